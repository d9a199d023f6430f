/* A picture of all casters in the shadows of an asset.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef ASSET_PICTURE_H
#define ASSET_PICTURE_H

#include "baker/lab/picture/picture.h"

/* Limit on lights: each takes time in each pixel, and of hundreds of lamps most light a small area. */
enum { ASSET_PICTURE_LIGHTS = 6 };

/* Draw the asset's scene from above, all of it in view, in the light of the ASSET_PICTURE_LIGHTS lights with the largest shadows
 * in memory.
 * rgb   [out] [3 * width * height] sRGB, top row first
 * file  [size_bytes] the asset's
 * Returns VXS_OK, VXS_E_MEMORY, or the error of an invalid asset or invalid casters. */
vxs_result asset_picture(uint8_t *rgb, uint32_t width_px, uint32_t height_px, const casters *c, const void *file, size_t size_bytes,
                         uint32_t threads, message *m);

#endif
