/* What moved between two measurements; see bench_against.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/bench/bench_against.h"

#include <math.h>
#include <stdarg.h>
#include <string.h>

#include "baker/base/text.h"
#include "baker/bench/bench_text.h"
#include "baker/bench/text_table.h"

static const double stage_share  = 0.05; /* stages that take less of a bake are left out */
static const double memory_share = 0.05; /* of peak memory that is never quite the same */
static const double equal_share  = 1e-8; /* numbers are written with nine digits */

typedef struct moves {
    text_table  table;
    const char *cell; /* its name */
    double      max_slower;
    size_t      too_slow, rows;
} moves;

/* Figures -------------------------------------------------------------------------------------------------------------------- */

static int differ(double a, double b, double share)
{
    return fabs(a - b) > share * fmax(fabs(a), fabs(b));
}

static int outside(double value, const spread *s)
{
    return value < s->min * (1 - equal_share) || value > s->max * (1 + equal_share);
}

static void add_heads(text_table *t)
{
    static const char *const heads[] = {"moved", "figure", "before", "now", "now / before"};
    for (size_t n = 0; n < sizeof heads / sizeof *heads; n++) text_table_add(t, "%s", heads[n]);
}

static void add_row(moves *v, const char *what, const char *before, const char *now, double ratio)
{
    if (!v->rows++) add_heads(&v->table);
    text_table_add(&v->table, "%s", v->cell);
    text_table_add(&v->table, "%s", what);
    text_table_add(&v->table, "%s", before);
    text_table_add(&v->table, "%s", now);
    if (isfinite(ratio))
        text_table_add(&v->table, "%.3f", ratio);
    else
        text_table_add(&v->table, "-");
}

/* limited  1: may be too slow */
static void add_seconds(moves *v, const char *what, const spread *before, const spread *now, double unit, int limited)
{
    spread a = {unit * before->median, unit * before->min, unit * before->max},
           b = {unit * now->median, unit * now->min, unit * now->max};
    char before_text[64], now_text[64];
    if (!outside(a.median, &b) || !outside(b.median, &a)) return;
    add_row(v, what, spread_text(before_text, &a), spread_text(now_text, &b), b.median / a.median);
    v->too_slow += limited && b.median > v->max_slower * a.median;
}

static void add_bytes(moves *v, const char *what, uint64_t before, uint64_t now, double share)
{
    char before_text[32], now_text[32];
    if (!differ((double)before, (double)now, share)) return;
    snprintf(before_text, sizeof before_text, "%llu B", (unsigned long long)before);
    snprintf(now_text, sizeof now_text, "%llu B", (unsigned long long)now);
    add_row(v, what, before_text, now_text, (double)now / (double)before);
}

static void add_count(moves *v, const char *what, uint64_t before, uint64_t now)
{
    char before_text[32], now_text[32];
    if (before == now) return;
    snprintf(before_text, sizeof before_text, "%llu", (unsigned long long)before);
    snprintf(now_text, sizeof now_text, "%llu", (unsigned long long)now);
    add_row(v, what, before_text, now_text, (double)now / (double)before);
}

static void add_share(moves *v, const char *what, double before, double now)
{
    char before_text[32], now_text[32];
    if (!differ(before, now, equal_share)) return;
    snprintf(before_text, sizeof before_text, "%.6g %%", 100 * before);
    snprintf(now_text, sizeof now_text, "%.6g %%", 100 * now);
    add_row(v, what, before_text, now_text, now / before);
}

/* Cells ---------------------------------------------------------------------------------------------------------------------- */

static void add_stages(moves *v, const bench_cell *before, const bench_cell *now)
{
    for (uint32_t n = 0; n < now->stage_count; n++)
        for (uint32_t i = 0; i < before->stage_count; i++) {
            const bench_stage *a = &before->stages[i], *b = &now->stages[n];
            char               what[64];
            if (strcmp(a->name, b->name)) continue;
            if (b->seconds.median < stage_share * now->wall_seconds.median &&
                a->seconds.median < stage_share * before->wall_seconds.median)
                continue;
            snprintf(what, sizeof what, "stage %s", b->name);
            add_seconds(v, what, &a->seconds, &b->seconds, 1, 0);
        }
}

static void add_error(moves *v, const bench_error *before, const bench_error *now)
{
    char points[32], what[96];
    choice_word(points, BENCH_POINTS_WORDS, (int)now->points);
    if (now->filter_px > 1) {
        snprintf(what, sizeof what, "RMSE %u x %u, %s", now->filter_px, now->filter_px, points);
        add_share(v, what, before->rmse, now->rmse);
        snprintf(what, sizeof what, "greatest error %u x %u, %s", now->filter_px, now->filter_px, points);
        add_share(v, what, before->max_error, now->max_error);
        return;
    }
    snprintf(what, sizeof what, "wrong, %s", points);
    add_share(v, what, before->wrong_share, now->wrong_share);
    snprintf(what, sizeof what, "leaks, %s", points);
    add_count(v, what, before->leaks, now->leaks);
    snprintf(what, sizeof what, "false shadows, %s", points);
    add_count(v, what, before->false_shadows, now->false_shadows);
    snprintf(what, sizeof what, "unexplained, %s", points);
    add_count(v, what, before->unexplained, now->unexplained);
}

