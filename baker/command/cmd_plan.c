/* vxs plan.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <stdio.h>
#include <string.h>

#include "baker/files/output_file.h"
#include "baker/options/bake_arguments.h"
#include "baker/report/plan_text.h"

static vxs_result run(bake_arguments *a, bake_report *report, message *m)
{
    bake_options *o = &a->o;
    vxs_result    r = VXS_OK;
    if (o->output_path) r = output_file_check(o->output_path, o->scene_path, m);
    if (r == VXS_OK && a->json_path) r = output_file_check(a->json_path, o->scene_path, m);
    if (r == VXS_OK && a->page_path) r = output_file_check(a->page_path, o->scene_path, m);
    if (r == VXS_OK) r = bake_plan_only(o, report, m);
    if (r == VXS_OK) plan_print(a->json_path && !strcmp(a->json_path, "-") ? stderr : stdout, o, report);
    if (r == VXS_OK && a->json_path) r = plan_write_json(a->json_path, o, report, m);
    return r;
}

int cmd_plan(int argc, char **argv)
{
    bake_arguments a;
    bake_report    report = {0};
    message        m      = {0};
    vxs_result     r      = bake_arguments_parse(&a, "plan", "SCENE [options of bake]",
                                                 "Say what a bake would do and what it would leave out, and why.", 0, argc, argv, &m);
    if (r == VXS_OK && !a.help_shown) r = run(&a, &report, &m);
    bake_report_free(&report);
    bake_arguments_free(&a);
    return command_end(&m, r);
}
