/* Where a light's map lies in the world.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef LIGHT_FIT_H
#define LIGHT_FIT_H

#include "baker/scene/casters.h"
#include "formats/vxs_file.h"

typedef struct light_fit_desc {
    const char        *name;
    const light_shape *shape;
    uint32_t           resolution;     /* texels a side, a power of two from 8; 0: from texel_metres */
    uint32_t           resolution_max; /* of a map that texel_metres asks for */
    double             texel_metres;   /* used when resolution is 0 */
    const double      *region_ws;      /* [6] min xyz, max xyz of the box that is looked up; NULL: all casters */
} light_fit_desc;

/* Fit the orthographic map of a directional light to the casters, or to a region.
 *
 * u is horizontal, so that vertical edges (most edges of buildings) run along texel columns. Around the casters lie one texel, one
 * voxel in front, and two behind: what is outside the map is lit, and its last voxel is behind every caster, so that points beyond
 * it can be answered from it. A map of a region ends at the region, because casters in front of it are flattened to its near side and
 * those behind it are left out: it is bounded. A voxel is never flatter than a texel is wide: the map knows no position better than that.
 * light  [out] all but the DAG.   Returns VXS_OK, VXS_E_ARGUMENT. */
vxs_result light_fit(vxs_light *light, const casters *c, const light_fit_desc *desc, message *m);

#endif
