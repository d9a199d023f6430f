/* Smoke as capsules of a scene, and light rays through them: capsules that a tile of a light's map may see, and the exact part of a
 * ray inside each.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SMOKE_CAPSULES_H
#define SMOKE_CAPSULES_H

#include "baker/scene/smoke.h"
#include "baker/smoke/smoke_path.h"
#include "formats/vxs_file.h"

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

#endif
