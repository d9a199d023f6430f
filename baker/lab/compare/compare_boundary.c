/* Distance of wrong answers from a place where they would be right.
 *
 * Probes go in 26 directions from the point where the truth was traced, in the coordinates of the map, where a texel and a
 * voxel's depth have the same length: across the light, along it, and between, as from the centre of a cube to its corners and
 * to the centres of its edges and faces.
 *
 *        \ | /        In each direction the truth is traced at 1/2, 1, 1 1/2, 2, 3, 4, 6 and 8 texels. Where it first agrees
 *        with
 *       -- p --       the asset, the last step is halved six times. The least distance of all directions is the result. For a
 *                     flat
 *        / | \        boundary it is at most 13 % too large; features thinner than a step may be missed. Insides of solids are
 *        dark.
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/compare/compare_points.h"

#include <math.h>
#include <stdlib.h>

#include "baker/base/parallel.h"

enum { ANSWERS_AT_A_TIME = 16, HALVINGS = 6 };

static const double steps[] = {0.5, 1, 1.5, 2, 3, 4, 6, 8};
enum { STEPS = sizeof steps / sizeof *steps };

typedef struct search {
    const comparison *comparison;
    compare_kind      kind;
    wrong_answer     *answers;
} search;

/* One direction from a point: `way` has the length of a texel. */
static int lit_along(const comparison *c, const sample *s, const double way[3], double texels)
{
    const double *at = s->truth_ls;
    return compare_lit_at(c, s->map, at[0] + texels * way[0], at[1] + texels * way[1], at[2] + texels * way[2]);
}

/* Halve the step between `from`, where the truth differs from the asset, and `to`, where they agree. */
static double halved(const comparison *c, const sample *s, const double way[3], int lit, double from, double to)
{
    for (int n = 0; n < HALVINGS; n++) {
        double middle = 0.5 * (from + to);
        if (lit_along(c, s, way, middle) == lit)
            to = middle;
        else
            from = middle;
    }
    return 0.5 * (from + to);
}

/* The nearest boundary between two steps, over all directions; INFINITY when there is none. */
static double nearest_between(const comparison *c, const sample *s, int lit, double from, double to)
{
    double nearest = INFINITY;
    for (int n = 0; n < 27; n++) {
        double way[3] = {n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1}, length = sqrt(way[0] * way[0] + way[1] * way[1] + way[2] * way[2]);
        if (length == 0) continue;
        for (int i = 0; i < 3; i++) way[i] /= length;
        if (lit_along(c, s, way, to) == lit) nearest = fmin(nearest, halved(c, s, way, lit, from, to));
    }
    return nearest;
}

static double distance_of(const search *f, const wrong_answer *a)
{
    sample s;
    compare_point(f->comparison, f->kind, a->index, &s);
    for (int n = 0; n < STEPS; n++) {
        double nearest = nearest_between(f->comparison, &s, a->asset_lit, n ? steps[n - 1] : 0, steps[n]);
        if (!isinf(nearest)) return nearest;
    }
    return INFINITY;
}

static void search_answers(void *user, size_t begin, size_t end, uint32_t worker)
{
    search *f = user;
    (void)worker;
    for (size_t n = begin; n < end; n++) f->answers[n].texels = (float)distance_of(f, &f->answers[n]);
}

static int by_distance(const void *a, const void *b)
{
    float x = ((const wrong_answer *)a)->texels, y = ((const wrong_answer *)b)->texels;
    return (x > y) - (x < y);
}

/* The value below which this share of the answers is; [count] sorted, count > 0. */
static double quantile(const wrong_answer *answers, size_t count, double share)
{
    return (double)answers[(size_t)(share * (double)(count - 1) + 0.5)].texels;
}

compare_distance compare_boundary(const comparison *c, compare_kind kind, wrong_answer *answers, size_t count)
{
    search           f   = {c, kind, answers};
    compare_distance out = {0};
    double           sum = 0;
    parallel_for(c->options->threads, count, ANSWERS_AT_A_TIME, search_answers, &f);
    qsort(answers, count, sizeof *answers, by_distance);

    while (out.points < count && !isinf(answers[out.points].texels)) sum += (double)answers[out.points++].texels;
    out.beyond = count - out.points;
    if (!out.points) return out;
    out.mean   = sum / (double)out.points;
    out.median = quantile(answers, out.points, 0.5);
    out.p95    = quantile(answers, out.points, 0.95);
    out.max    = quantile(answers, out.points, 1);
    return out;
}
