/* vxs health: why components of a scene are not solids, and other faults of them.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/text.h"
#include "baker/command/options/options.h"
#include "baker/command/process/process.h"
#include "baker/files/json_file.h"
#include "baker/files/output_file.h"
#include "baker/lab/command/lab_commands.h"
#include "baker/lab/command/report_text.h"
#include "baker/lab/mend/mesh_health.h"

enum { ROWS = 30, NAMES = 3, COLUMNS = 100, FROM_MIN = 24 };

typedef struct health_command {
    const char  *path, *json_path;
    scene_choice choice;
    int          closed, all;
} health_command;

/* as text ---------------------------------------------------------------------------------------------------------------------- */

static void show_progress(const char *what)
{
    progress_say(PROGRESS_LINE, "examining %s", what);
}

/* The shape of a component, in a word or two. A one-sided component without boundary edges is closed. */
static const char *shape_name(const component_health *k)
{
    if (!k->orientable) return "one-sided";
    if (!k->closed) return k->oriented ? "open" : "open, mixed";
    return k->oriented ? "closed" : "mixed";
}

static void print_counts(FILE *to, const component_health *k)
{
    static const int widths[HEALTH_COUNTS] = {9, 0, 0, 8, 5, 5, 6, 8, 7, 4, 6}; /* 0: vertices and edges have no column */
    for (int n = 0; n < HEALTH_COUNTS; n++)
        if (widths[n]) fprintf(to, " %*llu", widths[n], (unsigned long long)k->counts[n]);
    fputc('\n', to);
}

static void print_row(FILE *to, const scene *s, const casters *c, const mesh_health *h, const component_health *k)
{
    fprintf(to, "%7zu  %-12s %-11s", (size_t)(k - h->components), component_kind_name(k->kind), shape_name(k));
    print_counts(to, k);

    /* a line with its position, the solids that it intersects, and its origin */
    char from[PART_TEXT_BYTES], shown[COLUMNS + 1];
    int  used = fprintf(to, "%9s", "");
    if (k->volume_m3 != 0) used += fprintf(to, "%.4g m3 at ", k->volume_m3);
    used += fprintf(to, "(%.4g, %.4g, %.4g)", (k->box_ws.min[0] + k->box_ws.max[0]) / 2, (k->box_ws.min[1] + k->box_ws.max[1]) / 2,
                    (k->box_ws.min[2] + k->box_ws.max[2]) / 2);
    for (uint64_t i = 0; i < k->meets && i < NAMES; i++)
        used += fprintf(to, "%s%u", i ? ", " : "; meets ", h->met[k->meets_first + i]);
    if (k->meets > NAMES) used += fprintf(to, " and %llu more", (unsigned long long)(k->meets - NAMES));
    part_text(from, s, &c->parts_of[k - h->components]);
    fprintf(to, "; %s\n", shorten(shown, used + 2 + FROM_MIN < COLUMNS ? (size_t)(COLUMNS - used - 2) : FROM_MIN, from));
}

/* Compare pointers to components. Order: components that cannot be solids, then those with other faults; each by size, then by
 * number. */
static int worst_first(const void *a, const void *b)
{
    const component_health *p = *(const component_health *const *)a, *q = *(const component_health *const *)b;
    int                     more_faulty = component_faults(q) - component_faults(p);
    if (more_faulty) return more_faulty;
    if (p->triangles != q->triangles) return p->triangles < q->triangles ? 1 : -1;
    return p < q ? -1 : 1;
}

static vxs_result print_health(FILE *to, const health_command *c, const scene *s, const casters *casting, const mesh_health *h,
                               run_context *m)
{
    const component_health **order  = malloc((h->count + 1) * sizeof *order);
    size_t                   faulty = 0, sound_meet = 0;
    if (!order) return fail(m, VXS_E_MEMORY, "out of memory for a table of %zu components", h->count);
    for (size_t i = 0; i < h->count; i++) {
        order[i] = &h->components[i];
        faulty += component_faults(order[i]) != 0;
        sound_meet += order[i]->meets && !component_faults(order[i]);
    }
    qsort(order, h->count, sizeof *order, worst_first);

    fprintf(to, "%zu triangles in %zu components", casting->triangle_count, h->count);
    if (h->collapsed_triangles) fprintf(to, ", %zu left out: two corners in one place", h->collapsed_triangles);
    fputs("\n", to);
    for (int kind = 0; kind < COMPONENT_KINDS; kind++)
        if (casting->component_count[kind])
            fprintf(to, "  %-12s %9zu components %9zu triangles\n", component_kind_name((component_kind)kind),
                    casting->component_count[kind], casting->triangles_of_kind[kind]);

    size_t rows = c->all ? h->count : faulty + 1 <= ROWS ? faulty : ROWS;
    if (rows) {
        static const char line[] = "%7s  %-12s %-11s %9s %8s %5s %5s %6s %8s %7s %4s %6s\n";
        fprintf(to, line, "", "", "", "", "boundary", "", "edges", "turned", "pinched", "self-", "zero", "re-");
        fprintf(to, line, "number", "kind", "shape", "triangles", "edges", "holes", "of >2", "edges", "vertices", "crossed", "area",
                "peated");
    }
    for (size_t i = 0; i < rows; i++) print_row(to, s, casting, h, order[i]);
    if (rows) fprintf(to, "%7s  %-12s %-11s", "total", "", "");
    if (rows) print_counts(to, &h->total);
    if (faulty > rows) fprintf(to, "%zu more with faults: --all lists them\n", faulty - rows);
    if (!c->all && faulty < h->count)
        fprintf(to, "%zu without a fault, %zu of which meet others: --all lists them\n", h->count - faulty, sound_meet);
    fprintf(to, "%llu pairs of solids meet\n", (unsigned long long)(h->total.meets / 2));
    if (h->gave_up) fprintf(to, "too many intersections: not all are counted\n");
    free(order);
    return VXS_OK;
}

