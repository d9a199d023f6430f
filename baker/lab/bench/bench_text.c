/* Measurements as text; see bench_text.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/bench/bench_text.h"

#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/text.h"
#include "baker/command/options/options.h"
#include "baker/files/json_file.h"

/* Tables ----------------------------------------------------------------------------------------------------------------------- */

void table_add(json_t *table, const char *format, ...)
{
    char   *text = NULL;
    va_list args;
    va_start(args, format);
    if (vasprintf(&text, format, args) < 0) text = NULL;
    va_end(args);
    if (json_array_append_new(table, text ? json_text(one_line(text)) : json_null()))
        json_array_append_new(table, json_null()); /* out of memory: table_print detects the null */
    free(text);
}

vxs_result table_print(json_t *table, size_t columns, FILE *to, run_context *m)
{
    size_t  n, widths[64] = {0};
    json_t *cell;
    int     whole = !json_memory_missing() && columns <= sizeof widths / sizeof *widths;
    json_array_foreach(table, n, cell)
    {
        size_t *width = &widths[n % columns];
        if (*width < json_string_length(cell)) *width = json_string_length(cell);
        whole &= json_is_string(cell);
    }
    for (n = 0; whole && (cell = json_array_get(table, n)); n++) {
        size_t column = n % columns;
        int    width  = (int)widths[column];
        fprintf(to, "%s%*s%s", column ? "  " : "", column ? width : -width, json_string_value(cell),
                column + 1 == columns ? "\n" : "");
    }
    json_decref(table);
    return whole ? VXS_OK : fail(m, VXS_E_MEMORY, "out of memory for the table");
}

/* Options ---------------------------------------------------------------------------------------------------------------------- */

/* The options that differ between cells, and always the resolution: as keys of an object, which the caller releases. */
static json_t *varying_options(const json_t *result)
{
    const json_t *cells   = json_at(result, "cells"), *cell;
    json_t       *varying = json_object(), *value;
    const char   *name;
    void         *next;
    size_t        n;
    json_array_foreach(cells, n, cell) json_object_update_missing(varying, json_at(cell, "options"));
    json_object_del(varying, "resolution_px");
    json_object_foreach_safe(varying, next, name, value)
    {
        size_t alike = 0;
        json_array_foreach(cells, n, cell)
        {
            /* if the cell's coding does not have the option, this is no difference */
            int is_blocks = !strcmp(text_at(cell, "options/coding"), "blocks");
            alike += choice_index(is_blocks ? "rule|reuse|compress|stop" : "pack", name) >= 0 ||
                     json_equal(value, json_object_get(json_at(cell, "options"), name));
        }
        if (alike == json_array_size(cells)) json_object_del(varying, name);
    }
    return varying;
}

static const char *option_text(char text[64], const json_t *cell, const char *name)
{
    const json_t *value = json_object_get(json_at(cell, "options"), name);
    char         *other =
        value && !json_is_string(value) ? json_dumps(value, JSON_COMPACT | JSON_ENCODE_ANY | JSON_REAL_PRECISION(9)) : NULL;
    /* the value when the cell does not have the option */
    const char *missing = !strcmp(name, "skinned") ? "exclude" : !strcmp(name, "blend") ? "mask" : "-";
    snprintf(text, 64, "%s", other ? other : value && json_is_string(value) ? json_string_value(value) : missing);
    free(other);
    return text;
}

const char *bench_cell_name(char *text, size_t size, const json_t *result, const json_t *cell)
{
    char          value[64];
    const char   *name;
    const json_t *any;
    json_t       *varying = varying_options(result);
    size_t end = (size_t)snprintf(text, size, "%s, %s texels", text_at(cell, "scene"), option_text(value, cell, "resolution_px"));
    json_object_foreach(varying, name, any) if (end < size) end +=
        (size_t)snprintf(text + end, size - end, ", %s %s", name, option_text(value, cell, name));
    json_decref(varying);
    return one_line(text);
}

/* Figures ---------------------------------------------------------------------------------------------------------------------- */

