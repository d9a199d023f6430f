/* A cell of a measurement; see bench_cell.h.
 *
 * Reports are read as they are: they were written a moment ago by this very program.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/bench/bench_cell.h"

#include <math.h>
#include <string.h>

#include "baker/files/json_file.h"

json_t *bench_cell_new(const char *scene_path, json_t *options)
{
    const char *slash = strrchr(scene_path, '/');
    return json_pack("{s:o, s:n, s:n, s:n, s:n, s:i, s:o, s:{s:[], s:[], s:[], s:[], s:i}, s:n, s:[], s:[]}", "scene",
                     json_text(slash ? slash + 1 : scene_path), "triangles", "solid_triangles", "light", "lights", "maps", 0,
                     "options", options, "bake", "wall_seconds", "total_seconds", "maps_to_dag_seconds", "stages", "peak_bytes", 0,
                     "size", "errors", "lookups");
}

static void set_count(json_t *object, const char *name, uint64_t count)
{
    json_object_set_new(object, name, json_integer((json_int_t)count));
}

static void add_count(json_t *object, const char *name, uint64_t count)
{
    set_count(object, name, count_at(object, name) + count);
}

static void add_number(json_t *object, const char *name, double number)
{
    json_object_set_new(object, name, json_real(number_at(object, name) + number));
}

static void keep_most_bytes(json_t *object, uint64_t peak_bytes)
{
    if (peak_bytes > count_at(object, "peak_bytes")) set_count(object, "peak_bytes", peak_bytes);
}

static void add_sample(json_t *object, const char *name, double value)
{
    json_array_append_new(json_object_get(object, name), json_real(value));
}

/* A bake ---------------------------------------------------------------------------------------------------------------------- */

static int is_from_maps_to_dag(const char *stage)
{
    static const char *const names[] = {"pyramid", "masks", "insert", "compress", "merge"};
    for (size_t n = 0; n < sizeof names / sizeof *names; n++)
        if (!strcmp(names[n], stage)) return 1;
    return 0;
}

static void add_stages(json_t *bake, const json_t *report)
{
    json_t *stage, *sums = json_object_get(bake, "stages");
    double  maps_to_dag = 0;
    size_t  n;
    json_array_foreach(json_object_get(report, "stages"), n, stage)
    {
        const char *name    = text_at(stage, "name");
        double      seconds = number_at(stage, "seconds");
        if (n == json_array_size(sums))
            json_array_append_new(sums, json_pack("{s:s, s:[], s:i}", "name", name, "seconds", "peak_bytes", 0));
        add_sample(json_array_get(sums, n), "seconds", seconds);
        keep_most_bytes(json_array_get(sums, n), count_at(stage, "peak_bytes"));
        if (is_from_maps_to_dag(name)) maps_to_dag += seconds;
    }
    add_sample(bake, "maps_to_dag_seconds", maps_to_dag);
}

/* The level of that side; levels stand in the order of their sides, the root first, masks (0) last. */
static json_t *level_of(json_t *levels, uint64_t side_voxels)
{
    size_t at = 0;
    while (at < json_array_size(levels) && count_at(json_array_get(levels, at), "side_voxels") > side_voxels) at++;
    if (at == json_array_size(levels) || count_at(json_array_get(levels, at), "side_voxels") != side_voxels)
        json_array_insert_new(levels, at, json_pack("{s:I}", "side_voxels", (json_int_t)side_voxels));
    return json_array_get(levels, at);
}

