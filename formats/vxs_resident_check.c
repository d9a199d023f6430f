/* Reading resident parts packed fast: checks their words; vxs_page_fast.h.
 *
 * The walk follows the order in 13.4 of formats/vxs.md: tops map after map, entries in z order, then the common pool,
 * pattern by pattern. It collects the nodes of all pages, in their order.
 * SPDX-License-Identifier: MIT */
#include "vxs_page_fast.h"

#include <string.h>

#include "vxs_frame.h"
#include "vxs_pattern_check.h"
#include "vxs_resident_layout.h"

/* State of the check of a resident part. */
typedef struct checked_resident {
    const vxs_resident_sizes *sizes;
    const uint32_t           *words;
    uint32_t                  levels;
    uint32_t                  word; /* where the next top, or the entries of the next cell, must start */
    vxs_page_node            *nodes;
    uint32_t                 *page_first;
    uint32_t                  met, pages; /* number of nodes and pages so far */
} checked_resident;

static int is_depth(uint32_t word)
{
    return word >= top_uniform && word - top_uniform < SQUARE_DEPTH_END;
}

/* The entry at a word, of square (x, y) of a map: a depth, a known node, the next node of the last page, or the first of the
 * next page. */
static int check_entry(checked_resident *r, uint32_t at, uint32_t map, uint32_t x, uint32_t y)
{
    uint32_t name = r->words[at], bounds = r->words[at + 1], page = name >> 16, offset = name & 0xffff;
    if (name >= top_uniform) return is_depth(name) && !bounds;
    if (bounds >> 24 < (bounds >> 16 & 0xff)) return 0; /* lookups and depths would disagree between the bounds */
    if (page == r->pages) {
        if (offset || r->pages == r->sizes->page_count) return 0;
        r->page_first[r->pages++] = r->met;
    } else if (page + 1 != r->pages || offset <= r->nodes[r->met - 1].offset) {
        if (page >= r->pages) return 0;
        uint32_t end = page + 1 < r->pages ? r->page_first[page + 1] : r->met;
        return node_at(r->nodes, r->page_first[page], end, offset, r->met) < r->met; /* the node must be known */
    }
    if (r->met == r->sizes->node_count) return 0;
    r->nodes[r->met++] = (vxs_page_node){offset, x, y, map, square_base(bounds, r->levels)};
    return 1;
}

/* Entries of a square of `side` entries a side, in z order. */
static int check_entries(checked_resident *r, uint32_t top, uint32_t map, uint32_t x0, uint32_t y0, uint32_t side)
{
    for (uint32_t n = 0; n < side * side; n++) {
        uint32_t x = x0 + even_bits(n), y = y0 + even_bits(n >> 1);
        if (!check_entry(r, top_at(r->words, top, r->levels, x, y), map, x, y)) return 0;
    }
    return 1;
}

static int check_top(checked_resident *r, uint32_t map)
{
    uint32_t side = squares_of(r->levels), top = r->word, cells = side / CELL_SQUARES;
    uint32_t size = r->levels < CELL_LEVELS ? 2 * side * side : cells * cells;
    if (r->words[2 + map] != top || size > r->sizes->word_count - top) return 0;
    r->word += size;
    if (r->levels < CELL_LEVELS) return check_entries(r, top, map, 0, 0, side);
    for (uint32_t n = 0; n < cells * cells; n++) {
        uint32_t x = even_bits(n), y = even_bits(n >> 1), cell = r->words[top + y * cells + x];
        if (is_depth(cell)) continue;
        if (cell != r->word || 2 * CELL_SQUARES * CELL_SQUARES > r->sizes->word_count - r->word) return 0;
        r->word += 2 * CELL_SQUARES * CELL_SQUARES;
        if (!check_entries(r, top, map, x * CELL_SQUARES, y * CELL_SQUARES, CELL_SQUARES)) return 0;
    }
    return 1;
}

