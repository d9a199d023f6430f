/* Measuring bakes and lookups; see bench.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/bench/bench.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "baker/measure/clock.h"
#include "baker/measure/progress.h"
#include "baker/base/version.h"
#include "baker/bench/bench_jobs.h"
#include "baker/bench/bench_reports.h"
#include "baker/bench/bench_text.h"
#include "baker/bench/child.h"
#include "baker/bench/work_folder.h"

typedef struct bench_work {
    const bench_options *o;
    bench_result        *result;
    bench_job           *jobs; /* [result->cell_count] */
    interrupts           signals;
    char                *folder, *asset, *report, *errors; /* files in it: what a child writes, and its standard error */
    double               since;                            /* when the first run began */
    int                  outputs_differ;
} bench_work;

/* Children ------------------------------------------------------------------------------------------------------------------- */

/* The error that a child printed, which is the last line when there is one; "" when there is none. */
static void read_error(const char *path, char text[512])
{
    static const char begin[] = "vxs: error: ";
    char              line[512];
    FILE             *f = fopen(path, "re");
    text[0]             = 0;
    while (f && fgets(line, sizeof line, f))
        if (!strncmp(line, begin, strlen(begin))) strcpy(text, line + strlen(begin));
    text[strcspn(text, "\n")] = 0;
    if (f) fclose(f);
}

static vxs_result result_of_status(int status)
{
    static const vxs_result results[] = {VXS_E_ARGUMENT, VXS_E_READ, VXS_E_WRITE, VXS_E_NO_CASTER, VXS_E_MEMORY, VXS_E_INTERRUPTED};
    for (size_t n = 0; n < sizeof results / sizeof *results; n++)
        if (exit_status(results[n]) == status) return results[n];
    return VXS_E_MEMORY; /* it crashed, or was killed */
}

/* Run a command whose exit status is 0, or `accepted`. */
static vxs_result run_child(bench_work *w, const bench_job *job, const char *const *arguments, int accepted, double *seconds,
                            message *m)
{
    child_end  end;
    char       name[256], text[512];
    vxs_result r = child_run(&w->signals, arguments, w->errors, &end, m);
    if (r != VXS_OK) return r;
    *seconds = end.seconds;
    if (!end.exit_status || end.exit_status == accepted) return VXS_OK;

    read_error(w->errors, text);
    if (!text[0] && end.exit_status < 0)
        snprintf(text, sizeof text, "ended by signal %d, %s", -end.exit_status, strsignal(-end.exit_status));
    if (!text[0]) snprintf(text, sizeof text, "exit status %d", end.exit_status);
    return fail(m, result_of_status(end.exit_status), "%s of %s: %s", arguments[1],
                bench_cell_name(name, sizeof name, w->result, job->cell), text);
}

/* Steps of a run ------------------------------------------------------------------------------------------------------------- */

static vxs_result bake_once(bench_work *w, bench_job *job, uint32_t run, message *m)
{
    static const char *const begin[] = {"vxs", "bake", "--baseline", "off", "--json", NULL, "-o", NULL};
    enum { BEGIN = sizeof begin / sizeof *begin, JSON = 5, OUTPUT = 7 };
    size_t count = 0;
    while (job->arguments[count]) count++;
    const char **arguments = malloc((BEGIN + count + 1) * sizeof *arguments);
    if (!arguments) return fail(m, VXS_E_MEMORY, "out of memory for arguments");
    memcpy(arguments, begin, sizeof begin);
    memcpy(arguments + BEGIN, job->arguments, (count + 1) * sizeof *arguments);
    arguments[JSON]   = w->report;
    arguments[OUTPUT] = w->asset;

    vxs_result r = run_child(w, job, arguments, 0, &job_row(job, ROW_WALL, w->o->runs)[run], m);
    free(arguments);
    return r == VXS_OK ? bench_take_bake(job, run, w->o->runs, w->report, &w->result->machine, m) : r;
}

