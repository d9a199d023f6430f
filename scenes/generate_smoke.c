/* Scenes with smoke and hair that cast shadows: points and lines with radius and extinction, and surfaces that receive the
 * shadows.
 *
 *     smoke   a yard between two houses, a low sun through three columns      hair   a head with strands on a table between
 *             lamps, that rise from barrels, widen and thin, and a street lamp              and a thread of smoke beside it
 *
 * A column consists of billows: balls that rise, lean with the wind and grow. A billow consists of puffs. The density of a puff
 * depends on their number, so that a column's density does not.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "scenes/generate.h"

#include <math.h>
#include <stdlib.h>

#include "baker/base/random.h"
#include "scenes/generate_parts.h"

static double between(rng *r, double low, double high)
{
    return low + (high - low) * rng_unit(r);
}

/* An approximate sine by parabolas: 0 at 0, 1 at a quarter, 0 at a half. */
static double wave(double turns)
{
    double y = turns - (double)(int64_t)turns;
    return y < 0.5 ? 16 * y * (0.5 - y) : -16 * (y - 0.5) * (1 - y);
}

/* A random point in the unit ball, uniform by volume. */
static void in_ball(rng *r, double place[3])
{
    double square;
    do {
        square = 0;
        for (int n = 0; n < 3; n++) {
            place[n] = between(r, -1, 1);
            square += place[n] * place[n];
        }
    } while (square > 1);
}

static void scale_to(double v[3], double length)
{
    double has = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    for (int n = 0; n < 3; n++) v[n] *= length / has;
}

/* receivers of shadows --------------------------------------------------------------------------------------------------------- */

static uint32_t paint(parts *p, const char *name, double red, double green, double blue)
{
    return parts_material(p, (glb_material){.name = name, .colour = {red, green, blue}});
}

/* The light that was added last. */
static void set_emission(const parts *p, double red, double green, double blue)
{
    if (p->out_of_memory) return;
    double *colour = p->s->lights[p->s->light_count - 1].colour;
    colour[0]      = red;
    colour[1]      = green;
    colour[2]      = blue;
}

static void add_camera(parts *p, double x, double y, double z)
{
    double *at = malloc(3 * sizeof *at);
    if (!at) {
        p->out_of_memory = 1;
        return;
    }
    at[0] = x, at[1] = y, at[2] = z;
    p->s->camera_positions_ws = at;
    p->s->camera_count        = 1;
}

/* smoke ------------------------------------------------------------------------------------------------------------------------ */

typedef struct column {
    const char *name;
    double      foot[3], tall, narrow, wide; /* metres; half the width at its bottom and its top */
    double      lean[2];                     /* metres along x and z, at its top */
    double      depth;                       /* optical depth across it at its bottom; it decreases to a third */
    double      colour[3];
} column;

typedef struct billow {
    double at[3], radius, rise;
} billow;

/* Billow n of `count`, from the foot up. */
static billow billow_of(const column *c, rng *r, uint32_t n, uint32_t count)
{
    double rise = (n + rng_unit(r)) / count, half = c->narrow + (c->wide - c->narrow) * sqrt(rise), aside[3];
    in_ball(r, aside);
    billow b = {.radius = half * between(r, 0.45, 0.75), .rise = rise};
    for (int axis = 0; axis < 3; axis++) b.at[axis] = c->foot[axis] + aside[axis] * (half - 0.6 * b.radius);
    b.at[0] += c->lean[0] * rise * rise + 0.5 * half * wave(1.7 * rise + 0.3);
    b.at[1] += c->tall * rise + b.radius;
    b.at[2] += c->lean[1] * rise * rise + 0.5 * half * wave(1.3 * rise);
    return b;
}

