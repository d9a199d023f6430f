/* Functions of real numbers in double-double arithmetic; see portable_math.h.
 *
 * Sums and products of two doubles are split into a rounded result and its exact error (Dekker: "A floating-point technique for
 * extending the available precision", 1971). Each function reduces its argument to a small range, adds up a Taylor series there
 * to about 100 bits, and rounds the sum to double. Arguments are scaled by powers of two first, so that no step overflows or loses
 * bits to underflow.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/base/portable_math.h"

#include <math.h>
#include <stdint.h>

/* The number hi + lo; |lo| is at most half an ulp of hi. */
typedef struct dd {
    double hi, lo;
} dd;

static const dd half_pi = {0x1.921fb54442d18p+0, 0x1.1a62633145c07p-54}, whole_pi = {0x1.921fb54442d18p+1, 0x1.1a62633145c07p-53};

/* arithmetic ------------------------------------------------------------------------------------------------------------------- */

/* For |a| >= |b|, or a = 0. */
static dd sum_of_ordered(double a, double b)
{
    double sum = a + b;
    return (dd){sum, b - (sum - a)};
}

static dd sum_of(double a, double b)
{
    double sum = a + b, from_b = sum - a;
    return (dd){sum, (a - (sum - from_b)) + (b - from_b)};
}

static dd product_of(double a, double b)
{
    const double split   = 0x1p27 + 1; /* halves of 26 bits, whose products are exact */
    double       product = a * b, c = split * a, d = split * b, a1 = c - (c - a), b1 = d - (d - b), a2 = a - a1, b2 = b - b1;
    return (dd){product, ((a1 * b1 - product) + a1 * b2 + a2 * b1) + a2 * b2};
}

static dd dd_of(double x)
{
    return (dd){x, 0};
}

static dd dd_negated(dd a)
{
    return (dd){-a.hi, -a.lo};
}

static dd dd_scaled(dd a, double power_of_two)
{
    return (dd){a.hi * power_of_two, a.lo * power_of_two};
}

static dd dd_add(dd a, dd b)
{
    dd hi = sum_of(a.hi, b.hi), lo = sum_of(a.lo, b.lo);
    hi = sum_of_ordered(hi.hi, hi.lo + lo.hi);
    return sum_of_ordered(hi.hi, hi.lo + lo.lo);
}

static dd dd_multiply(dd a, dd b)
{
    dd p = product_of(a.hi, b.hi);
    return sum_of_ordered(p.hi, p.lo + (a.hi * b.lo + a.lo * b.hi));
}

static dd dd_divide(dd a, dd b)
{
    double first  = a.hi / b.hi;
    dd     rest   = dd_add(a, dd_negated(dd_multiply(b, dd_of(first))));
    double second = rest.hi / b.hi;
    rest          = dd_add(rest, dd_negated(dd_multiply(b, dd_of(second))));
    dd sum        = sum_of_ordered(first, second);
    return sum_of_ordered(sum.hi, sum.lo + rest.hi / b.hi);
}

static dd dd_sqrt(dd a)
{
    double root = sqrt(a.hi);
    if (root == 0) return dd_of(0);
    dd rest = dd_add(a, dd_negated(product_of(root, root)));
    return sum_of_ordered(root, rest.hi / (2 * root));
}

/* 1 / n! */
static const dd per_factorial[] = {{1, 0},
                                   {1, 0},
                                   {0.5, 0},
                                   {0x1.5555555555555p-3, 0x1.5555555555555p-57},
                                   {0x1.5555555555555p-5, 0x1.5555555555555p-59},
                                   {0x1.1111111111111p-7, 0x1.1111111111111p-63},
                                   {0x1.6c16c16c16c17p-10, -0x1.f49f49f49f49fp-65},
                                   {0x1.a01a01a01a01ap-13, 0x1.a01a01a01a01ap-73},
                                   {0x1.a01a01a01a01ap-16, 0x1.a01a01a01a01ap-76},
                                   {0x1.71de3a556c734p-19, -0x1.c154f8ddc6c00p-73},
                                   {0x1.27e4fb7789f5cp-22, 0x1.cbbc05b4fa99ap-76},
                                   {0x1.ae64567f544e4p-26, -0x1.c062e06d1f209p-80},
                                   {0x1.1eed8eff8d898p-29, -0x1.2aec959e14c06p-83},
                                   {0x1.6124613a86d09p-33, 0x1.f28e0cc748ebep-87},
                                   {0x1.93974a8c07c9dp-37, 0x1.05d6f8a2efd1fp-92},
                                   {0x1.ae7f3e733b81fp-41, 0x1.1d8656b0ee8cbp-97},
                                   {0x1.ae7f3e733b81fp-45, 0x1.1d8656b0ee8cbp-101},
                                   {0x1.952c77030ad4ap-49, 0x1.ac981465ddc6cp-103},
                                   {0x1.6827863b97d97p-53, 0x1.eec01221a8b0bp-107},
                                   {0x1.2f49b46814157p-57, 0x1.2650f61dbdcb4p-112},
                                   {0x1.e542ba4020225p-62, 0x1.ea72b4afe3c2fp-120},
                                   {0x1.71b8ef6dcf572p-66, -0x1.d043ae40c4647p-120},
                                   {0x1.0ce396db7f853p-70, -0x1.aebcdbd20331cp-124}};

