/* The bake; see bake.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/bake.h"

#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/clock.h"
#include "baker/base/integer.h"
#include "baker/base/output_file.h"
#include "baker/base/parallel.h"
#include "baker/base/version.h"
#include "baker/maps/baseline.h"
#include "baker/maps/light_fit.h"
#include "baker/scene/light_choice.h"

/* time and memory by stage ---------------------------------------------------------------------------------------------------- */

typedef struct stage_timer {
    bake_report *report;
    double       start;
} stage_timer;

static stage_timer stage_begin(bake_report *report)
{
    memory_peak_reset();
    return (stage_timer){report, clock_seconds()};
}

static void stage_end(stage_timer *t, bake_stage stage)
{
    stage_report *s    = &t->report->stage[stage];
    uint64_t      peak = memory_peak_bytes();
    s->seconds += clock_seconds() - t->start;
    if (peak > s->peak_bytes) s->peak_bytes = peak;
    if (peak > t->report->peak_bytes) t->report->peak_bytes = peak;
    memory_peak_reset();
    t->start = clock_seconds();
}

static const char *const stage_names[STAGE_COUNT] = {"load",   "solids",   "gl",    "maps",   "pyramid", "masks",
                                                     "insert", "compress", "merge", "encode", "write"};

const char *bake_stage_name(bake_stage stage)
{
    return stage_names[stage];
}

/* one map tile into sub-DAGs -------------------------------------------------------------------------------------------------- */

typedef struct sub_dag {
    tile_masks masks;
    dag        dag;
    vxs_result result;
    uint64_t   nodes, mask_nodes, mask_tiles, mask_runs;
} sub_dag;

typedef struct tile_job {
    const bake_options *o;
    column_source       source;
    uint32_t            sub_px;   /* side of a sub-DAG */
    uint32_t            sub_side; /* sub-DAGs a side of the tile */
    sub_dag            *subs;     /* [sub_side * sub_side] */
} tile_job;

/* A sub-DAG is a sixteenth of a map tile, so that threads have something to share, and at most SUB_DAG_MAX_PX wide. */
static uint32_t sub_dag_side(uint32_t tile_px)
{
    uint32_t side = min_u32(tile_px / 4, SUB_DAG_MAX_PX);
    return side < 8 ? 8 : side;
}

static void masks_of_sub(void *user, size_t begin, size_t end, uint32_t worker)
{
    tile_job *t     = user;
    uint32_t  tiles = t->sub_px / 8;
    (void)worker;
    for (size_t n = begin; n < end; n++) {
        sub_dag *s = &t->subs[n];
        s->result  = tile_masks_build(&s->masks, &t->source, (uint32_t)(n % t->sub_side) * tiles,
                                      (uint32_t)(n / t->sub_side) * tiles, tiles, t->o->rule);
        if (s->result != VXS_OK) continue;
        s->mask_runs = s->masks.run_count;
        for (size_t k = 0; k < (size_t)tiles * tiles; k++) s->mask_tiles += s->masks.first[k] < s->masks.first[k + 1];
    }
}

static void insert_sub(void *user, size_t begin, size_t end, uint32_t worker)
{
    tile_job *t = user;
    (void)worker;
    for (size_t n = begin; n < end; n++) {
        sub_dag *s = &t->subs[n];
        if (s->result != VXS_OK) continue;
        s->result = dag_insert(&s->dag, &t->source, (uint32_t)(n % t->sub_side), (uint32_t)(n / t->sub_side), dag_levels(t->sub_px),
                               &s->masks, t->o->reuse);
        tile_masks_free(&s->masks);
        s->nodes      = dag_node_count(&s->dag);
        s->mask_nodes = s->dag.mask_count;
    }
}

static void compress_sub(void *user, size_t begin, size_t end, uint32_t worker)
{
    tile_job *t = user;
    (void)worker;
    for (size_t n = begin; n < end; n++)
        if (t->subs[n].result == VXS_OK) t->subs[n].result = dag_compress(&t->subs[n].dag, t->o->compress);
}

