/* The library's functions; see vxs_bake.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/vxs_bake.h"

#include <math.h>
#include <stdlib.h>

#include "baker/bake/bake.h"
#include "baker/base/clock.h"
#include "baker/base/threads.h"
#include "baker/library/bake_run.h"

void vxs_bake_bytes_free(vxs_bake_bytes *bytes)
{
    if (bytes) free(bytes->data);
    if (bytes) *bytes = (vxs_bake_bytes){0};
}

/* scenes ---------------------------------------------------------------------------------------------------------------------- */

static vxs_result open_scene(bake_run *run, void *user)
{
    return bake_run_open_scene(run, user);
}

vxs_result vxs_bake_scene_open(vxs_bake_scene **opened, const vxs_bake_options *options)
{
    bake_run        run;
    vxs_bake_scene *s = calloc(1, sizeof *s);
    vxs_result      r = bake_run_init(&run, options, 0);
    if (!s && r == VXS_OK) r = fail(&run.m, VXS_E_MEMORY, "out of memory for a scene");
    if (r == VXS_OK) r = bake_run_guarded(&run, open_scene, &s->scene);
    bake_run_end(&run, r);
    if (r == VXS_OK) {
        s->options         = run.options;
        s->options.o.watch = NULL;
        run.options        = (asked_options){0};
    } else {
        if (s) bake_scene_free(&s->scene);
        free(s);
    }
    *opened = r == VXS_OK ? s : NULL;
    bake_run_free(&run);
    return r;
}

void vxs_bake_scene_close(vxs_bake_scene *s)
{
    if (!s) return;
    bake_scene_free(&s->scene);
    asked_options_free(&s->options);
    free(s);
}

/* jobs ------------------------------------------------------------------------------------------------------------------------ */

struct vxs_bake_job {
    bake_run       run;
    vxs_bake_bytes file;
    os_mutex       lock;
    os_signal      ended;
    vxs_bake_state state; /* under the lock while the thread exists */
    vxs_result     result;
    int            has_thread; /* 1: the baking thread exists, running or paused */
    int            bad_budget; /* 1: the last call had an invalid budget */
    os_thread      thread;
    double         held_since;
};

static vxs_result take_file(void *user, const bake_options *o, const casters *c, vxs_bytes *file, run_context *m)
{
    vxs_bake_job *job = user;
    (void)o;
    (void)c;
    (void)m;
    job->file = (vxs_bake_bytes){file->data, file->size_bytes};
    *file     = (vxs_bytes){0};
    return VXS_OK;
}

/* Run the whole bake. */
static vxs_result bake_all(bake_run *run, void *user)
{
    bake_options  o        = run->options.o;
    bake_scene    own      = {0};
    bake_report   report   = {0};
    bake_observer observer = {take_file, user};
    vxs_result    r        = VXS_OK;
    if (run->options.asked.arrays) { /* a scene that is a file is read by bake(), which checks its lights first */
        r          = bake_run_open_scene(run, &own);
        o.prepared = &own;
    }
    if (r == VXS_OK) r = bake(&o, &observer, &report, &run->m);
    bake_report_free(&report);
    bake_scene_free(&own);
    return r;
}

static void work(vxs_bake_job *job)
{
    vxs_result r = bake_run_guarded(&job->run, bake_all, job);
    os_lock(&job->lock);
    job->result = bake_run_end(&job->run, r);
    job->state  = r == VXS_OK ? VXS_BAKE_DONE : VXS_BAKE_FAILED;
    if (r != VXS_OK) vxs_bake_bytes_free(&job->file);
    os_wake_all(&job->ended);
    os_unlock(&job->lock);
}

static void *work_on_thread(void *job)
{
    work(job);
    return NULL;
}

vxs_result vxs_bake_job_open(vxs_bake_job **job, const vxs_bake_options *options)
{
    vxs_bake_job *j = calloc(1, sizeof *j);
    *job            = NULL;
    bake_run   none;
    bake_run  *run = j ? &j->run : &none;
    vxs_result r   = bake_run_init(run, options, j != NULL);
    if (!j && r == VXS_OK) r = fail(&run->m, VXS_E_MEMORY, "out of memory for a job");
    if (bake_run_end(run, r) != VXS_OK) {
        bake_run_free(run);
        free(j);
        return r;
    }
    os_mutex_init(&j->lock);
    os_signal_init(&j->ended);
    *job = j;
    return VXS_OK;
}

