/* vxs compare: error and time of a .vxs file against ray tracing. The JSON is described by docs/compare.schema.json.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/json_file.h"
#include "baker/base/parallel.h"
#include "baker/base/version.h"
#include "baker/command/asset_open.h"
#include "baker/command/light_text.h"
#include "baker/command/options.h"
#include "baker/truth/compare.h"

/* What the command returns when it worked and found the asset wrong. */
enum { STATUS_WRONG = 1 };

typedef struct compare_command {
    const char     *files[2]; /* scene, asset */
    const char     *scene_name, *json_path;
    compare_options options;
    int             closed, closed_given;
    double          max_error; /* share of wrong points that is accepted */
    int             max_error_given;

    size_t          triangle_count, solid_triangle_count;
    compare_result *results; /* [light count] */
} compare_command;

static const char *const kind_names[] = {"random", "surface"};

static double share(uint64_t part, uint64_t whole)
{
    return whole ? (double)part / (double)whole : 0;
}

/* all lights and kinds together ----------------------------------------------------------------------- */

static compare_counts total(const compare_command *c, uint32_t light_count)
{
    compare_counts sum = {0};
    for (uint32_t n = 0; n < light_count * COMPARE_KINDS; n++) {
        const compare_counts *one = &c->results[n / COMPARE_KINDS].counts[n % COMPARE_KINDS];
        sum.checked += one->checked;
        sum.leaks += one->leaks;
        sum.false_shadows += one->false_shadows;
        sum.unexplained += one->unexplained;
    }
    return sum;
}

static int passes(const compare_command *c, const compare_counts *sum)
{
    return !sum->unexplained && !(c->max_error_given && share(compare_wrong(sum), sum->checked) > c->max_error);
}

/* for people ------------------------------------------------------------------------------------------ */

static void print_counts(FILE *to, const char *name, const compare_counts *n)
{
    fprintf(to, "  %-9s %10llu %10llu %10llu %9.4f %% %9llu %9llu %9llu %9llu %11llu\n", name, (unsigned long long)n->checked,
            (unsigned long long)n->outside, (unsigned long long)n->inside_solid, 100 * share(compare_wrong(n), n->checked),
            (unsigned long long)n->leaks, (unsigned long long)n->false_shadows, (unsigned long long)n->near_boundary,
            (unsigned long long)n->near_surface, (unsigned long long)n->unexplained);
}

static void print_example(FILE *to, const compare_example *e)
{
    fprintf(to, "  unexplained: (%.9g, %.9g, %.9g)", e->point_ws[0], e->point_ws[1], e->point_ws[2]);
    if (e->kind == COMPARE_SURFACE) fprintf(to, ", normal (%.6g, %.6g, %.6g)", e->normal_ws[0], e->normal_ws[1], e->normal_ws[2]);
    fprintf(to, ", map %d, voxel (%d, %d, %d): asset %s, truth %s\n", e->map, e->voxel[0], e->voxel[1], e->voxel[2],
            e->asset_lit ? "lit" : "shadow", e->truth_lit ? "lit" : "shadow");
}

static void print_light(FILE *to, const compare_command *c, const vxs_light *l, const compare_result *r)
{
    const compare_counts *surface   = &r->counts[COMPARE_SURFACE];
    unsigned              filter_px = c->options.filter_px;
    char                  text[LIGHT_TEXT_BYTES];
    fprintf(to, "light %s: %s\n", l->name, light_text(text, l));
    fprintf(to, "  %-9s %10s %10s %10s %11s %9s %9s %9s %9s %11s\n", "points", "checked", "outside", "in solids", "wrong", "leaks",
            "shadows", "boundary", "surface", "unexplained");
    for (int kind = 0; kind < COMPARE_KINDS; kind++) print_counts(to, kind_names[kind], &r->counts[kind]);
    fprintf(to, "  at the surface itself: %.4f %% wrong\n", 100 * share(surface->wrong_at_surface, surface->checked_at_surface));
    for (uint32_t n = 0; n < r->example_count; n++) print_example(to, &r->examples[n]);
    for (int kind = 0; kind < COMPARE_KINDS && filter_px > 1; kind++)
        fprintf(to, "  %u x %u filter, %s points: RMSE %.4g, at most %.4g, of %llu points\n", filter_px, filter_px,
                kind_names[kind], r->filter[kind].rmse, r->filter[kind].max_error, (unsigned long long)r->filter[kind].points);
    fprintf(to, "  one thread: lookup %.1f ns", 1e9 * r->time.lookup_s);
    if (filter_px > 1) fprintf(to, ", %u x %u lookup %.1f ns", filter_px, filter_px, 1e9 * r->time.filter_s);
    if (r->time.truth_s > 0)
        fprintf(to, ", ray %.1f ns (%.3g million rays a second)", 1e9 * r->time.truth_s, 1e-6 / r->time.truth_s);
    fprintf(to, "\n");
}

