/* What is to be measured; see bench_jobs.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/bench/bench_jobs.h"

#include <stdlib.h>
#include <string.h>

#include "baker/files/json_file.h"
#include "baker/options/bake_arguments.h"

static vxs_result no_memory(message *m)
{
    return fail(m, VXS_E_MEMORY, "out of memory for the cells of the bench");
}

/* How many combinations there are; BENCH_CELLS_MAX + 1 when they are more. */
static size_t count_cells(const bench_options *o)
{
    size_t count = o->scene_count;
    for (int n = 0; n < BENCH_SWEEPS && count <= BENCH_CELLS_MAX; n++)
        if (o->sweep_value[n].count) count *= o->sweep_value[n].count;
    return count <= BENCH_CELLS_MAX ? count : BENCH_CELLS_MAX + 1;
}

static size_t append_pair(const char **arguments, size_t count, const char *name, const char *value)
{
    if (!value) return count;
    arguments[count]     = name;
    arguments[count + 1] = value;
    return count + 2;
}

/* The command line that bakes cell `index`: what all have, its values, its scene. NULL without memory. */
static const char **arguments_of(const bench_options *o, const children *c, size_t index)
{
    const char **all = calloc(2 * (o->light_names.count + BENCH_SWEEPS + 6) + 4, sizeof *all), *value[BENCH_SWEEPS] = {0};
    size_t       count = 0;
    if (!all) return NULL;
    for (int n = BENCH_SWEEPS; n-- > 0;) { /* the last varies fastest */
        const text_list *values = &o->sweep_value[n];
        if (!values->count) continue;
        value[n] = values->items[index % values->count];
        index /= values->count;
    }
    count = append_pair(all, count, "vxs", "bake");
    count = append_pair(all, count, "--baseline", "off");
    count = append_pair(all, count, "--json", c->report);
    count = append_pair(all, count, "-o", c->asset);
    for (size_t n = 0; n < o->light_names.count; n++) count = append_pair(all, count, "--light", o->light_names.items[n]);
    count = append_pair(all, count, "--sun", o->sun);
    count = append_pair(all, count, "--region", o->region);
    count = append_pair(all, count, "--scene", o->scene_name);
    for (int n = 0; n < BENCH_SWEEPS; n++) count = append_pair(all, count, o->sweep_name[n], value[n]);
    append_pair(all, count, "--", o->scenes[index]);
    return all;
}

/* As a file will have it: numbers in nine digits, so that what is measured equals what was. NULL without memory. */
static json_t *as_written(json_t *value)
{
    char   *text    = json_print(value, JSON_REAL_PRECISION(9));
    json_t *written = text ? json_loads(text, 0, NULL) : NULL;
    free(text);
    json_decref(value);
    return written;
}

/* What makes a difference: bake's own words, and what the measurement was told to bake. Without what is the same in every bench. */
static json_t *options_json(const bake_options *o)
{
    json_t *object = bake_options_json(o);
    json_object_del(object, "gl");
    json_object_del(object, "baseline");
    json_object_set_new(object, "resolution_px", json_integer(o->resolution));
    if (o->sun_given) json_object_set_new(object, "sun", json_pack("[f,f,f]", o->sun[0], o->sun[1], o->sun[2]));
    if (o->scene_name) json_object_set_new(object, "scene", json_text(o->scene_name));
    if (o->light_names.count) {
        json_t *names = json_array();
        for (size_t n = 0; n < o->light_names.count; n++) json_array_append_new(names, json_text(o->light_names.items[n]));
        json_object_set_new(object, "light", names);
    }
    return as_written(object);
}

/* Read the arguments as the bake will: its checks, its defaults. */
static vxs_result read_arguments(bench_job *job, json_t *cells, message *m)
{
    bake_arguments a;
    char         **argv = (char **)(size_t)(job->arguments + 1); /* that of a command begins with its own name */
    int            argc = 0;
    while (argv[argc]) argc++;
    vxs_result r = bake_arguments_parse(&a, "bake", "SCENE -o OUT.vxs [options]", "", 1, argc, argv, m);
    if (r == VXS_OK) {
        const char *slash = strrchr(job->scene_path, '/');
        job->runs         = json_array();
        job->cell = json_pack("{s:o, s:o}", "scene", json_text(slash ? slash + 1 : job->scene_path), "options", options_json(&a.o));
        job->weight = 1e6 + (double)a.o.resolution * a.o.resolution; /* a bake takes as long as a million texels before it begins */
        if (json_array_append_new(cells, job->cell)) r = no_memory(m);
    }
    bake_arguments_free(&a);
    return r;
}

static vxs_result require_different(const json_t *cells, message *m)
{
    json_t *cell;
    size_t  n;
    json_array_foreach(cells, n, cell) for (size_t i = 0; i < n; i++)
    {
        if (!bench_cells_equal(json_array_get(cells, i), cell)) continue;
        json_t    *key  = json_pack("[O, O]", json_object_get(cell, "scene"), json_object_get(cell, "options"));
        char      *text = json_print(key, JSON_COMPACT | JSON_SORT_KEYS | JSON_REAL_PRECISION(9));
        vxs_result r    = text ? fail(m, VXS_E_ARGUMENT,
                                      "asked for twice: %s: expected scenes of different names and different values of options", text)
                               : no_memory(m);
        free(text);
        json_decref(key);
        return r;
    }
    return VXS_OK;
}

vxs_result bench_jobs_make(bench_job **jobs, size_t *count, json_t *cells, const bench_options *o, const children *c, message *m)
{
    size_t     all = count_cells(o);
    vxs_result r   = VXS_OK;
    *count         = 0;
    *jobs          = NULL;
    if (all > BENCH_CELLS_MAX)
        return fail(m, VXS_E_ARGUMENT, "too many combinations of scenes and options: expected at most %d", BENCH_CELLS_MAX);
    if (o->light_names.count > VXS_LIGHTS_MAX) return fail(m, VXS_E_ARGUMENT, "--light: expected at most %u", VXS_LIGHTS_MAX);
    *jobs = calloc(all, sizeof **jobs);
    if (!*jobs) return no_memory(m);
    for (; *count < all && r == VXS_OK; ++*count) {
        bench_job *job  = &(*jobs)[*count];
        job->scene_path = o->scenes[*count / (all / o->scene_count)];
        job->arguments  = arguments_of(o, c, *count);
        r               = job->arguments ? read_arguments(job, cells, m) : no_memory(m);
    }
    return r == VXS_OK ? require_different(cells, m) : r;
}

void bench_jobs_free(bench_job *jobs, size_t count)
{
    for (size_t n = 0; n < count; n++) {
        free(jobs[n].arguments);
        json_decref(jobs[n].runs);
    }
    free(jobs);
}
