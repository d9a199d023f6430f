/* Reading what lies beside shadows: baked smoke and points of casters; every check of formats/vxs.md sections 15 and 16. The words
 * of smoke get the layout for lookups.
 *
 * The number of words of smoke follows from the stored numbers of tiles and nodes; counts are compared with these before any node
 * is read.
 * SPDX-License-Identifier: MIT */
#include <math.h>
#include <string.h>

#include "vxs_bytes.h"
#include "vxs_reader.h"
#include "vxs_smoke.h"

/* smoke ------------------------------------------------------------------------------------------------------------------------- */

enum { HEAD_WORDS = 3, TILE_TEXELS = 64, TILE_WORDS = 32, NODE_BYTES = 4 };

/* State of decoding the smoke of a light. */
typedef struct smoke_reader {
    vxs_reader    *r;
    int            section;
    const uint8_t *content, *mask, *counts, *nodes; /* nodes: four planes of node_count bytes */
    uint64_t       size, tiles;                     /* tiles of all maps */
    uint32_t       levels, node_count, tile_count;
} smoke_reader;

static int has_tile(const smoke_reader *s, uint64_t tile)
{
    return s->mask[tile >> 3] >> (tile & 7) & 1;
}

/* Find mask, counts and nodes in the section. 0: a finding. */
static int find_parts(smoke_reader *s, const vxs_light *light)
{
    if (s->size < VXS_SMOKE_PREFIX_BYTES) return vxs_found(s->r, 601, s->section, 0), 0;
    s->levels     = vxs_load32(s->content + VXS_SMOKE_LEVELS);
    s->node_count = vxs_load32(s->content + VXS_SMOKE_NODE_COUNT);

    /* metres must be finite floats for all depths */
    double first = vxs_real_of(vxs_load32(s->content + VXS_SMOKE_FIRST_METRES));
    double step  = vxs_real_of(vxs_load32(s->content + VXS_SMOKE_STEP_METRES));
    if (!(s->levels >= VXS_LEVELS_MIN && s->levels <= VXS_SMOKE_LEVELS_MAX && s->levels <= light->levels && isfinite(first) &&
          isfinite(step) && step > 0 && isfinite((float)(first + 65535 * step))))
        return vxs_found(s->r, 602, s->section, 0), 0;

    s->tiles        = (uint64_t)vxs_map_count(light) << (2 * (s->levels - 3));
    uint64_t counts = VXS_SMOKE_PREFIX_BYTES + (s->tiles + 7) / 8, nodes;
    if (s->size < counts) return vxs_found(s->r, 601, s->section, VXS_SMOKE_PREFIX_BYTES), 0;
    s->mask = s->content + VXS_SMOKE_PREFIX_BYTES;
    for (uint64_t t = 0; t < (s->tiles + 7) / 8 * 8; t++) s->tile_count += (uint32_t)has_tile(s, t);
    for (uint64_t t = s->tiles; t < (s->tiles + 7) / 8 * 8; t++)
        if (has_tile(s, t)) return vxs_found(s->r, 602, s->section, counts - 1), 0;
    nodes = counts + (uint64_t)s->tile_count * TILE_TEXELS;
    if (s->size != nodes + (uint64_t)s->node_count * NODE_BYTES) return vxs_found(s->r, 601, s->section, counts), 0;
    s->counts = s->content + counts;
    s->nodes  = s->content + nodes;
    return 1;
}

/* Check the node counts of each tile: within bounds, and with the sum in the head. 0: a finding. */
static int check_counts(const smoke_reader *s)
{
    uint64_t sum = 0;
    for (uint32_t t = 0; t < s->tile_count; t++) {
        const uint8_t *counts = s->counts + (size_t)t * TILE_TEXELS;
        uint32_t       nodes = 0, most = 0;
        for (int n = 0; n < TILE_TEXELS; n++) {
            nodes += counts[n];
            most = counts[n] > most ? counts[n] : most;
        }
        if (!nodes || most > VXS_SMOKE_NODES_MAX) return vxs_found(s->r, 603, s->section, (uint64_t)(counts - s->content)), 0;
        sum += nodes;
    }
    if (sum != s->node_count) return vxs_found(s->r, 601, s->section, VXS_SMOKE_NODE_COUNT), 0;
    return 1;
}

/* Byte `plane` of node n. */
static uint32_t node_byte(const smoke_reader *s, uint64_t n, uint32_t plane)
{
    return s->nodes[(uint64_t)plane * s->node_count + n];
}

