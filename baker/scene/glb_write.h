/* Triangle meshes and one directional light as a binary glTF 2.0 file.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef GLB_WRITE_H
#define GLB_WRITE_H

#include <stddef.h>
#include <stdint.h>

#include "baker/base/message.h"
#include "baker/base/output_file.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A run of the scene's vertices and triangles; becomes a mesh and a node of that name. */
typedef struct glb_mesh {
    char   name[32];
    size_t vertex_first, vertex_count;
    size_t triangle_first, triangle_count; /* both counts > 0 */
} glb_mesh;

typedef struct glb_scene {
    const char *name; /* borrowed, UTF-8 */

    size_t vertex_count;
    float *positions; /* [3 * vertex_count] metres, +Y up; finite; owned */

    size_t    triangle_count;
    uint32_t *indices; /* [3 * triangle_count] counted from the mesh's vertex_first; counter-clockwise from outside; owned */

    size_t    mesh_count;
    glb_mesh *meshes; /* [mesh_count] owned */

    double sun_direction[3]; /* the way the light "sun" travels; any length but 0 */
} glb_scene;

/* Write the scene: one node a mesh, then a node "sun" with a directional light of KHR_lights_punctual. Positions are
 * FLOAT, indices UNSIGNED_INT, one buffer view each; the same scene gives the same bytes.
 * Returns VXS_OK, VXS_E_WRITE, VXS_E_ARGUMENT (more than the 4 GiB a GLB can hold), VXS_E_MEMORY. */
vxs_result glb_write(const glb_scene *s, output_file *out, message *m);

/* Accepts a zeroed object. */
void glb_scene_free(glb_scene *s);

#ifdef __cplusplus
}
#endif
#endif
