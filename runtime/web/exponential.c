/* exp() of the runtime as WebAssembly. That of the C library takes 2.5 KB, most of it a table; this one has none.
 *
 * With x = k ln 2 + r and |r| <= ln 2 / 2, e^x is 2^k e^r, and e^r = 1 + 2 r / (r coth(r / 2) - r). The series of r coth(r / 2) is
 * 2 + r^2 / 6 - r^4 / 360 + ...: each term is less than a 300th of the one before it.
 * SPDX-License-Identifier: MIT */
#include <math.h>
#include <stdint.h>
#include <string.h>

/* 2^k, for normal numbers */
static double power_of_two(int k)
{
    uint64_t bits = (uint64_t)(1023 + k) << 52;
    double   power;
    memcpy(&power, &bits, sizeof power);
    return power;
}

/* Errors are less than an ulp, or, of subnormal results, than the least number. */
double exp(double x)
{
    static const double ln2_head = 0x1.62e42feep-1, ln2_rest = 0x1.a39ef35793c76p-33; /* k ln2_head is exact */
    if (!(x > -746)) return x < 0 ? 0 : x;                                            /* also NaN */
    if (x > 710) return INFINITY;
    double k = rint(x * 0x1.71547652b82fep+0), head = x - k * ln2_head, rest = k * ln2_rest, r = head - rest, r2 = r * r;
    double far  = 1. / 604800 - r2 * (1. / 23950080 - r2 * (691. / 653837184000));
    double tail = r2 * (1. / 6 - r2 * (1. / 360 - r2 * (1. / 15120 - r2 * far)));
    double most = r - tail, power = 1 + (head - (rest - r * most / (2 - most)));
    int    half = (int)k / 2;
    return power * power_of_two(half) * power_of_two((int)k - half);
}
