/* Floats as OpenEXR.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef EXR_ENCODE_H
#define EXR_ENCODE_H

#include <stddef.h>
#include <stdint.h>

/* pixels      [strlen(channels) * width * height] channels of a pixel side by side, top row first
 * channels    one letter for each channel, at most 4, all different: "RGB", "XYZ", "Y", "Z"; a channel named '.' is not written
 * white       luminance of value 1 in cd/m2, written as whiteLuminance; 0: not written
 * size_bytes  [out]
 * Returns the file's bytes, released with free(); NULL when out of memory. With the same OpenEXR and zlib, the same pixels give
 * the same bytes. */
uint8_t *exr_encode(const float *pixels, uint32_t width_px, uint32_t height_px, const char *channels, float white,
                    size_t *size_bytes);

#endif
