/* Random numbers that are equal on all machines: integer arithmetic, and no hidden state.
 *
 * SplitMix64 (Steele, Lea, Flood: "Fast splittable pseudorandom number generators", OOPSLA 2014): a counter that steps by an odd
 * constant, and a bijective mix of it. Scenes use splitting: each block, cell or lattice point has its own stream, so its numbers
 * do not depend on how many were drawn elsewhere.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef RANDOM_H
#define RANDOM_H

#include <stdint.h>

typedef struct rng {
    uint64_t state;
} rng;

static inline uint64_t rng_mix(uint64_t x)
{
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return x ^ (x >> 31);
}

/* An independent stream for each (parent, key). The first parent is a seed, later ones are the `state` of the parent. */
static inline rng rng_split(uint64_t parent, uint64_t key)
{
    return (rng){rng_mix(rng_mix(parent + 0x9e3779b97f4a7c15u) + key)};
}

/* 32 uniform bits. */
static inline uint32_t rng_u32(rng *r)
{
    r->state += 0x9e3779b97f4a7c15u;
    return (uint32_t)(rng_mix(r->state) >> 32);
}

/* Uniform in [0, 1), a multiple of 2^-32. */
static inline double rng_unit(rng *r)
{
    return rng_u32(r) * 0x1p-32;
}

/* Uniform in [0, count), count > 0: the high word of a product. Low words that would bias the result are drawn again (Lemire: "Fast
 * random integer generation in an interval", 2019). */
static inline uint32_t rng_below(rng *r, uint32_t count)
{
    uint64_t product = (uint64_t)rng_u32(r) * count;
    if ((uint32_t)product < count) {
        uint32_t uneven = -count % count;
        while ((uint32_t)product < uneven) product = (uint64_t)rng_u32(r) * count;
    }
    return (uint32_t)(product >> 32);
}

/* Uniform in [low, high], both included. */
static inline int32_t rng_between(rng *r, int32_t low, int32_t high)
{
    return low + (int32_t)rng_below(r, (uint32_t)(high - low) + 1);
}

#endif
