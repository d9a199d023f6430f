/* The order in which a quadtree's leaves are met: squares of a power of two a side, numbered along a Z of Zs.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef Z_ORDER_H
#define Z_ORDER_H

#include <stdint.h>

typedef struct z_place {
    uint32_t i, j; /* [0, 2^16) column and row */
} z_place;

/* Every other bit of n, from the lowest on, close together. */
static inline uint32_t z_even_bits(uint32_t n)
{
    uint32_t even = 0;
    for (uint32_t bit = 0; bit < 16; bit++) even |= (n >> 2 * bit & 1) << bit;
    return even;
}

/* Where square n is. */
static inline z_place z_order(uint32_t n)
{
    return (z_place){z_even_bits(n), z_even_bits(n >> 1)};
}

/* The number of a square. */
static inline uint32_t z_number(z_place at)
{
    uint32_t n = 0;
    for (uint32_t bit = 0; bit < 16; bit++) n |= (at.i >> bit & 1) << 2 * bit | (at.j >> bit & 1) << (2 * bit + 1);
    return n;
}

#endif