/* as JSON ---------------------------------------------------------------------------------------------------------------------- */

static json_t *counts_json(const component_health *k)
{
    static const char names[] = "triangles|vertices|edges|boundary_edges|holes|nonmanifold_edges|misoriented_edges|"
                                "nonmanifold_vertices|self_intersections|zero_area_triangles|repeated_triangles";
    char              name[32];
    json_t           *json = json_pack("{s:b, s:b, s:b, s:f, s:o, s:o}", "closed", (int)k->closed, "orientable", (int)k->orientable,
                                       "oriented", (int)k->oriented, "volume_m3", k->volume_m3, "min_m", json_vector(k->box_ws.min), "max_m",
                                       json_vector(k->box_ws.max));
    for (int n = 0; n < HEALTH_COUNTS; n++)
        json_object_set_new(json, choice_word(name, names, n), json_integer((json_int_t)k->counts[n]));
    return json;
}

static json_t *health_json(const scene *s, const casters *c, const mesh_health *h)
{
    json_t *components = json_array();
    for (size_t i = 0; i < h->count; i++) {
        const component_health *k     = &h->components[i];
        json_t                 *entry = counts_json(k), *meets = json_array();
        for (uint64_t n = 0; n < k->meets; n++) json_array_append_new(meets, json_integer(h->met[k->meets_first + n]));
        json_object_set_new(entry, "number", json_integer((json_int_t)i));
        json_object_set_new(entry, "kind", json_string(component_kind_name(k->kind)));
        json_object_set_new(entry, "meets", meets);
        json_object_set_new(entry, "faults", json_integer(component_faults(k)));
        json_object_set_new(entry, "from", part_json(s, &c->parts_of[i]));
        json_array_append_new(components, entry);
    }
    json_t *total = counts_json(&h->total);
    json_object_set_new(total, "collapsed_triangles", json_integer((json_int_t)h->collapsed_triangles));
    json_object_set_new(total, "pairs_that_meet", json_integer((json_int_t)(h->total.meets / 2)));
    return json_pack("{s:o, s:o, s:b}", "total", total, "components", components, "complete", !h->gave_up);
}

static vxs_result run(void *command, run_context *m)
{
    health_command *c       = command;
    scene           s       = {0};
    casters         casting = {0};
    mesh_health     h       = {0};
    vxs_result      r;

    if ((r = scene_load_gltf(&s, c->path, &c->choice, m)) != VXS_OK) goto done;
    if ((r = casters_from_scene(&casting, &s, (closed_mode)c->closed, 1, m)) != VXS_OK) goto done;
    r = mesh_health_examine(&h, &casting, progress_wanted(m) == PROGRESS_LINE ? show_progress : NULL, m);
    progress_clear();
    if (r != VXS_OK) goto done;
    FILE *to = report_stream(m, is_standard_output(c->json_path));
    if (to && (r = print_health(to, c, &s, &casting, &h, m)) != VXS_OK) goto done;
    if (c->json_path)
        r = json_write(c->json_path,
                       json_pack("{s:o, s:o, s:o}", "scene", json_text(c->path), "name", json_text(s.name), "health",
                                 health_json(&s, &casting, &h)),
                       m);
done:
    mesh_health_free(&h);
    casters_free(&casting);
    scene_free(&s);
    return r;
}

int cmd_health(int argc, char **argv)
{
    health_command c         = {.closed = CLOSED_AUTO};
    const option   options[] = {
          {"SCENE", OPTION_INPUT, &c.path, FILE_SCENE, 0, NULL, NULL, "a glTF 2.0 scene, .gltf or .glb", NULL},
          SCENE_ROWS(c.choice),
          {"--closed", OPTION_CHOICE, &c.closed, 0, 0, CLOSED_CHOICES, NULL,
           "which components are solids, as bake has it (default auto)", NULL},
          {"--all", OPTION_SWITCH, &c.all, 0, 0, NULL, NULL, "list every component, not the 30 worst only", NULL},
          {"--json", OPTION_OUTPUT, &c.json_path, 0, 0, ".json", "FILE.json", "everything as JSON; - is standard output", NULL},
    };
    const command_line line =
        COMMAND_LINE("health", "SCENE [options]",
                     "Say what is wrong with the meshes of a scene. What keeps components from being solids comes first.", options);
    return command_run(&line, argc, argv, run, &c);
}
