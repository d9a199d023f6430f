/* The page about benches; see bench_page.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/page/bench_page.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "baker/page/growth.h"
#include "baker/page/html.h"
#include "baker/page/range.h"

/* cells ----------------------------------------------------------------------------------------------------------------------- */

static void print_spread_seconds(FILE *to, spread s)
{
    html_seconds(to, s.median);
    if (s.min == s.max) return;
    fputs(" <small>", to);
    html_seconds(to, s.min);
    fputs("–", to);
    html_seconds(to, s.max);
    fputs("</small>", to);
}

static spread seconds_of_nanoseconds(spread s)
{
    return (spread){s.median * 1e-9, s.min * 1e-9, s.max * 1e-9};
}

static double bit_per_texel(const set_cell *c)
{
    double maps = c->measured->maps ? (double)c->measured->maps : 1;
    return 8 * (double)c->measured->file_bytes / (c->side_px * c->side_px * maps);
}

/* Which bake a row is about. */
static void print_head(FILE *to, const bench_set *set)
{
    fputs("<tr><th class=\"text\">scene</th>", to);
    if (set->setting_count > 1) fputs("<th class=\"text\">setting</th>", to);
    if (set->file_count > 1) fputs("<th class=\"text\">measured in</th>", to);
}

static void print_text_cell(FILE *to, const char *text)
{
    fputs("<td class=\"text\">", to);
    html_text(to, text);
    fputs("</td>", to);
}

static void print_series_cells(FILE *to, const bench_set *set, uint32_t scene, uint32_t setting, uint32_t file)
{
    fputs("<tr>", to);
    print_text_cell(to, set->scenes[scene]);
    if (set->setting_count > 1) print_text_cell(to, set->settings[setting]);
    if (set->file_count > 1) print_text_cell(to, set->files[file].label);
}

static void print_bake_cells(FILE *to, const bench_set *set, const set_cell *c)
{
    print_series_cells(to, set, c->scene, c->setting, c->file);
    fprintf(to, "<td>%.0f</td>", c->side_px);
}

static void begin_table(FILE *to, const char *title, const bench_set *set)
{
    fprintf(to, "<h3>%s</h3>\n<div class=\"table\"><table>\n<thead>", title);
    print_head(to, set);
}

static void end_table(FILE *to)
{
    fputs("</tbody></table></div>\n", to);
}

/* Cells in the order of series: of a scene and setting those of all resolutions stand together. */
#define FOR_EACH_CELL(set, cell)                                                                                                   \
    for (size_t series_ = 0; series_ < (set)->series_count; series_++)                                                             \
        for (size_t at_ = 0; at_ < (set)->series[series_].count; at_++)                                                            \
            for (const set_cell *cell = &(set)->cells[(set)->series[series_].cells[at_]]; cell; cell = NULL)

/* the answers ----------------------------------------------------------------------------------------------------------------- */

static void print_fact(FILE *to, const char *question, range r, void (*print)(FILE *, double), const char *about)
{
    if (r.min > r.max) return;
    fputs("<div><small>", to);
    fputs(question, to);
    fputs("</small><b>", to);
    print(to, r.min);
    if (r.max > r.min) {
        fputs(" – ", to);
        print(to, r.max);
    }
    fprintf(to, "</b><small>%s</small></div>\n", about);
}

static void print_nanoseconds(FILE *to, double nanoseconds)
{
    html_seconds(to, nanoseconds * 1e-9);
}

static void print_facts(FILE *to, const bench_set *set)
{
    range time = RANGE_NOTHING, bytes = RANGE_NOTHING, wrong = RANGE_NOTHING, lookup = RANGE_NOTHING, peak = RANGE_NOTHING;
    FOR_EACH_CELL(set, cell)
    {
        const bench_cell   *c = cell->measured;
        const bench_error  *e = bench_error_of(c, BENCH_SURFACE, 1);
        const bench_lookup *l = bench_lookup_of(c, 1);
        range_add(&time, c->total_seconds.median);
        range_add(&bytes, (double)c->file_bytes);
        range_add(&peak, (double)c->peak_bytes);
        if (e) range_add(&wrong, e->wrong_share);
        if (l) range_add(&lookup, l->nanoseconds.median);
    }
    fputs("<div class=\"facts\">\n", to);
    print_fact(to, "How big?", bytes, html_bytes, "a file");
    print_fact(to, "How long?", time, html_seconds, "a bake, median");
    print_fact(to, "How much memory?", peak, html_bytes, "at the peak of a bake");
    print_fact(to, "How wrong?", wrong, html_percent, "of surface points");
    print_fact(to, "How fast?", lookup, print_nanoseconds, "a lookup of one tap");
    fputs("</div>\n", to);
}

