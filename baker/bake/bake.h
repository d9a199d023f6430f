/* Bakes a scene into a .vxs file: the list of stages.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BAKE_H
#define BAKE_H

#include "baker/bake/bake_options.h"
#include "baker/bake/bake_report.h"

/* Called when the file is written. It may read the casters and the asset's bytes, and may take the bytes. Its time is not
 * counted. */
typedef struct bake_observer {
    vxs_result (*on_complete)(void *user, const bake_options *o, const casters *c, vxs_bytes *file, run_context *m);
    void *user;
} bake_observer;

/* Check before long work that the asset and the page can be written. With if_changed, bake() checks later, when it knows that it
 * writes: an output that is kept may be read-only.
 * Returns what output_file_check returns. */
vxs_result bake_check_outputs(const bake_options *o, run_context *m);

/* Declare the folder of --resume, if there is one (run_files.h).
 * option  its name in messages */
vxs_result bake_add_folder(const bake_options *o, const char *option, run_context *m);

/* Bake a scene. The output is written completely or not at all; returns VXS_E_INTERRUPTED if the run is cancelled before.
 * observer  NULL: none
 * report    [out] zero it first; released with bake_report_free, whatever is returned.
 * Same scene and options, same bytes, at any number of threads. */
vxs_result bake(const bake_options *o, const bake_observer *observer, bake_report *report, run_context *m);

/* Only plan: fill what is known before the work, above all the plan. */
vxs_result bake_plan_only(const bake_options *o, bake_report *report, run_context *m);

#endif
