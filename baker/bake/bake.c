/* The bake; see bake.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/bake/bake.h"

#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "baker/bake/bake_light.h"
#include "baker/measure/clock.h"
#include "baker/files/json_file.h"
#include "baker/files/output_file.h"
#include "baker/base/pages.h"
#include "baker/measure/progress.h"
#include "baker/base/version.h"
#include "baker/bake/plan.h"
#include "baker/scene/light_choice.h"

/* time and memory by stage ---------------------------------------------------------------------------------------------------- */

stage_timer stage_begin(bake_report *report)
{
    memory_peak_reset();
    return (stage_timer){report, clock_seconds()};
}

void stage_end(stage_timer *t, bake_stage stage)
{
    stage_report *s    = &t->report->stage[stage];
    uint64_t      peak = memory_peak_bytes();
    s->seconds += clock_seconds() - t->start;
    if (peak > s->peak_bytes) s->peak_bytes = peak;
    if (peak > t->report->peak_bytes) t->report->peak_bytes = peak;
    memory_peak_reset();
    t->start = clock_seconds();
}

vxs_result bake_within_budget(const bake_options *o, const bake_report *report, message *m)
{
    char budget[32], held[32];
    if (!o->memory_bytes || report->peak_bytes <= o->memory_bytes) return VXS_OK;
    return fail(m, VXS_E_MEMORY, "--memory %s is too little for '%s': the bake has come to hold %s, and is given up",
                size_text(budget, o->memory_bytes), o->scene_path, size_text(held, report->peak_bytes));
}

static const char *const stage_names[STAGE_COUNT] = {"load",  "solids", "plan",     "gl",    "maps",   "pyramid",
                                                     "masks", "insert", "compress", "merge", "encode", "write"};

const char *bake_stage_name(bake_stage stage)
{
    return stage_names[stage];
}

/* the file -------------------------------------------------------------------------------------------------------------------- */

static int set_word(json_t *object, const char *key, const char *choices, int index)
{
    char word[32];
    return json_object_set_new(object, key, json_string(choice_word(word, choices, index)));
}

json_t *bake_choices_json(const bake_options *o)
{
    json_t *object = json_object();
    set_word(object, "closed", CLOSED_CHOICES, (int)o->closed);
    set_word(object, "exit", EXIT_CHOICES, (int)o->exit);
    set_word(object, "rule", RULE_CHOICES, (int)o->rule);
    set_word(object, "stop", STOP_CHOICES, (int)o->stop);
    if (o->repair)
        json_object_set_new(object, "repair",
                            json_pack("{s:f, s:f, s:I}", "stitch_m", o->mending.stitch_m, "hole_diameter_m",
                                      o->mending.hole_diameter_m, "hole_edges", (json_int_t)o->mending.hole_edges_max));
    if (o->unite) json_object_set_new(object, "union", json_true());
    return object;
}

json_t *bake_options_json(const bake_options *o)
{
    json_t       *object = bake_choices_json(o);
    const double *b      = o->region_ws;
    set_word(object, "reuse", REUSE_CHOICES, o->reuse);
    set_word(object, "compress", COMPRESS_CHOICES, (int)o->compress);
    set_word(object, "gl", GL_CHOICES, (int)o->gl);
    set_word(object, "baseline", BASELINE_CHOICES, (int)o->baseline);
    json_object_set_new(object, "zstd_level", json_integer(o->zstd_level));
    json_object_set_new(object, "threads", json_integer(o->threads));
    if (o->memory_bytes) json_object_set_new(object, "memory_bytes", json_integer((json_int_t)o->memory_bytes));
    if (o->region_given) json_object_set_new(object, "region_m", json_pack("[f,f,f,f,f,f]", b[0], b[1], b[2], b[3], b[4], b[5]));
    return object;
}

/* What made the file, for people and tools; a lookup needs none of it. No clock, no path: same input, same bytes. */
static char *metadata_text(const bake_options *o, const bake_report *report)
{
    json_t *root = json_pack("{s:s, s:I, s:I, s:I, s:o}", "generator", "vxs " VXS_VERSION, "triangles",
                             (json_int_t)report->casters.triangle_count, "solids",
                             (json_int_t)report->casters.component_count[COMPONENT_SOLID], "solid_triangles",
                             (json_int_t)report->casters.solid_triangle_count, "options", bake_choices_json(o));
    char   *text = root ? json_print(root, JSON_COMPACT) : NULL;
    json_decref(root);
    return text;
}

