/* vxs report: a page from the results of vxs bench, or of make bench-volumes.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <stdlib.h>

#include "baker/command/options/options.h"
#include "baker/files/json_file.h"
#include "baker/lab/bench/bench_json.h"
#include "baker/lab/command/lab_commands.h"
#include "baker/lab/pages/page.h"

typedef struct report_command {
    text_list   benches;
    const char *out;
    page_kind   kind; /* of all files */
} report_command;

static vxs_result add_file(report_command *c, json_t *files, const char *path, run_context *m)
{
    json_t    *measured;
    vxs_result r = json_read(&measured, path, m);
    if (r != VXS_OK) return r;
    int         is_fog = is_volumes_json(measured);
    page_kind   kind   = is_fog ? PAGE_VOLUMES : PAGE_BENCH;
    const char *items  = is_fog ? "scenes" : "cells";
    if (!json_array_size(files)) c->kind = kind;
    r = is_fog ? volumes_json_check(measured, path, m) : bench_json_check(measured, path, m);
    if (r == VXS_OK && !json_array_size(json_at(measured, items)))
        r = fail(m, VXS_E_READ, "%s: no %s: expected one at least", path, items);
    if (r == VXS_OK && kind != c->kind)
        r = fail(m, VXS_E_READ, "%s: measurements of %s: expected such as are in %s", path, kind == PAGE_BENCH ? "bakes" : "fog",
                 c->benches.items[0]);
    if (r == VXS_OK)
        json_array_append_new(files, json_pack("{s:o, s:o}", "path", json_text(path), "bench", measured));
    else
        json_decref(measured);
    return r;
}

static vxs_result run(void *command, run_context *m)
{
    report_command *c     = command;
    json_t         *files = json_array();
    vxs_result      r     = VXS_OK;
    for (size_t n = 0; n < c->benches.count && r == VXS_OK; n++) r = add_file(c, files, c->benches.items[n], m);
    if (r == VXS_OK) return page_write(c->out, c->kind, json_pack("{s:o}", "files", files), m);
    json_decref(files);
    return r;
}

int cmd_report(int argc, char **argv)
{
    report_command c         = {0};
    const option   options[] = {
          {"BENCH.json", OPTION_INPUTS, &c.benches, FILE_JSON, 0, NULL, NULL, "what vxs bench wrote, or make bench-volumes", NULL},
          {"-o", OPTION_OUTPUT, &c.out, 1, 0, ".html|.htm", "OUT.html", "where the page goes; - is standard output", NULL},
    };
    const command_line line =
        COMMAND_LINE("report", "BENCH.json... -o OUT.html",
                     "Make a page with plots of measurements. They are of bakes, by vxs bench, or of fog, by make "
                     "bench-volumes. The page stands alone, and has tables of the same figures.",
                     options);
    return command_run(&line, argc, argv, run, &c);
}
