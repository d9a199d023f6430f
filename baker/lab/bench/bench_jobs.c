/* The jobs of a measurement; see bench.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/bench/bench.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "baker/command/options/bake_arguments.h"
#include "baker/files/input_file.h"
#include "baker/files/json_file.h"

static vxs_result no_memory(run_context *m)
{
    return fail(m, VXS_E_MEMORY, "out of memory for the cells of the bench");
}

/* 1 when both values are for the same light ("sun=64" and "sun=512"), or both for all lights. */
static int same_name(const char *a, const char *b)
{
    const char *a_end = strrchr(a, '='), *b_end = strrchr(b, '=');
    return !a_end || !b_end ? a_end == b_end : a_end - a == b_end - b && !memcmp(a, b, (size_t)(a_end - a));
}

/* The number of values for the same light as value n; 0 if an earlier value is for that light. */
static size_t count_alike(const text_list *values, size_t n)
{
    size_t count = 0;
    for (size_t i = 0; i < n; i++)
        if (same_name(values->items[i], values->items[n])) return 0;
    for (size_t i = n; i < values->count; i++) count += (size_t)same_name(values->items[i], values->items[n]);
    return count;
}

static size_t append_pair(const char **arguments, size_t count, const char *name, const char *value)
{
    if (!value) return count;
    arguments[count]     = name;
    arguments[count + 1] = value;
    return count + 2;
}

static size_t append_all(const char **arguments, size_t count, const char *name, const text_list *values)
{
    for (size_t n = 0; n < values->count; n++) count = append_pair(arguments, count, name, values->items[n]);
    return count;
}

/* The command line that bakes cell `index`: common arguments, the cell's values, its scene. NULL when out of memory. */
static const char **arguments_of(const bench_options *o, const char *scene_path, const children *c, size_t index)
{
    size_t pairs = o->light_names.count + o->suns.count + o->exclude.count + o->include.count + 8, count = 0;
    for (int n = 0; n < BENCH_SWEEPS; n++) pairs += o->sweep_value[n].count;
    const char **all = calloc(2 * pairs, sizeof *all);
    if (!all) return NULL;
    count = append_pair(all, count, "vxs", "bake");
    count = append_pair(all, count, "--json", c->report);
    count = append_pair(all, count, "-o", c->asset);
    count = append_all(all, count, "--light", &o->light_names);
    count = append_all(all, count, "--sun", &o->suns);
    count = append_all(all, count, "--exclude", &o->exclude);
    count = append_all(all, count, "--include", &o->include);
    count = append_pair(all, count, "--region", o->region);
    count = append_pair(all, count, "--scene", o->scene_name);
    for (int n = BENCH_SWEEPS; n-- > 0;) /* the last varies fastest */
        for (size_t i = o->sweep_value[n].count; i-- > 0;) {
            const text_list *values = &o->sweep_value[n];
            size_t           alike = count_alike(values, i), which = alike ? index % alike : 0, at = i;
            if (!alike) continue;
            while (!same_name(values->items[at], values->items[i]) || which--) at++; /* to value `which` of these */
            count = append_pair(all, count, o->sweep_name[n], values->items[at]);
            index /= alike;
        }
    if (o->allow_outside) all[count++] = "--allow-outside";
    append_pair(all, count, "--", scene_path);
    return all;
}

/* Options that distinguish cells: bake's options and the scene, without those that are the same in every bench. NULL when out of
 * memory. */
static json_t *options_json(const bake_options *o)
{
    json_t *object = bake_options_json(o);
    json_object_del(object, "gl");
    if (o->scene.name) json_object_set_new(object, "scene", json_text(o->scene.name));

    /* round numbers to nine digits, as in a file, so that new measurements compare equal to stored ones */
    char   *text    = json_print(object, JSON_REAL_PRECISION(9));
    json_t *written = text ? json_loads(text, 0, NULL) : NULL;
    free(text);
    json_decref(object);
    return written;
}

/* Parse the arguments as the bake will, with its checks and defaults. */
static vxs_result read_arguments(bench_job *job, const char *name, json_t *cells, run_context *m)
{
    bake_arguments a;
    char         **argv = (char **)(size_t)(job->arguments + 1); /* argv[0] of a command is its own name */
    int            argc = 0, help_shown;
    while (argv[argc]) argc++;
    bake_arguments_init(&a, "bake", "", "", 1);
    vxs_result r = options_parse(&a.line, argc, argv, &help_shown, m);
    if (r == VXS_OK) r = bake_arguments_check(&a, m);
    if (r == VXS_OK) {
        const char *slash = strrchr(name, '/');
        job->runs         = json_array();
        job->cell         = json_pack("{s:o, s:o}", "scene", json_text(slash ? slash + 1 : name), "options", options_json(&a.o));
        job->weight = 1e6 + (double)a.o.resolution * a.o.resolution; /* a bake takes about as long as a million texels before it
                                                                        begins with its maps */
        for (size_t n = 0; n < a.o.resolutions.count; n++) job->weight += pow(a.o.resolutions.items[n].numbers[0], 2);
        if (json_array_append_new(cells, job->cell)) r = no_memory(m);
    }
    options_free(&a.line);
    return r;
}

static vxs_result require_different(const json_t *cells, run_context *m)
{
    json_t *cell;
    size_t  n;
    json_array_foreach(cells, n, cell) for (size_t i = 0; i < n; i++)
    {
        if (!bench_cells_equal(json_array_get(cells, i), cell)) continue;
        json_t    *key  = json_pack("[O, O]", json_object_get(cell, "scene"), json_object_get(cell, "options"));
        char      *text = json_print(key, JSON_COMPACT | JSON_SORT_KEYS | JSON_REAL_PRECISION(9));
        vxs_result r    = text ? fail(m, VXS_E_ARGUMENT,
                                      "given twice: %s: expected scenes of different names and different values of options", text)
                               : no_memory(m);
        free(text);
        json_decref(key);
        return r;
    }
    return VXS_OK;
}

vxs_result bench_jobs_make(bench_job **jobs, size_t *count, json_t *cells, const bench_options *o, const int *inputs,
                           const children *c, run_context *m)
{
    size_t     all = o->scenes.count;
    vxs_result r   = VXS_OK;
    *count         = 0;
    *jobs          = NULL;
    for (int n = 0; n < BENCH_SWEEPS; n++)
        for (size_t i = 0; i < o->sweep_value[n].count && all <= BENCH_CELLS_MAX; i++) {
            size_t alike = count_alike(&o->sweep_value[n], i);
            if (alike) all *= alike;
        }
    if (all > BENCH_CELLS_MAX)
        return fail(m, VXS_E_ARGUMENT, "too many combinations of scenes and options: expected at most %d", BENCH_CELLS_MAX);
    if (o->light_names.count > VXS_LIGHTS_MAX) return fail(m, VXS_E_ARGUMENT, "--light: expected at most %u", VXS_LIGHTS_MAX);
    *jobs = calloc(all, sizeof **jobs);
    if (!*jobs) return no_memory(m);
    for (; *count < all && r == VXS_OK; ++*count) {
        bench_job  *job   = &(*jobs)[*count];
        size_t      which = *count / (all / o->scenes.count);
        const char *path  = o->scenes.items[which];
        job->input        = inputs[which];
        job->scene_path   = job->input < 0 ? path : "-";
        job->arguments    = arguments_of(o, job->scene_path, c, *count);
        r                 = job->arguments ? read_arguments(job, input_name(path), cells, m) : no_memory(m);
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
