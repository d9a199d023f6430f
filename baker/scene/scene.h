/* A loaded scene: triangles, lights and cameras in world space (metres, glTF axes: +Y up), independent of the file format.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SCENE_H
#define SCENE_H

#include <stddef.h>
#include <stdint.h>

#include "baker/base/run_context.h"
#include "baker/base/text.h"
#include "baker/scene/smoke.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum light_kind { LIGHT_DIRECTIONAL, LIGHT_SPOT, LIGHT_POINT } light_kind;

/* Position, direction and extent of a light, in world space. */
typedef struct light_shape {
    light_kind kind;
    double     position_ws[3];  /* metres; unused for a directional light */
    double     direction_ws[3]; /* unit, direction in which light travels; unused for a point light */
    double     outer_rad;       /* spot: angle between its direction and the edge of its cone, (0, pi/2] */
    double     range_metres;    /* spot and point: maximum distance, metres; INFINITY: unlimited */
} light_shape;

typedef struct scene_light {
    char       *name; /* owned, never NULL; unique in the scene */
    light_shape shape;
    double      colour[3]; /* linear, times intensity (directional: lux; else candela), for pictures; 0: unknown or dark */
    double      inner_rad; /* spot: full intensity up to this angle from its direction, [0, outer_rad]; for pictures */
    char       *node_name; /* owned; name of its node, "": the node has none; NULL: not from a file */
    uint32_t    node;      /* node number in the file */
    char       *odd;       /* owned; properties not used as given, and advice; NULL: none */
    const char *dark;      /* why it emits no light; NULL: it does */
} scene_light;

/* A light of the file that cannot be baked, or is hidden with its node. */
typedef struct lost_light {
    char    *name, *node_name; /* owned, as in scene_light */
    uint32_t node;
    char    *why; /* owned; the fault, and advice; NULL: hidden (KHR_node_visibility) */
} lost_light;

/* flags of a triangle */
enum {
    TRIANGLE_DOUBLE_SIDED = 1, /* material.doubleSided */
    TRIANGLE_ALPHA_MASK   = 2  /* material.alphaMode is MASK, and some of it may be a hole: listed in holed_triangles */
};

typedef struct alpha_image {
    uint32_t width_px, height_px; /* 1 to ALPHA_IMAGE_MAX_PX each */
    uint8_t *alpha;               /* [height * width] rows from the top; 255 is opaque; owned by the scene */
} alpha_image;

#define ALPHA_IMAGE_MAX_PX 16384u

typedef enum texture_wrap { WRAP_REPEAT, WRAP_CLAMP, WRAP_MIRROR } texture_wrap;

/* Alpha test of a MASK material: there is a surface where the image's alpha is at least the threshold. */
typedef struct alpha_mask {
    uint32_t image;     /* index into the scene's images */
    float    threshold; /* alphaCutoff / alpha of baseColorFactor; (0, 1]: materials that always or never reach it have no mask */
    texture_wrap wrap_u, wrap_v;
    int          nearest; /* 1: nearest pixel; 0: bilinear */
} alpha_mask;

/* A triangle with holes. */
typedef struct holed_triangle {
    uint32_t triangle; /* index into the scene's triangles */
    uint32_t mask;     /* index into alpha_masks */
    float    uv[3][2]; /* texture coordinates of its corners, with KHR_texture_transform applied. (0, 0) is the upper left corner of
                       the image, (1, 1) the lower right one */
} holed_triangle;

/* Consecutive triangles of one primitive and one node, including its instances. */
typedef struct scene_part {
    uint32_t triangle_first;                      /* up to the first triangle of the next part */
    uint32_t node, mesh, material;                /* numbers in the file; material SCENE_NO_MATERIAL: none */
    uint32_t node_name, mesh_name, material_name; /* offsets into the scene's names; 0: no name */
} scene_part;

#define SCENE_NO_MATERIAL UINT32_MAX