/* Check the head and the tops of all maps. */
static int check_tops(checked_resident *r, uint32_t map_count)
{
    if (r->words[0] != r->sizes->page_count) return 0;
    for (uint32_t n = 2 + map_count; n < r->word; n++)
        if (r->words[n]) return 0; /* must be 0: a map that does not exist, or a page, since none is loaded yet */
    for (uint32_t map = 0; map < map_count; map++)
        if (!check_top(r, map)) return 0;
    r->page_first[r->pages] = r->met;
    return r->met == r->sizes->node_count && r->pages == r->sizes->page_count && r->words[1] == r->word;
}

/* Check the common pool: patterns without gaps, to the last word. */
static int check_common(const checked_resident *r, const uint8_t *kinds, vxs_common_marks *marks)
{
    uint32_t     words = r->sizes->word_count - r->word, half = 0;
    checked_pool pool = {r->words + r->word, 2 * words};
    marks->half_count = 2 * words < VXS_COMMON_HALVES_MAX ? 2 * words : VXS_COMMON_HALVES_MAX;
    if (marks->half_count) memset(marks->at, 0, marks->half_count);
    for (uint32_t n = 0; n < r->sizes->pattern_count; n++) {
        if (kinds[n] >= VXS_PATTERN_KINDS || kinds[n] == 1 || half >= VXS_COMMON_HALVES_MAX) return 0;
        uint32_t halves = check_pattern_of(&pool, half, kinds[n]);
        if (!halves) return 0;
        marks->at[half] = (uint8_t)(kinds[n] + 1);
        half += halves;
    }
    if ((half + 1) / 2 != words || half > VXS_COMMON_HALVES_MAX) return 0;
    return half % 2 == 0 || !get_half(pool.words, half);
}

void vxs_common_mark(vxs_common_marks *marks, const vxs_common *common)
{
    marks->half_count = common->half_count;
    if (marks->half_count) memset(marks->at, 0, marks->half_count);
    for (uint32_t kind = 0; kind < VXS_PATTERN_KINDS; kind++)
        for (uint32_t n = common->first[kind]; n < common->first[kind + 1]; n++)
            marks->at[common->patterns[n]] = (uint8_t)(kind + 1);
}

uint32_t vxs_resident_common_halves(const vxs_resident_sizes *sizes)
{
    uint32_t words = sizes->word_count - RESIDENT_WORDS - sizes->page_count;
    return words < VXS_COMMON_HALVES_MAX / 2 ? 2 * words : VXS_COMMON_HALVES_MAX;
}

uint64_t vxs_resident_inflated_bytes(const vxs_resident_sizes *sizes)
{
    return 4 * (uint64_t)sizes->word_count + sizes->pattern_count;
}

vxs_result vxs_resident_unpack(vxs_resident *out, vxs_common_marks *marks, uint32_t levels, uint32_t map_count,
                               const uint8_t *bytes, size_t size_bytes, uint8_t *inflated, ZSTD_DCtx *zstd)
{
    vxs_resident_sizes sizes;
    if (vxs_resident_sizes_of(&sizes, bytes, size_bytes) != VXS_OK) return VXS_E_CORRUPT;
    if (!vxs_inflate_frame(inflated, vxs_resident_inflated_bytes(&sizes), bytes + RESIDENT_HEAD_BYTES,
                           size_bytes - RESIDENT_HEAD_BYTES, zstd))
        return VXS_E_CORRUPT;
    for (uint32_t n = 0; n < sizes.word_count; n++) out->words[n] = vxs_load32(inflated + 4 * (size_t)n);
    checked_resident r    = {&sizes, out->words, levels, RESIDENT_WORDS + sizes.page_count, out->nodes, out->page_first, 0, 0};
    int              good = check_tops(&r, map_count) && check_common(&r, inflated + 4 * (size_t)sizes.word_count, marks);
    return good ? VXS_OK : VXS_E_CORRUPT;
}
