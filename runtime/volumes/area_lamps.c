/* Virtual point lights of a rectangle; see vxs_area_light.h.
 * SPDX-License-Identifier: MIT */
#include <math.h>

#include "area_numbers.h"
#include "vxs_area_light.h"

/* Where a lamp is on the rectangle, [0, 1) of both sides, and what its texel's light is times. */
typedef struct site {
    double u, v, scale;
} site;

static int is_number(const float v[3], float least)
{
    for (int n = 0; n < 3; n++)
        if (!(v[n] >= least && isfinite(v[n]))) return 0;
    return 1;
}

/* The normal, of length 1.   Returns square metres; 0: it has no area. */
static double area_of(const vxs_area_rectangle *r, double normal[3])
{
    double square = 0;
    for (int n = 0; n < 3; n++) {
        int a = (n + 1) % 3, b = (n + 2) % 3;
        normal[n] = (double)r->across[a] * (double)r->up[b] - (double)r->across[b] * (double)r->up[a];
        square += normal[n] * normal[n];
    }
    double area = sqrt(square);
    for (int n = 0; n < 3 && area > 0; n++) normal[n] /= area;
    return isfinite(area) ? area : 0;
}

static const float *texel_of(const vxs_area_rectangle *r, uint32_t x, uint32_t y)
{
    static const float one[3] = {1, 1, 1};
    return r->texture ? r->texture + 3 * ((size_t)y * r->wide_px + x) : one;
}

static const float *texel_at(const vxs_area_rectangle *r, const site *at)
{
    if (!r->texture) return texel_of(r, 0, 0);
    uint32_t x = (uint32_t)(at->u * r->wide_px), y = (uint32_t)(at->v * r->high_px);
    return texel_of(r, x < r->wide_px ? x : r->wide_px - 1, y < r->high_px ? y : r->high_px - 1);
}

/* Of linear colours with the primaries of Rec. 709. */
static double luminance_of(const vxs_area_rectangle *r, const float *texel)
{
    return 0.2126 * (double)texel[0] * (double)r->radiance[0] + 0.7152 * (double)texel[1] * (double)r->radiance[1] +
           0.0722 * (double)texel[2] * (double)r->radiance[2];
}

static double luminance_of_row(const vxs_area_rectangle *r, uint32_t y)
{
    double sum = 0;
    for (uint32_t x = 0; x < r->wide_px; x++) sum += luminance_of(r, texel_of(r, x, y));
    return sum;
}

static double luminance_of_all(const vxs_area_rectangle *r)
{
    double sum = 0;
    for (uint32_t y = 0; y < r->high_px; y++) sum += luminance_of_row(r, y);
    return sum;
}

static double fraction(double x)
{
    return x - floor(x);
}

static void halton(uint32_t seed, site *sites, uint32_t count)
{
    double shift[2] = {seed ? vxs_area_random(seed, 0) : 0, seed ? vxs_area_random(seed, 1) : 0};
    for (uint32_t n = 0; n < count; n++) {
        sites[n].u = fraction(vxs_area_radical_inverse(n + 1, 2) + shift[0]);
        sites[n].v = fraction(vxs_area_radical_inverse(n + 1, 3) + shift[1]);
    }
}

static double length_of(const float v[3])
{
    return sqrt((double)v[0] * (double)v[0] + (double)v[1] * (double)v[1] + (double)v[2] * (double)v[2]);
}

/* Of so many cells, those in a row of the rectangle: they are as square as they can be. */
static uint32_t cells_across(const vxs_area_rectangle *r, uint32_t count)
{
    double   aspect = length_of(r->across) / length_of(r->up), least = INFINITY;
    uint32_t across = 1;
    for (uint32_t n = 1; n <= count; n++) {
        double off = fabs(log(aspect * (count / n) / n));
        if (count % n || off >= least) continue;
        least  = off;
        across = n;
    }
    return across;
}

