/* vxs health: what keeps components of a scene from being solids, and what else is wrong with them.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "baker/files/json_file.h"
#include "baker/files/output_file.h"
#include "baker/measure/progress.h"
#include "baker/options/options.h"
#include "baker/mend/mesh_health.h"
#include "baker/mend/mesh_repair.h"
#include "baker/mend/mesh_union.h"

enum { ROWS = 30, NAMES = 6 };

typedef struct health_command {
    const char    *path, *scene_name, *json_path;
    int            closed, all, repair, repair_detail_given, unite;
    repair_options how;
    json_t        *json;
} health_command;

/* --- for people ------------------------------------------------------------------------------------------------------- */

/* Standard output, unless JSON goes there. */
static FILE *people(const health_command *c)
{
    return c->json_path && !strcmp(c->json_path, "-") ? stderr : stdout;
}

static void say_progress(const char *what)
{
    progress_say(isatty(STDERR_FILENO), "examining %s", what);
}

/* What a component is, in a word or two. */
static const char *shape_name(const component_health *k)
{
    if (!k->orientable) return k->closed ? "one-sided, closed" : "one-sided";
    if (!k->closed) return k->oriented ? "open" : "open, mixed winding";
    return k->oriented ? "closed" : "mixed winding";
}

/* Columns: what is counted along edges, at vertices, of triangles. */
static void print_head(FILE *to)
{
    fprintf(to, "%7s  %-12s %-19s %9s %8s %6s %8s %7s %8s %7s %5s %8s %11s  %s\n", "", "", "", "", "boundary", "", "edges of",
            "turned", "pinched", "self-", "zero", "", "volume", "centre");
    fprintf(to, "%7s  %-12s %-19s %9s %8s %6s %8s %7s %8s %7s %5s %8s %11s  %s\n", "number", "kind", "shape", "triangles", "edges",
            "holes", ">2 faces", "edges", "vertices", "crossed", "area", "repeated", "m3", "m; solids that it meets");
}

static void print_counts(FILE *to, const component_health *k)
{
    fprintf(to, " %9u %8u %6u %8u %7u %8u %7llu %5u %8u %11.4g", k->triangles, k->boundary_edges, k->holes, k->nonmanifold_edges,
            k->misoriented_edges, k->nonmanifold_vertices, (unsigned long long)k->self_intersections, k->zero_area_triangles,
            k->repeated_triangles, k->volume_m3);
}

static void print_row(FILE *to, const mesh_health *h, size_t number)
{
    const component_health *k = &h->components[number];
    fprintf(to, "%7zu  %-12s %-19s", number, component_kind_name(k->kind), shape_name(k));
    print_counts(to, k);
    fprintf(to, "  (%.4g, %.4g, %.4g)", (k->box_ws[0] + k->box_ws[3]) / 2, (k->box_ws[1] + k->box_ws[4]) / 2,
            (k->box_ws[2] + k->box_ws[5]) / 2);
    for (uint64_t i = 0; i < k->meets && i < NAMES; i++) fprintf(to, "%s%u", i ? ", " : "; ", h->met[k->meets_first + i]);
    if (k->meets > NAMES) fprintf(to, " and %llu more", (unsigned long long)(k->meets - NAMES));
    fputs("\n", to);
}

typedef struct ranked {
    uint32_t number, triangles;
    int      faults;
} ranked;

static int worst_first(const void *a, const void *b)
{
    const ranked *p = a, *q = b;
    if (p->faults != q->faults) return q->faults - p->faults;
    if (p->triangles != q->triangles) return p->triangles < q->triangles ? 1 : -1;
    return p->number < q->number ? -1 : 1;
}

