/* A cell of a measurement; see bench.h.
 *
 * Reports are read as they are: they were written a moment ago by this very program.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/bench/bench.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

/* Collect the value at a path in each object or array of `from`: an array, released by the caller. */
static json_t *pick(const json_t *from, const char *format, ...) __attribute__((format(printf, 2, 3)));
static json_t *pick(const json_t *from, const char *format, ...)
{
    char    path[64];
    json_t *item, *picked = json_array();
    size_t  n;
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(path, sizeof path, format, arguments);
    va_end(arguments);
    json_array_foreach(from, n, item) json_array_append(picked, json_at(item, path));
    return picked;
}

/* The sum of the values at a path in all objects. */
static double total(const json_t *objects, const char *path)
{
    const json_t *object;
    size_t        n;
    double        sum = 0;
    json_array_foreach(objects, n, object) sum += number_at(object, path);
    return sum;
}

/* The mean, weighted by the value at another path; 0 when all weights are 0. */
static double mean(const json_t *objects, const char *path, const char *weight_path)
{
    const json_t *object;
    size_t        n;
    double        sum = 0;
    json_array_foreach(objects, n, object) sum += number_at(object, weight_path) * number_at(object, path);
    return sum / fmax(1, total(objects, weight_path));
}

/* A bake ----------------------------------------------------------------------------------------------------------------------- */

static double maps_to_words_seconds(const json_t *stages)
{
    static const char *const names[] = {"pyramid", "masks", "insert", "compress", "merge"};
    const json_t            *stage;
    size_t                   n;
    double                   seconds = 0;
    json_array_foreach(stages, n, stage) for (size_t i = 0; i < sizeof names / sizeof *names; i++)
    {
        if (!strcmp(names[i], text_at(stage, "name"))) seconds += number_at(stage, "seconds");
    }
    return seconds;
}

static void add_count(json_t *object, const char *name, uint64_t count)
{
    json_object_set_new(object, name, json_integer((json_int_t)(count_at(object, name) + count)));
}

/* Add the bytes of a level or a part. */
static void add_bytes(json_t *sum, const json_t *part)
{
    static const char *const figures[] = {"count", "memory_bytes", "stored_bytes"};
    for (size_t n = 0; n < sizeof figures / sizeof *figures; n++) add_count(sum, figures[n], count_at(part, figures[n]));
}

/* Levels are sorted by side, the root first, masks (side 0) last. */
static void add_level(json_t *size, const json_t *level)
{
    const char *kind   = text_at(level, "kind"); /* "nodes" or "masks" */
    json_t     *levels = json_object_get(size, "levels");
    uint64_t    side   = strcmp(kind, "masks") ? count_at(level, "side_voxels") : 0;
    size_t      at     = 0;
    while (at < json_array_size(levels) && count_at(json_array_get(levels, at), "side_voxels") > side) at++;
    if (at == json_array_size(levels) || count_at(json_array_get(levels, at), "side_voxels") != side)
        json_array_insert_new(levels, at, json_pack("{s:I}", "side_voxels", (json_int_t)side));
    add_bytes(json_array_get(levels, at), level);
    add_count(size, kind, count_at(level, "count"));
}

static void set_dag_size(json_t *size, const json_t *lights)
{
    json_t *light, *level;
    size_t  n, i;
    json_t *counts = json_pack("{s:i, s:i, s:I, s:I, s:[]}", "nodes", 0, "masks", 0, "inserted_nodes",
                               (json_int_t)total(lights, "inserted_nodes"), "inserted_masks",
                               (json_int_t)total(lights, "inserted_masks"), "levels");
    json_object_update(size, counts);
    json_decref(counts);
    json_array_foreach(lights, n, light) json_array_foreach(json_at(light, "levels"), i, level) add_level(size, level);
}

/* All lights have the same parts in the same order. */
static void set_blocks_size(json_t *size, const json_t *lights)
{
    json_t     *light, *part, *count, *parts = json_array(), *kept = json_object();
    const char *name;
    size_t      n, i;
    json_array_foreach(lights, n, light)
    {
        json_object_foreach(json_at(light, "palette_blocks"), name, count) add_count(kept, name, count_at(count, ""));
        json_array_foreach(json_at(light, "levels"), i, part)
        {
            if (!n) json_array_append_new(parts, json_pack("{s:O}", "kind", json_at(part, "kind")));
            add_bytes(json_array_get(parts, i), part);
        }
    }
    json_object_set_new(size, "palette_blocks", kept);
    json_object_set_new(size, "parts", parts);
}

/* A comparison ----------------------------------------------------------------------------------------------------------------- */

/* Errors of the lights at points of one kind, by single taps. found: released */
static json_t *tap_error(json_t *found, const char *kind)
{
    double  checked = total(found, "checked"), leaks = total(found, "leaks"), false_shadows = total(found, "false_shadows");
    json_t *error = json_pack("{s:s, s:i, s:I, s:f, s:I, s:I, s:I}", "points", kind, "filter_px", 1, "checked", (json_int_t)checked,
                              "wrong_share", (leaks + false_shadows) / fmax(1, checked), "leaks", (json_int_t)leaks,
                              "false_shadows", (json_int_t)false_shadows, "unexplained", (json_int_t)total(found, "unexplained"));
    json_decref(found);
    return error;
}