/* A rendered tile into the merger: pyramid, masks, insertion, compression, merge. */
static vxs_result add_tile(const bake_options *o, depth_maps *maps, uint32_t i, uint32_t j, dag_merger *merger, bake_report *report,
                           light_report *light)
{
    stage_timer timer = stage_begin(report);
    depth_maps_reduce(maps, o->threads);
    stage_end(&timer, STAGE_PYRAMID);

    tile_job t     = {.o = o, .source = depth_maps_columns(maps), .sub_px = sub_dag_side(maps->side_px)};
    t.sub_side     = maps->side_px / t.sub_px;
    uint32_t count = t.sub_side * t.sub_side;
    t.subs         = calloc(count, sizeof *t.subs);
    if (!t.subs) return VXS_E_MEMORY;

    parallel_for(o->threads, count, 1, masks_of_sub, &t);
    stage_end(&timer, STAGE_MASKS);
    parallel_for(o->threads, count, 1, insert_sub, &t);
    stage_end(&timer, STAGE_INSERT);
    if (o->stop != STOP_INSERT) parallel_for(o->threads, count, 1, compress_sub, &t);
    stage_end(&timer, STAGE_COMPRESS);

    vxs_result r = VXS_OK;
    for (uint32_t n = 0; n < count; n++) {
        sub_dag *s = &t.subs[n];
        if (r == VXS_OK) r = s->result;
        if (r == VXS_OK) r = dag_merger_add(merger, &s->dag, i * t.sub_side + n % t.sub_side, j * t.sub_side + n / t.sub_side);
        light->mask_tiles += s->mask_tiles;
        light->mask_runs += s->mask_runs;
        light->inserted_nodes += s->nodes;
        light->inserted_masks += s->mask_nodes;
        tile_masks_free(&s->masks);
        dag_free(&s->dag);
    }
    free(t.subs);
    stage_end(&timer, STAGE_MERGE);
    return r;
}

/* one light ------------------------------------------------------------------------------------------------------------------- */

static void say_progress(const bake_options *o, const char *light, uint32_t done, uint32_t of, double since)
{
    if (!o->progress) return;
    double spent = clock_seconds() - since;
    fprintf(stderr, "\r\033[Kvxs: light %s: tile %u of %u, about %.0f s left", light, done, of, spent / done * (of - done));
    fflush(stderr);
}

static void end_progress(const bake_options *o)
{
    if (o->progress) fputs("\r\033[K", stderr);
}

static vxs_result bake_tiles(const bake_options *o, depth_renderer *renderer, dag_merger *merger, depth_maps *maps, baseline *base,
                             bake_report *report, light_report *light, message *m)
{
    uint32_t   side  = (1u << light->light.levels) / maps->side_px;
    double     since = clock_seconds();
    vxs_result r     = VXS_OK;
    for (uint32_t n = 0; n < side * side && r == VXS_OK; n++) {
        uint32_t i = n % side, j = n / side;
        int      empty = !depth_renderer_has_casters(renderer, maps->side_px, i, j);
        light->tiles++;
        light->tiles_skipped += (uint64_t)empty;
        stage_timer timer = stage_begin(report);
        if (!empty) {
            r = depth_renderer_tile(renderer, maps, i, j, m);
            stage_end(&timer, STAGE_MAPS);
        }
        if (r == VXS_OK && o->baseline != BASELINE_OFF && !baseline_add(base, empty ? NULL : maps->enter, maps->side_px))
            r = VXS_E_MEMORY;
        report->baseline_seconds += clock_seconds() - timer.start;
        if (r == VXS_OK && !empty) r = add_tile(o, maps, i, j, merger, report, light);
        say_progress(o, light->light.name, n + 1, side * side, since);
    }
    end_progress(o);
    return r;
}

