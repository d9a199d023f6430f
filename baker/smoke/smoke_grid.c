/* Smoke as a grid; see smoke_grid.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/smoke/smoke_grid.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <xxhash.h>

#include "baker/base/vec3.h"

void smoke_grid_free(smoke_grid *g)
{
    free(g->extinction);
    *g = (smoke_grid){0};
}

/* one  1: a position; 0: a direction */
static void apply(const double matrix[12], const double v[3], double one, double out[3])
{
    for (int n = 0; n < 3; n++) out[n] = vec3_dot(matrix + 4 * n, v) + one * matrix[4 * n + 3];
}

void smoke_grid_corner(const smoke_grid *g, int corner, double ws[3])
{
    double at[3];
    for (int n = 0; n < 3; n++) at[n] = corner >> n & 1 ? g->size[n] - 0.5 : -0.5;
    apply(g->ws_from_grid, at, 1, ws);
}

void smoke_grid_middle(const smoke_grid *g, double ws[3])
{
    const double at[3] = {0.5 * (g->size[0] - 1.0), 0.5 * (g->size[1] - 1.0), 0.5 * (g->size[2] - 1.0)};
    apply(g->ws_from_grid, at, 1, ws);
}

double smoke_grid_spacing(const smoke_grid *g)
{
    double least = INFINITY;
    for (int n = 0; n < 3; n++) {
        const double unit[3] = {n == 0, n == 1, n == 2};
        double       axis[3];
        apply(g->ws_from_grid, unit, 0, axis);
        least = fmin(least, sqrt(vec3_dot(axis, axis)));
    }
    return least;
}

/* Whether all corners are within 1e9 m. */
static int is_near(const smoke_grid *g)
{
    for (int corner = 0; corner < 8; corner++) {
        double ws[3];
        smoke_grid_corner(g, corner, ws);
        for (int n = 0; n < 3; n++)
            if (!(fabs(ws[n]) <= 1e9)) return 0;
    }
    return 1;
}

int smoke_grid_place(smoke_grid *g, const double axes[3][3], const double origin[3])
{
    double rows[3][3];
    for (int n = 0; n < 3; n++) vec3_cross(axes[(n + 1) % 3], axes[(n + 2) % 3], rows[n]);
    double volume = vec3_dot(axes[0], rows[0]);
    if (!isfinite(volume) || volume == 0) return 0;
    for (int n = 0; n < 3; n++) {
        for (int c = 0; c < 3; c++) {
            g->grid_from_ws[4 * n + c] = rows[n][c] / volume;
            g->ws_from_grid[4 * n + c] = axes[c][n];
        }
        g->grid_from_ws[4 * n + 3] = -vec3_dot(rows[n], origin) / volume;
        g->ws_from_grid[4 * n + 3] = origin[n];
    }
    for (int n = 0; n < 12; n++)
        if (!isfinite(g->grid_from_ws[n])) return 0;
    return is_near(g);
}

void smoke_grid_fingerprint(const smoke_grid *g, char text[SMOKE_FINGERPRINT_BYTES])
{
    size_t        count = (size_t)g->size[0] * g->size[1] * g->size[2];
    XXH128_hash_t hash  = XXH3_128bits_withSeed(g->ws_from_grid, sizeof g->ws_from_grid, g->size[0]);
    hash                = XXH3_128bits_withSeed(g->extinction, count * sizeof *g->extinction, hash.low64 + g->size[1]);
    snprintf(text, SMOKE_FINGERPRINT_BYTES, "%016" PRIx64 "%016" PRIx64, (uint64_t)hash.high64, (uint64_t)hash.low64);
}

/* Extinction at a position in the grid's box. */
static double extinction_at(const smoke_grid *g, const double at[3])
{
    size_t step[3] = {1, g->size[0], (size_t)g->size[0] * g->size[1]}, first = 0, next[3];
    double part[3];
    for (int n = 0; n < 3; n++) {
        double last = g->size[n] - 1, held = at[n] > 0 ? at[n] < last ? at[n] : last : 0;
        size_t whole = (size_t)held;
        part[n]      = held - (double)whole;
        next[n]      = held < last ? step[n] : 0;
        first += whole * step[n];
    }
    double sum[4];
    for (int n = 0; n < 4; n++) {
        const float *row = g->extinction + first + (n & 1 ? next[1] : 0) + (n & 2 ? next[2] : 0);
        sum[n]           = (double)row[0] + part[0] * ((double)row[next[0]] - (double)row[0]);
    }
    double near = sum[0] + part[1] * (sum[1] - sum[0]), far = sum[2] + part[1] * (sum[3] - sum[2]);
    return near + part[2] * (far - near);
}

