/* Reading a .vxs file: every check of formats/vxs.md section 8 that is common to all files.
 *
 * Order: header, directory, checksums of all sections, light table, then for each light the sections of its coding.
 * SPDX-License-Identifier: MIT */
#include <math.h>
#include <string.h>
#include <xxhash.h>
#include <zstd.h>

#include "vxs_bytes.h"
#include "vxs_desc.h"
#include "vxs_reader.h"

/* Whether to continue: there is no finding, or all findings are wanted. */
static int go_on(const vxs_reader *r)
{
    return r->result == VXS_OK || r->desc.find_all;
}

/* header and directory -------------------------------------------------------------------------------------------------------- */

static int zeros(const uint8_t *p, size_t count)
{
    while (count--)
        if (*p++) return 0;
    return 1;
}

int vxs_read_header(vxs_reader *r)
{
    const uint8_t *h = r->bytes;
    if (r->size < VXS_MAGIC_BYTES || memcmp(h, VXS_MAGIC, VXS_MAGIC_BYTES))
        return vxs_found(r, r->size ? 102 : 101, VXS_IN_HEADER, 0), 0;
    if (r->size < VXS_HEADER_BYTES) return vxs_found(r, 101, VXS_IN_HEADER, r->size), 0;
    uint32_t version = vxs_load32(h + VXS_HEADER_VERSION);
    if (version < 1 || version > VXS_FORMAT_VERSION) return vxs_found(r, 103, VXS_IN_HEADER, VXS_HEADER_VERSION), 0;
    if (XXH64(h, VXS_HEADER_HASH, 0) != vxs_load64(h + VXS_HEADER_HASH))
        return vxs_found(r, 104, VXS_IN_HEADER, VXS_HEADER_HASH), 0;
    if (!zeros(h + VXS_HEADER_RESERVED, VXS_HEADER_HASH - VXS_HEADER_RESERVED))
        return vxs_found(r, 105, VXS_IN_HEADER, VXS_HEADER_RESERVED), 0;

    uint64_t recorded = vxs_load64(h + VXS_HEADER_FILE_BYTES);
    if (r->size != recorded) return vxs_found(r, r->size < recorded ? 106 : 107, VXS_IN_HEADER, VXS_HEADER_FILE_BYTES), 0;

    uint32_t count = vxs_load32(h + VXS_HEADER_SECTION_COUNT);
    if (count < 1 || count > VXS_SECTIONS_MAX || VXS_HEADER_BYTES + (uint64_t)count * VXS_ENTRY_BYTES > r->size)
        return vxs_found(r, 108, VXS_IN_HEADER, VXS_HEADER_SECTION_COUNT), 0;
    r->out.version       = version;
    r->out.section_count = count;
    return 1;
}

static int has_blocks(const vxs_reader *r)
{
    return r->out.version >= VXS_FORMAT_VERSION_BLOCKS;
}

static int known_kind(const vxs_reader *r, uint32_t kind)
{
    return kind == VXS_KIND_LIGHTS || kind == VXS_KIND_METADATA || kind == VXS_KIND_SMOKE || kind == VXS_KIND_POINTS ||
           vxs_is_dag_section(kind) || (has_blocks(r) && vxs_is_blocks_section(kind));
}