static void add_light(json_t *size, const json_t *light)
{
    static const char *const figures[] = {"count", "memory_bytes", "stored_bytes"};
    json_t                  *level;
    size_t                   n;
    add_count(size, "memory_bytes", count_at(light, "size/memory_bytes"));
    add_count(size, "inserted_nodes", count_at(light, "inserted_nodes"));
    add_count(size, "inserted_masks", count_at(light, "inserted_masks"));
    json_array_foreach(json_object_get(light, "levels"), n, level)
    {
        const char *kind = text_at(level, "kind"); /* "nodes" or "masks" */
        json_t     *sum  = level_of(json_object_get(size, "levels"), strcmp(kind, "masks") ? count_at(level, "side_voxels") : 0);
        for (size_t i = 0; i < sizeof figures / sizeof *figures; i++) add_count(sum, figures[i], count_at(level, figures[i]));
        add_count(size, kind, count_at(level, "count"));
    }
}

/* What is the same in all runs. */
static void set_sizes(json_t *cell, const json_t *report)
{
    json_t *light, *lights = json_object_get(report, "lights");
    size_t  n;
    json_t *size = json_pack("{s:O, s:i, s:i, s:i, s:i, s:i, s:[]}", "file_bytes", json_object_get(report, "file_bytes"),
                             "memory_bytes", 0, "nodes", 0, "masks", 0, "inserted_nodes", 0, "inserted_masks", 0, "levels");
    set_count(cell, "triangles", count_at(report, "casters/triangles"));
    set_count(cell, "solid_triangles", count_at(report, "casters/solids/triangles"));
    set_count(cell, "lights", json_array_size(lights));
    set_count(cell, "maps", 0);
    json_object_set(cell, "light", json_object_get(json_array_get(lights, 0), "name"));
    json_object_set_new(cell, "size", size);
    json_array_foreach(lights, n, light)
    {
        add_count(cell, "maps", count_at(light, "maps"));
        add_light(size, light);
    }
}

vxs_result bench_cell_add_bake(json_t *cell, json_t *machine, const char *path, double wall_seconds, message *m)
{
    json_t    *report, *bake = json_object_get(cell, "bake");
    vxs_result r = json_read(&report, path, m);
    if (r != VXS_OK) return r;
    json_object_set(machine, "renderer", json_object_get(report, "renderer"));
    set_sizes(cell, report);
    add_stages(bake, report);
    add_sample(bake, "wall_seconds", wall_seconds);
    add_sample(bake, "total_seconds", number_at(report, "total_seconds"));
    keep_most_bytes(bake, count_at(report, "peak_bytes"));
    json_decref(report);
    return VXS_OK;
}

/* A comparison ---------------------------------------------------------------------------------------------------------------- */

enum { POINT_KINDS = 2 };
static const char *const point_kinds[POINT_KINDS] = {"random", "surface"};

/* Add what a light's lookups through a filter, or its single taps, were off by: to errors n and n + 1. */
static void add_errors(json_t *errors, size_t n, uint64_t filter_px, const json_t *found)
{
    static const char *const counts[] = {"leaks", "false_shadows", "unexplained"};
    for (int kind = 0; kind < POINT_KINDS; kind++) {
        const json_t *points  = json_object_get(found, point_kinds[kind]);
        uint64_t      checked = count_at(points, filter_px > 1 ? "points" : "checked");
        double        rmse = number_at(points, "rmse"), max_error = number_at(points, "max_error");
        if (n + kind == json_array_size(errors))
            json_array_append_new(errors, json_pack("{s:s, s:I, s:i}", "points", point_kinds[kind], "filter_px",
                                                    (json_int_t)filter_px, "checked", 0));
        json_t *error = json_array_get(errors, n + kind);
        add_count(error, "checked", checked);
        if (filter_px > 1) {
            add_number(error, "rmse", rmse * rmse * (double)checked); /* the root of the mean follows */
            json_object_set_new(error, "max_error", json_real(fmax(max_error, number_at(error, "max_error"))));
            continue;
        }
        add_number(error, "wrong_share",
                   (double)(count_at(points, "leaks") + count_at(points, "false_shadows"))); /* a share follows */
        for (size_t i = 0; i < sizeof counts / sizeof *counts; i++) add_count(error, counts[i], count_at(points, counts[i]));
    }
}

