/* A plan as text; see plan_text.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/command/report/plan_text.h"

#include <math.h>
#include <stdarg.h>
#include <string.h>

#include "baker/base/text.h"
#include "baker/base/version.h"
#include "baker/files/json_file.h"

/* decisions ------------------------------------------------------------------------------------------------------------------- */

/* "exit map", "left out", "nothing is solid: ..." */
typedef struct plan_decision {
    const char *name;
    char        choice[64];
    char        reason[256];
} plan_decision;

typedef struct decision_list {
    plan_decision items[16];
    size_t        count;
} decision_list;

#if defined(__GNUC__)
__attribute__((format(printf, 4, 5)))
#endif
static void
decide(decision_list *l, const char *name, const char *choice, const char *format, ...)
{
    plan_decision *d = &l->items[l->count++];
    va_list        arguments;
    d->name = name;
    snprintf(d->choice, sizeof d->choice, "%s", choice);
    va_start(arguments, format);
    vsnprintf(d->reason, sizeof d->reason, format, arguments);
    va_end(arguments);
}

typedef struct block_sums {
    unsigned long long tiles, tiles_empty, blocks_peeled, blocks_not_peeled;
} block_sums;

static block_sums sums_of(const bake_plan *plan)
{
    block_sums s = {0};
    for (size_t n = 0; n < plan->light_count; n++) {
        s.tiles += plan->lights[n].tiles;
        s.tiles_empty += plan->lights[n].tiles_empty;
        s.blocks_peeled += plan->lights[n].sample.blocks_peeled;
        s.blocks_not_peeled += plan->lights[n].sample.blocks_not_peeled;
    }
    return s;
}

static void decide_exit(decision_list *l, const bake_plan *plan, const bake_options *o, const casters *c)
{
    size_t     solids = c->component_count[COMPONENT_SOLID];
    block_sums s      = sums_of(plan);
    if (!plan->has_exit_map) {
        decide(l, "exit map", "none", "no component is solid: light leaves a sheet where it enters");
        return;
    }
    decide(l, "exit map", "made", "%zu solids with %zu triangles have an inside, where voxels are don't-care", solids,
           c->solid_triangle_count);
    if (o->maps == MAPS_SPARSE) {
        decide(l, "peeling", "nowhere", "--maps sparse: faces are counted where a tile is looked at texel by texel");
    } else if (o->exit == EXIT_BACK) {
        decide(l, "peeling", "nowhere", "--exit back: the nearest back face, sooner found, and a larger file where solids meet");
    } else if (o->exit == EXIT_PEEL) {
        decide(l, "peeling", "everywhere", "--exit peel: all %llu blocks with solids", s.blocks_peeled);
    } else if (plan->meeting_known) {
        decide(l, "peeling", s.blocks_peeled ? "where solids meet" : "nowhere",
               "%zu of %zu solids meet another or themselves%s: %llu blocks need it, %llu with solids do not", c->meeting.meet,
               c->meeting.solids, c->meeting.assumed ? " (assumed: the search took too long)" : "", s.blocks_peeled,
               s.blocks_not_peeled);
    } else {
        decide(l, "peeling", "everywhere",
               "finding out which solids meet takes about %.15g s, and peeling all %llu blocks with solids no more than %.15g s",
               rounded(plan->meeting_seconds, 2), s.blocks_peeled, rounded(plan->peeling_seconds, 2));
    }
}

static void decide_memory(decision_list *l, const bake_plan *plan)
{
    char choice[64], a[32], b[32];
    snprintf(choice, sizeof choice, "%u x %u texels", plan->tile_px, plan->tile_px);
    if (!plan->budget_bytes)
        decide(l, "tile size", choice, "no --memory: the largest, or the map itself");
    else
        decide(l, "tile size", choice, "--memory %s: about %s with these tiles", size_text(a, plan->budget_bytes),
               size_text(b, plan->peak_bytes));
}