static vxs_result encode(const bake_options *o, const dag *dags, const bake_report *report, vxs_bytes *out, message *m)
{
    vxs_write_light *lights = calloc(report->light_count, sizeof *lights);
    char            *text   = metadata_text(o, report);
    vxs_result       r      = VXS_E_MEMORY;
    if (lights && text) {
        for (uint32_t n = 0; n < report->light_count; n++) {
            lights[n].light = report->lights[n].light;
            lights[n].dag   = dag_view_of(&dags[n]);
        }
        vxs_write_desc desc = {
            .lights = lights, .light_count = report->light_count, .metadata = text, .zstd_level = (int)o->zstd_level};
        r = vxs_write(out, &desc);
    }
    free(text);
    free(lights);
    return r == VXS_OK ? r : fail(m, r, "the asset cannot be encoded: %s", r == VXS_E_MEMORY ? "out of memory" : "it is too large");
}

/* Sizes by level, from the file as a reader sees it. */
static void report_contents(const vxs_contents *c, bake_report *report)
{
    for (uint32_t n = 0; n < c->light_count; n++) {
        const vxs_light *stored = &c->lights[n];
        light_report    *light  = &report->lights[n];
        light->light            = *stored;
        light->light.words      = NULL;
        light->memory_bytes     = (uint64_t)stored->word_count * 4;
        for (uint32_t s = 0; s < c->section_count; s++) {
            const vxs_section *section = &c->sections[s];
            if (section->light != n) continue;
            int masks                          = section->kind == VXS_KIND_MASKS;
            light->level[light->level_count++] = (level_report){
                .side_voxels  = masks ? 0 : 8u << section->level,
                .count        = masks ? stored->mask_count : stored->node_count[section->level],
                .memory_bytes = masks ? (uint64_t)stored->mask_count * 8 : (uint64_t)stored->node_words[section->level] * 4,
                .stored_bytes = section->stored_bytes,
            };
            light->stored_bytes += section->stored_bytes;
        }
    }
}

/* Read back what was encoded, as a game would, before it gets the name of the output. */
static vxs_result write_file(const bake_options *o, const vxs_bytes *file, bake_report *report, message *m)
{
    vxs_contents contents = {0};
    output_file  out      = {0};
    vxs_result   r        = vxs_read(&contents, file->data, file->size_bytes, NULL);
    if (r != VXS_OK) return fail(m, r, "the encoded asset cannot be read back, nothing was written: %s", vxs_result_text(r));
    report_contents(&contents, report);
    vxs_contents_free(&contents);
    report->file_bytes = file->size_bytes;

    if ((r = output_file_open(&out, o->output_path, m)) != VXS_OK) return r;
    if ((r = output_file_write(&out, file->data, file->size_bytes, m)) == VXS_OK) r = output_file_commit(&out, m);
    output_file_abort(&out);
    return r;
}

/* Of the scene's file; 0 when it is not known. Buffers beside a .gltf are not counted. */
static uint64_t file_bytes(const char *path)
{
    struct stat s;
    return stat(path, &s) || s.st_size < 0 ? 0 : (uint64_t)s.st_size;
}

/* A scene is held whole while it is read. */
static vxs_result check_scene_bytes(const bake_options *o, uint64_t scene_bytes, message *m)
{
    char budget[32], size[32];
    if (!o->memory_bytes || scene_bytes <= o->memory_bytes) return VXS_OK;
    return fail(m, VXS_E_MEMORY, "--memory %s is too little for '%s', a file of %s", size_text(budget, o->memory_bytes),
                o->scene_path, size_text(size, scene_bytes));
}

/* all lights ------------------------------------------------------------------------------------------------------------------ */

static void report_casters(bake_report *report, const casters *c)
{
    report->casters      = *c;
    casters *counts      = &report->casters; /* no arrays: they are the casters' */
    counts->positions_ws = NULL;
    counts->indices = counts->component_of = NULL;
    counts->kind_of = counts->solid_meets = NULL;
    counts->masks                         = NULL;
    counts->mask_first                    = NULL;
    counts->mask_uvs                      = NULL;
    counts->images                        = NULL;
    for (int axis = 0; axis < 3; axis++) {
        report->casters_min_ws[axis] = INFINITY;
        report->casters_max_ws[axis] = -INFINITY;
        for (size_t n = 0; n < c->vertex_count; n++) {
            report->casters_min_ws[axis] = fmin(report->casters_min_ws[axis], c->positions_ws[3 * n + axis]);
            report->casters_max_ws[axis] = fmax(report->casters_max_ws[axis], c->positions_ws[3 * n + axis]);
        }
    }
}

const char REACHES_NOTHING[] = "reaches no caster";

static void leave_out(bake_report *report, const char *name, const char *why)
{
    light_left_out *l = &report->left_out[report->left_out_count++];
    snprintf(l->name, sizeof l->name, "%s", name);
    l->why = why;
}

