/* Check of stored patterns, for pages and the common pool packed fast. Internal to vxs_page_check.c and
 * vxs_resident_check.c. Not installed.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_PATTERN_CHECK_H
#define VXS_PATTERN_CHECK_H

#include "vxs_page_layout.h"

/* The pool that contains the patterns. */
typedef struct checked_pool {
    const uint32_t *words;
    uint32_t        half_end;
} checked_pool;

/* Number of halves from `half` to the end of the pool. */
static uint32_t halves_left(const checked_pool *p, uint32_t half)
{
    return p->half_end - half;
}

/* Delta n of those that start at a half: bytes, halves, or two halves each. */
static uint32_t delta_at(const uint32_t *words, uint32_t half, uint32_t width, uint32_t n)
{
    if (width == 0) return get_byte(words, 2 * half + n);
    if (width == 1) return get_half(words, half + n);
    return get_half(words, half + 2 * n) | get_half(words, half + 2 * n + 1) << 16;
}

/* Deltas of a palette must be ascending, above zero, and within DEPTH_END. A padding byte must be 0. */
static int check_deltas(const uint32_t *words, uint32_t half, uint32_t width, uint32_t shift, uint32_t count)
{
    uint32_t last = 0;
    for (uint32_t n = 0; n < count; n++) {
        uint32_t delta = delta_at(words, half, width, n);
        if (delta <= last || (uint64_t)delta << shift >= DEPTH_END) return 0;
        last = delta;
    }
    return 1;
}

/* An image of indices: each index must be valid, and masks must need more space. */
static int check_image(const checked_pool *p, uint32_t half, uint32_t depths)
{
    uint32_t size = depths / 2;
    if (halves_left(p, half) < INDEX_HALVES || get_half(p->words, half) != 0xff) return 0;
    for (uint32_t c = 0; c < 4; c++) {
        uint32_t met = 0;
        for (uint32_t n = 0; n < 16; n++) met |= 1u << (get_byte(p->words, 2 * half + 2 + 16 * (c & 1) + n) >> 4 * (c >> 1) & 15);
        if (met >> depths) return 0;
        size += count_bits(met) - 1; /* the last depth has no mask */
    }
    return size > INDEX_HALVES;
}

/* Whether the halves of a quadrant are masks, neither empty nor full; each must contain all texels of the previous one, and
 * more. */
static int check_halves(const checked_pool *p, uint32_t half, uint32_t count)
{
    uint32_t last = 0, wrong = 0;
    for (uint32_t n = 0; n < count; n++) {
        uint32_t mask = get_half(p->words, half + n);
        wrong |= (last & ~mask) | (mask == last) | (mask == 0xffff);
        last = mask;
    }
    return !wrong;
}

/* Number of halves of a pattern over `depths` depths; 0: invalid. A byte has the state of a mask in each quadrant. In each
 * quadrant the states must be: no texels, then halves, which may repeat, then all texels. */
static uint32_t check_pattern(const checked_pool *p, uint32_t half, uint32_t depths)
{
    const uint32_t *words = p->words;
    uint32_t        left = halves_left(p, half), size = depths / 2, begun = 0, full = 0, wrong = 0, counts = 0;
    if (left < size) return 0;
    if (get_byte(words, 2 * half) == 0xff) return check_image(p, half, depths) ? INDEX_HALVES : 0;
    for (uint32_t n = 0; n + 1 < depths; n++) {
        uint32_t states = get_byte(words, 2 * half + n), low = states & 0x55, high = states >> 1 & 0x55;
        uint32_t is_new = high & ~low, again = high & low, all = low & ~high;
        wrong |= (~(low | high) & 0x55 & (begun | full)) | (full & ~all) | (again & ~begun);
        begun |= is_new;
        full |= all;
        counts += is_new * 0x41041 & 0x01010101; /* a byte for each quadrant */
    }
    if (depths % 2 == 0) wrong |= get_byte(words, 2 * half + depths - 1);
    uint32_t halves = counts * 0x01010101 >> 24;
    if (wrong || halves > left - size || size + halves > INDEX_HALVES) return 0;
    for (uint32_t c = 0; c < 4; size += counts >> 8 * c++ & 0xff)
        if (!check_halves(p, half + size, counts >> 8 * c & 0xff)) return 0;
    return size;
}

/* Number of halves of a private-palette pattern; 0: invalid. */
static uint32_t check_private(const checked_pool *p, uint32_t half)
{
    if (!halves_left(p, half)) return 0;
    uint32_t head = get_half(p->words, half), kind = head >> 12, shift = head >> 8 & 15, low = head & 0xff;
    if (kind <= PRIVATE_WORDS) { /* a palette of `low` depths, then the pattern */
        uint32_t first = half + 1, deltas = low - 1;
        if (low < 2 || low > DEPTHS_MAX) return 0;
        uint32_t halves = private_delta_halves(kind, deltas);
        if (halves_left(p, first) <= halves || !check_deltas(p->words, first, kind, shift, deltas)) return 0;
        if (kind == PRIVATE_BYTES && deltas % 2 && get_byte(p->words, 2 * first + deltas)) return 0;
        uint32_t pattern = check_pattern(p, first + halves, low);
        return pattern ? 1 + halves + pattern : 0;
    }
    if (kind >= PRIVATE_KINDS || private_halves[kind] > halves_left(p, half)) return 0;
    if (kind < PRIVATE_PLANE) { /* depths without a palette: each must be within DEPTH_END */
        for (uint32_t z = 0; z < 64; z++)
            if ((uint64_t)raw_depth(p->words, half, kind, z) << shift >= DEPTH_END) return 0;
        return low ? 0 : private_halves[kind];
    }
    uint32_t quarters = kind == PRIVATE_PLANE ? 3u << 3 : 15u << 3, far_shift = low & 7;
    if (shift > PLANE_SHIFT_MAX || low & ~(quarters | 7) || far_shift > (kind == PRIVATE_PLANE ? 0 : FAR_SHIFT_MAX)) return 0;
    return private_halves[kind];
}

/* Number of halves of a pattern of a kind (VXS_PATTERN_KINDS) that starts at a half; 0: invalid, or not within the pool. */
static inline uint32_t check_pattern_of(const checked_pool *p, uint32_t half, uint32_t kind)
{
    return kind == KIND_PRIVATE ? check_private(p, half) : check_pattern(p, half, kind);
}

#endif
