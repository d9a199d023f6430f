/* vxs validate: every check of the format, as numbered findings (formats/vxs.md section 8).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <jansson.h>
#include <stdio.h>

#include "baker/base/parallel.h"
#include "baker/command/asset_open.h"
#include "baker/command/commands.h"
#include "baker/command/options/options.h"
#include "baker/files/input_file.h"
#include "baker/files/json_file.h"
#include "runtime/vxs.h"

static void collect(void *user, int number, const char *text, int section, uint64_t offset)
{
    json_t *finding = json_pack("{s:i, s:s, s:I}", "number", number, "text", text, "offset_bytes", (json_int_t)offset);
    if (finding && section >= 0) json_object_set_new(finding, "section", json_integer(section));
    json_array_append_new(user, finding);
}

typedef struct validate_command {
    const char *path, *json_path;
    uint64_t    memory_bytes;
} validate_command;

static vxs_result run(void *command, run_context *m)
{
    const validate_command *c        = command;
    json_t                 *findings = json_array();
    vxs_parallel            lent     = parallel_lent(parallel_default_threads());
    vxs_read_desc           desc     = {.finding            = collect,
                                        .finding_user       = findings,
                                        .find_all           = 1,
                                        .metadata           = 1,
                                        .memory_limit_bytes = c->memory_bytes,
                                        .parallel           = &lent};
    vxs_asset              *asset    = NULL;
    vxs_result              r        = asset_read(&asset, c->path, &desc, m);
    vxs_asset_close(asset);
    int found = json_array_size(findings) != 0;
    if (r != VXS_OK && !found) {
        fail(m, r, "cannot check '%s': %s", input_name(c->path), vxs_result_text(r));
    } else {
        m->wrong = found;
        FILE *to = is_standard_output(c->json_path) ? NULL : report_stream(m, 0);
        if (to) {
            char    word[COLORED_BYTES], plain[PLAIN_BYTES];
            size_t  n;
            json_t *f;
            plain_text(plain, input_name(c->path));
            json_array_foreach(findings, n, f)
            {
                json_t *section = json_object_get(f, "section");
                char    where[32];
                snprintf(where, sizeof where, section ? "section %d" : "header", section ? (int)json_integer_value(section) : 0);
                fprintf(to, "%s: %s %d: %s (%s, byte %lld)\n", plain, colored(word, m->color, to, COLOR_RED, "finding"),
                        (int)json_integer_value(json_object_get(f, "number")), json_string_value(json_object_get(f, "text")), where,
                        (long long)json_integer_value(json_object_get(f, "offset_bytes")));
            }
            if (!json_array_size(findings)) fprintf(to, "%s: %s\n", plain, colored(word, m->color, to, COLOR_GREEN, "valid"));
        }
        json_t *json = json_pack("{s:o, s:b, s:O}", "file", json_text(c->path), "valid", !found, "findings", findings);
        r            = c->json_path ? json_write(c->json_path, json, m) : (json_decref(json), VXS_OK);
    }
    json_decref(findings);
    return r;
}

int cmd_validate(int argc, char **argv)
{
    validate_command c         = {0};
    const option     options[] = {
            {"FILE.vxs", OPTION_INPUT, &c.path, FILE_ASSET, 0, NULL, NULL, "what vxs bake wrote", NULL},
            {"--memory", OPTION_BYTES, &c.memory_bytes, 0, 0, NULL, "BYTES",
             "hold no more of the file in memory than this (default 256 times the file, 64M at least)", NULL},
            {"--json", OPTION_OUTPUT, &c.json_path, 0, 0, ".json", "FILE.json", "the findings as JSON; - is standard output", NULL},
    };
    const command_line line = COMMAND_LINE("validate", "FILE.vxs [options]",
                                           "Check every byte of a .vxs file. Exit status 1 when there is a finding.", options);
    return command_run(&line, argc, argv, run, &c);
}
