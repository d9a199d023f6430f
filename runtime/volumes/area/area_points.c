/* Points of triangles; see vxs_area_light.h.
 * SPDX-License-Identifier: MIT */
#include <math.h>
#include <string.h>

#include "vxs_area_light.h"

static double area_of(const float *a, const float *b, const float *c)
{
    double square = 0;
    for (int n = 0; n < 3; n++) {
        int    i = (n + 1) % 3, j = (n + 2) % 3;
        double across = ((double)b[i] - (double)a[i]) * ((double)c[j] - (double)a[j]) -
                        ((double)b[j] - (double)a[j]) * ((double)c[i] - (double)a[i]);
        square += across * across;
    }
    return 0.5 * sqrt(square);
}

static double area_of_corners(const float *positions, const uint32_t *corner)
{
    return area_of(positions + 3 * (size_t)corner[0], positions + 3 * (size_t)corner[1], positions + 3 * (size_t)corner[2]);
}

/* The corner where the longest side begins. Halving this side avoids thin triangles. */
static int longest_side(const float *positions, const uint32_t *corner)
{
    double most = -1;
    int    side = 0;
    for (int n = 0; n < 3; n++) {
        const float *from = positions + 3 * (size_t)corner[n], *to = positions + 3 * (size_t)corner[(n + 1) % 3];
        double       square = 0;
        for (int i = 0; i < 3; i++) square += ((double)to[i] - (double)from[i]) * ((double)to[i] - (double)from[i]);
        if (!(square > most)) continue;
        most = square;
        side = n;
    }
    return side;
}

enum { BEGIN, END, BESIDE, CORNERS }; /* corners of a part of a triangle */

/* A part of a triangle; its corners are coordinates along the first two sides of the triangle. Sierpinski's curve runs from its
 * BEGIN to its END. */
typedef struct part {
    double at[CORNERS][2];
    double area;
} part;

static const double whole[CORNERS][2] = {{0, 0}, {1, 0}, {0, 1}};

/* Position of a point in its part of the curve: about the middle of that part's triangle. The middle of the curve would be a
 * corner, where up to four parts meet: four points of a square with a power of two of points would coincide. */
static const double in_its_part = 1.0 / 3;

/* Replace a part by one of its halves. */
static void halve(part *p, int is_behind)
{
    double middle[2] = {0.5 * (p->at[BEGIN][0] + p->at[END][0]), 0.5 * (p->at[BEGIN][1] + p->at[END][1])};
    memcpy(p->at[is_behind ? BEGIN : END], p->at[BESIDE], sizeof *p->at);
    memcpy(p->at[BESIDE], middle, sizeof *p->at);
    p->area *= 0.5;
}

static void place_of(const float *const v[CORNERS], const double at[2], double place[3])
{
    for (int i = 0; i < 3; i++) {
        double a = (double)v[0][i], b = (double)v[1][i], c = (double)v[2][i];
        place[i] = a + at[0] * (b - a) + at[1] * (c - a);
    }
}

/* The point at t, [0, 1), on Sierpinski's curve through a part of a triangle. Equal parts of the curve are connected and have
 * equal area. So evenly spaced points on the curve are evenly distributed on the triangle, and consecutive points are
 * neighbours. */
static vxs_area_point point_on(const float *const v[CORNERS], part p, double t, double area)
{
    enum { HALVINGS = 26 }; /* halvings that a float can resolve */
    vxs_area_point point = {.square_metres = (float)area};
    double         place[3];
    for (int n = 0; n < HALVINGS; n++) {
        int is_behind = t >= 0.5;
        halve(&p, is_behind);
        t = 2 * t - is_behind;
    }
    place_of(v, p.at[BEGIN], place);
    for (int i = 0; i < 3; i++) point.place[i] = (float)place[i];
    return point;
}

/* scattering by what VPLs see ------------------------------------------------------------------------------------------------- */

/* The share of all points that is distributed by area alone. */
static const double by_area = 0.25;

typedef struct scattering {
    const vxs_vpl  *vpls;
    uint32_t        vpl_count, count, next; /* number of points, and the next one */
    vxs_area_point *points;
    /* over all triangles: area, and light that they receive; the sum of both shares so far */
    double          area, seen, before;
} scattering;

