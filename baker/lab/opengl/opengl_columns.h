/* The maps of a light rendered with OpenGL: a column source.
 *
 * A square is made by rendering depth maps of a tile and reducing them to a pyramid. Before that, only regions without casters
 * are known.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef OPENGL_COLUMNS_H
#define OPENGL_COLUMNS_H

#include "baker/lab/opengl/depth_gl.h"

/* Its devices are OpenGL contexts (gl_context). */
extern const column_renderer opengl_renderer;

column_source opengl_columns_source(rendered_columns *c);
void          opengl_columns_free(rendered_columns *c);

#endif
