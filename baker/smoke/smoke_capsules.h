/* Smoke as capsules of a scene, and light rays through them: which of them a tile of a light's map may see, and the part of a ray
 * in each, exactly.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SMOKE_CAPSULES_H
#define SMOKE_CAPSULES_H

#include "baker/scene/smoke.h"
#include "baker/smoke/smoke_path.h"
#include "formats/vxs_file.h"

enum { SMOKE_TILE_PX = 8 };

/* The capsules that each tile of 8 x 8 texels may see. Zero it. */
typedef struct smoke_bins {
    size_t   *first;    /* [tiles + 1] of each tile, in `capsules`; tiles by rows, map after map */
    uint32_t *capsules; /* ascending in each tile */
} smoke_bins;

/* Of maps of 2^levels texels a side in the space of a light's.   Returns 0 without memory; released with smoke_bins_free either
 * way. */
int  smoke_bins_make(smoke_bins *b, const scene_smoke *smoke, const vxs_light *light, uint32_t levels);
void smoke_bins_free(smoke_bins *b);

void smoke_capsules_fingerprint(const scene_smoke *smoke, char text[SMOKE_FINGERPRINT_BYTES]);

/* From where to where in depth capsule n is in one of the light's maps, its ends rounded outward.   range  [in, out] least,
 * greatest */
void smoke_capsule_depths(const scene_smoke *smoke, uint32_t n, const vxs_light *light, int32_t map, double range[2]);

/* Where a ray enters and leaves smoke: what it loses in a unit of depth from there on is more, or less. */
typedef struct smoke_change {
    double depth, loss;
} smoke_change;

/* Zero it. */
typedef struct smoke_changes {
    smoke_change *list;
    size_t        count, capacity;
} smoke_changes;

/* The path of a ray between two depths through these capsules.
 * from, way  at depth d the ray is at from + d * way
 * scratch    released by the caller, free(scratch->list)
 * path       [out] its count is set anew.   Returns 0 without memory. */
int smoke_capsules_march(const scene_smoke *smoke, const uint32_t *capsules, size_t count, const double from[3],
                         const double way[3], double begin, double end, smoke_changes *scratch, smoke_path *path);

#endif
