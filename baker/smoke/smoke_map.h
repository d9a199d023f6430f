/* Transmittance of smoke for one light: a map of curves over depth, in the space of the light's maps.
 *
 * A curve ends where the last lit texel within one curve texel around it ends, because a lookup interpolates four curves, and each
 * of them must cover the whole way to the point.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SMOKE_MAP_H
#define SMOKE_MAP_H

#include "baker/base/context.h"
#include "baker/scene/smoke.h"
#include "baker/smoke/smoke_grid.h"
#include "formats/vxs_write_file.h"

/* Smoke as capsules of a scene, and light rays through them: capsules that a tile of a light's map may see, and the exact part of a
 * ray inside each. */

enum { SMOKE_TILE_PX = 8 };

/* Capsules that each tile of 8 x 8 texels may see. Zero it. */
typedef struct smoke_bins {
    size_t   *first;    /* [tiles + 1] offset of each tile into `capsules`; tiles by rows, map after map */
    uint32_t *capsules; /* ascending in each tile */
} smoke_bins;

/* For maps of 2^levels texels a side in the light's space.   Returns 0 without memory; released with smoke_bins_free either way. */
int  smoke_bins_make(smoke_bins *b, const scene_smoke *smoke, const vxs_light *light, uint32_t levels);
void smoke_bins_free(smoke_bins *b);

void smoke_capsules_fingerprint(const scene_smoke *smoke, char text[SMOKE_FINGERPRINT_BYTES]);

/* Extend a depth range by capsule n in one of the light's maps, rounded outward.   range  [in, out] least, greatest depth */
void smoke_capsule_depths(const scene_smoke *smoke, uint32_t n, const vxs_light *light, int32_t map, double range[2]);

/* A point where a ray enters or leaves a capsule: the change of the loss per unit of depth. */
typedef struct smoke_change {
    double depth, loss;
} smoke_change;

/* Zero it. */
typedef struct smoke_changes {
    smoke_change *list;
    size_t        count, capacity;
} smoke_changes;

/* The path of a ray through these capsules between two depths.
 * from, way  at depth d the ray is at from + d * way
 * scratch    released by the caller, free(scratch->list)
 * path       [out] its contents are replaced.   Returns 0 without memory. */
int smoke_capsules_march(const scene_smoke *smoke, const uint32_t *capsules, size_t count, const double from[3],
                         const double way[3], double begin, double end, smoke_changes *scratch, smoke_path *path);

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

/* Statistics of a light's smoke; all 0 if it loses no light. */
typedef struct smoke_counts {
    uint32_t      side_px;
    size_t        texels, curves, nodes; /* of its maps; curves: texels that lose light */
    double        largest_error;         /* of a curve's transmittance, against the integral along its ray */
    smoke_lookups lookups;               /* between rays; places 0: no lit point was found */
    uint64_t      memory_bytes, stored_bytes;
} smoke_counts;

/* Add smoke to a file: a map of curves for each light that it affects, as additional sections.
 * file    [in, out] replaced if some light is lost
 * counts  [out] [lights of the file]
 * Returns VXS_OK, VXS_E_MEMORY, or what context_check returns. */
vxs_result smoke_bake(vxs_bytes *file, const smoke_source *source, const smoke_settings *settings, int zstd_level,
                      smoke_counts *counts, bake_context *ctx);

#endif