/* The middles of cells; or, where they are jittered, random places in them. */
static void in_cells(const vxs_area_rectangle *r, int is_jittered, uint32_t seed, site *sites, uint32_t count)
{
    uint32_t across = cells_across(r, count);
    for (uint32_t n = 0; n < count; n++) {
        double x = is_jittered ? vxs_area_random(seed, 2 * n) : 0.5, y = is_jittered ? vxs_area_random(seed, 2 * n + 1) : 0.5;
        sites[n].u = (n % across + x) / across;
        sites[n].v = (n / across + y) / (count / across);
    }
}

/* A site whose v says how much of the luminance is before it: in a row that has the rest of that before its own end. */
static void move_in_row(const vxs_area_rectangle *r, uint32_t y, double row, double in_row, double mean, site *s)
{
    double   left = s->u * row, here = 0;
    uint32_t x = 0, bright = 0;
    for (; x < r->wide_px; x++) {
        here = luminance_of(r, texel_of(r, x, y));
        if (here > 0) bright = x;
        if (left < here) break;
        left -= here;
    }
    if (x == r->wide_px) { /* what is left is rounding */
        here = luminance_of(r, texel_of(r, bright, y));
        left = 0.5 * here;
        x    = bright;
    }
    s->u     = (x + left / here) / r->wide_px;
    s->v     = (y + in_row) / r->high_px;
    s->scale = mean / here;
}

/* Move points to where the texture is bright: by its rows, and by the texels of a row. */
static void by_importance(const vxs_area_rectangle *r, site *sites, uint32_t count)
{
    double all = luminance_of_all(r), before = 0;
    int    is_moved[VXS_AREA_LAMPS] = {0};
    if (!r->texture || !(all > 0)) return;
    for (uint32_t y = 0; y < r->high_px; y++) {
        double row = luminance_of_row(r, y);
        for (uint32_t n = 0; n < count; n++) {
            double at = sites[n].v * all - before;
            if (is_moved[n] || !(row > 0) || !(at < row)) continue;
            is_moved[n] = 1;
            move_in_row(r, y, row, at > 0 ? at / row : 0, all / r->wide_px / r->high_px, &sites[n]);
        }
        before += row;
    }
}

static void choose(const vxs_area_rectangle *r, vxs_area_places places, uint32_t seed, site *sites, uint32_t count)
{
    for (uint32_t n = 0; n < count; n++) sites[n].scale = 1;
    if (places == VXS_AREA_HALTON || places == VXS_AREA_IMPORTANCE)
        halton(seed, sites, count);
    else
        in_cells(r, places == VXS_AREA_JITTERED, seed, sites, count);
    if (places == VXS_AREA_IMPORTANCE) by_importance(r, sites, count);
}

vxs_result vxs_area_sample(const vxs_area_rectangle *r, vxs_area_places places, uint32_t seed, vxs_area_lamp *lamps, uint32_t count)
{
    site   sites[VXS_AREA_LAMPS];
    double normal[3], area = area_of(r, normal);
    if (!count || count > VXS_AREA_LAMPS || (unsigned)places > VXS_AREA_JITTERED || !(area > 0)) return VXS_E_ARGUMENT;
    if (!is_number(r->corner, -INFINITY) || !is_number(r->radiance, 0)) return VXS_E_ARGUMENT;
    if (r->texture && (!r->wide_px || !r->high_px)) return VXS_E_ARGUMENT;
    choose(r, places, seed, sites, count);
    for (uint32_t n = 0; n < count; n++) {
        const site  *at    = &sites[n];
        const float *texel = texel_at(r, at);
        for (int i = 0; i < 3; i++) {
            lamps[n].place[i]  = (float)((double)r->corner[i] + at->u * (double)r->across[i] + at->v * (double)r->up[i]);
            lamps[n].normal[i] = (float)normal[i];
            lamps[n].colour[i] = (float)((double)r->radiance[i] * (double)texel[i] * at->scale * area / count);
        }
        lamps[n].radius_metres = (float)sqrt(area / count / 3.14159265358979324);
    }
    return VXS_OK;
}
