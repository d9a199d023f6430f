/* Layout of the words of pages (formats/vxs.md 13.2, 13.3), shared by all code that reads or writes them. Internal to
 * vxs_page_*.c. Not installed.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_PAGE_LAYOUT_H
#define VXS_PAGE_LAYOUT_H

#include "vxs_bytes.h"
#include "vxs_page.h"

enum {
    NODE_HALVES     = 11, /* halves of a node before its lists */
    PALETTE_MAX     = 14,
    DEPTHS_MAX      = 16,      /* of a private-palette pattern */
    DEPTH_END       = 1 << 24, /* all depths and bases are nearer to 0 than this, so that sums fit 32 bits */
    REF_COMMON      = 0x20000,
    KIND_PRIVATE    = 0,
    INDEX_HALVES    = 17, /* size of a pattern stored as an image of indices */
    PLANE_SHIFT_MAX = 8,
    FAR_SHIFT_MAX   = 5,
};

/* Kinds of private-palette patterns, bits 12..15 of the first half. */
enum {
    PRIVATE_BYTES,
    PRIVATE_HALVES,
    PRIVATE_WORDS,
    PRIVATE_NIBBLES,
    PRIVATE_RAW1,
    PRIVATE_RAW2,
    PRIVATE_RAW3,
    PRIVATE_PLANE,
    PRIVATE_NEARER,
    PRIVATE_FARTHER,
    PRIVATE_MASK,
    PRIVATE_KINDS,
};

/* Size in halves of the patterns without a palette. */
static const uint32_t private_halves[PRIVATE_KINDS] = {0, 0, 0, 1 + 2 + 16, 1 + 32, 1 + 64, 1 + 96, 1 + 2, 1 + 5, 1 + 5, 1 + 5 + 4};

VXS_BYTES_FN uint32_t get_half(const uint32_t *words, uint32_t half)
{
    return words[half >> 1] >> 16 * (half & 1) & 0xffff;
}

/* The half must be 0 before. */
VXS_BYTES_FN void put_half(uint32_t *words, uint32_t half, uint32_t value)
{
    words[half >> 1] |= (value & 0xffff) << 16 * (half & 1);
}

VXS_BYTES_FN uint32_t get_byte(const uint32_t *words, uint32_t byte)
{
    return words[byte >> 2] >> 8 * (byte & 3) & 0xff;
}

/* The byte must be 0 before. */
VXS_BYTES_FN void put_byte(uint32_t *words, uint32_t byte, uint32_t value)
{
    words[byte >> 2] |= (value & 0xff) << 8 * (byte & 3);
}

static inline uint32_t count_bits(uint32_t x)
{
    x -= x >> 1 & 0x55555555;
    x = (x & 0x33333333) + (x >> 2 & 0x33333333);
    return ((x + (x >> 4)) & 0x0f0f0f0f) * 0x01010101 >> 24;
}

/* Words of a block's record before those of its tiles: two more if tiles lie on a plane. */
static inline uint32_t head_words(uint32_t mixed, uint32_t own)
{
    return own & ~mixed & 0xffff ? 4 : 2;
}

/* Halves of the deltas of a private palette. */
static inline uint32_t private_delta_halves(uint32_t kind, uint32_t deltas)
{
    return kind == PRIVATE_BYTES ? (deltas + 1) / 2 : kind == PRIVATE_HALVES ? deltas : 2 * deltas;
}

/* Depth of texel z of a raw pattern, before the shift. */
static inline uint32_t raw_depth(const uint32_t *words, uint32_t half, uint32_t kind, uint32_t z)
{
    uint32_t byte = 2 * half + 2;
    if (kind == PRIVATE_NIBBLES)
        return get_byte(words, byte + z / 16) + (get_byte(words, byte + 4 + (z & 31)) >> (z >> 5) * 4 & 15);
    if (kind == PRIVATE_RAW1) return get_byte(words, byte + z);
    if (kind == PRIVATE_RAW2) return get_half(words, half + 1 + z);
    return get_byte(words, byte + 3 * z) | get_byte(words, byte + 3 * z + 1) << 8 | get_byte(words, byte + 3 * z + 2) << 16;
}

/* For unchecked words: 0 if `at` is beyond the end. */
static inline uint32_t word_or_zero(const uint32_t *words, uint32_t word_count, uint32_t at)
{
    return at < word_count ? words[at] : 0;
}

/* Number of words before the pool of an unchecked page: up to the first pattern that a tile refers to, or all words. Nodes
 * and blocks have no gaps, so that they can be walked without interpreting them. */
static inline uint32_t node_words_of(const uint32_t *words, uint32_t word_count, const vxs_page_node *nodes, uint32_t node_count)
{
    uint32_t least = 2 * word_count;
    for (uint32_t n = 0; n < node_count; n++) {
        uint32_t from = nodes[n].offset, name = 2 * from + NODE_HALVES, name_end = name;
        for (uint32_t k = 0; k < 2; k++) name_end += count_bits(word_or_zero(words, word_count, from + k));
        for (; name < name_end; name++) {
            uint32_t at    = word_or_zero(words, word_count, name / 2) >> 16 * (name & 1) & 0xffff;
            uint32_t mixed = word_or_zero(words, word_count, at) & 0xffff;
            uint32_t tile = at + head_words(mixed, word_or_zero(words, word_count, at + 1)), tile_end = tile + count_bits(mixed);
            for (; tile < tile_end; tile++) {
                uint32_t ref = word_or_zero(words, word_count, tile) >> 14;
                least        = ref < least ? ref : least;
            }
        }
    }
    return least / 2;
}

#endif
