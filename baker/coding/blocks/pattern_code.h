/* Encodes patterns as halves for lookups (formats/vxs.md, "Patterns").
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef PATTERN_CODE_H
#define PATTERN_CODE_H

#include <stdint.h>

enum { PATTERN_HALVES_MAX = 17, OWN_HALVES_MAX = 97, OWN_DEPTHS_MAX = 16 };

/* Number of trailing zero bits that depths have in common, at most 15.   bits  the depths, or-ed together */
static inline uint32_t common_shift(uint32_t bits)
{
    uint32_t shift = 0;
    while (bits && shift < 15 && !(bits >> shift & 1)) shift++;
    return shift;
}

/* index  [64] depth of each texel, [0, depths);   depths  [2, OWN_DEPTHS_MAX];   halves  [out] [PATTERN_HALVES_MAX]
 * Returns the number of halves. */
uint32_t pattern_encode(const uint8_t index[64], int depths, uint16_t *halves);

/* depth  [64] each [0, 2^24);   halves  [out] [OWN_HALVES_MAX]. Returns the number of halves, in the smallest form. */
uint32_t own_encode(const int32_t depth[64], uint16_t *halves);

#endif
