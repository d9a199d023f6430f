/* vxs plan.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <stdio.h>

#include "baker/command/commands.h"
#include "baker/command/options/bake_arguments.h"
#include "baker/command/report/plan_text.h"
#include "baker/command/report/report.h"

static vxs_result run(void *command, run_context *m)
{
    bake_arguments *a      = command;
    bake_report     report = {0};
    vxs_result      r      = bake_arguments_check(a, m);
    if (r == VXS_OK && (r = bake_plan_only(&a->o, &report, m)) == VXS_OK) {
        FILE *to = report_stream(m, is_standard_output(a->json_path));
        if (to) (report.unchanged ? unchanged_print : m->verbose ? plan_print : plan_summary_print)(to, &a->o, &report);
        if (a->json_path) r = (report.unchanged ? unchanged_write_json : plan_write_json)(a->json_path, &a->o, &report, m);
    }
    bake_report_free(&report);
    return r;
}

int cmd_plan(int argc, char **argv)
{
    bake_arguments a;
    bake_arguments_init(&a, "plan", "SCENE [options of bake]", "Say what a bake would do, what it would leave out, and why.", 0);
    return command_run(&a.line, argc, argv, run, &a);
}