/* What nobody asked for, and what reaches nothing. */
static vxs_result report_left_out(bake_report *report, const scene *s, const bake_plan *plan, message *m)
{
    report->left_out = calloc(s->light_count + plan->light_count + 1, sizeof *report->left_out);
    if (!report->left_out) return fail(m, VXS_E_MEMORY, "out of memory for %zu lights", s->light_count);
    for (size_t n = 0; n < s->light_count; n++) {
        int is_chosen = 0;
        for (size_t k = 0; k < plan->light_count; k++)
            is_chosen |= !strncmp(s->lights[n].name, plan->lights[k].name, VXS_LIGHT_NAME_BYTES - 1);
        if (!is_chosen) leave_out(report, s->lights[n].name, "not asked for");
    }
    for (size_t n = 0; n < plan->light_count; n++) {
        const plan_light *l = &plan->lights[n];
        if (!l->left_out) continue;
        leave_out(report, l->name, l->left_out);
        warn(m, "light '%s' %s: it is left out", l->name, l->left_out);
    }
    return VXS_OK;
}

/* pictures -------------------------------------------------------------------------------------------------------------------- */

/* What lookups of a DAG read, nearly: enough to tell large lights from small ones before they are encoded. */
static uint64_t dag_bytes(const dag *d)
{
    return 20 * dag_node_count(d) + 8 * (uint64_t)d->mask_count;
}

/* Keep a picture of a light when it is one of the largest so far; the picture of a smaller one is released for it. */
static void keep_picture(bake_report *report, const dag *dags, light_picture *picture)
{
    light_picture *least = &report->pictures[0];
    if (report->picture_count < PICTURES_MAX) {
        report->pictures[report->picture_count++] = *picture;
        return;
    }
    for (uint32_t n = 1; n < PICTURES_MAX; n++)
        if (dag_bytes(&dags[report->pictures[n].light]) < dag_bytes(&dags[least->light])) least = &report->pictures[n];
    if (dag_bytes(&dags[picture->light]) <= dag_bytes(&dags[least->light])) {
        light_picture_free(picture);
        return;
    }
    light_picture_free(least);
    *least = *picture;
}

/* Whether a light may be one of the largest: a picture takes time, and of many lights most are thrown away. */
static int is_picture_wanted(const light_baker *b, const plan_light *planned)
{
    uint32_t larger = 0;
    if (!b->options->pictures) return 0;
    for (size_t n = 0; n < b->plan->light_count; n++) larger += b->plan->lights[n].stored_bytes > planned->stored_bytes;
    return larger < 4 * PICTURES_MAX;
}

/* Bake the next light, and its picture where one is wanted. */
static vxs_result bake_next(light_baker *b, const plan_light *planned, dag *dags, baseline *bases, message *m)
{
    bake_report  *report  = b->report;
    uint32_t      baked   = report->light_count++;
    light_picture picture = {0};
    int           wanted  = is_picture_wanted(b, planned);
    vxs_result    r       = VXS_OK;
    if (wanted) r = light_picture_init(&picture, baked, 1u << planned->light.levels, planned->map_count, m);
    if (r == VXS_OK) r = bake_light(b, planned, &dags[baked], &bases[baked], wanted ? &picture : NULL, &report->lights[baked], m);
    if (r == VXS_OK && wanted)
        keep_picture(report, dags, &picture);
    else
        light_picture_free(&picture);
    return r;
}

/* start_seconds: of the clock, when the whole bake began. */
static vxs_result bake_lights(const bake_options *o, const casters *c, double start_seconds, vxs_bytes *file, bake_report *report,
                              message *m)
{
    const bake_plan *plan  = report->plan;
    gl_context      *gl    = NULL;
    dag             *dags  = calloc(plan->baked_count, sizeof *dags);
    baseline        *bases = calloc(plan->baked_count, sizeof *bases);
    vxs_result       r     = VXS_E_MEMORY;
    report->lights         = calloc(plan->baked_count, sizeof *report->lights);
    if (!dags || !bases || !report->lights) {
        fail(m, r, "out of memory for %zu lights", plan->baked_count);
        goto done;
    }

    stage_timer timer = stage_begin(report);
    if ((r = gl_context_create(&gl, o->gl, o->threads, m)) != VXS_OK) goto done;
    snprintf(report->renderer, sizeof report->renderer, "%s", gl->renderer);
    stage_end(&timer, STAGE_GL);

    light_baker baker = {.options = o, .plan = plan, .gl = gl, .casters = c, .report = report, .start = start_seconds};
    baker.past_seconds =
        plan->seconds[STAGE_LOAD] + plan->seconds[STAGE_SOLIDS] + plan->seconds[STAGE_PLAN] + plan->seconds[STAGE_GL];
    for (size_t n = 0; n < plan->light_count && r == VXS_OK; n++) {
        if (!plan->lights[n].left_out) r = bake_next(&baker, &plan->lights[n], dags, bases, m);
    }
    gl_context_destroy(gl);
    if (r != VXS_OK) goto done;

    progress_say(o->progress, "compressing the file");
    timer = stage_begin(report);
    r     = encode(o, dags, report, file, m);
    stage_end(&timer, STAGE_ENCODE);
    if (r == VXS_OK) r = bake_within_budget(o, report, m);

    /* the comparison with a plain depth map is no part of the bake: its time is its own */
    double start = clock_seconds();
    if (plan->baseline != BASELINE_OFF) progress_say(o->progress, "measuring depth maps under zstd -19");
    for (size_t n = 0; n < report->light_count && r == VXS_OK && plan->baseline != BASELINE_OFF; n++)
        report->lights[n].depth_zstd19_ratio = baseline_ratio(&bases[n], &report->lights[n].depth_sample_share);
    report->baseline_seconds += clock_seconds() - start;
done:
    for (size_t n = 0; n < plan->baked_count; n++) {
        if (dags) dag_free(&dags[n]);
        if (bases) baseline_free(&bases[n]);
    }
    free(dags);
    free(bases);
    return r;
}

