/* vxs report: a page of what vxs bench measured.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <stdlib.h>

#include "baker/bench/bench_json.h"
#include "baker/command/commands.h"
#include "baker/files/json_file.h"
#include "baker/options/options.h"
#include "baker/report/page.h"

static vxs_result add_file(json_t *files, const char *path, message *m)
{
    json_t    *bench;
    vxs_result r = bench_json_read(&bench, path, m);
    if (r == VXS_OK && !json_array_size(json_at(bench, "cells")))
        r = fail(m, VXS_E_READ, "%s: no cells: expected one at least", path);
    if (r != VXS_OK) json_decref(bench);
    if (r == VXS_OK) json_array_append_new(files, json_pack("{s:o, s:o}", "path", json_text(path), "bench", bench));
    return r;
}

typedef struct report_command {
    text_list   benches;
    const char *out;
} report_command;

static vxs_result run(void *command, message *m)
{
    report_command *c     = command;
    json_t         *files = json_array();
    vxs_result      r     = VXS_OK;
    for (size_t n = 0; n < c->benches.count && r == VXS_OK; n++) r = add_file(files, c->benches.items[n], m);
    if (r == VXS_OK) return page_write(c->out, PAGE_BENCH, json_pack("{s:o}", "files", files), m);
    json_decref(files);
    return r;
}

int cmd_report(int argc, char **argv)
{
    report_command c         = {0};
    const option   options[] = {
          {"BENCH.json", OPTION_INPUTS, &c.benches, FILE_JSON, 0, NULL, NULL, "what vxs bench wrote", NULL},
          {"-o", OPTION_OUTPUT, &c.out, 1, 0, ".html|.htm", "OUT.html", "where the page goes; - is standard output", NULL},
    };
    const command_line line = COMMAND_LINE(
        "report", "BENCH.json... -o OUT.html",
        "Make a page with plots of what vxs bench measured. It stands alone, and has tables of the same figures.", options);
    return command_run(&line, argc, argv, run, &c);
}
