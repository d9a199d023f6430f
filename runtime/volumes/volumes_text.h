/* Texts of shaders, and which texts each follows. The Makefile generates them from the files of these names: a line
 * #include "NAME" of another text becomes an entry of `needs`. Not installed.
 * SPDX-License-Identifier: MIT */
#ifndef VOLUMES_TEXT_H
#define VOLUMES_TEXT_H

typedef struct volumes_text {
    const char                       *text;
    const struct volumes_text *const *needs; /* ends with NULL */
} volumes_text;

/* The texts that C names: bodies of programs, and texts that a program has in addition to those its body needs. */
extern const volumes_text vxs_volumes_text_area_map_glsl, vxs_volumes_text_area_curves_glsl, vxs_volumes_text_area_exact_glsl,
    vxs_volumes_text_area_gather_glsl, vxs_volumes_text_area_grids_glsl, vxs_volumes_text_area_pull_push_glsl,
    vxs_volumes_text_area_show_glsl, vxs_volumes_text_area_splat_glsl, vxs_volumes_text_composite_frag_glsl,
    vxs_volumes_text_curves_glsl, vxs_volumes_text_frame_glsl, vxs_volumes_text_grid_fill_glsl, vxs_volumes_text_grid_light_glsl,
    vxs_volumes_text_half_depths_glsl, vxs_volumes_text_intervals_glsl, vxs_volumes_text_map_fill_glsl,
    vxs_volumes_text_map_join_glsl, vxs_volumes_text_march_glsl, vxs_volumes_text_mesh_frag_glsl, vxs_volumes_text_mesh_list_glsl,
    vxs_volumes_text_mesh_balance_glsl, vxs_volumes_text_mesh_split_glsl, vxs_volumes_text_mesh_vert_glsl,
    vxs_volumes_text_mesh_whole_glsl, vxs_volumes_text_or_scan_glsl, vxs_volumes_text_screen_vert_glsl,
    vxs_volumes_text_transmittance_build_glsl, vxs_volumes_text_transmittance_capture_glsl,
    vxs_volumes_text_transmittance_light_glsl, vxs_volumes_text_transmittance_lists_glsl, vxs_volumes_text_transmittance_pass_glsl,
    vxs_volumes_text_transmittance_places_glsl, vxs_volumes_text_transmittance_segments_glsl,
    vxs_volumes_text_transmittance_stream_glsl, vxs_volumes_text_upsample_glsl, vxs_volumes_text_voxelize_glsl,
    vxs_volumes_text_vxs_depths_h, vxs_volumes_text_vxs_intervals_h;

#endif
