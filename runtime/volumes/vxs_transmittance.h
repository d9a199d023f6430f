/* libvxs_volumes: shadows of smoke, hair and dust, as adaptive volumetric shadow maps [AVSM10].
 *
 *     vxs_transmittance_map *map;                                       // when a level is loaded
 *     vxs_transmittance_desc desc = {.baked = sun, .capsules = 10000, .segments = 1 << 20};
 *     if (vxs_transmittance_map_create(&map, air, &desc) != VXS_OK) ...
 *
 *     vxs_transmittance_map_build(map, &smoke, NULL);                   // each frame: what the light meets now
 *     vxs_volumes_begin(air, &frame);
 *     vxs_volumes_transmittance(air, map, texture, VXS_CURVE_LINES);    // how much of it reaches what each pixel sees
 *     light.smoke = map;
 *     vxs_volumes_march(air, &light, NULL, 64, VXS_STEPS_EVEN);         // and what it scatters on its way
 *
 * A map lies in the prism, frustum or cube of a light's maps. Each texel has a curve (vxs_curve.h) of how much light is left along the light ray
 * through its centre. Depths are metres along the map's axis, of a lamp from it on. What casts are capsules; each is met by a ray once, between entry and
 * exit.
 *
 *     lists      All segments are captured first, in lists by texel; then each texel sorts its own by depth, 2048 at most, and makes its curve of them. What lists have no
 *                room for is counted, and merged into one more segment a texel: from the least entry to the greatest exit, with the product of
 *                what all of them let through. So no light comes through where there was no room.
 *     streaming  With no room for lists, memory is that of the curves: a workgroup for each tile of 8 x 8 texels finds the capsules that it may see, in their
 *                order, and an invocation for each texel inserts them. Capsules that are given from the light on are inserted sorted.
 *
 * All else is as in vxs_volumes.h: context, state, places.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_TRANSMITTANCE_H
#define VXS_TRANSMITTANCE_H

#include "vxs_capsule.h"
#include "vxs_volumes.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct vxs_transmittance_map vxs_transmittance_map;

/* What is not named is 0, and means the default. It grows at its end only. */
typedef struct vxs_transmittance_desc {
    size_t                     struct_size; /* sizeof(vxs_transmittance_desc); 0: as it was at first, up to unsorted */
    uint32_t                   baked;       /* the light's number in vxs_gl; without constants */
    const vxs_light_constants *constants;   /* of a light that is not baked; NULL: it is */
    uint32_t                   side_px;     /* texels a side; 0: 256; 8192 at most */
    uint32_t                   nodes;       /* of each curve: 4, 8, 12, 16; 0: 8 */
    uint32_t                   capsules;    /* how many there may be, > 0; 2^24 at most */
    uint32_t                   segments;    /* how many lists have room for, 16 bytes each; 0: none, streaming */
    uint32_t                   unsorted;    /* 1: lists are taken in any order, which may change from frame to frame; 0: by depth */
} vxs_transmittance_desc;

/* One storage buffer: 16 bytes, 8 for each node of each texel, and with lists 16 for each texel and for each segment; and one for capsules, 32 bytes each.
 * map  [out] NULL on failure
 * Returns VXS_OK; VXS_E_ARGUMENT; VXS_E_MEMORY; VXS_E_GL: more than a storage buffer of the context holds, or a shader that does not compile. */
vxs_result vxs_transmittance_map_create(vxs_transmittance_map **map, vxs_volumes *volumes, const vxs_transmittance_desc *desc);
void       vxs_transmittance_map_destroy(vxs_transmittance_map *map);

/* Capsules of the caller's memory, which are uploaded, or of a storage buffer. */
typedef struct vxs_capsules {
    const vxs_capsule *list;   /* [count] NULL: those of the buffer */
    unsigned           buffer; /* of vxs_capsule */
    uint32_t           count;
} vxs_capsules;

/* Make the curves anew.
 * opaque  where shadow begins, of the same light: light ends there, and what lies behind casts nothing. NULL: only smoke casts; what stands is in the asset's
 *         shadow, which a shader multiplies. With it a surface itself is where light ends: it is for what is in the air, not for what surfaces receive
 * Returns VXS_OK; VXS_E_ARGUMENT for more capsules than create was told, or for another light's map. */
vxs_result vxs_transmittance_map_build(vxs_transmittance_map *map, const vxs_capsules *capsules, const vxs_shadow_depth_map *opaque);

