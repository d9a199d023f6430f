/* Runs of the library; see bake_run.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/library/bake_run.h"

#include <errno.h>
#include <fenv.h>
#include <stdlib.h>

#include "baker/bake/bake.h"
#include "baker/base/clock.h"
#include "baker/base/parallel.h"
#include "baker/library/array_scene.h"
#include "runtime/vxs.h"

/* progress and log ------------------------------------------------------------------------------------------------------------ */

static void tell_progress(bake_run *run, double seconds_left, const char *doing)
{
    const vxs_bake_options *asked = &run->options.asked;
    vxs_bake_progress       now   = {.share = run->share, .seconds_left = seconds_left, .doing = doing};
    if (asked->progress && asked->progress(asked->user, &now)) run_control_cancel(&run->run_control);
}

static void say(void *user, const char *doing)
{
    tell_progress(user, -1, doing);
}

static void share(void *user, double share, double since, const char *doing)
{
    bake_run *run   = user;
    double    spent = clock_seconds() - since - run->held_seconds;
    run->share      = share;
    tell_progress(run, share > 0 ? spent / share * (1 - share) : -1, doing);
}

void bake_run_log(const bake_run *run, vxs_severity severity, const char *text)
{
    const vxs_bake_options *asked = &run->options.asked;
    if (asked->log) asked->log(severity, text, asked->user);
}

vxs_result bake_run_end(const bake_run *run, vxs_result result)
{
    if (result != VXS_OK) bake_run_log(run, VXS_SEVERITY_ERROR, run->m.error[0] ? run->m.error : vxs_result_text(result));
    return result;
}

static void log_warning(vxs_severity severity, const char *text, void *user)
{
    bake_run_log(user, severity, text);
}

/* ----------------------------------------------------------------------------------------------------------------------------- */

/* The nearest error number of the system, whose text names the cause in messages. */
static int error_of(vxs_result result)
{
    return result == VXS_OK ? 0 : result == VXS_E_MEMORY ? ENOMEM : result == VXS_E_NO_FILE ? ENOENT : EIO;
}

static uint64_t size_of_file(void *user, const char *name)
{
    const vxs_bake_files *files = user;
    return files->size(files->user, name);
}

static int read_file(void *user, const char *name, void *bytes, size_t size_bytes)
{
    const vxs_bake_files *files = user;
    return error_of(files->read(files->user, name, bytes, size_bytes));
}

static int write_file(void *user, const char *name, const void *bytes, size_t size_bytes)
{
    const vxs_bake_files *files = user;
    return error_of(files->write(files->user, name, bytes, size_bytes));
}

/* Check that the output is no input, and can be written. */
static vxs_result check_output(bake_run *run)
{
    const vxs_bake_options *asked = &run->options.asked;
    bake_options           *o     = &run->options.o;
    vxs_result              r     = VXS_OK;
    if (run->m.access) return VXS_OK;
    if (asked->output_path) r = run_files_add_output("output_path", asked->output_path, &run->m);
    if (r == VXS_OK) r = bake_add_folder(o, "resume_path", &run->m);
    if (r == VXS_OK && asked->scene_path) r = run_files_check_input(asked->scene_path, "scene_path", &run->m);
    return r == VXS_OK && !o->if_changed ? bake_check_outputs(o, &run->m) : r;
}

vxs_result bake_run_init(bake_run *run, const vxs_bake_options *options, int lights)
{
    *run         = (bake_run){.share = -1};
    run->m       = (run_context){.log = log_warning, .log_user = run, .files = &run->files};
    run->watch   = (run_watch){.say = say, .share = share, .user = run};
    vxs_result r = asked_options_init(&run->options, options, lights, &run->m);
    run->m.force = run->options.asked.replace != 0;
    if (r == VXS_OK && run->options.asked.files) {
        run->callers  = *run->options.asked.files;
        run->access   = (file_access){size_of_file, read_file, write_file, &run->callers};
        run->m.access = &run->access;
        run->m.files  = NULL; /* tracks files of the system */
    }
    run_control_init(&run->run_control);
    if (r != VXS_OK) return r;
    run->options.o.watch = &run->watch;
    if (run->options.asked.scene) {
        /* use the options that the scene was opened with */
        const vxs_bake_scene *opened = run->options.asked.scene;
        const bake_options   *of     = &opened->options.o;
        bake_options         *o      = &run->options.o;
        o->prepared                  = (bake_scene *)&opened->scene; /* read only */
        o->scene_path                = of->scene_path;
        o->closed                    = of->closed;
        free(o->scene.exclude.items);
        free(o->scene.include.items);
        o->scene = of->scene;
    }
    return lights ? check_output(run) : VXS_OK;
}

vxs_result bake_run_guarded(bake_run *run, vxs_result (*work)(bake_run *run, void *user), void *user)
{
    fenv_t callers;
    fegetenv(&callers);
    fesetenv(FE_DFL_ENV);
    thread_pool *pool = parallel_keep_threads();
    run_control_enter(&run->run_control);
    vxs_result r = run_control_is_cancelled() ? fail(&run->m, VXS_E_INTERRUPTED, "given up before it was begun") : work(run, user);
    run_control_leave(&run->run_control);
    parallel_end_threads(pool);
    fesetenv(&callers);
    return r;
}

vxs_result bake_run_open_scene(bake_run *run, bake_scene *s)
{
    const bake_options *o   = &run->options.o;
    bake_context        ctx = {.run          = &run->m,
                               .threads      = o->threads,
                               .watch        = o->watch,
                               .subject      = o->scene_path,
                               .memory_bytes = o->memory_bytes,
                               .begun        = clock_seconds()};
    vxs_result          r;
    run->m.memory_bytes = o->memory_bytes;
    if (run->options.asked.arrays) {
        r = scene_from_arrays(&s->scene, run->options.asked.arrays, &run->m);
        if (r == VXS_OK) r = scene_fingerprint_take(&s->fingerprint, &s->scene, &run->m);
    } else
        r = bake_scene_read(s, o, NULL, &ctx);
    if (r == VXS_OK) r = bake_scene_find_casters(s, o, &ctx);
    stage_begin(&ctx, STAGE_NONE);
    return r == VXS_OK ? context_check(&ctx) : r;
}

void bake_run_free(bake_run *run)
{
    if (run->options.o.prepared) run->options.o.scene = (scene_choice){0}; /* owned by the scene */
    asked_options_free(&run->options);
    run_files_free(&run->files);
    run_free(&run->m);
    run_control_free(&run->run_control);
}
