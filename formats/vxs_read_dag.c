/* Reading a light that is a DAG: every check of formats/vxs.md section 7 on its levels and masks, and its words in the
 * layout of section 6.
 *
 * Levels are read from the root down. A level is checked when it is decoded: a reference can only be to a child used before,
 * or to the next new one. So a child is always in the level below, and lookups need no check.
 * SPDX-License-Identifier: MIT */
#include "vxs_bytes.h"
#include "vxs_lookup.h"
#include "vxs_reader.h"

int vxs_is_dag_section(uint32_t kind)
{
    return kind == VXS_KIND_LEVEL || kind == VXS_KIND_MASKS;
}

int vxs_dag_has_section(const vxs_light *light, const vxs_section *s)
{
    return s->level <= (s->kind == VXS_KIND_LEVEL ? light->levels - VXS_LEVELS_MIN : 0);
}

/* A level of the light being decoded. */
typedef struct level {
    int       section;
    uint8_t  *content; /* inflated: node count, states, references */
    uint64_t  size;
    uint32_t  count;
    uint32_t *word; /* [count] word where each node starts */
} level;

typedef struct light_reader {
    vxs_reader      *r;
    vxs_baked_light *baked;
    uint32_t         level_count;
    level            level[VXS_LEVELS_MAX];
    uint8_t         *masks;
    uint32_t         mask_count;
    int              mask_section;
    uint64_t         words; /* used so far */
    uint32_t         maps;
} light_reader;

static uint32_t level_states(const level *l, uint32_t node)
{
    return vxs_load16(l->content + 4 + (size_t)node * 2);
}

static void add_part(light_reader *lr, const char *kind, uint32_t side_voxels, uint32_t count, uint64_t words, int section)
{
    lr->baked->parts[lr->baked->part_count++] = (vxs_part){kind, side_voxels, count, 4 * words, (uint32_t)section};
}

/* Inflate a level and place its nodes after those of the level above. */
static int lay_out_level(light_reader *lr, uint32_t index)
{
    vxs_reader *r = lr->r;
    level      *l = &lr->level[index];
    l->section    = vxs_find_section(r, VXS_KIND_LEVEL, (uint32_t)(lr->baked - r->out.lights), index);
    if (l->section < 0 || !(l->content = vxs_inflate(r, l->section, 4))) return 0;
    l->size  = r->out.sections[l->section].inflated_bytes;
    l->count = vxs_load32(l->content);
    if (l->size < 4 || l->count > (l->size - 4) / 2) return vxs_found(r, 401, l->section, 0), 0;
    if (!(l->word = vxs_reader_alloc(r, l->count, sizeof *l->word, l->section))) return 0;
    uint64_t start = lr->words;
    for (uint32_t n = 0; n < l->count; n++) {
        uint32_t states = level_states(l, n);

        /* A child that repeats its neighbour nearer the light must have one: for an octree child with z = 1, a neighbour with
         * its own offset; for a slice, any mask. */
        int      slices = index == 0;
        uint32_t same   = states & (states >> 1) & 0x5555u;
        uint32_t masks  = (states >> 1) & 0x5555u;
        if (!(slices ? !(same & ~(masks << 2)) : !(same & ~(vxs_own(states) << 8))))
            return vxs_found(r, 402, l->section, 4 + (uint64_t)n * 2), 0;

        l->word[n] = (uint32_t)lr->words;
        lr->words += 1 + vxs_popcount(vxs_own(states));
        if (lr->words > UINT32_MAX) return vxs_found(r, 406, l->section, 0), 0;
    }
    add_part(lr, "nodes", 8u << index, l->count, lr->words - start, l->section);
    return 1;
}

/* The next reference: 0 for a new child, else its distance back from the next new one. Returns 0 for a finding. */
static int read_code(light_reader *lr, const level *l, uint64_t *at, uint32_t *code)
{
    uint64_t value = 0;
    uint64_t start = *at;
    for (unsigned shift = 0;; shift += 7) {
        if (*at == l->size || shift > 28) return vxs_found(lr->r, shift > 28 ? 405 : 401, l->section, start), 0;
        uint8_t byte = l->content[(*at)++];
        value |= (uint64_t)(byte & 0x7f) << shift;
        if (byte & 0x80) continue;
        if ((!byte && shift) || value > UINT32_MAX) return vxs_found(lr->r, 405, l->section, start), 0;
        *code = (uint32_t)value;
        return 1;
    }
}

