/* Measurements in words; see bench_text.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/bench/bench_text.h"

#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/text.h"
#include "baker/files/json_file.h"
#include "baker/bench/text_table.h"

/* Options -------------------------------------------------------------------------------------------------------------------- */

/* The keys of the options that are not the same in all cells, but for the resolution, which always is said.
 * Returns the next one from `key` on (NULL: from the first), or NULL. A key that the first cell has not is not found. */
static const char *varying_option(const bench_result *r, const char *key)
{
    json_t *first = r->cell_count ? r->cells[0].options : NULL;
    void   *at    = key ? json_object_iter_next(first, json_object_iter_at(first, key)) : json_object_iter(first);
    for (; at; at = json_object_iter_next(first, at)) {
        const char *name = json_object_iter_key(at);
        for (size_t n = 1; n < r->cell_count && strcmp(name, "resolution_px"); n++)
            if (!json_equal(json_object_iter_value(at), json_object_get(r->cells[n].options, name))) return name;
    }
    return NULL;
}

static const char *option_text(char text[64], const bench_cell *cell, const char *name)
{
    const json_t *value = json_object_get(cell->options, name);
    char         *other =
        value && !json_is_string(value) ? json_dumps(value, JSON_COMPACT | JSON_ENCODE_ANY | JSON_REAL_PRECISION(9)) : NULL;
    snprintf(text, 64, "%s", other ? other : value && json_is_string(value) ? json_string_value(value) : "-");
    free(other);
    return text;
}

static void append(char *text, size_t size, const char *format, ...) __attribute__((format(printf, 3, 4)));
static void append(char *text, size_t size, const char *format, ...)
{
    size_t  length = strlen(text);
    va_list args;
    va_start(args, format);
    vsnprintf(text + length, size - length, format, args);
    va_end(args);
}

const char *bench_cell_name(char *text, size_t size, const bench_result *r, const bench_cell *cell)
{
    char value[64];
    snprintf(text, size, "%s, %s texels", cell->scene, option_text(value, cell, "resolution_px"));
    for (const char *name = NULL; (name = varying_option(r, name));)
        append(text, size, ", %s %s", name, option_text(value, cell, name));
    return one_line(text);
}

/* Figures -------------------------------------------------------------------------------------------------------------------- */

const char *spread_text(char text[64], const spread *s)
{
    static const struct {
        const char *name;
        double      seconds;
    } units[] = {{"s", 1}, {"ms", 1e-3}, {"us", 1e-6}, {"ns", 1e-9}};
    int unit  = 0;
    while (unit < 3 && s->median < (unit ? 1 : 10) * units[unit].seconds) unit++; /* 2126 ms, but 12.6 s */
    double scale  = 1 / units[unit].seconds;
    int    digits = scale * s->median < 10 ? 2 : scale * s->median < 100;
    snprintf(text, 64, "%.*f %s", digits, s->median * scale, units[unit].name);
    if (s->min < s->max) append(text, 64, " (%.*f to %.*f)", digits, s->min * scale, digits, s->max * scale);
    return text;
}

static spread seconds_of_nanoseconds(const spread *s)
{
    return (spread){1e-9 * s->median, 1e-9 * s->min, 1e-9 * s->max};
}

static void add_errors(text_table *t, const bench_cell *c, const bench_cell *first)
{
    for (uint32_t n = 0; n < first->error_count; n++) {
        const bench_error *e = &c->errors[n];
        text_table_add(t, "%.4f %%", 100 * (e->filter_px > 1 ? e->rmse : e->wrong_share));
    }
}

static void add_error_heads(text_table *t, const bench_cell *first)
{
    for (uint32_t n = 0; n < first->error_count; n++) {
        const bench_error *e = &first->errors[n];
        char               points[32];
        choice_word(points, BENCH_POINTS_WORDS, (int)e->points);
        if (e->filter_px > 1)
            text_table_add(t, "RMSE %u x %u, %s", e->filter_px, e->filter_px, points);
        else
            text_table_add(t, "wrong, %s", points);
    }
}

