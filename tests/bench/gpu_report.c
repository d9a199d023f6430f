/* A table of what was measured, and the same as JSON; see gpu_bench.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "tests/bench/gpu_bench.h"

#include <stdio.h>
#include <string.h>

#include "baker/base/version.h"
#include "baker/files/json_file.h"
#include "baker/lab/bench/bench_text.h"
#include "baker/lab/bench/machine.h"

/* The time that a row is divided by: of the first row of the same group, view and resolution, which is a rival. */
static double rival_ms(const json_t *rows, const json_t *row)
{
    size_t  n;
    json_t *other;
    json_array_foreach(rows, n, other)
    {
        const char *name = json_string_value(json_object_get(other, "name"));
        if (!json_equal(json_object_get(other, "group"), json_object_get(row, "group")) ||
            !json_equal(json_object_get(other, "view"), json_object_get(row, "view")) ||
            !json_equal(json_object_get(other, "resolution_px"), json_object_get(row, "resolution_px")))
            continue;
        if (strstr(name, "(rival)")) return json_real_value(json_object_get(json_object_get(other, "ms"), "median"));
    }
    return 0;
}

static void add_cell(json_t *table, const json_t *value, const char *format, double scale)
{
    if (value)
        table_add(table, format, scale * json_number_value(value));
    else
        table_add(table, "%s", "");
}

/* Rows that are compared follow each other, in the order of the first of them. */
static void sort_rows(gpu_bench *b)
{
    static const char *const keys[] = {"group", "view", "resolution_px"};
    json_t                  *sorted = json_array(), *first, *row;
    size_t                   n;
    while ((first = json_incref(json_array_get(b->rows, 0)))) {
        json_t *others = json_array();
        json_array_foreach(b->rows, n, row)
        {
            int same = 1;
            for (int k = 0; k < 3; k++) same &= json_equal(json_object_get(first, keys[k]), json_object_get(row, keys[k]));
            json_array_append(same ? sorted : others, row);
        }
        json_decref(b->rows);
        json_decref(first);
        b->rows = others;
    }
    json_decref(b->rows);
    b->rows = sorted;
}

static vxs_result print_table(const gpu_bench *b, run_context *m)
{
    static const char *const head[] = {"measured",     "view", "texels a side", "by",    "ms",
                                       "of the rival", "MiB",  "pixels differ", "error", "lights listed"};
    enum { COLUMNS = sizeof head / sizeof *head };
    json_t *table = json_array(), *row;
    size_t  n;
    for (n = 0; n < COLUMNS; n++) table_add(table, "%s", head[n]);
    json_array_foreach(b->rows, n, row)
    {
        double rival = rival_ms(b->rows, row), ms = json_real_value(json_object_get(json_object_get(row, "ms"), "median"));
        table_add(table, "%s", json_string_value(json_object_get(row, "group")));
        table_add(table, "%s", json_string_value(json_object_get(row, "view")));
        add_cell(table, json_object_get(row, "resolution_px"), "%.0f", 1);
        table_add(table, "%s", json_string_value(json_object_get(row, "name")));
        table_add(table, ms < 10 ? "%.4f" : "%.2f", ms);
        if (rival > 0) {
            table_add(table, ms < 0.1 * rival ? "%.4f" : "%.2f", ms / rival);
            json_object_set_new(row, "of_rival", json_real(ms / rival));
        } else
            table_add(table, "%s", "");
        add_cell(table, json_object_get(row, "bytes"), "%.2f", 1.0 / (1 << 20));
        add_cell(table, json_object_get(row, "pixels_differ"), "%.0f", 1);
        add_cell(table, json_object_get(row, "relative_rms"), "%.4f", 1);
        add_cell(table, json_object_get(row, "lights_listed"), "%.2f", 1);
    }
    return table_print(table, COLUMNS, stdout, m);
}

vxs_result gpu_report(gpu_bench *b, run_context *m)
{
    bench_machine machine = {0};
    vxs_result    r       = machine_describe(&machine) ? VXS_OK : fail(m, VXS_E_MEMORY, "out of memory for the report");
    const char   *version = (const char *)b->gl->GetString(GL_VERSION);
    size_t        n;
    json_t       *row;
    if (r == VXS_OK)
        printf("%s, OpenGL %s; %s; %s; %u x %u, %s shaders; medians of at most %u frames, times by %s\n\n", b->gl->names.renderer,
               version, machine.processor, b->scene_path, b->width_px, b->height_px, b->is_fragment ? "fragment" : "compute",
               b->runs, b->clock == GPU_CLOCK_TIMER ? "timer queries" : "the clock on the wall");
    sort_rows(b);
    if (r == VXS_OK) r = print_table(b, m);
    json_array_foreach(b->rows, n, row) m->wrong |= json_integer_value(json_object_get(row, "pixels_differ")) > 0;
    json_t *o = json_object();
    json_set(&o, "vxs", json_text(VXS_VERSION));
    json_set(&o, "renderer", json_text(b->gl->names.renderer));
    json_set(&o, "opengl", json_text(version));
    json_set(&o, "processor", json_text(machine.processor ? machine.processor : ""));
    json_set(&o, "scene", json_text(b->scene_path));
    json_set(&o, "width_px", json_integer((json_int_t)b->width_px));
    json_set(&o, "height_px", json_integer((json_int_t)b->height_px));
    json_set(&o, "shader", json_text(b->is_fragment ? "fragment" : "compute"));
    json_set(&o, "clock", json_text(b->clock == GPU_CLOCK_TIMER ? "timer" : "wall"));
    json_set(&o, "warm_ms", json_integer((json_int_t)b->warm_ms));
    json_set(&o, "rows", json_incref(b->rows));
    if (r == VXS_OK && b->json_path)
        r = json_write(b->json_path, o, m);
    else
        json_decref(o);
    machine_free(&machine);
    return r;
}