/* 1 / (2 n + 1) */
static const dd per_odd[] = {{1, 0},
                             {0x1.5555555555555p-2, 0x1.5555555555555p-56},
                             {0x1.999999999999ap-3, -0x1.999999999999ap-57},
                             {0x1.2492492492492p-3, 0x1.2492492492492p-57},
                             {0x1.c71c71c71c71cp-4, 0x1.c71c71c71c71cp-58},
                             {0x1.745d1745d1746p-4, -0x1.745d1745d1746p-59},
                             {0x1.3b13b13b13b14p-4, -0x1.3b13b13b13b14p-58},
                             {0x1.1111111111111p-4, 0x1.1111111111111p-60},
                             {0x1.e1e1e1e1e1e1ep-5, 0x1.e1e1e1e1e1e1ep-61},
                             {0x1.af286bca1af28p-5, 0x1.af286bca1af28p-59},
                             {0x1.8618618618618p-5, 0x1.8618618618618p-59},
                             {0x1.642c8590b2164p-5, 0x1.642c8590b2164p-60},
                             {0x1.47ae147ae147bp-5, -0x1.eb851eb851eb8p-61},
                             {0x1.2f684bda12f68p-5, 0x1.2f684bda12f68p-59},
                             {0x1.1a7b9611a7b96p-5, 0x1.1a7b9611a7b96p-61},
                             {0x1.0842108421084p-5, 0x1.0842108421084p-60}};

/* Sum of c[step n] x^n for n < count. From n = exact on, terms are less than 2^-20 of the sum, and double is enough for them. */
static dd series(const dd *c, int step, int count, int exact, dd x)
{
    double rest = 0;
    for (int n = count - 1; n >= exact; n--) rest = rest * x.hi + c[step * n].hi;
    dd sum = dd_of(rest);
    for (int n = exact - 1; n >= 0; n--) sum = dd_add(c[step * n], dd_multiply(sum, x));
    return sum;
}

/* exponentials and logarithms -------------------------------------------------------------------------------------------------- */

/* ln 2 in three parts; times a whole number below 2^11, the first one is exact */
static const double ln2_head = 0x1.62e42feep-1, ln2_rest = 0x1.a39ef35793c76p-33, ln2_tail = 0x1.cc01f97b57a08p-87;

static dd times_ln2(double whole)
{
    return dd_add(dd_of(whole * ln2_head), dd_multiply((dd){ln2_rest, ln2_tail}, dd_of(whole)));
}

/* e^x, rounded to double. */
static double exp_of(dd x)
{
    enum { HALVINGS = 6 };
    if (x.hi > 710) return INFINITY;
    if (x.hi < -746) return 0;
    double power = floor(x.hi / ln2_head + 0.5);
    dd     r     = dd_scaled(dd_add(x, dd_negated(times_ln2(power))), 1.0 / (1 << HALVINGS));
    /* e^r - 1, then (e^r)^2 - 1 = 2 (e^r - 1) + (e^r - 1)^2, which loses no digits */
    dd     less  = dd_multiply(r, series(per_factorial + 1, 1, 9, 3, r));
    for (int n = 0; n < HALVINGS; n++) less = dd_add(dd_scaled(less, 2), dd_multiply(less, less));
    dd whole = dd_add(dd_of(1), less);
    return ldexp(whole.hi, (int)power);
}

