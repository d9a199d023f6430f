/* Small functions of integers.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef INTEGER_H
#define INTEGER_H

#include <stdint.h>

static inline uint32_t min_u32(uint32_t a, uint32_t b)
{
    return a < b ? a : b;
}

static inline uint32_t max_u32(uint32_t a, uint32_t b)
{
    return a > b ? a : b;
}

static inline int32_t min_i32(int32_t a, int32_t b)
{
    return a < b ? a : b;
}

static inline int32_t max_i32(int32_t a, int32_t b)
{
    return a > b ? a : b;
}

static inline uint64_t min_u64(uint64_t a, uint64_t b)
{
    return a < b ? a : b;
}

static inline uint64_t max_u64(uint64_t a, uint64_t b)
{
    return a > b ? a : b;
}

/* Exponent of a power of two. */
static inline uint32_t log2_u32(uint32_t power)
{
    return 31 - (uint32_t)__builtin_clz(power | 1);
}

#endif