/* 1.4 s on 2 cores of ... */
static void print_machines(FILE *to, const bench_set *set)
{
    for (size_t n = 0; n < set->file_count; n++) {
        const set_file     *f = &set->files[n];
        const bench_result *r = &f->result;
        fputs("<p class=\"soft\">", to);
        if (set->file_count > 1) {
            html_text(to, f->label);
            fputs(": ", to);
        }
        html_textf(to, "vxs %.40s, measured %.40s on %llu cores of %.200s, ", r->vxs, r->started,
                   (unsigned long long)r->machine.cores, r->machine.processor);
        fprintf(to, "%.3g GiB", (double)r->machine.memory_bytes / (1 << 30));
        html_textf(to, ", %.200s, OpenGL by %.200s; medians of %u runs", r->machine.system, r->machine.renderer, r->runs);
        if (r->points) {
            fputs(", ", to);
            html_count(to, r->points);
            fputs(" points of each kind", to);
        }
        fputs(".</p>\n", to);
    }
}

/* what settings are worth ----------------------------------------------------------------------------------------------------- */

typedef struct ratios {
    double *values;
    size_t  count;
} ratios;

static int by_value(const void *a, const void *b)
{
    double p = *(const double *)a, q = *(const double *)b;
    return (p > q) - (p < q);
}

static void add_ratio(ratios *r, double value, double base)
{
    if (value > 0 && base > 0) r->values[r->count++] = value / base;
}

static void print_ratio(FILE *to, ratios *r)
{
    if (!r->count) {
        fputs("<td class=\"soft\">–</td>", to);
        return;
    }
    qsort(r->values, r->count, sizeof *r->values, by_value);
    size_t half   = r->count / 2;
    double median = r->count % 2 ? r->values[half] : (r->values[half - 1] + r->values[half]) / 2;
    fprintf(to, "<td>%.2f", median);
    if (r->count > 1) fprintf(to, " <small>%.2f–%.2f</small>", r->values[0], r->values[r->count - 1]);
    fputs("</td>", to);
}

/* The bake of the same scene, resolution and file as the base has it. */
static const bench_cell *base_of(const bench_set *set, const set_cell *c)
{
    for (size_t n = 0; n < set->cell_count; n++) {
        const set_cell *b = &set->cells[n];
        if (!b->setting && b->scene == c->scene && b->file == c->file && b->side_px == c->side_px) return b->measured;
    }
    return NULL;
}

static double wrong_of(const bench_cell *c)
{
    const bench_error *e = bench_error_of(c, BENCH_SURFACE, 1);
    return e ? e->wrong_share : 0;
}

enum { RATIO_KINDS = 5 };

static void print_settings(FILE *to, const bench_set *set)
{
    if (set->setting_count < 2) return;
    double *room = calloc(RATIO_KINDS * set->cell_count, sizeof *room);
    if (!room) return; /* the page goes without */
    fputs("<h2>What each setting is worth</h2>\n<p>Base is ", to);
    html_text(to, *set->base ? set->base : "the first setting");
    fputs(". Each other setting is divided by it, at the same scene and resolution: median, and least to greatest. Below 1 is "
          "smaller, sooner, less wrong.</p>\n"
          "<div class=\"table\"><table>\n<thead><tr><th class=\"text\">setting</th><th>bakes</th><th>file</th>"
          "<th>in memory</th><th>bake time</th><th>peak memory</th><th>wrong at surfaces</th></tr></thead>\n<tbody>\n",
          to);
    for (size_t setting = 1; setting < set->setting_count; setting++) {
        ratios r[RATIO_KINDS] = {{0}};
        size_t count          = 0;
        for (int k = 0; k < RATIO_KINDS; k++) r[k].values = room + (size_t)k * set->cell_count;
        FOR_EACH_CELL(set, cell)
        {
            const bench_cell *c = cell->measured, *b = cell->setting == setting ? base_of(set, cell) : NULL;
            if (!b) continue;
            count++;
            add_ratio(&r[0], (double)c->file_bytes, (double)b->file_bytes);
            add_ratio(&r[1], (double)c->memory_bytes, (double)b->memory_bytes);
            add_ratio(&r[2], c->total_seconds.median, b->total_seconds.median);
            add_ratio(&r[3], (double)c->peak_bytes, (double)b->peak_bytes);
            add_ratio(&r[4], wrong_of(c), wrong_of(b));
        }
        fputs("<tr>", to);
        print_text_cell(to, set->settings[setting]);
        fprintf(to, "<td>%zu</td>", count);
        for (int k = 0; k < RATIO_KINDS; k++) print_ratio(to, &r[k]);
        fputs("</tr>\n", to);
    }
    end_table(to);
    free(room);
}

