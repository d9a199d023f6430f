/* Shares of a texture's light for each sample; see area_sites.h.
 * SPDX-License-Identifier: MIT */
#include <math.h>

#include "area_sites.h"

enum { PIECES = 64 }; /* across and down; each belongs to one VPL */

/* Length of the part of [begin, end] in [from, to]. */
static double overlap(double begin, double end, double from, double to)
{
    return fmax(fmin(end, to) - fmax(begin, from), 0);
}

/* Add the light of a piece, times its share of the picture. */
static void add_piece(const area_picture *p, uint32_t across, uint32_t down, double sum[3])
{
    double top = down / (double)PIECES, bottom = (down + 1) / (double)PIECES, wide = p->wide_px / (double)PIECES,
           left = across * wide, right = left + wide; /* in texels */
    for (uint32_t y = vxs_area_row_of(p, top); y < p->high_px && vxs_area_before_row(p, y) < bottom; y++) {
        double part = overlap(vxs_area_before_row(p, y), vxs_area_before_row(p, y + 1), top, bottom) / p->wide_px;
        for (uint32_t x = (uint32_t)left; x < p->wide_px && x < right; x++) {
            double       of_it = part * overlap(x, x + 1, left, right);
            const float *texel = vxs_area_texel_of(p, x, y);
            for (int n = 0; n < 3; n++) sum[n] += of_it * (double)texel[n];
        }
    }
}

static uint32_t nearest_of(const double (*places)[3], uint32_t count, const double place[3])
{
    double   least   = INFINITY;
    uint32_t nearest = 0;
    for (uint32_t n = 0; n < count; n++) {
        double off[3] = {places[n][0] - place[0], places[n][1] - place[1], places[n][2] - place[2]};
        double square = off[0] * off[0] + off[1] * off[1] + off[2] * off[2];
        if (!(square < least)) continue;
        least   = square;
        nearest = n;
    }
    return nearest;
}

void vxs_area_share_light(const area_picture *p, area_site *sites, uint32_t count)
{
    double places[VXS_VPLS_MAX][3];
    for (uint32_t n = 0; n < count; n++) {
        vxs_area_place_of(p, sites[n].u, sites[n].v, places[n]);
        sites[n].light[0] = sites[n].light[1] = sites[n].light[2] = 0;
    }
    for (uint32_t piece = 0; piece < PIECES * PIECES; piece++) {
        uint32_t across = piece % PIECES, down = piece / PIECES;
        double   middle[3];
        vxs_area_place_of(p, (across + 0.5) / PIECES, (down + 0.5) / PIECES, middle);
        add_piece(p, across, down, sites[nearest_of(places, count, middle)].light);
    }
    for (uint32_t n = 0; n < count; n++)
        for (int i = 0; i < 3; i++) sites[n].light[i] *= count;
}
