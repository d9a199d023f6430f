/* Writing a .vxs file; formats/vxs.md sections 3 to 7.
 * SPDX-License-Identifier: MIT */
#include <stdlib.h>
#include <string.h>
#include <xxhash.h>
#include <zstd.h>

#include "vxs_bytes.h"
#include "vxs_file.h"

/* `size` more bytes at the end of `b`, or NULL without memory. */
static uint8_t *append(vxs_bytes *b, size_t size)
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

/* The sections so far: directory entries and stored bytes, put together at the end. */
typedef struct sections {
    vxs_bytes  entries; /* VXS_ENTRY_BYTES each; offsets are filled in at the end */
    vxs_bytes  stored;
    ZSTD_CCtx *zstd;
} sections;

static vxs_result add_section(sections *s, uint32_t kind, uint32_t flags, uint32_t light, uint32_t level, const vxs_bytes *content)
{
    size_t   bound = ZSTD_compressBound(content->size_bytes);
    size_t   start = s->stored.size_bytes;
    uint8_t *to    = append(&s->stored, bound);
    uint8_t *entry = append(&s->entries, VXS_ENTRY_BYTES);
    if (!to || !entry) return VXS_E_MEMORY;

    size_t stored = ZSTD_compress2(s->zstd, to, bound, content->data, content->size_bytes);
    if (ZSTD_isError(stored)) return VXS_E_MEMORY;
    s->stored.size_bytes = start + stored;

    vxs_store32(entry + VXS_ENTRY_KIND, kind);
    vxs_store32(entry + VXS_ENTRY_FLAGS, flags);
    vxs_store32(entry + VXS_ENTRY_LIGHT, light);
    vxs_store32(entry + VXS_ENTRY_LEVEL, level);
    vxs_store64(entry + VXS_ENTRY_STORED_BYTES, stored);
    vxs_store64(entry + VXS_ENTRY_INFLATED_BYTES, content->size_bytes);
    vxs_store64(entry + VXS_ENTRY_HASH, XXH64(to, stored, 0));
    return VXS_OK;
}

/* What child c of a node is; VXS_CHILD_SAME spares the offset of a child that repeats its neighbour nearer the light. */
static uint32_t child_state(const uint32_t *child, unsigned c, int slices)
{
    if (child[c] < VXS_REF_FIRST) return child[c];
    unsigned nearer  = slices ? c - 1 : c - 4;
    int      has_one = slices ? c >= 1 : c >= 4;
    return has_one && child[c] == child[nearer] ? VXS_CHILD_SAME : VXS_CHILD_OWN;
}

static int append_varint(vxs_bytes *b, uint32_t v)
{
    do {
        uint8_t *at = append(b, 1);
        if (!at) return 0;
        *at = (uint8_t)((v & 0x7f) | (v > 0x7f ? 0x80 : 0));
        v >>= 7;
    } while (v);
    return 1;
}

/* A level's nodes in the order in which the level above first refers to them (vxs.md section 7).
 * order  [count] nodes of this level, as `view` numbers them
 * below  [out] the same for the level below, or for the masks; *below_count of them; number [size of that level] is scratch */
static vxs_result encode_level(vxs_bytes *content, const vxs_dag_view *view, uint32_t level, const uint32_t *order, uint32_t count,
                               uint32_t *below, uint32_t *below_count, uint32_t *number, uint64_t *words)
{
    content->size_bytes = 0;
    uint8_t *head       = append(content, 4 + (size_t)count * 2);
    if (!head) return VXS_E_MEMORY;
    vxs_store32(head, count);
    *words += count;
    *below_count = 0;
    for (uint32_t n = 0; n < count; n++) {
        const uint32_t *child  = view->nodes[level] + (size_t)order[n] * 8;
        uint32_t        states = 0;
        for (unsigned c = 0; c < 8; c++) {
            uint32_t state = child_state(child, c, level == 0);
            states |= state << (2 * c);
            if (state != VXS_CHILD_OWN) continue;

            uint32_t *seen = &number[child[c] - VXS_REF_FIRST];
            uint32_t  code = *seen ? *below_count + 1 - *seen : 0;
            if (!*seen) {
                below[(*below_count)++] = child[c] - VXS_REF_FIRST;
                *seen                   = *below_count;
            }
            if (!append_varint(content, code)) return VXS_E_MEMORY;
            ++*words;
        }
        vxs_store16(content->data + 4 + (size_t)n * 2, (uint16_t)states);
    }
    return VXS_OK;
}