/* Directory entries: in order, without gaps, to the end of the file; each checksum holds. */
int vxs_read_head(vxs_reader *r)
{
    if (!vxs_read_header(r)) return 0;
    uint32_t count = r->out.section_count;
    if (XXH64(r->bytes + VXS_HEADER_BYTES, (size_t)count * VXS_ENTRY_BYTES, 0) != vxs_load64(r->bytes + VXS_HEADER_DIRECTORY_HASH))
        return vxs_found(r, 109, VXS_IN_HEADER, VXS_HEADER_DIRECTORY_HASH), 0;
    r->out.sections = vxs_reader_alloc(r, count, sizeof *r->out.sections, VXS_IN_HEADER);
    if (!r->out.sections) return 0;

    uint32_t defined = VXS_SECTION_OPTIONAL | (has_blocks(r) ? VXS_SECTION_STORED : 0);
    uint64_t end     = VXS_HEADER_BYTES + (uint64_t)count * VXS_ENTRY_BYTES;
    for (uint32_t n = 0; n < count; n++) {
        const uint8_t *e  = r->bytes + VXS_HEADER_BYTES + (size_t)n * VXS_ENTRY_BYTES;
        uint64_t       at = (uint64_t)(e - r->bytes);
        vxs_section    s  = {
                .kind           = vxs_load32(e + VXS_ENTRY_KIND),
                .flags          = vxs_load32(e + VXS_ENTRY_FLAGS),
                .light          = vxs_load32(e + VXS_ENTRY_LIGHT),
                .level          = vxs_load32(e + VXS_ENTRY_LEVEL),
                .offset_bytes   = vxs_load64(e + VXS_ENTRY_OFFSET),
                .stored_bytes   = vxs_load64(e + VXS_ENTRY_STORED_BYTES),
                .inflated_bytes = vxs_load64(e + VXS_ENTRY_INFLATED_BYTES),
                .hash           = vxs_load64(e + VXS_ENTRY_HASH),
        };
        r->out.sections[n] = s;
        if (s.flags & ~defined) vxs_found(r, 201, (int)n, at + VXS_ENTRY_FLAGS);
        if (!known_kind(r, s.kind) && !(s.flags & VXS_SECTION_OPTIONAL)) vxs_found(r, 205, (int)n, at + VXS_ENTRY_KIND);
        if (s.offset_bytes != end) return vxs_found(r, 202, (int)n, at + VXS_ENTRY_OFFSET), 0;
        if (s.stored_bytes > r->size - end) return vxs_found(r, 203, (int)n, at + VXS_ENTRY_STORED_BYTES), 0;
        end += s.stored_bytes;
        if (!r->load && XXH64(r->bytes + s.offset_bytes, s.stored_bytes, 0) != s.hash) vxs_found(r, 206, (int)n, s.offset_bytes);

        /* a section that is not a zstd frame must have two equal sizes; each known kind is, or is not, a frame */
        int stored = (s.flags & VXS_SECTION_STORED) != 0, known = known_kind(r, s.kind);
        int as_kind = !known || stored == vxs_is_blocks_section(s.kind);
        if (has_blocks(r) && (!as_kind || (stored && s.stored_bytes != s.inflated_bytes)))
            vxs_found(r, 212, (int)n, at + VXS_ENTRY_FLAGS);
        uint32_t same = 0;
        while (known && same < n && !vxs_same_section(&r->out.sections[same], &s)) same++;
        if (known && same < n) vxs_found(r, 208, (int)n, at);
        if (!go_on(r)) return 0;
    }
    if (end != r->size) vxs_found(r, 204, VXS_IN_HEADER, end);
    return r->result == VXS_OK;
}

/* lights ---------------------------------------------------------------------------------------------------------------------- */

static int transform_valid(const double *m)
{
    for (int n = 0; n < 12; n++)
        if (!isfinite(m[n])) return 0;
    double det = m[0] * (m[5] * m[10] - m[6] * m[9]) - m[1] * (m[4] * m[10] - m[6] * m[8]) + m[2] * (m[4] * m[9] - m[5] * m[8]);
    return isfinite(det) && det != 0.0;
}

static int measure_valid(double metres)
{
    return isfinite(metres) && metres > 0.0;
}

/* Directional lights have no reach, and these fields are 0; for other lights each must be in range. A flag must belong to the kind
 * of the light; a point light has six maps.
 * l  of a known kind */
