/* The report of vxs compare; see compare_report.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/command/compare_report.h"

#include <math.h>
#include <string.h>

#include "baker/base/text.h"
#include "baker/base/version.h"
#include "baker/command/light_text.h"
#include "baker/command/options/options.h"
#include "baker/command/provenance_differences.h"
#include "baker/files/input_file.h"
#include "baker/files/json_file.h"

static const char *const kind_names[COMPARE_KINDS] = {"random", "surface", "camera"};

/* Sort kinds that were compared first. */
static int kind_count(const compare_report *r)
{
    return r->options.camera ? COMPARE_KINDS : COMPARE_CAMERA;
}

/* all lights together ---------------------------------------------------------------------------------------------------------- */

/* The sums of kinds [first, last] that decide the exit status. */
static compare_counts total(const compared_asset *a, int first, int last)
{
    compare_counts sum = {0};
    for (uint32_t n = 0; n < a->light_count; n++)
        for (int kind = first; kind <= last; kind++) {
            const compare_counts *one = &a->results[n].counts[kind];
            sum.checked += one->checked;
            sum.leaks += one->leaks;
            sum.false_shadows += one->false_shadows;
            sum.unexplained += one->unexplained;
        }
    return sum;
}

/* For all lights and kinds, single taps and filters. */
static compare_bias bias_of_all(const compare_report *r, const compared_asset *a)
{
    compare_bias sum = {0};
    for (uint32_t n = 0; n < a->light_count; n++)
        for (int kind = 0; kind < COMPARE_KINDS; kind++)
            for (uint32_t f = 0; f <= r->options.filter_count; f++) {
                const compare_result *one  = &a->results[n];
                const compare_bias   *bias = f ? &one->filters[f - 1].error[kind].bias : &one->counts[kind].bias;
                sum.self_shadows += bias->self_shadows;
                sum.deep_leaks += bias->deep_leaks;
            }
    return sum;
}

static compare_counts total_of_all(const compared_asset *a)
{
    return total(a, 0, COMPARE_KINDS - 1);
}

static double wrong_share(const compare_counts *n)
{
    return n->checked ? (double)compare_wrong(n) / (double)n->checked : 0;
}

static int compare_asset_passes(const compare_report *r, const compared_asset *a)
{
    compare_counts sum  = total_of_all(a);
    compare_bias   bias = bias_of_all(r, a);
    return !sum.unexplained && !bias.self_shadows && !bias.deep_leaks && !(r->max_error_given && wrong_share(&sum) > r->max_error);
}

int compare_passes(const compare_report *r)
{
    for (size_t n = 0; n < r->asset_count; n++)
        if (!compare_asset_passes(r, &r->assets[n])) return 0;
    return 1;
}

/* Sums over all lights, as for a single one. */
static double rmse_of_all(const compared_asset *a, uint32_t filter, int kind)
{
    double squares = 0, points = 0;
    for (uint32_t n = 0; n < a->light_count; n++) {
        const compare_error *e = &a->results[n].filters[filter].error[kind];
        squares += e->rmse * e->rmse * (double)e->points;
        points += (double)e->points;
    }
    return points > 0 ? sqrt(squares / points) : 0;
}

static double lookup_seconds_of_all(const compared_asset *a)
{
    double seconds = 0, points = 0;
    for (uint32_t n = 0; n < a->light_count; n++) {
        const compare_time *t = &a->results[n].time;
        seconds += t->lookup_s * (double)t->points;
        points += (double)t->points;
    }
    return points > 0 ? seconds / points : 0;
}

/* as text ---------------------------------------------------------------------------------------------------------------------- */

static void print_bias(FILE *to, const char *points, const compare_bias *bias)
{
    fprintf(to, "  %s points in their own shadow: %llu; in light deep behind casters: %llu\n", points,
            (unsigned long long)bias->self_shadows, (unsigned long long)bias->deep_leaks);
}

