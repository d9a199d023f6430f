/* What moved between two measurements; see bench_against.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/bench/bench_against.h"

#include <math.h>
#include <stdarg.h>
#include <string.h>

#include "baker/base/text.h"
#include "baker/bench/bench_text.h"

static const double stage_share  = 0.05; /* stages that take less of a bake are left out */
static const double memory_share = 0.05; /* of peak memory that is never quite the same */
static const double equal_share  = 1e-8; /* numbers are written with nine digits */

/* The first two may be too slow. */
typedef enum figure_kind {
    SECONDS_LIMITED,
    NANOSECONDS_LIMITED,
    SECONDS,
    NANOSECONDS,
    BYTES,
    PEAK_BYTES,
    COUNT,
    SHARE
} figure_kind;

typedef struct figure {
    const char *name, *path;
    figure_kind kind;
} figure;

typedef struct moves {
    json_t     *table;
    const char *cell; /* its name */
    double      max_slower;
    size_t      too_slow;
} moves;

/* Figures -------------------------------------------------------------------------------------------------------------------- */

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

static void compare_times(moves *v, const char *what, spread before, spread now, int is_limited)
{
    char before_text[64], now_text[64];
    if (!outside(before.median, now) || !outside(now.median, before)) return;
    add_row(v, what, spread_text(before_text, before), spread_text(now_text, now), now.median / before.median);
    v->too_slow += is_limited && now.median > v->max_slower * before.median;
}

static void compare_numbers(moves *v, const char *what, figure_kind kind, double before, double now)
{
    static const char *const formats[] = {[BYTES] = "%.0f B", [PEAK_BYTES] = "%.0f B", [COUNT] = "%.0f", [SHARE] = "%.6g %%"};
    double                   equal     = kind == PEAK_BYTES ? memory_share : kind == SHARE ? equal_share : 0;
    double                   unit      = kind == SHARE ? 100 : 1;
    char                     before_text[32], now_text[32];
    if (!(fabs(before - now) > equal * fmax(before, now))) return;
    snprintf(before_text, sizeof before_text, formats[kind], unit * before);
    snprintf(now_text, sizeof now_text, formats[kind], unit * now);
    add_row(v, what, before_text, now_text, now / before);
}

/* Figures of an object that both have; those that it has not are left out.
 * figures  ends with a name of NULL
 * of       what filter and points they are of; see figure_text */
static void compare(moves *v, const figure *figures, const json_t *before, const json_t *now)
{
    char what[96];
    for (const figure *f = figures; f->name; f++) {
        if (!json_at(now, f->path) || !json_at(before, f->path)) continue;
        figure_text(what, f->name, count_at(now, "filter_px"), text_at(now, "points"));
        double unit = f->kind == NANOSECONDS || f->kind == NANOSECONDS_LIMITED ? 1e-9 : 1;
        if (f->kind <= NANOSECONDS)
            compare_times(v, what, spread_at(before, f->path, unit), spread_at(now, f->path, unit), f->kind <= NANOSECONDS_LIMITED);
        else
            compare_numbers(v, what, f->kind, number_at(before, f->path), number_at(now, f->path));
    }
}

/* Cells ---------------------------------------------------------------------------------------------------------------------- */

static void compare_stages(moves *v, const json_t *before, const json_t *now)
{
    json_t *a, *b;
    size_t  n, i;
    double  least_before = stage_share * number_at(before, "bake/wall_seconds/median"),
           least_now     = stage_share * number_at(now, "bake/wall_seconds/median");
    json_array_foreach(json_at(now, "bake/stages"), n, b) json_array_foreach(json_at(before, "bake/stages"), i, a)
    {
        spread then = spread_at(a, "seconds", 1), here = spread_at(b, "seconds", 1);
        char   what[64];
        if (strcmp(text_at(a, "name"), text_at(b, "name")) || (then.median < least_before && here.median < least_now)) continue;
        snprintf(what, sizeof what, "stage %s", text_at(b, "name"));
        compare_times(v, what, then, here, 0);
    }
}

/* Items of the same filter and points. */
static void compare_items(moves *v, const figure *figures, const json_t *before, const json_t *now)
{
    json_t *a, *b;
    size_t  n, i;
    json_array_foreach(now, n, b) json_array_foreach(before, i, a)
    {
        if (count_at(a, "filter_px") == count_at(b, "filter_px") && !strcmp(text_at(a, "points"), text_at(b, "points")))
            compare(v, figures, a, b);
    }
}

/* same_points  errors were measured at the same points */
static void compare_cells(moves *v, const json_t *before, const json_t *now, int same_points)
{
    static const figure times[] = {
        {"bake", "bake/wall_seconds", SECONDS_LIMITED}, {"maps to DAG", "bake/maps_to_dag_seconds", SECONDS}, {NULL, NULL, COUNT}};
    static const figure sizes[]  = {{"peak memory", "bake/peak_bytes", PEAK_BYTES},
                                    {"triangles", "triangles", COUNT},
                                    {"triangles of solids", "solid_triangles", COUNT},
                                    {"lights", "lights", COUNT},
                                    {"maps", "maps", COUNT},
                                    {"file", "size/file_bytes", BYTES},
                                    {"in memory", "size/memory_bytes", BYTES},
                                    {"nodes", "size/nodes", COUNT},
                                    {"masks", "size/masks", COUNT},
                                    {"inserted nodes", "size/inserted_nodes", COUNT},
                                    {"inserted masks", "size/inserted_masks", COUNT},
                                    {NULL, NULL, COUNT}};
    static const figure errors[] = {
        {"RMSE", "rmse", SHARE},   {"greatest error", "max_error", SHARE},    {"wrong", "wrong_share", SHARE},
        {"leaks", "leaks", COUNT}, {"false shadows", "false_shadows", COUNT}, {"unexplained", "unexplained", COUNT},
        {NULL, NULL, COUNT}};
    static const figure lookups[] = {
        {"lookup", "nanoseconds", NANOSECONDS_LIMITED}, {"ray", "ray_nanoseconds", NANOSECONDS}, {NULL, NULL, COUNT}};
    compare(v, times, before, now);
    compare_stages(v, before, now);
    compare(v, sizes, before, now);
    if (same_points) compare_items(v, errors, json_at(before, "errors"), json_at(now, "errors"));
    compare_items(v, lookups, json_at(before, "lookups"), json_at(now, "lookups"));
}

static const json_t *find_cell(const json_t *result, const json_t *cell)
{
    json_t *other;
    size_t  n;
    json_array_foreach(json_at(result, "cells"), n, other) if (bench_cells_equal(other, cell)) return other;
    return NULL;
}

/* Results -------------------------------------------------------------------------------------------------------------------- */

/* A line that may hold text from files. */
static void print_line(FILE *to, const char *format, ...) __attribute__((format(printf, 2, 3)));
static void print_line(FILE *to, const char *format, ...)
{
    char    text[512];
    va_list args;
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
                         size_t *too_slow, message *m)
{
    moves   v    = {.table = json_array(), .max_slower = max_slower};
    size_t  both = 0, n;
    json_t *cell;
    fprintf(to, "\n");
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
    if (!both)
        fprintf(to, "no cell is in both\n");
    else if (!json_array_size(v.table))
        fprintf(to, "nothing moved in %zu cells\n", both);
    *too_slow    = v.too_slow;
    vxs_result r = table_print(v.table, 5, to, m);
    if (r != VXS_OK) return r;
    print_cells_only_in(to, now, before, "now");
    print_cells_only_in(to, before, now, "before");
    return VXS_OK;
}