static void add_column(parts *p, const column *c, rng r, uint32_t puffs)
{
    enum { PUFFS_EACH = 24 };
    uint32_t billows = (puffs + PUFFS_EACH - 1) / PUFFS_EACH, made = 0;
    if (!puffs) return;
    parts_smoke(p, c->name, 0, paint(p, c->name, c->colour[0], c->colour[1], c->colour[2]));
    for (uint32_t n = 0; n < billows; n++) {
        billow b = billow_of(c, &r, n, billows);
        for (; made < (uint64_t)puffs * (n + 1) / billows; made++) {
            /* all puffs of a column together take as much light as its depth times its width and height */
            double at[3], radius = b.radius * between(&r, 0.3, 0.6), volume = 4.19 * radius * radius * radius;
            double half = c->narrow + (c->wide - c->narrow) * sqrt(b.rise), depth = c->depth * (1 - 0.67 * b.rise);
            in_ball(&r, at);
            for (int axis = 0; axis < 3; axis++) at[axis] = b.at[axis] + at[axis] * (b.radius - 0.5 * radius);
            if (at[1] < radius) at[1] = radius;
            parts_smoke_vertex(p, at, radius, depth * 2 * half * c->tall / (puffs * volume));
        }
    }
}

/* the yard --------------------------------------------------------------------------------------------------------------------- */

static const column yard[3] = {
    {"white smoke", {-4.4, 0.9, -3.4}, 9.5, 0.35, 2.1, {-2.2, -0.5}, 2.4, {0.92, 0.92, 0.93}},
    {"grey smoke", {0.4, 0.9, 0.6}, 7, 0.3, 1.7, {-2.0, -0.8}, 2.0, {0.74, 0.76, 0.80}},
    {"brown smoke", {5.2, 0.9, -3.8}, 9, 0.35, 1.9, {-1.6, -0.6}, 2.6, {0.80, 0.68, 0.55}},
};

static void add_houses(parts *p, uint32_t stone, uint32_t plaster)
{
    parts_mesh(p, "ground", stone);
    parts_box_at(p, NULL, -22, 22, -0.5, 0, -16, 22);
    parts_mesh(p, "house behind", plaster);
    parts_box_at(p, NULL, -14, 8.5, -0.2, 7.2, -14, -8);
    parts_box_at(p, NULL, -14.2, 8.7, 7.2, 7.5, -14.2, -7.8);
    parts_mesh(p, "house beside", plaster);
    parts_box_at(p, NULL, -16, -10, -0.2, 5.4, -8.4, 9);
    parts_box_at(p, NULL, -16.2, -9.8, 5.4, 5.7, -8.4, 9.2);
    parts_mesh(p, "windows", stone);

    double x0 = -9.2;
    double z  = -8;
    for (int n = 0; n < 8; n++) {
        double x = x0 + n % 4 * 3.4, y = 1.4 + n / 4 * 2.9;
        parts_box_at(p, NULL, x - 0.1, x + 1.5, y - 0.12, y, z - 0.05, z + 0.16);
        parts_box_at(p, NULL, x - 0.06, x + 1.46, y + 1.6, y + 1.72, z - 0.05, z + 0.12);
        parts_box_at(p, NULL, x + 0.66, x + 0.74, y, y + 1.6, z - 0.05, z + 0.05);
    }
}

