/* Pixels as PNG; see png_encode.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/files/png_encode.h"

#include <png.h>
#include <stdlib.h>

uint8_t *png_encode(const uint8_t *pixels, uint32_t width_px, uint32_t height_px, uint32_t channels, size_t *size_bytes)
{
    png_image image = {.version = PNG_IMAGE_VERSION,
                       .width   = width_px,
                       .height  = height_px,
                       .format  = channels == 4 ? PNG_FORMAT_RGBA : PNG_FORMAT_RGB};
    size_t    room  = PNG_IMAGE_PNG_SIZE_MAX(image);
    uint8_t  *png   = malloc(room);
    if (!png) return NULL;
    if (!png_image_write_to_memory(&image, png, &room, 0, pixels, 0, NULL)) {
        free(png);
        return NULL;
    }
    *size_bytes = room;
    return png;
}