/* The same, for lookups with a filter. */
static json_t *filter_error(json_t *found, const char *kind, const json_t *filter)
{
    const json_t *of;
    size_t        n;
    double        checked = total(found, "points"), squares = 0, most = 0;
    json_array_foreach(found, n, of)
    {
        double rmse = number_at(of, "rmse");
        squares += rmse * rmse * number_at(of, "points");
        most = fmax(most, number_at(of, "max_error"));
    }
    json_t *error = json_pack("{s:s, s:O, s:O, s:I, s:f, s:f}", "points", kind, "filter_px", json_at(filter, "filter_px"), "smooth",
                              json_at(filter, "smooth"), "checked", (json_int_t)checked, "rmse", sqrt(squares / fmax(1, checked)),
                              "max_error", most);
    json_decref(found);
    return error;
}

static json_t *errors_json(const json_t *lights)
{
    static const char *const kinds[] = {"random", "surface"};
    enum { KINDS = sizeof kinds / sizeof *kinds };
    json_t *filter, *errors = json_array();
    size_t  n, k;
    for (k = 0; lights && k < KINDS; k++) json_array_append_new(errors, tap_error(pick(lights, "%s", kinds[k]), kinds[k]));
    json_array_foreach(json_at(lights, "0/filters"), n, filter) for (k = 0; k < KINDS; k++)
    {
        json_t *found = pick(lights, "filters/%zu/%s", n, kinds[k]);
        json_array_append_new(errors, filter_error(found, kinds[k], filter));
    }
    return errors;
}

/* Nanoseconds: the mean over points that were looked up. */
static json_t *lookups_json(const json_t *lights)
{
    static const char points[] = "time/points";
    json_t           *filter, *lookups = json_array();
    size_t            n;
    if (lights)
        json_array_append_new(lookups,
                              json_pack("{s:i, s:f, s:f}", "filter_px", 1, "nanoseconds", mean(lights, "time/lookup_ns", points),
                                        "ray_nanoseconds", mean(lights, "time/ray_ns", points)));
    json_array_foreach(json_at(lights, "0/filters"), n, filter)
    {
        char path[64];
        snprintf(path, sizeof path, "filters/%zu/lookup_ns", n);
        json_array_append_new(lookups, json_pack("{s:O, s:O, s:f}", "filter_px", json_at(filter, "filter_px"), "smooth",
                                                 json_at(filter, "smooth"), "nanoseconds", mean(lights, path, points)));
    }
    return lookups;
}

/* Cells ------------------------------------------------------------------------------------------------------------------------ */

json_t *bench_cell_of_run(const json_t *cell, const json_t *bake, const json_t *compare, double wall_seconds)
{
    const json_t *lights = json_at(bake, "lights"), *compared = json_at(compare, "assets/0/lights");
    json_t       *size = json_pack("{s:O, s:I}", "file_bytes", json_at(bake, "file_bytes"), "memory_bytes",
                                   (json_int_t)total(lights, "size/memory_bytes"));
    json_at(lights, "0/palette_blocks") ? set_blocks_size(size, lights) : set_dag_size(size, lights);
    return json_pack("{s:O, s:O, s:O, s:O, s:I, s:I, s:O, s:{s:f, s:f, s:f, s:O, s:O}, s:o, s:o, s:o}", "scene",
                     json_at(cell, "scene"), "triangles", json_at(bake, "casters/triangles"), "solid_triangles",
                     json_at(bake, "casters/solids/triangles"), "light", json_at(lights, "0/name"), "lights",
                     (json_int_t)json_array_size(lights), "maps", (json_int_t)total(lights, "maps"), "options",
                     json_at(cell, "options"), "bake", "wall_seconds", wall_seconds, "total_seconds",
                     number_at(bake, "total_seconds"), "maps_to_words_seconds", maps_to_words_seconds(json_at(bake, "stages")),
                     "stages", json_at(bake, "stages"), "peak_bytes", json_at(bake, "peak_bytes"), "size", size, "errors",
                     errors_json(compared), "lookups", lookups_json(compared));
}

/* The values of all runs under one name. values: released */
static json_t *of_runs(const char *name, json_t *values)
{
    json_t     *part, *first = json_array_get(values, 0), *whole = NULL;
    const char *key;
    size_t      n;
    if (first && strstr(name, "seconds")) {
        double numbers[BENCH_RUNS_MAX];
        json_array_foreach(values, n, part) numbers[n] = json_number_value(part);
        spread s                                       = spread_of(numbers, (uint32_t)json_array_size(values));
        whole = json_pack("{s:f, s:f, s:f}", "median", s.median, "min", s.min, "max", s.max);
    } else if (json_is_object(first)) {
        whole = json_object();
        json_object_foreach(first, key, part) json_object_set_new(whole, key, of_runs(key, pick(values, "%s", key)));
    } else if (json_is_array(first)) {
        whole = json_array();
        json_array_foreach(first, n, part) json_array_append_new(whole, of_runs("", pick(values, "%zu", n)));
    } else {
        whole = first;
        json_array_foreach(values, n, part)
        {
            if (!strcmp(name, "peak_bytes") && json_integer_value(part) > json_integer_value(whole)) whole = part;
        }
        json_incref(whole);
    }
    json_decref(values);
    return whole;
}

json_t *bench_cell_of_runs(json_t *runs)
{
    return of_runs("", runs);
}