/* Faults of the bias, examples, filters and times of a light. */
static void print_light_details(FILE *to, const compare_report *r, const compare_result *result)
{
    static const char *const texts[] = {"", "unexplained", "in its own shadow", "in light deep behind casters"};
    const compare_time      *t       = &result->time;
    char                     text[32];
    for (int kind = COMPARE_SURFACE; kind < kind_count(r); kind++) print_bias(to, kind_names[kind], &result->counts[kind].bias);
    for (const compare_example *e = result->examples; e < result->examples + result->example_count; e++) {
        fprintf(to, "  %s: (%.9g, %.9g, %.9g)", texts[e->fault], e->point_ws[0], e->point_ws[1], e->point_ws[2]);
        if (e->kind != COMPARE_RANDOM)
            fprintf(to, ", normal (%.6g, %.6g, %.6g)", e->normal_ws[0], e->normal_ws[1], e->normal_ws[2]);
        fprintf(to, ", map %d, voxel (%d, %d, %d): asset %s, truth %s\n", e->map, e->voxel[0], e->voxel[1], e->voxel[2],
                e->asset_lit ? "lit" : "shadow", e->truth_lit ? "lit" : "shadow");
    }
    for (uint32_t n = 0; n < r->options.filter_count; n++)
        for (int kind = 0; kind < kind_count(r); kind++) {
            const compare_error *e = &result->filters[n].error[kind];
            fprintf(to, "  %s filter, %s points: RMSE %.4g, at most %.4g, of %llu points\n",
                    filter_text(text, r->options.filters[n]), kind_names[kind], e->rmse, e->max_error,
                    (unsigned long long)e->points);
            if (kind != COMPARE_RANDOM) print_bias(to, kind_names[kind], &e->bias);
        }
    fprintf(to, "  one thread: lookup %.1f ns", 1e9 * t->lookup_s);
    for (uint32_t n = 0; n < r->options.filter_count; n++)
        fprintf(to, ", %s lookup %.1f ns", filter_text(text, r->options.filters[n]), 1e9 * result->filters[n].lookup_s);
    if (t->truth_s > 0) fprintf(to, ", ray %.1f ns (%.3g million rays a second)", 1e9 * t->truth_s, 1e-6 / t->truth_s);
    fprintf(to, "\n");
}

static void print_light(FILE *to, const compare_report *r, const vxs_light *l, const compare_result *result)
{
    int  wrong = 0;
    char text[LIGHT_TEXT_BYTES], plain[PLAIN_BYTES];
    fprintf(to, "light %s: %s\n", plain_text(plain, l->name), light_text(text, l));
    fprintf(to, "  %-9s %10s %10s %10s %11s %9s %9s %9s %9s %11s\n", "points", "checked", "outside", "in solids", "wrong", "leaks",
            "shadows", "boundary", "surface", "unexplained");
    for (int kind = 0; kind < kind_count(r); kind++) {
        const compare_counts *n = &result->counts[kind];
        fprintf(to, "  %-9s %10llu %10llu %10llu %9.4f %% %9llu %9llu %9llu %9llu %11llu\n", kind_names[kind],
                (unsigned long long)n->checked, (unsigned long long)n->outside, (unsigned long long)n->inside_solid,
                100 * wrong_share(n), (unsigned long long)n->leaks, (unsigned long long)n->false_shadows,
                (unsigned long long)n->near_boundary, (unsigned long long)n->near_surface, (unsigned long long)n->unexplained);
        wrong |= compare_wrong(n) > 0;
    }
    for (int kind = 0; kind < kind_count(r); kind++)
        if (result->counts[kind].left_free)
            fprintf(to, "  %-9s %10llu besides: lit where no light comes, where the bake had don't-care voxels\n", kind_names[kind],
                    (unsigned long long)result->counts[kind].left_free);
    if (wrong)
        fprintf(to, "  %-9s %10s %10s %10s %11s %9s %9s   texels from a wrong answer to the nearest boundary\n", "wrong", "found",
                "beyond", "mean", "median", "95 %", "most");
    for (int kind = 0; kind < kind_count(r); kind++) {
        const compare_distance *d = &result->counts[kind].boundary;
        if (!compare_wrong(&result->counts[kind])) continue;
        fprintf(to, "  %-9s %10llu %10llu", kind_names[kind], (unsigned long long)d->points, (unsigned long long)d->beyond);
        if (d->points) fprintf(to, " %10.3f %11.3f %9.3f %9.3f", d->mean, d->median, d->p95, d->max);
        fprintf(to, "\n");
    }
    print_light_details(to, r, result);
}

