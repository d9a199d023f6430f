/* Z-order (Morton order) of the leaves of a quadtree: numbers the squares of a grid with a power of two a side.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef Z_ORDER_H
#define Z_ORDER_H

#include <stdint.h>

typedef struct z_place {
    uint32_t i, j; /* [0, 2^16) column and row */
} z_place;

/* Compact the even bits of n: bit 2 i becomes bit i. */
static inline uint32_t z_even_bits(uint32_t n)
{
    uint32_t even = 0;
    for (uint32_t bit = 0; bit < 16; bit++) even |= (n >> 2 * bit & 1) << bit;
    return even;
}

/* Position of square n. */
static inline z_place z_order(uint32_t n)
{
    return (z_place){z_even_bits(n), z_even_bits(n >> 1)};
}

/* Number of the square at a position. */
static inline uint32_t z_number(z_place at)
{
    uint32_t n = 0;
    for (uint32_t bit = 0; bit < 16; bit++) n |= (at.i >> bit & 1) << 2 * bit | (at.j >> bit & 1) << (2 * bit + 1);
    return n;
}

#endif