static void join(vxs_bake_job *job)
{
    os_thread_join(job->thread);
    job->has_thread = 0;
}

/* Resume after a pause. */
static void go_on(vxs_bake_job *job)
{
    if (job->held_since > 0) job->run.held_seconds += clock_seconds() - job->held_since;
    run_control_resume(&job->run.run_control);
}

vxs_result vxs_bake_job_run(vxs_bake_job *job)
{
    job->bad_budget = 0;
    if (job->has_thread) {
        go_on(job);
        join(job);
    } else if (job->state == VXS_BAKE_MORE)
        work(job);
    return job->result;
}

/* Returns 1 if the job has ended before. */
static int wait_for(vxs_bake_job *job, double until)
{
    int late = 0;
    os_lock(&job->lock);
    while (job->state == VXS_BAKE_MORE && !late) late = !threads_wait_until(&job->ended, &job->lock, until);
    int ended = job->state != VXS_BAKE_MORE;
    os_unlock(&job->lock);
    return ended;
}

vxs_bake_state vxs_bake_step(vxs_bake_job *job, double budget_ms)
{
    const double longest_ms = 1e12;
    double       begun      = clock_seconds();
    job->bad_budget         = !(budget_ms > 0);
    if (job->bad_budget) {
        bake_run_log(&job->run, VXS_SEVERITY_ERROR, "budget_ms: expected more than 0");
        return VXS_BAKE_FAILED;
    }
    if (!job->has_thread && job->state != VXS_BAKE_MORE) return job->state;
    if (!HAS_THREADS) {
        work(job);
        return job->state;
    }
    if (job->has_thread)
        go_on(job);
    else {
        sigset_t before; /* all signals are blocked in the thread: they are for the program's own threads */
        threads_block_signals(&before);
        job->has_thread = os_thread_start(&job->thread, work_on_thread, job);
        threads_unblock_signals(&before);
        if (!job->has_thread) {
            job->state = VXS_BAKE_FAILED;
            job->result =
                bake_run_end(&job->run, fail(&job->run.m, VXS_E_MEMORY, "no thread could be started for a bake in steps"));
            return job->state;
        }
    }
    if (!wait_for(job, begun + 1e-3 * fmin(budget_ms, longest_ms))) {
        run_control_pause(&job->run.run_control);
        job->held_since = clock_seconds();
        if (!wait_for(job, 0)) return VXS_BAKE_MORE;
    }
    join(job);
    return job->state;
}

void vxs_bake_job_cancel(vxs_bake_job *job)
{
    run_control_cancel(&job->run.run_control);
}

vxs_result vxs_bake_job_result(const vxs_bake_job *job)
{
    return job->bad_budget ? VXS_E_ARGUMENT : job->result;
}

void vxs_bake_job_take(vxs_bake_job *job, vxs_bake_bytes *file)
{
    int is_done = !job->has_thread && job->state == VXS_BAKE_DONE;
    *file       = is_done ? job->file : (vxs_bake_bytes){0};
    if (is_done) job->file = (vxs_bake_bytes){0};
}

void vxs_bake_job_close(vxs_bake_job *job)
{
    if (!job) return;
    vxs_bake_job_cancel(job);
    job->run.options.asked.log = NULL;
    if (job->has_thread) {
        run_control_resume(&job->run.run_control);
        join(job);
    }
    vxs_bake_bytes_free(&job->file);
    os_signal_free(&job->ended);
    os_mutex_free(&job->lock);
    bake_run_free(&job->run);
    free(job);
}

/* one call -------------------------------------------------------------------------------------------------------------------- */

vxs_result vxs_bake(const vxs_bake_options *options, vxs_bake_bytes *file)
{
    vxs_bake_job *job;
    if (file) *file = (vxs_bake_bytes){0};
    vxs_result r = vxs_bake_job_open(&job, options);
    if (r != VXS_OK) return r;
    if (!file && !options->output_path)
        r = bake_run_end(&job->run, fail(&job->run.m, VXS_E_ARGUMENT, "expected an output_path, or somewhere to put the bytes"));
    else
        r = vxs_bake_job_run(job);
    if (file) vxs_bake_job_take(job, file);
    vxs_bake_job_close(job);
    return r;
}