/* plots ----------------------------------------------------------------------------------------------------------------------- */

static void print_plots(FILE *to, const bench_plots *plots, plot_group group)
{
    static const char *const titles[PLOT_GROUPS] = {"How long, and where the time goes", "How big, and where the bytes go",
                                                    "How wrong, for how much"};
    if (plots->first[group] == plots->first[group + 1]) return;
    fprintf(to, "<h2>%s</h2>\n<div class=\"plots\">\n", titles[group]);
    for (size_t n = plots->first[group]; n < plots->first[group + 1]; n++) {
        const plot *p = &plots->items[n];
        fputs(p->width > 480 ? "<figure class=\"span\"><h3>" : "<figure><h3>", to);
        html_text(to, p->title);
        fputs("</h3>\n<div>", to);
        plot_print_inline(p, to, (unsigned)n + 1);
        fputs("</div><figcaption>", to);
        html_text(to, p->caption);
        fputs("</figcaption></figure>\n", to);
    }
    fputs("</div>\n", to);
}

/* tables ---------------------------------------------------------------------------------------------------------------------- */

static void print_bakes(FILE *to, const bench_set *set)
{
    begin_table(to, "Bakes", set);
    fputs("<th>texels a side</th><th>bake</th><th>whole process</th><th>maps to DAG</th><th>peak memory</th><th>file</th>"
          "<th>in memory</th><th>bit/texel</th><th>nodes</th><th>masks</th><th>nodes inserted</th><th>masks inserted</th>"
          "<th>triangles</th><th>in solids</th></tr></thead>\n<tbody>\n",
          to);
    FOR_EACH_CELL(set, cell)
    {
        const bench_cell *c = cell->measured;
        print_bake_cells(to, set, cell);
        fputs("<td>", to);
        print_spread_seconds(to, c->total_seconds);
        fputs("</td><td>", to);
        print_spread_seconds(to, c->wall_seconds);
        fputs("</td><td>", to);
        print_spread_seconds(to, c->maps_to_dag_seconds);
        fputs("</td><td>", to);
        html_bytes(to, (double)c->peak_bytes);
        fputs("</td><td>", to);
        html_bytes(to, (double)c->file_bytes);
        fputs("</td><td>", to);
        html_bytes(to, (double)c->memory_bytes);
        fprintf(to, "</td><td>%.3f</td>", bit_per_texel(cell));
        const uint64_t counts[] = {c->nodes, c->masks, c->inserted_nodes, c->inserted_masks, c->triangles, c->solid_triangles};
        for (size_t n = 0; n < sizeof counts / sizeof *counts; n++) {
            fputs("<td>", to);
            html_count(to, (double)counts[n]);
            fputs("</td>", to);
        }
        fputs("</tr>\n", to);
    }
    end_table(to);
}

static double nodes_of(const bench_cell *c)
{
    return (double)c->nodes;
}

static double masks_of(const bench_cell *c)
{
    return (double)c->masks;
}

static double file_bytes_of(const bench_cell *c)
{
    return (double)c->file_bytes;
}

static double memory_bytes_of(const bench_cell *c)
{
    return (double)c->memory_bytes;
}

static double peak_bytes_of(const bench_cell *c)
{
    return (double)c->peak_bytes;
}

static double total_seconds_of(const bench_cell *c)
{
    return c->total_seconds.median;
}

static double maps_to_dag_seconds_of(const bench_cell *c)
{
    return c->maps_to_dag_seconds.median;
}

