/* Enter and exit depth maps of the casters, rendered with OpenGL.
 * Source: [CPVS16] 3.3.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef DEPTH_GL_H
#define DEPTH_GL_H

#include "baker/casters/casters.h"
#include "baker/columns/rendered_columns.h"
#include "baker/lab/opengl/depth_maps.h"
#include "baker/lab/opengl/gl.h"
#include "formats/vxs_file.h"

typedef struct depth_renderer depth_renderer;

/* Set up for map `map` of a light (numbered as in vxs.h). gl and casters are borrowed until depth_renderer_destroy. Renderers
 * may share a context and take turns. Depths are those of depth_maps.h: fractions of the depth range for a directional light,
 * -near / distance for others.
 * Returns VXS_OK, VXS_E_GL, VXS_E_MEMORY. */
vxs_result depth_renderer_create(depth_renderer **out, gl_context *gl, const casters *c, const vxs_light *light, int map,
                                 exit_mode mode, uint32_t threads, run_context *m);

/* 1 when some caster may touch the square (i, j), in units of side_px. */
int depth_renderer_has_casters(const depth_renderer *r, uint32_t side_px, uint32_t i, uint32_t j);

/* Render the square (i, j), in units of maps->side_px, into maps->enter and maps->exit. These may be the same array only when
 * there are no solids. Returns VXS_OK, VXS_E_GL, VXS_E_MEMORY. */
vxs_result depth_renderer_tile(depth_renderer *r, depth_maps *maps, uint32_t i, uint32_t j, run_context *m);

depth_stats depth_renderer_stats(const depth_renderer *r);

void depth_renderer_destroy(depth_renderer *r);

/* Its devices are OpenGL contexts (gl_context). */
extern const column_renderer opengl_renderer;

column_source opengl_columns_source(rendered_columns *c);
void          opengl_columns_free(rendered_columns *c);

#endif
