/* From a scene to a .vxs file: the list of stages.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BAKE_H
#define BAKE_H

#include "baker/bake/bake_report.h"
#include "baker/bake/bake_scene.h"

/* What may look at the casters and the asset's bytes when the file is there, and may take these; its time is no part of the bake's. */
typedef struct bake_observer {
    vxs_result (*look)(void *user, const bake_options *o, const casters *c, vxs_bytes *file, message *m);
    void *user;
} bake_observer;

/* Find out before long work that the asset and the page can be written. With if_changed a bake asks itself, once it knows that it writes:
 * what stays as it is may be read-only.
 * Returns what output_file_check returns. */
vxs_result bake_check_outputs(const bake_options *o, message *m);

/* Declare the folder of --resume, where there is one (run_files.h).
 * option  what messages call it */
vxs_result bake_add_folder(const bake_options *o, const char *option, message *m);

/* Bake a scene. The output is complete under its name, or untouched; VXS_E_INTERRUPTED when the run is given up before.
 * observer  NULL: nobody looks
 * report    [out] zero it first; released with bake_report_free, whatever is returned.
 * Same scene and options, same bytes, at any thread count. */
vxs_result bake(const bake_options *o, const bake_observer *observer, bake_report *report, message *m);

/* Only what would be done: fills what is known before the work, the plan above all. */
vxs_result bake_plan_only(const bake_options *o, bake_report *report, message *m);

#endif
