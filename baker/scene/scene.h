/* A loaded scene: triangles, lights and cameras in world space (metres, glTF axes: +Y up), whatever file they came from.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SCENE_H
#define SCENE_H

#include <stddef.h>
#include <stdint.h>

#include "baker/base/message.h"
#include "baker/base/text.h"
#include "baker/scene/smoke.h"

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
    double      colour
        [3]; /* linear, times intensity: lux of a directional light, candela of others; for pictures. 0: unknown, or it is dark */
    double      inner_rad; /* spot: up to this angle from its direction it is at its full strength, [0, outer_rad]; for pictures */
    char       *node_name; /* owned; of the node that places it, "" where that has none; NULL: it came from no file */
    uint32_t    node;      /* the file's number of that node */
    char       *odd;       /* owned; what of it is not read as it is written, and what to do; NULL: nothing */
    const char *dark;      /* why it shines with nothing; NULL: it shines */
} scene_light;

/* A light of the file that cannot be baked, or is hidden with its node. */
typedef struct lost_light {
    char    *name, *node_name; /* owned, as a light's */
    uint32_t node;
    char    *why; /* owned: what is wrong, and what to do; NULL: it is hidden (KHR_node_visibility) */
} lost_light;

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

/* Triangles that follow each other, all of one primitive and one node, instances of it included. */
typedef struct scene_part {
    uint32_t triangle_first;                      /* to where the next part begins */
    uint32_t node, mesh, material;                /* the file's numbers; material SCENE_NO_MATERIAL: none */
    uint32_t node_name, mesh_name, material_name; /* where they begin in the scene's names; 0: it has none */
} scene_part;

#define SCENE_NO_MATERIAL UINT32_MAX

/* A parallelogram of two triangles that shines to the side that they are seen from, for pictures. */
typedef struct scene_area {
    uint32_t part;                   /* whose triangles they are */
    double   corner_ws[3];           /* from which the sides run */
    double   across_ws[3], up_ws[3]; /* metres; it shines to where their cross product points */
    float    radiance[3];      /* linear; of lights of one scene, candela or lux, and this, candela a square metre, go together */
    uint32_t wide_px, high_px; /* of the texture; 0: it has none */
    float *
        texture; /* [high_px][wide_px][3] linear, what the radiance is times; the first texel is at the corner; owned by the scene */
} scene_area;

/* What a camera of the file sees, for pictures. A picture is as wide as its shape says, and as high as this: */
typedef enum view_kind {
    VIEW_NONE,        /* the file has no sound numbers for it */
    VIEW_PERSPECTIVE, /* half_high is the tangent of half of its angle from top to bottom */
    VIEW_ORTHOGRAPHIC /* half_high is half of its height in metres */
} view_kind;

typedef struct scene_view {
    char     *name; /* of its node, or of the camera, or "camera" and its number; owned */
    view_kind kind;
    double    eye_ws[3], forward_ws[3], up_ws[3]; /* forward and up: unit, at right angles */
    double    half_high;
    double    aspect; /* width / height; 0: that of the picture */
    double    near_m; /* nearer along its axis nothing is seen, 0 or more */
} scene_view;

/* Triangles that follow each other, all placed from one origin: their coordinates are floats that are counted from there. */
typedef struct scene_origin {
    uint32_t triangle_first; /* to where the next one begins */
    double   at_ws[3];
} scene_origin;

/* The parts that something is made of, whose triangles are seen in order. */
typedef struct part_span {
    uint32_t first, last, count;
} part_span;

/* Why triangles do not cast; the order is the order in which the rules are asked. */
typedef enum exclusion_rule {
    EXCLUDED_BY_INCLUDE,
    EXCLUDED_BY_EXCLUDE,
    EXCLUDED_BY_EXTRAS,
    EXCLUDED_AS_SKINNED,
    EXCLUDED_AS_HIDDEN, /* KHR_node_visibility; asked first */
    EXCLUDED_AS_BLEND   /* their material lets light through */
} exclusion_rule;
#define EXCLUSION_RULES "include|exclude|extras|skinned|hidden|blend" /* their words, in that order */

typedef struct scene_exclusion {
    exclusion_rule rule;
    const char    *pattern;   /* of EXCLUDED_BY_EXCLUDE: the choice's; else NULL */
    size_t         triangles; /* that this is the first rule to exclude */
    size_t         nodes;     /* of EXCLUDED_AS_HIDDEN: that are hidden, with those below them */
} scene_exclusion;

