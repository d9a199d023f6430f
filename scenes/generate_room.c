/* A furnished room, seen from inside.
 *
 *     +----------------------------------+     8 x 6 m, 3 m high. Walls, floor and ceiling are one open sheet that faces
 *     | corner        sofa               |     inward; all furniture is closed. Beyond the door are a floor and a wall
 *     |s            chair                |     that receive the light through it.
 *     |h      chair table chair  cabinet |
 *     |elf         lamp                  |     X to the right, Z down
 *     |             chair                |
 *     +--------------------+ door +------+
 *
 * Most triangles are those of books and of round objects: the shelf is filled first, then round objects get more segments.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "scenes/generate.h"

#include <math.h>
#include <stdlib.h>

#include "baker/base/random.h"
#include "scenes/generate_parts.h"

/* screen: a sky, red below and blue above, a sun, and hills in front ----------------------------------------------------------- */

enum { WIDE_PX = 96, HIGH_PX = 54 };

static const double half_wide = 0.82, half_high = 0.46, case_deep = 0.05, edge = 0.02, gap = 0.001;

static uint8_t *make_picture(void)
{
    static const double foot[3] = {255, 130, 50}, top[3] = {20, 70, 170}, sun[3] = {255, 244, 214}, hill[3] = {16, 12, 22};
    uint8_t            *rgba = malloc((size_t)4 * WIDE_PX * HIGH_PX);
    for (size_t n = 0; rgba && n < WIDE_PX * HIGH_PX; n++) {
        /* x, y: [0, 1] from the left, from the bottom */
        double x = ((double)(n % WIDE_PX) + 0.5) / WIDE_PX, y = 1 - ((double)(n / WIDE_PX) + 0.5) / HIGH_PX;
        double a = x - 0.25, b = x - 0.85, hills = 0.08 + 0.16 / (1 + 30 * a * a) + 0.24 / (1 + 40 * b * b);
        double across = (x - 0.55) * WIDE_PX / HIGH_PX, above = y - 0.42, square = across * across + above * above;
        double high = y * (2 - y), glow = 0.02 / (0.02 + square);
        for (size_t k = 0; k < 3; k++) {
            double sky      = foot[k] + high * (top[k] - foot[k]);
            double c        = y < hills ? hill[k] : square < 0.016 ? sun[k] : sky + 0.8 * glow * (sun[k] - sky);
            rgba[4 * n + k] = (uint8_t)(c + 0.5);
        }
        rgba[4 * n + 3] = 255;
    }
    return rgba;
}

/* A flat box on a wall that faces -X, in front of `wall_x`; in front of it a picture of a low sun, two triangles of an emissive
 * material.
 * middle  of the screen, metres: y, z */
