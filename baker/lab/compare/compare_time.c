/* The time of lookups and rays, on one thread; see compare_points.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/compare/compare_points.h"

#include <stdlib.h>
#include <string.h>

#include "baker/base/clock.h"
#include "baker/base/spread.h"
#include "runtime/vxs.h"

enum { TIMED_RUNS = 5, TIMED_RAYS_MAX = 100000 };

typedef struct timed {
    const comparison *comparison;
    double           *points_ws; /* [3 * count] */
    float            *lit;       /* [count] */
    size_t            count;
    int               filter_px;
} timed;

static void run_lookups(timed *t)
{
    vxs_lookup_many(t->comparison->baked, t->points_ws, NULL, t->count, t->filter_px, t->lit);
}

static void run_rays(timed *t)
{
    const comparison *c = t->comparison;
    for (size_t n = 0; n < t->count; n++) t->lit[n] = (float)truth_lit(c->truth, t->points_ws + 3 * n, &c->shape);
}

/* Seconds for one point: the median of some runs. */
static double time_runs(void (*run)(timed *t), timed *t)
{
    double seconds[TIMED_RUNS];
    if (!t->count) return 0;
    for (int n = 0; n < TIMED_RUNS; n++) {
        double start = clock_seconds();
        run(t);
        seconds[n] = clock_seconds() - start;
    }
    return spread_of(seconds, TIMED_RUNS).median / (double)t->count;
}

static void gather_points(timed *t, size_t limit)
{
    sample s;
    for (size_t n = 0; n < limit; n++)
        if (compare_point(t->comparison, COMPARE_RANDOM, n, &s))
            memcpy(t->points_ws + 3 * t->count++, s.point_ws, sizeof s.point_ws);
}

vxs_result compare_measure_time(const comparison *c, compare_result *out, message *m)
{
    const compare_options *o     = c->options;
    size_t                 limit = o->points < COMPARE_TIMED_POINTS_MAX ? o->points : COMPARE_TIMED_POINTS_MAX;
    timed                  t     = {.comparison = c, .filter_px = 1};
    vxs_result             r     = VXS_OK;
    t.points_ws                  = malloc(3 * limit * sizeof *t.points_ws);
    t.lit                        = malloc(limit * sizeof *t.lit);
    if (!t.points_ws || !t.lit) {
        r = fail(m, VXS_E_MEMORY, "out of memory for %zu points", limit);
        goto done;
    }
    gather_points(&t, limit);
    out->time.points   = t.count;
    out->time.lookup_s = time_runs(run_lookups, &t);
    for (uint32_t n = 0; n < o->filter_count; n++) {
        t.filter_px              = (int)o->filters_px[n];
        out->filters[n].lookup_s = time_runs(run_lookups, &t);
    }
    if (t.count > TIMED_RAYS_MAX) t.count = TIMED_RAYS_MAX;
    out->time.truth_s = time_runs(run_rays, &t);
done:
    free(t.points_ws);
    free(t.lit);
    return r;
}