typedef struct scene {
    char *name; /* the glTF scene's name, "" when it has none; owned */

    size_t  vertex_count;
    double *positions_ws; /* [3 * vertex_count] as loaded, transformed in double; not welded */

    size_t    triangle_count;
    uint32_t *indices;        /* [3 * triangle_count] < vertex_count; counter-clockwise seen from outside */
    uint8_t  *triangle_flags; /* [triangle_count] TRIANGLE_* */

    size_t      part_count;
    scene_part *parts; /* in the order of their triangles, all of which they hold; none in a scene that came from no file */
    char       *names; /* each ended by 0, as the file has them */

    size_t        origin_count;
    scene_origin *origins; /* as parts; without any, positions are as fine as doubles */

    size_t           exclusion_count;
    scene_exclusion *exclusions; /* what was asked for, and what else left triangles out */

    size_t          image_count, alpha_mask_count;
    alpha_image    *images; /* only those that masks need */
    alpha_mask     *alpha_masks;
    size_t          holed_triangle_count;
    holed_triangle *holed_triangles; /* in the order of their triangles */

    size_t       light_count;
    scene_light *lights;
    size_t       lost_light_count;
    lost_light  *lost_lights; /* in the file's order, as lights are */

    size_t material_count;
    float (*material_colours)[3]; /* [material_count] linear base colours, for pictures; textures are not read, and count as grey */
    size_t shining_count;         /* materials that shine, which are no lights */

    size_t      area_count; /* of a choice with `areas` */
    scene_area *areas;      /* in the order of their triangles */
    size_t      dim_count;  /* triangles that should shine, and are no parallelogram of two */

    size_t  camera_count;
    double *camera_positions_ws; /* [3 * camera_count] */

    size_t      view_count;
    scene_view *views; /* of the same cameras, in the scene's order; none in a scene that came from no file */

    scene_smoke smoke; /* points and lines that dim light */
} scene;

typedef enum skinned_mode { SKINNED_EXCLUDE, SKINNED_REST } skinned_mode;
#define SKINNED_CHOICES "exclude|rest" /* their words, in that order */

/* What is baked of materials of alphaMode BLEND: a wall where alpha is 0.5 or more; a wall; nothing, nor of KHR_materials_transmission.
 * Where alpha is 0 everywhere it is nothing, where it is 1 everywhere a wall. */
typedef enum blend_choice { BLEND_MASK, BLEND_OPAQUE, BLEND_EXCLUDE } blend_choice;
#define BLEND_CHOICES "mask|opaque|exclude" /* their words, in that order */

/* Which scene of a file, and what of it casts. A pattern names nodes, meshes or materials of the scene by their names, with the wildcards of
 * a shell, or by their numbers ("#12"): one kind after "node:", "mesh:" or "material:", else all three. A node stands for all below
 * it. What an exclude names does not cast; with an include, nor does what none names. */
typedef struct scene_choice {
    const char *name; /* of the scene, or its index; NULL: the file's default scene, else scene 0, else all root nodes */
    text_list   exclude, include;
    int         skinned, skinned_given; /* skinned_mode; when it was asked for, that is no reason for a warning */
    int         blend, blend_given;     /* blend_choice; the same */
    int         areas;                  /* 1: what shines is read, too, with its pictures */
    int         allow_outside;          /* 1: buffers and images may lie outside of the scene's folder */
} scene_choice;

/* Read a .gltf or .glb file with tinygltf (glTF 2.0): node hierarchy, sparse accessors, strips and fans, lights of
 * KHR_lights_punctual, points and lines that are smoke (docs/smoke.md, "In a scene file"). Skinned meshes are excluded, morph targets taken at their
 * default weights, other points and lines skipped; each with a warning.
 * choice  NULL: the file's default scene, and all of it but skinned meshes
 * s       [out] zeroed on failure; released with scene_free. Borrows patterns from the choice.
 * A mirrored node (negative determinant) has its winding turned back, so that outside stays outside.
 * Returns VXS_OK, VXS_E_READ, VXS_E_SCENE, VXS_E_UNSUPPORTED (an unknown required extension), VXS_E_ARGUMENT (no such
 * scene, a pattern that names nothing of it), VXS_E_MEMORY, VXS_E_STRICT. A scene without triangles is not an error here. */
vxs_result scene_load_gltf(scene *s, const char *path, const scene_choice *choice, message *m);

/* Asked once when the name, the lights and the cameras of a scene are known and before a triangle is placed, which may take long: what
 * it returns ends the loading unless it is VXS_OK. What it borrows from s stays where it is until scene_free. */
typedef struct scene_check {
    vxs_result (*check)(void *user, const scene *s, message *m);
    void *user;
} scene_check;

/* The same, and what the check returns.   check  NULL: none */
vxs_result scene_load_gltf_checked(scene *s, const char *path, const scene_choice *choice, const scene_check *check, message *m);

/* Check alone, for a scene that others will read, that no file that it refers to is an output of this run, as scene_load_gltf does first.
 * Returns VXS_OK, VXS_E_READ, VXS_E_SCENE, VXS_E_ARGUMENT, VXS_E_MEMORY. */
vxs_result scene_check_files_gltf(const char *path, message *m);

/* Read the bytes of a .gltf or .glb file alike: its default scene; buffers and images in other files are an error. `name` stands
 * for the file in messages. */
vxs_result scene_load_gltf_memory(scene *s, const void *bytes, size_t size_bytes, const char *name, message *m);

void scene_free(scene *s);

/* What a light owns. */
void scene_light_free(scene_light *l);

/* The part that a triangle belongs to. `part` is that of a triangle before, 0 at first. */
static inline uint32_t scene_part_at(const scene *s, uint32_t part, size_t triangle)
{
    while (part + 1 < s->part_count && s->parts[part + 1].triangle_first <= triangle) part++;
    return part;
}

/* Count a triangle's part. */
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

/* 1 when a point is in the light's cone and range (no shadow is asked about); directional: always. */
int light_reaches(const light_shape *light, const double point_ws[3]);

/* 1 when some of a ball is. */
int light_reaches_ball(const light_shape *light, const double middle_ws[3], double radius_m);

#ifdef __cplusplus
}
#endif
#endif
