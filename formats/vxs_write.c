/* Writing a .vxs file: header, directory and light table, formats/vxs.md sections 3 to 5. vxs_write_*.c add the sections of
 * codings, of smoke and of points.
 * SPDX-License-Identifier: MIT */
#include <stdlib.h>
#include <string.h>
#include <xxhash.h>
#include <zstd.h>

#include "vxs_bytes.h"
#include "vxs_writer.h"

/* Join header, directory and stored sections. */
static vxs_result assemble(vxs_bytes *out, const vxs_sections *s)
{
    uint32_t section_count = (uint32_t)(s->entries.size_bytes / VXS_ENTRY_BYTES);
    size_t   total         = VXS_HEADER_BYTES + s->entries.size_bytes + s->stored.size_bytes;
    out->size_bytes        = 0;
    uint8_t *header        = vxs_append(out, total);
    if (!header) return VXS_E_MEMORY;
    uint8_t *entries = header + VXS_HEADER_BYTES;
    memcpy(entries, s->entries.data, s->entries.size_bytes);
    memcpy(entries + s->entries.size_bytes, s->stored.data, s->stored.size_bytes);

    uint64_t offset = VXS_HEADER_BYTES + s->entries.size_bytes;
    for (uint32_t n = 0; n < section_count; n++) {
        vxs_store64(entries + n * VXS_ENTRY_BYTES + VXS_ENTRY_OFFSET, offset);
        offset += vxs_load64(entries + n * VXS_ENTRY_BYTES + VXS_ENTRY_STORED_BYTES);
    }

    memset(header, 0, VXS_HEADER_BYTES);
    memcpy(header, VXS_MAGIC, VXS_MAGIC_BYTES);
    vxs_store32(header + VXS_HEADER_VERSION, s->version);
    vxs_store32(header + VXS_HEADER_SECTION_COUNT, section_count);
    vxs_store64(header + VXS_HEADER_FILE_BYTES, total);
    vxs_store64(header + VXS_HEADER_DIRECTORY_HASH, XXH64(entries, s->entries.size_bytes, 0));
    vxs_store64(header + VXS_HEADER_HASH, XXH64(header, VXS_HEADER_HASH, 0));
    return VXS_OK;
}

/* Add the sections of light n, and write its record. */
static vxs_result add_light(vxs_sections *s, const vxs_write_light *l, vxs_encoded_light *encoded, uint32_t n, uint8_t *record)
{
    int        blocks = l->light.coding == VXS_CODING_BLOCKS;
    uint32_t   words  = l->blocks.word_count;
    vxs_result r      = blocks ? vxs_write_blocks(s, encoded, n) : vxs_write_dag(s, &l->dag, vxs_map_count(&l->light), n, &words);

    memset(record, 0, VXS_LIGHT_BYTES);
    vxs_store32(record + VXS_LIGHT_KIND, l->light.kind);
    vxs_store32(record + VXS_LIGHT_LEVELS, l->light.levels);
    vxs_store32(record + VXS_LIGHT_WORD_COUNT, words);
    vxs_store32(record + VXS_LIGHT_FLAGS, l->light.flags);
    for (int k = 0; k < 12; k++) vxs_store_f64(record + VXS_LIGHT_LS_FROM_WS + k * 8, l->light.ls_from_ws[k]);
    vxs_store_f64(record + VXS_LIGHT_TEXEL_METRES, l->light.texel_metres);
    vxs_store_f64(record + VXS_LIGHT_VOXEL_METRES, l->light.voxel_metres);
    for (int k = 0; k < 3; k++) vxs_store_f64(record + VXS_LIGHT_DIRECTION + k * 8, l->light.direction_ws[k]);
    vxs_store_f64(record + VXS_LIGHT_NEAR_METRES, l->light.near_metres);
    vxs_store_f64(record + VXS_LIGHT_COS_OUTER, l->light.cos_outer);
    vxs_store_f64(record + VXS_LIGHT_RANGE_METRES, l->light.range_metres);
    vxs_store32(record + VXS_LIGHT_CODING, s->version >= VXS_FORMAT_VERSION_BLOCKS ? l->light.coding : 0);
    vxs_store32(record + VXS_LIGHT_PACKING, blocks ? l->blocks.packing : 0);
    memcpy(record + VXS_LIGHT_NAME, l->light.name, strlen(l->light.name));

    return r;
}