static void decide_lights(decision_list *l, const bake_plan *plan, const bake_report *report)
{
    char   choice[64];
    size_t nothing = plan->light_count - plan->baked_count, unrequested = 0;
    snprintf(choice, sizeof choice, "%zu baked", plan->baked_count);
    for (size_t n = 0; n < report->left_out_count; n++) unrequested += !strcmp(report->left_out[n].why, "not requested");
    size_t others = report->left_out_count - nothing - unrequested;
    if (!report->left_out_count)
        decide(l, "lights", choice, "none is left out");
    else if (!others)
        decide(l, "lights", choice, "%zu left out: %zu not requested, %zu that reach no caster", report->left_out_count,
               unrequested, nothing);
    else
        decide(l, "lights", choice,
               "%zu left out: %zu not requested, %zu that reach no caster, %zu that are dark, hidden or faulty",
               report->left_out_count, unrequested, nothing, others);
}

/* The decisions, and the reason of each. */
static decision_list decisions_of(const bake_plan *plan, const bake_options *o, const bake_report *report)
{
    decision_list l = {0};
    block_sums    s = sums_of(plan);
    char          choice[64];
    decide_lights(&l, plan, report);
    decide_exit(&l, plan, o, &report->casters);
    snprintf(choice, sizeof choice, "%llu of %llu", s.tiles - s.tiles_empty, s.tiles);
    decide(&l, "tiles", choice, "%llu that no caster may touch are left out: they are lit", s.tiles_empty);
    decide_memory(&l, plan);
    if (o->coding == CODING_DAG) {
        if (o->stop == STOP_INSERT)
            decide(&l, "sub-DAG compression", "left out", "--stop insert");
        else if (o->stop == STOP_PARTIAL)
            decide(&l, "sub-DAG compression", "done", "--stop partial: it is the last step");
        else if (o->compress != COMPRESS_CHOICE_AUTO)
            decide(&l, "sub-DAG compression", "done", "--compress %s",
                   o->compress == COMPRESS_CHOICE_BOTTOM_UP ? "bottom-up" : "top-down");
        else
            decide(&l, "sub-DAG compression", plan->compress != COMPRESS_NONE ? "done" : "left out",
                   "it would take about %.15g s on %u threads and spare the merge, which finds the same, about %.15g s",
                   rounded(plan->compress_seconds, 2), o->threads, rounded(plan->merge_seconds_spared, 2));
    }
    decide(&l, "file",
           o->coding == CODING_DAG ? "levels and masks of each light"
           : o->pack == PACK_SMALL ? "tops, patterns and pages of each light, packed small"
                                   : "tops, patterns and pages of each light, packed fast",
           "no depth maps, no names or materials of the scene, no empty section");
    return l;
}

/* for people ------------------------------------------------------------------------------------------------------------------ */

void report_print_excluded(FILE *to, const bake_report *r, const char *head)
{
    char rule[128];
    for (const scene_exclusion *e = r->exclusions; e < r->exclusions + r->exclusion_count; e++)
        fprintf(to, "%-12s %zu triangles excluded: %s\n", head, e->triangles, exclusion_text(rule, e));
}

void report_print_casters(FILE *to, const bake_report *r)
{
    const casters *c = &r->casters;
    fprintf(to, "casters      %zu triangles, %zu solids with %zu triangles\n", casters_whole_count(c),
            c->component_count[COMPONENT_SOLID], c->solid_triangle_count);
    for (int kind = COMPONENT_SOLID + 1; kind < COMPONENT_KINDS; kind++)
        if (c->component_count[kind])
            fprintf(to, "             %zu sheets with %zu triangles: %s\n", c->component_count[kind], c->triangles_of_kind[kind],
                    component_kind_name((component_kind)kind));
    report_print_excluded(to, r, "");
    if (c->collapsed_count) fprintf(to, "             %zu triangles left out: two corners in one place\n", c->collapsed_count);
    if (c->borders.split || c->borders.joined)
        fprintf(to, "             %zu edges split where borders meet, %zu triangles more, %zu vertices joined\n", c->borders.split,
                c->borders.added, c->borders.joined);
    fprintf(to, "             %.6g x %.6g x %.6g m\n", r->casters_max_ws[0] - r->casters_min_ws[0],
            r->casters_max_ws[1] - r->casters_min_ws[1], r->casters_max_ws[2] - r->casters_min_ws[2]);
}