static vxs_result bake_light(const bake_options *o, gl_context *gl, const casters *c, const chosen_light *chosen, dag *out,
                             baseline *base, bake_report *report, light_report *light, message *m)
{
    light_fit_desc  fit      = {.name           = chosen->name,
                                .shape          = &chosen->shape,
                                .resolution     = o->resolution,
                                .resolution_max = RESOLUTION_MAX_PX,
                                .texel_metres   = o->texel_metres,
                                .region_ws      = o->region_given ? o->region_ws : NULL};
    depth_renderer *renderer = NULL;
    dag_merger     *merger   = NULL;
    depth_maps      maps     = {0};
    vxs_result      r;

    stage_timer timer = stage_begin(report);
    if ((r = light_fit(&light->light, c, &fit, m)) != VXS_OK) goto done;
    for (const light_report *other = report->lights; other < light; other++)
        if (!strcmp(other->light.name, light->light.name)) {
            r = fail(m, VXS_E_ARGUMENT, "light '%s': another light of that name is baked too", light->light.name);
            goto done;
        }
    uint32_t side = 1u << light->light.levels;
    uint32_t tile = min_u32(side, TILE_MAX_PX);
    if ((r = depth_renderer_create(&renderer, gl, c, &light->light, o->exit, o->threads, m)) != VXS_OK) goto done;
    if ((r = depth_maps_init(&maps, tile, side, depth_renderer_has_exit(renderer), m)) != VXS_OK) goto done;
    if ((r = dag_merger_create(&merger, side, sub_dag_side(tile), o->stop == STOP_FINAL)) != VXS_OK) goto done;
    stage_end(&timer, STAGE_GL);

    base->limit_per_map = o->baseline == BASELINE_FULL ? 0 : ((size_t)256 << 10) / ((side / tile) * (side / tile));
    if ((r = bake_tiles(o, renderer, merger, &maps, base, report, light, m)) != VXS_OK) goto done;
    light->depth = depth_renderer_stats(renderer);

    timer = stage_begin(report);
    r     = dag_merger_finish(merger, out);
    stage_end(&timer, STAGE_MERGE);
done:
    if (r == VXS_E_MEMORY) fail(m, r, "out of memory while baking light '%s'", chosen->name);
    dag_merger_destroy(merger);
    depth_maps_free(&maps);
    depth_renderer_destroy(renderer);
    return r;
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
    char   *text = root ? json_dumps(root, JSON_COMPACT) : NULL;
    json_decref(root);
    return text;
}

static vxs_dag_view view_of(const dag *d)
{
    vxs_dag_view v = {
        .level_count = d->level_count, .masks = d->masks, .mask_count = d->mask_count, .roots = {d->roots[0] - REF_FIRST}};
    for (uint32_t l = 0; l < d->level_count; l++) {
        v.nodes[l] = d->level[l].nodes ? d->level[l].nodes[0].child : NULL;
        v.count[l] = d->level[l].count;
    }
    return v;
}

