/* Transmittance of smoke for one light: a map of curves over depth, in the space of the light's maps.
 *
 * A curve ends where the last lit texel within one curve texel around it ends, because a lookup interpolates four curves, and each
 * of them must cover the whole way to the point.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SMOKE_MAP_H
#define SMOKE_MAP_H

#include "baker/base/context.h"
#include "baker/smoke/smoke_capsules.h"
#include "baker/smoke/smoke_grid.h"
#include "formats/vxs_file.h"

/* Sources of smoke. */
typedef struct smoke_source {
    const smoke_grid  *grid;     /* NULL: none */
    const scene_smoke *capsules; /* NULL: none */
} smoke_source;

/* How smoke is baked. */
typedef struct smoke_settings {
    uint32_t side_px; /* curves along a side of a map: a power of two, from 8 to the side in texels; 0: the spacing of the grid's
                         samples, 64 to 1024, or 256 without a grid */
    uint32_t nodes;   /* most nodes of a curve: 4 to VXS_SMOKE_NODES_MAX */
    double   error;   /* permitted error of transmittance, 0 to 1: a curve gets no more nodes than it needs for this */
} smoke_settings;

/* Error of lookups, which interpolate the curves of four rays, against the integral along the ray to the point itself. Measured at
 * random lit points within half a texel of a curve, half of them in the smoke, half where light or smoke ends. */
typedef struct smoke_lookups {
    uint32_t places; /* 1000, or fewer if light does not reach them */
    double   rms, largest;
} smoke_lookups;

/* Zero it; released with smoke_map_free. */
typedef struct smoke_map {
    vxs_smoke_view view; /* of the arrays below; counts NULL: the light loses nothing in smoke */
    uint8_t       *counts;
    uint32_t      *nodes;
    size_t         texel_count, curve_count, node_count;
    size_t         word_count;    /* size in memory (formats/vxs.md section 15) */
    double         largest_error; /* of a curve, without interpolation */
    smoke_lookups  lookups;
} smoke_map;

/* Accepts a zeroed object. */
void smoke_map_free(smoke_map *map);

/* Make the map of a light.
 * baked  a light with its words: each curve ends where they end the light
 * map    [out]
 * Returns VXS_OK, VXS_E_MEMORY, or what context_check returns. The result does not depend on the number of threads. */
vxs_result smoke_map_make(smoke_map *map, const smoke_source *source, const vxs_baked_light *baked, const smoke_settings *settings,
                          bake_context *ctx);

#endif