static void add_lookups(text_table *t, const bench_cell *c, const bench_cell *first)
{
    for (uint32_t n = 0; n < first->lookup_count; n++) {
        char   text[64];
        spread seconds = seconds_of_nanoseconds(&c->lookups[n].nanoseconds);
        text_table_add(t, "%s", spread_text(text, &seconds));
    }
    spread ray = seconds_of_nanoseconds(&c->lookups[0].ray_nanoseconds);
    char   text[64];
    if (first->lookup_count) text_table_add(t, "%s", spread_text(text, &ray));
}

static void add_lookup_heads(text_table *t, const bench_cell *first)
{
    for (uint32_t n = 0; n < first->lookup_count; n++) {
        uint32_t k = first->lookups[n].filter_px;
        if (k > 1)
            text_table_add(t, "lookup %u x %u", k, k);
        else
            text_table_add(t, "lookup");
    }
    if (first->lookup_count) text_table_add(t, "ray");
}

static size_t add_heads(text_table *t, const bench_result *r)
{
    size_t before = t->count;
    text_table_add(t, "scene");
    text_table_add(t, "texels");
    for (const char *name = NULL; (name = varying_option(r, name));) text_table_add(t, "%s", name);
    text_table_add(t, "bake");
    text_table_add(t, "maps to DAG");
    text_table_add(t, "peak memory");
    text_table_add(t, "file");
    text_table_add(t, "in memory");
    add_error_heads(t, &r->cells[0]);
    add_lookup_heads(t, &r->cells[0]);
    return t->count - before;
}

static void add_cell(text_table *t, const bench_result *r, const bench_cell *c)
{
    char text[64], size[32];
    text_table_add(t, "%s", c->scene);
    text_table_add(t, "%s", option_text(text, c, "resolution_px"));
    for (const char *name = NULL; (name = varying_option(r, name));) text_table_add(t, "%s", option_text(text, c, name));
    text_table_add(t, "%s", spread_text(text, &c->wall_seconds));
    text_table_add(t, "%s", spread_text(text, &c->maps_to_dag_seconds));
    text_table_add(t, "%s", size_text(size, c->peak_bytes));
    text_table_add(t, "%s", size_text(size, c->file_bytes));
    text_table_add(t, "%s", size_text(size, c->memory_bytes));
    add_errors(t, c, &r->cells[0]);
    add_lookups(t, c, &r->cells[0]);
}

vxs_result bench_print(FILE *to, const bench_result *r, message *m)
{
    const bench_machine *machine = &r->machine;
    char                 memory[32], name[256];
    text_table           t = {0};
    fprintf(to, "vxs %s on %s, %llu cores, %s, %s, OpenGL by %s\n", r->vxs, machine->processor, (unsigned long long)machine->cores,
            size_text(memory, machine->memory_bytes), machine->system, machine->renderer);
    fprintf(to, "medians of %u runs (least to greatest)", r->runs);
    if (r->points) fprintf(to, "; errors at %u points of each kind; lookups on one thread", r->points);
    fprintf(to, "\n\n");
    t.columns = add_heads(&t, r);
    for (size_t n = 0; n < r->cell_count; n++) add_cell(&t, r, &r->cells[n]);
    if (!text_table_print(&t, to)) return fail(m, VXS_E_MEMORY, "out of memory for the table");
    for (size_t n = 0; n < r->cell_count; n++)
        for (uint32_t i = 0; i < r->cells[n].error_count; i++)
            if (r->cells[n].errors[i].unexplained)
                fprintf(to, "%s: %llu wrong answers that no surface or shadow boundary explains: vxs compare says where\n",
                        bench_cell_name(name, sizeof name, r, &r->cells[n]), (unsigned long long)r->cells[n].errors[i].unexplained);
    return VXS_OK;
}
