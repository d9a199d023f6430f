/* Pixels as PNG.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef PNG_ENCODE_H
#define PNG_ENCODE_H

#include <stddef.h>
#include <stdint.h>

/* pixels      [channels * width * height] sRGB, top row first
 * channels    3: RGB; 4: RGBA, alpha not multiplied in
 * size_bytes  [out]
 * Returns the file's bytes, released with free(); NULL without memory. The same pixels give the same bytes, by the same libpng and zlib. */
uint8_t *png_encode(const uint8_t *pixels, uint32_t width_px, uint32_t height_px, uint32_t channels, size_t *size_bytes);

#endif
