/* The plots of a page about benches.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BENCH_PLOTS_H
#define BENCH_PLOTS_H

#include "baker/page/bench_set.h"
#include "baker/page/plot.h"

/* The parts of the page, in their order. */
typedef enum plot_group { PLOTS_TIME, PLOTS_BYTES, PLOTS_ERROR, PLOT_GROUPS } plot_group;

typedef struct bench_plots {
    plot  *items; /* in the order of the page */
    size_t count;
    size_t first[PLOT_GROUPS + 1]; /* plots of group g are [first[g], first[g + 1]) */
    size_t scenes_left_out;        /* that have no plots of their own, only lines in those of all scenes */
} bench_plots;

/* Draw all that the set has figures for.
 * plots  [out] released with bench_plots_free, whatever is returned.   Returns as plot_end. */
vxs_result bench_plots_make(bench_plots *plots, const bench_set *set, message *m);

void bench_plots_free(bench_plots *plots);

#endif