void plan_print_decisions(FILE *to, const bake_plan *plan, const bake_options *o, const bake_report *report)
{
    decision_list l = decisions_of(plan, o, report);
    for (const plan_decision *d = l.items; d < l.items + l.count; d++) fprintf(to, "%-20s %s: %s\n", d->name, d->choice, d->reason);
}

const char *texels_text(char text[TEXELS_BYTES], const texel_range *t, int digits)
{
    if (t->least == t->most)
        snprintf(text, TEXELS_BYTES, "%.15g m", rounded(t->median, digits));
    else
        snprintf(text, TEXELS_BYTES, "%.15g to %.15g m at casters, median %.15g m", rounded(t->least, digits),
                 rounded(t->most, digits), rounded(t->median, digits));
    return text;
}

json_t *texels_json(const texel_range *t)
{
    return json_pack("{s:f, s:f, s:f}", "least", t->least, "median", t->median, "most", t->most);
}

void plan_print_estimate(FILE *to, const bake_plan *plan)
{
    char a[32], b[32], c[32];
    fprintf(to, "estimate     %.15g s, %s of memory, a file of %s, %s when loaded\n", rounded(plan->total_seconds, 2),
            size_text(a, plan->peak_bytes), size_text(b, plan->file_bytes), size_text(c, plan->memory_bytes));
}

static const char *share_words(double share)
{
    static const struct {
        double      share;
        const char *words;
    } known[]   = {{0.1, "a tenth"}, {0.2, "a fifth"},      {0.25, "a quarter"},     {1.0 / 3, "a third"},     {0.4, "two fifths"},
                   {0.5, "half"},    {0.6, "three fifths"}, {2.0 / 3, "two thirds"}, {0.75, "three quarters"}, {0.8, "four fifths"}};
    size_t best = 0;
    for (size_t n = 1; n < sizeof known / sizeof *known; n++)
        if (fabs(known[n].share - share) < fabs(known[best].share - share)) best = n;
    return known[best].words;
}

void plan_print_savings(FILE *to, const bake_plan *plan, uint64_t file_bytes)
{
    char a[32];
    for (const plan_saving *s = plan->savings; s < plan->savings + plan->saving_count; s++) {
        double share = (double)s->file_bytes / (double)plan->file_bytes;
        fprintf(to, "%-12s %s: %.15g s, a file of %s, ", s == plan->savings ? "would save" : "", s->option, rounded(s->seconds, 2),
                size_text(a, (uint64_t)(share * (double)file_bytes)));
        if (s->triangles)
            fprintf(to,
                    "about %s: %zu triangles are closed, but their material has two sides; it promises nothing inside of them\n",
                    share_words(share), s->triangles);
        else
            fprintf(to, "which promises less\n");
    }
}

void plan_print(FILE *to, const bake_options *o, const bake_report *report)
{
    const bake_plan *plan = report->plan;
    char             plain[PLAIN_BYTES];
    fprintf(to, "scene        %s\n", plain_text(plain, o->scene_path));
    report_print_casters(to, report);
    plan_print_decisions(to, plan, o, report);
    for (const plan_light *l = plan->lights; l < plan->lights + plan->light_count; l++) {
        char     name[VXS_LIGHT_NAME_BYTES], a[TEXELS_BYTES], b[32];
        unsigned side = 1u << l->light.levels;
        one_line(strcpy(name, l->name));
        if (l->left_out) {
            fprintf(to, "light %s is left out: it %s\n", name, l->left_out);
            continue;
        }
        fprintf(to, "light %s\n", name);
        fprintf(to, "  map        %u of %u x %u texels of %s, voxels %.4g %s deep\n", l->map_count, side, side,
                texels_text(a, &l->texels, 4), l->light.voxel_metres,
                l->light.kind == VXS_LIGHT_KIND_DIRECTIONAL ? "m" : "of the distance");
        fprintf(to, "  tiles      %llu, left out without casters: %llu", (unsigned long long)l->tiles,
                (unsigned long long)l->tiles_empty);
        if (o->maps != MAPS_SPARSE)
            fprintf(to, "; %llu blocks to render, %llu of them to peel",
                    (unsigned long long)(l->sample.blocks - l->sample.blocks_empty), (unsigned long long)l->sample.blocks_peeled);
        fprintf(to, "\n");
        if (l->light.coding == VXS_CODING_DAG)
            fprintf(to, "  about      %.15g masks, %.15g nodes", rounded(l->masks, 3), rounded(l->nodes, 3));
        else
            fprintf(to, "  about      %.15g palette blocks, %.15g patterns", rounded(l->palette.blocks, 3),
                    rounded(l->palette.patterns, 3));
        fprintf(to, "; %s in memory, %s on disk\n", size_text(a, (uint64_t)l->memory_bytes),
                size_text(b, (uint64_t)l->stored_bytes));
    }
    for (size_t n = 0; n < report->left_out_count; n++)
        if (report->left_out[n].why != REACHES_NOTHING) {
            char name[VXS_LIGHT_NAME_BYTES];
            fprintf(to, "light %s is left out: %s\n", one_line(strcpy(name, report->left_out[n].name)), report->left_out[n].why);
        }
    plan_print_estimate(to, plan);
    plan_print_savings(to, plan, plan->file_bytes);
}

