/* Functions of baker/base/portable_math.h, portable_quick.h and runtime/web/exponential.c against MPFR: many random arguments and hard ones.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/base/portable_math.h"

#include <math.h>
#include <mpfr.h>
#include <stdio.h>

#include "baker/base/portable_quick.h"
#include "baker/base/random.h"
#include "repeats.h"

double web_exp(double x);
#define exp web_exp /* that of the runtime as WebAssembly */
#include "runtime/web/exponential.c"
#undef exp

/* last: it needs the four headers above it */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

enum { BITS = 400, LANES = 2 };

typedef double   reals __attribute__((vector_size(8 * LANES)));
typedef uint64_t words __attribute__((vector_size(8 * LANES)));

PORTABLE_LOG(log_of_one, double, uint64_t)
PORTABLE_LOG(log_of_lanes, reals, words)

typedef int mpfr_one(mpfr_t, const mpfr_t, mpfr_rnd_t);
typedef int mpfr_two(mpfr_t, const mpfr_t, const mpfr_t, mpfr_rnd_t);

/* Distance of two results in units of the last place of the true one. */
static double ulps_off(const mpfr_t truth, double got)
{
    double nearest = mpfr_get_d(truth, MPFR_RNDN);
    if (isnan(nearest) || isnan(got)) return isnan(nearest) && isnan(got) ? 0 : INFINITY;
    if (isinf(nearest) || isinf(got)) return nearest == got ? 0 : INFINITY;
    if (nearest == got) {
        if (signbit(nearest) != signbit(got)) return INFINITY;
        if (nearest == 0) return 0;
    }
    int power;
    frexp(nearest, &power);
    double ulp = ldexp(1, (power < -1021 ? -1021 : power) - 53), off;
    mpfr_t rest;
    mpfr_init2(rest, BITS);
    mpfr_sub_d(rest, truth, got, MPFR_RNDN);
    mpfr_div_d(rest, rest, ulp, MPFR_RNDN);
    off = fabs(mpfr_get_d(rest, MPFR_RNDN));
    mpfr_clear(rest);
    return off;
}

/* The largest differences of one function. */
typedef struct error {
    const char *name;
    double      most, most_denormal, at[3];
} error;

static void count_error(error *e, const mpfr_t truth, double got, double x, double y, double z)
{
    double  off  = ulps_off(truth, got);
    double *most = fabs(got) < 0x1p-1022 ? &e->most_denormal : &e->most;
    if (off <= *most) return;
    *most    = off;
    e->at[0] = x;
    e->at[1] = y;
    e->at[2] = z;
}

static void check_error(const error *e, double limit)
{
    if (e->most > limit || e->most_denormal > 1.5)
        fail_msg("%s: %.6g ulp off, %.6g where denormal, at %a %a %a", e->name, e->most, e->most_denormal, e->at[0], e->at[1],
                 e->at[2]);
}

/* arguments -------------------------------------------------------------------------------------------------------------------- */

