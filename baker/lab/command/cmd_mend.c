/* vxs mend: a scene with fewer holes, so that more of it is solid.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <stdio.h>
#include <stdlib.h>

#include "baker/casters/casters.h"
#include "baker/command/options/options.h"
#include "baker/files/json_file.h"
#include "baker/files/output_file.h"
#include "baker/lab/command/lab_commands.h"
#include "baker/lab/command/report_text.h"
#include "baker/lab/mend/mesh_repair.h"
#include "baker/scene/gltf/glb_write.h"
#include "baker/scene/light_choice.h"

enum { ROWS = 30 };

typedef struct mend_command {
    const char    *path, *output_path, *json_path;
    scene_choice   choice;
    int            all;
    repair_options how;
    repair_report  report;
    size_t         solids[2], triangles[2]; /* solids, and triangles of solids, before and after */
} mend_command;

/* Names in the order of repaired_component.counts: JSON members, and words. */
static const struct repair_count {
    const char *member, *text;
} repair_counts[REPAIR_COUNTS] = {
    {"removed_repeated", "repeated triangles removed"},
    {"removed_zero_area", "triangles without area removed"},
    {"turned_triangles", "triangles turned"},
    {"filled_holes", "holes filled"},
    {"added_triangles", "triangles added"},
    {"left_holes", "holes left"},
};

/* as text ---------------------------------------------------------------------------------------------------------------------- */

static void print_counts(FILE *to, const repaired_component *k)
{
    const char *separator = "";
    for (int i = 0; i < REPAIR_COUNTS; i++) {
        if (!k->counts[i]) continue;
        fprintf(to, "%s%u %s", separator, k->counts[i], repair_counts[i].text);
        separator = ", ";
    }
    fprintf(to, "%s\n", *separator ? "" : "nothing to do");
}

/* Order: components that are still open first; each by size, then in the scene's order. */
static int worst_first(const void *a, const void *b)
{
    const repaired_component *p = a, *q = b;
    if (p->closed_after != q->closed_after) return p->closed_after ? 1 : -1;
    if (p->triangles != q->triangles) return p->triangles < q->triangles ? 1 : -1;
    return p->triangle < q->triangle ? -1 : 1;
}

/* Print the totals, and the components if verbose. */
static void print_report(FILE *to, const mend_command *c, const scene *s, int verbose)
{
    const repair_report *r    = &c->report;
    size_t               rows = c->all || (verbose && r->count <= ROWS) ? r->count : verbose ? ROWS : 0;
    char                 plain[PLAIN_BYTES];
    fprintf(to, "scene        %s\n", plain_text(plain, c->path));
    for (size_t i = 0; i < rows; i++) {
        const repaired_component *k = &r->components[i];
        char                      from[PART_TEXT_BYTES];
        fprintf(to, "component of %u triangles from triangle %u, %s, %s: ", k->triangles, k->triangle,
                part_text(from, s, &k->parts), k->closed_after ? "now closed" : "still open");
        print_counts(to, k);
    }
    if (r->count > rows && verbose) fprintf(to, "%zu more: --all lists them\n", r->count - rows);
    fprintf(to, "in all       ");
    print_counts(to, &r->total);
    fprintf(to, "closed       %zu of %zu components were closed and oriented, %zu are now\n", r->closed_before, r->component_count,
            r->closed_after);
    fprintf(to, "solids       %zu with %zu triangles were solids, %zu with %zu are now\n", c->solids[0], c->triangles[0],
            c->solids[1], c->triangles[1]);
    fprintf(to, "wrote        %s\n", plain_text(plain, c->output_path));
}

/* as JSON ---------------------------------------------------------------------------------------------------------------------- */

static json_t *counts_json(const repaired_component *k)
{
    json_t *json = json_pack("{s:I}", "triangles", (json_int_t)k->triangles);
    for (int i = 0; i < REPAIR_COUNTS; i++)
        json_object_set_new(json, repair_counts[i].member, json_integer((json_int_t)k->counts[i]));
    return json;
}

