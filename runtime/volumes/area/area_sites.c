/* Sample positions on emitting pictures; see area_sites.h.
 * SPDX-License-Identifier: MIT */
#include "area_sites.h"

#include <math.h>

#include "area_numbers.h"

int vxs_area_is_number(const float v[3], float least)
{
    for (int n = 0; n < 3; n++)
        if (!(v[n] >= least && isfinite(v[n]))) return 0;
    return 1;
}

static const double half_turn = 3.14159265358979324;

double vxs_area_before_row(const area_picture *p, uint32_t y)
{
    if (!p->is_sky) return y / (double)p->high_px;
    double half_sine = sin(0.5 * half_turn * y / p->high_px);
    return half_sine * half_sine;
}

uint32_t vxs_area_row_of(const area_picture *p, double v)
{
    uint32_t y = (uint32_t)(p->high_px * (p->is_sky ? 2 / half_turn * asin(sqrt(v)) : v));
    return y < p->high_px ? y : p->high_px - 1;
}

const float *vxs_area_texel_of(const area_picture *p, uint32_t x, uint32_t y)
{
    return p->texture + 3 * ((size_t)y * p->wide_px + x);
}

void vxs_area_place_of(const area_picture *p, double u, double v, double place[3])
{
    double across = 2 * sqrt(fmax(v * (1 - v), 0)); /* v may be rounded to above 1 */
    place[0]      = p->is_sky ? across * cos(2 * half_turn * u) : u * p->aspect;
    place[1]      = p->is_sky ? 1 - 2 * v : v;
    place[2]      = p->is_sky ? across * sin(2 * half_turn * u) : 0;
}

/* Luminance of linear colours with the primaries of Rec. 709. */
static double luminance_of(const area_picture *p, const float *texel)
{
    return 0.2126 * (double)texel[0] * (double)p->radiance[0] + 0.7152 * (double)texel[1] * (double)p->radiance[1] +
           0.0722 * (double)texel[2] * (double)p->radiance[2];
}

static double luminance_of_row(const area_picture *p, uint32_t y)
{
    double sum = 0;
    for (uint32_t x = 0; x < p->wide_px; x++) sum += luminance_of(p, vxs_area_texel_of(p, x, y));
    return sum;
}

/* Share of the picture of one texel of a row. */
static double part_of_texel(const area_picture *p, uint32_t y)
{
    return (vxs_area_before_row(p, y + 1) - vxs_area_before_row(p, y)) / p->wide_px;
}

static double luminance_of_all(const area_picture *p)
{
    double sum = 0;
    for (uint32_t y = 0; y < p->high_px; y++) sum += luminance_of_row(p, y) * part_of_texel(p, y);
    return sum;
}

static double fraction(double x)
{
    return x - floor(x);
}

static void halton(uint32_t seed, area_site *sites, uint32_t count)
{
    double shift[2] = {seed ? vxs_area_random(seed, 0) : 0, seed ? vxs_area_random(seed, 1) : 0};
    for (uint32_t n = 0; n < count; n++) {
        sites[n].u = fraction(vxs_area_radical_inverse(n + 1, 2) + shift[0]);
        sites[n].v = fraction(vxs_area_radical_inverse(n + 1, 3) + shift[1]);
    }
}

/* Hammersley points; if the number of points is known, they are more even than Halton points. */
static void hammersley(uint32_t seed, area_site *sites, uint32_t count)
{
    double shift[2] = {seed ? vxs_area_random(seed, 0) : 0, seed ? vxs_area_random(seed, 1) : 0};
    for (uint32_t n = 0; n < count; n++) {
        sites[n].u = fraction((n + 0.5) / count + shift[0]);
        sites[n].v = fraction(vxs_area_radical_inverse(n, 2) + 0.5 / count + shift[1]);
    }
}

/* Number of cells in a row, for `count` cells that are as square as possible. */
static uint32_t cells_across(const area_picture *p, uint32_t count)
{
    double   least  = INFINITY;
    uint32_t across = 1;
    for (uint32_t n = 1; n <= count; n++) {
        double off = fabs(log(p->aspect * (count / n) / n));
        if (count % n || off >= least) continue;
        least  = off;
        across = n;
    }
    return across;
}

/* The middles of cells, or random positions in them. */
static void in_cells(const area_picture *p, int is_jittered, uint32_t seed, area_site *sites, uint32_t count)
{
    uint32_t across = cells_across(p, count);
    for (uint32_t n = 0; n < count; n++) {
        double x = is_jittered ? vxs_area_random(seed, 2 * n) : 0.5, y = is_jittered ? vxs_area_random(seed, 2 * n + 1) : 0.5;
        sites[n].u = (n % across + x) / across;
        sites[n].v = (n / across + y) / (count / across);
    }
}

/* Warp a site into row y. Its u, as a share of the row's luminance, chooses the texel; in_row, [0, 1], is the position between
 * the row's edges. */
static void move_in_row(const area_picture *p, uint32_t y, double row, double in_row, double mean, area_site *s)
{
    double   left = s->u * row, here = 0;
    uint32_t x = 0, bright = 0;
    for (; x < p->wide_px; x++) {
        here = luminance_of(p, vxs_area_texel_of(p, x, y));
        if (here > 0) bright = x;
        if (left < here) break;
        left -= here;
    }
    if (x == p->wide_px) { /* rounding left a rest */
        here = luminance_of(p, vxs_area_texel_of(p, bright, y));
        left = 0.5 * here;
        x    = bright;
    }
    s->u = (x + left / here) / p->wide_px;
    s->v = vxs_area_before_row(p, y) + in_row * (vxs_area_before_row(p, y + 1) - vxs_area_before_row(p, y));
    for (int n = 0; n < 3; n++) s->light[n] = mean / here * (double)vxs_area_texel_of(p, x, y)[n];
}

/* Warp points to where the texture is bright: by rows, and by the texels of a row. */
static void by_importance(const area_picture *p, double all, area_site *sites, uint32_t count)
{
    double before                 = 0;
    int    is_moved[VXS_VPLS_MAX] = {0};
    for (uint32_t y = 0; y < p->high_px; y++) {
        double row = luminance_of_row(p, y), part = row * part_of_texel(p, y);
        for (uint32_t n = 0; n < count; n++) {
            double at = sites[n].v * all - before;
            if (is_moved[n] || !(part > 0) || !(at < part)) continue;
            is_moved[n] = 1;
            move_in_row(p, y, row, at > 0 ? at / part : 0, all, &sites[n]);
        }
        before += part;
    }
}

void vxs_area_sites(const area_picture *p, vxs_area_places places, uint32_t seed, area_site *sites, uint32_t count)
{
    if (places == VXS_AREA_HALTON)
        halton(seed, sites, count);
    else if (places == VXS_AREA_IMPORTANCE)
        hammersley(seed, sites, count);
    else
        in_cells(p, places == VXS_AREA_JITTERED, seed, sites, count);
    for (uint32_t n = 0; n < count; n++)
        for (int i = 0; i < 3; i++) sites[n].light[i] = 1;
    if (!p->texture) return;
    double all = places == VXS_AREA_IMPORTANCE ? luminance_of_all(p) : 0;
    if (all > 0)
        by_importance(p, all, sites, count);
    else
        vxs_area_share_light(p, sites, count);
}
