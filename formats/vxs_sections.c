/* The sections of a .vxs file being written: their bytes and directory entries (vxs_writer.h).
 * SPDX-License-Identifier: MIT */
#include <stdlib.h>
#include <string.h>
#include <xxhash.h>
#include <zstd.h>

#include "vxs_bytes.h"
#include "vxs_writer.h"

ZSTD_CCtx *vxs_compressor(int zstd_level)
{
    ZSTD_CCtx *zstd = ZSTD_createCCtx();
    if (!zstd || !ZSTD_isError(ZSTD_CCtx_setParameter(zstd, ZSTD_c_compressionLevel, zstd_level))) return zstd;
    ZSTD_freeCCtx(zstd);
    return NULL;
}

uint8_t *vxs_append(vxs_bytes *b, size_t size)
{
    if (b->capacity_bytes - b->size_bytes < size) {
        size_t capacity = b->capacity_bytes ? b->capacity_bytes : 4096;
        while (capacity - b->size_bytes < size) {
            if (capacity > SIZE_MAX / 2) return NULL;
            capacity *= 2;
        }
        uint8_t *grown = realloc(b->data, capacity);
        if (!grown) return NULL;
        b->data           = grown;
        b->capacity_bytes = capacity;
    }
    uint8_t *at = b->data + b->size_bytes;
    b->size_bytes += size;
    return at;
}

/* Add the directory entry of a section whose bytes were appended from `start` on. */
static vxs_result add_entry(vxs_sections *s, const vxs_section *section, size_t start)
{
    uint8_t *entry  = vxs_append(&s->entries, VXS_ENTRY_BYTES);
    size_t   stored = s->stored.size_bytes - start;
    if (!entry) return VXS_E_MEMORY;
    vxs_store32(entry + VXS_ENTRY_KIND, section->kind);
    vxs_store32(entry + VXS_ENTRY_FLAGS, section->flags);
    vxs_store32(entry + VXS_ENTRY_LIGHT, section->light);
    vxs_store32(entry + VXS_ENTRY_LEVEL, section->level);
    vxs_store64(entry + VXS_ENTRY_STORED_BYTES, stored);
    vxs_store64(entry + VXS_ENTRY_INFLATED_BYTES, section->inflated_bytes);
    vxs_store64(entry + VXS_ENTRY_HASH, XXH64(s->stored.data + start, stored, 0));
    return VXS_OK;
}

vxs_result vxs_add_section(vxs_sections *s, uint32_t kind, uint32_t flags, uint32_t light, uint32_t level, const vxs_bytes *content)
{
    size_t   bound = ZSTD_compressBound(content->size_bytes);
    size_t   start = s->stored.size_bytes;
    uint8_t *to    = vxs_append(&s->stored, bound);
    if (!to) return VXS_E_MEMORY;

    size_t stored = ZSTD_compress2(s->zstd, to, bound, content->data, content->size_bytes);
    if (ZSTD_isError(stored)) return VXS_E_MEMORY;
    s->stored.size_bytes = start + stored;
    return add_entry(s, &(vxs_section){kind, flags, light, level, .inflated_bytes = content->size_bytes}, start);
}

vxs_result vxs_add_stored(vxs_sections *s, uint32_t kind, uint32_t light, const vxs_bytes *content)
{
    size_t   start = s->stored.size_bytes;
    uint8_t *to    = vxs_append(&s->stored, content->size_bytes);
    if (!to) return VXS_E_MEMORY;
    memcpy(to, content->data, content->size_bytes);
    return add_entry(s, &(vxs_section){kind, VXS_SECTION_STORED, light, .inflated_bytes = content->size_bytes}, start);
}