static void print_summary(FILE *to, const casters *c, const mesh_health *h)
{
    fprintf(to, "%zu triangles in %zu components", c->triangle_count, h->count);
    if (h->collapsed_triangles) fprintf(to, ", %zu left out: two corners in one place", h->collapsed_triangles);
    fputs("\n", to);
    for (int kind = 0; kind < COMPONENT_KINDS; kind++)
        if (c->component_count[kind])
            fprintf(to, "  %-12s %9zu components %9zu triangles\n", component_kind_name((component_kind)kind),
                    c->component_count[kind], c->triangles_of_kind[kind]);
}

static vxs_result print_health(const health_command *c, const casters *casting, const mesh_health *h, message *m)
{
    FILE   *to     = people(c);
    ranked *order  = malloc((h->count + 1) * sizeof *order);
    size_t  faulty = 0;
    if (!order) return fail(m, VXS_E_MEMORY, "out of memory for a table of %zu components", h->count);
    for (uint32_t i = 0; i < h->count; i++) {
        order[i] = (ranked){i, h->components[i].triangles, component_has_faults(&h->components[i])};
        faulty += (size_t)order[i].faults;
    }
    qsort(order, h->count, sizeof *order, worst_first);

    print_summary(to, casting, h);
    print_head(to);
    size_t rows = c->all || faulty + 1 <= ROWS ? (c->all ? h->count : faulty) : ROWS;
    for (size_t i = 0; i < rows; i++) print_row(to, h, order[i].number);
    if (faulty > rows) fprintf(to, "%7s  %zu more with faults: --all lists them\n", "", faulty - rows);
    if (!c->all && faulty < h->count) fprintf(to, "%7s  %zu without a fault\n", "", h->count - faulty);
    fprintf(to, "%7s  %-12s %-19s", "total", "", "");
    print_counts(to, &h->total);
    fprintf(to, "  %llu pairs of solids meet\n", (unsigned long long)(h->total.meets / 2));
    if (h->gave_up) fprintf(to, "too many intersections: not all are counted\n");
    free(order);
    return VXS_OK;
}

/* --- for machines ----------------------------------------------------------------------------------------------------- */

static json_t *counts_json(const component_health *k)
{
    const struct {
        const char *name;
        uint64_t    count;
    } counts[] = {
        {"triangles", k->triangles},
        {"vertices", k->vertices},
        {"edges", k->edges},
        {"boundary_edges", k->boundary_edges},
        {"holes", k->holes},
        {"nonmanifold_edges", k->nonmanifold_edges},
        {"misoriented_edges", k->misoriented_edges},
        {"nonmanifold_vertices", k->nonmanifold_vertices},
        {"zero_area_triangles", k->zero_area_triangles},
        {"repeated_triangles", k->repeated_triangles},
        {"self_intersections", k->self_intersections},
    };
    const double *box  = k->box_ws;
    json_t       *json = json_pack("{s:b, s:b, s:b, s:f, s:[f,f,f], s:[f,f,f]}", "closed", (int)k->closed, "orientable",
                                   (int)k->orientable, "oriented", (int)k->oriented, "volume_m3", k->volume_m3, "min_m", box[0], box[1],
                                   box[2], "max_m", box[3], box[4], box[5]);
    for (size_t i = 0; i < sizeof counts / sizeof *counts; i++)
        json_object_set_new(json, counts[i].name, json_integer((json_int_t)counts[i].count));
    return json;
}

static json_t *health_json(const mesh_health *h)
{
    json_t *components = json_array();
    for (size_t i = 0; i < h->count; i++) {
        const component_health *k     = &h->components[i];
        json_t                 *entry = counts_json(k), *meets = json_array();
        for (uint64_t n = 0; n < k->meets; n++) json_array_append_new(meets, json_integer(h->met[k->meets_first + n]));
        json_object_set_new(entry, "number", json_integer((json_int_t)i));
        json_object_set_new(entry, "kind", json_string(component_kind_name(k->kind)));
        json_object_set_new(entry, "meets", meets);
        json_array_append_new(components, entry);
    }
    json_t *total = counts_json(&h->total);
    json_object_set_new(total, "collapsed_triangles", json_integer((json_int_t)h->collapsed_triangles));
    json_object_set_new(total, "pairs_that_meet", json_integer((json_int_t)(h->total.meets / 2)));
    return json_pack("{s:o, s:o, s:b}", "total", total, "components", components, "complete", !h->gave_up);
}