/* Sums become means. */
static void finish_error(json_t *error)
{
    double checked = fmax(1, number_at(error, "checked"));
    if (count_at(error, "filter_px") > 1)
        json_object_set_new(error, "rmse", json_real(sqrt(number_at(error, "rmse") / checked)));
    else
        json_object_set_new(error, "wrong_share", json_real(number_at(error, "wrong_share") / checked));
}

/* Nanoseconds, the mean over lights, each counted as often as points were looked up in it. filter: of each light's, or -1: single taps. */
static double mean_ns(const json_t *lights, int filter, const char *figure)
{
    const json_t *light;
    size_t        n;
    double        sum = 0, weight = 0;
    json_array_foreach(lights, n, light)
    {
        const json_t *of = filter < 0 ? json_object_get(light, "time") : json_array_get(json_object_get(light, "filters"), filter);
        double        points = number_at(light, "time/points");
        sum += points * number_at(of, figure);
        weight += points;
    }
    return weight > 0 ? sum / weight : 0;
}

static void add_lookup(json_t *lookups, size_t n, uint64_t filter_px, const json_t *lights)
{
    if (n == json_array_size(lookups))
        json_array_append_new(lookups, n ? json_pack("{s:I, s:[]}", "filter_px", (json_int_t)filter_px, "nanoseconds")
                                         : json_pack("{s:i, s:[], s:[]}", "filter_px", 1, "nanoseconds", "ray_nanoseconds"));
    add_sample(json_array_get(lookups, n), "nanoseconds", mean_ns(lights, (int)n - 1, "lookup_ns"));
    if (!n) add_sample(json_array_get(lookups, n), "ray_nanoseconds", mean_ns(lights, -1, "ray_ns"));
}

vxs_result bench_cell_add_compare(json_t *cell, const char *path, message *m)
{
    json_t *report, *light, *filter, *error, *errors = json_object_get(cell, "errors"), *lookups = json_object_get(cell, "lookups");
    size_t  n, i;
    vxs_result r = json_read(&report, path, m);
    if (r != VXS_OK) return r;
    const json_t *lights = json_object_get(json_array_get(json_object_get(report, "assets"), 0), "lights");

    json_array_clear(errors); /* they are the same in all runs */
    json_array_foreach(lights, n, light)
    {
        add_errors(errors, 0, 1, light);
        json_array_foreach(json_object_get(light, "filters"), i, filter)
            add_errors(errors, POINT_KINDS * (i + 1), count_at(filter, "filter_px"), filter);
    }
    json_array_foreach(errors, n, error) finish_error(error);

    add_lookup(lookups, 0, 1, lights);
    json_array_foreach(json_object_get(json_array_get(lights, 0), "filters"), i, filter)
        add_lookup(lookups, i + 1, count_at(filter, "filter_px"), lights);
    json_decref(report);
    return VXS_OK;
}

/* Samples --------------------------------------------------------------------------------------------------------------------- */

static json_t *spread_json(const json_t *samples)
{
    double values[BENCH_RUNS_MAX];
    size_t count = json_array_size(samples);
    for (size_t n = 0; n < count; n++) values[n] = json_real_value(json_array_get(samples, n));
    spread s = spread_of(values, (uint32_t)count);
    return json_pack("{s:f, s:f, s:f}", "median", s.median, "min", s.min, "max", s.max);
}

static void take_spreads(json_t *value)
{
    const char *key;
    json_t     *part;
    size_t      n;
    json_array_foreach(value, n, part) take_spreads(part);
    json_object_foreach(value, key, part)
    {
        if (json_is_real(json_array_get(part, 0)))
            json_object_set_new(value, key, spread_json(part));
        else
            take_spreads(part);
    }
}

void bench_cell_finish(json_t *cell)
{
    take_spreads(json_object_get(cell, "bake"));
    take_spreads(json_object_get(cell, "lookups"));
}
