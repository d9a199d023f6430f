/* libvxs_volumes: shadows of smoke, hair and dust, as adaptive volumetric shadow maps [AVSM10].
 *
 *     vxs_transmittance_map *map;                                       // when a level is loaded
 *     vxs_transmittance_desc desc = {.baked_number = vxs_baked_number(sun), .capsules = 10000, .segments = 1 << 20};
 *     if (vxs_transmittance_map_create(&map, air, &desc) != VXS_OK) ...
 *
 *     vxs_transmittance_map_build(map, &smoke, NULL);                   // each frame: the smoke of this frame
 *     vxs_volumes_begin(air, &frame);
 *     vxs_volumes_transmittance(air, map, texture, VXS_CURVE_LINES);    // how much light reaches the surface in each pixel
 *     light.smoke = map;
 *     vxs_volumes_march(air, &light, NULL, 64, VXS_STEPS_EVEN);         // and the airlight
 *
 * A map lies in the prism, frustum or cube of a light's maps. Each texel has a curve (vxs_curve.h): the transmittance along the
 * light ray through its centre. Depths are metres along the map's axis, for punctual lights from the light on. Casters are
 * capsules. A ray meets each capsule at most once, between an entry and an exit depth.
 *
 *     lists      First, all segments are captured in lists, one per texel. Then each texel sorts its segments by depth, at most
 *                2048, and builds its curve. Segments for which lists have no room are counted, and merged into one more segment
 *                per texel: from the smallest entry to the greatest exit, with the product of their transmittances. So no light
 *                leaks where there was no room.
 *     streaming  Without lists, only the curves need memory. A workgroup for each tile of 8 x 8 texels finds the capsules that may
 *                overlap the tile, in their order; an invocation for each texel inserts them. If capsules are given in order of
 *                distance from the light, they are inserted sorted.
 *
 * Context, state and positions are as in vxs_volumes.h.
 * Public.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_TRANSMITTANCE_H
#define VXS_TRANSMITTANCE_H

#include "vxs_capsule.h"
#include "vxs_volumes.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct vxs_transmittance_map vxs_transmittance_map;

/* Fields that are not set are 0, which means the default. New fields are added at the end only. */
typedef struct vxs_transmittance_desc {
    size_t                     struct_size;  /* sizeof(vxs_transmittance_desc); 0: the first version, which ends with unsorted */
    uint32_t                   baked_number; /* vxs_baked_number (vxs_volumes.h); not used with constants */
    const vxs_light_constants *constants;    /* for a light that is not baked; NULL: it is baked */
    uint32_t                   side_px;      /* texels per side; 0: 256; at most 8192 */
    uint32_t                   nodes;        /* per curve: 4, 8, 12, 16; 0: 8 */
    uint32_t                   capsules;     /* largest number of capsules, > 0; at most 2^24 */
    uint32_t                   segments;     /* capacity of the lists, 16 bytes each; 0: no lists, streaming */
    /* 1: segments are inserted in any order, which may change from frame to frame; 0: by depth */
    uint32_t                   unsorted;
} vxs_transmittance_desc;

/* Memory: one storage buffer of 16 bytes, 8 for each node of each texel, and with lists 16 for each texel and for each segment;
 * and another of 32 bytes for each capsule.
 * map  [out] NULL on failure
 * Returns VXS_OK; VXS_E_ARGUMENT; VXS_E_MEMORY; VXS_E_GL: more than the largest storage buffer of the context, or a shader does
 * not compile. */
vxs_result vxs_transmittance_map_create(vxs_transmittance_map **map, vxs_volumes *volumes, const vxs_transmittance_desc *desc);
void       vxs_transmittance_map_destroy(vxs_transmittance_map *map);

/* Capsules in memory of the caller, which are uploaded, or in a storage buffer. */
typedef struct vxs_capsules {
    const vxs_capsule *list;   /* [count] NULL: use the buffer */
    unsigned           buffer; /* a storage buffer of vxs_capsule */
    uint32_t           count;
} vxs_capsules;

/* Rebuild the curves.
 * opaque  shadow depth map of the same light: light ends where its shadow begins, and smoke behind that casts nothing. NULL: only
 * smoke
 *         casts; the shadow of static casters is in the asset, and a shader multiplies both. With `opaque`, light ends at the
 *         surface itself: use that for airlight, not for light on surfaces
 * Returns VXS_OK; VXS_E_ARGUMENT for more capsules than given to create, or for a map of another light. */