static vxs_result hash_file(const char *path, XXH128_hash_t *hash, message *m)
{
    XXH3_state_t *state = XXH3_createState();
    FILE         *f     = fopen(path, "rbe");
    char          bytes[1 << 16];
    vxs_result    r = VXS_OK;
    if (!state || (!f && errno == ENOMEM))
        r = fail(m, VXS_E_MEMORY, "out of memory while reading %s", path);
    else if (!f)
        r = fail(m, VXS_E_READ, "%s: cannot read: %s", path, strerror(errno));
    if (r == VXS_OK) {
        XXH3_128bits_reset(state);
        for (size_t count; (count = fread(bytes, 1, sizeof bytes, f));) XXH3_128bits_update(state, bytes, count);
        if (ferror(f)) r = fail(m, VXS_E_READ, "%s: cannot read: %s", path, strerror(errno));
        *hash = XXH3_128bits_digest(state);
    }
    if (f) fclose(f);
    XXH3_freeState(state);
    return r;
}

/* What is measured is the same work only when it makes the same bytes. */
static vxs_result require_same_bytes(bench_work *w, bench_job *job, uint32_t run, message *m)
{
    XXH128_hash_t hash;
    char          name[256];
    vxs_result    r = hash_file(w->asset, &hash, m);
    if (r != VXS_OK) return r;
    if (!run) job->asset_hash = hash;
    if (XXH128_isEqual(hash, job->asset_hash)) return VXS_OK;
    w->outputs_differ = 1;
    return fail(m, VXS_E_READ, "bake of %s: run %u of %u wrote other bytes than run 1",
                bench_cell_name(name, sizeof name, w->result, job->cell), run + 1, w->o->runs);
}

static vxs_result compare_once(bench_work *w, bench_job *job, uint32_t run, double *seconds, message *m)
{
    const bench_options *o = w->o;
    char                 points[16], filters[BENCH_FILTERS_MAX][16];
    const char          *arguments[2 * BENCH_FILTERS_MAX + 16] = {"vxs", "compare", "--json", w->report, "--points", points};
    size_t               count                                 = 6;
    enum { FOUND_UNEXPLAINED = 1 };
    snprintf(points, sizeof points, "%u", o->points);
    for (size_t n = 0; n < o->filter_count; n++) {
        snprintf(filters[n], sizeof filters[n], "%u", o->filters_px[n]);
        arguments[count++] = "--filter";
        arguments[count++] = filters[n];
    }
    if (o->scene_name) arguments[count++] = "--scene";
    if (o->scene_name) arguments[count++] = o->scene_name;
    arguments[count++] = "--";
    arguments[count++] = job->scene_path;
    arguments[count++] = w->asset;

    vxs_result r = run_child(w, job, arguments, FOUND_UNEXPLAINED, seconds, m);
    return r == VXS_OK ? bench_take_compare(job, run, o->runs, w->report, m) : r;
}

static vxs_result run_once(bench_work *w, bench_job *job, uint32_t run, message *m)
{
    double     compare_seconds = 0;
    vxs_result r               = bake_once(w, job, run, m);
    if (r == VXS_OK) r = require_same_bytes(w, job, run, m);
    if (r == VXS_OK && w->o->points) r = compare_once(w, job, run, &compare_seconds, m);
    job->seconds = job_row(job, ROW_WALL, w->o->runs)[run] + compare_seconds;
    return r;
}

/* Rounds --------------------------------------------------------------------------------------------------------------------- */

/* How long a job takes: as long as the last time, or by its weight among those that ran. */
static double expected_seconds(const bench_work *w, const bench_job *job)
{
    double seconds = 0, weight = 0;
    for (size_t n = 0; n < w->result->cell_count && !job->seconds; n++) {
        if (!w->jobs[n].seconds) continue;
        seconds += w->jobs[n].seconds;
        weight += w->jobs[n].weight;
    }
    return job->seconds ? job->seconds : weight ? job->weight * seconds / weight : 0;
}

static void show_progress(const bench_work *w, uint32_t run, size_t at)
{
    if (!w->o->progress) return;
    double round_seconds = 0, left_seconds = 0;
    char   name[256];
    for (size_t n = 0; n < w->result->cell_count; n++) {
        double seconds = expected_seconds(w, &w->jobs[n]);
        round_seconds += seconds;
        if (n >= at) left_seconds += seconds;
    }
    double spent = clock_seconds() - w->since;
    double left  = left_seconds + (w->o->runs - run - 1) * round_seconds;
    progress_clear(); /* what comes may take long: it is named even when the last one took no time */
    progress_share(1, left > 0 ? spent / (spent + left) : 0, w->since, "run %u of %u: %s", run + 1, w->o->runs,
                   bench_cell_name(name, sizeof name, w->result, &w->result->cells[at]));
}

