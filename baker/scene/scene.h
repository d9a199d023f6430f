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

/* Where light comes from and how far it goes, in world space. */
typedef struct light_shape {
    light_kind kind;
    double     position_ws[3];  /* metres; means nothing for a directional light */
    double     direction_ws[3]; /* unit, the way light travels; means nothing for a point light */
    double     outer_rad;       /* spot: angle between its direction and the edge of its cone, (0, pi/2] */
    double     range_m;         /* spot and point: metres from the light to where its reach ends; INFINITY: no end */
} light_shape;

typedef struct scene_light {
    char       *name; /* owned, never NULL; unique in the scene */
    light_shape shape;
} scene_light;

/* per triangle */
enum {
    TRIANGLE_DOUBLE_SIDED = 1, /* material.doubleSided */
    TRIANGLE_ALPHA_MASK   = 2  /* material.alphaMode is MASK and some of it may be a hole: it is one of holed_triangles */
};

typedef struct alpha_image {
    uint32_t width_px, height_px; /* 1 to ALPHA_IMAGE_MAX_PX each */
    uint8_t *alpha;               /* [height * width] rows from the top; 255 is opaque; owned by the scene */
} alpha_image;

#define ALPHA_IMAGE_MAX_PX 16384u

typedef enum texture_wrap { WRAP_REPEAT, WRAP_CLAMP, WRAP_MIRROR } texture_wrap;

/* How a MASK material decides whether there is a surface: where the image's alpha is at least the threshold. */
typedef struct alpha_mask {
    uint32_t     image;     /* index into the scene's images */
    float        threshold; /* alphaCutoff / baseColorFactor's alpha; (0, 1]: what is always or never met has no mask */
    texture_wrap wrap_u, wrap_v;
    int          nearest; /* 1: the nearest pixel; 0: bilinear, between the four around */
} alpha_mask;

/* A triangle with holes. */
typedef struct holed_triangle {
    uint32_t triangle; /* index into the scene's triangles */
    uint32_t mask;     /* index into masks */
    float uv[3][2]; /* of its corners; KHR_texture_transform is applied. (0, 0) is the image's upper left corner, (1, 1) the lower
                          right one */
} holed_triangle;

typedef struct scene {
    char *name; /* the glTF scene's name, "" when it has none; owned */

    size_t  vertex_count;
    double *positions_ws; /* [3 * vertex_count] as loaded, transformed in double; not welded */

    size_t    triangle_count;
    uint32_t *indices;        /* [3 * triangle_count] < vertex_count; counter-clockwise seen from outside */
    uint8_t  *triangle_flags; /* [triangle_count] TRIANGLE_* */

    size_t          image_count, alpha_mask_count;
    alpha_image    *images; /* only those that masks need */
    alpha_mask     *alpha_masks;
    size_t          holed_triangle_count;
    holed_triangle *holed_triangles; /* in the order of their triangles */

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

/* The same for the bytes of a .gltf or .glb file: its default scene; buffers and images in other files are an error. `name` stands
 * for the file in messages. */
vxs_result scene_load_gltf_memory(scene *s, const void *bytes, size_t size_bytes, const char *name, message *m);

void scene_free(scene *s);

/* "directional", "spot", "point" */
const char *light_kind_name(light_kind kind);

/* 1 when a point is in the light's cone and range (no shadow is asked about); directional: always. */
int light_reaches(const light_shape *light, const double point_ws[3]);

#ifdef __cplusplus
}
#endif
#endif
