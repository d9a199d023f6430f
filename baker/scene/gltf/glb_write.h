/* Write triangle meshes, materials with holes, smoke, lights and cameras as a binary glTF 2.0 file.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef GLB_WRITE_H
#define GLB_WRITE_H

#include <stddef.h>
#include <stdint.h>

#include "baker/base/run_context.h"
#include "baker/files/output_file.h"
#include "baker/scene/scene.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A range of the scene's vertices and triangles; becomes a mesh and a node with this name. */
typedef struct glb_mesh {
    char     name[32];
    size_t   vertex_first, vertex_count;
    size_t   triangle_first, triangle_count; /* both counts > 0 */
    uint32_t material;                       /* 1 + index into materials; 0: none */
    double   translation[3];                 /* metres: translation of the node */
} glb_mesh;

typedef struct glb_material {
    const char  *name; /* borrowed */
    int          double_sided;
    double       alpha_cutoff; /* 0: OPAQUE; else alphaMode MASK with this cutoff, (0, 1] */
    uint32_t     image;        /* 1 + index into images: base colour texture; 0: none */
    double       emission;     /* above 0: emissive strength: the image is the emissive texture, and the base colour is black */
    texture_wrap wrap_u, wrap_v;
    int          nearest;   /* 1: nearest pixel; 0: bilinear */
    double       colour[3]; /* base colour, linear, [0, 1]; all 0: not written, which means white */
} glb_material;

/* A range of the smoke vertices; becomes a mesh and a node with this name. */
typedef struct glb_smoke {
    char     name[32];
    int      lines; /* 1: LINES, two vertices each; 0: POINTS */
    size_t   vertex_first, vertex_count;
    uint32_t material; /* 1 + index into materials; 0: none */
} glb_smoke;

/* Layout in the file: interleaved attributes. */
typedef struct glb_smoke_vertex {
    float place[3], radius_metres, extinction; /* extinction per metre; place in metres from the origin */
} glb_smoke_vertex;

/* Stored as PNG. */
typedef struct glb_image {
    uint32_t width_px, height_px; /* 1 to ALPHA_IMAGE_MAX_PX each */
    uint8_t *rgba;                /* [4 * width * height] rows from the top, sRGB with straight alpha; owned */
} glb_image;

typedef struct glb_scene {
    const char *name; /* borrowed, UTF-8 */

    /* Origin of the positions of meshes and smoke, metres: the translation of a root node that contains them. 0,0,0: no such
     * node. */
    double origin_ws[3];
    size_t vertex_count;
    float *positions; /* [3 * vertex_count] metres from the origin, +Y up; owned. May be not finite, for tests of broken scenes */
    float *texcoords; /* [2 * vertex_count] owned; NULL when no material has an image */

    size_t    triangle_count;
    uint32_t *indices; /* [3 * triangle_count] relative to the mesh's vertex_first; counter-clockwise from outside; owned */

    size_t    mesh_count;
    glb_mesh *meshes; /* [mesh_count] owned */

    size_t            smoke_count, smoke_vertex_count;
    glb_smoke        *smoke;          /* [smoke_count] owned */
    glb_smoke_vertex *smoke_vertices; /* [smoke_vertex_count] owned */

    size_t        material_count, image_count, light_count, camera_count;
    glb_material *materials;           /* [material_count] owned */
    glb_image    *images;              /* [image_count] owned */
    scene_light  *lights;              /* [light_count] directions of any nonzero length; owned, with their names */
    double       *camera_positions_ws; /* [3 * camera_count] owned; directions are not stored */
} glb_scene;

/* Write the scene. Nodes: one per mesh, one per run of smoke, one per light (KHR_lights_punctual), one per camera. Positions,
 * texture coordinates and smoke are FLOAT, indices UNSIGNED_INT, in one buffer view each; images have one buffer view each. Empty
 * lists are left out. The same scene gives the same bytes (images: with the same version of libpng).
 * Returns VXS_OK, VXS_E_WRITE, VXS_E_ARGUMENT (more than 4 GiB, the limit of GLB), VXS_E_MEMORY. */
vxs_result glb_write(const glb_scene *s, output_file *out, run_context *m);

/* Accepts a zeroed object. */
void glb_scene_free(glb_scene *s);

#ifdef __cplusplus
}
#endif

/* Convert a loaded scene to a glb_scene for writing. */

/* Convert everything that a bake reads: triangles in order within each material, double-sidedness, alpha masks, lights, positions
 * of cameras, names of the scene and its lights. Positions are rounded to float as by glb_round_positions.
 * out        [out] zeroed on failure; borrows the scene's name; released with glb_scene_free
 * origin_ws  from glb_find_origin
 * Returns VXS_OK or VXS_E_MEMORY. */
vxs_result glb_from_scene(glb_scene *out, const scene *s, const double origin_ws[3], run_context *m);

/* Find an origin for the positions of a GLB, so that floats are precise enough. 0,0,0, unless the scene is far from there relative
 * to its size, as georeferenced scenes are. Then it is the origin of the longest run of triangles, which preserves their original
 * floats, or the centre of the scene, if that moves vertices less. */
void glb_find_origin(const scene *s, double origin_ws[3]);

/* Round positions to floats relative to an origin, as a GLB stores them. Vertices with equal positions stay equal; different
 * positions may become equal. Warns when a vertex moves by more than a millimetre.
 * Returns VXS_OK, VXS_E_SCENE when a position exceeds the range of a float, or VXS_E_STRICT. */
vxs_result glb_round_positions(scene *s, const double origin_ws[3], run_context *m);

#endif
