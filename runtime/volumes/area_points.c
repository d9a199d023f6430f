/* Points of triangles; see vxs_area_light.h.
 * SPDX-License-Identifier: MIT */
#include <math.h>

#include "area_numbers.h"
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

/* Point n of all, on a triangle: evenly on a square, of which one half is folded over the other. */
static vxs_area_point point_on(const float *positions, const uint32_t *corner, uint32_t n, double area)
{
    double         u = vxs_area_radical_inverse(n, 2), v = vxs_area_radical_inverse(n, 3);
    vxs_area_point point = {.square_metres = (float)area};
    if (u + v > 1) {
        u = 1 - u;
        v = 1 - v;
    }
    for (int i = 0; i < 3; i++) {
        double a = (double)positions[3 * (size_t)corner[0] + i], b = (double)positions[3 * (size_t)corner[1] + i],
               c       = (double)positions[3 * (size_t)corner[2] + i];
        point.place[i] = (float)(a + u * (b - a) + v * (c - a));
    }
    return point;
}

double vxs_area_scatter(const float *positions, const uint32_t *corners, uint32_t triangle_count, vxs_area_point *points,
                        uint32_t count)
{
    double   all = 0, before = 0;
    uint32_t n = 0;
    for (uint32_t t = 0; t < triangle_count; t++) all += area_of_corners(positions, corners + 3 * (size_t)t);
    if (!(all > 0) || !isfinite(all)) return 0;
    for (uint32_t t = 0; t < triangle_count; t++) {
        const uint32_t *corner = corners + 3 * (size_t)t;
        before += area_of_corners(positions, corner);
        for (; n < count && (n + 0.5) * all < before * count; n++) points[n] = point_on(positions, corner, n, all / count);
    }
    return all;
}
