/* Pictures of scenes in the shadows of baked lights.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef PICTURE_H
#define PICTURE_H

#include <stdint.h>

#include "baker/lab/picture/fog.h"
#include "baker/lab/truth/camera.h"
#include "baker/lab/truth/truth.h"
#include "formats/vxs_file.h"

typedef struct picture_options {
    uint32_t          width_px, height_px;
    vxs_filter        filter; /* of lookups, as for vxs_lookup */
    uint32_t          threads;
    camera_pose       camera; /* eye and target are different, and their direction is not vertical within rounding */
    const fog_medium *fog;    /* replaces haze, and punctual lights in it; NULL: none */
} picture_options;

/* Render: shadows by lookups, all else (surfaces, light from the sky) by rays. Without directional lights it is night, and the
 * light of spot and point lights is seen in the air, too.
 * rgb     [out] [3 * width * height] sRGB, top row first.   The same at any thread count.
 * linear  [out] as many floats, before tone mapping; NULL: not wanted
 * lights  [light_count]
 * Returns VXS_OK or VXS_E_MEMORY. */
vxs_result picture_render(uint8_t *rgb, float *linear, const picture_options *o, const truth *t, const casters *c,
                          const vxs_baked_light *const *lights, uint32_t light_count, run_context *m);

/* Limit on lights: each takes time in each pixel, and of hundreds of punctual lights most light a small area. */
enum { ASSET_PICTURE_LIGHTS = 6 };

/* Draw the asset's scene from above, all of it in view, in the light of the ASSET_PICTURE_LIGHTS lights with the largest shadows
 * in memory.
 * rgb   [out] [3 * width * height] sRGB, top row first
 * file  [size_bytes] the asset's
 * Returns VXS_OK, VXS_E_MEMORY, or the error of an invalid asset or invalid casters. */
vxs_result asset_picture(uint8_t *rgb, uint32_t width_px, uint32_t height_px, const casters *c, const void *file, size_t size_bytes,
                         uint32_t threads, run_context *m);

#endif
