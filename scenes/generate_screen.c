/* A screen and its picture: a sky, red below and blue above, a sun, and hills in front.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "scenes/generate_screen.h"

#include <stdlib.h>

enum { WIDE_PX = 96, HIGH_PX = 54 };

static const double half_wide = 0.82, half_high = 0.46, deep = 0.05, edge = 0.02, gap = 0.001;

/* Height of hills, [0, 1] from the bottom, at a place [0, 1] from the left. */
static double hills(double x)
{
    double a = x - 0.25, b = x - 0.85;
    return 0.08 + 0.16 / (1 + 30 * a * a) + 0.24 / (1 + 40 * b * b);
}

/* x, y  [0, 1] from the left, from the bottom */
static void colour_at(double x, double y, uint8_t rgba[4])
{
    static const double foot[3] = {255, 130, 50}, top[3] = {20, 70, 170}, sun[3] = {255, 244, 214}, hill[3] = {16, 12, 22};
    double              across = (x - 0.55) * WIDE_PX / HIGH_PX, above = y - 0.42, square = across * across + above * above;
    double              high = y * (2 - y), glow = 0.02 / (0.02 + square);
    for (int n = 0; n < 3; n++) {
        double sky = foot[n] + high * (top[n] - foot[n]);
        double c   = y < hills(x) ? hill[n] : square < 0.016 ? sun[n] : sky + 0.8 * glow * (sun[n] - sky);
        rgba[n]    = (uint8_t)(c + 0.5);
    }
    rgba[3] = 255;
}

static uint8_t *make_picture(void)
{
    uint8_t *rgba = malloc((size_t)4 * WIDE_PX * HIGH_PX);
    for (size_t n = 0; rgba && n < WIDE_PX * HIGH_PX; n++)
        colour_at(((double)(n % WIDE_PX) + 0.5) / WIDE_PX, 1 - ((double)(n / WIDE_PX) + 0.5) / HIGH_PX, rgba + 4 * n);
    return rgba;
}

void generate_screen(parts *p, double wall_x, const double middle[2])
{
    double   front = wall_x - deep, y = middle[0], z = middle[1];
    uint32_t image    = parts_image(p, WIDE_PX, HIGH_PX, make_picture());
    uint32_t material = parts_material(p, (glb_material){.name = "screen", .image = image, .shines = 3});
    uint32_t corner[4];
    parts_box_at(p, "screen's case", front, wall_x, y - half_high - edge, y + half_high + edge, z - half_wide - edge,
                 z + half_wide + edge);
    parts_mesh(p, "screen", material);
    for (int n = 0; n < 4; n++) { /* in order, as seen from the front, where +Z is to the right */
        double u = n == 1 || n == 2, v = n < 2;
        corner[n] = parts_vertex_uv(p, (double[3]){front - gap, y + half_high * (1 - 2 * v), z + half_wide * (2 * u - 1)}, u, v);
    }
    parts_triangle(p, corner[0], corner[1], corner[2]);
    parts_triangle(p, corner[0], corner[2], corner[3]);
}
