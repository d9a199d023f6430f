/* vxs plan.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <stdio.h>

#include "baker/command/commands.h"
#include "baker/files/output_file.h"
#include "baker/options/bake_arguments.h"
#include "baker/report/plan_text.h"

static vxs_result run(bake_arguments *a, bake_report *report, message *m)
{
    const char *const outputs[] = {a->o.output_path, a->json_path, a->page_path};
    vxs_result        r;

    for (int n = 0; n < 3; n++)
        if (outputs[n] && (r = output_file_check(outputs[n], a->o.scene_path, m)) != VXS_OK) return r;
    if ((r = bake_plan_only(&a->o, report, m)) != VXS_OK) return r;
    plan_print(is_standard_output(a->json_path) ? stderr : stdout, &a->o, report);
    return a->json_path ? plan_write_json(a->json_path, &a->o, report, m) : VXS_OK;
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
