/* Pixels as PNG, and the 8 bits of a screen.
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

/* One of 255 steps for a value from 0 to 1, by ordered dither: a value between two steps becomes the higher one in as many pixels as it is nearer to it, so
 * that dark gradients have no bands, and the mean of some pixels is that of the values. The thresholds are a lattice whose neighbours are as unlike as can be
 * (multiples of the powers of the inverse plastic number), the same in each run. A value that is a step stays as it is. */
static inline uint8_t png_dithered(double value, uint32_t x, uint32_t y)
{
    double threshold = ((x * 3242174889U + y * 2447445414U) >> 8) / 16777216.0, held = value > 0 ? value < 1 ? value : 1 : 0;
    return (uint8_t)(255 * held + threshold + 0.5 / 16777216);
}

#endif