/* for machines ---------------------------------------------------------------------------------------------------------------- */

json_t *report_casters_json(const bake_report *r)
{
    const casters *c      = &r->casters;
    json_t        *sheets = json_object();
    for (int kind = COMPONENT_SOLID + 1; kind < COMPONENT_KINDS; kind++)
        json_object_set_new(sheets, component_kind_name((component_kind)kind),
                            json_pack("{s:I, s:I}", "components", (json_int_t)c->component_count[kind], "triangles",
                                      (json_int_t)c->triangles_of_kind[kind]));

    json_t *exclusions_json = json_array();
    for (const scene_exclusion *e = r->exclusions; e < r->exclusions + r->exclusion_count; e++) {
        char    rule[32];
        json_t *entry = json_pack("{s:s, s:I}", "rule", choice_word(rule, EXCLUSION_RULES, (int)e->rule), "triangles",
                                  (json_int_t)e->triangles);
        if (e->pattern) json_object_set_new(entry, "pattern", json_text(e->pattern));
        json_array_append_new(exclusions_json, entry);
    }

    return json_pack("{s:I, s:I, s:o, s:{s:I, s:I}, s:o, s:o, s:[f,f,f], s:[f,f,f]}", "triangles",
                     (json_int_t)casters_whole_count(c), "collapsed_triangles", (json_int_t)c->collapsed_count, "excluded",
                     exclusions_json, "solids", "components", (json_int_t)c->component_count[COMPONENT_SOLID], "triangles",
                     (json_int_t)c->solid_triangle_count, "sheets", sheets, "borders",
                     json_pack("{s:I, s:I, s:I, s:I, s:I}", "open_edges", (json_int_t)c->borders.edges, "split_edges",
                               (json_int_t)c->borders.split, "added_triangles", (json_int_t)c->borders.added, "joined_vertices",
                               (json_int_t)c->borders.joined, "left_edges", (json_int_t)c->borders.left),
                     "min_m", r->casters_min_ws[0], r->casters_min_ws[1], r->casters_min_ws[2], "max_m", r->casters_max_ws[0],
                     r->casters_max_ws[1], r->casters_max_ws[2]);
}

json_t *report_warnings_json(const run_context *m)
{
    json_t *warnings = json_array();
    for (size_t n = 0; n < m->warning_count; n++) json_array_append_new(warnings, json_text(m->warnings[n]));
    return warnings;
}

json_t *plan_decisions_json(const bake_plan *plan, const bake_options *o, const bake_report *report)
{
    decision_list l     = decisions_of(plan, o, report);
    json_t       *array = json_array();
    for (const plan_decision *d = l.items; d < l.items + l.count; d++)
        json_array_append_new(array, json_pack("{s:s, s:s, s:s}", "name", d->name, "choice", d->choice, "reason", d->reason));
    return array;
}