const char *spread_text(char text[64], spread s)
{
    static const struct {
        const char *name;
        double      seconds;
    } units[] = {{"s", 1}, {"ms", 1e-3}, {"us", 1e-6}, {"ns", 1e-9}};
    int unit  = 0;
    while (unit < 3 && s.median < (unit ? 1 : 10) * units[unit].seconds) unit++; /* 2126 ms, but 12.6 s */
    double scale  = 1 / units[unit].seconds;
    int    digits = scale * s.median < 10 ? 2 : scale * s.median < 100;
    int    end    = snprintf(text, 64, "%.*f %s", digits, s.median * scale, units[unit].name);
    if (s.min < s.max && end < 64)
        snprintf(text + end, 64 - (size_t)end, " (%.*f to %.*f)", digits, s.min * scale, digits, s.max * scale);
    return text;
}

typedef struct figure_row {
    const char *of, *name, *path; /* of: path in the cell, to an object or a list of objects; name: label; path: within the
                                     object */
    figure_kind kind;
    unsigned    flags;
} figure_row;

static const figure_row rows[] = {
    {"bake", "bake", "wall_seconds", FIGURE_SECONDS, FIGURE_COLUMN | FIGURE_LIMITED},
    {"bake", "maps to words", "maps_to_words_seconds", FIGURE_SECONDS, FIGURE_COLUMN},
    {"bake/stages", "stage", "seconds", FIGURE_SECONDS, FIGURE_STAGE},
    {"bake", "peak memory", "peak_bytes", FIGURE_PEAK_BYTES, FIGURE_COLUMN},
    {"", "triangles", "triangles", FIGURE_COUNT, 0},
    {"", "triangles of solids", "solid_triangles", FIGURE_COUNT, 0},
    {"", "lights", "lights", FIGURE_COUNT, 0},
    {"", "maps", "maps", FIGURE_COUNT, 0},
    {"size", "file", "file_bytes", FIGURE_BYTES, FIGURE_COLUMN},
    {"size", "in memory", "memory_bytes", FIGURE_BYTES, FIGURE_COLUMN},
    {"size", "nodes", "nodes", FIGURE_COUNT, 0},
    {"size", "masks", "masks", FIGURE_COUNT, 0},
    {"size", "inserted nodes", "inserted_nodes", FIGURE_COUNT, 0},
    {"size", "inserted masks", "inserted_masks", FIGURE_COUNT, 0},
    {"size/palette_blocks", "pages", "pages", FIGURE_COUNT, 0},
    {"size/palette_blocks", "nodes", "nodes", FIGURE_COUNT, 0},
    {"size/palette_blocks", "blocks", "blocks", FIGURE_COUNT, 0},
    {"size/palette_blocks", "tiles", "tiles", FIGURE_COUNT, 0},
    {"size/palette_blocks", "tiles with private palettes", "private_tiles", FIGURE_COUNT, 0},
    {"size/palette_blocks", "patterns", "patterns", FIGURE_COUNT, 0},
    {"errors", "wrong", "wrong_share", FIGURE_SHARE, FIGURE_COLUMN | FIGURE_ERROR},
    {"errors", "leaks", "leaks", FIGURE_COUNT, FIGURE_ERROR},
    {"errors", "false shadows", "false_shadows", FIGURE_COUNT, FIGURE_ERROR},
    {"errors", "unexplained", "unexplained", FIGURE_COUNT, FIGURE_ERROR},
    {"errors", "RMSE", "rmse", FIGURE_SHARE, FIGURE_COLUMN | FIGURE_ERROR},
    {"errors", "greatest error", "max_error", FIGURE_SHARE, FIGURE_ERROR},
    {"lookups", "lookup", "nanoseconds", FIGURE_SECONDS, FIGURE_COLUMN | FIGURE_LIMITED},
    {"lookups", "ray", "ray_nanoseconds", FIGURE_SECONDS, FIGURE_COLUMN},
};

