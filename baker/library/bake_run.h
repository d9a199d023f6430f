/* State shared by scenes and jobs of the library: options, messages, and a run control. The work runs on a separate thread or on
 * the caller's.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BAKE_RUN_H
#define BAKE_RUN_H

#include "baker/bake/bake_options.h"
#include "baker/base/run_control.h"
#include "baker/files/file_access.h"
#include "baker/files/run_files.h"
#include "baker/library/asked_options.h"

struct vxs_bake_scene {
    bake_scene    scene;
    asked_options options; /* options it was opened with; texts belong to the caller */
};

/* Must not move. */
typedef struct bake_run {
    asked_options  options;
    run_context    m;
    run_files      files;
    vxs_bake_files callers; /* the options' files, if they are the caller's; */
    file_access    access;  /* calls them */
    run_watch      watch;
    run_control    run_control;
    double         share;        /* last reported share; below 0: none */
    double         held_seconds; /* total time of pauses */
} bake_run;

/* Check the options.
 * run     [out] released with bake_run_free, whatever is returned
 * lights  1: check also options of lights and outputs
 * Returns VXS_OK, VXS_E_ARGUMENT, VXS_E_MEMORY, VXS_E_WRITE. */
vxs_result bake_run_init(bake_run *run, const vxs_bake_options *options, int lights);

/* Run `work` under the run control, in the floating-point mode that guarantees equal bytes. The thread's mode is restored
 * afterwards. */
vxs_result bake_run_guarded(bake_run *run, vxs_result (*work)(bake_run *run, void *user), void *user);

/* Read the scene of the options, and find its casters. */
vxs_result bake_run_open_scene(bake_run *run, bake_scene *s);

void bake_run_free(bake_run *run);

/* Pass a text to the log callback of the options, if there is one. */
void bake_run_log(const bake_run *run, vxs_severity severity, const char *text);

/* Log the reason of a failure. Call it once for each result that a function of the library returns. Returns the result. */
vxs_result bake_run_end(const bake_run *run, vxs_result result);

#endif