/* Decode the curves of a tile; the nodes of a curve are stored as differences from the previous one.
 * node  the first one; becomes that of the next tile.   0: a finding. */
static int decode_tile(const smoke_reader *s, uint32_t number, uint64_t *node, uint32_t *words)
{
    const uint8_t *counts = s->counts + (size_t)number * TILE_TEXELS;
    uint32_t       end    = 0;
    for (uint32_t texel = 0; texel < TILE_TEXELS; texel++) {
        uint32_t depth = 0, left = 0xffff;
        for (uint32_t k = 0; k < counts[texel]; k++) {
            uint64_t n  = (*node)++;
            uint32_t on = node_byte(s, n, 0) | node_byte(s, n, 1) << 8, less = node_byte(s, n, 2) | node_byte(s, n, 3) << 8;
            if (on > 0xffff - depth || less > left)
                return vxs_found(s->r, 604, s->section, (uint64_t)(s->nodes - s->content) + n), 0;
            depth += on;
            left -= less;
            words[TILE_WORDS + end++] = depth | left << 16;
        }
        words[texel / 2] = texel & 1 ? words[texel / 2] | end << 16 : end;
    }
    return 1;
}

/* 0: a finding. */
static int decode_smoke(const smoke_reader *s, uint32_t *words)
{
    uint64_t at = HEAD_WORDS + s->tiles, node = 0;
    uint32_t number = 0;
    words[0]        = s->levels;
    words[1]        = vxs_load32(s->content + VXS_SMOKE_FIRST_METRES);
    words[2]        = vxs_load32(s->content + VXS_SMOKE_STEP_METRES);
    for (uint64_t t = 0; t < s->tiles; t++) {
        words[HEAD_WORDS + t] = has_tile(s, t) ? (uint32_t)at : 0;
        if (!has_tile(s, t)) continue;
        uint64_t before = node;
        if (!decode_tile(s, number++, &node, words + at)) return 0;
        at += TILE_WORDS + node - before;
    }
    return 1;
}

/* Inflate a section and set all of a vxs_baked_smoke except its words. 0: a finding. */
static int open_section(smoke_reader *s, vxs_reader *r, int section, vxs_baked_smoke *to)
{
    const vxs_section *from  = &r->out.sections[section];
    const vxs_light   *light = &r->out.lights[from->light].light;
    *s = (smoke_reader){.r = r, .section = section, .content = vxs_inflate(r, section, 0), .size = from->inflated_bytes};
    if (!s->content || !find_parts(s, light) || !check_counts(s)) return 0;
    uint64_t count = HEAD_WORDS + s->tiles + (uint64_t)s->tile_count * TILE_WORDS + s->node_count;
    if (count > INT32_MAX) return vxs_found(r, 601, section, 0), 0; /* must fit an int index of shaders */
    *to = (vxs_baked_smoke){NULL, (uint32_t)count, 1u << s->levels, s->tile_count, s->node_count, (uint32_t)section};
    return 1;
}

static void close_section(const smoke_reader *s)
{
    vxs_reader_free(s->r, (void *)s->content, s->size, 1);
}

void vxs_measure_smoke(vxs_reader *r, int section, vxs_baked_smoke *to)
{
    smoke_reader s;
    open_section(&s, r, section, to);
    close_section(&s);
}

void vxs_read_smoke_words(vxs_reader *r, const vxs_baked_smoke *measured, uint32_t *words)
{
    smoke_reader    s;
    vxs_baked_smoke now;
    if (open_section(&s, r, (int)measured->section, &now)) {
        if (now.word_count == measured->word_count && now.side_px == measured->side_px && now.tile_count == measured->tile_count &&
            now.node_count == measured->node_count)
            decode_smoke(&s, words);
        else
            vxs_found(r, 601, s.section, 0); /* the bytes changed since vxs_measure_smoke */
    }
    close_section(&s);
}

int vxs_find_smoke(const vxs_reader *r, uint32_t light)
{
    for (uint32_t n = 0; n < r->out.section_count; n++)
        if (r->out.sections[n].kind == VXS_KIND_SMOKE && r->out.sections[n].light == light) return (int)n;
    return -1;
}