/* ---------------------------------------------------------------------------------------------------------------------- */

/* Examine, print, and add to the JSON under a name. */
static vxs_result tell(health_command *c, const casters *casting, const char *name, message *m)
{
    mesh_health h = {0};
    vxs_result  r = mesh_health_examine(&h, casting, say_progress, m);
    progress_clear();
    if (r == VXS_OK) r = print_health(c, casting, &h, m);
    if (r == VXS_OK && c->json_path) json_object_set_new(c->json, name, health_json(&h));
    mesh_health_free(&h);
    return r;
}

/* --- repair ----------------------------------------------------------------------------------------------------------- */

static const struct repair_count {
    const char *name, *text;
    size_t      offset;
} repair_counts[] = {
    {"stitched_vertices", "vertices stitched", offsetof(repaired_component, stitched_vertices)},
    {"removed_repeated", "repeated triangles removed", offsetof(repaired_component, removed_repeated)},
    {"removed_zero_area", "triangles without area removed", offsetof(repaired_component, removed_zero_area)},
    {"turned_triangles", "triangles turned", offsetof(repaired_component, turned_triangles)},
    {"filled_holes", "holes filled", offsetof(repaired_component, filled_holes)},
    {"added_triangles", "triangles added", offsetof(repaired_component, added_triangles)},
    {"left_holes", "holes left", offsetof(repaired_component, left_holes)},
};
enum { REPAIR_COUNTS = sizeof repair_counts / sizeof *repair_counts };

static uint32_t repair_count_of(const repaired_component *k, int which)
{
    uint32_t count;
    memcpy(&count, (const char *)k + repair_counts[which].offset, sizeof count);
    return count;
}

static void print_done(FILE *to, const repaired_component *k)
{
    const char *separator = "";
    for (int i = 0; i < REPAIR_COUNTS; i++) {
        uint32_t count = repair_count_of(k, i);
        if (count) fprintf(to, "%s%u %s", separator, count, repair_counts[i].text);
        if (count) separator = ", ";
    }
    fprintf(to, "%s\n", *separator ? "" : "nothing to do");
}

static void print_repair(const health_command *c, const repair_report *r)
{
    FILE  *to   = people(c);
    size_t rows = c->all || r->count <= ROWS ? r->count : ROWS;
    fprintf(to, "\nrepair\n");
    for (size_t i = 0; i < rows; i++) {
        const repaired_component *k = &r->components[i];
        fprintf(to, "  component of %u triangles from triangle %u, %s: ", k->triangles, k->triangle,
                k->closed_after ? "now closed" : "still open");
        print_done(to, k);
    }
    if (r->count > rows) fprintf(to, "  %zu more: --all lists them\n", r->count - rows);
    fprintf(to, "  in all: ");
    print_done(to, &r->total);
    fprintf(to, "  %zu of %zu components were closed and oriented, %zu are now\n\n", r->closed_before, r->component_count,
            r->closed_after);
}

static json_t *repaired_json(const repaired_component *k)
{
    json_t *json = json_pack("{s:I}", "triangles", (json_int_t)k->triangles);
    for (int i = 0; i < REPAIR_COUNTS; i++)
        json_object_set_new(json, repair_counts[i].name, json_integer((json_int_t)repair_count_of(k, i)));
    return json;
}

