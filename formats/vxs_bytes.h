/* Little-endian numbers in byte arrays, for any byte order and alignment of the machine. The caller checks the bounds.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_BYTES_H
#define VXS_BYTES_H

#include <stdint.h>
#include <string.h>

#ifdef __GNUC__
#define VXS_BYTES_FN static inline __attribute__((always_inline))
#else
#define VXS_BYTES_FN static inline
#endif

VXS_BYTES_FN uint16_t vxs_load16(const uint8_t *p)
{
    return (uint16_t)(p[0] | p[1] << 8);
}

VXS_BYTES_FN uint32_t vxs_load32(const uint8_t *p)
{
    return vxs_load16(p) | (uint32_t)vxs_load16(p + 2) << 16;
}

VXS_BYTES_FN uint64_t vxs_load64(const uint8_t *p)
{
    return vxs_load32(p) | (uint64_t)vxs_load32(p + 4) << 32;
}

VXS_BYTES_FN double vxs_load_f64(const uint8_t *p)
{
    uint64_t bits = vxs_load64(p);
    double   value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

VXS_BYTES_FN void vxs_store16(uint8_t *p, uint16_t v)
{
    p[0] = (uint8_t)v;
    p[1] = (uint8_t)(v >> 8);
}

VXS_BYTES_FN void vxs_store32(uint8_t *p, uint32_t v)
{
    vxs_store16(p, (uint16_t)v);
    vxs_store16(p + 2, (uint16_t)(v >> 16));
}

VXS_BYTES_FN void vxs_store64(uint8_t *p, uint64_t v)
{
    vxs_store32(p, (uint32_t)v);
    vxs_store32(p + 4, (uint32_t)(v >> 32));
}

VXS_BYTES_FN void vxs_store_f64(uint8_t *p, double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    vxs_store64(p, bits);
}

#endif