static void add_errors(moves *v, const bench_cell *before, const bench_cell *now)
{
    for (uint32_t n = 0; n < now->error_count; n++)
        for (uint32_t i = 0; i < before->error_count; i++)
            if (now->errors[n].points == before->errors[i].points && now->errors[n].filter_px == before->errors[i].filter_px)
                add_error(v, &before->errors[i], &now->errors[n]);
}

static void add_lookups(moves *v, const bench_cell *before, const bench_cell *now)
{
    for (uint32_t n = 0; n < now->lookup_count; n++)
        for (uint32_t i = 0; i < before->lookup_count; i++) {
            const bench_lookup *a = &before->lookups[i], *b = &now->lookups[n];
            char                what[64] = "lookup";
            if (a->filter_px != b->filter_px) continue;
            if (b->filter_px > 1) snprintf(what, sizeof what, "lookup %u x %u", b->filter_px, b->filter_px);
            add_seconds(v, what, &a->nanoseconds, &b->nanoseconds, 1e-9, 1);
            if (b->filter_px == 1) add_seconds(v, "ray", &a->ray_nanoseconds, &b->ray_nanoseconds, 1e-9, 0);
        }
}

/* same_points  errors were measured at the same points */
static void add_cell(moves *v, const bench_cell *before, const bench_cell *now, int same_points)
{
    add_seconds(v, "bake", &before->wall_seconds, &now->wall_seconds, 1, 1);
    add_seconds(v, "maps to DAG", &before->maps_to_dag_seconds, &now->maps_to_dag_seconds, 1, 0);
    add_stages(v, before, now);
    add_bytes(v, "peak memory", before->peak_bytes, now->peak_bytes, memory_share);
    add_count(v, "triangles", before->triangles, now->triangles);
    add_count(v, "triangles of solids", before->solid_triangles, now->solid_triangles);
    add_count(v, "lights", before->lights, now->lights);
    add_count(v, "maps", before->maps, now->maps);
    add_bytes(v, "file", before->file_bytes, now->file_bytes, 0);
    add_bytes(v, "in memory", before->memory_bytes, now->memory_bytes, 0);
    add_count(v, "nodes", before->nodes, now->nodes);
    add_count(v, "masks", before->masks, now->masks);
    add_count(v, "inserted nodes", before->inserted_nodes, now->inserted_nodes);
    add_count(v, "inserted masks", before->inserted_masks, now->inserted_masks);
    if (same_points) add_errors(v, before, now);
    add_lookups(v, before, now);
}

static const bench_cell *find_cell(const bench_result *r, const char *key)
{
    for (size_t n = 0; n < r->cell_count; n++)
        if (!strcmp(r->cells[n].key, key)) return &r->cells[n];
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

static void print_text_difference(FILE *to, const char *what, const char *before, const char *now)
{
    if (strcmp(before, now)) print_line(to, "%s: %s, before: %s", what, now, before);
}

static void print_count_difference(FILE *to, const char *what, uint64_t before, uint64_t now)
{
    if (before != now) print_line(to, "%s: %llu, before: %llu", what, (unsigned long long)now, (unsigned long long)before);
}

/* Returns whether errors can be compared. */
static int print_differences(FILE *to, const bench_result *now, const bench_result *before)
{
    print_text_difference(to, "vxs", before->vxs, now->vxs);
    print_text_difference(to, "processor", before->machine.processor, now->machine.processor);
    print_count_difference(to, "cores", before->machine.cores, now->machine.cores);
    print_count_difference(to, "memory, bytes", before->machine.memory_bytes, now->machine.memory_bytes);
    print_text_difference(to, "system", before->machine.system, now->machine.system);
    print_text_difference(to, "OpenGL", before->machine.renderer, now->machine.renderer);
    print_count_difference(to, "runs", before->runs, now->runs);
    if (now->points == before->points) return 1;
    fprintf(to, "points: %u, before: %u: errors are not compared\n", now->points, before->points);
    return 0;
}

static void print_cells_only_in(FILE *to, const bench_result *one, const bench_result *other, const char *where)
{
    char name[256];
    for (size_t n = 0; n < one->cell_count; n++)
        if (!find_cell(other, one->cells[n].key))
            fprintf(to, "only %s: %s\n", where, bench_cell_name(name, sizeof name, one, &one->cells[n]));
}

vxs_result bench_against(FILE *to, const bench_result *now, const bench_result *before, const char *before_path, double max_slower,
                         size_t *too_slow, message *m)
{
    moves  v    = {.table = {.columns = 5}, .max_slower = max_slower};
    size_t both = 0;
    fprintf(to, "\n");
    print_line(to, "against %s of %s", before_path, before->started);
    int same_points = print_differences(to, now, before);
    for (size_t n = 0; n < now->cell_count; n++) {
        const bench_cell *earlier = find_cell(before, now->cells[n].key);
        char              name[256];
        if (!earlier) continue;
        both++;
        v.cell = bench_cell_name(name, sizeof name, now, &now->cells[n]);
        add_cell(&v, earlier, &now->cells[n], same_points);
    }
    if (!both)
        fprintf(to, "no cell is in both\n");
    else if (!v.rows)
        fprintf(to, "nothing moved in %zu cells\n", both);
    *too_slow = v.too_slow;
    if (!text_table_print(&v.table, to)) return fail(m, VXS_E_MEMORY, "out of memory for the table");
    print_cells_only_in(to, now, before, "now");
    print_cells_only_in(to, before, now, "before");
    return VXS_OK;
}