static json_t *repair_json(const repair_report *r)
{
    json_t *components = json_array();
    for (size_t i = 0; i < r->count; i++) {
        json_t *entry = repaired_json(&r->components[i]);
        json_object_set_new(entry, "first_triangle", json_integer((json_int_t)r->components[i].triangle));
        json_object_set_new(entry, "closed_after", json_boolean(r->components[i].closed_after));
        json_array_append_new(components, entry);
    }
    return json_pack("{s:o, s:o, s:I, s:I, s:I}", "total", repaired_json(&r->total), "components", components, "component_count",
                     (json_int_t)r->component_count, "closed_before", (json_int_t)r->closed_before, "closed_after",
                     (json_int_t)r->closed_after);
}

static vxs_result repair(health_command *c, scene *s, message *m)
{
    repair_report report;
    vxs_result    r = scene_repair(s, &c->how, &report, m);
    if (r != VXS_OK) return r;
    print_repair(c, &report);
    if (c->json_path) json_object_set_new(c->json, "repair", repair_json(&report));
    repair_report_free(&report);
    return VXS_OK;
}

/* --- union ------------------------------------------------------------------------------------------------------------ */

static void print_united(FILE *to, const union_cluster *k)
{
    fprintf(to, "%u solids with %u triangles: %u became %u", k->solids, k->triangles, k->left[UNITED], k->results);
    for (int i = UNITED + 1; i < UNITE_OUTCOMES; i++)
        if (k->left[i]) fprintf(to, ", %u left (%s)", k->left[i], unite_outcome_name((unite_outcome)i));
    fputs("\n", to);
}

static void print_union(const health_command *c, const union_report *r)
{
    FILE  *to   = people(c);
    size_t rows = c->all || r->count <= ROWS ? r->count : ROWS;
    fprintf(to, "\nunion: %zu clusters of solids that meet\n", r->count);
    for (size_t i = 0; i < rows; i++) {
        fprintf(to, "  with solid %u, ", r->clusters[i].solid);
        print_united(to, &r->clusters[i]);
    }
    if (r->count > rows) fprintf(to, "  %zu more: --all lists them\n", r->count - rows);
    fprintf(to, "  in all: ");
    print_united(to, &r->total);
    if (r->gave_up) fprintf(to, "  too many intersections: some solids that meet are not united\n");
    fprintf(to, "  %zu solids with %zu triangles\n\n", r->solids_after, r->triangles_after);
}

static json_t *cluster_json(const union_cluster *k)
{
    json_t *left = json_object();
    for (int i = UNITED + 1; i < UNITE_OUTCOMES; i++)
        json_object_set_new(left, unite_outcome_name((unite_outcome)i), json_integer((json_int_t)k->left[i]));
    return json_pack("{s:I, s:I, s:I, s:I, s:o}", "solids", (json_int_t)k->solids, "triangles", (json_int_t)k->triangles, "united",
                     (json_int_t)k->left[UNITED], "results", (json_int_t)k->results, "left", left);
}

static json_t *union_json(const union_report *r)
{
    json_t *clusters = json_array();
    for (size_t i = 0; i < r->count; i++) {
        json_t *entry = cluster_json(&r->clusters[i]);
        json_object_set_new(entry, "solid", json_integer((json_int_t)r->clusters[i].solid));
        json_array_append_new(clusters, entry);
    }
    return json_pack("{s:o, s:o, s:I, s:I, s:b}", "total", cluster_json(&r->total), "clusters", clusters, "solids_after",
                     (json_int_t)r->solids_after, "triangles_after", (json_int_t)r->triangles_after, "complete", !r->gave_up);
}

static vxs_result unite(health_command *c, casters *casting, message *m)
{
    union_report report;
    say_progress("unions");
    vxs_result r = casters_unite(casting, &report, m);
    progress_clear();
    if (r != VXS_OK) return r;
    print_union(c, &report);
    if (c->json_path) json_object_set_new(c->json, "union", union_json(&report));
    union_report_free(&report);
    return tell(c, casting, "united", m);
}

/* ---------------------------------------------------------------------------------------------------------------------- */