json_t *plan_estimate_json(const bake_plan *plan)
{
    json_t *stages = json_array();
    for (int s = 0; s < STAGE_COUNT; s++)
        json_array_append_new(stages, json_pack("{s:s, s:f}", "name", bake_stage_name((bake_stage)s), "seconds", plan->seconds[s]));
    return json_pack("{s:f, s:o, s:I, s:I, s:I}", "total_seconds", plan->total_seconds, "stages", stages, "peak_bytes",
                     (json_int_t)plan->peak_bytes, "file_bytes", (json_int_t)plan->file_bytes, "memory_bytes",
                     (json_int_t)plan->memory_bytes);
}

/* Estimates of the coding: what it finds and what it keeps. */
static json_t *coded_json(const plan_light *l)
{
    if (l->light.coding == VXS_CODING_DAG)
        return json_pack("{s:I, s:I, s:I, s:I, s:I}", "mask_runs", (json_int_t)l->mask_runs, "inserted_nodes",
                         (json_int_t)l->inserted_nodes, "inserted_masks", (json_int_t)l->inserted_masks, "nodes",
                         (json_int_t)l->nodes, "masks", (json_int_t)l->masks);
    return json_pack("{s:{s:I, s:I}}", "palette_blocks", "blocks", (json_int_t)l->palette.blocks, "patterns",
                     (json_int_t)l->palette.patterns);
}

static json_t *light_json(const plan_light *l)
{
    if (l->left_out) return json_pack("{s:o, s:s}", "name", json_text(l->name), "left_out", l->left_out);
    json_t *light = json_pack(
        "{s:o, s:I, s:i, s:o, s:I, s:I, s:I, s:I, s:I, s:I, s:I, s:I, s:I, s:I}", "name", json_text(l->name), "resolution_px",
        (json_int_t)1 << l->light.levels, "maps", (int)l->map_count, "texel_at_casters_m", texels_json(&l->texels), "triangles",
        (json_int_t)l->sample.triangles, "tiles", (json_int_t)l->tiles, "tiles_without_casters", (json_int_t)l->tiles_empty,
        "blocks", (json_int_t)l->sample.blocks, "blocks_without_casters", (json_int_t)l->sample.blocks_empty, "blocks_peeled",
        (json_int_t)l->sample.blocks_peeled, "blocks_not_peeled", (json_int_t)l->sample.blocks_not_peeled, "mask_tiles",
        (json_int_t)l->mask_tiles, "memory_bytes", (json_int_t)l->memory_bytes, "stored_bytes", (json_int_t)l->stored_bytes);
    json_t *coded = coded_json(l);
    json_object_update(light, coded);
    json_decref(coded);
    return light;
}

json_t *plan_lights_json(const bake_plan *plan)
{
    json_t *lights = json_array();
    for (size_t n = 0; n < plan->light_count; n++) json_array_append_new(lights, light_json(&plan->lights[n]));
    return lights;
}

json_t *plan_savings_json(const bake_plan *plan)
{
    json_t *savings = json_array();
    for (const plan_saving *s = plan->savings; s < plan->savings + plan->saving_count; s++) {
        json_t *saving =
            json_pack("{s:s, s:I, s:f}", "option", s->option, "file_bytes", (json_int_t)s->file_bytes, "total_seconds", s->seconds);
        if (s->triangles) json_object_set_new(saving, "triangles", json_integer((json_int_t)s->triangles));
        json_array_append_new(savings, saving);
    }
    return savings;
}

vxs_result plan_write_json(const char *path, const bake_options *o, const bake_report *report, run_context *m)
{
    const bake_plan *plan = report->plan;
    json_t *root = json_pack("{s:s, s:o, s:b, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:I, s:o, s:f}", "vxs", VXS_VERSION, "scene",
                             json_text(o->scene_path), "unchanged", 0, "options", bake_options_json(o), "casters",
                             report_casters_json(report), "decisions", plan_decisions_json(plan, o, report), "lights",
                             plan_lights_json(plan), "lights_left_out", report_left_out_json(report), "warnings",
                             report_warnings_json(m), "estimate", plan_estimate_json(plan), "least_bytes",
                             (json_int_t)plan->least_bytes, "savings", plan_savings_json(plan), "plan_seconds", plan->plan_seconds);
    return json_write(path, root, m);
}