static void print_report(FILE *to, const compare_command *c, const vxs_asset *asset)
{
    uint32_t       lights = vxs_asset_light_count(asset);
    compare_counts sum    = total(c, lights);
    char           closed[32];
    fprintf(to, "scene        %s: %zu triangles, %zu of solids (--closed %s)\n", c->files[0], c->triangle_count,
            c->solid_triangle_count, choice_word(closed, CLOSED_CHOICES, c->closed));
    fprintf(to, "asset        %s: %u lights\n", c->files[1], lights);
    for (uint32_t n = 0; n < lights; n++) print_light(to, c, vxs_asset_light(asset, n), &c->results[n]);
    fprintf(to, "%llu of %llu points wrong: %.4f %%, unexplained: %llu%s\n", (unsigned long long)compare_wrong(&sum),
            (unsigned long long)sum.checked, 100 * share(compare_wrong(&sum), sum.checked), (unsigned long long)sum.unexplained,
            passes(c, &sum) ? "" : "; FAILED");
}

/* for machines ---------------------------------------------------------------------------------------- */

static json_t *vector_json(const double v[3])
{
    return json_pack("[f,f,f]", v[0], v[1], v[2]);
}

static json_t *counts_json(const compare_counts *n)
{
    return json_pack("{s:I, s:I, s:I, s:I, s:I, s:f, s:I, s:I, s:I, s:I, s:I}", "points", (json_int_t)n->points, "outside",
                     (json_int_t)n->outside, "inside_solid", (json_int_t)n->inside_solid, "checked", (json_int_t)n->checked,
                     "wrong", (json_int_t)compare_wrong(n), "wrong_share", share(compare_wrong(n), n->checked), "leaks",
                     (json_int_t)n->leaks, "false_shadows", (json_int_t)n->false_shadows, "near_boundary",
                     (json_int_t)n->near_boundary, "near_surface", (json_int_t)n->near_surface, "unexplained",
                     (json_int_t)n->unexplained);
}

/* Surface points have the counts at the surface too. */
static json_t *surface_json(const compare_counts *n)
{
    json_t *counts = counts_json(n);
    json_object_set_new(counts, "checked_at_surface", json_integer((json_int_t)n->checked_at_surface));
    json_object_set_new(counts, "wrong_at_surface", json_integer((json_int_t)n->wrong_at_surface));
    json_object_set_new(counts, "wrong_at_surface_share", json_real(share(n->wrong_at_surface, n->checked_at_surface)));
    return counts;
}

static json_t *examples_json(const compare_result *r)
{
    json_t *examples = json_array();
    for (uint32_t n = 0; n < r->example_count; n++) {
        const compare_example *e = &r->examples[n];
        json_array_append_new(examples, json_pack("{s:s, s:o, s:o, s:i, s:[i,i,i], s:b, s:b}", "kind", kind_names[e->kind],
                                                  "point_m", vector_json(e->point_ws), "normal",
                                                  e->kind == COMPARE_SURFACE ? vector_json(e->normal_ws) : json_null(), "map",
                                                  e->map, "voxel", e->voxel[0], e->voxel[1], e->voxel[2], "asset_lit", e->asset_lit,
                                                  "truth_lit", e->truth_lit));
    }
    return examples;
}

static json_t *filter_json(const compare_filter *f)
{
    return json_pack("{s:I, s:f, s:f}", "points", (json_int_t)f->points, "rmse", f->rmse, "max_error", f->max_error);
}