/* Write the words of a level: states, and offsets of the children. */
static int decode_level(light_reader *lr, uint32_t index, uint32_t *words, uint32_t mask_word)
{
    const level *l     = &lr->level[index];
    const level *below = index ? &lr->level[index - 1] : NULL;
    uint32_t     room  = below ? below->count : lr->mask_count;
    uint32_t     next  = 0;
    uint64_t     at    = 4 + (uint64_t)l->count * 2;
    for (uint32_t n = 0; n < l->count; n++) {
        uint32_t  states = level_states(l, n);
        uint32_t *word   = words + l->word[n];
        *word++          = states;
        for (uint32_t own = vxs_popcount(vxs_own(states)); own; own--) {
            uint64_t start = at;
            uint32_t code;
            if (!read_code(lr, l, &at, &code)) return 0;
            if (code > next) return vxs_found(lr->r, 403, l->section, start), 0;
            uint32_t child = code ? next - code : next++;
            if (child >= room) return vxs_found(lr->r, 404, l->section, start), 0;
            *word++ = below ? below->word[child] : mask_word + 2 * child;
        }
    }
    if (next != room) return vxs_found(lr->r, 404, below ? below->section : lr->mask_section, 0), 0;
    if (at != l->size) return vxs_found(lr->r, 401, l->section, at), 0;
    return 1;
}

static int decode_dag(light_reader *lr)
{
    vxs_reader *r   = lr->r;
    lr->level_count = lr->baked->light.levels - 2;
    lr->maps        = vxs_map_count(&lr->baked->light);
    lr->words       = lr->maps > 1 ? lr->maps : 0;
    for (uint32_t l = lr->level_count; l-- > 0;)
        if (!lay_out_level(lr, l)) return 0;
    if (lr->level[lr->level_count - 1].count != lr->maps) return vxs_found(r, 404, lr->level[lr->level_count - 1].section, 0), 0;

    lr->mask_section = vxs_find_section(r, VXS_KIND_MASKS, (uint32_t)(lr->baked - r->out.lights), 0);
    if (lr->mask_section < 0 || !(lr->masks = vxs_inflate(r, lr->mask_section, 0))) return 0;
    uint64_t size = r->out.sections[lr->mask_section].inflated_bytes;
    lr->words += lr->words & 1;
    if (size % 8 || lr->words + size / 4 > UINT32_MAX) return vxs_found(r, 401, lr->mask_section, 0), 0;
    lr->mask_count = (uint32_t)(size / 8);
    add_part(lr, "masks", 8, lr->mask_count, size / 4, lr->mask_section);

    uint32_t mask_word = (uint32_t)lr->words;
    uint64_t total     = lr->words + (uint64_t)lr->mask_count * 2;
    if (total != lr->baked->word_count) return vxs_found(r, 406, lr->mask_section, 0), 0;
    uint32_t *words = (uint32_t *)lr->baked->words;
    if (!words && !(words = vxs_reader_alloc(r, total, sizeof *words, lr->mask_section))) return 0;
    lr->baked->words                     = words;
    words[mask_word ? mask_word - 1 : 0] = 0; /* the padding before masks, if there is any */
    for (uint32_t map = 0; map < lr->maps && lr->maps > 1; map++) words[map] = lr->level[lr->level_count - 1].word[map];
    for (uint32_t l = 0; l < lr->level_count; l++)
        if (!decode_level(lr, l, words, mask_word)) return 0;
    for (uint32_t n = 0; n < 2 * lr->mask_count; n++) words[mask_word + n] = vxs_load32(lr->masks + (size_t)n * 4);
    return 1;
}

void vxs_read_dag(vxs_reader *r, vxs_baked_light *baked)
{
    light_reader lr = {.r = r, .baked = baked};
    decode_dag(&lr);
    for (uint32_t l = 0; l < lr.level_count; l++) {
        vxs_reader_free(r, lr.level[l].word, lr.level[l].count, sizeof *lr.level[l].word);
        if (lr.level[l].content)
            vxs_reader_free(r, lr.level[l].content, r->out.sections[lr.level[l].section].inflated_bytes + 4, 1);
    }
    if (lr.masks) vxs_reader_free(r, lr.masks, r->out.sections[lr.mask_section].inflated_bytes, 1);
}
