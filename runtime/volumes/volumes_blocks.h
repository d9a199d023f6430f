/* Uniform blocks, as in shaders (std140). Not installed.
 * SPDX-License-Identifier: MIT */
#ifndef VOLUMES_BLOCKS_H
#define VOLUMES_BLOCKS_H

#include "vxs_volumes.h"

/* The frame and its light: frame.glsl. */
typedef struct frame_block {
    float               point_from_depth[16];
    float               eye[3], far_metres;
    float               wide_px, high_px, empty_depth, top_metres;
    float               scattering[3], anisotropy;
    float               extinction[3], two; /* `two` is 2, unknown to the shader compiler */
    float               ambient[3], reserved_1;
    float               colour[3], radius_metres;
    float               place[3], cos_inner;
    float               axis[4];
    vxs_light_constants light;
    uint32_t            map_side_px, map_layers, reserved_2[2];
    vxs_pixels          pixels;
} frame_block;

/* A map of transmittance curves: curves.glsl. */
typedef struct curve_block {
    uint32_t capsules, segment_room, flags, side_px;
    uint32_t layers, nodes, opaque_side_px;
    int32_t  lookup;
} curve_block;

/* baked_number  of the light whose baked smoke dims it; 0: none */
typedef struct march_block {
    uint32_t steps, first, end, baked_number;
} march_block;

typedef struct intervals_block {
    uint32_t piece;
} intervals_block;

typedef struct map_fill_block {
    uint32_t first, end;
} map_fill_block;

typedef struct or_scan_block {
    uint32_t texels, segments, first, step;
} or_scan_block;

typedef struct voxelize_block {
    float    axes_from_place[16]; /* from positions of casters to coordinates along the axis, `ahead` and `side` */
    uint32_t triangles, first_word, place_words, is_indexed;
    uint32_t first_triangle;
    int32_t  columns;
} voxelize_block;

/* low to error_scale, and the box, as in vxs_mesh_shape. */
typedef struct mesh_block {
    float    clip_from_ls[16], eye_from_ls[16]; /* for positions relative to the eye */
    float    low, high, texel, turn;            /* turn: 1 or -1, orientation of the lit volume in the view */
    float    least, reach, error_scale, error_texels;
    int32_t  first, last, level;
    uint32_t triangles_most;
    float    box_low[3];
    int32_t  first_place; /* of a mesh made in C: the word of its buffer where positions begin */
    float    box_high[4];
} mesh_block;

/* Area lights: area_pass.glsl. */
typedef struct area_block {
    uint32_t vpls, vpl, side_px, first_word;
    uint32_t points, is_whole, levels, gather;
    uint32_t wide_px, high_px, layer, is_added;
    int32_t  runs;
    uint32_t between_rows;
    float    point_wide, gap_wide, points_apart;
} area_block;

typedef struct upsample_block {
    uint32_t wide_px, high_px; /* of half the size */
} upsample_block;

typedef struct places_block {
    uint32_t count, first;
} places_block;

/* The block of the technique that runs; a technique sets all of its own. */
enum { OWN_WORDS = 64 };
typedef union own_block {
    march_block     march;
    intervals_block intervals;
    map_fill_block  map_fill;
    or_scan_block   or_scan;
    voxelize_block  voxelize;
    mesh_block      mesh;
    area_block      area;
    places_block    places;
    upsample_block  upsample;
    float           words[OWN_WORDS];
} own_block;

#endif
