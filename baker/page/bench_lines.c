/* Lines over all scenes; see bench_parts.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/page/bench_parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/text.h"
#include "baker/page/axis.h"
#include "baker/page/growth.h"
#include "baker/page/html.h"

static const char *fold_text(char text[32], double factor)
{
    snprintf(text, 32, "%.2f-fold", factor);
    return text;
}

static const char *nanoseconds_text(char text[32], double nanoseconds)
{
    return seconds_text(text, nanoseconds * 1e-9);
}

/* lines over all scenes ------------------------------------------------------------------------------------------------------- */

typedef struct point {
    double x, x_min, x_max;
    double y, y_min, y_max;
} point;

/* A plot with a line for each series, and each filter where it has several. */
typedef struct chart {
    const char *name;
    axis        x, y;
    int (*at)(point *p, const set_cell *c, const struct chart *of, uint32_t filter_px); /* 0: not measured */
    bench_points  kind;
    uint32_t      filters[BENCH_FILTERS_MAX];
    size_t        filter_count;
    growth_value *grows;  /* or NULL; lines are then fits */
    range         xs, ys; /* of all points, filled by begin_chart */
} chart;

/* Whether a line has its points labelled: one line a scene, while there is room. */
static int is_labelled(const bench_set *set, const bench_series *s)
{
    return s->setting == 0 && s->file == 0 && set->scene_count <= 3;
}

static size_t longest(char *const *names, size_t count)
{
    size_t length = 0;
    for (size_t n = 0; n < count; n++) length = strlen(names[n]) > length ? strlen(names[n]) : length;
    return length;
}

/* What colours, marks and dashes mean. */
typedef struct key {
    size_t rows, columns, most; /* characters of a name */
} key;

static key key_of(const bench_set *set, const chart *c)
{
    size_t settings = set->setting_count > 1 ? set->setting_count : 0, files = set->file_count > 1 ? set->file_count : 0;
    size_t length = longest(set->scenes, set->scene_count), count = set->scene_count + settings + files;
    if (settings && longest(set->settings, settings) > length) length = longest(set->settings, settings);
    for (size_t n = 0; n < files; n++)
        if (strlen(set->files[n].label) > length) length = strlen(set->files[n].label);
    if (c->grows) count = set->series_count, length += 40;
    size_t columns = length > 20 ? 1 : 2;
    if (c->grows && count > 12) count = 13;
    return (key){(count + columns - 1) / columns, columns, columns == 1 ? 56 : 20};
}

static void print_key(FILE *to, const bench_set *set, const key *k)
{
    for (size_t n = 0; n < set->scene_count; n++) {
        fprintf(to, ", \\\n keyentry with lines lw 3 lc rgb '%s' title ", plot_colour((uint32_t)n));
        plot_text(to, set->scenes[n], k->most);
    }
    for (size_t n = 0; n < set->setting_count && set->setting_count > 1; n++) {
        fprintf(to, ", \\\n keyentry with points pt %d ps 0.7 lc rgb '" PLOT_SOFT "' title ", plot_mark((uint32_t)n));
        plot_text(to, set->settings[n], k->most);
    }
    for (size_t n = 0; n < set->file_count && set->file_count > 1; n++) {
        fprintf(to, ", \\\n keyentry with lines lw 1.6 dt %d lc rgb '" PLOT_SOFT "' title ", plot_dash((uint32_t)n));
        plot_text(to, set->files[n].label, k->most);
    }
}

/* "city.glb, rule shadow, old.json" */
static void series_text(char text[256], const bench_set *set, const bench_series *s)
{
    int several = set->setting_count > 1, files = set->file_count > 1;
    snprintf(text, 256, "%.80s%s%.80s%s%.80s", set->scenes[s->scene], several ? ", " : "", several ? set->settings[s->setting] : "",
             files ? ", " : "", files ? set->files[s->file].label : "");
    clean_text(text); /* a name may be cut within a character */
}

/* Data blocks $s0, $s1, ... a line each; what has no points gets no block. Returns how many points there are. */
static size_t print_points(FILE *to, const bench_set *set, chart *c)
{
    size_t count = 0;
    for (size_t n = 0; n < set->series_count; n++)
        for (size_t f = 0; f < c->filter_count; f++) {
            const bench_series *s = &set->series[n];
            fprintf(to, "$s%zu << EOD\n", n * c->filter_count + f);
            for (size_t k = 0; k < s->count; k++) {
                point p;
                if (!c->at(&p, cell_at(set, s, k), c, c->filters[f]) || !(p.x > 0) || !(p.y > 0)) continue;
                fprintf(to, "%.9g %.9g %.9g %.9g %.9g %.9g %.9g\n", p.x, p.y, p.x_min > 0 ? p.x_min : p.x, p.x_max,
                        p.y_min > 0 ? p.y_min : p.y, p.y_max, cell_at(set, s, k)->side_px);
                axis_add(&c->x, p.x_min);
                axis_add(&c->x, p.x_max);
                axis_add(&c->y, p.y_min);
                axis_add(&c->y, p.y_max);
                range_add(&c->xs, p.x);
                range_add(&c->ys, p.y);
                count++;
            }
            fputs("EOD\n", to);
        }
    return count;
}

