/* Opening and closing assets; see vxs.h.
 * SPDX-License-Identifier: MIT */
#include <string.h>

#include "platform.h"
#include "vxs.h"
#include "vxs_desc.h"
#include "vxs_reader.h"

struct vxs_asset {
    vxs_contents  contents;
    vxs_extras    extras;
    vxs_allocator allocator;
};

vxs_result vxs_asset_open(vxs_asset **asset, const void *bytes, size_t size_bytes, const vxs_read_desc *desc)
{
    *asset              = NULL;
    vxs_read_desc known = {0};
    vxs_result    r     = vxs_read_desc_take(&known, desc);
    if (r != VXS_OK) return r;
    vxs_allocator memory = vxs_allocator_of(&known);
    vxs_asset    *a      = memory.alloc(sizeof *a, memory.user);
    if (!a) return VXS_E_MEMORY;
    memset(a, 0, sizeof *a);
    a->allocator = memory;
    r            = vxs_read_extras(&a->contents, &a->extras, bytes, size_bytes, &known, 0);
    if (r != VXS_OK) {
        memory.free(a, sizeof *a, memory.user);
        return r;
    }
    *asset = a;
    return VXS_OK;
}

vxs_result vxs_asset_open_file(vxs_asset **asset, const char *path, const vxs_read_desc *desc)
{
    os_file file;
    *asset             = NULL;
    vxs_read_desc rest = {0};
    vxs_result    r    = vxs_read_desc_take(&rest, desc);
    if (r != VXS_OK) return r;
    if (!path) return VXS_E_ARGUMENT;
    if ((r = os_file_open(&file, path)) != VXS_OK) return r;

    vxs_allocator memory = vxs_allocator_of(&rest);
    uint8_t      *bytes = NULL, header[VXS_HEADER_BYTES] = {0};
    uint64_t      size = file.size_bytes, limit = vxs_memory_limit_of(&rest, size);

    /* check the header, including the file size in it, before the rest is read */
    vxs_reader head = {.bytes = header, .size = size, .desc = rest};
    r               = VXS_E_READ;
    if (!os_file_read(&file, 0, size < sizeof header ? size : sizeof header, header)) goto done;
    vxs_read_header(&head);
    if ((r = head.result) != VXS_OK) goto done;
    r = VXS_E_MEMORY;
    if (size >= limit || size > SIZE_MAX) goto done;
    rest.memory_limit_bytes = limit - size;
    bytes                   = memory.alloc(size ? (size_t)size : 1, memory.user);
    if (!bytes) goto done;
    r = os_file_read(&file, 0, size, bytes) ? vxs_asset_open(asset, bytes, (size_t)size, &rest) : VXS_E_READ;
    memory.free(bytes, size ? (size_t)size : 1, memory.user);
done:
    os_file_close(&file);
    return r;
}

void vxs_asset_close(vxs_asset *asset)
{
    if (!asset) return;
    vxs_allocator memory = asset->allocator;
    vxs_extras_free(&asset->extras, asset->contents.light_count, &memory);
    vxs_contents_free(&asset->contents);
    memory.free(asset, sizeof *asset, memory.user);
}

uint32_t vxs_asset_light_count(const vxs_asset *asset)
{
    return asset->contents.light_count;
}

const vxs_baked_light *vxs_asset_light(const vxs_asset *asset, uint32_t index)
{
    return index < asset->contents.light_count ? &asset->contents.lights[index] : NULL;
}

const vxs_baked_light *vxs_asset_find_light(const vxs_asset *asset, const char *name)
{
    for (uint32_t n = 0; name && n < asset->contents.light_count; n++)
        if (!strcmp(asset->contents.lights[n].light.name, name)) return &asset->contents.lights[n];
    return NULL;
}

const vxs_baked_smoke *vxs_asset_smoke(const vxs_asset *asset, uint32_t index)
{
    const vxs_baked_smoke *smoke = asset->extras.smoke;
    return smoke && index < asset->contents.light_count && smoke[index].words ? &smoke[index] : NULL;
}

const vxs_baked_points *vxs_asset_points(const vxs_asset *asset)
{
    return asset->extras.points.coordinates ? &asset->extras.points : NULL;
}

void vxs_points_unpack(const vxs_baked_points *points, const double origin_ws[3], float *out)
{
    static const double zero[3] = {0, 0, 0};
    const double       *origin  = origin_ws ? origin_ws : zero;
    for (uint32_t n = 0; n < points->count; n++) {
        for (int i = 0; i < 3; i++)
            *out++ = (float)(points->low_ws[i] - origin[i] + points->step_metres * points->coordinates[3 * (size_t)n + (size_t)i]);
        *out++ = (float)points->square_metres;
    }
}

const vxs_contents *vxs_asset_contents(const vxs_asset *asset)
{
    return &asset->contents;
}

uint32_t vxs_version(void)
{
    return VXS_VERSION_NUMBER;
}

const char *vxs_result_text(vxs_result result)
{
    switch (result) {
#define VXS_RESULT_CASE(name, value, text)                                                                                         \
    case name: return text;
        VXS_RESULTS(VXS_RESULT_CASE)
#undef VXS_RESULT_CASE
    }
    return "unknown result";
}
