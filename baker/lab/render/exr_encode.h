/* Floats as OpenEXR.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef EXR_ENCODE_H
#define EXR_ENCODE_H

#include <stddef.h>
#include <stdint.h>

/* pixels      [strlen(channels) * width * height] channels of a pixel side by side, top row first
 * channels    a name of one letter for each, at most 4, no two alike: "RGB", "XYZ", "Y", "Z"; one that is '.' is left out
 * white       cd/m2 of a value of 1, which the file states as whiteLuminance; 0: it states none
 * size_bytes  [out]
 * Returns the file's bytes, released with free(); NULL without memory. The same pixels give the same bytes, by the same OpenEXR
 * and zlib. */
uint8_t *exr_encode(const float *pixels, uint32_t width_px, uint32_t height_px, const char *channels, float white,
                    size_t *size_bytes);

#endif
