/* Bars of one scene; see bench_parts.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/page/bench_parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "baker/page/axis.h"
#include "baker/page/html.h"

enum { BAR_ROW = 22, ROWS_MAX = 40, PARTS_MAX = 32, NAME_MOST = 62 };

/* bars of one scene ----------------------------------------------------------------------------------------------------------- */

/* What bars are stacked of. */
typedef struct stack_part {
    char   name[40];
    char   colour[8];
    double most; /* share of a bar, at most */
} stack_part;

typedef struct stack {
    const bench_set *set;
    const set_cell  *rows[ROWS_MAX];
    size_t           row_count, rows_left_out;
    stack_part       parts[PARTS_MAX];
    size_t           part_count;
    double           values[ROWS_MAX][PARTS_MAX];
    spread           totals[ROWS_MAX];
} stack;

static void collect_rows(stack *s, const bench_set *set, uint32_t scene)
{
    *s = (stack){.set = set};
    for (size_t n = 0; n < set->series_count; n++)
        for (size_t k = 0; k < set->series[n].count && set->series[n].scene == scene; k++) {
            if (s->row_count < ROWS_MAX)
                s->rows[s->row_count++] = cell_at(set, &set->series[n], k);
            else
                s->rows_left_out++;
        }
}

/* The part of that name, taken in when it is new; the last one holds what is beyond PARTS_MAX. */
static size_t part_of(stack *s, const char *name, const char *colour)
{
    char cut[sizeof s->parts->name];
    snprintf(cut, sizeof cut, "%s", name);
    clean_text(cut);
    for (size_t n = 0; n < s->part_count; n++)
        if (!strcmp(s->parts[n].name, cut)) return n;
    if (s->part_count == PARTS_MAX) return PARTS_MAX - 1;
    stack_part *p = &s->parts[s->part_count];
    snprintf(p->name, sizeof p->name, "%s", cut);
    snprintf(p->colour, sizeof p->colour, "%s", colour);
    return s->part_count++;
}

/* Parts that are nowhere a hundredth of a bar become one, the last. */
static void join_small_parts(stack *s, const char *name)
{
    size_t kept           = 0;
    double rest[ROWS_MAX] = {0};
    int    joined         = 0;
    for (size_t part = 0; part < s->part_count; part++)
        for (size_t row = 0; row < s->row_count; row++)
            if (s->totals[row].median > 0)
                s->parts[part].most = fmax(s->parts[part].most, s->values[row][part] / s->totals[row].median);
    for (size_t part = 0; part < s->part_count; part++) {
        int is_small = s->parts[part].most < 0.01;
        joined += is_small;
        for (size_t row = 0; row < s->row_count; row++) {
            if (is_small) rest[row] += s->values[row][part];
            s->values[row][kept] = s->values[row][part];
        }
        if (!is_small) s->parts[kept++] = s->parts[part];
    }
    s->part_count = kept;
    if (!joined) return;
    size_t last = part_of(s, name, "#b9b6ab");
    for (size_t row = 0; row < s->row_count; row++) s->values[row][last] = rest[row];
}

/* "4096, rule shadow, old.json" */
static void row_text(char text[128], const bench_set *set, const set_cell *c)
{
    int several = set->setting_count > 1, files = set->file_count > 1;
    snprintf(text, 128, "%.0f%s%.48s%s%.48s", c->side_px, several ? ", " : "", several ? set->settings[c->setting] : "",
             files ? ", " : "", files ? set->files[c->file].label : "");
    clean_text(text);
}