/* Logarithm of x > 0. x = 2^k m, log m = 2 artanh((m - 1) / (m + 1)). */
static dd log_of(double x)
{
    int    power;
    double m = frexp(x, &power);
    if (m < 0x1.6a09e667f3bcdp-1) {
        m *= 2;
        power--;
    }
    dd s = dd_divide(sum_of(m, -1), sum_of(m, 1)), square = dd_multiply(s, s);
    return dd_add(times_ln2(power), dd_scaled(dd_multiply(s, series(per_odd, 1, 15, 4, square)), 2));
}

double portable_exp(double x)
{
    return isnan(x) ? x : exp_of(dd_of(x));
}

double portable_log(double x)
{
    if (!(x > 0) || isinf(x)) return x < 0 ? NAN : x == 0 ? -INFINITY : x;
    return log_of(x).hi;
}

double portable_pow(double x, double y)
{
    if (y == 0 || x == 1) return 1;
    if (isnan(y) || !(x >= 0)) return NAN;
    if (x == 0 || isinf(x) || isinf(y)) return (x > 1) == (y > 0) ? INFINITY : 0;
    if (fabs(y) > 0x1p80) return (x > 1) == (y > 0) ? INFINITY : 0; /* |log x| is at least 2^-53 */
    if (fabs(y) < 0x1p-80) return 1;
    return exp_of(dd_multiply(log_of(x), dd_of(y)));
}

/* angles ----------------------------------------------------------------------------------------------------------------------- */

/* The fraction of 2 / pi, most significant bits first. */
static const uint32_t two_over_pi[40] = {
    0xa2f9836e, 0x4e441529, 0xfc2757d1, 0xf534ddc0, 0xdb629599, 0x3c439041, 0xfe5163ab, 0xdebbc561, 0xb7246e3a, 0x424dd2e0,
    0x06492eea, 0x09d1921c, 0xfe1deb1c, 0xb129a73e, 0xe88235f5, 0x2ebb4484, 0xe99c7026, 0xb45f7e41, 0x3991d639, 0x835339f4,
    0x9c845f8b, 0xbdf9283b, 0x1ff897ff, 0xde05980f, 0xef2f118b, 0x5a0a6d1f, 0x6d367ecf, 0x27cb09b7, 0x4f463f66, 0x9e5fea2d,
    0x7527bac7, 0xebe5f17b, 0x3d0739f7, 0x8a5292ea, 0x6bfb5fb1, 0x1f8d5d08, 0x56033046, 0xfc7b6bab, 0xf0cfbc20, 0x9af4361d};

/* Bits of 2 / pi, [first, first + 32); bit 0 is worth 1/2. Bits before it are 0. */
static uint32_t bits_of_two_over_pi(int first)
{
    if (first <= -32) return 0;
    if (first < 0) return two_over_pi[0] >> -first;
    uint32_t word = two_over_pi[first / 32] << first % 32;
    return first % 32 ? word | two_over_pi[first / 32 + 1] >> (32 - first % 32) : word;
}

/* x - n pi / 2, in [-pi / 4, pi / 4], for finite x with |x| >= 2^-30.   quarter  [out] n modulo 4
 * x 2 / pi is computed as a whole number times a window of the bits of 2 / pi: higher bits would give multiples of 4, lower ones
 * too little to matter (Payne and Hanek, 1983). No double is so near to a multiple of pi / 2 that the first 64 bits of the fraction
 * are equal. */
static dd reduced_angle(double x, int *quarter)
{
    enum { WORDS = 8 }; /* of the product: 2 bits for n, the rest are the fraction */
    int      power;
    uint64_t whole = (uint64_t)ldexp(frexp(fabs(x), &power), 53), low = whole & UINT32_MAX, high = whole >> 32, carry = 0;
    uint32_t product[WORDS];
    power -= 53;                           /* |x| = whole * 2^power */
    for (int n = WORDS - 1; n >= 0; n--) { /* word n of the product gets low * window[n] and high * window[n + 1], and carries */
        uint64_t a = low * bits_of_two_over_pi(power - 2 + 32 * n), b = high * bits_of_two_over_pi(power - 2 + 32 * (n + 1));
        uint64_t sum = (a & UINT32_MAX) + (b & UINT32_MAX) + (carry & UINT32_MAX);
        product[n]   = (uint32_t)sum;
        carry        = (a >> 32) + (b >> 32) + (carry >> 32) + (sum >> 32);
    }

    /* to the nearest multiple: a fraction of more than a half becomes negative */
    int n = (int)(product[0] >> 30), negative = product[0] >> 29 & 1;
    product[0] &= 0x1fffffff;
    dd     fraction = dd_of(negative ? -0.5 : 0);
    double scale    = 4;
    for (int k = 0; k < WORDS; k++) fraction = dd_add(fraction, dd_of(product[k] * (scale *= 0x1p-32)));
    *quarter = (x < 0 ? -(n + negative) : n + negative) & 3;
    fraction = dd_multiply(fraction, half_pi);
    return x < 0 ? dd_negated(fraction) : fraction;
}