static vxs_result add_sections(vxs_sections *s, const vxs_write_desc *desc)
{
    /* the table of lights follows the levels, because it holds their word counts */
    vxs_bytes          table   = {0};
    vxs_encoded_light *encoded = NULL;
    uint8_t           *at      = vxs_append(&table, VXS_LIGHTS_PREFIX_BYTES + (size_t)desc->light_count * VXS_LIGHT_BYTES);
    if (!at) return VXS_E_MEMORY;
    vxs_store32(at, desc->light_count);
    vxs_store32(at + 4, VXS_LIGHT_BYTES);
    vxs_result r = vxs_encode_blocks(&encoded, s, desc->lights, desc->light_count);
    for (uint32_t n = 0; n < desc->light_count && r == VXS_OK; n++)
        r = add_light(s, &desc->lights[n], encoded, n, table.data + VXS_LIGHTS_PREFIX_BYTES + (size_t)n * VXS_LIGHT_BYTES);
    if (r == VXS_OK) r = vxs_add_section(s, VXS_KIND_LIGHTS, 0, VXS_NO_LIGHT, 0, &table);
    vxs_encoded_free(encoded, desc->light_count);
    free(table.data);
    if (r == VXS_OK && desc->points) r = vxs_add_points(s, desc->points);
    if (r == VXS_OK && desc->metadata) {
        vxs_bytes text = {.data = (uint8_t *)desc->metadata, .size_bytes = strlen(desc->metadata)};
        r              = vxs_add_section(s, VXS_KIND_METADATA, VXS_SECTION_OPTIONAL, VXS_NO_LIGHT, 0, &text);
    }
    return r;
}

vxs_result vxs_write(vxs_bytes *out, const vxs_write_desc *desc)
{
    if (desc->light_count < 1 || desc->light_count > VXS_LIGHTS_MAX) return VXS_E_ARGUMENT;
    if (desc->zstd_level < 1 || desc->zstd_level > 19) return VXS_E_ARGUMENT;
    uint32_t version = 1; /* the lowest that has the codings of all lights */
    for (uint32_t n = 0; n < desc->light_count; n++) {
        const vxs_write_light *lights = desc->lights;
        const vxs_light       *light  = &lights[n].light;
        if (light->levels < VXS_LEVELS_MIN || light->levels > VXS_LEVELS_MAX) return VXS_E_ARGUMENT;
        if (light->coding != VXS_CODING_DAG && light->coding != VXS_CODING_BLOCKS) return VXS_E_ARGUMENT;
        if (light->coding == VXS_CODING_DAG && !vxs_dag_fits(&lights[n].dag, light)) return VXS_E_ARGUMENT;
        if (!light->name[0] || !memchr(light->name, 0, sizeof light->name)) return VXS_E_ARGUMENT;
        for (uint32_t other = 0; other < n; other++)
            if (!strcmp(lights[other].light.name, light->name)) return VXS_E_ARGUMENT;
        if (light->coding == VXS_CODING_BLOCKS) version = VXS_FORMAT_VERSION_BLOCKS;
    }
    vxs_sections s = {
        .zstd = vxs_compressor(desc->zstd_level), .zstd_level = desc->zstd_level, .version = version, .parallel = desc->parallel};
    vxs_result r = VXS_E_MEMORY;
    if (!s.zstd) goto done;
    if ((r = add_sections(&s, desc)) != VXS_OK) goto done;
    r = assemble(out, &s);
done:
    ZSTD_freeCCtx(s.zstd);
    free(s.entries.data);
    free(s.stored.data);
    return r;
}

vxs_result vxs_write_smoke(vxs_bytes *out, const void *bytes, size_t size_bytes, const vxs_contents *contents,
                           const vxs_smoke_view *smoke, int zstd_level)
{
    vxs_sections s = {.zstd_level = zstd_level, .version = contents->version};
    vxs_result   r = VXS_E_MEMORY;
    if (zstd_level < 1 || zstd_level > 19) return VXS_E_ARGUMENT;
    for (uint32_t n = 0; n < contents->section_count; n++)
        if (contents->sections[n].kind == VXS_KIND_SMOKE) return VXS_E_ARGUMENT;
    s.zstd = vxs_compressor(zstd_level);

    /* directory entries and stored bytes of the file stay as they are */
    size_t   entries = (size_t)contents->section_count * VXS_ENTRY_BYTES, stored = size_bytes - VXS_HEADER_BYTES - entries;
    uint8_t *to = vxs_append(&s.entries, entries), *rest = vxs_append(&s.stored, stored);
    if (s.zstd && to && rest) {
        memcpy(to, (const uint8_t *)bytes + VXS_HEADER_BYTES, entries);
        memcpy(rest, (const uint8_t *)bytes + VXS_HEADER_BYTES + entries, stored);
        r = VXS_OK;
    }
    for (uint32_t n = 0; n < contents->light_count && r == VXS_OK; n++)
        if (smoke[n].counts) r = vxs_add_smoke(&s, &smoke[n], &contents->lights[n].light, n);
    if (r == VXS_OK) r = assemble(out, &s);
    ZSTD_freeCCtx(s.zstd);
    free(s.entries.data);
    free(s.stored.data);
    return r;
}
