/* Reading pages packed fast: checks their words; vxs_page_fast.h.
 *
 * The walk follows the order of records in 13.4 of formats/vxs.md: node by node, block by block, tile by tile. A new record
 * or pattern must be the next one in storage, and is checked there. Any other reference must point to the start of a checked
 * one. So each record is checked once, every word belongs to a record, and no word belongs to two.
 * SPDX-License-Identifier: MIT */
#include "vxs_page_fast.h"

#include <string.h>

#include "vxs_frame.h"
#include "vxs_pattern_check.h"

enum { PAGE_HEAD_BYTES = 4, MARK_BLOCK = 255 };

/* State of the check of a page. */
typedef struct checked_page {
    uint32_t       *words;
    uint32_t        word_count, node_words;
    uint32_t        word, half; /* where the next record and the next pattern must start */
    vxs_page_marks *marks;
    vxs_page_way    way;
} checked_page;

/* Whether a reference is that of the new record `next`. If so, convert it to the other direction. */
static int turn_new(const checked_page *p, uint32_t *name, uint32_t next)
{
    uint32_t stored = 0;
    if (*name != (p->way == VXS_PAGE_UNPACK ? stored : next)) return 0;
    *name = p->way == VXS_PAGE_UNPACK ? next : stored;
    return 1;
}

/* blocks ----------------------------------------------------------------------------------------------------------------------- */

/* The record of a block. */
typedef struct checked_block {
    uint32_t mixed, fresh, own, on; /* on: tiles on the plane */
    uint32_t entries, shift, width, far;
    uint32_t tiles, palette, fresh_byte, bases, end; /* where they start: in words; fresh_byte: in bytes */
} checked_block;

/* Read the first two words; 0: they are invalid, or the record is not within the words of nodes and blocks. */
static int read_block(const checked_page *p, checked_block *b)
{
    if (p->node_words - p->word < 2) return 0;
    uint32_t shape = p->words[p->word], head = p->words[p->word + 1];
    b->mixed   = shape & 0xffff;
    b->fresh   = shape >> 16;
    b->own     = head & 0xffff;
    b->on      = b->own & ~b->mixed;
    b->entries = (head >> 16 & 15) + 1;
    b->shift   = head >> 20 & 15;
    b->width   = head >> 24 & 3;
    b->far     = head >> 26 & 1;
    if (head >> 27 || b->entries > PALETTE_MAX || b->width > 2 || (b->width == 2 && b->shift)) return 0;

    uint32_t uniform = 0xffff & ~b->mixed & ~b->on;
    if (b->fresh & ~uniform || (uniform & (0 - uniform)) & ~b->fresh) return 0;
    b->tiles      = p->word + head_words(b->mixed, b->own);
    b->palette    = b->tiles + count_bits(b->mixed);
    b->fresh_byte = 4 * b->palette + ((b->entries - 1) << b->width);
    b->bases      = (b->fresh_byte + (count_bits(b->fresh) + 1) / 2 + 3) / 4;
    b->end        = b->bases + (b->far ? count_bits(b->own & b->mixed) : 0);
    return b->end <= p->node_words;
}

/* Palette entries of fresh tiles: each must be valid, and differ from the previous one; padding must be 0. */
static int check_fresh(const checked_page *p, const checked_block *b)
{
    uint32_t count = count_bits(b->fresh), last = PALETTE_MAX, byte = b->fresh_byte;
    for (uint32_t n = 0; n < count; n++) {
        uint32_t entry = get_byte(p->words, byte + n / 2) >> 4 * (n & 1) & 15;
        if (entry >= b->entries || entry == last) return 0;
        last = entry;
    }
    if (count % 2 && get_byte(p->words, byte + count / 2) >> 4) return 0;
    for (byte += (count + 1) / 2; byte % 4; byte++)
        if (get_byte(p->words, byte)) return 0;
    return 1;
}

/* own: not 0 if the tile has a private-palette pattern */
static int check_tile(checked_page *p, const checked_block *b, uint32_t *word, uint32_t own)
{
    uint32_t low = *word & 0x3fff, kind = KIND_PRIVATE;
    if (own && b->far && low) return 0;
    if (!own && (low >> b->entries || (kind = count_bits(low)) < 2)) return 0;

    /* the pattern that the word refers to */
    const vxs_common_marks *common = p->marks->common;
    uint32_t                name = *word >> 14, half = p->half, in_common = name & (REF_COMMON - 1);
    if (name & REF_COMMON) return in_common < common->half_count && common->at[in_common] == kind + 1;
    if (!turn_new(p, &name, half)) return name < half && p->marks->at[name] == kind + 1;
    uint32_t halves = check_pattern_of(&(checked_pool){p->words, 2 * p->word_count}, half, kind);
    if (!halves) return 0;
    p->marks->at[half] = (uint8_t)(kind + 1);
    p->half += halves;
    *word = name << 14 | (*word & 0x3fff);
    return 1;
}