static dd sin_near(dd r)
{
    return dd_multiply(r, series(per_factorial + 1, 2, 11, 5, dd_negated(dd_multiply(r, r))));
}

static dd cos_near(dd r)
{
    return series(per_factorial, 2, 12, 5, dd_negated(dd_multiply(r, r)));
}

/* sin(x + turn pi / 2) */
static double sin_turned(double x, int turn)
{
    int quarter;
    if (!isfinite(x)) return NAN;
    dd r = reduced_angle(x, &quarter);
    quarter += turn;
    dd at = quarter & 1 ? cos_near(r) : sin_near(r);
    return quarter & 2 ? -at.hi : at.hi;
}

double portable_sin(double x)
{
    return fabs(x) < 0x1p-30 ? x : sin_turned(x, 0);
}

double portable_cos(double x)
{
    return fabs(x) < 0x1p-30 ? 1 : sin_turned(x, 1);
}

double portable_tan(double x)
{
    int quarter;
    if (fabs(x) < 0x1p-30) return x;
    if (!isfinite(x)) return NAN;
    dd r = reduced_angle(x, &quarter), sine = sin_near(r), cosine = cos_near(r);
    return quarter & 1 ? -dd_divide(cosine, sine).hi : dd_divide(sine, cosine).hi;
}

/* Angle of the vector (x, y), x > 0, y >= 0. Each halving replaces y / x by the tangent of half the angle. */
static dd angle_of(dd x, dd y)
{
    enum { HALVINGS = 4 };
    dd t = dd_divide(y, x);
    for (int n = 0; n < HALVINGS; n++) t = dd_divide(t, dd_add(dd_of(1), dd_sqrt(dd_add(dd_of(1), dd_multiply(t, t)))));
    return dd_scaled(dd_multiply(t, series(per_odd, 1, 12, 4, dd_negated(dd_multiply(t, t)))), 1 << HALVINGS);
}

double portable_asin(double x)
{
    double size = fabs(x);
    if (!(size <= 1)) return NAN;
    if (size < 0x1p-30) return x;
    dd angle = half_pi;
    if (size < 1) angle = angle_of(dd_sqrt(dd_multiply(sum_of(1, -size), sum_of(1, size))), dd_of(size));
    return x < 0 ? -angle.hi : angle.hi;
}

/* The half angle has the tangent sqrt(1 - x) / sqrt(1 + x). */
double portable_acos(double x)
{
    if (!(fabs(x) <= 1)) return NAN;
    dd half = angle_of(dd_sqrt(sum_of(1, fabs(x))), dd_sqrt(sum_of(1, -fabs(x)))), angle = dd_scaled(half, 2);
    return x < 0 ? dd_add(whole_pi, dd_negated(angle)).hi : angle.hi;
}

/* roots ------------------------------------------------------------------------------------------------------------------------ */

double portable_cbrt(double x)
{
    int power;
    if (!isfinite(x) || x == 0) return x;
    double m     = frexp(fabs(x), &power);                                /* [1/2, 1) */
    int    third = (power + 3 * 400) / 3 - 400, rest = power - 3 * third; /* rest is 0, 1 or 2 */
    m           = ldexp(m, rest);
    double root = 1;
    for (int n = 0; n < 7; n++) root -= (root * root * root - m) / (3 * root * root); /* Newton's steps */
    dd cube = dd_multiply(product_of(root, root), dd_of(root)), off = dd_add(cube, dd_of(-m));
    return ldexp(x < 0 ? -(root - off.hi / (3 * root * root)) : root - off.hi / (3 * root * root), third);
}
