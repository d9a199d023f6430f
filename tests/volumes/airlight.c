/* Airlight by adaptive quadrature; see airlight.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "tests/volumes/airlight.h"
#include "baker/base/spread.h"

#include <gsl/gsl_errno.h>
#include <gsl/gsl_integration.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>

/* A ray and one channel; from  where the piece begins, less `along`. */
typedef struct integrand {
    const air_passing *p;
    double             from, extinction, g;
} integrand;

static gsl_integration_workspace *workspace(void)
{
    static gsl_integration_workspace *space;
    if (space) return space;
    gsl_set_error_handler_off(); /* its estimates of error are cautious where little is left */
    return space = gsl_integration_workspace_alloc(1000);
}

/* Henyey and Greenstein.   less  1 - cosine */
static double phase_of(double g, double less)
{
    double wide = (1 - g) * (1 - g) + 2 * g * less;
    return (1 - g * g) / (4 * M_PI * wide * sqrt(wide));
}

/* What lies in fog of the straight way between two heights, as a share of it. */
static double share_below(double top, double a, double b)
{
    double low = fmin(a, b), high = fmax(a, b);
    return high <= top ? 1 : low >= top ? 0 : (top - low) / (high - low);
}

double air_way_of(const air_passing *p, double x)
{
    double height = p->up * x, r = hypot(p->beside, x - p->along);
    if (!p->has_top) return x + r;
    return x * share_below(p->top, 0, height) + r * share_below(p->top, p->punctual, height);
}

static double punctual_at(double s, void *user)
{
    const integrand   *n = user;
    const air_passing *p = n->p;
    double             y = n->from + s, r = hypot(p->beside, y), rim = 1;
    double             less = y < 0 ? p->beside * p->beside / (r * (r - y)) : 1 + y / r;
    if (p->is_spot) rim = ((p->before + y * p->facing) / r - p->cos_outer) / fmax(1e-3, p->cos_inner - p->cos_outer);
    rim = fmin(fmax(rim, 0), 1);
    if (!p->is_face) rim *= rim;
    if (p->range > 0) rim *= fmax(1 - pow(r / p->range, 4), 0);
    return rim * phase_of(n->g, less) * exp(-n->extinction * air_way_of(p, p->along + y)) / (r * r);
}

air_passing air_passing_of(const double direction[3], const double to_light[3], double radius, const double *axis, double cos_inner,
                           double cos_outer)
{
    air_passing p      = {.cos_inner = cos_inner, .cos_outer = cos_outer, .is_spot = axis != NULL};
    double      square = 0;
    for (int i = 0; i < 3; i++) {
        int    a = (i + 1) % 3, b = (i + 2) % 3;
        double across = to_light[a] * direction[b] - to_light[b] * direction[a];
        square += across * across;
        p.along += direction[i] * to_light[i];
        if (axis) p.facing += direction[i] * axis[i];
    }
    for (int i = 0; i < 3 && axis; i++) p.before += (p.along * direction[i] - to_light[i]) * axis[i];
    p.beside = fmax(sqrt(square), radius);
    return p;
}

/* In pieces that grow away from where the ray is nearest to the light, and from its begin as fast as light is lost; below a top
 * from both ends. */
double air_of_punctual(const air_passing *p, double g, double extinction, double begin, double length)
{
    enum { PIECES = 500 };
    integrand    n = {p, begin - p->along, extinction, g};
    gsl_function f = {punctual_at, &n};
    double       ends[PIECES], sum = 0, nearest = -n.from;
    int          count = 0;
    ends[count++]      = 0;
    ends[count++]      = length;
    ends[count++]      = nearest;
    for (double step = 1e-3; step < 1e9; step *= 4) {
        ends[count++] = nearest - step * p->beside;
        ends[count++] = nearest + step * p->beside;
    }
    for (double depth = 0.1; extinction > 0 && depth < 800; depth *= 2) ends[count++] = depth / extinction;
    for (double part = 0.25; p->has_top && part > 1e-12; part /= 4) {
        ends[count++] = length * part;
        ends[count++] = length - length * part;
    }
    for (double part = 0.25; part < 1.01; part += 0.25) { /* of the range */
        double half = p->range * p->range * part * part - p->beside * p->beside;
        if (!(half > 0)) continue;
        ends[count++] = nearest - sqrt(half);
        ends[count++] = nearest + sqrt(half);
    }
    if (p->is_spot) /* the ends of its rim */
        for (int k = 1; k < 128; k++) ends[count++] = length * k / 128;
    qsort(ends, (size_t)count, sizeof *ends, doubles_ascending);
    for (int k = 0; k + 1 < count; k++) {
        double from = fmax(ends[k], 0), to = fmin(ends[k + 1], length), part = 0, error = 0;
        if (to <= from) continue;
        gsl_integration_qag(&f, from, to, 0, 1e-9, 1000, GSL_INTEG_GAUSS21, workspace(), &part, &error);
        sum += part;
    }
    return sum;
}

static double sun_at(double x, void *user)
{
    const double *n = user; /* extinction, way at x = 0, slope */
    return exp(-n[0] * (n[1] + n[2] * x));
}

double air_of_sun(double cosine, double g, double extinction, double way, double slope, double begin, double length)
{
    enum { PIECES = 16 };
    double       numbers[3] = {extinction, way, slope}, sum = 0;
    gsl_function f = {sun_at, numbers};
    for (int k = 0; k < PIECES; k++) {
        double part = 0, error = 0, from = begin + length * k / PIECES, to = begin + length * (k + 1) / PIECES;
        gsl_integration_qag(&f, from, to, 0, 1e-9, 1000, GSL_INTEG_GAUSS21, workspace(), &part, &error);
        sum += part;
    }
    return phase_of(g, 1 - cosine) * sum;
}
