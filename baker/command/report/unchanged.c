/* The report of a bake that was up to date; see unchanged.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/command/report/unchanged.h"

#include "baker/base/text.h"
#include "baker/base/version.h"
#include "baker/command/report/plan_text.h"
#include "baker/files/json_file.h"

void unchanged_print(FILE *to, const bake_options *o, const bake_report *r)
{
    char size[32], warnings[64] = "", plain[PLAIN_BYTES];
    if (r->warning_count) snprintf(warnings, sizeof warnings, "; warnings of its bake: %zu", r->warning_count);
    fprintf(to, "up to date   %s, %s: baked from this scene, these lights and options by vxs " VXS_VERSION "%s\n",
            plain_text(plain, o->output_path), size_text(size, r->file_bytes), warnings);
}

vxs_result unchanged_write_json(const char *path, const bake_options *o, const bake_report *r, message *m)
{
    json_t *root = json_pack("{s:s, s:o, s:o, s:b, s:I, s:o, s:f}", "vxs", VXS_VERSION, "scene", json_text(o->scene_path), "output",
                             json_text(o->output_path), "unchanged", 1, "file_bytes", (json_int_t)r->file_bytes, "warnings",
                             report_warnings_json(m), "total_seconds", r->total_seconds);
    return json_write(path, root, m);
}
