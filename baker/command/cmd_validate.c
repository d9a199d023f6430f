/* vxs validate: every check of the format, as numbered findings (formats/vxs.md section 8).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <errno.h>
#include <jansson.h>
#include <stdio.h>
#include <string.h>

#include "baker/command/commands.h"
#include "baker/files/json_file.h"
#include "baker/options/options.h"
#include "runtime/vxs.h"

static void collect(void *user, int number, const char *text, int section, uint64_t offset)
{
    json_t *finding = json_pack("{s:i, s:s, s:I}", "number", number, "text", text, "offset_bytes", (json_int_t)offset);
    if (finding && section >= 0) json_object_set_new(finding, "section", json_integer(section));
    json_array_append_new(user, finding);
}

static void print_findings(const char *path, json_t *findings)
{
    size_t  n;
    json_t *f;
    json_array_foreach(findings, n, f)
    {
        json_t *section = json_object_get(f, "section");
        char    where[32];
        snprintf(where, sizeof where, section ? "section %d" : "header", section ? (int)json_integer_value(section) : 0);
        printf("%s: finding %d: %s (%s, byte %lld)\n", path, (int)json_integer_value(json_object_get(f, "number")),
               json_string_value(json_object_get(f, "text")), where,
               (long long)json_integer_value(json_object_get(f, "offset_bytes")));
    }
    if (!json_array_size(findings)) printf("%s: valid\n", path);
}

int cmd_validate(int argc, char **argv)
{
    const char  *json_path = NULL, *path = NULL;
    const option options[] = {
        {"--json", OPTION_TEXT, &json_path, 0, 0, NULL, "FILE", "the findings as JSON; - is standard output", NULL}};
    const command_line line = {
        "validate", "FILE.vxs [--json FILE]", "Check every byte of a .vxs file. Exit status 1 when there is a finding.", options, 1,
        1};
    message    m = {0};
    int        help_shown;
    vxs_result r = options_parse(&line, argc, argv, &path, &help_shown, &m);
    if (r != VXS_OK || help_shown) return command_end(&m, r);

    json_t       *findings = json_array();
    vxs_read_desc desc     = {.finding = collect, .finding_user = findings, .find_all = 1};
    vxs_asset    *asset    = NULL;
    errno                  = 0;
    r                      = vxs_asset_open_file(&asset, path, &desc);
    vxs_asset_close(asset);
    int found = json_array_size(findings) != 0;
    if (r == VXS_E_READ) {
        fail(&m, r, "cannot read '%s': %s", path, strerror(errno ? errno : EIO));
    } else if (r != VXS_OK && !found) {
        fail(&m, r, "cannot check '%s': %s", path, vxs_result_text(r));
    } else {
        if (!is_standard_output(json_path)) print_findings(path, findings);
        r = json_path ? json_write(json_path,
                                   json_pack("{s:o, s:b, s:O}", "file", json_text(path), "valid", !found, "findings", findings), &m)
                      : VXS_OK;
    }
    json_decref(findings);
    int status = command_end(&m, r);
    return status ? status : found;
}