static void check_reach_and_flags(vxs_reader *r, const vxs_light *l, int section, uint64_t at)
{
    int is_sun = l->kind == VXS_LIGHT_KIND_DIRECTIONAL, is_spot = l->kind == VXS_LIGHT_KIND_SPOT;
    int cone  = is_spot ? l->cos_outer >= 0 && l->cos_outer < 1 : l->cos_outer == 0;
    int reach = is_sun ? l->near_metres == 0 && l->range_metres == 0
                       : measure_valid(l->near_metres) && isfinite(l->range_metres) && l->range_metres >= 0;
    int flags = is_sun ? !(l->flags & ~VXS_LIGHT_BOUNDED) : is_spot ? !(l->flags & ~VXS_LIGHT_CUBE) : l->flags == VXS_LIGHT_CUBE;
    if (!reach || !cone) vxs_found(r, 308, section, at + VXS_LIGHT_NEAR_METRES);
    if (!flags) vxs_found(r, 307, section, at + VXS_LIGHT_FLAGS);
}

static void check_light(vxs_reader *r, const vxs_light *light, const uint8_t *record, int section, uint64_t at)
{
    const double *d     = light->direction_ws;
    int           known = light->kind >= VXS_LIGHT_KIND_DIRECTIONAL && light->kind <= VXS_LIGHT_KIND_POINT;
    if (!known) vxs_found(r, 302, section, at + VXS_LIGHT_KIND);
    if (light->levels < VXS_LEVELS_MIN || light->levels > VXS_LEVELS_MAX) vxs_found(r, 303, section, at + VXS_LIGHT_LEVELS);
    if (!transform_valid(light->ls_from_ws)) vxs_found(r, 304, section, at + VXS_LIGHT_LS_FROM_WS);
    if (!measure_valid(light->texel_metres) || !measure_valid(light->voxel_metres) ||
        !(fabs(d[0] * d[0] + d[1] * d[1] + d[2] * d[2] - 1.0) < 1e-6))
        vxs_found(r, 305, section, at + VXS_LIGHT_TEXEL_METRES);

    const uint8_t *name = record + VXS_LIGHT_NAME;
    const uint8_t *end  = memchr(name, 0, VXS_LIGHT_NAME_BYTES);
    int            good = end && end != name && zeros(end, (size_t)(name + VXS_LIGHT_NAME_BYTES - end));
    for (const vxs_baked_light *other = r->out.lights; &other->light < light && good; other++)
        good = strcmp(other->light.name, light->name) != 0;
    if (!good) vxs_found(r, 306, section, at + VXS_LIGHT_NAME);

    if (known) check_reach_and_flags(r, light, section, at);
    if (light->coding != VXS_CODING_DAG && light->coding != VXS_CODING_BLOCKS) vxs_found(r, 309, section, at + VXS_LIGHT_CODING);
    if (!has_blocks(r) && vxs_load32(record + VXS_LIGHT_CODING)) vxs_found(r, 307, section, at + VXS_LIGHT_CODING);
    uint32_t packing = vxs_load32(record + VXS_LIGHT_PACKING); /* of palette blocks */
    if (packing && light->coding != VXS_CODING_BLOCKS)
        vxs_found(r, 307, section, at + VXS_LIGHT_PACKING);
    else if (packing > VXS_PACKING_FINE)
        vxs_found(r, 310, section, at + VXS_LIGHT_PACKING);
    if (!zeros(record + VXS_LIGHT_RESERVED, VXS_LIGHT_NAME - VXS_LIGHT_RESERVED))
        vxs_found(r, 307, section, at + VXS_LIGHT_RESERVED);
}

