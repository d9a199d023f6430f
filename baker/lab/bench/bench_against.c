/* Changes between two measurements; see bench_text.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/bench/bench_text.h"

#include <math.h>
#include <stdarg.h>
#include <string.h>

#include "baker/base/text.h"

static const double stage_share  = 0.05; /* stages that take a smaller share of a bake are ignored */
static const double memory_share = 0.05; /* change of peak memory that counts as a change */
static const double equal_share  = 1e-8; /* numbers are written with nine digits */

typedef struct moves {
    json_t     *table;
    const char *cell; /* its name */
    double      max_slower;
    size_t      too_slow;
} moves;

/* Figures ---------------------------------------------------------------------------------------------------------------------- */

static int outside(double value, spread s)
{
    return value < s.min * (1 - equal_share) || value > s.max * (1 + equal_share);
}

static void add_row(moves *v, const char *what, const char *before, const char *now, double ratio)
{
    static const char *const heads[] = {"moved", "figure", "before", "now", "now / before"};
    if (!json_array_size(v->table))
        for (size_t n = 0; n < sizeof heads / sizeof *heads; n++) table_add(v->table, "%s", heads[n]);
    table_add(v->table, "%s", v->cell);
    table_add(v->table, "%s", what);
    table_add(v->table, "%s", before);
    table_add(v->table, "%s", now);
    if (isfinite(ratio))
        table_add(v->table, "%.3f", ratio);
    else
        table_add(v->table, "-");
}

static int has_moved(const bench_figure *now, const bench_figure *before)
{
    double equal = now->kind == FIGURE_PEAK_BYTES ? memory_share : now->kind == FIGURE_SHARE ? equal_share : 0;
    double a = before->value.median, b = now->value.median;
    if (now->kind == FIGURE_SECONDS) return outside(a, now->value) && outside(b, before->value);
    return fabs(a - b) > equal * fmax(a, b);
}

static const char *value_text(char text[64], const bench_figure *f)
{
    if (f->kind == FIGURE_SECONDS) return spread_text(text, f->value);
    if (f->kind == FIGURE_SHARE)
        snprintf(text, 64, "%.6g %%", 100 * f->value.median);
    else
        snprintf(text, 64, "%.0f%s", f->value.median, f->kind == FIGURE_COUNT ? "" : " B");
    return text;
}

/* Compare the figures that both cells have. same_points: errors were measured at the same points */
static void compare_cells(moves *v, const json_t *before, const json_t *now, int same_points)
{
    bench_figure a[BENCH_FIGURES_MAX], b[BENCH_FIGURES_MAX];
    size_t       a_count = bench_figures(before, a), b_count = bench_figures(now, b);
    char         before_text[64], now_text[64];
    for (size_t n = 0; n < b_count; n++)
        for (size_t i = 0; i < a_count; i++) {
            double then = a[i].value.median, here = b[n].value.median;
            int    is_small = then < stage_share * a[0].value.median && here < stage_share * b[0].value.median;
            if (strcmp(a[i].name, b[n].name) || !has_moved(&b[n], &a[i])) continue;
            if ((b[n].flags & FIGURE_STAGE && is_small) || (b[n].flags & FIGURE_ERROR && !same_points)) continue;
            add_row(v, b[n].name, value_text(before_text, &a[i]), value_text(now_text, &b[n]), here / then);
            v->too_slow += b[n].flags & FIGURE_LIMITED && here > v->max_slower * then;
        }
}

/* Cells ------------------------------------------------------------------------------------------------------------------------ */

static const json_t *find_cell(const json_t *result, const json_t *cell)
{
    json_t *other;
    size_t  n;
    json_array_foreach(json_at(result, "cells"), n, other) if (bench_cells_equal(other, cell)) return other;
    return NULL;
}

/* Results ---------------------------------------------------------------------------------------------------------------------- */

/* Print a line that may contain text from files. */
static void print_line(FILE *to, const char *format, ...) __attribute__((format(printf, 2, 3)));
static void print_line(FILE *to, const char *format, ...)
{
    char    text[512];
    va_list args;
    if (!to) return;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    fprintf(to, "%s\n", one_line(text));
}

/* Returns whether errors can be compared. */
static int print_differences(FILE *to, const json_t *now, const json_t *before)
{
    static const char *const members[][2] = {{"vxs", "vxs"},
                                             {"processor", "machine/processor"},
                                             {"cores", "machine/cores"},
                                             {"memory, bytes", "machine/memory_bytes"},
                                             {"system", "machine/system"},
                                             {"OpenGL", "machine/renderer"},
                                             {"runs", "runs"},
                                             {"points", "points"}};
    int                      same         = 1;
    for (size_t n = 0; n < sizeof members / sizeof *members; n++) {
        const char   *name = members[n][0], *path = members[n][1];
        const json_t *a = json_at(before, path), *b = json_at(now, path);
        same = json_equal(a, b);
        if (!same && json_is_string(b)) print_line(to, "%s: %s, before: %s", name, json_string_value(b), json_string_value(a));
        if (!same && json_is_integer(b))
            print_line(to, "%s: %lld, before: %lld%s", name, json_integer_value(b), json_integer_value(a),
                       strcmp(name, "points") ? "" : ": errors are not compared");
    }
    return same; /* of the last, the points */
}

static void print_cells_only_in(FILE *to, const json_t *one, const json_t *other, const char *where)
{
    char    name[256];
    json_t *cell;
    size_t  n;
    json_array_foreach(json_at(one, "cells"), n, cell)
    {
        if (!find_cell(other, cell)) fprintf(to, "only %s: %s\n", where, bench_cell_name(name, sizeof name, one, cell));
    }
}

vxs_result bench_against(FILE *to, const json_t *now, const json_t *before, const char *before_path, double max_slower,
                         size_t *too_slow, run_context *m)
{
    moves   v    = {.table = json_array(), .max_slower = max_slower};
    size_t  both = 0, n;
    json_t *cell;
    if (to) fprintf(to, "\n");
    print_line(to, "against %s of %s", before_path, text_at(before, "started"));
    int same_points = print_differences(to, now, before);
    json_array_foreach(json_at(now, "cells"), n, cell)
    {
        const json_t *earlier = find_cell(before, cell);
        char          name[256];
        if (!earlier) continue;
        both++;
        v.cell = bench_cell_name(name, sizeof name, now, cell);
        compare_cells(&v, earlier, cell, same_points);
    }
    *too_slow = v.too_slow;
    if (!both)
        print_line(to, "no cell is in both");
    else if (!json_array_size(v.table))
        print_line(to, "nothing moved in %zu cells", both);
    if (!to) {
        json_decref(v.table);
        return VXS_OK;
    }
    vxs_result r = table_print(v.table, 5, to, m);
    if (r != VXS_OK) return r;
    print_cells_only_in(to, now, before, "now");
    print_cells_only_in(to, before, now, "before");
    return VXS_OK;
}