/* rays ------------------------------------------------------------------------------------------------------------------------- */

typedef struct march {
    const smoke_grid *grid;
    double            from[3], way[3]; /* in voxels */
    double            metres;          /* length of the ray per unit of depth */
} march;

static double extinction_along(const march *m, double depth)
{
    double at[3];
    vec3_mad(m->from, depth, m->way, at);
    return extinction_at(m->grid, at);
}

/* Optical depth between two planes of samples, by Simpson's rule.
 * bow  [out] greatest error of linear optical depth in between, for linear extinction */
static double piece_thick(const march *m, double begin, double end, double *bow)
{
    double a = extinction_along(m, begin), middle = extinction_along(m, 0.5 * (begin + end)), b = extinction_along(m, end);
    *bow = (end - begin) / 8 * m->metres * fabs(b - a);
    return (end - begin) / 6 * m->metres * (a + 4 * middle + b);
}

/* Add smoke that is too dense for equal pieces: pieces of limited optical depth, until no light is left.
 * Returns 0 without memory. */
static int add_dense(const march *m, double begin, double end, smoke_path *path)
{
    double step = (end - begin) / SMOKE_PARTS_MOST;
    for (double a = begin; a < end && !(path->count && path->thick[path->count - 1] > SMOKE_OPAQUE);) {
        double b = a + step < end ? a + step : end, bow, thick = piece_thick(m, a, b, &bow);
        if ((thick > SMOKE_PIECE || bow > SMOKE_BOW) && a + step / 2 > a) {
            step /= 2;
            continue;
        }
        if (!(b > a)) b = nextafter(a, end);
        if (thick > 0 && !smoke_path_add(path, a, b, thick)) return 0;
        a = b;
        step *= 2;
    }
    return 1;
}

/* Returns 0 without memory. */
static int add_piece(const march *m, double begin, double end, smoke_path *path)
{
    double bow, thick = piece_thick(m, begin, end, &bow), parts = fmax(ceil(thick / SMOKE_PIECE), ceil(sqrt(bow / SMOKE_BOW)));
    if (!(thick > 0)) return 1;
    if (parts > SMOKE_PARTS_MOST) return add_dense(m, begin, end, path);
    for (int n = 0; n < (int)parts; n++) {
        double a = begin + (end - begin) * n / parts, b = n + 1 < parts ? begin + (end - begin) * (n + 1) / parts : end;
        if (parts > 1) thick = piece_thick(m, a, b, &bow);
        if (b > a && thick > 0 && !smoke_path_add(path, a, b, thick)) return 0;
    }
    return 1;
}

/* Clip to the grid's box. */
static void clip(const march *m, double *begin, double *end)
{
    for (int n = 0; n < 3; n++) {
        double low = -0.5 - m->from[n], high = m->grid->size[n] - 0.5 - m->from[n];
        if (m->way[n] == 0) {
            if (low > 0 || high < 0) *end = -INFINITY;
            continue;
        }
        double a = low / m->way[n], b = high / m->way[n];
        *begin = fmax(*begin, fmin(a, b));
        *end   = fmin(*end, fmax(a, b));
    }
}

int smoke_grid_march(const smoke_grid *g, const double from[3], const double way[3], double begin, double end, smoke_path *path)
{
    march  m = {.grid = g, .metres = sqrt(vec3_dot(way, way))};
    double plane[3]; /* depth of the next plane of each axis */
    apply(g->grid_from_ws, from, 1, m.from);
    apply(g->grid_from_ws, way, 0, m.way);
    clip(&m, &begin, &end);
    for (int n = 0; n < 3; n++) {
        double at = m.from[n] + begin * m.way[n];
        plane[n]  = m.way[n] > 0 ? floor(at) + 1 : ceil(at) - 1;
    }
    while (begin < end && !(path->count && path->thick[path->count - 1] > SMOKE_OPAQUE)) {
        int    axis = -1;
        double next = end;
        for (int n = 0; n < 3; n++) {
            double at = m.way[n] != 0 ? (plane[n] - m.from[n]) / m.way[n] : INFINITY;
            if (at < next) next = at, axis = n;
        }
        if (next > begin && !add_piece(&m, begin, next, path)) return 0;
        begin = fmax(begin, next);
        if (axis < 0) break;
        plane[axis] += m.way[axis] > 0 ? 1 : -1;
    }
    return 1;
}
