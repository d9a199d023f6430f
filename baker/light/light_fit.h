/* Fit the maps of a light to the scene.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef LIGHT_FIT_H
#define LIGHT_FIT_H

#include "baker/casters/casters.h"
#include "formats/vxs_file.h"

#define PUNCTUAL_BORDER_PX    26 /* half the width of the widest filter with its bias (vxs_voxel), rounded up */
#define PUNCTUAL_FAR_NEAR_MAX 1e7
#define PUNCTUAL_SPOT_MAX_RAD 1.0471975511965976 /* 60 degrees from the axis; wider cones get six maps */

typedef struct light_fit_desc {
    const char        *name;
    const light_shape *shape;
    uint32_t           resolution;     /* texels a side, a power of two, at least 8; 0: from texel_metres */
    uint32_t           resolution_max; /* upper limit of the resolution that texel_metres gives */
    double             texel_metres;   /* used when resolution is 0 */
    const double      *region_ws;      /* [6] min xyz, max xyz of the box in which lookups happen; NULL: all casters */
    uint32_t           threads;        /* 0 and 1: the calling thread only */
} light_fit_desc;

/* Fit the maps of a light to the casters it can reach.
 *
 * Directional: one orthographic map of the casters, or of a region. The u axis is horizontal, so that vertical edges (most edges of
 * buildings) run along texel columns. Margins around the casters: one texel at each side, one voxel in front, two voxels behind. So
 * points outside the map are lit, and the last voxel lies behind every caster and can answer for all points beyond it. A map of a
 * region is bounded: it ends at the region, casters in front are flattened to its near side, and casters behind are left out. A
 * voxel is never thinner than a texel is wide, since the map is not more precise than that.
 *
 * Spot and point: perspective maps with logarithmic depth ([CPVS16] 5). A spot light has one map across its cone. If the cone is
 * wider than 120 degrees, one map would waste its texels at the rim, so the light gets the six maps of a cube, as a point light. A
 * border of PUNCTUAL_BORDER_PX texels (fewer in maps narrower than 256 texels) surrounds the cone or the sides of the cube, for
 * filters and their bias. Near and far are those of the casters within the light's range and maps, with far / near <=
 * PUNCTUAL_FAR_NEAR_MAX: nearer casters are moved to the near plane. The texel size applies at the far side. The region is ignored.
 *
 * light  [out] everything except the DAG.
 * Returns VXS_OK; VXS_E_NO_CASTER (without a message): the light reaches no caster; VXS_E_ARGUMENT. */
vxs_result light_fit(vxs_light *light, const casters *c, const light_fit_desc *desc, run_context *m);

#endif
