/* Measuring bakes and lookups; see bench.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/bench/bench.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>
#include <xxhash.h>

#include "baker/base/clock.h"
#include "baker/base/version.h"
#include "baker/command/process/process.h"
#include "baker/files/foreign_file.h"
#include "baker/files/input_file.h"
#include "baker/files/json_file.h"
#include "baker/lab/bench/bench_text.h"
#include "baker/lab/bench/machine.h"

typedef struct bench_work {
    const bench_options *o;
    json_t              *result;
    bench_job           *jobs; /* [job_count] */
    size_t               job_count;
    int                 *inputs; /* [scene] copies of pipes, see keep_pipes; owned */
    children             children;
    double               since; /* when the first run began */
    int                  outputs_differ;
} bench_work;

/* Children --------------------------------------------------------------------------------------------------------------------- */

/* Run a command. Its exit status must be 0 or `accepted`. */
static vxs_result run_child(bench_work *w, const bench_job *job, const char *const *arguments, int accepted, double *seconds,
                            run_context *m)
{
    char       name[256], text[512];
    int        status;
    vxs_result r = child_run(&w->children, arguments, job->input, seconds, &status, m);
    if (r != VXS_OK || !status || status == accepted) return r;

    /* the error that the child printed: its last line */
    static const char begin[] = "vxs: error: ";
    char              line[512];
    FILE             *f = fopen(w->children.errors, "re");
    text[0]             = 0;
    while (f && fgets(line, sizeof line, f))
        if (!strncmp(line, begin, strlen(begin))) strcpy(text, line + strlen(begin));
    text[strcspn(text, "\n")] = 0;
    if (f) fclose(f);

    if (!text[0] && status < 0) snprintf(text, sizeof text, "ended by signal %d, %s", -status, strsignal(-status));
    if (!text[0]) snprintf(text, sizeof text, "exit status %d", status);

    static const vxs_result results[] = {VXS_E_ARGUMENT, VXS_E_READ, VXS_E_WRITE, VXS_E_NO_CASTER, VXS_E_MEMORY, VXS_E_INTERRUPTED};
    r                                 = VXS_E_MEMORY; /* it crashed, or was killed */
    for (size_t n = 0; n < sizeof results / sizeof *results; n++)
        if (exit_status(results[n]) == status) r = results[n];
    return fail(m, r, "%s of %s: %s", arguments[1], bench_cell_name(name, sizeof name, w->result, job->cell), text);
}

/* Steps of a run --------------------------------------------------------------------------------------------------------------- */

/* All runs must write the same bytes; else they did not do the same work. */
static vxs_result require_same_bytes(bench_work *w, bench_job *job, uint32_t run, run_context *m)
{
    char        name[256], bytes[1 << 16];
    const char *path = w->children.asset;
    FILE       *f    = fopen(path, "rbe");
    uint64_t    hash = 0;
    if (!f && errno == ENOMEM) return fail(m, VXS_E_MEMORY, "out of memory while reading %s", path);
    for (size_t count; f && (count = fread(bytes, 1, sizeof bytes, f));) hash = XXH3_64bits_withSeed(bytes, count, hash);
    vxs_result r = f && !ferror(f) ? VXS_OK : fail(m, VXS_E_READ, "%s: cannot read: %s", path, strerror(errno));
    if (f) fclose(f);
    if (r != VXS_OK) return r;
    if (!run) job->asset_hash = hash;
    if (hash == job->asset_hash) return VXS_OK;
    w->outputs_differ = 1;
    return fail(m, VXS_E_READ, "bake of %s: run %u of %u wrote other bytes than run 1",
                bench_cell_name(name, sizeof name, w->result, job->cell), run + 1, w->o->runs);
}

