/* What scenes and jobs of the library share: options, messages, and a run control, for work on a thread of its own or of the caller's.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BAKE_RUN_H
#define BAKE_RUN_H

#include "baker/bake/bake_scene.h"
#include "baker/base/run_control.h"
#include "baker/files/run_files.h"
#include "baker/library/asked_options.h"

struct vxs_bake_scene {
    bake_scene    scene;
    asked_options options; /* what was asked for it; texts are the caller's */
};

/* It stays where it is. */
typedef struct bake_run {
    asked_options options;
    message       m;
    run_files     files;
    run_watch     watch;
    run_control   run_control;
    double        share;        /* told last; below 0: none */
    double        held_seconds; /* that the run was paused */
} bake_run;

/* Check options, and outputs where lights are asked for.
 * run  [out] released with bake_run_free, whatever is returned
 * Returns VXS_OK, VXS_E_ARGUMENT, VXS_E_MEMORY, VXS_E_WRITE. */
vxs_result bake_run_init(bake_run *run, const vxs_bake_options *options, int lights);

/* Work under the run control, with the floating point that bytes are promised for, which the thread has back afterwards. */
vxs_result bake_run_guarded(bake_run *run, vxs_result (*work)(bake_run *run, void *user), void *user);

/* Read the scene that was asked for, and find its casters. */
vxs_result bake_run_open_scene(bake_run *run, bake_scene *s);

void bake_run_free(bake_run *run);

/* error  [VXS_BAKE_ERROR_BYTES] out, or NULL
 * Returns the result. */
vxs_result bake_run_error(const bake_run *run, vxs_result result, char *error);

#endif