/* The line of a series: bars from least to greatest, the medians, and what stands beside them. */
static void print_line(FILE *to, const bench_set *set, const chart *c, size_t series, size_t filter)
{
    const bench_series *s      = &set->series[series];
    size_t              block  = series * c->filter_count + filter;
    const char         *colour = plot_colour(s->scene);
    growth              g      = {0};
    if (c->grows) g = growth_of(set, s, c->grows);
    if (g.count) {
        double from = cell_at(set, s, 0)->side_px, until = cell_at(set, s, s->count - 1)->side_px;
        fprintf(to,
                " '+' using (%.9g + $0 * %.9g):(%.9g * (%.9g + $0 * %.9g)**%.9g) every ::0::1 with lines lw 1.4 dt %d lc rgb '%s', "
                "\\\n",
                from, until - from, g.scale, from, until - from, g.slope, plot_dash(s->file), colour);
    }
    fprintf(to, " $s%zu using 3:2:($4-$3):(0) with vectors nohead lw 1 lc rgb '%s', \\\n", block, colour);
    fprintf(to, " $s%zu using 1:5:(0):($6-$5) with vectors nohead lw 1 lc rgb '%s', \\\n", block, colour);
    fprintf(to, " $s%zu using 1:2 with %s pt %d ps 0.7 lw 1.4 dt %d lc rgb '%s'", block, c->grows ? "points" : "linespoints",
            plot_mark(s->setting), plot_dash(s->file), colour);
    if (c->grows || !is_labelled(set, s) || filter) return;
    /* with filters there is room for the ends of a line alone */
    const char *every = c->filter_count > 1 ? "(int($0) == 0 || int($0) == LAST ? $2 : NaN)" : "2";
    if (c->filter_count > 1) fprintf(to, ", \\\n LAST = %zu", s->count - 1);
    fprintf(
        to,
        ", \\\n $s%zu using 1:%s:(sprintf('%%.0f', $7)) with labels left offset character 0.7, character 0.35 font ',11' textcolor "
        "rgb '%s'",
        block, every, colour);
}

/* What lies below each other is of one filter: its name stands above, in the middle of it. */
static void print_filters(FILE *to, const bench_set *set, const chart *c)
{
    for (size_t f = 0; f < c->filter_count && c->filter_count > 1; f++) {
        range x = RANGE_NOTHING;
        point p;
        for (size_t n = 0; n < set->cell_count; n++)
            if (c->at(&p, &set->cells[n], c, c->filters[f]) && p.x > 0 && p.y > 0) range_add(&x, p.x);
        if (x.min > x.max) continue;
        fprintf(to, c->filters[f] == 1 ? "set label '1 tap'" : "set label '%u x %u'", c->filters[f], c->filters[f]);
        fprintf(to, " at %.9g, graph 0.96 center font ',12' textcolor rgb '" PLOT_INK "'\n", sqrt(x.min * x.max));
    }
}

static void print_growth_key(FILE *to, const bench_set *set, const chart *c, const key *k)
{
    size_t shown = set->series_count > 12 ? 12 : set->series_count;
    for (size_t n = 0; n < shown; n++) {
        const bench_series *s = &set->series[n];
        growth              g = growth_of(set, s, c->grows);
        char                name[256], text[320];
        series_text(name, set, s);
        if (g.count)
            snprintf(text, sizeof text, "%.2f-fold, slope %.2f: %s", g.factor, g.slope, name);
        else
            snprintf(text, sizeof text, "one resolution, no slope: %s", name);
        fprintf(to, ", \\\n keyentry with %s pt %d ps 0.7 lw 1.4 dt %d lc rgb '%s' title ", g.count ? "linespoints" : "points",
                plot_mark(s->setting), plot_dash(s->file), plot_colour(s->scene));
        plot_text(to, text, k->most);
    }
    if (shown < set->series_count)
        fprintf(to, ", \\\n keyentry with lines lw 0 title 'and %zu more, in the table'", set->series_count - shown);
}