/* "FAILED" with the reason; "passed". */
static void print_judgement(FILE *to, const compare_report *r, const compared_asset *a, const run_context *m)
{
    compare_counts sum    = total_of_all(a);
    compare_bias   bias   = bias_of_all(r, a);
    int            passes = compare_asset_passes(r, a);
    char           word[COLORED_BYTES];
    fputs(colored(word, m->color, to, passes ? COLOR_GREEN : COLOR_RED, passes ? "passed" : "FAILED"), to);
    const char *before = ":";
    if (sum.unexplained) {
        fprintf(to, "%s %llu wrong answers that nothing explains", before, (unsigned long long)sum.unexplained);
        before = ", and";
    }
    if (bias.self_shadows) {
        fprintf(to, "%s %llu points of surfaces in their own shadow", before, (unsigned long long)bias.self_shadows);
        before = ", and";
    }
    if (bias.deep_leaks) {
        fprintf(to, "%s %llu points in light deep behind casters", before, (unsigned long long)bias.deep_leaks);
        before = ", and";
    }
    if (r->max_error_given && wrong_share(&sum) > r->max_error)
        fprintf(to, "%s more is wrong than --max-error %g", before, r->max_error);
    if (!passes && !m->verbose) fprintf(to, "; --verbose says where");
    fprintf(to, "\n");
}

static void print_other_scene(FILE *to, const compared_asset *a)
{
    char differ[PROVENANCE_TEXT_BYTES];
    if (json_array_size(a->scene_differences))
        fprintf(to, "other scene  than it was baked from: %s\n", provenance_differences_text(differ, a->scene_differences));
}

static void print_asset_head(FILE *to, const compared_asset *a)
{
    char     file[32], memory[32], plain[PLAIN_BYTES];
    uint32_t all = vxs_asset_light_count(a->asset);
    fprintf(to, "asset        %s: ", plain_text(plain, input_name(a->path)));
    if (a->light_count < all) fprintf(to, "%u of ", a->light_count);
    fprintf(to, "%u light%s, a file of %s, %s in memory\n", all, all > 1 ? "s" : "", size_text(file, a->file_bytes),
            size_text(memory, a->memory_bytes));
    print_other_scene(to, a);
}

static void print_asset_in_short(FILE *to, const compare_report *r, const compared_asset *a, const run_context *m)
{
    compare_counts sum = total_of_all(a);
    print_asset_head(to, a);
    fprintf(to, "wrong        %.3g %% of %llu points", 100 * wrong_share(&sum), (unsigned long long)sum.checked);
    for (int kind = 0; kind < kind_count(r); kind++) {
        compare_counts one = total(a, kind, kind);
        fprintf(to, "%s%s %.2g", kind ? ", " : " (", kind_names[kind], 100 * wrong_share(&one));
    }
    fprintf(to, ")\n");
    for (uint32_t f = 0; f < r->options.filter_count; f++) {
        fprintf(to, "%-12s ", f ? "" : "filters");
        char text[32];
        fprintf(to, "%s: RMSE", filter_text(text, r->options.filters[f]));
        for (int kind = 0; kind < kind_count(r); kind++)
            fprintf(to, "%s %s %.4f", kind ? "," : "", kind_names[kind], rmse_of_all(a, f, kind));
        fprintf(to, "\n");
    }
    fprintf(to, "lookup       %.1f ns on one thread\n", 1e9 * lookup_seconds_of_all(a));
    fprintf(to, "result       ");
    print_judgement(to, r, a, m);
}