static vxs_result draw_stack(plot *p, const char *name, const stack *s, axis x, const char *(*words)(char[32], double), message *m)
{
    size_t label = 4;
    char   text[128], total[32];
    for (size_t row = 0; row < s->row_count; row++) {
        row_text(text, s->set, s->rows[row]);
        label = strlen(text) > label ? strlen(text) : label;
        axis_add(&x, s->totals[row].max);
    }
    uint32_t width    = label > 12 ? PLOT_WIDE : PLOT_WIDTH;
    size_t   most     = label > 44 ? 44 : label;
    size_t   columns  = width == PLOT_WIDE ? 4 : 3; /* that fit: SVG takes text to be wider than PNG does */
    size_t   key_rows = (s->part_count + columns - 1) / columns;
    FILE    *to       = plot_begin(p, name, width, (uint32_t)(14 + BAR_ROW * s->row_count));
    if (!to) return plot_end(p, m);
    axis_print(&x, to, 'x', 0.14);
    p->height += plot_bottom(to, key_rows);
    fprintf(to, "set lmargin %zu\nset key maxcols %zu\n", most + 2, columns);
    fprintf(to, "set border 1\nunset grid\nset grid xtics lt 1 lw 0.6 lc rgb '" PLOT_RULE "'\n");
    fprintf(to, "set yrange [%.1f:-0.6]\nset ytics scale 0 (", (double)s->row_count - 0.4);
    for (size_t row = 0; row < s->row_count; row++) {
        row_text(text, s->set, s->rows[row]);
        if (row) fputs(", ", to);
        plot_tic(to, text, most, (double)row);
    }
    fputs(")\n", to);
    for (size_t row = 0; row < s->row_count; row++)
        fprintf(to, "set label '%s' at %.9g, %zu left offset character 0.7, 0 font ',12' textcolor rgb '" PLOT_INK "'\n",
                words(total, s->totals[row].median), s->totals[row].max, row);
    fputs("$rows << EOD\n", to);
    for (size_t row = 0; row < s->row_count; row++) {
        double sum = 0;
        fprintf(to, "%zu %.9g %.9g %.9g 0", row, s->totals[row].median, s->totals[row].min, s->totals[row].max);
        for (size_t part = 0; part < s->part_count; part++) fprintf(to, " %.9g", sum += s->values[row][part]);
        fputc('\n', to);
    }
    fputs("EOD\nplot", to);
    for (size_t part = 0; part < s->part_count; part++)
        fprintf(to, " $rows using (0):1:%zu:%zu:($1-0.36):($1+0.36) with boxxyerror lc rgb '%s', \\\n", part + 5, part + 6,
                s->parts[part].colour);
    fputs(" $rows using 3:1:($4-$3):(0) with vectors nohead lw 1.2 lc rgb '" PLOT_INK "'", to);
    for (size_t part = 0; part < s->part_count; part++) {
        fprintf(to, ", \\\n keyentry with boxes lc rgb '%s' title ", s->parts[part].colour);
        plot_text(to, s->parts[part].name, 18);
    }
    fputc('\n', to);
    return plot_end(p, m);
}

/* "84 % to 91 % of the bake goes to maps": the part that is largest over all bars. */
static void stack_title(plot *p, const char *scene, const stack *s, const char *whole)
{
    size_t largest         = 0;
    double sums[PARTS_MAX] = {0};
    range  shares          = RANGE_NOTHING;
    char   text[80];
    for (size_t part = 0; part < s->part_count; part++)
        for (size_t row = 0; row < s->row_count; row++)
            if (s->totals[row].median > 0) sums[part] += s->values[row][part] / s->totals[row].median;
    for (size_t part = 1; part < s->part_count; part++)
        if (sums[part] > sums[largest]) largest = part;
    for (size_t row = 0; row < s->row_count && s->part_count; row++)
        if (s->totals[row].median > 0) range_add(&shares, s->values[row][largest] / s->totals[row].median);
    if (shares.min > shares.max)
        snprintf(p->title, sizeof p->title, "%.100s", scene);
    else
        snprintf(p->title, sizeof p->title, "%.100s: %s of %s goes to %s%s", scene, range_text(text, shares, percent_text), whole,
                 s->parts[largest].name, strstr(s->parts[largest].name, "³") ? " nodes" : "");
    clean_text(p->title);
}

static void say_rows_left_out(plot *p, const stack *s)
{
    size_t at = strlen(p->caption);
    if (s->rows_left_out) snprintf(p->caption + at, sizeof p->caption - at, " %zu more bakes are in the table.", s->rows_left_out);
}

