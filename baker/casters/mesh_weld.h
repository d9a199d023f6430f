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
    double   *positions_ws; /* [3 * vertex_count] finite and distinct; -0 is stored as +0 */
    size_t    triangle_count;
    uint32_t *indices;   /* [3 * triangle_count] three different vertices per triangle, in the scene's order */
    uint32_t *from;      /* [triangle_count] triangle number in the scene, ascending */
    uint32_t *welded_of; /* [the scene's vertex_count] welded vertex; UINT32_MAX: not used by any triangle */
} mesh_weld;

/* Weld vertices at bit-equal positions, and drop triangles with two corners at one position.
 * w  [out] zeroed on failure; released with mesh_weld_free
 * Returns VXS_OK, VXS_E_MEMORY, or VXS_E_SCENE: a corner is not finite, or there are 2^32 / 3 triangles or more. The result does
 * not depend on the number of threads. */
vxs_result mesh_weld_scene(mesh_weld *w, const scene *s, uint32_t threads, message *m);

void mesh_weld_free(mesh_weld *w);

#ifdef __cplusplus
}
#endif
#endif
