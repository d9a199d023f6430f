/* Logarithm and exponential for inner loops: within 1 ulp, and the same bits on every processor, for one number and for vectors.
 * For other places, portable_math.h is more exact.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef PORTABLE_QUICK_H
#define PORTABLE_QUICK_H

#include <math.h>
#include <stdint.h>
#include <string.h>

/* Define name(x), the logarithm of x within 1 ulp, for positive normal x; 0 and denormal x give a number below -708.
 * real  double, or a vector of doubles
 * bits  uint64_t, or a vector of as many uint64_t
 *
 * x = 2^k m with m in [sqrt 1/2, sqrt 2), f = m - 1 and s = f / (2 + f). Then log m = 2 artanh s = 2 s + s R(s^2) =
 * f - (f^2 / 2 - s (f^2 / 2 + R(s^2))), in which the large term f is exact. R(z) = 2/3 z + 2/5 z^2 + ... is a minimax polynomial
 * of degree 7, with an error below 2^-58. */
#define PORTABLE_LOG(name, real, bits)                                                                                             \
    static inline real name(real x)                                                                                                \
    {                                                                                                                              \
        const uint64_t root_half = 0x3fe6a09e667f3bcd, mantissa = 0x000fffffffffffff, shift = 0x4330000000000000; /* 2^52 */       \
        bits           of_x, of_m, of_k;                                                                                           \
        real           m, k;                                                                                                       \
        memcpy(&of_x, &x, sizeof x);                                                                                               \
        of_x += 0x3ff0000000000000 - root_half;                                                                                    \
        of_m = (of_x & mantissa) + root_half;                                                                                      \
        of_k = (of_x >> 52) + shift;                                                                                               \
        memcpy(&m, &of_m, sizeof x);                                                                                               \
        memcpy(&k, &of_k, sizeof x);                                                                                               \
        k -= 0x1p52 + 1023;                                                                                                        \
        real f = m - 1, half = 0.5 * f * f, s = f / (2 + f), z = s * s;                                                            \
        real r = 0x1.39a1b6bf0ac1ep-3 + z * 0x1.2f058d691a1eap-3;                                                                  \
        r      = 0x1.c71c5208aff5cp-3 + z * (0x1.74663f0de842p-3 + z * r);                                                         \
        r      = z * (0x1.5555555555592p-1 + z * (0x1.999999997fdaap-2 + z * (0x1.24924941f1ee1p-2 + z * r)));                     \
        /* the first part of log 2 has 32 bits: times k it is exact */                                                             \
        return k * 0x1.62e42feep-1 - ((half - (s * (half + r) + k * 0x1.a39ef35793c76p-33)) - f);                                  \
    }

/* e^x within 1 ulp, 1.5 where the result is denormal, for x that is not NaN. x = k log 2 + r with |r| <= log(2) / 2; e^r by its
 * Taylor series. */
static inline double portable_quick_exp(double x)
{
    static const double per_factorial[] = {
        0x1.0000000000000p-1,  0x1.5555555555555p-3,  0x1.5555555555555p-5,  0x1.1111111111111p-7,
        0x1.6c16c16c16c17p-10, 0x1.a01a01a01a01ap-13, 0x1.a01a01a01a01ap-16, 0x1.71de3a556c734p-19,
        0x1.27e4fb7789f5cp-22, 0x1.ae64567f544e4p-26, 0x1.1eed8eff8d898p-29, 0x1.6124613a86d09p-33}; /* 1 / 2! to 1 / 13! */
    if (x > 710) return INFINITY;
    if (x < -746) return 0;
    /* a sum near 2^52 is rounded to a whole number; the first part of log 2 has 32 bits: times k it is exact */
    double k = (x * 0x1.71547652b82fep+0 + 0x1.8p52) - 0x1.8p52, head = x - k * 0x1.62e42feep-1, rest = k * 0x1.a39ef35793c76p-33;
    double r = head - rest, lost = (head - r) - rest, square = r * r, even = 0, odd = 0;
    for (int n = 10; n >= 0; n -= 2) {
        even = even * square + per_factorial[n];
        odd  = odd * square + per_factorial[n + 1];
    }
    double left = 1 + (r + (square * (even + r * odd) + lost)), power;
    if (fabs(k) > 1021) return ldexp(left, (int)k);
    uint64_t bits = (uint64_t)((int64_t)k + 1023) << 52; /* 2^k */
    memcpy(&power, &bits, sizeof power);
    return left * power;
}

#endif
