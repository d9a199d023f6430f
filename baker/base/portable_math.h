/* Functions of real numbers that give the same bits on every processor and with every C library.
 *
 * The baker's files depend on their results, and a C library may choose among variants by the processor (with and without fused
 * multiply-add). These use only +, -, *, /, sqrt, floor, and exact operations on bits, which IEEE 754 defines. Numbers are
 * computed as sums of two doubles (double-double) and rounded once: each result is within 0.5001 ulp of the true one, 1 ulp where
 * it is denormal. tests/unit/test_portable_math.c compares them with MPFR.
 *
 * A call takes 0.1 to 1 us. portable_quick.h has functions for inner loops.
 * Threads: no state.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef PORTABLE_MATH_H
#define PORTABLE_MATH_H

#ifdef __cplusplus
extern "C" {
#endif

/* Results for NaN, infinities, zeros and arguments outside the domain are those of C's functions. Errors are not put into errno. */
double portable_exp(double x);
double portable_log(double x);

/* x^y for x >= 0. Negative x: NaN. */
double portable_pow(double x, double y);

/* Radians of any size. */
double portable_sin(double x);
double portable_cos(double x);
double portable_tan(double x);
double portable_asin(double x);
double portable_acos(double x);

double portable_cbrt(double x);

#ifdef __cplusplus
}
#endif
#endif