static void print_growth(FILE *to, const bench_set *set)
{
    static const struct {
        const char   *name;
        growth_value *value;
    } kinds[]    = {{"bake", total_seconds_of}, {"maps to DAG", maps_to_dag_seconds_of}, {"peak memory", peak_bytes_of},
                    {"file", file_bytes_of},    {"in memory", memory_bytes_of},          {"nodes", nodes_of},
                    {"masks", masks_of}};
    size_t count = sizeof kinds / sizeof *kinds;
    begin_table(to, "Growth with each doubling of the resolution, and the fitted slope", set);
    fputs("<th>resolutions</th>", to);
    for (size_t n = 0; n < count; n++) fprintf(to, "<th>%s</th>", kinds[n].name);
    fputs("</tr></thead>\n<tbody>\n", to);
    for (size_t n = 0; n < set->series_count; n++) {
        const bench_series *s = &set->series[n];
        print_series_cells(to, set, s->scene, s->setting, s->file);
        fprintf(to, "<td>%zu</td>", s->count);
        for (size_t k = 0; k < count; k++) {
            growth g = growth_of(set, s, kinds[k].value);
            if (g.count)
                fprintf(to, "<td>%.2f-fold <small>slope %.2f</small></td>", g.factor, g.slope);
            else
                fputs("<td class=\"soft\">–</td>", to);
        }
        fputs("</tr>\n", to);
    }
    end_table(to);
}

/* Columns of a table, in the order in which stages are first seen. */
typedef struct columns {
    const char *names[64];
    size_t      count;
} columns;

static size_t column_of_stage(columns *k, const char *name)
{
    size_t n = 0;
    while (n < k->count && strcmp(k->names[n], name)) n++;
    if (n == k->count && n < 64) k->names[k->count++] = name;
    return n < 64 ? n : 63;
}

static void print_stages(FILE *to, const bench_set *set)
{
    columns k = {.count = 0};
    FOR_EACH_CELL(set, cell)
    for (size_t n = 0; n < cell->measured->stage_count; n++) column_of_stage(&k, cell->measured->stages[n].name);
    if (!k.count) return;
    begin_table(to, "Stages: median seconds, and peak memory", set);
    fputs("<th>texels a side</th>", to);
    for (size_t n = 0; n < k.count; n++) {
        fputs("<th>", to);
        html_text(to, k.names[n]);
        fputs("</th>", to);
    }
    fputs("</tr></thead>\n<tbody>\n", to);
    FOR_EACH_CELL(set, cell)
    {
        const bench_cell  *c          = cell->measured;
        const bench_stage *stages[64] = {NULL};
        for (size_t n = 0; n < c->stage_count; n++) stages[column_of_stage(&k, c->stages[n].name)] = &c->stages[n];
        print_bake_cells(to, set, cell);
        for (size_t n = 0; n < k.count; n++) {
            fputs("<td>", to);
            if (stages[n]) {
                html_seconds(to, stages[n]->seconds.median);
                fputs("<br><small>", to);
                html_bytes(to, (double)stages[n]->peak_bytes);
                fputs("</small>", to);
            }
            fputs("</td>", to);
        }
        fputs("</tr>\n", to);
    }
    end_table(to);
}

static void print_levels(FILE *to, const bench_set *set)
{
    uint32_t all = 0;
    FOR_EACH_CELL(set, cell)
    all |= cell->measured->level_set;
    if (!all) return;
    begin_table(to, "Levels: nodes or masks, and their bytes in the file and in memory", set);
    fputs("<th>texels a side</th>", to);
    for (int n = 0; n < BENCH_LEVELS_MAX; n++) {
        if (!(all >> n & 1)) continue;
        if (n)
            fprintf(to, "<th>%.0f³</th>", ldexp(1, n));
        else
            fputs("<th>masks</th>", to);
    }
    fputs("</tr></thead>\n<tbody>\n", to);
    FOR_EACH_CELL(set, cell)
    {
        print_bake_cells(to, set, cell);
        for (int n = 0; n < BENCH_LEVELS_MAX; n++) {
            const bench_level *l = &cell->measured->levels[n];
            if (!(all >> n & 1)) continue;
            fputs("<td>", to);
            if (cell->measured->level_set >> n & 1) {
                html_count(to, (double)l->count);
                fputs("<br><small>", to);
                html_bytes(to, (double)l->stored_bytes);
                fputs("<br>", to);
                html_bytes(to, (double)l->memory_bytes);
                fputs("</small>", to);
            }
            fputs("</td>", to);
        }
        fputs("</tr>\n", to);
    }
    end_table(to);
}