static vxs_result compare_once(bench_work *w, const bench_job *job, double *seconds, run_context *m)
{
    const bench_options *o = w->o;
    char                 points[16], widths[FILTERS_MAX][16];
    const char          *arguments[2 * FILTERS_MAX + 16] = {"vxs", "compare", "--json", w->children.report, "--points", points};
    size_t               count                           = 6;
    enum { FOUND_UNEXPLAINED = 1 };
    snprintf(points, sizeof points, "%u", o->points);
    for (size_t n = 0; n < o->filter_count; n++) {
        snprintf(widths[n], sizeof widths[n], "%d", o->filters[n].width_px);
        arguments[count++] = o->filters[n].is_smooth ? "--smooth" : "--filter";
        arguments[count++] = widths[n];
    }
    if (o->scene_name) arguments[count++] = "--scene";
    if (o->scene_name) arguments[count++] = o->scene_name;
    if (o->allow_outside) arguments[count++] = "--allow-outside";
    arguments[count++] = "--other-scene"; /* no check of the scene: if the scene changes, the next bake's bytes differ */
    arguments[count++] = "--";
    arguments[count++] = job->scene_path;
    arguments[count++] = w->children.asset;

    return run_child(w, job, arguments, FOUND_UNEXPLAINED, seconds, m);
}

/* Rounds ----------------------------------------------------------------------------------------------------------------------- */

static void show_progress(const bench_work *w, uint32_t run, size_t at)
{
    if (!w->o->progress) return;
    double round_seconds = 0, left_seconds = 0;
    char   name[256];
    for (size_t n = 0; n < w->job_count; n++) {
        /* Expected time of a job: that of its last run, or by its weight relative to jobs that ran. */
        double known = 0, weight = 0;
        for (size_t k = 0; k < w->job_count && !w->jobs[n].seconds; k++) {
            if (!w->jobs[k].seconds) continue;
            known += w->jobs[k].seconds;
            weight += w->jobs[k].weight;
        }
        double seconds = w->jobs[n].seconds ? w->jobs[n].seconds : weight ? w->jobs[n].weight * known / weight : 0;

        round_seconds += seconds;
        if (n >= at) left_seconds += seconds;
    }
    double spent = clock_seconds() - w->since;
    double left  = left_seconds + (w->o->runs - run - 1) * round_seconds;
    progress_clear(); /* the next step may take long: show its name, even if the last step took no time */
    progress_share(w->o->progress, left > 0 ? spent / (spent + left) : 0, w->since, "run %u of %u: %s", run + 1, w->o->runs,
                   bench_cell_name(name, sizeof name, w->result, w->jobs[at].cell));
}

/* Scenes from pipes ------------------------------------------------------------------------------------------------------------ */

/* Read a GLB, or text that may be glTF, completely. For other files the first bytes suffice: the bake rejects them. */
static uint64_t wanted_bytes(void *user, const uint8_t *first, size_t size_bytes)
{
    (void)user;
    return may_be_gltf(first, size_bytes) ? UINT64_MAX : 0;
}

/* Each run reads its scene again, but a pipe can be read only once: copy it to memory. Its descriptor in w->inputs stays -1 if the
 * scene is a file, or cannot be read, which its bake will report. */
static vxs_result keep_pipes(bench_work *w, run_context *m)
{
    w->inputs = malloc(w->o->scenes.count * sizeof *w->inputs);
    if (!w->inputs) return fail(m, VXS_E_MEMORY, "out of memory");
    for (size_t n = 0; n < w->o->scenes.count; n++) w->inputs[n] = -1;
    for (size_t n = 0; n < w->o->scenes.count; n++) {
        const char *path = w->o->scenes.items[n];
        struct stat status;
        uint8_t    *bytes;
        size_t      size_bytes, done = 0;
        if (!is_standard_input(path) && (stat(path, &status) || !S_ISFIFO(status.st_mode))) continue;
        vxs_result r = input_read(&bytes, &size_bytes, path, UINT32_MAX, &(input_head){wanted_bytes, NULL}, m);
        if (r != VXS_OK) return r;
        int kept = w->inputs[n] = memfd_create("scene", MFD_CLOEXEC);
        for (ssize_t wrote = 1; kept >= 0 && wrote > 0 && done < size_bytes; done += (size_t)(wrote > 0 ? wrote : 0))
            wrote = write(kept, bytes + done, size_bytes - done);
        free(bytes);
        if (done < size_bytes) return fail(m, VXS_E_MEMORY, "out of memory for a copy of '%s'", input_name(path));
    }
    return VXS_OK;
}

