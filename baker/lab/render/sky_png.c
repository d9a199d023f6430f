/* A sky from a PNG, by libpng; see sky_map.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <png.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/srgb.h"
#include "baker/lab/render/sky_map.h"

int sky_is_png(const sky_file *file)
{
    static const char magic[8] = "\x89PNG\r\n\x1a\n";
    return file->end - file->bytes >= 8 && !memcmp(file->bytes, magic, sizeof magic);
}

/* Transparent pixels become black. */
static vxs_result decode(sky_map *map, png_image *image, const sky_file *file, message *m)
{
    png_color  black  = {0, 0, 0};
    size_t     count  = 3 * (size_t)map->wide_px * map->high_px;
    uint8_t   *pixels = malloc(count);
    float      light[256];
    vxs_result r  = pixels ? VXS_OK : fail(m, VXS_E_MEMORY, "out of memory for the sky of '%s'", file->name);
    image->format = PNG_FORMAT_RGB;
    if (r == VXS_OK && !png_image_finish_read(image, &black, pixels, 0, NULL))
        r = fail(m, VXS_E_CORRUPT, "'%s' is a broken PNG: %s", file->name, image->message);
    for (int n = 0; n < 256; n++) light[n] = srgb_light((uint8_t)n);
    for (size_t n = 0; n < count && r == VXS_OK; n++) map->radiance[n] = light[pixels[n]];
    free(pixels);
    return r;
}

vxs_result sky_read_png(sky_map *map, const sky_file *file, message *m)
{
    png_image  image = {.version = PNG_IMAGE_VERSION};
    vxs_result r     = VXS_OK;
    if (!png_image_begin_read_from_memory(&image, file->bytes, (size_t)(file->end - file->bytes)))
        r = fail(m, VXS_E_CORRUPT, "'%s' is a broken PNG: %s", file->name, image.message);
    if (r == VXS_OK) r = sky_map_make(map, file, image.width, image.height, m);
    if (r == VXS_OK) r = decode(map, &image, file, m);
    png_image_free(&image);
    return r;
}