/* A double with random bits, of any size. */
static double any_double(rng *r)
{
    uint64_t bits = (uint64_t)rng_u32(r) << 32 | rng_u32(r);
    double   x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

static double unit(rng *r)
{
    return rng_unit(r) + 0x1p-32 * rng_unit(r);
}

/* x moved by up to 4 ulp. */
static double near(rng *r, double x)
{
    for (uint32_t n = rng_below(r, 9); n > 4; n--) x = nextafter(x, INFINITY);
    for (uint32_t n = rng_below(r, 9); n > 4; n--) x = nextafter(x, -INFINITY);
    return x;
}

static const double special[] = {
    0, -0.0, 1, -1, 2, -2, 0.5, -0.5, INFINITY, -INFINITY, NAN, 0x1p-1074, -0x1p-1074, 0x1p-1022, 0x1.fffffffffffffp+1023,
    -0x1.fffffffffffffp+1023, 0x1.6a09e667f3bcdp-1, 0x1.6a09e667f3bcdp+0, 0x1p-30, 0x1p-31, 0x1p30, 709.782712893384,
    709.7827128933841, -745.1332191019411, -745.1332191019412, -708.3964185322641, 1e-300, 1e300,
    /* hard to reduce: 6381956970095103 * 2^797 is nearest to a multiple of pi / 2 of all doubles */
    0x1.6ac5b262ca1ffp+849, 0x1.921fb54442d18p+0, 0x1.921fb54442d18p+1, 0x1.2d97c7f3321d2p+2, 0x1.921fb54442d18p+2};

enum { SPECIALS = sizeof special / sizeof *special };

/* Argument n for functions of one number: the special ones, then some of any size, some near 0 and 1, and near quarter turns. */
static double argument(rng *r, size_t n)
{
    if (n < SPECIALS) return special[n];
    switch (n % 8) {
    case 0: return any_double(r);
    case 1: return near(r, 1);
    case 2: return near(r, rng_u32(r) * 1.5707963267948966);
    case 3: return (2 * unit(r) - 1) * 750;
    case 4: return ldexp(unit(r), -(int)rng_below(r, 1074));
    case 5: return 1 + ldexp(2 * unit(r) - 1, -(int)rng_below(r, 50));
    case 6: return near(r, (2 * unit(r) - 1) * 8);
    default: return 2 * unit(r) - 1;
    }
}

/* tests ------------------------------------------------------------------------------------------------------------------------ */

static const struct {
    const char *name;
    double (*ours)(double);
    mpfr_one *truth;
} of_one[] = {{"exp", portable_exp, mpfr_exp},     {"log", portable_log, mpfr_log},
              {"sin", portable_sin, mpfr_sin},     {"cos", portable_cos, mpfr_cos},
              {"tan", portable_tan, mpfr_tan},     {"asin", portable_asin, mpfr_asin},
              {"acos", portable_acos, mpfr_acos},  {"cbrt", portable_cbrt, mpfr_cbrt},
              {"quick log", log_of_one, mpfr_log}, {"quick exp", portable_quick_exp, mpfr_exp},
              {"web exp", web_exp, mpfr_exp}};

static void functions_of_one_number(void **state)
{
    (void)state;
    mpfr_t x, truth;
    mpfr_init2(x, 53);
    mpfr_init2(truth, BITS);
    for (size_t f = 0; f < sizeof of_one / sizeof *of_one; f++) {
        error e      = {.name = of_one[f].name};
        rng   r      = rng_split(1, f);
        int   is_log = of_one[f].ours == log_of_one, is_quick = is_log || of_one[f].ours == portable_quick_exp;
        for (size_t n = 0; n < repeats(20000, 2000000); n++) {
            double at = argument(&r, n);
            if ((is_log && !(at >= 0x1p-1022 && at < INFINITY)) || (is_quick && isnan(at))) continue;
            mpfr_set_d(x, at, MPFR_RNDN);
            of_one[f].truth(truth, x, MPFR_RNDN);
            count_error(&e, truth, of_one[f].ours(at), at, 0, 0);
        }
        check_error(&e, is_quick || of_one[f].ours == web_exp ? 1 : 0.5001);
    }
    mpfr_clear(x);
    mpfr_clear(truth);
}

static void powers(void **state)
{
    (void)state;
    error  e = {.name = "pow"};
    rng    r = {2};
    mpfr_t x, y, truth;
    mpfr_init2(x, 53);
    mpfr_init2(y, 53);
    mpfr_init2(truth, BITS);
    for (size_t n = 0; n < repeats(20000, 2000000); n++) {
        double base  = fabs(n < SPECIALS * SPECIALS ? special[n % SPECIALS] : argument(&r, n));
        double power = n < SPECIALS * SPECIALS ? special[n / SPECIALS]
                       : n % 3                 ? argument(&r, n)
                                               : (2 * unit(&r) - 1) * 745 / log(base);
        mpfr_set_d(x, base, MPFR_RNDN);
        mpfr_set_d(y, power, MPFR_RNDN);
        mpfr_pow(truth, x, y, MPFR_RNDN);
        count_error(&e, truth, portable_pow(base, power), base, power, 0);
    }
    check_error(&e, 0.501);
    assert_true(isnan(portable_pow(-1, 2)));
    mpfr_clear(x);
    mpfr_clear(y);
    mpfr_clear(truth);
}

/* One number and lanes of a vector, bit by bit; 0 and denormal numbers are less than the logarithm of any normal one. */
static void logarithms_of_lanes(void **state)
{
    (void)state;
    rng r = {4};
    for (size_t n = 0; n < 100000; n++) {
        reals x, got;
        for (int k = 0; k < LANES; k++) x[k] = fabs(argument(&r, n + (size_t)k));
        got = log_of_lanes(x);
        for (int k = 0; k < LANES; k++) {
            double one = log_of_one(x[k]), lane = got[k];
            assert_memory_equal(&one, &lane, sizeof one);
            if (x[k] < 0x1p-1022) assert_true(one < -708);
        }
    }
    assert_true(log_of_one(1) == 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(functions_of_one_number), cmocka_unit_test(powers),
                                       cmocka_unit_test(logarithms_of_lanes)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
