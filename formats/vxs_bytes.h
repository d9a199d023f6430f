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

/* On machines of this byte order in one access, which compilers do not always make of single bytes. */
#if defined(__BYTE_ORDER__) && __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__
#define VXS_BYTES_OF(bits)                                                                                                         \
    VXS_BYTES_FN uint##bits##_t vxs_load##bits(const uint8_t *p)                                                                   \
    {                                                                                                                              \
        uint##bits##_t v;                                                                                                          \
        memcpy(&v, p, sizeof v);                                                                                                   \
        return v;                                                                                                                  \
    }                                                                                                                              \
    VXS_BYTES_FN void vxs_store##bits(uint8_t *p, uint##bits##_t v)                                                                \
    {                                                                                                                              \
        memcpy(p, &v, sizeof v);                                                                                                   \
    }
#else
#define VXS_BYTES_OF(bits)                                                                                                         \
    VXS_BYTES_FN uint##bits##_t vxs_load##bits(const uint8_t *p)                                                                   \
    {                                                                                                                              \
        uint##bits##_t v = 0;                                                                                                      \
        for (int n = 0; n < bits; n += 8) v = (uint##bits##_t)(v | (uint##bits##_t)p[n / 8] << n);                                 \
        return v;                                                                                                                  \
    }                                                                                                                              \
    VXS_BYTES_FN void vxs_store##bits(uint8_t *p, uint##bits##_t v)                                                                \
    {                                                                                                                              \
        for (int n = 0; n < bits; n += 8) p[n / 8] = (uint8_t)(v >> n);                                                            \
    }
#endif
VXS_BYTES_OF(16)
VXS_BYTES_OF(32)
VXS_BYTES_OF(64)

VXS_BYTES_FN double vxs_load_f64(const uint8_t *p)
{
    uint64_t bits = vxs_load64(p);
    double   value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

VXS_BYTES_FN void vxs_store_f64(uint8_t *p, double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    vxs_store64(p, bits);
}

#endif
