/* Codes of points, as formats/vxs.md section 16 stores them. Not installed.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_POINTS_H
#define VXS_POINTS_H

#include <stdint.h>

enum { VXS_POINT_PLANES = 6 }; /* bytes of a code */

/* A coordinate from bits 0, 3, 6, ... of a code; and the inverse. */
static inline uint16_t vxs_point_coordinate(uint64_t code)
{
    uint32_t found = 0;
    for (uint32_t n = 0; n < 16; n++) found |= (uint32_t)(code >> 3 * n & 1) << n;
    return (uint16_t)found;
}

static inline uint64_t vxs_point_code(uint32_t coordinate)
{
    uint64_t code = 0;
    for (uint32_t n = 0; n < 16; n++) code |= (uint64_t)(coordinate >> n & 1) << 3 * n;
    return code;
}

#endif