static vxs_result run_rounds(bench_work *w, message *m)
{
    vxs_result r = VXS_OK;
    w->since     = clock_seconds();
    for (uint32_t run = 0; run < w->o->runs && r == VXS_OK; run++)
        for (size_t n = 0; n < w->result->cell_count && r == VXS_OK; n++) {
            show_progress(w, run, n);
            r = run_once(w, &w->jobs[n], run, m);
        }
    progress_clear();
    return r;
}

static void take_spreads(const bench_job *job, uint32_t runs)
{
    bench_cell *c          = job->cell;
    c->wall_seconds        = spread_of(job_row(job, ROW_WALL, runs), runs);
    c->total_seconds       = spread_of(job_row(job, ROW_TOTAL, runs), runs);
    c->maps_to_dag_seconds = spread_of(job_row(job, ROW_MAPS_TO_DAG, runs), runs);
    for (uint32_t n = 0; n < c->stage_count; n++) c->stages[n].seconds = spread_of(job_row(job, ROW_STAGE + (int)n, runs), runs);
    for (uint32_t n = 0; n < c->lookup_count; n++)
        c->lookups[n].nanoseconds = spread_of(job_row(job, ROW_LOOKUP + (int)n, runs), runs);
    if (c->lookup_count) c->lookups[0].ray_nanoseconds = spread_of(job_row(job, ROW_RAY, runs), runs);
}

/* The whole ------------------------------------------------------------------------------------------------------------------ */

static vxs_result describe(const bench_options *o, bench_result *result, message *m)
{
    char   started[32];
    time_t now = time(NULL);
    strftime(started, sizeof started, "%Y-%m-%dT%H:%M:%SZ", gmtime(&now));
    result->vxs     = strdup(VXS_VERSION);
    result->started = strdup(started);
    result->runs    = o->runs;
    result->points  = o->points;
    if (!machine_describe(&result->machine) || !result->vxs || !result->started) return fail(m, VXS_E_MEMORY, "out of memory");
    return VXS_OK;
}

static vxs_result run_in_folder(bench_work *w, message *m)
{
    vxs_result r = work_folder_make(&w->folder, m);
    if (r == VXS_OK) {
        w->asset  = work_folder_file(w->folder, "asset.vxs");
        w->report = work_folder_file(w->folder, "report.json");
        w->errors = work_folder_file(w->folder, "errors.txt");
        r         = w->asset && w->report && w->errors ? run_rounds(w, m) : fail(m, VXS_E_MEMORY, "out of memory");
    }
    work_folder_remove(w->folder);
    free(w->asset);
    free(w->report);
    free(w->errors);
    return r;
}

vxs_result bench_run(const bench_options *o, bench_result *result, int *outputs_differ, message *m)
{
    bench_work w = {.o = o, .result = result};
    vxs_result r = describe(o, result, m);
    if (r == VXS_OK) r = bench_jobs_make(&w.jobs, result, o, m);
    if (r == VXS_OK) {
        interrupts_hold(&w.signals);
        r = run_in_folder(&w, m);
        interrupts_release(&w.signals);
    }
    for (size_t n = 0; n < result->cell_count && r == VXS_OK; n++) take_spreads(&w.jobs[n], o->runs);
    bench_jobs_free(w.jobs, result->cell_count);
    *outputs_differ = w.outputs_differ;
    return r;
}

void bench_cell_free(bench_cell *cell)
{
    free(cell->scene);
    json_decref(cell->options);
    free(cell->key);
    free(cell->light);
    *cell = (bench_cell){0};
}

void bench_result_free(bench_result *result)
{
    for (size_t n = 0; n < result->cell_count; n++) bench_cell_free(&result->cells[n]);
    free(result->cells);
    free(result->vxs);
    free(result->started);
    machine_free(&result->machine);
    *result = (bench_result){0};
}