static json_t *compared_light_json(const compare_command *c, const vxs_light *l, const compare_result *r)
{
    json_t *time = json_pack("{s:I, s:f, s:f}", "points", (json_int_t)r->time.points, "lookup_ns", 1e9 * r->time.lookup_s, "ray_ns",
                             1e9 * r->time.truth_s);
    json_t *light = light_json(l);
    json_object_set_new(light, "random", counts_json(&r->counts[COMPARE_RANDOM]));
    json_object_set_new(light, "surface", surface_json(&r->counts[COMPARE_SURFACE]));
    json_object_set_new(light, "unexplained", examples_json(r));
    json_object_set_new(light, "time", time);
    if (light && c->options.filter_px > 1) {
        json_object_set_new(time, "filter_lookup_ns", json_real(1e9 * r->time.filter_s));
        json_object_set_new(light, "filter",
                            json_pack("{s:i, s:o, s:o}", "filter_px", (int)c->options.filter_px, "random",
                                      filter_json(&r->filter[COMPARE_RANDOM]), "surface",
                                      filter_json(&r->filter[COMPARE_SURFACE])));
    }
    return light;
}

static json_t *report_json(const compare_command *c, const vxs_asset *asset)
{
    json_t        *lights = json_array();
    uint32_t       count  = vxs_asset_light_count(asset);
    compare_counts sum    = total(c, count);
    char           closed[32];
    for (uint32_t n = 0; n < count; n++)
        json_array_append_new(lights, compared_light_json(c, vxs_asset_light(asset, n), &c->results[n]));
    json_t *root =
        json_pack("{s:s, s:o, s:o, s:I, s:I, s:s, s:I, s:I, s:o, s:I, s:I, s:f, s:I, s:b}", "vxs", VXS_VERSION, "scene",
                  json_text(c->files[0]), "asset", json_text(c->files[1]), "triangles", (json_int_t)c->triangle_count,
                  "solid_triangles", (json_int_t)c->solid_triangle_count, "closed", choice_word(closed, CLOSED_CHOICES, c->closed),
                  "points", (json_int_t)c->options.points, "seed", (json_int_t)c->options.seed, "lights", lights, "checked",
                  (json_int_t)sum.checked, "wrong", (json_int_t)compare_wrong(&sum), "wrong_share",
                  share(compare_wrong(&sum), sum.checked), "unexplained", (json_int_t)sum.unexplained, "passed", passes(c, &sum));
    if (root && c->max_error_given) json_object_set_new(root, "max_error", json_real(c->max_error));
    return root;
}

/* the command ----------------------------------------------------------------------------------------- */

/* Which solids the asset was baked with, as its metadata says; auto where they do not. */
static int closed_of_asset(const vxs_asset *asset)
{
    const char *metadata = vxs_asset_contents(asset)->metadata;
    json_t     *root     = metadata ? json_loads(metadata, 0, NULL) : NULL;
    const char *text     = json_string_value(json_object_get(json_object_get(root, "options"), "closed"));
    int         closed   = text ? choice_index(CLOSED_CHOICES, text) : -1;
    json_decref(root);
    return closed < 0 ? CLOSED_AUTO : closed;
}

/* A comparison that checked nothing says nothing. */
static vxs_result require_checked(const compare_command *c, const vxs_light *l, const compare_result *result, message *m)
{
    uint64_t checked = 0, inside = 0;
    for (int kind = 0; kind < COMPARE_KINDS; kind++) {
        checked += result->counts[kind].checked;
        inside += result->counts[kind].inside_solid;
    }
    if (checked) return VXS_OK;
    if (!inside) return fail(m, VXS_E_ARGUMENT, "no point of %s lies in the volume of light '%s'", c->files[0], l->name);
    return fail(m, VXS_E_ARGUMENT, "all points of %s in the volume of light '%s' lie inside solids: expected more --points",
                c->files[0], l->name);
}

