/* vxs bake.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <stdio.h>
#include <string.h>

#include "baker/command/bake_watch.h"
#include "baker/command/commands.h"
#include "baker/command/options/bake_arguments.h"
#include "baker/command/options/laboratory.h"
#include "baker/command/process/process.h"
#include "baker/command/report/report.h"

static vxs_result write_reports(const bake_arguments *a, const bake_page *page, const bake_report *report, run_context *m)
{
    const bake_options *o = &a->o;
    int   to_stdout = is_standard_output(o->output_path) || is_standard_output(a->json_path) || is_standard_output(o->page_path);
    FILE *to        = report_stream(m, to_stdout); /* keep the report out of standard output when an output goes there */
    vxs_result r;

    if (report->unchanged) {
        if (to) unchanged_print(to, o, report);
        return a->json_path ? unchanged_write_json(a->json_path, o, report, m) : VXS_OK;
    }
    if (o->parts) {
        if (to) part_print(to, o, report);
        return a->json_path ? part_write_json(a->json_path, o, report, m) : VXS_OK;
    }
    char size[32], plain[PLAIN_BYTES];
    if (to && a->watch && !m->verbose)
        fprintf(to, "%s: %s, %.2f s\n", plain_text(plain, o->output_path), size_text(size, report->file_bytes),
                report->total_seconds);
    else if (to)
        (m->verbose ? report_print : bake_summary_print)(to, o, report);
    if (a->json_path && (r = report_write_json(a->json_path, o, report, m)) != VXS_OK) return r;
    if (!o->page_path) return VXS_OK;
    return linked_laboratory.pages->write(o->page_path, page, o, report, m);
}

static vxs_result bake_once(void *command, run_context *m)
{
    bake_arguments   *a      = command;
    bake_report       report = {0};
    bake_page         page   = {0};
    const bake_pages *pages  = linked_laboratory.pages;
    bake_observer     drawn  = {pages ? pages->on_complete : NULL, &page};
    vxs_result        r      = bake_arguments_check(a, m);
    process_return_large();
    a->o.watch = progress_watch(m);
    if (r == VXS_OK) r = bake(&a->o, a->o.page_path ? &drawn : NULL, &report, m);
    progress_clear();
    if (r == VXS_OK) r = write_reports(a, &page, &report, m);
    if (pages) pages->free(&page);
    bake_report_free(&report);
    return r;
}

typedef struct watched_bake {
    bake_arguments *arguments;
    run_context    *run;
} watched_bake;

static int bake_apart(void *work)
{
    watched_bake *w = work;
    run_files_free(w->run->files); /* other files may have the names by now */
    *w->run->files = (run_files){0};
    vxs_result r   = options_check_files(&w->arguments->line, w->run);
    return command_end(w->run, r == VXS_OK ? bake_once(w->arguments, w->run) : r);
}

static vxs_result run(void *command, run_context *m)
{
    bake_arguments *a = command;
    if (!a->watch) return bake_once(command, m);
    if (!strcmp(a->o.scene_path, "-") || is_standard_output(a->o.output_path))
        return fail(m, VXS_E_ARGUMENT, "--watch needs a file for SCENE and for -o, not standard input or output");
    return bake_watch(a->o.scene_path, bake_apart, &(watched_bake){a, m}, m);
}

int cmd_bake(int argc, char **argv)
{
    return cmd_bake_with(NULL, argc, argv);
}

int cmd_bake_with(const square_exchange *others, int argc, char **argv)
{
    bake_arguments a;
    bake_arguments_init(&a, "bake", "SCENE -o OUT.vxs [options]", "Bake the shadows of a scene into a .vxs file.", 1);
    a.o.others = others;
    return command_run(&a.line, argc, argv, run, &a);
}