/* Smoke of other shapes: shaders of the caller's own add segments to the lists while the map is built, beside those of capsules.
 *
 *     const char *text[VXS_SEGMENT_TEXTS + 2] = {"#version 450 core\n"};           // vertex, fragment or compute; needs no other text of the libraries
 *     vxs_transmittance_map_texts(map, text + 1);
 *     text[VXS_SEGMENT_TEXTS + 1] = my_body;
 *     ...
 *     vxs_transmittance_map_build_drawn(map, &smoke, NULL, draw_sprites, sprites);  // draws into a viewport of side_px x side_px, for each layer once
 *
 * Bodies may call
 *
 *     ivec3 vxs_segment_texels()                                    texels across, down, and layers, one or six
 *     vec4  vxs_segment_position(vec3 at, int layer)                gl_Position of a place: fragment (x, y) is texel (x, y) of the layer
 *     vec3  vxs_segment_ray(ivec3 texel, out vec3 from)             the light ray through a texel's centre: its way, of length 1, and where it begins
 *     void  vxs_add_segment(ivec3 texel, float entry, float exit, float left)   metres along that ray; what it lets through, 0 to 1
 *
 * Each segment is to be added once: one side of faces is culled (the light's view is mirrored: with GL_BACK the sides that look
 * away from the light stay, of which a ball about a lamp has some), and there is no test of depth. What lies before a lamp, or behind what is opaque, is cut off as if the
 * segment was evenly dense. What is of texels that are not there, of numbers that are none, or takes nothing, is left out. */
enum { VXS_SEGMENT_TEXTS = 5 };

/* texts  [out] NUL-terminated, valid until vxs_transmittance_map_destroy; they use two storage buffers, from the volumes' first binding on
 * Returns VXS_OK; VXS_E_ARGUMENT of a map without lists. */
vxs_result vxs_transmittance_map_texts(const vxs_transmittance_map *map, const char *texts[VXS_SEGMENT_TEXTS]);

/* As vxs_transmittance_map_build.
 * draw  called once, with those two storage buffers bound; it leaves them bound. State that it changes, it puts back. NULL: nothing is drawn
 * Returns as that, and VXS_E_ARGUMENT for a map without lists. */
vxs_result vxs_transmittance_map_build_drawn(vxs_transmittance_map *map, const vxs_capsules *capsules, const vxs_shadow_depth_map *opaque,
                                             void (*draw)(void *user), void *user);

typedef struct vxs_transmittance_counts {
    uint32_t segments; /* that were met */
    uint32_t merged;   /* of them, because lists had no room */
    uint32_t
        cut_texels; /* a driver ended the loops of so many texels before their lists' end, as llvmpipe does behind some 30 000 segments: light
                            comes through there */
} vxs_transmittance_counts;

/* Of the last build; without lists only cut_texels. Waits for the graphics processor. */
vxs_transmittance_counts vxs_transmittance_map_counts(const vxs_transmittance_map *map);

/* The buffer: 16 bytes of counts; from there on, as vxs_curve.h stores them, the curves of all texels, row by row, layer by layer. Valid until
 * vxs_transmittance_map_destroy. */
unsigned vxs_transmittance_map_buffer(const vxs_transmittance_map *map);

/* What a curve is between two nodes. */
typedef enum vxs_curve_lookup {
    VXS_CURVE_LINES,       /* a line */
    VXS_CURVE_EXPONENTIALS /* as through a medium of even density */
} vxs_curve_lookup;

/* How much of the light reaches what each pixel of the frame sees, 0 to 1; 1 where it sees nothing, and outside the map. Four curves are asked, and what they
 * say is weighed by where the place lies between texels.
 * texture  GL_TEXTURE_2D of GL_R32F, no smaller than the view; written */
vxs_result vxs_volumes_transmittance(vxs_volumes *volumes, const vxs_transmittance_map *map, unsigned texture,
                                     vxs_curve_lookup how);

/* The same at places that are not seen: of particles, of probes.
 * places  a storage buffer of float[4] each: metres as all places, and a number that is not read
 * left    another, of float: `count` of them, from number `first` on, are written */
vxs_result vxs_volumes_transmittance_at(vxs_volumes *volumes, const vxs_transmittance_map *map, unsigned places, uint32_t count,
                                        unsigned left, uint32_t first, vxs_curve_lookup how);

#ifdef __cplusplus
}
#endif
#endif