static void print_asset(FILE *to, const compare_report *r, const compared_asset *a, const run_context *m)
{
    compare_counts sum = total_of_all(a);
    char           memory[32], closed[32];
    print_asset_head(to, a);
    fprintf(to, "casters      %zu triangles, %zu of solids (--closed %s)\n", a->triangle_count, a->solid_triangle_count,
            choice_word(closed, CLOSED_CHOICES, (int)a->closed));
    if (a->bake_given)
        fprintf(to, "bake         %.15g s, peak memory %s\n", rounded(a->bake_seconds, 3), size_text(memory, a->bake_peak_bytes));
    for (uint32_t n = 0; n < a->light_count; n++) print_light(to, r, &a->lights[n]->light, &a->results[n]);
    fprintf(to, "%llu of %llu points wrong: %.4f %%, unexplained: %llu; ", (unsigned long long)compare_wrong(&sum),
            (unsigned long long)sum.checked, 100 * wrong_share(&sum), (unsigned long long)sum.unexplained);
    print_judgement(to, r, a, m);
}

/* "4096", or "64-4096" if lights differ. */
static const char *texels_text(char text[32], const compared_asset *a)
{
    uint32_t least = UINT32_MAX, most = 0;
    for (uint32_t n = 0; n < a->light_count; n++) {
        uint32_t side = (uint32_t)1 << a->lights[n]->light.levels;
        if (side < least) least = side;
        if (side > most) most = side;
    }
    snprintf(text, 32, least < most ? "%u-%u" : "%u", least, most);
    return text;
}

/* The width of a filter's column. */
static int filter_column(const compare_report *r, uint32_t f)
{
    return (r->options.filters[f].is_smooth ? 22 : 15) + 8 * kind_count(r);
}

/* One row for each asset; its name is last, since it may be long. */
static void print_table(FILE *to, const compare_report *r, const run_context *m)
{
    char text[64], word[COLORED_BYTES], plain[PLAIN_BYTES];
    fprintf(to, "%-12s %11s %11s %9s %9s", "texels", "file", "memory", "bake", "lookup");
    for (int kind = 0; kind < kind_count(r); kind++) {
        snprintf(text, sizeof text, "wrong %s", kind_names[kind]);
        fprintf(to, " %14s", text);
    }
    for (uint32_t f = 0; f < r->options.filter_count; f++) {
        char filter[32];
        snprintf(text, sizeof text, "RMSE %s %s", filter_text(filter, r->options.filters[f]),
                 r->options.camera ? "random/surface/camera" : "random/surface");
        fprintf(to, "  %*s", filter_column(r, f), text);
    }
    fprintf(to, "  asset\n");
    for (size_t n = 0; n < r->asset_count; n++) {
        const compared_asset *a = &r->assets[n];
        fprintf(to, "%-12s", texels_text(text, a));
        fprintf(to, " %11s", size_text(text, a->file_bytes));
        fprintf(to, " %11s", size_text(text, a->memory_bytes));
        snprintf(text, sizeof text, "%.15g s", rounded(a->bake_seconds, 3));
        fprintf(to, " %9s %6.1f ns", a->bake_given ? text : "-", 1e9 * lookup_seconds_of_all(a));
        for (int kind = 0; kind < kind_count(r); kind++) {
            compare_counts sum = total(a, kind, kind);
            fprintf(to, " %12.4f %%", 100 * wrong_share(&sum));
        }
        for (uint32_t f = 0; f < r->options.filter_count; f++) {
            int length = 0;
            for (int kind = 0; kind < kind_count(r); kind++)
                length += snprintf(text + length, sizeof text - (size_t)length, "%s%.4f", kind ? "/" : "", rmse_of_all(a, f, kind));
            fprintf(to, "  %*s", filter_column(r, f), text);
        }
        fprintf(to, "  %s%s%s\n", plain_text(plain, input_name(a->path)), compare_asset_passes(r, a) ? "" : "; ",
                compare_asset_passes(r, a) ? "" : colored(word, m->color, to, COLOR_RED, "FAILED"));
        if (!m->verbose) print_other_scene(to, a);
    }
}