/* The whole -------------------------------------------------------------------------------------------------------------------- */

/* The data known before the first run. NULL when out of memory. */
static json_t *describe(const bench_options *o)
{
    char          started[32];
    time_t        now     = time(NULL);
    json_t       *result  = NULL;
    bench_machine machine = {0};
    strftime(started, sizeof started, "%Y-%m-%dT%H:%M:%SZ", gmtime(&now));
    if (machine_describe(&machine))
        result = json_pack("{s:s, s:s, s:{s:o, s:I, s:I, s:o, s:n}, s:I, s:I, s:[]}", "vxs", VXS_VERSION, "started", started,
                           "machine", "processor", json_text(machine.processor), "cores", (json_int_t)machine.cores, "memory_bytes",
                           (json_int_t)machine.memory_bytes, "system", json_text(machine.system), "renderer", "runs",
                           (json_int_t)o->runs, "points", (json_int_t)o->points, "cells");
    machine_free(&machine);
    return result;
}

vxs_result bench_run(const bench_options *o, json_t **result, int *outputs_differ, run_context *m)
{
    bench_work w = {.o = o};
    *result      = NULL;
    vxs_result r = keep_pipes(&w, m);
    if (r != VXS_OK) goto done;
    r = children_begin(&w.children, m); /* from now on signals wait */
    if (r == VXS_OK && !(w.result = describe(o))) r = fail(m, VXS_E_MEMORY, "out of memory");
    if (r == VXS_OK) r = bench_jobs_make(&w.jobs, &w.job_count, json_object_get(w.result, "cells"), o, w.inputs, &w.children, m);
    if (r == VXS_OK) {
        w.since = clock_seconds();
        for (uint32_t run = 0; run < w.o->runs && r == VXS_OK; run++)
            for (size_t n = 0; n < w.job_count && r == VXS_OK; n++) {
                show_progress(&w, run, n);

                json_t *bake = NULL, *compare = NULL;
                double  bake_seconds = 0, compare_seconds = 0;
                r = run_child(&w, &w.jobs[n], w.jobs[n].arguments, 0, &bake_seconds, m);
                if (r == VXS_OK) r = json_read(&bake, w.children.report, m);
                if (r == VXS_OK) r = require_same_bytes(&w, &w.jobs[n], run, m);
                if (r == VXS_OK && w.o->points) r = compare_once(&w, &w.jobs[n], &compare_seconds, m);
                if (r == VXS_OK && w.o->points) r = json_read(&compare, w.children.report, m);
                if (r == VXS_OK) {
                    json_object_set(json_object_get(w.result, "machine"), "renderer", json_object_get(bake, "renderer"));
                    json_array_append_new(w.jobs[n].runs, bench_cell_of_run(w.jobs[n].cell, bake, compare, bake_seconds));
                }
                w.jobs[n].seconds = bake_seconds + compare_seconds;
                json_decref(bake);
                json_decref(compare);
            }
        progress_clear();
    }
    children_end(&w.children);

    for (size_t n = 0; n < w.job_count && r == VXS_OK; n++)
        json_array_set_new(json_object_get(w.result, "cells"), n, bench_cell_of_runs(json_incref(w.jobs[n].runs)));
    bench_jobs_free(w.jobs, w.job_count);
    *outputs_differ = w.outputs_differ;
    if (r != VXS_OK) json_decref(w.result);
    *result = r == VXS_OK ? w.result : NULL;
done:
    for (size_t n = 0; w.inputs && n < o->scenes.count; n++)
        if (w.inputs[n] >= 0) close(w.inputs[n]);
    free(w.inputs);
    return r;
}