static void add_figure(bench_figure *figures, size_t *count, const figure_row *row, const json_t *item)
{
    const json_t *value = json_at(item, row->path);
    double        one   = json_number_value(value);
    bench_figure *f     = &figures[*count];
    if (!value || *count == BENCH_FIGURES_MAX) return;
    *f = (bench_figure){"", row->kind, row->flags, {one, one, one}};
    if (row->kind == FIGURE_SECONDS) f->value = spread_at(value, "", strcmp(row->of, "lookups") ? 1 : 1e-9);

    /* its name: "stage merge", "lookup 3 x 3", "RMSE 9 x 9 smooth, surface" */
    char        text[32] = "";
    vxs_filter  filter   = {(int32_t)count_at(item, "filter_px"), json_is_true(json_at(item, "smooth"))};
    const char *stage = row->flags & FIGURE_STAGE ? text_at(item, "name") : "", *points = text_at(item, "points");
    if (filter.width_px > 1 || filter.is_smooth) filter_text(text, filter);
    snprintf(f->name, 96, "%s%s%s%s%s%s%s", row->name, *stage ? " " : "", stage, *text ? " " : "", text, *points ? ", " : "",
             points);

    ++*count;
}

size_t bench_figures(const json_t *cell, bench_figure *figures)
{
    size_t count = 0, n;
    for (const figure_row *row = rows; row < rows + sizeof rows / sizeof *rows; row++) {
        const json_t *of = json_at(cell, row->of), *item;
        if (json_is_object(of)) add_figure(figures, &count, row, of);
        json_array_foreach(of, n, item) add_figure(figures, &count, row, item);
    }
    return count;
}

/* is_head: add the labels of the columns, in place of the cell's values. */
static void add_row(json_t *t, const json_t *result, const json_t *cell, int is_head)
{
    char          text[64];
    const char   *name;
    const json_t *any;
    json_t       *varying = varying_options(result);
    table_add(t, "%s", is_head ? "scene" : text_at(cell, "scene"));
    table_add(t, "%s", is_head ? "texels" : option_text(text, cell, "resolution_px"));
    json_object_foreach(varying, name, any) table_add(t, "%s", is_head ? name : option_text(text, cell, name));
    json_decref(varying);

    /* Add the figures of a cell to the table: their labels (is_head), or their values. */
    bench_figure figures[BENCH_FIGURES_MAX];
    size_t       count = bench_figures(cell, figures);
    char         value[64];
    for (const bench_figure *f = figures; f < figures + count; f++) {
        if (!(f->flags & FIGURE_COLUMN)) continue;
        if (is_head)
            table_add(t, "%s", f->name);
        else if (f->kind == FIGURE_SECONDS)
            table_add(t, "%s", spread_text(value, f->value));
        else if (f->kind == FIGURE_SHARE)
            table_add(t, "%.4f %%", 100 * f->value.median);
        else
            table_add(t, "%s", size_text(value, (uint64_t)f->value.median));
    }
}

vxs_result bench_print(FILE *to, const json_t *result, run_context *m)
{
    const json_t *machine = json_at(result, "machine"), *cells = json_at(result, "cells"), *cell, *error;
    char          memory[32], name[256];
    json_t       *table = json_array();
    size_t        n, i;
    fprintf(to, "vxs %s on %s, %llu cores, %s, %s, OpenGL by %s\n", text_at(result, "vxs"), text_at(machine, "processor"),
            (unsigned long long)count_at(machine, "cores"), size_text(memory, count_at(machine, "memory_bytes")),
            text_at(machine, "system"), text_at(machine, "renderer"));
    fprintf(to, "medians of %u runs (least to greatest)", (unsigned)count_at(result, "runs"));
    if (count_at(result, "points"))
        fprintf(to, "; errors at %u points of each kind; lookups on one thread", (unsigned)count_at(result, "points"));
    fprintf(to, "\n\n");
    add_row(table, result, json_array_get(cells, 0), 1);
    size_t columns = json_array_size(table);
    json_array_foreach(cells, n, cell) add_row(table, result, cell, 0);
    vxs_result r = table_print(table, columns, to, m);
    json_array_foreach(cells, n, cell) json_array_foreach(json_at(cell, "errors"), i, error)
    {
        if (r == VXS_OK && count_at(error, "unexplained"))
            fprintf(to, "%s: %llu wrong answers that no surface or shadow boundary explains: vxs compare says where\n",
                    bench_cell_name(name, sizeof name, result, cell), (unsigned long long)count_at(error, "unexplained"));
    }
    return r;
}
