/* One vertex for each position.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef MESH_WELD_H
#define MESH_WELD_H

#include "baker/scene/scene.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct mesh_weld {
    size_t    vertex_count;
    double   *positions_ws; /* [3 * vertex_count] finite, no two are equal; -0 is +0 */
    size_t    triangle_count;
    uint32_t *indices;   /* [3 * triangle_count] three different ones each, in the scene's order */
    uint32_t *from;      /* [triangle_count] which of the scene's triangles it is, ascending */
    uint32_t *welded_of; /* [the scene's vertex_count] or UINT32_MAX: no triangle uses it */
} mesh_weld;

/* Weld vertices at bit-equal positions, and leave out triangles with two corners in one place.
 * w  [out] zeroed on failure; released with mesh_weld_free
 * Returns VXS_OK, VXS_E_MEMORY, or VXS_E_SCENE: a corner that is not finite, or 2^32 / 3 triangles.  The same at any thread count. */
vxs_result mesh_weld_scene(mesh_weld *w, const scene *s, uint32_t threads, message *m);

void mesh_weld_free(mesh_weld *w);

#ifdef __cplusplus
}
#endif
#endif