static vxs_result encode_masks(vxs_bytes *content, const vxs_dag_view *view, const uint32_t *order, uint32_t count)
{
    content->size_bytes = 0;
    uint8_t *at         = append(content, (size_t)count * 8);
    if (!at && count) return VXS_E_MEMORY;
    for (uint32_t n = 0; n < count; n++, at += 8) vxs_store64(at, view->masks[order[n]]);
    return VXS_OK;
}

/* Sections of one light, the roots' level first, the masks last. A root is a node of its own for each map, even where two are equal. *word_count is what a reader will need. */
static vxs_result add_light(sections *s, const vxs_dag_view *view, uint32_t maps, uint32_t light, uint32_t *word_count)
{
    vxs_bytes content = {0};
    uint64_t  words   = maps > 1 ? maps : 0; /* where each root starts */
    uint32_t  count   = maps;
    uint32_t *order   = malloc(maps * sizeof *order);
    if (!order) return VXS_E_MEMORY;
    memcpy(order, view->roots, maps * sizeof *order);
    vxs_result r = VXS_OK;
    for (uint32_t level = view->level_count; level-- > 0 && r == VXS_OK;) {
        uint32_t  room        = level ? view->count[level - 1] : view->mask_count;
        uint32_t *below       = malloc(((size_t)room + 1) * sizeof *below);
        uint32_t *number      = calloc((size_t)room + 1, sizeof *number);
        uint32_t  below_count = 0;
        r = below && number ? encode_level(&content, view, level, order, count, below, &below_count, number, &words) : VXS_E_MEMORY;
        if (r == VXS_OK) r = add_section(s, VXS_KIND_LEVEL, 0, light, level, &content);
        free(number);
        free(order);
        order = below;
        count = below_count;
    }
    if (r == VXS_OK) r = encode_masks(&content, view, order, count);
    if (r == VXS_OK) r = add_section(s, VXS_KIND_MASKS, 0, light, 0, &content);
    words += (words & 1) + (uint64_t)count * 2; /* masks lie at even words */
    if (r == VXS_OK && words > UINT32_MAX) r = VXS_E_ARGUMENT;
    *word_count = (uint32_t)words;
    free(order);
    free(content.data);
    return r;
}

static void encode_light_record(uint8_t *at, const vxs_light *light, uint32_t word_count)
{
    memset(at, 0, VXS_LIGHT_BYTES);
    vxs_store32(at + VXS_LIGHT_KIND, light->kind);
    vxs_store32(at + VXS_LIGHT_LEVELS, light->levels);
    vxs_store32(at + VXS_LIGHT_WORD_COUNT, word_count);
    vxs_store32(at + VXS_LIGHT_FLAGS, light->flags);
    for (int n = 0; n < 12; n++) vxs_store_f64(at + VXS_LIGHT_LS_FROM_WS + n * 8, light->ls_from_ws[n]);
    vxs_store_f64(at + VXS_LIGHT_TEXEL_METRES, light->texel_metres);
    vxs_store_f64(at + VXS_LIGHT_VOXEL_METRES, light->voxel_metres);
    for (int n = 0; n < 3; n++) vxs_store_f64(at + VXS_LIGHT_DIRECTION + n * 8, light->direction_ws[n]);
    vxs_store_f64(at + VXS_LIGHT_NEAR_METRES, light->near_metres);
    vxs_store_f64(at + VXS_LIGHT_COS_OUTER, light->cos_outer);
    vxs_store_f64(at + VXS_LIGHT_RANGE_METRES, light->range_metres);
    memcpy(at + VXS_LIGHT_NAME, light->name, strlen(light->name));
}