void vxs_read_smoke(vxs_reader *r)
{
    for (uint32_t n = 0; n < r->out.section_count && (r->result == VXS_OK || r->desc.find_all); n++) {
        const vxs_section *s = &r->out.sections[n];
        if (s->kind != VXS_KIND_SMOKE || s->light >= r->out.light_count) continue;
        if (!r->smoke) {
            if (!(r->smoke = vxs_reader_alloc(r, r->out.light_count, sizeof *r->smoke, (int)n))) return;
            memset(r->smoke, 0, r->out.light_count * sizeof *r->smoke);
        }
        if (r->smoke[s->light].words) continue;

        smoke_reader    reading;
        vxs_baked_smoke found;
        uint32_t       *words = NULL;
        if (open_section(&reading, r, (int)n, &found)) words = vxs_reader_alloc(r, found.word_count, sizeof *words, (int)n);
        if (words) {
            found.words        = words;
            r->smoke[s->light] = found;
            decode_smoke(&reading, words);
        }
        close_section(&reading);
    }
}

void vxs_smoke_free(vxs_baked_smoke *smoke, uint32_t count, const vxs_allocator *a)
{
    for (uint32_t n = 0; smoke && n < count; n++)
        if (smoke[n].words) a->free((void *)smoke[n].words, smoke[n].word_count * sizeof *smoke[n].words, a->user);
    if (smoke) a->free(smoke, count * sizeof *smoke, a->user);
}

/* points ------------------------------------------------------------------------------------------------------------------------ */

/* Decode codes stored as differences from the previous code, with a plane for each byte. */
static void decode_points(vxs_reader *r, int section, const uint8_t *planes, uint32_t count, uint16_t *coordinates)
{
    uint64_t code = 0;
    for (uint32_t n = 0; n < count; n++) {
        for (uint32_t plane = 0; plane < VXS_POINT_CODE_BYTES; plane++)
            code += (uint64_t)planes[(size_t)plane * count + n] << 8 * plane;
        if (code >> 8 * VXS_POINT_CODE_BYTES) {
            vxs_found(r, 703, section, VXS_POINTS_PREFIX_BYTES + n);
            return;
        }
        for (uint32_t i = 0; i < 3; i++, coordinates++) { /* bits i, i + 3, i + 6, ... */
            *coordinates = 0;
            for (uint32_t bit = 0; bit < 16; bit++) *coordinates |= (uint16_t)((code >> (3 * bit + i) & 1) << bit);
        }
    }
}

static void read_content(vxs_reader *r, int section, const uint8_t *content, uint64_t size)
{
    if (size < VXS_POINTS_PREFIX_BYTES) {
        vxs_found(r, 701, section, 0);
        return;
    }
    vxs_baked_points p = {.section       = (uint32_t)section,
                          .count         = vxs_load32(content + VXS_POINTS_POINT_COUNT),
                          .square_metres = vxs_load_f64(content + VXS_POINTS_SQUARE_METRES),
                          .step_metres   = vxs_load_f64(content + VXS_POINTS_STEP_METRES)};
    int good           = isfinite((float)p.square_metres) && p.square_metres > 0 && isfinite(p.step_metres) && p.step_metres > 0 &&
               p.count >= 1 && p.count <= VXS_POINTS_MAX;
    for (int n = 0; n < 3; n++) { /* all places must be finite, also at the last unit */
        p.low_ws[n] = vxs_load_f64(content + VXS_POINTS_LOW + 8 * n);
        good &= isfinite(p.low_ws[n]) && isfinite(p.low_ws[n] + 65535 * p.step_metres);
    }
    if (!good) {
        vxs_found(r, 702, section, 0);
        return;
    }
    if (size != VXS_POINTS_PREFIX_BYTES + (uint64_t)p.count * VXS_POINT_CODE_BYTES) {
        vxs_found(r, 701, section, VXS_POINTS_POINT_COUNT);
        return;
    }
    uint16_t *coordinates = vxs_reader_alloc(r, p.count, 3 * sizeof *coordinates, section);
    if (!coordinates) return;
    p.coordinates = coordinates;
    r->points     = p;
    decode_points(r, section, content + VXS_POINTS_PREFIX_BYTES, p.count, coordinates);
}

void vxs_read_points(vxs_reader *r)
{
    for (uint32_t n = 0; n < r->out.section_count; n++) {
        const vxs_section *s = &r->out.sections[n];
        if (s->kind != VXS_KIND_POINTS || s->light != VXS_NO_LIGHT || r->points.coordinates) continue;
        uint8_t *content = vxs_inflate(r, (int)n, 0);
        if (!content) return;
        read_content(r, (int)n, content, s->inflated_bytes);
        vxs_reader_free(r, content, s->inflated_bytes, 1);
    }
}

void vxs_points_free(vxs_baked_points *points, const vxs_allocator *a)
{
    if (points->coordinates) a->free((void *)points->coordinates, points->count * 3 * sizeof *points->coordinates, a->user);
}