/* *has_points 0: there is nothing to draw, and p is empty. */
static vxs_result draw_chart(plot *p, const bench_set *set, chart *c, int *has_points, message *m)
{
    key   k  = key_of(set, c);
    FILE *to = plot_begin(p, c->name, PLOT_WIDTH, PLOT_HEIGHT);
    c->xs = c->ys = RANGE_NOTHING;
    *has_points   = 1;
    if (!to) return plot_end(p, m);
    *has_points = print_points(to, set, c) != 0;
    if (!*has_points) {
        plot_free(p);
        return VXS_OK;
    }
    axis_print(&c->x, to, 'x', c->grows ? 0 : 0.1);
    axis_print(&c->y, to, 'y', c->filter_count > 1 ? 0.14 : 0);
    print_filters(to, set, c);
    p->height += plot_bottom(to, k.rows);
    fprintf(to, "set key maxcols %zu\nplot", k.columns);
    for (size_t n = 0; n < set->series_count; n++)
        for (size_t f = 0; f < c->filter_count; f++) {
            if (n + f) fputs(", \\\n", to);
            print_line(to, set, c, n, f);
        }
    if (c->grows)
        print_growth_key(to, set, c, &k);
    else
        print_key(to, set, &k);
    fputc('\n', to);
    return plot_end(p, m);
}

/* what lies on the axes ------------------------------------------------------------------------------------------------------- */

static void set_x(point *p, spread s)
{
    p->x     = s.median;
    p->x_min = s.min;
    p->x_max = s.max;
}

static void set_y(point *p, spread s)
{
    p->y     = s.median;
    p->y_min = s.min;
    p->y_max = s.max;
}

/* No wrong answer has no place on a logarithmic axis: it is drawn where half an answer would be. */
static double seen_error(double error, const bench_error *e)
{
    double half = e->checked ? 0.5 / (double)e->checked : 0;
    return error > 0 ? error : e->filter_px == 1 ? half : sqrt(half);
}

static int wrong_by_time(point *p, const set_cell *c, const chart *of, uint32_t filter_px)
{
    const bench_error *e = bench_error_of(c->measured, of->kind, filter_px);
    if (!e) return 0;
    set_x(p, c->measured->total_seconds);
    set_y(p, exactly(seen_error(e->wrong_share, e)));
    return 1;
}

static int wrong_by_bytes(point *p, const set_cell *c, const chart *of, uint32_t filter_px)
{
    const bench_error *e = bench_error_of(c->measured, of->kind, filter_px);
    if (!e) return 0;
    set_x(p, exactly((double)c->measured->file_bytes));
    set_y(p, exactly(seen_error(e->wrong_share, e)));
    return 1;
}

static int rmse_by_lookup(point *p, const set_cell *c, const chart *of, uint32_t filter_px)
{
    const bench_error  *e = bench_error_of(c->measured, of->kind, filter_px);
    const bench_lookup *l = bench_lookup_of(c->measured, filter_px);
    if (!e || !l) return 0;
    set_x(p, l->nanoseconds);
    set_y(p, exactly(seen_error(bench_rmse(e), e)));
    return 1;
}

static int bytes_by_resolution(point *p, const set_cell *c, const chart *of, uint32_t filter_px)
{
    (void)of, (void)filter_px;
    set_x(p, exactly(c->side_px));
    set_y(p, exactly((double)c->measured->file_bytes));
    return 1;
}

static int time_by_resolution(point *p, const set_cell *c, const chart *of, uint32_t filter_px)
{
    (void)of, (void)filter_px;
    set_x(p, exactly(c->side_px));
    set_y(p, c->measured->total_seconds);
    return 1;
}

static double file_bytes_of(const bench_cell *c)
{
    return (double)c->file_bytes;
}

static double total_seconds_of(const bench_cell *c)
{
    return c->total_seconds.median;
}

/* plots ----------------------------------------------------------------------------------------------------------------------- */

/* Draw a chart and keep it; *p is NULL when it has no points. */
static vxs_result add_chart(bench_plots *plots, const bench_set *set, chart *c, plot **p, message *m)
{
    int has_points;
    *p = bench_plots_another(plots, m);
    if (!*p) return VXS_E_MEMORY;
    vxs_result r = draw_chart(*p, set, c, &has_points, m);
    if (has_points)
        plots->count++;
    else
        *p = NULL;
    return r;
}

static vxs_result add_growth(bench_plots *plots, const bench_set *set, chart c, const char *what, message *m)
{
    range folds = RANGE_NOTHING;
    char  text[80];
    plot *p;
    for (size_t n = 0; n < set->series_count; n++) {
        growth g = growth_of(set, &set->series[n], c.grows);
        if (g.count) range_add(&folds, g.factor);
    }
    vxs_result r = add_chart(plots, set, &c, &p, m);
    if (r != VXS_OK || !p) return r;
    if (folds.min <= folds.max)
        snprintf(p->title, sizeof p->title, "%s grows %s with each doubling of the resolution", what,
                 range_text(text, folds, fold_text));
    else
        snprintf(p->title, sizeof p->title, "%s by resolution: of one alone, so nothing is known of its growth", what);
    snprintf(p->caption, sizeof p->caption,
             "Both axes are logarithmic. Lines are fits by least squares to the logarithms of medians; bars reach from the least "
             "to the greatest run.");
    return r;
}