void compare_print(FILE *to, const compare_report *r, const run_context *m)
{
    char plain[PLAIN_BYTES];
    fprintf(to, "scene        %s\n", plain_text(plain, input_name(r->scene_path)));
    if (r->options.camera && m->verbose) {
        const camera_pose *c = r->options.camera;
        uint32_t           width_px, height_px;
        compare_picture_size(r->options.points, &width_px, &height_px);
        fprintf(to, "camera       at (%.6g, %.6g, %.6g) towards (%.6g, %.6g, %.6g), %.4g degrees, %u x %u pixels\n", c->eye_ws[0],
                c->eye_ws[1], c->eye_ws[2], c->target_ws[0], c->target_ws[1], c->target_ws[2], c->fov_degrees, width_px, height_px);
    }
    for (size_t n = 0; n < r->asset_count && m->verbose; n++) print_asset(to, r, &r->assets[n], m);
    if (r->asset_count > 1)
        print_table(to, r, m);
    else if (!m->verbose)
        print_asset_in_short(to, r, &r->assets[0], m);
}

/* as JSON ---------------------------------------------------------------------------------------------------------------------- */

/* null when there are no points. */
static json_t *texels_json(const compare_distance *d, double texels)
{
    return d->points ? json_real(texels) : json_null();
}

/* Random points have no bias. */
static void set_bias(json_t *object, int kind, const compare_bias *bias)
{
    if (kind == COMPARE_RANDOM) return;
    json_object_set_new(object, "self_shadows", json_integer((json_int_t)bias->self_shadows));
    json_object_set_new(object, "deep_leaks", json_integer((json_int_t)bias->deep_leaks));
}

static json_t *counts_json(const compare_counts *n, compare_kind kind)
{
    const compare_distance *d = &n->boundary;
    json_t *distance = json_pack("{s:I, s:I, s:o, s:o, s:o, s:o}", "points", (json_int_t)d->points, "beyond", (json_int_t)d->beyond,
                                 "mean", texels_json(d, d->mean), "median", texels_json(d, d->median), "p95",
                                 texels_json(d, d->p95), "max", texels_json(d, d->max));
    json_t *counts = json_pack("{s:I, s:I, s:I, s:I, s:I, s:I, s:f, s:I, s:I, s:I, s:I, s:I, s:o}", "points", (json_int_t)n->points,
                               "outside", (json_int_t)n->outside, "inside_solid", (json_int_t)n->inside_solid, "left_free",
                               (json_int_t)n->left_free, "checked", (json_int_t)n->checked, "wrong", (json_int_t)compare_wrong(n),
                               "wrong_share", wrong_share(n), "leaks", (json_int_t)n->leaks, "false_shadows",
                               (json_int_t)n->false_shadows, "near_boundary", (json_int_t)n->near_boundary, "near_surface",
                               (json_int_t)n->near_surface, "unexplained", (json_int_t)n->unexplained, "boundary_texels", distance);
    set_bias(counts, kind, &n->bias);
    return counts;
}

static json_t *examples_json(const compare_result *result)
{
    static const char *const names[]  = {"", "unexplained", "self_shadow", "deep_leak"};
    json_t                  *examples = json_array();
    for (uint32_t n = 0; n < result->example_count; n++) {
        const compare_example *e = &result->examples[n];
        json_array_append_new(examples, json_pack("{s:s, s:s, s:o, s:o, s:i, s:[i,i,i], s:b, s:b}", "fault", names[e->fault],
                                                  "kind", kind_names[e->kind], "point_m", json_vector(e->point_ws), "normal",
                                                  e->kind == COMPARE_RANDOM ? json_null() : json_vector(e->normal_ws), "map",
                                                  e->map, "voxel", e->voxel[0], e->voxel[1], e->voxel[2], "asset_lit", e->asset_lit,
                                                  "truth_lit", e->truth_lit));
    }
    return examples;
}

