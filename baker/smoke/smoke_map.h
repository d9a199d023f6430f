/* What smoke leaves of one light: its map of curves, in the space of the light's maps.
 *
 * A curve is as long as light may still be asked for within a texel about its own: to where the last of the light's texels there
 * ends, since a lookup weighs four curves, and each of them has to know all that lies before the place.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SMOKE_MAP_H
#define SMOKE_MAP_H

#include "baker/base/context.h"
#include "baker/smoke/smoke_capsules.h"
#include "baker/smoke/smoke_grid.h"
#include "formats/vxs_file.h"

/* What smoke there is. */
typedef struct smoke_source {
    const smoke_grid  *grid;     /* NULL: none */
    const scene_smoke *capsules; /* NULL: none */
} smoke_source;

/* How smoke is baked. */
typedef struct smoke_settings {
    uint32_t side_px; /* curves along a side of a map: a power of two, 8 or more, of which the light's texels are the most; 0: as
                         close as samples of the grid lie, 64 to 1024, or 256 without a grid */
    uint32_t nodes;   /* of a curve, at most: 4 to VXS_SMOKE_NODES_MAX */
    double   error;   /* of transmittance: a curve has no more nodes than it needs for this; 0 to 1 */
} smoke_settings;

/* How far lookups, which weigh the curves of four rays, are from the integral along the ray to the place itself: measured at random
 * places within half a texel of a curve that the light reaches, half of them in the smoke, half where light or smoke ends. */
typedef struct smoke_lookups {
    uint32_t places; /* 1000, or fewer where light does not reach them */
    double   rms, largest;
} smoke_lookups;

/* Zero it; released with smoke_map_free. */
typedef struct smoke_map {
    vxs_smoke_view view; /* of what is owned below; counts NULL: the smoke loses none of the light */
    uint8_t       *counts;
    uint32_t      *nodes;
    size_t         texel_count, curve_count, node_count;
    size_t         word_count;    /* in memory (formats/vxs.md section 15) */
    double         largest_error; /* of a curve, before a lookup weighs it */
    smoke_lookups  lookups;
} smoke_map;

/* Accepts a zeroed object. */
void smoke_map_free(smoke_map *map);

/* baked  a light with its words: where they end the light, its curves end
 * map    [out]
 * Returns VXS_OK, VXS_E_MEMORY, or what context_check returns. The same at any number of threads. */
vxs_result smoke_map_make(smoke_map *map, const smoke_source *source, const vxs_baked_light *baked, const smoke_settings *settings,
                          bake_context *ctx);

#endif