/* Header, directory and stored sections, one after the other. */
static vxs_result assemble(vxs_bytes *out, const sections *s)
{
    uint32_t section_count = (uint32_t)(s->entries.size_bytes / VXS_ENTRY_BYTES);
    size_t   total         = VXS_HEADER_BYTES + s->entries.size_bytes + s->stored.size_bytes;
    out->size_bytes        = 0;
    uint8_t *header        = append(out, total);
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
    vxs_store32(header + VXS_HEADER_VERSION, VXS_FORMAT_VERSION);
    vxs_store32(header + VXS_HEADER_SECTION_COUNT, section_count);
    vxs_store64(header + VXS_HEADER_FILE_BYTES, total);
    vxs_store64(header + VXS_HEADER_DIRECTORY_HASH, XXH64(entries, s->entries.size_bytes, 0));
    vxs_store64(header + VXS_HEADER_HASH, XXH64(header, VXS_HEADER_HASH, 0));
    return VXS_OK;
}

static vxs_result add_sections(sections *s, const vxs_write_desc *desc)
{
    /* the table of lights follows the levels, because it holds their word counts */
    vxs_bytes  table = {0};
    vxs_result r     = VXS_OK;
    uint8_t   *at    = append(&table, VXS_LIGHTS_PREFIX_BYTES + (size_t)desc->light_count * VXS_LIGHT_BYTES);
    if (!at) return VXS_E_MEMORY;
    vxs_store32(at, desc->light_count);
    vxs_store32(at + 4, VXS_LIGHT_BYTES);
    for (uint32_t n = 0; n < desc->light_count && r == VXS_OK; n++) {
        uint32_t words = 0;
        r              = add_light(s, &desc->lights[n].dag, vxs_light_map_count(&desc->lights[n].light), n, &words);
        encode_light_record(table.data + VXS_LIGHTS_PREFIX_BYTES + (size_t)n * VXS_LIGHT_BYTES, &desc->lights[n].light, words);
    }
    if (r == VXS_OK) r = add_section(s, VXS_KIND_LIGHTS, 0, VXS_NO_LIGHT, 0, &table);
    free(table.data);
    if (r == VXS_OK && desc->metadata) {
        vxs_bytes text = {.data = (uint8_t *)desc->metadata, .size_bytes = strlen(desc->metadata)};
        r              = add_section(s, VXS_KIND_METADATA, VXS_SECTION_OPTIONAL, VXS_NO_LIGHT, 0, &text);
    }
    return r;
}

/* Whether the format has room for a light, beside those before it. */
static int light_fits(const vxs_write_light *lights, uint32_t n)
{
    const vxs_light    *light = &lights[n].light;
    const vxs_dag_view *dag   = &lights[n].dag;
    if (light->levels < VXS_LEVELS_MIN || light->levels > VXS_LEVELS_MAX) return 0;
    if (light->coding != VXS_CODING_DAG || dag->level_count != light->levels - 2) return 0;
    for (uint32_t map = 0; map < vxs_light_map_count(light); map++)
        if (dag->roots[map] >= dag->count[dag->level_count - 1]) return 0;
    if (!light->name[0] || !memchr(light->name, 0, sizeof light->name)) return 0;
    for (uint32_t other = 0; other < n; other++)
        if (!strcmp(lights[other].light.name, light->name)) return 0;
    return 1;
}

vxs_result vxs_write(vxs_bytes *out, const vxs_write_desc *desc)
{
    if (desc->light_count < 1 || desc->light_count > VXS_LIGHTS_MAX) return VXS_E_ARGUMENT;
    if (desc->zstd_level < 1 || desc->zstd_level > 19) return VXS_E_ARGUMENT;
    for (uint32_t n = 0; n < desc->light_count; n++)
        if (!light_fits(desc->lights, n)) return VXS_E_ARGUMENT;
    sections   s = {.zstd = ZSTD_createCCtx()};
    vxs_result r = VXS_E_MEMORY;
    if (!s.zstd || ZSTD_isError(ZSTD_CCtx_setParameter(s.zstd, ZSTD_c_compressionLevel, desc->zstd_level))) goto done;
    if ((r = add_sections(&s, desc)) != VXS_OK) goto done;
    r = assemble(out, &s);
done:
    ZSTD_freeCCtx(s.zstd);
    free(s.entries.data);
    free(s.stored.data);
    return r;
}