/* An area light, for pictures: a parallelogram of two triangles that emits light to its front side. */
typedef struct scene_area {
    uint32_t part;                   /* part of its triangles */
    double   corner_ws[3];           /* corner where the sides start */
    double   across_ws[3], up_ws[3]; /* sides, metres; light is emitted in the direction of their cross product */
    float    radiance[3];      /* linear, candela per square metre; consistent with the candela and lux of the scene's lights */
    uint32_t wide_px, high_px; /* size of the texture; 0: none */
    float   *texture;          /* [high_px][wide_px][3] linear factor of radiance, first texel at the corner; owned by the scene */
} scene_area;

/* View of a camera of the file, for pictures. `aspect` gives the width of a picture relative to its height; half_high gives the
 * height: */
typedef enum view_kind {
    VIEW_NONE,        /* the file has no valid numbers for it */
    VIEW_PERSPECTIVE, /* half_high is the tangent of half the vertical field of view */
    VIEW_ORTHOGRAPHIC /* half_high is half the height in metres */
} view_kind;

typedef struct scene_view {
    char     *name; /* of its node, else of the camera, else "camera" and its number; owned */
    view_kind kind;
    double    eye_ws[3], forward_ws[3], up_ws[3]; /* forward and up: orthogonal unit vectors */
    double    half_high;
    double    aspect;      /* width / height; 0: use the picture's */
    double    near_metres; /* near plane: distance along its axis, 0 or more */
} scene_view;

/* Consecutive triangles with one origin. The file stores their coordinates as floats relative to this origin. */
typedef struct scene_origin {
    uint32_t triangle_first; /* up to the first triangle of the next origin */
    double   at_ws[3];
} scene_origin;

/* The parts of an object whose triangles are visited in order. */
typedef struct part_span {
    uint32_t first, last, count;
} part_span;

/* Why triangles are not casters. In the order in which the rules apply. */
typedef enum exclusion_rule {
    EXCLUDED_BY_INCLUDE,
    EXCLUDED_BY_EXCLUDE,
    EXCLUDED_BY_EXTRAS,
    EXCLUDED_AS_SKINNED,
    EXCLUDED_AS_HIDDEN, /* KHR_node_visibility; applied first */
    EXCLUDED_AS_BLEND   /* materials that let light through */
} exclusion_rule;
#define EXCLUSION_RULES "include|exclude|extras|skinned|hidden|blend" /* words in the order of exclusion_rule */

typedef struct scene_exclusion {
    exclusion_rule rule;
    const char    *pattern;   /* EXCLUDED_BY_EXCLUDE: a pattern, borrowed from the choice; else NULL */
    size_t         triangles; /* triangles for which this is the first matching rule */
    size_t         nodes;     /* EXCLUDED_AS_HIDDEN: number of hidden nodes, with their descendants */
} scene_exclusion;

typedef struct scene {
    char *name; /* name of the glTF scene, "": none; owned */

    size_t  vertex_count;
    double *positions_ws; /* [3 * vertex_count] as in the file, transformed in double; not welded */

    size_t    triangle_count;
    uint32_t *indices;        /* [3 * triangle_count] < vertex_count; counter-clockwise seen from outside */
    uint8_t  *triangle_flags; /* [triangle_count] TRIANGLE_* */

    size_t      part_count;
    scene_part *parts; /* in the order of triangles; cover all triangles; none in a scene that is not from a file */
    char       *names; /* NUL-terminated strings, as in the file */

    size_t        origin_count;
    scene_origin *origins; /* in the order of triangles; none: positions have the precision of a double */

    size_t           exclusion_count;
    scene_exclusion *exclusions; /* the requested rules, and others that left triangles out */

    size_t          image_count, alpha_mask_count;
    alpha_image    *images; /* only those that masks use */
    alpha_mask     *alpha_masks;
    size_t          holed_triangle_count;
    holed_triangle *holed_triangles; /* in the order of triangles */

    size_t       light_count;
    scene_light *lights;
    size_t       lost_light_count;
    lost_light  *lost_lights; /* in the file's order, as lights */

    size_t material_count;
    float (*material_colours)[3]; /* [material_count] linear base colours, for pictures; textures are not read and count as grey */
    size_t emissive_count;        /* number of emissive materials; these are not lights */

    size_t      area_count; /* filled only if the choice has `areas` */
    scene_area *areas;      /* in the order of triangles */
    size_t      dim_count;  /* emissive triangles that are not part of a parallelogram of two */

    size_t  camera_count;
    double *camera_positions_ws; /* [3 * camera_count] */

    size_t      view_count;
    scene_view *views; /* of the same cameras, in the scene's order; none in a scene that is not from a file */

    scene_smoke smoke; /* points and lines that dim light */
} scene;