static json_t *filters_json(const compare_report *r, const compare_result *result)
{
    json_t *filters = json_array();
    for (uint32_t n = 0; n < r->options.filter_count; n++) {
        const compare_filter *f      = &result->filters[n];
        vxs_filter            filter = r->options.filters[n];
        json_t *one = json_pack("{s:I, s:b, s:f}", "filter_px", (json_int_t)filter.width_px, "smooth", filter.is_smooth,
                                "lookup_ns", 1e9 * f->lookup_s);
        for (int kind = 0; kind < kind_count(r); kind++) {
            const compare_error *e = &f->error[kind];
            json_t              *error =
                json_pack("{s:I, s:f, s:f}", "points", (json_int_t)e->points, "rmse", e->rmse, "max_error", e->max_error);
            set_bias(error, kind, &e->bias);
            json_object_set_new(one, kind_names[kind], error);
        }
        json_array_append_new(filters, one);
    }
    return filters;
}

/* The triangles that an asset was compared with: members of each asset, and, for the first one, of the whole report. */
static void set_casters(json_t *object, const compared_asset *a)
{
    char closed[32];
    json_object_set_new(object, "triangles", json_integer((json_int_t)a->triangle_count));
    json_object_set_new(object, "solid_triangles", json_integer((json_int_t)a->solid_triangle_count));
    json_object_set_new(object, "closed", json_string(choice_word(closed, CLOSED_CHOICES, (int)a->closed)));
}

static json_t *asset_json(const compare_report *r, const compared_asset *a)
{
    compare_counts sum    = total_of_all(a);
    json_t        *lights = json_array();
    for (uint32_t n = 0; n < a->light_count; n++) {
        const compare_result *result = &a->results[n];
        json_t               *light  = light_json(&a->lights[n]->light);
        for (int kind = 0; kind < kind_count(r); kind++)
            json_object_set_new(light, kind_names[kind], counts_json(&result->counts[kind], (compare_kind)kind));
        json_object_set_new(light, "faults", examples_json(result));
        json_object_set_new(light, "filters", filters_json(r, result));
        json_object_set_new(light, "time",
                            json_pack("{s:I, s:f, s:f}", "points", (json_int_t)result->time.points, "lookup_ns",
                                      1e9 * result->time.lookup_s, "ray_ns", 1e9 * result->time.truth_s));
        json_array_append_new(lights, light);
    }
    json_t *root = json_pack("{s:o, s:I, s:I, s:I, s:o, s:I, s:I, s:f, s:I, s:b}", "asset", json_text(a->path), "file_bytes",
                             (json_int_t)a->file_bytes, "memory_bytes", (json_int_t)a->memory_bytes, "lights_in_file",
                             (json_int_t)vxs_asset_light_count(a->asset), "lights", lights, "checked", (json_int_t)sum.checked,
                             "wrong", (json_int_t)compare_wrong(&sum), "wrong_share", wrong_share(&sum), "unexplained",
                             (json_int_t)sum.unexplained, "passed", compare_asset_passes(r, a));
    set_casters(root, a);
    json_object_set(root, "scene_differences", a->scene_differences);
    if (a->bake_given)
        json_object_set_new(
            root, "bake", json_pack("{s:f, s:I}", "total_seconds", a->bake_seconds, "peak_bytes", (json_int_t)a->bake_peak_bytes));
    return root;
}

json_t *compare_json(const compare_report *r)
{
    json_t *assets = json_array();
    for (size_t n = 0; n < r->asset_count; n++) json_array_append_new(assets, asset_json(r, &r->assets[n]));
    json_t *root = json_pack("{s:s, s:o, s:I, s:I, s:o, s:b}", "vxs", VXS_VERSION, "scene", json_text(r->scene_path), "points",
                             (json_int_t)r->options.points, "seed", (json_int_t)r->options.seed, "assets", assets, "passed",
                             compare_passes(r));
    set_casters(root, &r->assets[0]);
    const camera_pose *c = r->options.camera;
    if (c) {
        uint32_t width_px, height_px;
        compare_picture_size(r->options.points, &width_px, &height_px);
        json_object_set_new(root, "camera",
                            json_pack("{s:o, s:o, s:f, s:I, s:I}", "eye_m", json_vector(c->eye_ws), "target_m",
                                      json_vector(c->target_ws), "fov_degrees", c->fov_degrees, "width_px", (json_int_t)width_px,
                                      "height_px", (json_int_t)height_px));
    }
    if (r->max_error_given) json_object_set_new(root, "max_error", json_real(r->max_error));
    return root;
}
