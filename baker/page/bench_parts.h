/* The kinds of plots of benches, for the list of them (bench_plots.h).
 *
 * Each draws and adds to the list what the set has figures for. Returns as plot_end.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BENCH_PARTS_H
#define BENCH_PARTS_H

#include "baker/page/bench_plots.h"
#include "baker/page/range.h"

enum { PLOT_WIDTH = 480, PLOT_WIDE = 760, PLOT_HEIGHT = 220 }; /* CSS pixels; the height without what is below the axis */

/* bench_lines.c: lines over all scenes */
vxs_result bench_lines_growth(bench_plots *plots, const bench_set *set, plot_group group, message *m);
vxs_result bench_lines_errors(bench_plots *plots, const bench_set *set, message *m);

/* bench_bars.c: of one scene, a bar or a line for each bake */
vxs_result bench_bars_stages(bench_plots *plots, const bench_set *set, uint32_t scene, message *m);
vxs_result bench_bars_levels(bench_plots *plots, const bench_set *set, uint32_t scene, message *m);

/* Room for one more plot, which counts when plots->count is raised; NULL without memory. */
plot *bench_plots_another(bench_plots *plots, message *m);

/* "0.31 % to 0.82 %", or one of them where both read the same. words: as seconds_text. Returns text. */
const char *range_text(char text[80], range r, const char *(*words)(char[32], double));

/* As size_text, of a double. */
const char *bytes_text(char text[32], double bytes);

/* A cell of a series. */
static inline const set_cell *cell_at(const bench_set *set, const bench_series *s, size_t n)
{
    return &set->cells[s->cells[n]];
}

/* What does not spread. */
static inline spread exactly(double value)
{
    return (spread){value, value, value};
}

#endif
