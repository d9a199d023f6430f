/* What a child reports; see bench_reports.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/bench/bench_reports.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/integer.h"
#include "baker/files/json_file.h"

/* From ready depth maps to the DAG. */
static const char *const maps_to_dag_stages[] = {"pyramid", "masks", "insert", "compress", "merge"};

static vxs_result unexpected(const char *path, const json_error_t *e, message *m)
{
    if (json_memory_missing()) return fail(m, VXS_E_MEMORY, "out of memory while reading %s", path);
    return fail(m, VXS_E_READ, "%s: not the report of this version: %s", path, e->text);
}

/* A bake ---------------------------------------------------------------------------------------------------------------------- */

static int take_light(bench_cell *cell, json_t *light, json_error_t *e)
{
    json_t    *levels, *level;
    size_t     n;
    json_int_t memory_bytes, inserted_nodes, inserted_masks;
    if (json_unpack_ex(light, e, 0, "{s:{s:I}, s:I, s:I, s:o}", "size", "memory_bytes", &memory_bytes, "inserted_nodes",
                       &inserted_nodes, "inserted_masks", &inserted_masks, "levels", &levels))
        return 0;
    cell->memory_bytes += (uint64_t)memory_bytes;
    cell->inserted_nodes += (uint64_t)inserted_nodes;
    cell->inserted_masks += (uint64_t)inserted_masks;
    json_array_foreach(levels, n, level)
    {
        const char *kind;
        json_int_t  side_voxels, count, memory, stored;
        if (json_unpack_ex(level, e, 0, "{s:s, s:I, s:I, s:I, s:I}", "kind", &kind, "side_voxels", &side_voxels, "count", &count,
                           "memory_bytes", &memory, "stored_bytes", &stored))
            return 0;
        int          is_mask = !strcmp(kind, "masks");
        uint32_t     at      = is_mask ? 0 : log2_u32((uint32_t)side_voxels);
        bench_level *sum     = &cell->levels[at];
        sum->count += (uint64_t)count;
        sum->memory_bytes += (uint64_t)memory;
        sum->stored_bytes += (uint64_t)stored;
        cell->level_set |= 1u << at;
        *(is_mask ? &cell->masks : &cell->nodes) += (uint64_t)count;
    }
    return 1;
}

static int take_lights(bench_cell *cell, json_t *lights, json_t *planned, json_error_t *e)
{
    json_t *light;
    size_t  n;
    cell->memory_bytes = cell->inserted_nodes = cell->inserted_masks = cell->nodes = cell->masks = cell->maps = 0;
    cell->lights    = json_array_size(lights);
    cell->level_set = 0;
    memset(cell->levels, 0, sizeof cell->levels);
    json_array_foreach(lights, n, light) if (!take_light(cell, light, e)) return 0;
    json_array_foreach(planned, n, light) /* those that are left out have none */
        cell->maps += (uint64_t)json_integer_value(json_object_get(light, "maps"));
    return 1;
}

static int take_stages(bench_job *job, uint32_t run, uint32_t runs, json_t *stages, json_error_t *e)
{
    bench_cell *cell        = job->cell;
    double      maps_to_dag = 0;
    json_t     *stage;
    size_t      n;
    json_array_foreach(stages, n, stage)
    {
        const char *name;
        json_int_t  peak_bytes;
        double      seconds;
        if (n == BENCH_STAGES_MAX) break;
        if (json_unpack_ex(stage, e, 0, "{s:s, s:F, s:I}", "name", &name, "seconds", &seconds, "peak_bytes", &peak_bytes)) return 0;
        bench_stage *s = &cell->stages[n];
        snprintf(s->name, sizeof s->name, "%s", name);
        if (s->peak_bytes < (uint64_t)peak_bytes) s->peak_bytes = (uint64_t)peak_bytes;
        job_row(job, ROW_STAGE + (int)n, runs)[run] = seconds;
        for (size_t i = 0; i < sizeof maps_to_dag_stages / sizeof *maps_to_dag_stages; i++)
            if (!strcmp(name, maps_to_dag_stages[i])) maps_to_dag += seconds;
    }
    cell->stage_count                        = (uint32_t)n;
    job_row(job, ROW_MAPS_TO_DAG, runs)[run] = maps_to_dag;
    return 1;
}

