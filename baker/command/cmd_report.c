/* vxs report: a page of what vxs bench measured.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <stdlib.h>

#include "baker/bench/bench_json.h"
#include "baker/command/commands.h"
#include "baker/files/json_file.h"
#include "baker/files/output_file.h"
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

static vxs_result run(const char *const *benches, const char *out, message *m)
{
    json_t    *files = json_array();
    vxs_result r     = out ? VXS_OK : fail(m, VXS_E_ARGUMENT, "report needs -o OUT.html");
    for (size_t n = 0; benches[n] && r == VXS_OK; n++) r = output_file_check(out, benches[n], m);
    for (size_t n = 0; benches[n] && r == VXS_OK; n++) r = add_file(files, benches[n], m);
    if (r == VXS_OK) return page_write(out, PAGE_BENCH, json_pack("{s:o}", "files", files), m);
    json_decref(files);
    return r;
}

int cmd_report(int argc, char **argv)
{
    const char  *out       = NULL;
    const option options[] = {{"-o", OPTION_TEXT, &out, 0, 0, NULL, "OUT.html", "where the page goes; - is standard output", NULL}};
    const command_line line = {
        "report", "BENCH.json... -o OUT.html",      "A page that stands alone, with plots and tables of what vxs bench measured.",
        options,  sizeof options / sizeof *options, 1};
    message      m = {0};
    int          help_shown;
    const char **benches = calloc((size_t)argc + 1, sizeof *benches);
    vxs_result   r       = benches ? options_parse_repeated(&line, argc, argv, benches, &help_shown, &m)
                                   : fail(&m, VXS_E_MEMORY, "out of memory for %d arguments", argc);
    if (r == VXS_OK && !help_shown) r = run(benches, out, &m);
    free(benches);
    return command_end(&m, r);
}