static json_t *report_json(const mend_command *c, const scene *s)
{
    const repair_report *r          = &c->report;
    json_t              *components = json_array();
    for (size_t i = 0; i < r->count; i++) {
        json_t *entry = counts_json(&r->components[i]);
        json_object_set_new(entry, "first_triangle", json_integer((json_int_t)r->components[i].triangle));
        json_object_set_new(entry, "closed_after", json_boolean(r->components[i].closed_after));
        json_object_set_new(entry, "from", part_json(s, &r->components[i].parts));
        json_array_append_new(components, entry);
    }
    return json_pack("{s:o, s:o, s:{s:f, s:I}, s:o, s:o, s:I, s:I, s:I, s:{s:I, s:I}, s:{s:I, s:I}}", "scene", json_text(c->path),
                     "output", json_text(c->output_path), "options", "hole_diameter_m", c->how.hole_diameter_metres, "hole_edges",
                     (json_int_t)c->how.hole_edges_max, "total", counts_json(&r->total), "components", components,
                     "component_count", (json_int_t)r->component_count, "closed_before", (json_int_t)r->closed_before,
                     "closed_after", (json_int_t)r->closed_after, "solids_before", "components", (json_int_t)c->solids[0],
                     "triangles", (json_int_t)c->triangles[0], "solids_after", "components", (json_int_t)c->solids[1], "triangles",
                     (json_int_t)c->triangles[1]);
}

/* when  0: before, 1: after */
static vxs_result count_solids(mend_command *c, const scene *s, int when, run_context *m)
{
    casters    casting;
    vxs_result r = casters_from_scene(&casting, s, CLOSED_AUTO, 1, m);
    if (r != VXS_OK) return r;
    c->solids[when]    = casting.component_count[COMPONENT_SOLID];
    c->triangles[when] = casting.solid_triangle_count;
    casters_free(&casting);
    return VXS_OK;
}

static vxs_result run(void *command, run_context *m)
{
    mend_command *c   = command;
    scene         s   = {0};
    glb_scene     glb = {0};
    output_file   out = {0};
    double        origin_ws[3];
    vxs_result    r;

    if ((r = scene_load_gltf(&s, c->path, &c->choice, m)) != VXS_OK) goto done;
    warn_about_lost_lights(&s, m);
    if ((r = run_check(m)) != VXS_OK) goto done;
    if ((r = count_solids(c, &s, 0, m)) != VXS_OK) goto done;
    glb_find_origin(&s, origin_ws);
    if ((r = glb_round_positions(&s, origin_ws, m)) != VXS_OK)
        goto done; /* round first, as the file does, so that holes closed here are closed in the file */
    if ((r = scene_repair(&s, &c->how, &c->report, m)) != VXS_OK) goto done;
    if ((r = count_solids(c, &s, 1, m)) != VXS_OK) goto done;
    if ((r = glb_from_scene(&glb, &s, origin_ws, m)) != VXS_OK) goto done;
    if ((r = output_file_open(&out, c->output_path, m)) != VXS_OK) goto done;
    if ((r = glb_write(&glb, &out, m)) != VXS_OK) goto done;
    if ((r = output_file_commit(&out, m)) != VXS_OK) goto done;

    if (c->report.count) qsort(c->report.components, c->report.count, sizeof *c->report.components, worst_first);
    /* keep the report out of standard output when an output goes there */
    FILE *to = report_stream(m, is_standard_output(c->output_path) || is_standard_output(c->json_path));
    if (to) print_report(to, c, &s, m->verbose);
    if (c->json_path) r = json_write(c->json_path, report_json(c, &s), m);
done:
    output_file_abort(&out);
    glb_scene_free(&glb);
    repair_report_free(&c->report);
    scene_free(&s);
    return r;
}

int cmd_mend(int argc, char **argv)
{
    mend_command c         = {.how = REPAIR_DEFAULTS};
    const option options[] = {
        {"SCENE", OPTION_INPUT, &c.path, FILE_SCENE, 0, NULL, NULL, "a glTF 2.0 scene, .gltf or .glb", NULL},
        {"-o", OPTION_OUTPUT, &c.output_path, 1, 0, ".glb", "OUT.glb", "where the mended scene goes; - is standard output", NULL},
        SCENE_ROWS(c.choice),
        {"--hole-diameter", OPTION_F64, &c.how.hole_diameter_metres, 0, 1e9, NULL, "METRES",
         "the largest hole to fill (default 0.1)", NULL},
        {"--hole-edges", OPTION_U32, &c.how.hole_edges_max, 0, REPAIR_HOLE_EDGES_MAX, NULL, "N",
         "the most edges of a hole to fill (default 64)", NULL},
        {"--all", OPTION_SWITCH, &c.all, 0, 0, NULL, NULL,
         "list every component that was mended or still has holes, not the first 30 only", NULL},
        {"--json", OPTION_OUTPUT, &c.json_path, 0, 0, ".json", "FILE.json", "what was done as JSON; - is standard output", NULL},
    };
    const command_line line = COMMAND_LINE("mend", "SCENE -o OUT.glb [options]",
                                           "Write a scene with closed meshes, for smaller files. What can be closed is closed, so "
                                           "that more of the scene is solid, and what a bake needs of it is written.",
                                           options);
    return command_run(&line, argc, argv, run, &c);
}