static void read_light_records(vxs_reader *r, int section, const uint8_t *table, uint64_t size)
{
    uint32_t count = size >= VXS_LIGHTS_PREFIX_BYTES ? vxs_load32(table) : 0;
    if (count < 1 || count > VXS_LIGHTS_MAX || vxs_load32(table + 4) != VXS_LIGHT_BYTES ||
        size != VXS_LIGHTS_PREFIX_BYTES + (uint64_t)count * VXS_LIGHT_BYTES) {
        vxs_found(r, 301, section, 0);
        return;
    }
    r->out.lights = vxs_reader_alloc(r, count, sizeof *r->out.lights, section);
    if (!r->out.lights) return;
    memset(r->out.lights, 0, count * sizeof *r->out.lights);
    r->out.light_count = count;
    for (uint32_t n = 0; n < count && go_on(r); n++) {
        uint64_t       at           = VXS_LIGHTS_PREFIX_BYTES + (uint64_t)n * VXS_LIGHT_BYTES;
        const uint8_t *record       = table + at;
        vxs_light     *light        = &r->out.lights[n].light;
        light->kind                 = vxs_load32(record + VXS_LIGHT_KIND);
        light->levels               = vxs_load32(record + VXS_LIGHT_LEVELS);
        light->flags                = vxs_load32(record + VXS_LIGHT_FLAGS);
        light->coding               = has_blocks(r) ? vxs_load32(record + VXS_LIGHT_CODING) : VXS_CODING_DAG;
        r->out.lights[n].packing    = vxs_load32(record + VXS_LIGHT_PACKING);
        r->out.lights[n].word_count = vxs_load32(record + VXS_LIGHT_WORD_COUNT);
        for (int k = 0; k < 12; k++) light->ls_from_ws[k] = vxs_load_f64(record + VXS_LIGHT_LS_FROM_WS + k * 8);
        light->texel_metres = vxs_load_f64(record + VXS_LIGHT_TEXEL_METRES);
        light->voxel_metres = vxs_load_f64(record + VXS_LIGHT_VOXEL_METRES);
        for (int k = 0; k < 3; k++) light->direction_ws[k] = vxs_load_f64(record + VXS_LIGHT_DIRECTION + k * 8);
        light->near_metres  = vxs_load_f64(record + VXS_LIGHT_NEAR_METRES);
        light->cos_outer    = vxs_load_f64(record + VXS_LIGHT_COS_OUTER);
        light->range_metres = vxs_load_f64(record + VXS_LIGHT_RANGE_METRES);
        memcpy(light->name, record + VXS_LIGHT_NAME, VXS_LIGHT_NAME_BYTES - 1);
        check_light(r, light, record, section, at);
    }
}

/* Whether a section of a known kind belongs to an existing light and level, and to the right coding. */
static int owner_valid(const vxs_reader *r, const vxs_section *s)
{
    int dag = vxs_is_dag_section(s->kind), smoke = s->kind == VXS_KIND_SMOKE;
    if (!dag && !smoke && !vxs_is_blocks_section(s->kind)) return s->light == VXS_NO_LIGHT && s->level == 0;
    if (s->light >= r->out.light_count) return 0;
    if (smoke) return s->level == 0;
    const vxs_light *light = &r->out.lights[s->light].light;
    if (light->coding != (dag ? VXS_CODING_DAG : VXS_CODING_BLOCKS)) return 0;
    return dag ? vxs_dag_has_section(light, s) : s->level == 0;
}

/* all of it -------------------------------------------------------------------------------------------------------------------- */

/* There is at most one. Metadata that belongs to a light has been reported before, and is ignored. */
int vxs_read_metadata(vxs_reader *r)
{
    const vxs_section wanted = {.kind = VXS_KIND_METADATA, .light = VXS_NO_LIGHT};
    for (uint32_t n = 0; n < r->out.section_count; n++) {
        if (!vxs_same_section(&r->out.sections[n], &wanted)) continue;
        if (!r->desc.metadata) {
            vxs_check_frame(r, (int)n, vxs_stored_bytes(r, (int)n), 1);
            continue;
        }
        r->out.metadata       = (char *)vxs_inflate(r, (int)n, 1);
        r->out.metadata_bytes = r->out.sections[n].inflated_bytes;
    }
    return r->result == VXS_OK;
}

int vxs_read_light_table(vxs_reader *r)
{
    int      section = vxs_find_section(r, VXS_KIND_LIGHTS, VXS_NO_LIGHT, 0);
    uint8_t *table   = section < 0 ? NULL : vxs_inflate(r, section, VXS_LIGHTS_PREFIX_BYTES);
    if (!table) return 0;
    uint64_t size = r->out.sections[section].inflated_bytes;
    read_light_records(r, section, table, size);
    vxs_reader_free(r, table, size + VXS_LIGHTS_PREFIX_BYTES, 1);
    if (r->result != VXS_OK) return 0;

    /* Sections of missing lights and levels would never be read, so they are not allowed. */
    for (uint32_t n = 0; n < r->out.section_count && go_on(r); n++) {
        const vxs_section *s = &r->out.sections[n];
        if (known_kind(r, s->kind) && !owner_valid(r, s))
            vxs_found(r, 210, (int)n, VXS_HEADER_BYTES + (uint64_t)n * VXS_ENTRY_BYTES);
    }

    return go_on(r);
}