/* Check the block that a half of a node refers to: a known one, or the one at the next word. */
static int check_block(checked_page *p, uint32_t half)
{
    uint32_t name = get_half(p->words, half), before = name;
    if (!turn_new(p, &name, p->word)) return name < p->word && p->marks->at[2 * name] == MARK_BLOCK;
    p->words[half / 2] ^= (name ^ before) << 16 * (half & 1);

    checked_block b;
    if (!read_block(p, &b)) return 0;
    if (b.on && (p->words[p->word + 3] & 15) > PLANE_SHIFT_MAX) return 0;
    if (!check_deltas(p->words, 2 * b.palette, b.width, b.shift, b.entries - 1) || !check_fresh(p, &b)) return 0;
    for (uint32_t n = b.bases; n < b.end; n++)
        if (p->words[n] + (DEPTH_END - 1) >= 2 * DEPTH_END - 1) return 0;
    uint32_t *word = p->words + b.tiles;
    for (uint32_t rest = b.mixed; rest; rest &= rest - 1)
        if (!check_tile(p, &b, word++, b.own & rest & (0 - rest))) return 0;
    p->marks->at[2 * p->word] = MARK_BLOCK;
    p->word                   = b.end;
    return 1;
}

/* nodes ------------------------------------------------------------------------------------------------------------------------ */

/* Depth or base number n of those that start at a half.   wide  1: each is two halves */
static uint32_t depth_at(const uint32_t *words, uint32_t half, uint32_t wide, uint32_t n)
{
    return delta_at(words, half, 1 + wide, n);
}

/* Check the node at the next word, and the blocks that no earlier node uses. */
static int check_node(checked_page *p, const vxs_page_node *node)
{
    const uint32_t *words = p->words;
    uint32_t        left = p->node_words - p->word, half = 2 * p->word;
    if (p->word != node->offset || left < (NODE_HALVES + 1) / 2) return 0;
    const uint32_t *n     = words + p->word;
    uint64_t        mixed = n[0] | (uint64_t)n[1] << 32, fresh = n[2] | (uint64_t)n[3] << 32, uniform = ~mixed;
    if (fresh & mixed || (uniform & (0 - uniform)) & ~fresh) return 0;
    uint32_t wide = get_half(words, half + NODE_HALVES - 1), blocks = count_bits(n[0]) + count_bits(n[1]),
             depths = count_bits(n[2]) + count_bits(n[3]), halves = NODE_HALVES + blocks + (1 + wide) * (blocks + depths);
    if (wide > 1 || (halves + 1) / 2 > left || (halves % 2 && get_half(words, half + halves))) return 0;

    uint32_t names = half + NODE_HALVES, bases = names + blocks;
    for (uint32_t k = 0; k < blocks; k++)
        if (depth_at(words, bases, wide, k) >= DEPTH_END) return 0;
    for (uint32_t k = 0, fresh_at = bases + blocks * (1 + wide); k < depths; k++) {
        /* depths of fresh blocks: each differs from the previous one, and is within range or "never" */
        uint32_t depth = depth_at(words, fresh_at, wide, k);
        if (k && depth == depth_at(words, fresh_at, wide, k - 1)) return 0;
        if (depth >= DEPTH_END && depth != ~0u) return 0;
    }
    p->word += (halves + 1) / 2;
    for (uint32_t b = 0; b < blocks; b++)
        if (!check_block(p, names + b)) return 0;
    return 1;
}

/* pages ------------------------------------------------------------------------------------------------------------------------ */

vxs_result vxs_page_check(uint32_t *words, uint32_t word_count, uint32_t node_words, const vxs_page_node *nodes,
                          uint32_t node_count, vxs_page_marks *marks, vxs_page_way way)
{
    checked_page p = {words, word_count, node_words, 0, 2 * node_words, marks, way};
    memset(marks->at, 0, 2 * (size_t)word_count);
    if (!node_count || node_words > word_count) return VXS_E_CORRUPT;
    for (uint32_t n = 0; n < node_count; n++)
        if (!check_node(&p, &nodes[n])) return VXS_E_CORRUPT;
    if (p.word != node_words || (p.half + 1) / 2 != word_count) return VXS_E_CORRUPT;
    return p.half % 2 && get_half(words, p.half) ? VXS_E_CORRUPT : VXS_OK;
}

vxs_result vxs_page_inflate(uint32_t *words, uint32_t word_count, const uint8_t *bytes, size_t size_bytes, ZSTD_DCtx *zstd)
{
    if (size_bytes < PAGE_HEAD_BYTES || vxs_page_word_count(bytes, size_bytes) != word_count) return VXS_E_CORRUPT;
    if (!vxs_inflate_frame(words, 4 * (size_t)word_count, bytes + PAGE_HEAD_BYTES, size_bytes - PAGE_HEAD_BYTES, zstd))
        return VXS_E_CORRUPT;
    for (uint32_t n = 0; n < word_count; n++) words[n] = vxs_load32((const uint8_t *)&words[n]);
    return VXS_OK;
}

uint32_t vxs_page_node_words(const uint8_t *bytes)
{
    return vxs_load16(bytes + 2) + 1u;
}
