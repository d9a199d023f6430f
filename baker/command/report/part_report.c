/* The report of --part; see part_report.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/command/report/part_report.h"

#include "baker/base/text.h"
#include "baker/base/version.h"
#include "baker/command/report/plan_text.h"
#include "baker/files/json_file.h"
#include "baker/files/run_files.h"

void part_print(FILE *to, const bake_options *o, const bake_report *r)
{
    square_counts squares = report_squares(r);
    char          size[32], plain[PLAIN_BYTES];
    fprintf(to, "part         %u of %u: %s, %s\n", o->part, o->parts,
            is_standard_output(o->output_path) ? "standard output" : plain_text(plain, o->output_path),
            size_text(size, r->file_bytes));
    fprintf(to, "squares      %llu of %llu made, %llu kept%s%s\n", (unsigned long long)squares.made,
            (unsigned long long)squares.all, (unsigned long long)(squares.all - squares.made), o->resume_path ? " in " : "",
            o->resume_path ? plain_text(plain, o->resume_path) : "");
    fprintf(to, "time         %.2f s; memory %s\n", r->total_seconds, size_text(size, r->peak_bytes));
}

vxs_result part_write_json(const char *path, const bake_options *o, const bake_report *r, message *m)
{
    square_counts squares = report_squares(r);
    json_t       *part    = json_pack("{s:I, s:I, s:I, s:I}", "number", (json_int_t)o->part, "parts", (json_int_t)o->parts, "made",
                                      (json_int_t)squares.made, "kept", (json_int_t)(squares.all - squares.made));
    json_t       *root =
        json_pack("{s:s, s:o, s:o, s:b, s:o, s:I, s:o, s:f, s:I}", "vxs", VXS_VERSION, "scene", json_text(o->scene_path), "output",
                  json_text(o->output_path), "unchanged", 0, "part", part, "file_bytes", (json_int_t)r->file_bytes, "warnings",
                  report_warnings_json(m), "total_seconds", r->total_seconds, "peak_bytes", (json_int_t)r->peak_bytes);
    return json_write(path, root, m);
}
