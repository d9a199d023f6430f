/* Encode pixels as PNG; dither to 8 bits.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef PNG_ENCODE_H
#define PNG_ENCODE_H

#include <stddef.h>
#include <stdint.h>

/* pixels      [channels * width * height] sRGB, top row first
 * channels    3: RGB; 4: RGBA with straight alpha
 * size_bytes  [out]
 * Returns the bytes of the file, released with free(); NULL without memory. With the same versions of libpng and zlib, the same
 * pixels give the same bytes. */
uint8_t *png_encode(const uint8_t *pixels, uint32_t width_px, uint32_t height_px, uint32_t channels, size_t *size_bytes);

/* Quantize a value in [0, 1] to 8 bits with ordered dithering, so that dark gradients show no bands and averages are preserved. A
 * value between two steps is rounded up in a share of the pixels equal to its fraction. The thresholds form a lattice whose
 * neighbours differ as much as possible (multiples of the powers of the inverse plastic number). They are the same in each run.
 * Values that are exact steps do not change. */
static inline uint8_t png_dithered(double value, uint32_t x, uint32_t y)
{
    double threshold = ((x * 3242174889U + y * 2447445414U) >> 8) / 16777216.0, held = value > 0 ? value < 1 ? value : 1 : 0;
    return (uint8_t)(255 * held + threshold + 0.5 / 16777216);
}

#endif
