/* See area_reference.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "tests/volumes/area_reference.h"

#include <math.h>

#include "baker/base/random.h"
#include "baker/base/vec3.h"

#define PI 3.14159265358979323846

static double radical_inverse(uint32_t n, uint32_t base)
{
    double sum = 0, part = 1.0 / base;
    for (; n; n /= base, part /= base) sum += part * (n % base);
    return sum;
}

static double shifted(uint32_t n, uint32_t base, double shift)
{
    double at = radical_inverse(n, base) + shift;
    return at - floor(at);
}

/* A place of the rectangle, and what it sends along its normal from a square metre, times the area of all.   normal  as long as
 * that area */
static void place_of(const area_source *source, double u, double v, double place_ws[3], double normal[3], double sent[3])
{
    const vxs_area_rectangle *r     = source->rectangle;
    size_t                    texel = r->texture ? (size_t)(v * r->high_px) * r->wide_px + (size_t)(u * r->wide_px) : 0;
    for (int n = 0; n < 3; n++) {
        int a = (n + 1) % 3, b = (n + 2) % 3;
        place_ws[n] = source->origin_ws[n] + (double)r->corner[n] + u * (double)r->across[n] + v * (double)r->up[n];
        normal[n]   = (double)r->across[a] * (double)r->up[b] - (double)r->across[b] * (double)r->up[a];
        sent[n]     = (double)r->radiance[n] * (r->texture ? (double)r->texture[3 * texel + (size_t)n] : 1);
    }
}

static double phase(double g, double cosine)
{
    return (1 - g * g) / (4 * PI * pow(1 + g * g - 2 * g * cosine, 1.5));
}

/* One place of the rectangle and one of the ray, `share` of the angle along it. */
static void add_sample(const area_source *source, const fog_medium *f, const double from_ws[3], const double normal[3],
                       const double sent[3], const double eye_ws[3], const double direction[3], double metres, double share,
                       double to[3])
{
    double way[3], at[3], out[3];
    vec3_sub(from_ws, eye_ws, way);
    double along = vec3_dot(way, direction), beside = sqrt(fmax(vec3_dot(way, way) - along * along, 1e-18));
    double begin = atan(-along / beside), end = atan((metres - along) / beside);
    double x = fmin(fmax(along + beside * tan(begin + share * (end - begin)), 0), metres);
    for (int n = 0; n < 3; n++) {
        at[n]  = eye_ws[n] + x * direction[n];
        out[n] = at[n] - from_ws[n];
    }
    double square = vec3_dot(out, out), r = sqrt(square), cosine = vec3_dot(normal, out) / r;
    if (!(cosine > 0) || !source->is_free(source->user, from_ws, at)) return;
    double sum = cosine * phase(f->anisotropy, -vec3_dot(out, direction) / r) * (end - begin) / beside;
    for (int n = 0; n < 3; n++) to[n] += sent[n] * sum * f->scattering[n] * exp(-f->extinction[n] * (x + r));
}

double area_reference_add(const area_source *source, const fog_medium *f, const double eye_ws[3], const double direction[3],
                          double metres, uint32_t samples, uint64_t ray, double to[3])
{
    rng    r = {ray + 1};
    double shift[3], halves[2][3] = {{0}}, square = 0;
    for (int n = 0; n < 3; n++) shift[n] = rng_unit(&r);
    for (uint32_t n = 0; n < samples; n++) {
        double from[3], normal[3], sent[3];
        place_of(source, shifted(n + 1, 2, shift[0]), shifted(n + 1, 3, shift[1]), from, normal, sent);
        add_sample(source, f, from, normal, sent, eye_ws, direction, metres, shifted(n + 1, 5, shift[2]), halves[n >= samples / 2]);
    }
    for (int n = 0; n < 3; n++) {
        to[n] += (halves[0][n] + halves[1][n]) / samples;
        square += pow((halves[0][n] - halves[1][n]) / samples, 2);
    }
    return sqrt(square / 3);
}