/* Irradiance of a face turned toward the VPLs.   nearest  [out] metres to the nearest VPL, at least its radius */
static double seen_at(const scattering *s, const double place[3], double *nearest)
{
    double sum = 0;
    *nearest   = INFINITY;
    for (uint32_t n = 0; n < s->vpl_count; n++) {
        const vxs_vpl *vpl = &s->vpls[n];
        double         way[3], square = 0, along = 0, radius = (double)vpl->radius_metres;
        for (int i = 0; i < 3; i++) {
            way[i] = place[i] - (double)vpl->place[i];
            square += way[i] * way[i];
            along += way[i] * (double)vpl->normal[i];
        }
        double metres = fmax(sqrt(square), radius),
               bright = (double)vpl->colour[0] + (double)vpl->colour[1] + (double)vpl->colour[2];
        int has_side  = vpl->normal[0] != 0 || vpl->normal[1] != 0 || vpl->normal[2] != 0;
        *nearest      = fmin(*nearest, metres);
        sum += bright * (has_side ? fmax(along, 0) / metres : 1) / (metres * metres);
    }
    return sum;
}

/* Scatter the points of a part. It is halved until its longest side is at most half of the distance to the nearest VPL, so that
 * the light hardly varies on it. Without an array of points, only the light is summed. */
static void scatter_part(scattering *s, const float *const v[CORNERS], const part *p, int halvings)
{
    double places[CORNERS][3], middle[3], nearest, longest = 0;
    for (int n = 0; n < CORNERS; n++) place_of(v, p->at[n], places[n]);
    for (int i = 0; i < 3; i++) {
        middle[i] = (places[BEGIN][i] + places[END][i] + places[BESIDE][i]) / 3;
        longest += (places[END][i] - places[BEGIN][i]) * (places[END][i] - places[BEGIN][i]);
    }
    double seen = seen_at(s, middle, &nearest);
    if (longest > 0.25 * nearest * nearest && halvings > 0) {
        for (int behind = 0; behind < 2; behind++) {
            part half = *p;
            halve(&half, behind);
            scatter_part(s, v, &half, halvings - 1);
        }
        return;
    }
    if (!s->points) {
        s->seen += seen * p->area;
        return;
    }
    double density = by_area / s->area + (1 - by_area) * seen / s->seen, here = density * p->area;
    for (; s->next < s->count && s->next + in_its_part < (s->before + here) * s->count; s->next++)
        s->points[s->next] =
            point_on(v, *p, fmax(((s->next + in_its_part) / s->count - s->before) / here, 0), 1 / (density * s->count));
    s->before += here;
}

/* A whole triangle.   v  [out] its corners; the longest side is between the first two */
static part part_of(const float *positions, const uint32_t *corner, const float *v[CORNERS])
{
    part p     = {.area = area_of_corners(positions, corner)};
    int  first = longest_side(positions, corner);
    memcpy(p.at, whole, sizeof whole);
    for (int n = 0; n < CORNERS; n++) v[n] = positions + 3 * (size_t)corner[(first + n) % 3];
    return p;
}

double vxs_area_scatter(const float *positions, const uint32_t *corners, uint32_t triangle_count, vxs_area_point *points,
                        uint32_t count)
{
    double   all = 0, before = 0;
    uint32_t n = 0;
    for (uint32_t t = 0; t < triangle_count; t++) all += area_of_corners(positions, corners + 3 * (size_t)t);
    if (!(all > 0) || !isfinite(all)) return 0;
    for (uint32_t t = 0; t < triangle_count; t++) {
        const float *v[CORNERS];
        part         p = part_of(positions, corners + 3 * (size_t)t, v);
        for (; n < count && (n + in_its_part) * all < (before + p.area) * count; n++)
            points[n] = point_on(v, p, ((n + in_its_part) * all / count - before) / p.area, all / count);
        before += p.area;
    }
    return all;
}

double vxs_area_scatter_for(const float *positions, const uint32_t *corners, uint32_t triangle_count, const vxs_vpl *vpls,
                            uint32_t vpl_count, vxs_area_point *points, uint32_t count)
{
    enum { HALVINGS = 24 };
    scattering s = {.vpls = vpls, .vpl_count = vpl_count, .count = count};
    for (uint32_t t = 0; t < triangle_count; t++) s.area += area_of_corners(positions, corners + 3 * (size_t)t);
    if (!(s.area > 0) || !isfinite(s.area)) return 0;
    for (int turn = 0; turn < 2; turn++) {
        s.points = turn ? points : NULL;
        for (uint32_t t = 0; t < triangle_count; t++) {
            const float *v[CORNERS];
            part         p = part_of(positions, corners + 3 * (size_t)t, v);
            if (p.area > 0) scatter_part(&s, v, &p, HALVINGS);
        }
        if (!(s.seen > 0) || !isfinite(s.seen)) return vxs_area_scatter(positions, corners, triangle_count, points, count);
    }
    return s.area;
}
