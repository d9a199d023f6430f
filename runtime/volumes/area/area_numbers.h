/* Evenly distributed numbers, and reproducible pseudo-random numbers. Not installed.
 * SPDX-License-Identifier: MIT */
#ifndef AREA_NUMBERS_H
#define AREA_NUMBERS_H

#include "vxs_area_grid.h"

/* Radical inverse of n: its digits in a base, mirrored at the point, [0, 1). For n = 0, 1, 2... they fill the interval evenly;
 * two bases without a common factor fill a square [Halton 1960]. */
static inline double vxs_area_radical_inverse(uint32_t n, uint32_t base)
{
    double sum = 0, digit = 1;
    for (; n; n /= base) sum += (n % base) * (digit /= base);
    return sum;
}

/* Pseudo-random number n of a seed, [0, 1). */
static inline double vxs_area_random(uint32_t seed, uint32_t n)
{
    return vxs_area_hash(vxs_area_hash(seed) + n) / 4294967296.0;
}

#endif
