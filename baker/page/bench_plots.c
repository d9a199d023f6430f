/* The plots of a page about benches; see bench_plots.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/page/bench_plots.h"

#include <stdlib.h>
#include <string.h>

#include "baker/base/text.h"
#include "baker/page/bench_parts.h"

enum { SCENES_MAX = 8 };

const char *range_text(char text[80], range r, const char *(*words)(char[32], double))
{
    char a[32], b[32];
    words(a, r.min);
    words(b, r.max);
    snprintf(text, 80, strcmp(a, b) ? "%s to %s" : "%s", a, b);
    return text;
}

const char *bytes_text(char text[32], double bytes)
{
    return size_text(text, (uint64_t)bytes);
}

plot *bench_plots_another(bench_plots *plots, message *m)
{
    plot *longer = realloc(plots->items, (plots->count + 1) * sizeof *longer);
    if (!longer) {
        fail(m, VXS_E_MEMORY, "out of memory for %zu plots", plots->count + 1);
        return NULL;
    }
    plots->items         = longer;
    longer[plots->count] = (plot){0};
    return &longer[plots->count];
}

static int has_stages(const bench_set *set, uint32_t scene)
{
    for (size_t n = 0; n < set->cell_count; n++)
        if (set->cells[n].scene == scene && set->cells[n].measured->stage_count) return 1;
    return 0;
}

static int has_levels(const bench_set *set, uint32_t scene)
{
    for (size_t n = 0; n < set->cell_count; n++)
        if (set->cells[n].scene == scene && set->cells[n].measured->level_set) return 1;
    return 0;
}

vxs_result bench_plots_make(bench_plots *plots, const bench_set *set, message *m)
{
    uint32_t   scenes = (uint32_t)(set->scene_count < SCENES_MAX ? set->scene_count : SCENES_MAX);
    vxs_result r      = VXS_OK;
    memset(plots, 0, sizeof *plots);
    plots->scenes_left_out = set->scene_count - scenes;

    plots->first[PLOTS_TIME] = 0;
    for (uint32_t n = 0; n < scenes && r == VXS_OK; n++)
        if (has_stages(set, n)) r = bench_bars_stages(plots, set, n, m);
    if (r == VXS_OK) r = bench_lines_growth(plots, set, PLOTS_TIME, m);

    plots->first[PLOTS_BYTES] = plots->count;
    for (uint32_t n = 0; n < scenes && r == VXS_OK; n++)
        if (has_levels(set, n)) r = bench_bars_levels(plots, set, n, m);
    if (r == VXS_OK) r = bench_lines_growth(plots, set, PLOTS_BYTES, m);

    plots->first[PLOTS_ERROR] = plots->count;
    if (r == VXS_OK) r = bench_lines_errors(plots, set, m);
    plots->first[PLOT_GROUPS] = plots->count;
    return r;
}

void bench_plots_free(bench_plots *plots)
{
    for (size_t n = 0; n < plots->count; n++) plot_free(&plots->items[n]);
    free(plots->items);
    memset(plots, 0, sizeof *plots);
}