static void read_all(vxs_reader *r)
{
    if (!vxs_read_head(r)) return;
    r->zstd = ZSTD_createDCtx();
    if (!r->zstd) {
        r->result = VXS_E_MEMORY;
        return;
    }
    if (!vxs_read_light_table(r)) return;
    for (uint32_t n = 0; n < r->out.light_count && go_on(r); n++) {
        vxs_baked_light *baked = &r->out.lights[n];
        if (baked->light.coding == VXS_CODING_BLOCKS)
            vxs_read_blocks(r, baked);
        else
            vxs_read_dag(r, baked);
    }
    if (go_on(r)) vxs_read_smoke(r);
    if (go_on(r)) vxs_read_points(r);
    if (go_on(r)) vxs_read_metadata(r);
}

void vxs_extras_free(vxs_extras *extras, uint32_t light_count, const vxs_allocator *allocator)
{
    vxs_smoke_free(extras->smoke, light_count, allocator);
    vxs_points_free(&extras->points, allocator);
}

vxs_result vxs_read_extras(vxs_contents *contents, vxs_extras *extras, const void *bytes, size_t size_bytes,
                           const vxs_read_desc *desc, int is_written)
{
    vxs_reader r     = {.bytes = bytes, .size = size_bytes, .is_written = is_written};
    vxs_result taken = vxs_read_desc_take(&r.desc, desc);
    if (taken != VXS_OK) return taken;
    r.allocator     = vxs_allocator_of(&r.desc);
    r.memory_left   = vxs_memory_limit_of(&r.desc, size_bytes);
    r.out.allocator = r.allocator;

    read_all(&r);
    ZSTD_freeDCtx(r.zstd);
    vxs_extras found = {r.smoke, r.points};
    if (r.result == VXS_OK) {
        *contents = r.out;
        *extras   = found;
    } else {
        vxs_extras_free(&found, r.out.light_count, &r.allocator);
        vxs_contents_free(&r.out);
    }
    return r.result;
}

static vxs_result read_contents(vxs_contents *contents, const void *bytes, size_t size_bytes, const vxs_read_desc *desc,
                                int is_written)
{
    vxs_extras extras;
    vxs_result r = vxs_read_extras(contents, &extras, bytes, size_bytes, desc, is_written);
    if (r == VXS_OK) vxs_extras_free(&extras, contents->light_count, &contents->allocator);
    return r;
}

vxs_result vxs_read(vxs_contents *contents, const void *bytes, size_t size_bytes, const vxs_read_desc *desc)
{
    return read_contents(contents, bytes, size_bytes, desc, 0);
}

vxs_result vxs_read_written(vxs_contents *contents, const void *bytes, size_t size_bytes, const vxs_read_desc *desc)
{
    return read_contents(contents, bytes, size_bytes, desc, 1);
}

void vxs_contents_free(vxs_contents *c)
{
    vxs_allocator *a = &c->allocator;
    for (uint32_t n = 0; n < c->light_count; n++) {
        const vxs_baked_light *l = &c->lights[n];
        uint64_t words           = l->word_count + (uint64_t)(l->light.coding == VXS_CODING_BLOCKS ? VXS_BLOCKS_SPARE_WORDS : 0);
        if (l->words) a->free((void *)l->words, words * sizeof *l->words, a->user);
    }
    if (c->lights) a->free(c->lights, c->light_count * sizeof *c->lights, a->user);
    if (c->sections) a->free(c->sections, c->section_count * sizeof *c->sections, a->user);
    if (c->metadata) a->free(c->metadata, c->metadata_bytes + 1, a->user);
    memset(c, 0, sizeof *c);
}
