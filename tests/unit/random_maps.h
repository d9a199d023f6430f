/* Random depth maps for the tests of the stages that follow them, and what a voxel of them has to be.
 * Include after <cmocka.h>.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef RANDOM_MAPS_H
#define RANDOM_MAPS_H

#include <math.h>

#include "baker/base/random.h"
#include "baker/lab/opengl/depth_maps.h"

/* What a field of columns may look like: each kind is there for something that it may break. */
typedef enum map_kind {
    MAPS_EMPTY,  /* no caster at all */
    MAPS_DARK,   /* a sheet at depth 0: shadow everywhere */
    MAPS_NOISE,  /* every texel a depth of its own */
    MAPS_SHEETS, /* the same with x = e */
    MAPS_SLOPE,  /* a plane with some thickness: long chains of runs */
    MAPS_BOXES,  /* rectangles over one another and over nothing: what scenes look like */
    MAPS_ENDS,   /* depths 0 and 1 only */
    MAPS_INSIDE, /* e and x within one voxel: nothing but that voxel is free */
    MAPS_STEPS,  /* few depths, on voxel boundaries: ties */
    MAPS_CLIFF,  /* half of each tile far in front of the other: everything between is parted by one mask */
    MAPS_FACETS, /* slanted sheets that meet and end before one another, some steep: what meshes look like */
    MAP_KINDS
} map_kind;

/* Uniform in [0, 1), a multiple of 2^-24: exact in float. */
static inline float random_unit(rng *r)
{
    return (float)(rng_u32(r) >> 8) / 16777216.0f;
}

static inline void set_texel(depth_maps *d, size_t at, double enter, double exit)
{
    enter        = fmin(fmax(enter, 0), 1);
    d->exit[at]  = (float)fmin(fmax(exit, enter), 1);
    d->enter[at] = (float)enter;
    if (d->exit[at] < d->enter[at]) d->exit[at] = d->enter[at];
}

static inline void fill_boxes(depth_maps *d, rng *r)
{
    uint32_t side = d->side_px;
    for (size_t n = 0; n < (size_t)side * side; n++) set_texel(d, n, 1, 1);
    for (int box = 0; box < 12; box++) {
        uint32_t u0 = rng_below(r, side), v0 = rng_below(r, side);
        uint32_t u1 = u0 + 1 + rng_below(r, side - u0), v1 = v0 + 1 + rng_below(r, side - v0);
        double   e = random_unit(r), x = rng_below(r, 3) ? e + random_unit(r) * (1 - e) : e;
        for (uint32_t v = v0; v < v1; v++)
            for (uint32_t u = u0; u < u1; u++)
                if (e < d->enter[v * side + u]) set_texel(d, v * side + u, e, x);
    }
}

/* Of a sheet, e and x are the same; each is there for a rectangle. */
static inline void fill_facets(depth_maps *d, rng *r)
{
    uint32_t side = d->side_px;
    for (size_t n = 0; n < (size_t)side * side; n++) set_texel(d, n, 1, 1);
    for (int sheet = 0; sheet < 16; sheet++) {
        double steep = sheet % 4 ? 1 : 16, e = random_unit(r), a = (random_unit(r) - 0.5) * steep,
               b    = (random_unit(r) - 0.5) * steep;
        uint32_t u0 = rng_below(r, side), v0 = rng_below(r, side), u1 = u0 + side / 4, v1 = v0 + side / 2;
        for (uint32_t v = v0; v < v1 && v < side; v++)
            for (uint32_t u = u0; u < u1 && u < side; u++) {
                double at = e + (a * (u - u0) + b * (v - v0)) / side;
                if (at >= 0 && at < d->enter[v * side + u]) set_texel(d, v * side + u, at, at);
            }
    }
}

static inline void fill_maps(depth_maps *d, map_kind kind, rng *r)
{
    uint32_t side = d->side_px, depth = d->depth_vx;
    double   a = random_unit(r) - 0.5, b = random_unit(r) - 0.5, thick = random_unit(r) * 0.3;
    if (kind == MAPS_BOXES) {
        fill_boxes(d, r);
        return;
    }
    if (kind == MAPS_FACETS) {
        fill_facets(d, r);
        return;
    }
    for (size_t n = 0; n < (size_t)side * side; n++) {
        double   e = random_unit(r), more = random_unit(r);
        uint32_t u = (uint32_t)(n % side), v = (uint32_t)(n / side);
        double   slope = 0.5 + (a * u + b * v) / side, step = rng_below(r, 4) * 0.25;
        switch (kind) {
        case MAPS_EMPTY: set_texel(d, n, 1, 1); break;
        case MAPS_DARK: set_texel(d, n, 0, 0); break;
        case MAPS_NOISE: set_texel(d, n, e, e + more * (1 - e)); break;
        case MAPS_SHEETS: set_texel(d, n, e, e); break;
        case MAPS_SLOPE: set_texel(d, n, slope, slope + thick); break;
        case MAPS_ENDS: set_texel(d, n, e < 0.5 ? 0 : 1, more < 0.5 ? 0 : 1); break;
        case MAPS_INSIDE: set_texel(d, n, (floor(e * depth) + 0.25) / depth, (floor(e * depth) + 0.75) / depth); break;
        case MAPS_STEPS: set_texel(d, n, step, step + rng_below(r, 3) * 0.25); break;
        case MAPS_CLIFF: set_texel(d, n, u % 8 < 4 ? e / 64 : 1 - e / 64, u % 8 < 4 ? e / 32 : 1); break;
        default: assert_true(0);
        }
    }
}

/* The contract, on the depths as they are: 0 must be lit, 1 must be dark, -1 is free. */
static inline int wanted(const depth_maps *d, uint32_t i, uint32_t j, uint32_t k)
{
    double e = (double)d->enter[(size_t)j * d->side_px + i] * d->depth_vx;
    double x = (double)d->exit[(size_t)j * d->side_px + i] * d->depth_vx;
    return (double)k + 1 <= e ? 0 : (double)k >= x ? 1 : -1;
}

#endif
