/* A grid of smoke for tests, sampled and integrated without the grid's own code. Included behind cmocka.h and random_light.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SMOKE_SAMPLE_H
#define SMOKE_SAMPLE_H

#include <stdlib.h>

#include "baker/smoke/smoke_grid.h"

/* Of what the smoke is made: balls that are densest in their middles. */
typedef struct smoke_balls {
    double   at[8][3], radius[8], dense[8];
    uint32_t count;
} smoke_balls;

static inline double balls_extinction(const smoke_balls *b, const double ws[3])
{
    double sum = 0;
    for (uint32_t n = 0; n < b->count; n++) {
        double square = 0;
        for (int i = 0; i < 3; i++) square += (ws[i] - b->at[n][i]) * (ws[i] - b->at[n][i]);
        square /= b->radius[n] * b->radius[n];
        sum += square < 1 ? b->dense[n] * (1 - square) * (1 - square) : 0;
    }
    return sum;
}

/* Samples of balls on axes that are neither of the world nor at right angles.   origin  of sample (0, 0, 0) */
static inline smoke_grid sample_grid(const smoke_balls *b, const uint32_t size[3], const double axes[3][3], const double origin[3])
{
    smoke_grid g = {.size = {size[0], size[1], size[2]}};
    g.extinction = malloc((size_t)size[0] * size[1] * size[2] * sizeof *g.extinction);
    assert_non_null(g.extinction);
    float *to = g.extinction;
    for (uint32_t k = 0; k < size[2]; k++)
        for (uint32_t j = 0; j < size[1]; j++)
            for (uint32_t i = 0; i < size[0]; i++) {
                double ws[3];
                for (int n = 0; n < 3; n++) ws[n] = origin[n] + i * axes[0][n] + j * axes[1][n] + k * axes[2][n];
                *to++ = (float)balls_extinction(b, ws);
            }
    assert_int_equal(smoke_grid_place(&g, axes, origin), 1);
    return g;
}

/* Sample (i, j, k), or the nearest that there is. */
static inline double sample_at(const smoke_grid *g, const int at[3])
{
    size_t index = 0;
    for (int n = 2; n >= 0; n--) {
        int last = (int)g->size[n] - 1, held = at[n] < 0 ? 0 : at[n] > last ? last : at[n];
        index = index * g->size[n] + (size_t)held;
    }
    return (double)g->extinction[index];
}

/* Eight samples, each weighed by how near it is. */
static inline double sampled(const smoke_grid *g, const double axes[3][3], const double origin[3], const double ws[3])
{
    double at[3], from[3], normal[3], sum = 0;
    for (int n = 0; n < 3; n++) from[n] = ws[n] - origin[n];
    for (int n = 0; n < 3; n++) {
        cross(axes[(n + 1) % 3], axes[(n + 2) % 3], normal);
        at[n] = dot(from, normal) / dot(axes[n], normal);
        if (at[n] < -0.5 || at[n] > g->size[n] - 0.5) return 0;
    }
    for (int corner = 0; corner < 8; corner++) {
        int    sample[3];
        double weight = 1;
        for (int n = 0; n < 3; n++) {
            double low = floor(at[n]), part = at[n] - low;
            sample[n] = (int)low + (corner >> n & 1);
            weight *= corner >> n & 1 ? part : 1 - part;
        }
        sum += weight * sample_at(g, sample);
    }
    return sum;
}

#endif
