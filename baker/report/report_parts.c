/* Parts of plans and of reports; see report_parts.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/report/report_parts.h"

#include "baker/files/json_file.h"

void report_print_casters(FILE *to, const bake_report *r)
{
    const casters *c = &r->casters;
    fprintf(to, "casters      %zu triangles, %zu solids with %zu triangles\n", c->triangle_count,
            c->component_count[COMPONENT_SOLID], c->solid_triangle_count);
    for (int kind = COMPONENT_SOLID + 1; kind < COMPONENT_KINDS; kind++)
        if (c->component_count[kind])
            fprintf(to, "             %zu sheets with %zu triangles: %s\n", c->component_count[kind], c->triangles_of_kind[kind],
                    component_kind_name((component_kind)kind));
    if (c->collapsed_count) fprintf(to, "             %zu triangles left out: two corners in one place\n", c->collapsed_count);
    fprintf(to, "             %.6g x %.6g x %.6g m\n", r->casters_max_ws[0] - r->casters_min_ws[0],
            r->casters_max_ws[1] - r->casters_min_ws[1], r->casters_max_ws[2] - r->casters_min_ws[2]);
}

json_t *report_casters_json(const bake_report *r)
{
    const casters *c      = &r->casters;
    json_t        *sheets = json_object();
    for (int kind = COMPONENT_SOLID + 1; kind < COMPONENT_KINDS; kind++)
        json_object_set_new(sheets, component_kind_name((component_kind)kind),
                            json_pack("{s:I, s:I}", "components", (json_int_t)c->component_count[kind], "triangles",
                                      (json_int_t)c->triangles_of_kind[kind]));
    return json_pack("{s:I, s:I, s:{s:I, s:I}, s:o, s:[f,f,f], s:[f,f,f]}", "triangles", (json_int_t)c->triangle_count,
                     "collapsed_triangles", (json_int_t)c->collapsed_count, "solids", "components",
                     (json_int_t)c->component_count[COMPONENT_SOLID], "triangles", (json_int_t)c->solid_triangle_count, "sheets",
                     sheets, "min_m", r->casters_min_ws[0], r->casters_min_ws[1], r->casters_min_ws[2], "max_m",
                     r->casters_max_ws[0], r->casters_max_ws[1], r->casters_max_ws[2]);
}

json_t *report_left_out_json(const bake_report *r)
{
    json_t *lights = json_array();
    for (size_t n = 0; n < r->left_out_count; n++)
        json_array_append_new(lights, json_pack("{s:o, s:s}", "name", json_text(r->left_out[n].name), "why", r->left_out[n].why));
    return lights;
}

json_t *report_warnings_json(const message *m)
{
    json_t *warnings = json_array();
    for (size_t n = 0; n < m->warning_count; n++) json_array_append_new(warnings, json_text(m->warnings[n]));
    return warnings;
}
