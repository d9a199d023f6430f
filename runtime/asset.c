/* Opening and closing assets; see vxs.h.
 * SPDX-License-Identifier: MIT */
#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "vxs.h"
#include "vxs_memory.h"

struct vxs_asset {
    vxs_contents  contents;
    vxs_allocator allocator;
};

vxs_result vxs_asset_open(vxs_asset **asset, const void *bytes, size_t size_bytes, const vxs_read_desc *desc)
{
    *asset               = NULL;
    vxs_allocator memory = vxs_allocator_of(desc);
    vxs_asset    *a      = memory.alloc(sizeof *a, memory.user);
    if (!a) return VXS_E_MEMORY;
    memset(a, 0, sizeof *a);
    a->allocator = memory;
    vxs_result r = vxs_read(&a->contents, bytes, size_bytes, desc);
    if (r != VXS_OK) {
        memory.free(a, sizeof *a, memory.user);
        return r;
    }
    *asset = a;
    return VXS_OK;
}

/* The size of an open file, or -1 when it has none (a folder, a pipe): errno says why. */
static long long file_size(FILE *f)
{
    if (fgetc(f) == EOF && ferror(f)) return -1; /* a folder may have a size, but cannot be read */
    if (fseeko(f, 0, SEEK_END)) return -1;
    long long size = ftello(f);
    if (fseeko(f, 0, SEEK_SET)) return -1;
    return size;
}

vxs_result vxs_asset_open_file(vxs_asset **asset, const char *path, const vxs_read_desc *desc)
{
    *asset  = NULL;
    FILE *f = fopen(path, "rb");
    if (!f) return errno == ENOMEM ? VXS_E_MEMORY : VXS_E_READ;

    vxs_allocator memory = vxs_allocator_of(desc);
    vxs_result    r      = VXS_E_READ;
    uint8_t      *bytes  = NULL;
    long long     size   = file_size(f);
    vxs_read_desc rest   = desc ? *desc : (vxs_read_desc){0};
    uint64_t      limit  = vxs_memory_limit_of(desc, size > 0 ? (uint64_t)size : 0);
    if (size < 0) goto done;
    r = VXS_E_MEMORY;
    if ((uint64_t)size >= limit || (uint64_t)size > SIZE_MAX) goto done;
    rest.memory_limit_bytes = limit - (uint64_t)size;
    bytes                   = memory.alloc(size ? (size_t)size : 1, memory.user);
    if (!bytes) goto done;
    r = fread(bytes, 1, (size_t)size, f) == (size_t)size ? vxs_asset_open(asset, bytes, (size_t)size, &rest) : VXS_E_READ;
    memory.free(bytes, size ? (size_t)size : 1, memory.user);
done:
    fclose(f);
    return r;
}

void vxs_asset_close(vxs_asset *asset)
{
    if (!asset) return;
    vxs_allocator memory = asset->allocator;
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
    for (uint32_t n = 0; n < asset->contents.light_count; n++)
        if (!strcmp(asset->contents.lights[n].light.name, name)) return &asset->contents.lights[n];
    return NULL;
}

const vxs_contents *vxs_asset_contents(const vxs_asset *asset)
{
    return &asset->contents;
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