/* What the bars of one plot are. */
typedef struct stack_plot {
    const char *name; /* of the plot; the scene's number is added */
    axis        x;
    const char *(*words)(char[32], double);
    const char *whole, *caption; /* what a bar is of, for the title */
} stack_plot;

static vxs_result add_stack(bench_plots *plots, stack *s, uint32_t scene, const stack_plot *of, message *m)
{
    char name[32];
    join_small_parts(s, "others");
    plot *p = bench_plots_another(plots, m);
    if (!p) return VXS_E_MEMORY;
    snprintf(name, sizeof name, "%s-%u", of->name, scene + 1);
    plots->count++;
    vxs_result r = draw_stack(p, name, s, of->x, of->words, m);
    stack_title(p, s->set->scenes[scene], s, of->whole);
    snprintf(p->caption, sizeof p->caption, "%s", of->caption);
    say_rows_left_out(p, s);
    return r;
}

/* Greys before the maps, blue for them, greens from them to the DAG, browns for the file. */
static const char *stage_colour(const char *name, size_t number)
{
    static const char *const known[][2] = {{"load", "#8d8a80"},  {"solids", "#a7a499"}, {"plan", "#75736b"},
                                           {"gl", "#9a8fb0"},    {"maps", "#3d7ab8"},   {"pyramid", "#8ccf9d"},
                                           {"masks", "#66b37e"}, {"insert", "#3c9260"}, {"compress", "#2a7048"},
                                           {"merge", "#1f5737"}, {"encode", "#d0702a"}, {"write", "#94742f"}};
    for (size_t n = 0; n < sizeof known / sizeof *known; n++)
        if (!strcmp(known[n][0], name)) return known[n][1];
    return plot_colour((uint32_t)number);
}

vxs_result bench_bars_stages(bench_plots *plots, const bench_set *set, uint32_t scene, message *m)
{
    static const char caption[] =
        "A bar is a bake, labelled with its texels a side; the thin line at its end reaches from the least to the greatest "
        "run. Stages below 1 % everywhere are joined.";
    stack s;
    collect_rows(&s, set, scene);
    for (size_t row = 0; row < s.row_count; row++) {
        const bench_cell *c = s.rows[row]->measured;
        s.totals[row]       = c->total_seconds;
        for (size_t n = 0; n < c->stage_count; n++)
            s.values[row][part_of(&s, c->stages[n].name, stage_colour(c->stages[n].name, n))] += c->stages[n].seconds.median;
    }
    stack_plot of = {"stages", axis_of(UNIT_SECONDS, 1, "bake time by stage, medians"), seconds_text, "the bake", caption};
    return add_stack(plots, &s, scene, &of, m);
}

/* Fine to coarse: masks stand apart, nodes fade. Levels are counted as bench_cell has them. */
static void level_part(int level, char name[40], char colour[8])
{
    double shade = fmin(1, fmax(0, (level - 3) / 8.0));
    if (!level) {
        strcpy(name, "masks");
        strcpy(colour, "#d0702a");
        return;
    }
    snprintf(name, 40, "%.0f³", ldexp(1, level));
    snprintf(colour, 8, "#%02x%02x%02x", (int)(0x24 + shade * 0xa4), (int)(0x54 + shade * 0x84), (int)(0x8c + shade * 0x5c));
}

static vxs_result add_level_bytes(bench_plots *plots, const bench_set *set, uint32_t scene, message *m)
{
    static const char caption[] =
        "Masks are 8 x 8 texels of one depth; n³ are nodes of n voxels a side. Head is what is no light's. What is below 1 % "
        "everywhere is joined.";
    stack s;
    collect_rows(&s, set, scene);
    for (size_t row = 0; row < s.row_count; row++) {
        const bench_cell *c    = s.rows[row]->measured;
        double            rest = (double)c->file_bytes;
        s.totals[row]          = exactly(rest);
        for (int n = 0; n < BENCH_LEVELS_MAX; n++) {
            char what[40], colour[8];
            if (!(c->level_set >> n & 1)) continue;
            level_part(n, what, colour);
            s.values[row][part_of(&s, what, colour)] += (double)c->levels[n].stored_bytes;
            rest -= (double)c->levels[n].stored_bytes;
        }
        if (rest > 0) s.values[row][part_of(&s, "head", "#8d8a80")] += rest;
    }
    stack_plot of = {"bytes-by-level", axis_of(UNIT_BYTES, 1, "bytes of the file by level"), bytes_text, "the file", caption};
    return add_stack(plots, &s, scene, &of, m);
}