vxs_result generate_smoke(glb_scene *s, const smoke_options *o, run_context *m)
{
    parts    p     = parts_begin(s, "smoke");
    uint32_t stone = paint(&p, "stone", 0.42, 0.40, 0.38), plaster = paint(&p, "plaster", 0.66, 0.60, 0.52);
    uint32_t wood = paint(&p, "wood", 0.42, 0.29, 0.17), iron = paint(&p, "iron", 0.16, 0.16, 0.17);
    add_houses(&p, stone, plaster);

    rng                 r        = rng_split(o->seed, 1);
    static const double at[7][4] = {{-7.6, -6.2, 1.3, 0}, {-6.1, -6.6, 1.0, 0}, {-7.3, -6.3, 0.9, 1.3}, {7.2, -5.8, 1.4, 0},
                                    {7.0, -4.2, 1.0, 0},  {-8.2, 3.6, 1.2, 0},  {3.3, 3.4, 0.8, 0}};
    parts_mesh(&p, "crates", wood);
    for (int n = 0; n < 7; n++) {
        parts_frame f    = {{at[n][0], at[n][3], at[n][1]}, 1, 0};
        double      half = 0.5 * at[n][2];
        parts_turn(rng_below(&r, 64), 64, &f.cosine, &f.sine);
        parts_box(&p, f, (double[3]){-half, 0, -half}, (double[3]){half, at[n][2], half});
    }

    static const double barrel[6][2] = {{0, 0.85}, {0.24, 0.85}, {0.27, 0.9}, {0.33, 0.45}, {0.28, 0}, {0, 0}};
    parts_mesh(&p, "barrels", iron);
    for (int n = 0; n < 3; n++) parts_lathe(&p, (double[3]){yard[n].foot[0], 0, yard[n].foot[2]}, barrel, 6, 24);
    parts_sun(&p, (double[3]){-0.82, -0.42, -0.36});
    set_emission(&p, 1, 0.90, 0.76);

    const double x = 3.4, z = 1.1, out = 1.3;
    parts_mesh(&p, "street lamp", iron);
    parts_tube(&p, (double[3]){x, -0.1, z}, 0.09, (double[3]){x, 5, z}, 0.06, 12);
    parts_box_at(&p, NULL, x - out, x + 0.06, 4.9, 4.98, z - 0.04, z + 0.04);
    parts_box_at(&p, NULL, x - out - 0.16, x - out + 0.16, 4.78, 4.9, z - 0.14, z + 0.14);
    parts_spot(&p, "street lamp", (double[3]){x - out, 4.7, z}, (double[3]){-0.45, -1, -0.12}, 40, 12);
    set_emission(&p, 22, 16, 9);

    add_camera(&p, 2.5, 1.9, 14);
    for (uint32_t n = 0; n < 3; n++)
        add_column(&p, &yard[n], rng_split(o->seed, 2 + n),
                   (uint32_t)((uint64_t)o->capsules * (n + 1) / 3 - (uint64_t)o->capsules * n / 3));
    return parts_end(&p, m);
}

/* hair ------------------------------------------------------------------------------------------------------------------------- */

enum { STRAND_PIECES = 8 };

static const double head_at[3] = {-0.12, 1.13, 0}, head_radius = 0.12;

/* A chain of lines that leaves the head, falls and curls. */
static void add_strand(parts *p, rng r, uint32_t pieces)
{
    const double radius = 0.0008, extinction = between(&r, 250, 600), length = between(&r, 0.24, 0.36) / STRAND_PIECES;
    double       way[3], at[3], next[3], curl = rng_unit(&r), turn = between(&r, 0.5, 1.5);

    /* a strand grows neither on the face, towards +Z, nor below */
    do {
        in_ball(&r, way);
        scale_to(way, 1);
    } while (way[1] < -0.35 || (way[2] > 0.35 && way[1] < 0.55));

    for (int n = 0; n < 3; n++) at[n] = head_at[n] + head_radius * way[n];
    for (uint32_t piece = 0; piece < pieces; piece++) {
        way[0] += 0.25 * wave(curl + turn * piece / STRAND_PIECES);
        way[2] += 0.25 * wave(curl + turn * piece / STRAND_PIECES + 0.25);
        way[1] -= 0.8;
        scale_to(way, 1);

        double from[3], square = 0, least = 1.03 * head_radius;
        for (int n = 0; n < 3; n++) {
            next[n] = at[n] + length * way[n];
            from[n] = next[n] - head_at[n];
            square += from[n] * from[n];
        }
        if (square < least * least) { /* out of the head, only to its surface */
            scale_to(from, least);
            for (int n = 0; n < 3; n++) next[n] = head_at[n] + from[n];
        }
        parts_smoke_vertex(p, at, radius, extinction);
        parts_smoke_vertex(p, next, radius, extinction);
        for (int n = 0; n < 3; n++) at[n] = next[n];
    }
}