static void print_errors(FILE *to, const bench_set *set)
{
    begin_table(to, "Errors against ray tracing", set);
    fputs("<th>texels a side</th><th class=\"text\">points</th><th>filter</th><th>checked</th><th>wrong</th><th>leaks</th>"
          "<th>false shadows</th><th>unexplained</th><th>root mean square</th><th>greatest</th></tr></thead>\n<tbody>\n",
          to);
    FOR_EACH_CELL(set, cell)
    for (size_t n = 0; n < cell->measured->error_count; n++) {
        const bench_error *e = &cell->measured->errors[n];
        print_bake_cells(to, set, cell);
        print_text_cell(to, bench_points_text(e->points));
        fprintf(to, "<td>%u x %u</td><td>", e->filter_px, e->filter_px);
        html_count(to, (double)e->checked);
        fputs("</td>", to);
        if (e->filter_px == 1) {
            const uint64_t counts[] = {e->leaks, e->false_shadows, e->unexplained};
            fputs("<td>", to);
            html_percent(to, e->wrong_share);
            fputs("</td>", to);
            for (int k = 0; k < 3; k++) {
                fputs("<td>", to);
                html_count(to, (double)counts[k]);
                fputs("</td>", to);
            }
        } else {
            fputs("<td></td><td></td><td></td><td></td>", to);
        }
        fputs("<td>", to);
        html_percent(to, bench_rmse(e));
        fputs("</td><td>", to);
        if (e->filter_px > 1) html_percent(to, e->max_error);
        fputs("</td></tr>\n", to);
    }
    end_table(to);
}

static void print_lookups(FILE *to, const bench_set *set)
{
    begin_table(to, "Lookups", set);
    fputs("<th>texels a side</th><th>filter</th><th>a lookup</th><th>rays for the same</th></tr></thead>\n<tbody>\n", to);
    FOR_EACH_CELL(set, cell)
    for (size_t n = 0; n < cell->measured->lookup_count; n++) {
        const bench_lookup *l = &cell->measured->lookups[n];
        print_bake_cells(to, set, cell);
        fprintf(to, "<td>%u x %u</td><td>", l->filter_px, l->filter_px);
        print_spread_seconds(to, seconds_of_nanoseconds(l->nanoseconds));
        fputs("</td><td>", to);
        if (l->ray_nanoseconds.median > 0) print_spread_seconds(to, seconds_of_nanoseconds(l->ray_nanoseconds));
        fputs("</td></tr>\n", to);
    }
    end_table(to);
}

/* all ------------------------------------------------------------------------------------------------------------------------- */

static void print_title(FILE *to, const bench_set *set)
{
    fprintf(to, "<h1>%zu bake%s of ", set->cell_count, set->cell_count > 1 ? "s" : "");
    size_t shown = set->scene_count > 4 ? 4 : set->scene_count;
    for (size_t n = 0; n < shown; n++) {
        if (n) fputs(n + 1 == set->scene_count ? " and " : ", ", to);
        html_text(to, set->scenes[n]);
    }
    if (shown < set->scene_count) fprintf(to, " and %zu more", set->scene_count - shown);
    fputs("</h1>\n", to);
}

void bench_page_print(FILE *to, const bench_set *set, const bench_plots *plots)
{
    html_begin(to, "vxs: measured");
    print_title(to, set);
    print_machines(to, set);
    print_facts(to, set);
    for (plot_group g = 0; g < PLOT_GROUPS; g++) print_plots(to, plots, g);
    if (plots->scenes_left_out)
        fprintf(to, "<p class=\"soft\">%zu more scenes have no plots of their own; their figures are in the tables.</p>\n",
                plots->scenes_left_out);
    print_settings(to, set);
    fputs("<h2>The figures</h2>\n<p class=\"soft\">Times are medians, with least and greatest where they differ.</p>\n", to);
    print_bakes(to, set);
    print_growth(to, set);
    print_stages(to, set);
    print_levels(to, set);
    print_errors(to, set);
    print_lookups(to, set);
    html_end(to);
}