static vxs_result add_level_counts(bench_plots *plots, const bench_set *set, uint32_t scene, message *m)
{
    stack s;
    char  name[40];
    axis  x = axis_of(UNIT_VOXELS, 0, "level, by the voxels a side of its nodes"), y = axis_of(UNIT_COUNT, 0, "nodes, masks");
    collect_rows(&s, set, scene);
    size_t keys = (set->setting_count > 1 ? set->setting_count : 0) + (set->file_count > 1 ? set->file_count : 0);
    plot  *p    = bench_plots_another(plots, m);
    if (!p) return VXS_E_MEMORY;
    snprintf(name, sizeof name, "nodes-by-level-%u", scene + 1);
    FILE *to = plot_begin(p, name, PLOT_WIDTH, PLOT_HEIGHT);
    plots->count++;
    if (!to) return plot_end(p, m);
    double fine = 0, all = 0;
    for (size_t row = 0; row < s.row_count; row++) {
        const bench_cell *c = s.rows[row]->measured;
        fprintf(to, "$r%zu << EOD\n", row);
        for (int n = 0; n < BENCH_LEVELS_MAX; n++) {
            double side = n ? ldexp(1, n) : MASKS_AT, count = (double)c->levels[n].count;
            if (!(c->level_set >> n & 1) || !(count > 0)) continue;
            fprintf(to, "%.9g %.9g\n", side, count);
            axis_add(&x, side);
            axis_add(&y, count);
            all += count;
            if (n <= 4) fine += count;
        }
        fputs("EOD\n", to);
    }
    axis_print(&x, to, 'x', 0);
    axis_print(&y, to, 'y', 0);
    p->height += plot_bottom(to, keys);
    fprintf(to, "set key maxcols 1\nplot NaN");
    for (size_t row = 0; row < s.row_count; row++)
        fprintf(to, ", \\\n $r%zu using 1:2 with linespoints pt %d ps 0.6 lw 1.2 dt %d lc rgb '%s'", row,
                plot_mark(s.rows[row]->setting), plot_dash(s.rows[row]->file), plot_colour(scene));
    for (size_t n = 0; n < set->setting_count && set->setting_count > 1; n++) {
        fprintf(to, ", \\\n keyentry with points pt %d ps 0.7 lc rgb '" PLOT_SOFT "' title ", plot_mark((uint32_t)n));
        plot_text(to, set->settings[n], NAME_MOST);
    }
    for (size_t n = 0; n < set->file_count && set->file_count > 1; n++) {
        fprintf(to, ", \\\n keyentry with lines lw 1.6 dt %d lc rgb '" PLOT_SOFT "' title ", plot_dash((uint32_t)n));
        plot_text(to, set->files[n].label, NAME_MOST);
    }
    fputc('\n', to);
    char share[32];
    snprintf(p->title, sizeof p->title, "%.100s: masks, 8³ and 16³ are %s of all nodes and masks", set->scenes[scene],
             percent_text(share, all > 0 ? fine / all : 0));
    clean_text(p->title);
    snprintf(p->caption, sizeof p->caption, "A line is a bake. It ends at its root, which is as wide as the map.");
    return plot_end(p, m);
}

vxs_result bench_bars_levels(bench_plots *plots, const bench_set *set, uint32_t scene, message *m)
{
    vxs_result r = add_level_bytes(plots, set, scene, m);
    return r == VXS_OK ? add_level_counts(plots, set, scene, m) : r;
}