static int set_text(char **text, const char *value)
{
    if (*text) return 1;
    *text = strdup(value);
    return *text != NULL;
}

vxs_result bench_take_bake(bench_job *job, uint32_t run, uint32_t runs, const char *path, bench_machine *machine, message *m)
{
    bench_cell  *cell = job->cell;
    json_t      *root, *lights, *planned, *stages;
    const char  *renderer, *light;
    json_int_t   triangles, solid_triangles, file_bytes, peak_bytes;
    json_error_t e;
    vxs_result   r = json_read(&root, path, m);
    if (r != VXS_OK) return r;
    if (json_unpack_ex(root, &e, 0, "{s:s, s:I, s:{s:I, s:{s:I}}, s:o, s:[{s:s}], s:{s:o}, s:o, s:F, s:I}", "renderer", &renderer,
                       "file_bytes", &file_bytes, "casters", "triangles", &triangles, "solids", "triangles", &solid_triangles,
                       "lights", &lights, "lights", "name", &light, "plan", "lights", &planned, "stages", &stages, "total_seconds",
                       &job_row(job, ROW_TOTAL, runs)[run], "peak_bytes", &peak_bytes) ||
        !take_lights(cell, lights, planned, &e) || !take_stages(job, run, runs, stages, &e))
        r = unexpected(path, &e, m);
    else if (!set_text(&machine->renderer, renderer) || !set_text(&cell->light, light))
        r = fail(m, VXS_E_MEMORY, "out of memory");
    if (r == VXS_OK) {
        cell->triangles       = (uint64_t)triangles;
        cell->solid_triangles = (uint64_t)solid_triangles;
        cell->file_bytes      = (uint64_t)file_bytes;
        if (cell->peak_bytes < (uint64_t)peak_bytes) cell->peak_bytes = (uint64_t)peak_bytes;
    }
    json_decref(root);
    return r;
}

/* A comparison ---------------------------------------------------------------------------------------------------------------- */

/* The means of lights, each counted as often as points were looked up in it. */
typedef struct weighted {
    double sum, weight;
} weighted;

static void add(weighted *w, double value, json_int_t weight)
{
    w->sum += value * (double)weight;
    w->weight += (double)weight;
}

static double mean(const weighted *w)
{
    return w->weight > 0 ? w->sum / w->weight : 0;
}

static int add_counts(bench_error *error, json_t *counts, json_error_t *e)
{
    json_int_t checked, leaks, false_shadows, unexplained;
    if (json_unpack_ex(counts, e, 0, "{s:I, s:I, s:I, s:I}", "checked", &checked, "leaks", &leaks, "false_shadows", &false_shadows,
                       "unexplained", &unexplained))
        return 0;
    error->checked += (uint64_t)checked;
    error->leaks += (uint64_t)leaks;
    error->false_shadows += (uint64_t)false_shadows;
    error->unexplained += (uint64_t)unexplained;
    return 1;
}

static int add_filter_error(bench_error *error, weighted *square, json_t *filter, json_error_t *e)
{
    json_int_t points;
    double     rmse, max_error;
    if (json_unpack_ex(filter, e, 0, "{s:I, s:F, s:F}", "points", &points, "rmse", &rmse, "max_error", &max_error)) return 0;
    error->checked += (uint64_t)points;
    error->max_error = fmax(error->max_error, max_error);
    add(square, rmse * rmse, points);
    return 1;
}

/* Sums over lights while they are read; errors and lookups of a cell are in the order of filters, single taps first. */
typedef struct compare_sums {
    weighted lookup[BENCH_FILTERS_MAX], ray, square[BENCH_POINTS_COUNT * BENCH_FILTERS_MAX];
} compare_sums;

