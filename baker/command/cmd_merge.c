/* vxs merge.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <jansson.h>
#include <stdio.h>

#include "baker/bake/merge_parts.h"
#include "baker/base/parallel.h"
#include "baker/base/version.h"
#include "baker/command/commands.h"
#include "baker/command/options/options.h"
#include "baker/command/process/process.h"
#include "baker/files/json_file.h"

typedef struct merge_command {
    merge_options o;
    const char   *json_path;
} merge_command;

static vxs_result run(void *command, run_context *m)
{
    merge_command *c      = command;
    merge_report   report = {.parts = 0};
    process_return_large();
    c->o.watch    = progress_watch(m);
    vxs_result r  = merge_parts(&c->o, &report, m);
    FILE      *to = report_stream(m, is_standard_output(c->o.output_path) || is_standard_output(c->json_path));
    progress_clear();
    if (r == VXS_OK && to) {
        char size[32], memory[32], plain[PLAIN_BYTES];
        fprintf(to, "parts        %u, %llu squares of %u lights\n", report.parts, (unsigned long long)report.squares,
                report.lights.light_count);
        fprintf(to, "file         %s: %s\n",
                is_standard_output(c->o.output_path) ? "standard output" : plain_text(plain, c->o.output_path),
                size_text(size, report.lights.file_bytes));
        fprintf(to, "time         %.2f s; memory %s\n", report.lights.total_seconds, size_text(memory, report.lights.peak_bytes));
    }
    if (r == VXS_OK && c->json_path)
        r = json_write(c->json_path,
                       json_pack("{s:s, s:o, s:I, s:I, s:I, s:I, s:f, s:I}", "vxs", VXS_VERSION, "output",
                                 json_text(c->o.output_path), "parts", (json_int_t)report.parts, "squares",
                                 (json_int_t)report.squares, "lights", (json_int_t)report.lights.light_count, "file_bytes",
                                 (json_int_t)report.lights.file_bytes, "total_seconds", report.lights.total_seconds, "peak_bytes",
                                 (json_int_t)report.lights.peak_bytes),
                       m);
    merge_report_free(&report);
    return r;
}

int cmd_merge(int argc, char **argv)
{
    merge_command c         = {.o = {.threads = parallel_default_threads()}};
    const option  options[] = {
         {"PART", OPTION_INPUTS, &c.o.paths, FILE_PART, 0, NULL, NULL,
          "what vxs bake --part wrote: all parts of a bake, in any order", NULL},
         {"-o", OPTION_OUTPUT, &c.o.output_path, 1, 0, ".vxs", "OUT.vxs", "where the asset goes; - is standard output", NULL},
         {"--threads", OPTION_U32, &c.o.threads, 1, PARALLEL_THREADS_MAX, NULL, "N",
          "threads; never changes the bytes (default all processors)", NULL},
         {"--json", OPTION_OUTPUT, &c.json_path, 0, 0, ".json", "FILE.json", "the report as JSON; - is standard output", NULL},
    };
    const command_line line =
        COMMAND_LINE("merge", "PART... -o OUT.vxs [options]", "Make a .vxs file of the parts of a bake.", options);
    return command_run(&line, argc, argv, run, &c);
}