/* From the scene's file to the plan of its bake. */
static vxs_result prepare(const bake_options *o, scene *s, casters *c, bake_report *report, message *m)
{
    light_choice chosen = {0};
    stage_timer  timer  = stage_begin(report);
    uint64_t     bytes  = file_bytes(o->scene_path);
    vxs_result   r      = check_scene_bytes(o, bytes, m);
    progress_say(o->progress, "reading %s", o->scene_path);
    if (r == VXS_OK) r = scene_load_gltf(s, o->scene_path, o->scene_name, m);
    stage_end(&timer, STAGE_LOAD);
    if (r == VXS_OK) r = bake_within_budget(o, report, m);
    progress_say(o->progress, "telling solids from sheets");
    if (r == VXS_OK && o->repair) r = scene_repair(s, &o->mending, &report->repair, m);
    if (r == VXS_OK) r = casters_from_scene(c, s, o->closed, m);
    if (r == VXS_OK && o->unite) r = casters_unite(c, &report->unite, m);
    if (r == VXS_OK) r = lights_choose(s, &o->light_names, o->sun_given, o->sun, &chosen, m);
    stage_end(&timer, STAGE_SOLIDS);
    if (r == VXS_OK) r = bake_within_budget(o, report, m);

    progress_say(o->progress, "making a plan");
    report->plan = r == VXS_OK ? calloc(1, sizeof *report->plan) : NULL;
    if (r == VXS_OK && !report->plan) r = fail(m, VXS_E_MEMORY, "out of memory for a plan");
    if (r == VXS_OK) r = plan_make(report->plan, o, c, &chosen, bytes, m);
    if (r == VXS_OK) report_casters(report, c);
    if (r == VXS_OK) r = report_left_out(report, s, report->plan, m);
    stage_end(&timer, STAGE_PLAN);
    if (r == VXS_OK) r = bake_within_budget(o, report, m);
    light_choice_free(&chosen);
    return r;
}

vxs_result bake(const bake_options *o, bake_report *report, message *m)
{
    double     start = clock_seconds();
    scene      s     = {0};
    casters    c     = {0};
    vxs_bytes  file  = {0};
    vxs_result r;

    pages_return_large();
    if ((r = output_file_check(o->output_path, o->scene_path, m)) != VXS_OK) goto done;
    if ((r = prepare(o, &s, &c, report, m)) != VXS_OK) goto done;
    if ((r = bake_lights(o, &c, start, &file, report, m)) != VXS_OK) goto done;

    stage_timer timer = stage_begin(report);
    progress_say(o->progress, "writing %s", o->output_path);
    r = write_file(o, &file, report, m);
    stage_end(&timer, STAGE_WRITE);
    report->total_seconds = clock_seconds() - start - report->baseline_seconds - report->picture_seconds;
done:
    progress_clear();
    free(file.data);
    casters_free(&c);
    scene_free(&s);
    return r;
}

vxs_result bake_plan_only(const bake_options *o, bake_report *report, message *m)
{
    scene      s = {0};
    casters    c = {0};
    vxs_result r = prepare(o, &s, &c, report, m);
    casters_free(&c);
    scene_free(&s);
    return r;
}

void bake_report_free(bake_report *r)
{
    free(r->lights);
    free(r->left_out);
    if (r->plan) plan_free(r->plan);
    free(r->plan);
    for (uint32_t n = 0; n < r->picture_count; n++) light_picture_free(&r->pictures[n]);
    repair_report_free(&r->repair);
    union_report_free(&r->unite);
    memset(r, 0, sizeof *r);
}
