/* vxs bake.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <stdio.h>
#include <unistd.h>

#include "baker/command/commands.h"
#include "baker/files/output_file.h"
#include "baker/options/bake_arguments.h"
#include "baker/report/bake_page.h"
#include "baker/report/report.h"

static vxs_result run(bake_arguments *a, bake_report *report, message *m)
{
    bake_options *o = &a->o;
    int to_stdout   = is_standard_output(o->output_path) || is_standard_output(a->json_path) || is_standard_output(a->page_path);
    vxs_result r;

    if (a->json_path && (r = output_file_check(a->json_path, o->scene_path, m)) != VXS_OK) return r;
    if (a->page_path && (r = output_file_check(a->page_path, o->scene_path, m)) != VXS_OK) return r;
    o->progress = isatty(STDERR_FILENO);
    if ((r = bake(o, report, m)) != VXS_OK) return r;
    report_print(to_stdout ? stderr : stdout, o, report); /* what goes to standard output stays alone there */
    if (a->json_path && (r = report_write_json(a->json_path, o, report, m)) != VXS_OK) return r;
    if (!a->page_path) return VXS_OK;
    /* names that were not there before, and are one file now: through a linked folder */
    if ((r = output_file_check(a->page_path, is_standard_output(o->output_path) ? NULL : o->output_path, m)) != VXS_OK) return r;
    return bake_page_write(a->page_path, o, report, m);
}

int cmd_bake(int argc, char **argv)
{
    bake_arguments a;
    bake_report    report = {0};
    message        m      = {0};
    vxs_result     r      = bake_arguments_parse(&a, "bake", "SCENE -o OUT.vxs [options]",
                                                 "Bake the shadows of a glTF scene into a .vxs file.", 1, argc, argv, &m);
    if (r == VXS_OK && !a.help_shown) r = run(&a, &report, &m);
    bake_report_free(&report);
    bake_arguments_free(&a);
    return command_end(&m, r);
}