typedef enum skinned_mode { SKINNED_EXCLUDE, SKINNED_REST } skinned_mode;
#define SKINNED_CHOICES "exclude|rest" /* words in the order of skinned_mode */

/* Treatment of materials with alphaMode BLEND. BLEND_MASK: a caster where alpha is 0.5 or more. BLEND_OPAQUE: a caster.
 * BLEND_EXCLUDE: no caster, also for KHR_materials_transmission. In all cases alpha 0 everywhere is no caster, and alpha 1
 * everywhere is one. */
typedef enum blend_choice { BLEND_MASK, BLEND_OPAQUE, BLEND_EXCLUDE } blend_choice;
#define BLEND_CHOICES "mask|opaque|exclude" /* words in the order of blend_choice */

/* Which scene of a file to load, and which of its objects cast shadows. A pattern matches nodes, meshes or materials of the scene
 * by name, with shell wildcards, or by number ("#12"). A prefix "node:", "mesh:" or "material:" selects one kind, else all three
 * match. A node stands for its whole subtree. Objects that `exclude` matches are no casters; if `include` is not empty, nor are
 * objects that it does not match. */
typedef struct scene_choice {
    const char *name; /* name or index of the scene; NULL: the file's default scene, else scene 0, else all root nodes */
    text_list   exclude, include;
    int         skinned, skinned_given; /* skinned_mode; the second is 1 when the option was given: then there is no warning */
    int         blend, blend_given;     /* blend_choice; likewise */
    int         areas;                  /* 1: also read area lights with their textures */
    int         allow_outside;          /* 1: buffers and images may lie outside the scene's folder */
} scene_choice;

/* Read a .gltf or .glb file (glTF 2.0) with tinygltf: node hierarchy, sparse accessors, strips and fans, lights of
 * KHR_lights_punctual, and points and lines that are smoke (docs/smoke.md, "In a scene file"). Skinned meshes are excluded, morph
 * targets have their default weights, and other points and lines are skipped, each with a warning.
 * choice  NULL: the file's default scene, all except skinned meshes
 * s       [out] zeroed on failure; released with scene_free. Borrows patterns from the choice.
 * Triangles of mirrored nodes (negative determinant) are reversed, so that their outside stays outside.
 * Returns VXS_OK, VXS_E_READ, VXS_E_SCENE, VXS_E_UNSUPPORTED (an unknown required extension), VXS_E_ARGUMENT (no such scene, or a
 * pattern without a match), VXS_E_MEMORY, VXS_E_STRICT. A scene without triangles is not an error here. */
vxs_result scene_load_gltf(scene *s, const char *path, const scene_choice *choice, run_context *m);

/* A callback, called once when the name, lights and cameras of a scene are known, before triangles are placed, which may take long.
 * If it does not return VXS_OK, loading ends with its result. Data that it borrows from s stays valid until scene_free. */
typedef struct scene_check {
    vxs_result (*check)(void *user, const scene *s, run_context *m);
    void *user;
} scene_check;

/* The same with a check, whose result may be returned.
 * check  NULL: none */
vxs_result scene_load_gltf_checked(scene *s, const char *path, const scene_choice *choice, const scene_check *check,
                                   run_context *m);

/* Only check that no file that the scene refers to is an output of this run, as scene_load_gltf does first. For scenes that another
 * program will read.
 * Returns VXS_OK, VXS_E_READ, VXS_E_SCENE, VXS_E_ARGUMENT, VXS_E_MEMORY. */
vxs_result scene_check_files_gltf(const char *path, run_context *m);

/* A file of a scene.
 * uri    as the scene has it, for a buffer or an image; NULL: the scene's own file
 * bytes  [size_bytes] valid during the call
 * Returns VXS_OK; any other result ends the visit with it. */
