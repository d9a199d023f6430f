/* vxs report: a page and plots of what vxs bench measured.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "baker/files/output_file.h"
#include "baker/options/options.h"
#include "baker/page/bench_page.h"

typedef struct report_command {
    const char **benches; /* [bench_count] */
    size_t       bench_count;
    const char  *out, *plots;
} report_command;

static vxs_result check(const report_command *c, message *m)
{
    struct stat s;
    if (!c->out) return fail(m, VXS_E_ARGUMENT, "report needs -o OUT.html");
    for (size_t n = 0; n < c->bench_count; n++) {
        vxs_result r = output_file_check(c->out, c->benches[n], m);
        if (r != VXS_OK) return r;
    }
    if (c->plots && !stat(c->plots, &s) && !S_ISDIR(s.st_mode)) return fail(m, VXS_E_WRITE, "--plots %s: is no folder", c->plots);
    return VXS_OK;
}

static vxs_result write_plots(const bench_plots *plots, const char *folder, message *m)
{
    vxs_result r = VXS_OK;
    if (mkdir(folder, 0777) && errno != EEXIST)
        return fail(m, VXS_E_WRITE, "--plots %s: cannot be made: %s", folder, strerror(errno));
    for (size_t n = 0; n < plots->count && r == VXS_OK; n++) r = plot_write(&plots->items[n], folder, m);
    return r;
}

static vxs_result run(const report_command *c, message *m)
{
    bench_set   set   = {0};
    bench_plots plots = {0};
    output_file out   = {0};
    vxs_result  r;

    if ((r = check(c, m)) != VXS_OK) goto done;
    if ((r = bench_set_read(&set, c->benches, c->bench_count, m)) != VXS_OK) goto done;
    if ((r = bench_plots_make(&plots, &set, m)) != VXS_OK) goto done;
    if (c->plots && (r = write_plots(&plots, c->plots, m)) != VXS_OK) goto done;
    if ((r = output_file_open(&out, c->out, m)) != VXS_OK) goto done;
    bench_page_print(out.stream, &set, &plots);
    r = output_file_commit(&out, m);
done:
    output_file_abort(&out);
    bench_plots_free(&plots);
    bench_set_free(&set);
    return r;
}

int cmd_report(int argc, char **argv)
{
    report_command c         = {0};
    const option   options[] = {
          {"-o", OPTION_TEXT, &c.out, 0, 0, NULL, "OUT.html", "where the page goes; - is standard output", NULL},
          {"--plots", OPTION_TEXT, &c.plots, 0, 0, NULL, "FOLDER", "also write each plot as SVG and PNG, to this folder", NULL},
    };
    const command_line line = {"report",
                               "BENCH.json... -o OUT.html [--plots FOLDER]",
                               "A page that stands alone, with plots and tables of what vxs bench measured. Needs gnuplot.",
                               options,
                               sizeof options / sizeof *options,
                               1};
    message            m    = {0};
    int                help_shown;
    vxs_result         r = VXS_E_MEMORY;
    c.benches            = calloc((size_t)argc, sizeof *c.benches);
    if (c.benches)
        r = options_parse_repeated(&line, argc, argv, c.benches, &help_shown, &m);
    else
        fail(&m, r, "out of memory for %d arguments", argc);
    while (r == VXS_OK && c.benches[c.bench_count]) c.bench_count++;
    if (r == VXS_OK && !help_shown) r = run(&c, &m);
    free(c.benches);
    return command_end(&m, r);
}
