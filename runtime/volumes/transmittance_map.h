/* The object of vxs_transmittance.h, for its passes and for curves of other kinds that are made of the same lists. Not installed.
 * SPDX-License-Identifier: MIT */
#ifndef TRANSMITTANCE_MAP_H
#define TRANSMITTANCE_MAP_H

#include "volumes_state.h"
#include "vxs_transmittance.h"

struct vxs_transmittance_map {
    vxs_volumes        *volumes;
    vxs_light_constants constants; /* of a light that is not baked */
    uint32_t            baked, is_baked, side_px, layers, nodes, capsule_room, segment_room, is_sorted;
    gl_name             buffer, capsules, view;  /* view: what shaders that draw segments are told; 0 without lists */
    gl_name             capture, build, look_up; /* programs of the volumes; without lists, capture is 0 */
    char                binding_text[48];
};

/* What programs of maps need beside the texts that all have: lines of #define. */
enum { TRANSMITTANCE_NAMES = 96 };
void vxs_transmittance_names(const vxs_transmittance_map *map, char names[TRANSMITTANCE_NAMES]);

/* What a description may say. */
int vxs_transmittance_is_size(uint32_t side_px, uint32_t nodes, uint32_t capsules);

/* The buffers of a map whose numbers are set, and without them.   Returns VXS_OK; VXS_E_GL for more than the context holds; VXS_E_MEMORY. */
vxs_result vxs_transmittance_take(vxs_transmittance_map *map);
void       vxs_transmittance_give_back(vxs_transmittance_map *map);

/* The map and its light, for shaders (curves.glsl).   opaque  NULL: none */
void vxs_transmittance_set(const vxs_transmittance_map *map, const vxs_shadow_depth_map *opaque, uint32_t capsule_count);

/* For programs that read curves of any map (curves.glsl), beside the light. */
void vxs_transmittance_set_reader(const vxs_transmittance_map *map, vxs_curve_lookup how);

/* Whether a light's smoke can be asked: it is a map of the light, in the same object. */
int vxs_transmittance_is_of(const vxs_transmittance_map *map, const vxs_volumes *volumes, const vxs_volumes_light *light);

/* Capture the segments of capsules anew, where there are lists. Between vxs_volumes_keep_storage and vxs_volumes_put_back_storage. */
void vxs_transmittance_capture(const vxs_transmittance_map *map, const vxs_capsules *capsules, const vxs_shadow_depth_map *opaque);

/* The buffer of a map's view.   Returns 0 where there is no room */
gl_name vxs_transmittance_view(const vxs_volumes *volumes);

/* Let the caller's shaders add segments: lists and view are bound until it returns. */
void vxs_transmittance_draw(const vxs_transmittance_map *map, const vxs_light_constants *light, void (*draw)(void *user),
                            void *user);

/* Run a program of 8 x 8 texels a group, on all texels. */
void vxs_transmittance_run(const vxs_transmittance_map *map, gl_name program, const vxs_shadow_depth_map *opaque);

/* Run a program on the frame's pixels, which writes to a texture.   other  a storage buffer beside the map's; 0: none */
void vxs_transmittance_pass(const vxs_transmittance_map *map, gl_name program, gl_name other, gl_name texture);

#endif