vxs_result vxs_transmittance_map_build(vxs_transmittance_map *map, const vxs_capsules *capsules,
                                       const vxs_shadow_depth_map *opaque);

/* Smoke of other shapes: shaders of the caller add segments to the lists while the map is built, in addition to those of capsules.
 *
 *     const char *text[VXS_SEGMENT_TEXTS + 2] = {"#version 450 core\n"};  // vertex, fragment or compute; no other library text
 *     vxs_transmittance_map_texts(map, text + 1);
 *     text[VXS_SEGMENT_TEXTS + 1] = my_body;
 *     ...
 *     // draws into a viewport of side_px x side_px, once for each layer
 *     vxs_transmittance_map_build_drawn(map, &smoke, NULL, draw_sprites, sprites);
 *
 * Bodies may call
 *
 *     ivec3 vxs_segment_texels()                             texels across, texels down, layers (one or six)
 *     vec4  vxs_segment_position(vec3 at, int layer)         gl_Position of a point: fragment (x, y) is texel (x, y)
 *     vec3  vxs_segment_ray(ivec3 texel, out vec3 from)      direction, of length 1, and origin of a texel's light ray
 *     void  vxs_add_segment(ivec3 texel, float entry, float exit, float left)   metres along that ray; transmittance, 0 to 1
 *
 * Add each segment once. To do so, cull one side of faces; do not use a depth test. The light's view is mirrored: with GL_BACK,
 * the sides that face away from the light remain, and a ball around a punctual light has such sides, too. The parts of a segment
 * before a punctual light or behind an opaque surface are cut off, as if its density was constant. A segment is ignored if its
 * texel does not exist, if a number is not valid, or if it takes no light. */
enum { VXS_SEGMENT_TEXTS = 5 };

/* texts  [out] NUL-terminated, valid until vxs_transmittance_map_destroy; they use two storage buffers, from the first binding
 *        of the volumes on
 * Returns VXS_OK; VXS_E_ARGUMENT for a map without lists. */
vxs_result vxs_transmittance_map_texts(const vxs_transmittance_map *map, const char *texts[VXS_SEGMENT_TEXTS]);

/* As vxs_transmittance_map_build.
 * draw  called once, with these two storage buffers bound; it must leave them bound and restore other state that it changes.
 *       NULL: nothing is drawn
 * Returns as vxs_transmittance_map_build, and VXS_E_ARGUMENT for a map without lists. */
vxs_result vxs_transmittance_map_build_drawn(vxs_transmittance_map *map, const vxs_capsules *capsules,
                                             const vxs_shadow_depth_map *opaque, void (*draw)(void *user), void *user);

typedef struct vxs_transmittance_counts {
    uint32_t segments; /* number of segments that light rays met */
    uint32_t merged;   /* segments that were merged because lists had no room */
    /* texels whose loops a driver ended before the end of their lists, as llvmpipe does after about 30 000 segments: light leaks
     * there */
    uint32_t cut_texels;
} vxs_transmittance_counts;

/* Counts of the last build; without lists only cut_texels. Waits for the graphics processor. */
vxs_transmittance_counts vxs_transmittance_map_counts(const vxs_transmittance_map *map);

/* The buffer: 16 bytes of counts, then the curves of all texels, stored as in vxs_curve.h, row by row, layer by layer. Valid
 * until vxs_transmittance_map_destroy. */
unsigned vxs_transmittance_map_buffer(const vxs_transmittance_map *map);

/* Interpolation between two nodes of a curve. */
typedef enum vxs_curve_lookup {
    VXS_CURVE_LINES,       /* linear */
    VXS_CURVE_EXPONENTIALS /* as through a medium of constant density */
} vxs_curve_lookup;

/* Transmittance between the light and the surface in each pixel of the frame, 0 to 1; 1 where there is no surface, and outside
 * the map. The result is interpolated bilinearly between the curves of four texels.
 * texture  GL_TEXTURE_2D of GL_R32F, no smaller than the view; written */
vxs_result vxs_volumes_transmittance(vxs_volumes *volumes, const vxs_transmittance_map *map, unsigned texture,
                                     vxs_curve_lookup how);

/* The same at given positions, such as particles or probes.
 * places  a storage buffer of float[4] each: a position in metres, and a number that is not read
 * left    a storage buffer of float: `count` of them, from index `first` on, are written */
vxs_result vxs_volumes_transmittance_at(vxs_volumes *volumes, const vxs_transmittance_map *map, unsigned places, uint32_t count,
                                        unsigned left, uint32_t first, vxs_curve_lookup how);

#ifdef __cplusplus
}
#endif
#endif