typedef vxs_result scene_file_fn(void *user, const char *uri, const uint8_t *bytes, size_t size_bytes, run_context *m);

/* Visit the scene's own file, then each other file that its buffers and images are in, once for each URI. One file is held at a
 * time, beside the scene's own. A missing image is a warning, a missing buffer is an error.
 * path           a file, not a pipe
 * allow_outside  as in scene_choice
 * Returns VXS_OK, VXS_E_READ, VXS_E_SCENE, VXS_E_UNSUPPORTED, VXS_E_ARGUMENT (a file is an output of this run), VXS_E_MEMORY,
 * VXS_E_STRICT, or what `visit` returned. */
vxs_result scene_visit_files_gltf(const char *path, int allow_outside, scene_file_fn *visit, void *user, run_context *m);

/* Load the default scene from the bytes of a .gltf or .glb file. Buffers and images in other files are an error. `name` replaces
 * the path in messages. */
vxs_result scene_load_gltf_memory(scene *s, const void *bytes, size_t size_bytes, const char *name, run_context *m);

void scene_free(scene *s);

/* Release vertices and triangles, which take most of the memory. All else stays. */
void scene_drop_triangles(scene *s);

/* Part of a triangle. `part` is the part of an earlier triangle, 0 at first. */
static inline uint32_t scene_part_at(const scene *s, uint32_t part, size_t triangle)
{
    while (part + 1 < s->part_count && s->parts[part + 1].triangle_first <= triangle) part++;
    return part;
}

/* Add the part of a triangle. */
static inline void part_span_add(part_span *span, uint32_t part)
{
    if (span->count && span->last == part) return;
    if (!span->count++) span->first = part;
    span->last = part;
}

/* "--exclude node:Door*", "vxs_cast_shadow in its extras", ... into text. Returns text. */
const char *exclusion_text(char text[128], const scene_exclusion *e);

/* "directional", "spot", "point" */
const char *light_kind_name(light_kind kind);

/* 1 when a point is within the light's cone and range (shadows are ignored). Directional: always. */
int light_reaches(const light_shape *light, const double point_ws[3]);

/* The same for many points; the caller computes the cosine of outer_rad once. */
int light_reaches_by(const light_shape *light, double cosine, const double point_ws[3]);

/* 1 when a part of a ball is within the light's cone and range. */
int light_reaches_ball(const light_shape *light, const double middle_ws[3], double radius_metres);

/* Evaluates alpha masks: whether an alpha-tested material has a surface at a point of its image. Ray tracing uses these functions
 * directly; the shader for depth maps follows the same definition.
 *
 * u runs to the right and v downward; the image covers [0, 1] x [0, 1]. Pixel (i, j) has its centre at ((i + 0.5) / width, (j +
 * 0.5) / height). Coordinates outside the image map to a pixel by the wrap mode of each axis:
 *
 *     pixel         ...  -3 -2 -1 | 0  1  2  3 |  4  5  6 ...      an image 4 pixels wide
 *     WRAP_REPEAT         1  2  3 | 0  1  2  3 |  0  1  2
 *     WRAP_CLAMP          0  0  0 | 0  1  2  3 |  3  3  3
 *     WRAP_MIRROR         2  1  0 | 0  1  2  3 |  3  2  1
 *
 * Alpha is that of the pixel containing (u, v) (nearest), or bilinear between the four nearest pixel centres: first along u, then
 * along v, each as a + share * (b - a), so that equal pixels give exactly their alpha. No mipmaps are used, because a bake has no
 * viewpoint. */

/* Alpha at (u, v), 0 to 255. A coordinate that is not finite counts as 0. Thread-safe. */
double alpha_mask_alpha(const alpha_mask *mask, const alpha_image *image, double u, double v);

/* 1 where there is a surface: alpha / 255, rounded to float like the threshold, is at least the threshold. */
int alpha_mask_opaque(const alpha_mask *mask, const alpha_image *image, double u, double v);

#ifdef __cplusplus
}
#endif

#endif
