/* The pixels of a frame in which a light's airlight can be seen; see vxs_volumes.h.
 *
 * A ray that passes a punctual light at a distance h has an airlight of at most
 *
 *     I scattering p exp(-extinction D) pi / h
 *
 * D is the shortest path of light through the fog: the distance from the light to the eye; if one of them is above a level
 * top, the depth of the other below it. p is the maximum of the phase function. The integral of 1 / distance^2 along the whole
 * ray is pi / h.
 * So rays with more airlight than the bound pass through a sphere about the light. Rays that the light lights at all pass through
 * a sphere about its cone and range.
 * SPDX-License-Identifier: MIT */
#include <math.h>

#include "volumes_state.h"
#include "vxs_air_path.h"

typedef struct sphere {
    double middle[3], radius; /* from the eye; INFINITY: everything */
} sphere;

/* Rows that map a point, relative to the eye, to (u, v, 1) s, with s > 0 before the eye; and the vertical component of the
 * direction at (u, v): the sum of u, v and 1 times these. */
typedef struct projection {
    double u[3], v[3], s[3], rises[3];
} projection;

static double dot(const double *a, const double *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(const double *a, const double *b, double *out)
{
    for (int n = 0; n < 3; n++) out[n] = a[(n + 1) % 3] * b[(n + 2) % 3] - a[(n + 2) % 3] * b[(n + 1) % 3];
}

/* The direction at (u, v) is a sum u a + v b + c, where a, b, c are columns of the matrix minus the eye's position. The inverse
 * has the rows. Returns 0 if there is none. */
static int projection_of(const frame_block *f, projection *p)
{
    const float *m = f->point_from_depth;
    double       column[4][3], a[3], b[3], c[3];
    for (int k = 0; k < 4; k++)
        for (int n = 0; n < 3; n++) column[k][n] = (double)m[4 * k + n] - (double)f->eye[n] * (double)m[4 * k + 3];
    for (double depth = 0.125; depth < 1; depth += 0.25) { /* any depth that gives a point before the eye */
        double w = (double)m[3] * 0.5 + (double)m[7] * 0.5 + (double)m[11] * depth + (double)m[15], sign = w < 0 ? -1 : 1;
        for (int n = 0; n < 3; n++) {
            a[n] = sign * column[0][n];
            b[n] = sign * column[1][n];
            c[n] = sign * (column[3][n] + depth * column[2][n]);
        }
        cross(b, c, p->u);
        cross(c, a, p->v);
        cross(a, b, p->s);
        double size = dot(a, p->u);
        if (w == 0 || !(fabs(size) > 0) || !isfinite(size)) continue;
        for (int n = 0; n < 3; n++) {
            p->u[n] /= size;
            p->v[n] /= size;
            p->s[n] /= size;
        }
        p->rises[0] = a[1];
        p->rises[1] = b[1];
        p->rises[2] = c[1];
        return isfinite(dot(p->u, p->u) + dot(p->v, p->v) + dot(p->s, p->s));
    }
    return 0;
}

/* Whether a sphere is wholly on the far side of the plane where row = at s. */
static int is_beyond(const sphere *b, const double *row, const double *s, double at, double side)
{
    double normal[3];
    for (int n = 0; n < 3; n++) normal[n] = side * (row[n] - at * s[n]);
    return dot(normal, b->middle) < -b->radius * sqrt(dot(normal, normal));
}

/* Clip a range of pixels along an axis to those that may see a sphere.   range  [out] first, end */
static void narrow(const sphere *b, const double *row, const double *s, uint32_t count, uint32_t range[2])
{
    if (!(b->radius < INFINITY)) return;
    while (range[0] < range[1] && is_beyond(b, row, s, (double)(range[0] + 1) / count, -1)) range[0]++;
    while (range[0] < range[1] && is_beyond(b, row, s, (double)(range[1] - 1) / count, 1)) range[1]--;
}

/* The smallest sphere about a spot light's cone, or about the range of a punctual light. */
static sphere sphere_of_range(const frame_block *f)
{
    double range = (double)f->light.range_metres, cosine = fmin(fmax((double)f->light.cos_outer, 0), 1), along = 0;
    sphere b = {{0}, range > 0 ? range : INFINITY};
    if (f->light.kind != VXS_LIGHT_KIND_POINT && range > 0) {
        int narrow_cone = cosine > sqrt(0.5);
        along           = narrow_cone ? range / (2 * cosine) : range * cosine;
        b.radius        = narrow_cone ? along : range * sqrt(1 - cosine * cosine);
    }
    b.radius *= 1 + 1e-5;
    for (int n = 0; n < 3; n++) b.middle[n] = (double)f->place[n] + along * (double)f->axis[n] - (double)f->eye[n];
    return b;
}

/* Shortest path of light through the fog. */
static double metres_in_fog(const frame_block *f, double distance)
{
    double high = fmax((double)f->place[1], (double)f->eye[1]), low = fmin((double)f->place[1], (double)f->eye[1]);
    return high > (double)f->top_metres ? fmax((double)f->top_metres - low, 0) : distance;
}

/* Upper bound of a punctual light's airlight along a ray at a distance of 1 m; at other distances, divide by the distance. */
static double most_at_a_metre(const frame_block *f)
{
    const double pi = 3.14159265358979324;
    double       g = fabs((double)f->anisotropy), phase = (1 + g) / (4 * pi * (1 - g) * (1 - g)), most = 0, square = 0;
    for (int n = 0; n < 3; n++) square += ((double)f->place[n] - (double)f->eye[n]) * ((double)f->place[n] - (double)f->eye[n]);
    for (int n = 0; n < 3; n++)
        most = fmax(most, (double)f->colour[n] * (double)f->scattering[n] *
                              exp(-(double)f->extinction[n] * metres_in_fog(f, sqrt(square))));
    return pi * phase * most;
}

/* Upper bound of the sun's airlight. */
static double most_of_sun(const frame_block *f)
{
    const double pi = 3.14159265358979324;
    double       g = fabs((double)f->anisotropy), phase = (1 + g) / (4 * pi * (1 - g) * (1 - g)), most = 0;
    for (int n = 0; n < 3; n++) {
        double dense = (double)f->extinction[n],
               way   = dense > 0 ? -expm1(-dense * (double)f->far_metres) / dense : (double)f->far_metres;
        most         = fmax(most, phase * (double)f->colour[n] * (double)f->scattering[n] * way);
    }
    return most;
}

/* Whether no ray of the view gets below the top of the fog: all rays rise, or end before. */
static int is_view_clear(const frame_block *f, const projection *p)
{
    double above = (double)f->eye[1] - (double)f->top_metres;
    int    rise  = 1;
    for (int n = 0; n < 4; n++) rise &= p->rises[0] * (n & 1) + p->rises[1] * (n >> 1) + p->rises[2] >= 0;
    return above > 0 && (rise || above > (double)f->far_metres);
}

/* Whether no light gets below the top: the range ends above it, or the sun is below the horizon, where its light would cross
 * infinite fog. */
static int is_light_clear(const frame_block *f)
{
    sphere lit = sphere_of_range(f);
    if (!(f->top_metres < (float)VXS_AIR_EVERYWHERE)) return 0;
    if (f->light.kind == VXS_LIGHT_KIND_DIRECTIONAL) return !(f->place[1] > 0);
    return lit.middle[1] + (double)f->eye[1] - lit.radius > (double)f->top_metres;
}

double vxs_volumes_find_most(const vxs_volumes *v)
{
    const frame_block *f = &v->frame;
    return f->light.kind == VXS_LIGHT_KIND_DIRECTIONAL ? most_of_sun(f) : most_at_a_metre(f) / (double)f->radius_metres;
}

vxs_cull_result vxs_volumes_find_cull_result(const vxs_volumes *v, vxs_pixels *pixels)
{
    const frame_block *f    = &v->frame;
    uint32_t           wide = (uint32_t)f->wide_px, high = (uint32_t)f->high_px, across[2] = {0, wide}, up[2] = {0, high};
    double             least = (double)v->least;
    double             at_a_metre;
    projection         p;
    int                is_seen = projection_of(f, &p);
    *pixels                    = (vxs_pixels){0, 0, wide, high};
    if (is_light_clear(f) || (is_seen && is_view_clear(f, &p))) return VXS_CULLED_CLEAR;
    if (f->light.kind == VXS_LIGHT_KIND_DIRECTIONAL)
        return most_of_sun(f) > least || least == 0 ? VXS_NOT_CULLED : VXS_CULLED_FAINT;
    sphere lit = sphere_of_range(f), bright = {{0}, 0};
    for (int n = 0; n < 3; n++) bright.middle[n] = (double)f->place[n] - (double)f->eye[n];
    at_a_metre    = most_at_a_metre(f);
    bright.radius = least > 0 ? at_a_metre / least : INFINITY;
    if (bright.radius < (double)f->radius_metres) return VXS_CULLED_FAINT;
    if (!is_seen) return VXS_NOT_CULLED;
    const sphere *both[2] = {&lit, &bright};
    for (int n = 0; n < 2; n++) {
        narrow(both[n], p.u, p.s, wide, across);
        narrow(both[n], p.v, p.s, high, up);
        if (both[n]->radius < INFINITY && dot(p.s, both[n]->middle) < -both[n]->radius * sqrt(dot(p.s, p.s))) across[1] = across[0];
    }
    *pixels = (vxs_pixels){across[0], up[0], across[1] - across[0], up[1] - up[0]};
    return pixels->wide_px && pixels->high_px ? VXS_NOT_CULLED : VXS_CULLED_OFFSCREEN;
}