static void generate_screen(parts *p, double wall_x, const double middle[2])
{
    double   front = wall_x - case_deep, y = middle[0], z = middle[1];
    uint32_t image    = parts_image(p, WIDE_PX, HIGH_PX, make_picture());
    uint32_t material = parts_material(p, (glb_material){.name = "screen", .image = image, .emission = 3});
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

/* room ------------------------------------------------------------------------------------------------------------------------- */

/* size of the room, metres; integers, so that the cells of 1 m of adjacent walls share corners */
static const double left = -4, right = 4, back = -3, front = 3, top = 3, door_left = 1, door_right = 2, door_top = 2;

enum { SHELF_LEVELS = 6, BOOKS_MAX = 360, ROUND_MAX = 8, ROUND_TRIANGLES = 200, SHADE_SEGMENTS = 24 };

static const double lamp_at[3] = {0, 2, 0};

/* ---- fixed parts ---- */

static void wall(parts *p, double x, double y, double z, const double u[3], const double v[3])
{
    uint32_t columns = (uint32_t)(fabs(u[0]) + fabs(u[1]) + fabs(u[2])), rows = (uint32_t)(fabs(v[0]) + fabs(v[1]) + fabs(v[2]));
    parts_grid(p, (double[3]){x, y, z}, u, v, columns, rows);
}

/* The front of each is u x v. */
static void add_shell(parts *p)
{
    const double along[3] = {right - left, 0, 0}, deep[3] = {0, 0, front - back}, up[3] = {0, top, 0};
    parts_mesh(p, "shell", 0);
    wall(p, left, 0, back, deep, along);
    wall(p, left, top, back, along, deep);
    wall(p, left, 0, back, up, deep);
    wall(p, right, 0, back, deep, up);
    wall(p, left, 0, back, along, up);
    wall(p, left, 0, front, up, (double[3]){door_left - left, 0, 0});
    wall(p, door_left, door_top, front, (double[3]){0, top - door_top, 0}, (double[3]){door_right - door_left, 0, 0});
    wall(p, door_right, 0, front, up, (double[3]){right - door_right, 0, 0});
}

/* ---- furniture ---- */

/* Each chair is at its side of the table, turned a little at random. */
static void add_chairs(parts *p, rng r)
{
    static const double at[4][2] = {{0, -0.85}, {1.2, 0.05}, {0.1, 0.9}, {-1.25, 0}};
    parts_mesh(p, "chairs", 0);
    for (uint32_t i = 0; i < 4; i++) {
        parts_frame f = {{at[i][0], 0, at[i][1]}, 1, 0};
        parts_turn((16 * (4 - i) + 62 + rng_below(&r, 5)) % 64, 64, &f.cosine, &f.sine);

        parts_box(p, f, (double[3]){-0.22, 0.43, -0.22}, (double[3]){0.22, 0.47, 0.22});
        parts_box(p, f, (double[3]){-0.22, 0.6, -0.22}, (double[3]){0.22, 0.95, -0.19});
        for (int leg = 0; leg < 4; leg++) {
            double x = leg & 1 ? 0.18 : -0.22, z = leg & 2 ? 0.18 : -0.22;
            parts_box(p, f, (double[3]){x, 0, z}, (double[3]){x + 0.04, leg & 2 ? 0.43 : 0.95, z + 0.04});
        }
    }
}

static double shelf_height(int level)
{
    return 0.06 + level * 0.4;
}

/* Upright, side by side: a level has room for 60 books of 6.5 cm. Some protrude more than others; none touches the next. */
static void add_books(parts *p, rng r, uint32_t count)
{
    parts_mesh(p, "books", 0);
    for (uint32_t i = 0; i < count; i++) {
        double z = -1.95 + i / SHELF_LEVELS * 0.065, y = shelf_height((int)(i % SHELF_LEVELS)) + 0.03;
        double thick = rng_between(&r, 20, 60) / 1000.0, tall = rng_between(&r, 18, 32) / 100.0;
        double deep = rng_between(&r, 12, 25) / 100.0;
        parts_box_at(p, NULL, -3.92, -3.92 + deep, y, y + tall, z, z + thick);
    }
}

/* ---- round things ---- */

typedef struct round_thing {
    double x, floor, z, radius, belly; /* belly 0: a ball; more: a vase that is wider below */
} round_thing;

/* Add about `triangles` triangles, in squares. Returns their number. */
static uint32_t add_round(parts *p, const round_thing *t, uint32_t triangles)
{
    uint32_t segments = (uint32_t)sqrt((double)triangles) / 4 * 4;
    if (segments < 4) segments = 4;
    uint32_t bands = (triangles + segments) / (2 * segments) + 1;
    if (bands < 2) bands = 2;

    const double at[3]  = {t->x, t->floor + t->radius, t->z};
    double(*profile)[2] = malloc((bands + 1) * sizeof *profile);
    if (!profile) return p->out_of_memory = 1, 0;
    for (uint32_t i = 0; i <= bands; i++) {
        double s = 1 - 2.0 * i / bands, out = (1 - s * s) / (1 + s * s), up = 2 * s / (1 + s * s);
        profile[i][0] = t->radius * out * (1 - t->belly * up * (1 - up * up));
        profile[i][1] = t->radius * up;
    }
    parts_lathe(p, at, (const double(*)[2])profile, bands + 1, segments);
    free(profile);
    return 2 * segments * (bands - 1);
}

static void add_round_things(parts *p, rng r, uint32_t triangles)
{
    static const round_thing things[ROUND_MAX] = {
        {2.4, 0, -1.4, 0.35, 0},      {0.4, 0.75, 0.1, 0.12, 0},  {3.65, 0.9, -1, 0.2, 0.5},  {-2.2, 0, 1.6, 0.25, 0},
        {-0.5, 0.75, -0.2, 0.1, 0.5}, {3.7, 0.9, 0.3, 0.15, 0.4}, {-1.2, 0.6, -2.5, 0.09, 0}, {3.6, 0.9, 1.1, 0.22, 0.6}};
    uint32_t count = triangles / ROUND_TRIANGLES;
    if (count < 1) count = 1;
    if (count > ROUND_MAX) count = ROUND_MAX;
    parts_mesh(p, "round things", 0);
    for (uint32_t i = 0; i < count; i++) {
        round_thing t = things[i];
        t.x += rng_between(&r, -30, 30) / 1000.0;
        t.z += rng_between(&r, -30, 30) / 1000.0;
        uint32_t made = add_round(p, &t, triangles / (count - i));
        triangles     = triangles > made ? triangles - made : 0;
    }
}

/* ---- the room ---- */

vxs_result generate_room(glb_scene *s, const room_options *o, run_context *m)
{
    parts    p     = parts_begin(s, "room");
    uint32_t cloth = parts_material(&p, (glb_material){.name = "cloth", .double_sided = 1});
    add_shell(&p);

    parts_box_at(&p, "hall", -2, 5, -0.25, 0, front, 6);
    parts_box_at(&p, NULL, -2, 5, -0.25, top, 6, 6.25);
    parts_mesh(&p, "door", 0);
    parts_frame hinge = {{door_right, 0, front + 0.03}, -0.6, -0.8}; /* the door is open */
    parts_box(&p, hinge, (double[3]){0, 0.01, 0}, (double[3]){0.95, door_top - 0.02, 0.04});

    const double shade[2][2] = {{0.12, 0.15}, {0.3, -0.1}};
    parts_mesh(&p, "lampshade", cloth);
    parts_lathe(&p, lamp_at, shade, 2, SHADE_SEGMENTS);
    parts_box_at(&p, "cord", -0.005, 0.005, lamp_at[1] + 0.06, top + 0.02, -0.005, 0.005);

    parts_box_at(&p, "table", -0.9, 0.9, 0.71, 0.75, -0.5, 0.5);
    for (int leg = 0; leg < 4; leg++) {
        double x = leg & 1 ? 0.8 : -0.86, z = leg & 2 ? 0.4 : -0.46;
        parts_box_at(&p, NULL, x, x + 0.06, 0, 0.71, z, z + 0.06);
    }

    add_chairs(&p, rng_split(o->seed, 1));

    parts_box_at(&p, "sofa", -1.1, 1.1, 0.08, 0.42, -2.9, -2.0);
    parts_box_at(&p, NULL, -1.1, 1.1, 0.40, 0.85, -2.95, -2.7);
    parts_box_at(&p, NULL, -1.3, -1.08, 0, 0.6, -2.95, -2.0);
    parts_box_at(&p, NULL, 1.08, 1.3, 0, 0.6, -2.95, -2.0);
    parts_box_at(&p, "cabinet", 3.4, 3.95, 0, 0.9, -1.5, 1.5);
    parts_box_at(&p, "picture", -1, 1, 1.2, 2.2, -2.99, -2.96);

    parts_box_at(&p, "shelf", -3.95, -3.6, 0, 2.1, -2, -1.97);
    parts_box_at(&p, NULL, -3.95, -3.6, 0, 2.1, 1.97, 2);
    for (int level = 0; level < SHELF_LEVELS; level++)
        parts_box_at(&p, NULL, -3.95, -3.6, shelf_height(level), shelf_height(level) + 0.03, -1.97, 1.97);
    if (o->screen) generate_screen(&p, right - 0.05, (double[2]){1.45, 0});

    uint32_t rest = o->triangles > s->triangle_count ? o->triangles - (uint32_t)s->triangle_count : 0, books = rest / 2 / 12;
    if (books > BOOKS_MAX) books = BOOKS_MAX;
    add_books(&p, rng_split(o->seed, 2), books);
    add_round_things(&p, rng_split(o->seed, 3), rest - 12 * books);
    parts_point(&p, "lamp", lamp_at, 12);
    parts_spot(&p, "corner", (double[3]){-3.7, 2.7, -2.7}, (double[3]){1.5 - -3.7, 0.2 - 2.7, 1 - -2.7}, 35, 12);
    return parts_end(&p, m);
}