static void add_head(parts *p, uint32_t skin)
{
    enum { BANDS = 24 };
    double profile[BANDS + 1][2];
    for (int n = 0; n <= BANDS; n++) {
        double s      = 1 - 2.0 * n / BANDS;
        profile[n][0] = head_radius * (1 - s * s) / (1 + s * s);
        profile[n][1] = head_radius * 2 * s / (1 + s * s);
    }
    parts_mesh(p, "head", skin);
    parts_lathe(p, head_at, (const double(*)[2])profile, BANDS + 1, 48);
    parts_tube(p, (double[3]){head_at[0], 0.86, head_at[2] - 0.01}, 0.06, (double[3]){head_at[0], 1.05, head_at[2] - 0.01}, 0.052,
               24);
    parts_tube(p, (double[3]){head_at[0], 0.75, head_at[2]}, 0.15, (double[3]){head_at[0], 0.87, head_at[2]}, 0.07, 24);
}

vxs_result generate_hair(glb_scene *s, const smoke_options *o, run_context *m)
{
    static const column thread = {"smoke", {0.36, 0.77, -0.05}, 0.75, 0.012, 0.13, {-0.16, 0.03}, 1.4, {0.9, 0.9, 0.92}};
    parts               p      = parts_begin(s, "hair");
    uint32_t            wood = paint(&p, "wood", 0.46, 0.33, 0.22), wall = paint(&p, "wall", 0.60, 0.60, 0.58),
             iron = paint(&p, "iron", 0.2, 0.2, 0.2);

    static const double bowl[7][2] = {{0, 0.012}, {0.035, 0.012}, {0.05, 0.045}, {0.056, 0.045}, {0.045, 0.004}, {0.03, 0}, {0, 0}};
    parts_mesh(&p, "wall", wall);
    parts_box_at(&p, NULL, -2.5, 2.5, -0.1, 0, -1.2, 3);
    parts_box_at(&p, NULL, -2.5, 2.5, -0.1, 2.6, -1.4, -1.15);
    parts_mesh(&p, "table", wood);
    parts_box_at(&p, NULL, -0.8, 0.8, 0.71, 0.75, -0.45, 0.45);
    for (int leg = 0; leg < 4; leg++) {
        double x = leg & 1 ? 0.7 : -0.76, z = leg & 2 ? 0.36 : -0.42;
        parts_box_at(&p, NULL, x, x + 0.06, -0.02, 0.715, z, z + 0.06);
    }
    parts_mesh(&p, "bowl", iron);
    parts_lathe(&p, (double[3]){0.36, 0.75, -0.05}, bowl, 7, 32);

    add_head(&p, paint(&p, "skin", 0.66, 0.49, 0.40));
    parts_spot(&p, "lamp", (double[3]){0.75, 1.9, 0.75}, (double[3]){-0.72, -0.84, -0.75}, 30, 6);
    set_emission(&p, 1, 0.88, 0.72);
    parts_spot(&p, "behind", (double[3]){-0.9, 1.75, -0.85}, (double[3]){0.85, -0.62, 0.85}, 32, 6);
    set_emission(&p, 0.55, 0.68, 0.9);
    add_camera(&p, 0.15, 1.25, 1.9);
    uint32_t puffs = o->capsules / 4, pieces = o->capsules - puffs;
    if (pieces) parts_smoke(&p, "hair", 1, paint(&p, "hair", 0.62, 0.40, 0.22));
    for (uint32_t strand = 0; strand * STRAND_PIECES < pieces; strand++) {
        uint32_t rest = pieces - strand * STRAND_PIECES;
        add_strand(&p, rng_split(o->seed, 100 + strand), rest < STRAND_PIECES ? rest : STRAND_PIECES);
    }
    add_column(&p, &thread, rng_split(o->seed, 2), puffs);
    return parts_end(&p, m);
}