static vxs_result encode(const bake_options *o, const dag *dags, const bake_report *report, vxs_bytes *out, message *m)
{
    vxs_write_light *lights = calloc(report->light_count, sizeof *lights);
    char            *text   = metadata_text(o, report);
    vxs_result       r      = VXS_E_MEMORY;
    if (lights && text) {
        for (uint32_t n = 0; n < report->light_count; n++) {
            lights[n].light = report->lights[n].light;
            lights[n].dag   = view_of(&dags[n]);
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
    if (r != VXS_OK) return fail(m, r, "the encoded asset cannot be read back: nothing was written");
    report_contents(&contents, report);
    vxs_contents_free(&contents);
    report->file_bytes = file->size_bytes;

    if ((r = output_file_open(&out, o->output_path, m)) != VXS_OK) return r;
    if ((r = output_file_write(&out, file->data, file->size_bytes, m)) == VXS_OK) r = output_file_commit(&out, m);
    output_file_abort(&out);
    return r;
}

/* all lights ------------------------------------------------------------------------------------------------------------------ */

static void report_casters(bake_report *report, const casters *c)
{
    report->casters              = *c;
    report->casters.positions_ws = NULL;
    report->casters.indices      = NULL;
    for (int axis = 0; axis < 3; axis++) {
        report->casters_min_ws[axis] = INFINITY;
        report->casters_max_ws[axis] = -INFINITY;
        for (size_t n = 0; n < c->vertex_count; n++) {
            report->casters_min_ws[axis] = fmin(report->casters_min_ws[axis], c->positions_ws[3 * n + axis]);
            report->casters_max_ws[axis] = fmax(report->casters_max_ws[axis], c->positions_ws[3 * n + axis]);
        }
    }
}

static vxs_result report_left_out(bake_report *report, const scene *s, const light_choice *chosen, message *m)
{
    report->left_out = calloc(s->light_count + 1, sizeof *report->left_out);
    if (!report->left_out) return fail(m, VXS_E_MEMORY, "out of memory for %zu lights", s->light_count);
    for (size_t n = 0; n < s->light_count; n++) {
        int is_chosen = 0;
        for (size_t k = 0; k < chosen->count; k++) is_chosen |= !strcmp(s->lights[n].name, chosen->lights[k].name);
        if (is_chosen) continue;
        light_left_out *l = &report->left_out[report->left_out_count++];
        snprintf(l->name, sizeof l->name, "%s", s->lights[n].name);
        l->why = "not asked for";
    }
    return VXS_OK;
}

static vxs_result bake_lights(const bake_options *o, const casters *c, const light_choice *chosen, vxs_bytes *file,
                              bake_report *report, message *m)
{
    gl_context *gl    = NULL;
    dag        *dags  = calloc(chosen->count, sizeof *dags);
    baseline   *bases = calloc(chosen->count, sizeof *bases);
    vxs_result  r     = VXS_E_MEMORY;
    report->lights    = calloc(chosen->count, sizeof *report->lights);
    if (!dags || !bases || !report->lights) {
        fail(m, r, "out of memory for %zu lights", chosen->count);
        goto done;
    }
    report->light_count = (uint32_t)chosen->count;

    stage_timer timer = stage_begin(report);
    if ((r = gl_context_create(&gl, o->gl, o->threads, m)) != VXS_OK) goto done;
    snprintf(report->renderer, sizeof report->renderer, "%s", gl->renderer);
    stage_end(&timer, STAGE_GL);

    for (size_t n = 0; n < chosen->count && r == VXS_OK; n++)
        r = bake_light(o, gl, c, &chosen->lights[n], &dags[n], &bases[n], report, &report->lights[n], m);
    gl_context_destroy(gl);
    if (r != VXS_OK) goto done;

    timer = stage_begin(report);
    r     = encode(o, dags, report, file, m);
    stage_end(&timer, STAGE_ENCODE);

    /* the comparison with a plain depth map is no part of the bake: its time is its own */
    double start = clock_seconds();
    for (size_t n = 0; n < chosen->count && r == VXS_OK && o->baseline != BASELINE_OFF; n++)
        report->lights[n].depth_zstd19_ratio = baseline_ratio(&bases[n], &report->lights[n].depth_sample_share);
    report->baseline_seconds += clock_seconds() - start;
done:
    for (size_t n = 0; n < chosen->count; n++) {
        if (dags) dag_free(&dags[n]);
        if (bases) baseline_free(&bases[n]);
    }
    free(dags);
    free(bases);
    return r;
}

vxs_result bake(const bake_options *o, bake_report *report, message *m)
{
    double       start  = clock_seconds();
    scene        s      = {0};
    casters      c      = {0};
    light_choice chosen = {0};
    vxs_bytes    file   = {0};
    vxs_result   r;

    if ((r = output_file_check(o->output_path, o->scene_path, m)) != VXS_OK) goto done;
    stage_timer timer = stage_begin(report);
    if ((r = scene_load_gltf(&s, o->scene_path, o->scene_name, m)) != VXS_OK) goto done;
    stage_end(&timer, STAGE_LOAD);
    if ((r = casters_from_scene(&c, &s, o->closed, m)) != VXS_OK) goto done;
    if ((r = lights_choose(&s, &o->light_names, o->sun_given, o->sun, &chosen, m)) != VXS_OK) goto done;
    report_casters(report, &c);
    if ((r = report_left_out(report, &s, &chosen, m)) != VXS_OK) goto done;
    stage_end(&timer, STAGE_SOLIDS);

    if ((r = bake_lights(o, &c, &chosen, &file, report, m)) != VXS_OK) goto done;

    timer = stage_begin(report);
    r     = write_file(o, &file, report, m);
    stage_end(&timer, STAGE_WRITE);
    report->total_seconds = clock_seconds() - start - report->baseline_seconds;
done:
    free(file.data);
    light_choice_free(&chosen);
    casters_free(&c);
    scene_free(&s);
    return r;
}

void bake_report_free(bake_report *r)
{
    free(r->lights);
    free(r->left_out);
    memset(r, 0, sizeof *r);
}