vxs_result bench_lines_growth(bench_plots *plots, const bench_set *set, plot_group group, message *m)
{
    const chart time  = {.name         = "growth-time",
                         .x            = axis_of(UNIT_TEXELS, 0, "texels a side"),
                         .y            = axis_of(UNIT_SECONDS, 0, "bake time"),
                         .at           = time_by_resolution,
                         .filters      = {1},
                         .filter_count = 1,
                         .grows        = total_seconds_of};
    const chart bytes = {.name         = "growth-bytes",
                         .x            = axis_of(UNIT_TEXELS, 0, "texels a side"),
                         .y            = axis_of(UNIT_BYTES, 0, "size of the file"),
                         .at           = bytes_by_resolution,
                         .filters      = {1},
                         .filter_count = 1,
                         .grows        = file_bytes_of};
    return group == PLOTS_TIME ? add_growth(plots, set, time, "Bake time", m) : add_growth(plots, set, bytes, "The file", m);
}

static vxs_result add_wrong(bench_plots *plots, const bench_set *set, chart c, const char *of,
                            const char *(*words)(char[32], double), message *m)
{
    char       a[80], b[80];
    plot      *p;
    vxs_result r = add_chart(plots, set, &c, &p, m);
    if (r != VXS_OK || !p) return r;
    snprintf(p->title, sizeof p->title, "Of %s, %s are answered wrong, by %s %s", bench_points_text(c.kind),
             range_text(a, c.ys, percent_text), of, range_text(b, c.xs, words));
    snprintf(
        p->caption, sizeof p->caption,
        "Single taps against ray tracing; lower and further left is better. Numbers are texels a side. Where nothing is wrong, "
        "the mark is where half a point would be.");
    return r;
}

static vxs_result add_lookup(bench_plots *plots, const bench_set *set, chart c, message *m)
{
    char       a[80], b[80];
    plot      *p;
    vxs_result r = add_chart(plots, set, &c, &p, m);
    if (r != VXS_OK || !p) return r;
    snprintf(p->title, sizeof p->title, "A lookup takes %s, and is off by %s at %s", range_text(b, c.xs, nanoseconds_text),
             range_text(a, c.ys, percent_text), bench_points_text(c.kind));
    snprintf(p->caption, sizeof p->caption,
             "Root mean square against the same filter over rays, of full light; for 1 tap that is the root of the share of wrong "
             "answers. Numbers are texels a side.");
    return r;
}

/* All widths that any cell has, the single tap first where it is there. */
static void collect_filters(chart *c, const bench_set *set)
{
    size_t room = sizeof c->filters / sizeof *c->filters;
    for (size_t n = 0; n < set->cell_count; n++)
        for (size_t k = 0; k < set->cells[n].measured->lookup_count; k++) {
            uint32_t filter_px = set->cells[n].measured->lookups[k].filter_px;
            size_t   at        = 0;
            while (at < c->filter_count && c->filters[at] != filter_px) at++;
            if (at == c->filter_count && at < room) c->filters[c->filter_count++] = filter_px;
        }
}

vxs_result bench_lines_errors(bench_plots *plots, const bench_set *set, message *m)
{
    vxs_result r = VXS_OK;
    for (int what = 0; what < 3; what++)
        for (bench_points kind = 0; kind < BENCH_POINTS_COUNT && r == VXS_OK; kind++) {
            static const char *const names[] = {"error-bake", "error-bytes", "error-lookup"};
            char                     name[64], word[32];
            chart                    c = {.name = name, .kind = kind, .filters = {1}, .filter_count = 1};
            snprintf(name, sizeof name, "%s-%s", names[what], choice_word(word, BENCH_POINTS_WORDS, (int)kind));
            if (what == 0) {
                c.at = wrong_by_time;
                c.x  = axis_of(UNIT_SECONDS, 0, "bake time");
                c.y  = axis_of(UNIT_SHARE, 0, "wrong answers");
                r    = add_wrong(plots, set, c, "bakes of", seconds_text, m);
            } else if (what == 1) {
                c.at = wrong_by_bytes;
                c.x  = axis_of(UNIT_BYTES, 0, "size of the file");
                c.y  = axis_of(UNIT_SHARE, 0, "wrong answers");
                r    = add_wrong(plots, set, c, "files of", bytes_text, m);
            } else {
                c.at           = rmse_by_lookup;
                c.x            = axis_of(UNIT_NANOSECONDS, 0, "time of a lookup");
                c.y            = axis_of(UNIT_SHARE, 0, "root mean square error");
                c.filter_count = 0;
                collect_filters(&c, set);
                if (c.filter_count) r = add_lookup(plots, set, c, m);
            }
        }
    return r;
}
