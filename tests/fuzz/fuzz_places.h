/* Places in and about a light that fuzzers look up, by chance that a number decides; and what rays may be held against there.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef FUZZ_PLACES_H
#define FUZZ_PLACES_H

#include <float.h>
#include <math.h>

#include "runtime/vxs_query.h"

static inline uint64_t next_random(uint64_t *state)
{
    uint64_t x = *state += 0x9e3779b97f4a7c15u;
    x          = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x          = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return x ^ (x >> 31);
}

/* A number below another, which is not 0. */
static inline uint32_t random_below_of(uint64_t *state, uint32_t end)
{
    return (uint32_t)((next_random(state) >> 32) * end >> 32);
}

/* Where the light's matrix takes a point to `ls`; it may be far away, or not finite. */
static inline void unproject(const double *m, const double ls[3], double ws[3])
{
    double b[3] = {ls[0] - m[3], ls[1] - m[7], ls[2] - m[11]};
    double det  = m[0] * (m[5] * m[10] - m[6] * m[9]) - m[1] * (m[4] * m[10] - m[6] * m[8]) + m[2] * (m[4] * m[9] - m[5] * m[8]);
    for (int c = 0; c < 3; c++) {
        double a[9] = {m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10]};
        for (int row = 0; row < 3; row++) a[3 * row + c] = b[row];
        ws[c] =
            (a[0] * (a[4] * a[8] - a[5] * a[7]) - a[1] * (a[3] * a[8] - a[5] * a[6]) + a[2] * (a[3] * a[7] - a[4] * a[6])) / det;
    }
}

/* Borders of a map of `side` voxels first, then anywhere in it and around it. */
static inline double coordinate(uint64_t *random, double side)
{
    const double border[] = {0, nextafter(0, -1), side, nextafter(side, 0), side - 0.5, side / 2, -1, side + 1, 0.5, 8};
    uint64_t     choice   = next_random(random) % 24;
    if (choice < sizeof border / sizeof *border) return border[choice];
    return ((double)(next_random(random) >> 11) * 0x1p-53 * 1.25 - 0.125) * side;
}

/* What ls_from_ws should make of a point: texels and voxels, or metres about a light that has a place. */
static inline void point_ls(const vxs_light *l, uint64_t *random, double ls[3])
{
    double side = (double)(1u << l->levels);
    for (int axis = 0; axis < 3; axis++) ls[axis] = coordinate(random, side);
    if (l->kind == VXS_LIGHT_KIND_DIRECTIONAL) return;
    double z    = l->near_metres * exp((ls[2] + 0.5) * l->voxel_metres);
    double p[3] = {(ls[0] - side / 2) * l->texel_metres * z, (ls[1] - side / 2) * l->texel_metres * z, z};
    int    turn = (int)(next_random(random) % 6); /* the map's axis is any of the cube's */
    for (int axis = 0; axis < 3; axis++) ls[axis] = p[(axis + turn) % 3] * (turn < 3 ? 1 : -1);
}

/* A point to look up: mostly about the map, at times anywhere that a double can name. Never NaN or infinite. */
static inline void point_ws(const vxs_light *l, uint64_t *random, double ws[3])
{
    static const double far[] = {0, 1, -1, 1e-300, 1e9, -1e9, 1e38, -1e38, DBL_MAX, -DBL_MAX, DBL_MIN};
    double              ls[3];
    point_ls(l, random, ls);
    unproject(l->ls_from_ws, ls, ws);
    int anywhere = next_random(random) % 16 == 0;
    for (int axis = 0; axis < 3; axis++)
        if (anywhere || !isfinite(ws[axis])) ws[axis] = far[next_random(random) % (sizeof far / sizeof *far)];
}

/* How finely a walk along a ray sums up: relative to what it sums up, and how wide about a point of a punctual light, relative to
 * how far it is, its state is to be one to be held against it. */
typedef struct walk_precision {
    double sum, wide;
} walk_precision;

static const walk_precision in_doubles = {1e-13, 1e-7}, in_floats = {2e-6, 1e-4};

static inline int32_t state_at(const vxs_baked_light *l, const double point[3])
{
    float lit = vxs_lookup(l, point, NULL, vxs_box(1));
    return lit == VXS_OUTSIDE ? VXS_INTERVAL_OUTSIDE : lit == 1 ? VXS_INTERVAL_LIT : VXS_INTERVAL_SHADOW;
}

/* The state in the middle of a part of a ray by single lookups, where it is the same all about, as far as rounding may lead, and
 * the part is longer than that; else -1. */
static inline int32_t clear_state(const vxs_baked_light *baked, const vxs_ray *r, double begin, double end,
                                  walk_precision precision)
{
    const vxs_light *l = &baked->light;
    double           t = isfinite(end) ? 0.5 * begin + 0.5 * end : begin + 1, most_t = isfinite(end) ? end : t;
    double           point[3], ls[3], most = 0, away = 0, speed = 0, far;
    for (int k = 0; k < 3; k++) point[k] = r->origin_ws[k] + t * r->direction_ws[k];
    for (int row = 0; row < 3; row++) {
        const double *m = l->ls_from_ws + 4 * row, *o = r->origin_ws, *d = r->direction_ws;
        ls[row] = m[0] * point[0] + m[1] * point[1] + m[2] * point[2] + m[3];
        away    = fmax(away, fabs(ls[row]));
        speed   = fmax(speed, fabs(m[0] * d[0] + m[1] * d[1] + m[2] * d[2]));
        for (int k = 0; k < 4; k++) most = fmax(most, fabs(m[k]) * (k < 3 ? fabs(o[k]) + most_t * fabs(d[k]) : 1));
    }
    far = l->kind == VXS_LIGHT_KIND_DIRECTIONAL ? 0.05 : precision.wide * away;
    if (l->kind != VXS_LIGHT_KIND_DIRECTIONAL && fmin(l->texel_metres, l->voxel_metres) < precision.wide) return -1;
    /* In texels so wide, `far` is less than the rounding of a coordinate. */
    if (l->kind != VXS_LIGHT_KIND_DIRECTIONAL && precision.wide < precision.sum * (1u << l->levels) * l->texel_metres) return -1;
    if (!(far > precision.sum * most) || far > 1e100 || !((end - begin) * speed > far)) return -1;
    int32_t state = state_at(baked, point);
    for (int corner = 0; corner < 8; corner++) {
        double moved[3];
        for (int k = 0; k < 3; k++) moved[k] = ls[k] + (corner >> k & 1 ? far : -far);
        unproject(l->ls_from_ws, moved, point);
        if (!isfinite(point[0] + point[1] + point[2]) || state_at(baked, point) != state) return -1;
    }
    return state;
}

#endif