static vxs_result compare_lights(compare_command *c, const vxs_asset *asset, message *m)
{
    uint32_t   count   = vxs_asset_light_count(asset);
    scene      s       = {0};
    casters    casting = {0};
    truth     *t       = NULL;
    vxs_result r;

    if ((r = scene_load_gltf(&s, c->files[0], c->scene_name, m)) != VXS_OK) goto done;
    if ((r = casters_from_scene(&casting, &s, (closed_mode)c->closed, m)) != VXS_OK) goto done;
    if ((r = truth_create(&t, &casting, c->options.threads, m)) != VXS_OK) goto done;
    c->triangle_count       = casting.triangle_count;
    c->solid_triangle_count = casting.solid_triangle_count;

    c->results = calloc(count, sizeof *c->results);
    if (!c->results) r = fail(m, VXS_E_MEMORY, "out of memory for the results of %u lights", count);
    for (uint32_t n = 0; n < count && r == VXS_OK; n++)
        if ((r = compare_light(&c->results[n], t, &casting, vxs_asset_light(asset, n), &c->options, m)) == VXS_OK)
            r = require_checked(c, vxs_asset_light(asset, n), &c->results[n], m);
done:
    truth_destroy(t);
    casters_free(&casting);
    scene_free(&s);
    return r;
}

static vxs_result run(compare_command *c, int *passed, message *m)
{
    vxs_asset *asset = NULL;
    vxs_result r;
    if (c->options.filter_px % 2 == 0)
        return fail(m, VXS_E_ARGUMENT, "--filter %u: expected an odd number from 1 to %d", c->options.filter_px, VXS_FILTER_MAX);
    if ((r = asset_open(&asset, c->files[1], m)) != VXS_OK) goto done;
    if (!c->closed_given) c->closed = closed_of_asset(asset);
    if ((r = compare_lights(c, asset, m)) != VXS_OK) goto done;

    compare_counts sum = total(c, vxs_asset_light_count(asset));
    *passed            = passes(c, &sum);
    /* JSON that goes to standard output stays alone there */
    print_report(c->json_path && !strcmp(c->json_path, "-") ? stderr : stdout, c, asset);
    if (c->json_path) r = json_write(c->json_path, report_json(c, asset), m);
done:
    vxs_asset_close(asset);
    return r;
}

int cmd_compare(int argc, char **argv)
{
    compare_command c         = {.options = {.points = 100000, .seed = 1, .filter_px = 1, .threads = parallel_default_threads()}};
    const option    options[] = {
           {"--points", OPTION_U32, &c.options.points, 1, 1e9, NULL, "N", "points of each kind (default 100000)", NULL},
           {"--seed", OPTION_U32, &c.options.seed, 0, UINT32_MAX, NULL, "S", "another seed, other points (default 1)", NULL},
           {"--filter", OPTION_U32, &c.options.filter_px, 1, VXS_FILTER_MAX, NULL, "K",
            "also compare K x K box filters, K odd, 1 to 17 texels (default 1: single taps only)", NULL},
           {"--scene", OPTION_TEXT, &c.scene_name, 0, 0, NULL, "NAME", "name or index of the glTF scene (default: its own)", NULL},
           {"--closed", OPTION_CHOICE, &c.closed, 0, 0, CLOSED_CHOICES, NULL,
            "which casters are solids (default: as the asset was baked)", &c.closed_given},
           {"--threads", OPTION_U32, &c.options.threads, 1, PARALLEL_THREADS_MAX, NULL, "N", "threads (default: all processors)",
            NULL},
           {"--max-error", OPTION_F64, &c.max_error, 0, 1, NULL, "F", "share of wrong points that is accepted, 0 to 1 (default: any)",
            &c.max_error_given},
           {"--json", OPTION_TEXT, &c.json_path, 0, 0, NULL, "FILE", "the report as JSON; - is standard output", NULL},
    };
    const command_line line = {
        "compare",
        "SCENE FILE.vxs [options]",
        "Compare every light of a .vxs file with ray tracing, at random points and on surfaces. The exit status is 1 when "
        "an\n"
        "answer is wrong that no surface or shadow boundary within two voxels explains, or when more than --max-error are.",
        options,
        sizeof options / sizeof *options,
        2};
    message    m = {0};
    int        help_shown, passed = 1;
    vxs_result r = options_parse(&line, argc, argv, c.files, &help_shown, &m);
    if (r == VXS_OK && !help_shown) r = run(&c, &passed, &m);
    free(c.results);
    int status = command_end(&m, r);
    return r == VXS_OK && !passed ? STATUS_WRONG : status;
}