static int take_filters(bench_cell *cell, compare_sums *sums, json_t *filters, json_int_t timed, json_error_t *e)
{
    json_t *filter;
    size_t  n;
    json_array_foreach(filters, n, filter)
    {
        json_int_t filter_px;
        json_t    *points[BENCH_POINTS_COUNT];
        double     lookup_ns;
        if (n + 1 == BENCH_FILTERS_MAX) break;
        if (json_unpack_ex(filter, e, 0, "{s:I, s:o, s:o, s:F}", "filter_px", &filter_px, "random", &points[BENCH_RANDOM],
                           "surface", &points[BENCH_SURFACE], "lookup_ns", &lookup_ns))
            return 0;
        cell->lookups[n + 1].filter_px = (uint32_t)filter_px;
        add(&sums->lookup[n + 1], lookup_ns, timed);
        for (size_t kind = 0; kind < BENCH_POINTS_COUNT; kind++) {
            size_t       at    = (n + 1) * BENCH_POINTS_COUNT + kind;
            bench_error *error = &cell->errors[at];
            error->points      = (bench_points)kind;
            error->filter_px   = (uint32_t)filter_px;
            if (!add_filter_error(error, &sums->square[at], points[kind], e)) return 0;
        }
    }
    cell->lookup_count = (uint32_t)n + 1;
    cell->error_count  = BENCH_POINTS_COUNT * cell->lookup_count;
    return 1;
}

static int take_compared_light(bench_cell *cell, compare_sums *sums, json_t *light, json_error_t *e)
{
    json_t    *points[BENCH_POINTS_COUNT], *filters = NULL;
    json_int_t timed;
    double     lookup_ns, ray_ns;
    if (json_unpack_ex(light, e, 0, "{s:o, s:o, s?o, s:{s:I, s:F, s:F}}", "random", &points[BENCH_RANDOM], "surface",
                       &points[BENCH_SURFACE], "filters", &filters, "time", "points", &timed, "lookup_ns", &lookup_ns, "ray_ns",
                       &ray_ns))
        return 0;
    add(&sums->lookup[0], lookup_ns, timed);
    add(&sums->ray, ray_ns, timed);
    cell->lookups[0].filter_px = 1;
    for (int kind = 0; kind < BENCH_POINTS_COUNT; kind++) {
        cell->errors[kind].points    = (bench_points)kind;
        cell->errors[kind].filter_px = 1;
        if (!add_counts(&cell->errors[kind], points[kind], e)) return 0;
    }
    return take_filters(cell, sums, filters, timed, e);
}

static void take_sums(bench_job *job, uint32_t run, uint32_t runs, const compare_sums *sums)
{
    bench_cell *cell                 = job->cell;
    job_row(job, ROW_RAY, runs)[run] = mean(&sums->ray);
    for (uint32_t n = 0; n < cell->lookup_count; n++) job_row(job, ROW_LOOKUP + (int)n, runs)[run] = mean(&sums->lookup[n]);
    for (uint32_t n = 0; n < cell->error_count; n++) {
        bench_error *error = &cell->errors[n];
        if (error->filter_px > 1)
            error->rmse = sqrt(mean(&sums->square[n]));
        else if (error->checked)
            error->wrong_share = (double)(error->leaks + error->false_shadows) / (double)error->checked;
    }
}

vxs_result bench_take_compare(bench_job *job, uint32_t run, uint32_t runs, const char *path, message *m)
{
    compare_sums sums = {0};
    json_t      *root, *lights, *light;
    size_t       n;
    json_error_t e;
    vxs_result   r = json_read(&root, path, m);
    if (r != VXS_OK) return r;
    memset(job->cell->errors, 0, sizeof job->cell->errors);
    if (json_unpack_ex(root, &e, 0, "{s:[{s:o}]}", "assets", "lights", &lights)) r = unexpected(path, &e, m);
    if (r == VXS_OK) json_array_foreach(lights, n, light) if (!take_compared_light(job->cell, &sums, light, &e))
        {
            r = unexpected(path, &e, m);
            break;
        }
    if (r == VXS_OK) take_sums(job, run, runs, &sums);
    json_decref(root);
    return r;
}
