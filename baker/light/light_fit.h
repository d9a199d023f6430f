/* Where a light's map lies in the world.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef LIGHT_FIT_H
#define LIGHT_FIT_H

#include "baker/casters/casters.h"
#include "formats/vxs_file.h"

#define LAMP_BORDER_PX    26 /* half of the widest filter and its bias across the map (vxs_voxel), rounded up */
#define LAMP_FAR_NEAR_MAX 1e7
#define LAMP_SPOT_MAX_RAD 1.0471975511965976 /* 60 degrees from the axis: wider cones get six maps */

typedef struct light_fit_desc {
    const char        *name;
    const light_shape *shape;
    uint32_t           resolution;     /* texels a side, a power of two from 8; 0: from texel_metres */
    uint32_t           resolution_max; /* of a map that texel_metres asks for */
    double             texel_metres;   /* used when resolution is 0 */
    const double      *region_ws;      /* [6] min xyz, max xyz of the box that is looked up; NULL: all casters */
} light_fit_desc;

/* Fit the maps of a light to what it can reach.
 *
 * Directional: one orthographic map of the casters, or of a region.
 * u is horizontal, so that vertical edges (most edges of buildings) run along texel columns. Around the casters lie one texel, one
 * voxel in front, and two behind: what is outside the map is lit, and its last voxel is behind every caster, so that points beyond
 * it can be answered from it. A map of a region ends at the region, because casters in front of it are flattened to its near side and
 * those behind it are left out: it is bounded. A voxel is never flatter than a texel is wide: the map knows no position better than that.
 *
 * Spot and point: perspective maps with logarithmic depth ([CPVS16] 5). A spot has one map across its cone, or, where that is wider than
 * 120 degrees and one map would spend its texels on the rim, the six of a cube, as a point light has. About the cone (or the sides of
 * the cube) lies a border of LAMP_BORDER_PX texels for filters and their bias, less in maps narrower than 256 texels. Near and far are
 * those of the casters within the light's range and maps, but not farther apart than LAMP_FAR_NEAR_MAX: what is nearer is taken for as
 * near as that. A texel's size is that at the far side. A region is not looked at.
 *
 * light  [out] all but the DAG.
 * Returns VXS_OK; VXS_E_NO_CASTER (no message): the light reaches no caster; VXS_E_ARGUMENT. */
vxs_result light_fit(vxs_light *light, const casters *c, const light_fit_desc *desc, message *m);

/* The part of light_fit for spot and point lights, in lamp_fit.c.
 * light  [in] its name is set
 * axes   rows: u, v, and the light's direction; right-handed */
vxs_result lamp_fit(vxs_light *light, const casters *c, const light_fit_desc *desc, double axes[3][3], message *m);

#endif
