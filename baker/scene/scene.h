/* A loaded scene: triangles, lights and cameras in world space (metres, glTF axes: +Y up), whatever file they came from.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SCENE_H
#define SCENE_H

#include <stddef.h>
#include <stdint.h>

#include "baker/base/message.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum light_kind { LIGHT_DIRECTIONAL, LIGHT_SPOT, LIGHT_POINT } light_kind;

typedef struct scene_light {
    char      *name; /* owned, never NULL; unique in the scene */
    light_kind kind;
    double     position_ws[3];  /* metres; means nothing for a directional light */
    double     direction_ws[3]; /* unit, the way light travels; means nothing for a point light */
} scene_light;

/* per triangle */
enum {
    TRIANGLE_DOUBLE_SIDED = 1, /* material.doubleSided */
    TRIANGLE_ALPHA_MASK   = 2  /* material.alphaMode is MASK: parts of it may be holes */
};

typedef struct scene {
    char *name; /* the glTF scene's name, "" when it has none; owned */

    size_t  vertex_count;
    double *positions_ws; /* [3 * vertex_count] as loaded, transformed in double; not welded */

    size_t    triangle_count;
    uint32_t *indices;        /* [3 * triangle_count] < vertex_count; counter-clockwise seen from outside */
    uint8_t  *triangle_flags; /* [triangle_count] TRIANGLE_* */

    size_t       light_count;
    scene_light *lights;

    size_t  camera_count;
    double *camera_positions_ws; /* [3 * camera_count] */
} scene;

/* Read a .gltf or .glb file with tinygltf (glTF 2.0): node hierarchy, sparse accessors, strips and fans, lights of
 * KHR_lights_punctual. Skins and morph targets are taken in rest pose, points and lines skipped; each with a warning.
 * which  NULL: the file's default scene (else scene 0, else all root nodes); or a scene's name or index.
 * s      [out] zeroed on failure; released with scene_free.
 * A mirrored node (negative determinant) has its winding turned back, so that outside stays outside.
 * Returns VXS_OK, VXS_E_READ, VXS_E_SCENE, VXS_E_UNSUPPORTED (an unknown required extension), VXS_E_ARGUMENT (no such
 * scene), VXS_E_MEMORY. A scene without triangles is not an error here. */
vxs_result scene_load_gltf(scene *s, const char *path, const char *which, message *m);

void scene_free(scene *s);

#ifdef __cplusplus
}
#endif
#endif
