/* Points of triangles; see vxs_area_light.h.
 * SPDX-License-Identifier: MIT */
#include <math.h>
#include <string.h>

#include "vxs_area_light.h"

static double area_of(const float *a, const float *b, const float *c)
{
    double square = 0;
    for (int n = 0; n < 3; n++) {
        int    i = (n + 1) % 3, j = (n + 2) % 3;
        double across = ((double)b[i] - (double)a[i]) * ((double)c[j] - (double)a[j]) -
                        ((double)b[j] - (double)a[j]) * ((double)c[i] - (double)a[i]);
        square += across * across;
    }
    return 0.5 * sqrt(square);
}

static double area_of_corners(const float *positions, const uint32_t *corner)
{
    return area_of(positions + 3 * (size_t)corner[0], positions + 3 * (size_t)corner[1], positions + 3 * (size_t)corner[2]);
}

/* The corner that the longest side begins at: cut in its middle, parts of a triangle do not get thin. */
static int longest_side(const float *positions, const uint32_t *corner)
{
    double most = -1;
    int    side = 0;
    for (int n = 0; n < 3; n++) {
        const float *from = positions + 3 * (size_t)corner[n], *to = positions + 3 * (size_t)corner[(n + 1) % 3];
        double       square = 0;
        for (int i = 0; i < 3; i++) square += ((double)to[i] - (double)from[i]) * ((double)to[i] - (double)from[i]);
        if (!(square > most)) continue;
        most = square;
        side = n;
    }
    return side;
}

/* The place t, [0, 1), of Sierpinski's curve through a triangle: equal parts of it are in equal parts of the area, each in one piece. So places that are
 * evenly spaced along it are so on the triangle, and any few that follow each other are neighbours. */
static vxs_area_point point_on(const float *positions, const uint32_t *corner, double t, double area)
{
    enum { HALVINGS = 26, BEGIN = 0, END = 1, BESIDE = 2 }; /* as a float has it; corners of what is left */
    double         at[3][2] = {{0, 0}, {1, 0}, {0, 1}};
    vxs_area_point point    = {.square_metres = (float)area};
    for (int n = 0; n < HALVINGS; n++) {
        double middle[2] = {0.5 * (at[BEGIN][0] + at[END][0]), 0.5 * (at[BEGIN][1] + at[END][1])};
        int    is_behind = t >= 0.5;
        memcpy(at[is_behind ? BEGIN : END], at[BESIDE], sizeof *at);
        memcpy(at[BESIDE], middle, sizeof *at);
        t = 2 * t - is_behind;
    }
    for (int i = 0; i < 3; i++) {
        double a = (double)positions[3 * (size_t)corner[0] + i], b = (double)positions[3 * (size_t)corner[1] + i],
               c       = (double)positions[3 * (size_t)corner[2] + i];
        point.place[i] = (float)(a + at[BEGIN][0] * (b - a) + at[BEGIN][1] * (c - a));
    }
    return point;
}

double vxs_area_scatter(const float *positions, const uint32_t *corners, uint32_t triangle_count, vxs_area_point *points,
                        uint32_t count)
{
    double   all = 0, before = 0;
    uint32_t n = 0;
    for (uint32_t t = 0; t < triangle_count; t++) all += area_of_corners(positions, corners + 3 * (size_t)t);
    if (!(all > 0) || !isfinite(all)) return 0;
    for (uint32_t t = 0; t < triangle_count; t++) {
        const uint32_t *given     = corners + 3 * (size_t)t;
        int             first     = longest_side(positions, given);
        const uint32_t  corner[3] = {given[first], given[(first + 1) % 3], given[(first + 2) % 3]};
        double          here      = area_of_corners(positions, corner);
        for (; n < count && (n + 0.5) * all < (before + here) * count; n++)
            points[n] = point_on(positions, corner, ((n + 0.5) * all / count - before) / here, all / count);
        before += here;
    }
    return all;
}
