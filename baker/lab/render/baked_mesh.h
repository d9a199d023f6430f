/* The mesh around the lit volume of a baked light, made once from its shadow depths.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BAKED_MESH_H
#define BAKED_MESH_H

#include "baker/lab/opengl/gl.h"
#include "runtime/volumes/vxs_volumes.h"

typedef struct baked_mesh_options {
    uint32_t light;      /* its number in vxs_gl */
    uint32_t side_px;    /* side of the shadow depth map, a power of two; 0, or more than the baked map's: that side */
    double   far_metres; /* as for vxs_light_mesh_desc, like the next one */
    double   error_texels;
} baked_mesh_options;

/* mesh  [out] untouched on failure; released with vxs_light_mesh_destroy.   Returns VXS_OK, VXS_E_GL, VXS_E_MEMORY,
 *       VXS_E_ARGUMENT. */
vxs_result baked_mesh_make(vxs_light_mesh **mesh, const baked_mesh_options *o, const gl_context *gl, const vxs_gl *shadows,
                           vxs_volumes *volumes, message *m);

#endif
