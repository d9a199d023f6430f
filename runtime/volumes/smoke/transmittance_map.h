/* The object of vxs_transmittance.h, for its passes and for other kinds of curves built from the same lists. Not installed.
 * SPDX-License-Identifier: MIT */
#ifndef TRANSMITTANCE_MAP_H
#define TRANSMITTANCE_MAP_H

#include "volumes_state.h"
#include "vxs_transmittance.h"

struct vxs_transmittance_map {
    vxs_volumes        *volumes;
    vxs_light_constants constants; /* of a light that is not baked */
    uint32_t            baked, is_baked, side_px, layers, nodes, capsule_room, segment_room, is_sorted;
    gl_name             buffer, capsules, view; /* view: data for shaders that draw segments; 0 without lists */
    const char         *names;                  /* lines of #define of the program that builds the curves */
    const volumes_text *layers_text;            /* functions of its layers: transmittance_light.glsl or area_curves.glsl */
    char                binding_text[48];
};

/* Lines of #define for programs that read curves of any map. */
#define VXS_SMOKE_NAMES "#define VXS_READS_CURVES\n"

/* A program for curves with as many nodes as the map's; after more lines of #define. */
gl_name vxs_transmittance_program(const vxs_transmittance_map *map, const char *names, const volumes_text *body);

/* The program that builds a map's curves. */
gl_name vxs_transmittance_builder(const vxs_transmittance_map *map);

/* Whether the sizes in a description are valid. */
int vxs_transmittance_is_size(uint32_t side_px, uint32_t nodes, uint32_t capsules);

/* Allocate the buffers of a map whose numbers are set.   Returns VXS_OK; VXS_E_GL for more than the context supports;
 * VXS_E_MEMORY. */
vxs_result vxs_transmittance_alloc(vxs_transmittance_map *map);
void       vxs_transmittance_free(vxs_transmittance_map *map);

/* Set the map and its light for shaders (curves.glsl).   opaque  NULL: none */
void vxs_transmittance_set(const vxs_transmittance_map *map, const vxs_shadow_depth_map *opaque, uint32_t capsule_count);

/* Set the map for programs that read curves of any map (curves.glsl). The light is set elsewhere. */
void vxs_transmittance_set_reader(const vxs_transmittance_map *map, vxs_curve_lookup how);

/* Whether the map can be used as smoke of the light: it is a map of that light, in the same object. */
int vxs_transmittance_is_of(const vxs_transmittance_map *map, const vxs_volumes *volumes, const vxs_volumes_light *light);

/* If there are lists, capture the segments of capsules again. Call it between vxs_volumes_save_storage and
 * vxs_volumes_restore_storage. */
void vxs_transmittance_capture(const vxs_transmittance_map *map, const vxs_capsules *capsules, const vxs_shadow_depth_map *opaque);

/* The buffer of a map's view.   Returns 0 if there is no memory */
gl_name vxs_transmittance_view(const vxs_volumes *volumes);

/* Let the caller's shaders add segments; lists and view are bound during this call. */
void vxs_transmittance_draw(const vxs_transmittance_map *map, const vxs_light_constants *light, void (*draw)(void *user),
                            void *user);

/* Run a program on all texels, in groups of 8 x 8. */
void vxs_transmittance_run(const vxs_transmittance_map *map, gl_name program, const vxs_shadow_depth_map *opaque);

/* Run a program on the frame's pixels that writes to a texture.   other  a storage buffer in addition to the map's; 0: none */
void vxs_transmittance_pass(const vxs_transmittance_map *map, gl_name program, gl_name other, gl_name texture);

#endif
