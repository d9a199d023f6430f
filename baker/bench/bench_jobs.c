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

/* The arguments of cell `index`: what all have, its values, its scene. NULL without memory. */
static const char **arguments_of(const bench_options *o, size_t index)
{
    const char **arguments = malloc((2 * (o->light_names.count + 3 + BENCH_SWEEPS) + 3) * sizeof *arguments);
    if (!arguments) return NULL;
    const char *value[BENCH_SWEEPS] = {0};
    for (int n = BENCH_SWEEPS; n-- > 0;) { /* the last varies fastest */
        const text_list *values = &o->sweep_value[n];
        if (!values->count) continue;
        value[n] = values->items[index % values->count];
        index /= values->count;
    }

    size_t count = 0;
    for (size_t n = 0; n < o->light_names.count; n++) {
        arguments[count++] = "--light";
        arguments[count++] = o->light_names.items[n];
    }
    const char *const passed[] = {"--sun", o->sun, "--region", o->region, "--scene", o->scene_name};
    for (size_t n = 0; n < sizeof passed / sizeof *passed; n += 2) {
        if (!passed[n + 1]) continue;
        arguments[count++] = passed[n];
        arguments[count++] = passed[n + 1];
    }
    for (int n = 0; n < BENCH_SWEEPS; n++) {
        if (!value[n]) continue;
        arguments[count++] = o->sweep_name[n];
        arguments[count++] = value[n];
    }
    arguments[count++] = "--";
    arguments[count++] = o->scenes[index];
    arguments[count]   = NULL;
    return arguments;
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
    return object;
}

static char *base_name(const char *path)
{
    const char *slash = strrchr(path, '/');
    json_t     *text  = json_text(slash ? slash + 1 : path);
    char       *name  = text ? strdup(json_string_value(text)) : NULL;
    json_decref(text);
    return name;
}

char *bench_key(const char *scene_name, const json_t *options)
{
    json_t *key  = json_pack("[s,O]", scene_name, options);
    char   *text = key ? json_print(key, JSON_COMPACT | JSON_SORT_KEYS | JSON_REAL_PRECISION(9)) : NULL;
    json_decref(key);
    return text;
}

/* Read the arguments as bake would: its checks, its defaults. */
static vxs_result read_arguments(bench_job *job, message *m)
{
    char          *argv[2 * (VXS_LIGHTS_MAX + BENCH_SWEEPS) + 16] = {"bake", "-o", "asset"};
    int            argc                                           = 3;
    bake_arguments a;
    for (size_t n = 0; job->arguments[n]; n++) {
        if (argc == sizeof argv / sizeof *argv) return fail(m, VXS_E_ARGUMENT, "--light: expected at most %u", VXS_LIGHTS_MAX);
        argv[argc++] = (char *)job->arguments[n];
    }
    vxs_result r = bake_arguments_parse(&a, "bake", "SCENE -o OUT.vxs [options]", "", 1, argc, argv, m);
    if (r == VXS_OK) {
        bench_cell *cell = job->cell;
        cell->scene      = base_name(job->scene_path);
        cell->options    = options_json(&a.o);
        cell->key        = cell->scene ? bench_key(cell->scene, cell->options) : NULL;
        job->weight = 1e6 + (double)a.o.resolution * a.o.resolution; /* a bake takes as long as a million texels before it begins */
        if (!cell->key) r = no_memory(m);
    }
    bake_arguments_free(&a);
    return r;
}

static int compare_keys(const void *a, const void *b)
{
    return strcmp(*(char *const *)a, *(char *const *)b);
}

static vxs_result require_different(const bench_result *result, message *m)
{
    const char **keys = malloc(result->cell_count * sizeof *keys);
    vxs_result   r    = keys ? VXS_OK : no_memory(m);
    for (size_t n = 0; keys && n < result->cell_count; n++) keys[n] = result->cells[n].key;
    if (keys) qsort(keys, result->cell_count, sizeof *keys, compare_keys);
    for (size_t n = 1; keys && n < result->cell_count && r == VXS_OK; n++)
        if (!strcmp(keys[n - 1], keys[n]))
            r = fail(m, VXS_E_ARGUMENT, "asked for twice: %s: expected scenes of different names and different values of options",
                     keys[n]);
    free(keys);
    return r;
}

vxs_result bench_jobs_make(bench_job **jobs, bench_result *result, const bench_options *o, message *m)
{
    size_t     count = count_cells(o);
    vxs_result r     = VXS_OK;
    *jobs            = NULL;
    if (count > BENCH_CELLS_MAX)
        return fail(m, VXS_E_ARGUMENT, "too many combinations of scenes and options: expected at most %d", BENCH_CELLS_MAX);
    result->cells = calloc(count, sizeof *result->cells);
    *jobs         = calloc(count, sizeof **jobs);
    if (!result->cells || !*jobs) return no_memory(m);

    result->cell_count = count;
    for (size_t n = 0; n < count && r == VXS_OK; n++) {
        bench_job *job  = &(*jobs)[n];
        job->scene_path = o->scenes[n / (count / o->scene_count)];
        job->cell       = &result->cells[n];
        job->arguments  = arguments_of(o, n);
        job->samples    = calloc((size_t)ROW_COUNT * o->runs, sizeof *job->samples);
        r               = job->arguments && job->samples ? read_arguments(job, m) : no_memory(m);
    }
    return r == VXS_OK ? require_different(result, m) : r;
}

void bench_jobs_free(bench_job *jobs, size_t count)
{
    for (size_t n = 0; jobs && n < count; n++) {
        free(jobs[n].arguments);
        free(jobs[n].samples);
    }
    free(jobs);
}
