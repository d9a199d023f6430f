/* What a picture of the scene queries: for each pixel the voxel of what it sees, as a renderer looks it up.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef RIVAL_SCREEN_H
#define RIVAL_SCREEN_H

#include "baker/lab/truth/camera.h"
#include "tests/bench/rival.h"

typedef struct screen {
    const rival_maps *maps;
    camera_pose       camera;
    camera_view       view;
    uint32_t          width_px, height_px;
    truth            *rays;
} screen;

/* out  [out] borrows the maps until screen_close.   Returns VXS_OK, or what truth_create says. */
vxs_result screen_open(screen *out, const rival_maps *maps, const camera_pose *camera, uint32_t width_px, uint32_t height_px,
                       run_context *m);

/* The voxel of what pixel (x, y) sees, moved off its surface for a filter of that width as in runtime/vxs.h. Returns 0 where a
 * renderer looks nothing up: the pixel sees nothing, or what lies beside the map or in front of it. */
int screen_voxel(const screen *s, uint32_t x, uint32_t y, vxs_filter filter, voxel_at *at);

/* The same of all pixels that have one, in tiles of 8 x 8 pixels, as shaders take them.
 * at  [width_px * height_px] [out].   Returns how many. */
size_t screen_voxels(const screen *s, vxs_filter filter, voxel_at *at);

/* Accepts a zeroed object. */
void screen_close(screen *s);

#endif
