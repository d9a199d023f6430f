/* A map of the sky from a file; see sky_map.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/render/sky_map.h"

#include <stdlib.h>

#include "baker/base/memory.h"
#include "baker/files/input_file.h"

enum { FILE_BYTES_MAX = 1 << 28 };

vxs_result sky_map_make(sky_map *map, const sky_file *file, uint32_t wide_px, uint32_t high_px, message *m)
{
    size_t count = 3 * (size_t)wide_px * high_px;
    if (!high_px || high_px != wide_px / 2 || wide_px % 2)
        return fail(m, VXS_E_UNSUPPORTED,
                    "'%s' has %u x %u pixels: expected twice as many across as down, an equirectangular map of all directions",
                    file->name, wide_px, high_px);
    if (high_px > SKY_HIGH_MAX)
        return fail(m, VXS_E_UNSUPPORTED, "'%s' has %u x %u pixels: expected at most %d x %d: make it smaller", file->name, wide_px,
                    high_px, 2 * SKY_HIGH_MAX, SKY_HIGH_MAX);
    vxs_result r = memory_check(2 * count * sizeof *map->radiance, m, "the sky of '%s', %u x %u pixels, here and in OpenGL, needs",
                                file->name, wide_px, high_px);
    if (r != VXS_OK) return r;
    *map = (sky_map){wide_px, high_px, malloc(count * sizeof *map->radiance)};
    return map->radiance ? VXS_OK : fail(m, VXS_E_MEMORY, "out of memory for the sky of '%s'", file->name);
}

static int is_black(const sky_map *map)
{
    for (size_t n = 0; n < 3 * (size_t)map->wide_px * map->high_px; n++)
        if (map->radiance[n] > 0) return 0;
    return 1;
}

static vxs_result read_picture(sky_map *map, const sky_file *file, message *m)
{
    vxs_result r;
    if (sky_is_radiance(file))
        r = sky_read_radiance(map, file, m);
    else if (sky_is_png(file))
        r = sky_read_png(map, file, m);
    else
        return fail(m, VXS_E_UNSUPPORTED, "'%s' is neither a Radiance picture (.hdr) nor a PNG: convert it to .hdr", file->name);
    if (r == VXS_OK && is_black(map)) return fail(m, VXS_E_SCENE, "'%s' is black: there is no light in it", file->name);
    return r;
}

/* Reads on only if the file begins as a supported picture. */
static uint64_t wanted_bytes(void *user, const uint8_t *first, size_t size_bytes)
{
    sky_file file = {user, first, first + size_bytes};
    return sky_is_radiance(&file) || sky_is_png(&file) ? UINT64_MAX : 0;
}

vxs_result sky_map_read(sky_map *map, const char *path, message *m)
{
    uint8_t *bytes  = NULL;
    size_t   size   = 0;
    *map            = (sky_map){0};
    input_head head = {wanted_bytes, (void *)input_name(path)};
    vxs_result r    = input_read(&bytes, &size, path, FILE_BYTES_MAX, &head, m);
    if (r == VXS_OK) r = read_picture(map, &(sky_file){input_name(path), bytes, bytes + size}, m);
    if (r != VXS_OK) sky_map_free(map);
    free(bytes);
    return r;
}

void sky_map_free(sky_map *map)
{
    free(map->radiance);
    *map = (sky_map){0};
}