/* Sort the casters and say how they are. */
static vxs_result sort_and_tell(health_command *c, casters *casting, const scene *s, const char *name, message *m)
{
    casters_free(casting);
    vxs_result r = casters_from_scene(casting, s, (closed_mode)c->closed, m);
    return r == VXS_OK ? tell(c, casting, name, m) : r;
}

static vxs_result examine(health_command *c, message *m)
{
    scene      s       = {0};
    casters    casting = {0};
    vxs_result r;

    if (c->json_path && (r = output_file_check(c->json_path, c->path, m)) != VXS_OK) return r;
    if ((r = scene_load_gltf(&s, c->path, c->scene_name, m)) != VXS_OK) goto done;
    if (c->json_path) c->json = json_pack("{s:o, s:o}", "scene", json_text(c->path), "name", json_text(s.name));
    if ((r = sort_and_tell(c, &casting, &s, "health", m)) != VXS_OK) goto done;
    if (c->repair && (r = repair(c, &s, m)) != VXS_OK) goto done;
    if (c->repair && (r = sort_and_tell(c, &casting, &s, "repaired", m)) != VXS_OK) goto done;
    if (c->unite && (r = unite(c, &casting, m)) != VXS_OK) goto done;
    if (c->json_path) {
        json_t *json = c->json;
        c->json      = NULL;
        r            = json_write(c->json_path, json, m);
    }
done:
    json_decref(c->json);
    casters_free(&casting);
    scene_free(&s);
    return r;
}

int cmd_health(int argc, char **argv)
{
    health_command c         = {.closed = CLOSED_AUTO, .how = REPAIR_DEFAULTS};
    message        m         = {0};
    const option   options[] = {
          {"--scene", OPTION_TEXT, &c.scene_name, 0, 0, NULL, "NAME", "name or index of the glTF scene", NULL},
          {"--closed", OPTION_CHOICE, &c.closed, 0, 0, CLOSED_CHOICES, NULL, "which components are solids, as bake has it", NULL},
          {"--all", OPTION_SWITCH, &c.all, 0, 0, NULL, NULL, "list every component, not only the worst", NULL},
          {"--repair", OPTION_SWITCH, &c.repair, 0, 0, NULL, NULL, "mend what can be mended, say what was done, and examine again",
           NULL},
          {"--stitch", OPTION_F64, &c.how.stitch_m, 0, 1e6, NULL, "METRES", "repair: stitch borders this far apart (default 0)",
           &c.repair_detail_given},
          {"--hole-diameter", OPTION_F64, &c.how.hole_diameter_m, 0, 1e9, NULL, "METRES",
           "repair: the largest hole to fill (default 0.1)", &c.repair_detail_given},
          {"--hole-edges", OPTION_U32, &c.how.hole_edges_max, 0, REPAIR_HOLE_EDGES_MAX, NULL, "N",
           "repair: the most edges of a hole to fill (default 64)", &c.repair_detail_given},
          {"--union", OPTION_SWITCH, &c.unite, 0, 0, NULL, NULL, "unite solids that meet, say what came of it, and examine again",
           NULL},
          {"--json", OPTION_TEXT, &c.json_path, 0, 0, NULL, "FILE", "everything as JSON; - is standard output", NULL},
    };
    const command_line line = {"health",
                               "SCENE [options]",
                               "What keeps components of a scene from being solids, and what else is wrong with them.",
                               options,
                               sizeof options / sizeof *options,
                               1};
    int                help_shown;
    vxs_result         r = options_parse(&line, argc, argv, &c.path, &help_shown, &m);
    if (r == VXS_OK && !help_shown && c.repair_detail_given && !c.repair)
        r = fail(&m, VXS_E_ARGUMENT, "--stitch, --hole-diameter and --hole-edges go with --repair");
    if (r == VXS_OK && !help_shown) r = examine(&c, &m);
    return command_end(&m, r);
}
