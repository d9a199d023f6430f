/* Measurements in words; see bench_text.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/bench/bench_text.h"

#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/text.h"
#include "baker/files/json_file.h"

/* Tables --------------------------------------------------------------------------------------------------------------------- */

void table_add(json_t *table, const char *format, ...)
{
    char   *text = NULL;
    va_list args;
    va_start(args, format);
    if (vasprintf(&text, format, args) < 0) text = NULL;
    va_end(args);
    if (json_array_append_new(table, text ? json_text(one_line(text)) : json_null()))
        json_array_append_new(table, json_null()); /* out of memory: table_print sees what is no text */
    free(text);
}

vxs_result table_print(json_t *table, size_t columns, FILE *to, message *m)
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

/* Options -------------------------------------------------------------------------------------------------------------------- */

/* The keys of the options that are not the same in all cells, but for the resolution, which always is said.
 * Returns the next one from `key` on (NULL: from the first), or NULL. A key that the first cell has not is not found. */
static const char *varying_option(const json_t *result, const char *key)
{
    const json_t *cells = json_at(result, "cells"), *cell;
    json_t       *first = json_at(json_array_get(cells, 0), "options");
    void         *at    = key ? json_object_iter_next(first, json_object_iter_at(first, key)) : json_object_iter(first);
    size_t        n;
    for (; at; at = json_object_iter_next(first, at)) {
        const char *name = json_object_iter_key(at);
        if (!strcmp(name, "resolution_px")) continue;
        json_array_foreach(cells, n, cell)
        {
            if (!json_equal(json_object_iter_value(at), json_object_get(json_at(cell, "options"), name))) return name;
        }
    }
    return NULL;
}

static const char *option_text(char text[64], const json_t *cell, const char *name)
{
    const json_t *value = json_object_get(json_at(cell, "options"), name);
    char         *other =
        value && !json_is_string(value) ? json_dumps(value, JSON_COMPACT | JSON_ENCODE_ANY | JSON_REAL_PRECISION(9)) : NULL;
    snprintf(text, 64, "%s", other ? other : value && json_is_string(value) ? json_string_value(value) : "-");
    free(other);
    return text;
}

const char *bench_cell_name(char *text, size_t size, const json_t *result, const json_t *cell)
{
    char   value[64];
    size_t end = (size_t)snprintf(text, size, "%s, %s texels", text_at(cell, "scene"), option_text(value, cell, "resolution_px"));
    for (const char *name = NULL; end < size && (name = varying_option(result, name));)
        end += (size_t)snprintf(text + end, size - end, ", %s %s", name, option_text(value, cell, name));
    return one_line(text);
}

/* Figures -------------------------------------------------------------------------------------------------------------------- */

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

const char *figure_text(char text[96], const char *name, uint64_t filter_px, const char *points)
{
    char filter[32] = "";
    if (filter_px > 1) snprintf(filter, sizeof filter, " %u x %u", (unsigned)filter_px, (unsigned)filter_px);
    snprintf(text, 96, "%s%s%s%s", name, filter, points && *points ? ", " : "", points ? points : "");
    return text;
}

static void add_heads(json_t *t, const json_t *result, const json_t *first)
{
    static const char *const before[] = {"scene", "texels"}, *const after[] = {"bake", "maps to DAG", "peak memory", "file",
                                                                               "in memory"};
    char          text[96];
    const json_t *item;
    size_t        n;
    for (n = 0; n < sizeof before / sizeof *before; n++) table_add(t, "%s", before[n]);
    for (const char *name = NULL; (name = varying_option(result, name));) table_add(t, "%s", name);
    for (n = 0; n < sizeof after / sizeof *after; n++) table_add(t, "%s", after[n]);
    json_array_foreach(json_at(first, "errors"), n, item)
    {
        uint64_t k = count_at(item, "filter_px");
        table_add(t, "%s", figure_text(text, k > 1 ? "RMSE" : "wrong", k, text_at(item, "points")));
    }
    json_array_foreach(json_at(first, "lookups"), n, item)
        table_add(t, "%s", figure_text(text, "lookup", count_at(item, "filter_px"), NULL));
    if (n) table_add(t, "ray");
}

static void add_cell(json_t *t, const json_t *result, const json_t *cell)
{
    static const char *const times[] = {"bake/wall_seconds", "bake/maps_to_dag_seconds"}, *const sizes[] = {"bake/peak_bytes",
                                                                                                            "size/file_bytes",
                                                                                                            "size/memory_bytes"};
    char          text[64];
    const json_t *item, *lookups = json_at(cell, "lookups");
    size_t        n;
    table_add(t, "%s", text_at(cell, "scene"));
    table_add(t, "%s", option_text(text, cell, "resolution_px"));
    for (const char *name = NULL; (name = varying_option(result, name));) table_add(t, "%s", option_text(text, cell, name));
    for (n = 0; n < sizeof times / sizeof *times; n++) table_add(t, "%s", spread_text(text, spread_at(cell, times[n], 1)));
    for (n = 0; n < sizeof sizes / sizeof *sizes; n++) table_add(t, "%s", size_text(text, count_at(cell, sizes[n])));
    json_array_foreach(json_at(cell, "errors"), n, item)
        table_add(t, "%.4f %%", 100 * number_at(item, count_at(item, "filter_px") > 1 ? "rmse" : "wrong_share"));
    json_array_foreach(lookups, n, item) table_add(t, "%s", spread_text(text, spread_at(item, "nanoseconds", 1e-9)));
    if (n) table_add(t, "%s", spread_text(text, spread_at(json_array_get(lookups, 0), "ray_nanoseconds", 1e-9)));
}

vxs_result bench_print(FILE *to, const json_t *result, message *m)
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
    add_heads(table, result, json_array_get(cells, 0));
    size_t columns = json_array_size(table);
    json_array_foreach(cells, n, cell) add_cell(table, result, cell);
    vxs_result r = table_print(table, columns, to, m);
    json_array_foreach(cells, n, cell) json_array_foreach(json_at(cell, "errors"), i, error)
    {
        if (r == VXS_OK && count_at(error, "unexplained"))
            fprintf(to, "%s: %llu wrong answers that no surface or shadow boundary explains: vxs compare says where\n",
                    bench_cell_name(name, sizeof name, result, cell), (unsigned long long)count_at(error, "unexplained"));
    }
    return r;
}
