/* The bake; see bake.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/bake/bake.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "baker/bake/bake_light.h"
#include "baker/bake/bake_lights.h"
#include "baker/bake/bake_squares.h"
#include "baker/bake/light_coder.h"
#include "baker/bake/provenance.h"
#include "baker/bake/scene_warnings.h"
#include "baker/base/box.h"
#include "baker/base/clock.h"
#include "baker/base/memory.h"
#include "baker/casters/casters.h"
#include "baker/files/output_file.h"
#include "baker/files/run_files.h"
#include "baker/scene/light_choice.h"
#include "formats/vxs_write_file.h"
#include "runtime/volumes/vxs_area_light.h"

/* Positions are rounded to this share of the distance between points, much less than the drawn width of a point. */
#define ROUNDED_TO (1.0 / 32)

/* Scatter `count` points over the triangles, uniformly by area.
 * view  [out] the caller owns its points: free((void *)view->places_ws)
 * Returns VXS_OK, VXS_E_MEMORY; VXS_E_SCENE if the triangles have no area. */
static vxs_result bake_points(vxs_points_view *view, const casters *c, uint32_t count, run_context *m)
{
    double         *places_ws = malloc(3 * (size_t)count * sizeof *places_ws);
    float          *positions = malloc(3 * c->vertex_count * sizeof *positions);
    vxs_area_point *points    = calloc(count, sizeof *points);
    vxs_result      r         = VXS_OK;
    box             b         = box_of_corners(c->positions_ws, c->indices, 3 * c->triangle_count);
    double          middle_ws[3], area = 0; /* floats are relative to the middle */
    for (int n = 0; n < 3; n++) middle_ws[n] = 0.5 * (b.min[n] + b.max[n]);
    if (places_ws && positions && points) {
        for (size_t n = 0; n < 3 * c->vertex_count; n++) positions[n] = (float)(c->positions_ws[n] - middle_ws[n % 3]);
        area = vxs_area_scatter(positions, c->indices, (uint32_t)c->triangle_count, points, count);
        for (uint32_t n = 0; n < count; n++)
            for (size_t i = 0; i < 3; i++) places_ws[3 * (size_t)n + i] = middle_ws[i] + (double)points[n].place[i];
        if (!(area > 0)) r = fail(m, VXS_E_SCENE, "--points %u: the triangles have no area", count);
    } else {
        r = fail(m, VXS_E_MEMORY, "out of memory for %u points", count);
    }
    *view = (vxs_points_view){places_ws, count, area / count, ROUNDED_TO * sqrt(area / count)};
    free(positions);
    free(points);
    return r;
}

/* The renderer's name if nothing was rendered. */
#define SPARSE_RENDERER "none: straight from triangles"

/* Create the renderer's device if maps are rendered; else *device is NULL. */
static vxs_result begin_rendering(void **device, const bake_options *o, bake_report *report, bake_context *ctx)
{
    device_names names = {.renderer = SPARSE_RENDERER};
    vxs_result   r     = VXS_OK;
    *device            = NULL;
    if (o->maps != MAPS_SPARSE) {
        if (!o->renderer) return fail(ctx->run, VXS_E_GL, "this program bakes straight from triangles alone: it has no OpenGL");
        /* Mesa and LLVM crash if the address space is exhausted (ulimit -v), so they are not started if this may happen. In
         * addition to counted memory, they map libraries, code, and a stack and a heap for each thread. */
        uint64_t bytes = ((uint64_t)450 << 20) + o->threads * ((uint64_t)72 << 20) + report->plan->peak_bytes;
        char     needed[32];
        if (!memory_has_room(bytes))
            return fail(ctx->run, VXS_E_MEMORY,
                        "OpenGL needs up to %s of address space for '%s', and this process may not have as much (ulimit -v)",
                        size_text(needed, bytes), o->scene_path);
        stage_begin(ctx, STAGE_GL);
        r = o->renderer->create(device, &names, o->gl, o->threads, ctx->run);
        stage_begin(ctx, STAGE_NONE);
    }
    memcpy(report->renderer, names.renderer, sizeof report->renderer);
    memcpy(report->cpu_class, names.cpu_class, sizeof report->cpu_class);
    return r;
}

/* Bake all lights, and encode their file. */
static vxs_result bake_file(const bake_options *o, const casters *c, bake_squares *squares, vxs_bytes *file, bake_report *report,
                            bake_context *ctx)
{
    size_t          count  = report->plan->baked_count;
    coded_light    *coded  = calloc(count, sizeof *coded);
    vxs_points_view points = {0};
    char           *text   = NULL;
    vxs_result      r      = VXS_E_MEMORY;
    report->lights         = calloc(count, sizeof *report->lights);
    if (!coded || !report->lights) {
        fail(ctx->run, r, "out of memory for %zu lights", count);
        goto done;
    }

    const bake_plan *plan = report->plan;
    void            *device;
    r = begin_rendering(&device, o, report, ctx);
    if (r == VXS_OK) r = bake_squares_open(squares, o, report, ctx->run);
    ctx->total_seconds = plan->total_seconds;
    for (int s = STAGE_LOAD; s <= STAGE_GL; s++) ctx->past_seconds += plan->seconds[s];
    if (r == VXS_OK) r = bake_lights(&(lights_job){o, c, device, coded, squares, report}, ctx);
    if (device) o->renderer->destroy(device);
    if (r != VXS_OK) goto done;

    report->warning_count = ctx->run->warning_count - report->warnings_before - squares->store.warnings;
    if (is_baked_apart(o)) goto done;
    watch_say(o->watch, "compressing the file");
    stage_begin(ctx, STAGE_ENCODE);
    text = provenance_text(report);
    if (o->points && (r = bake_points(&points, c, o->points, ctx->run)) != VXS_OK) goto done;
    r = asset_encode(o, coded, report->light_count, text, o->points ? &points : NULL, file, ctx->run);
    if (r != VXS_OK) goto done;
    stage_begin(ctx, STAGE_NONE);
    r = context_check(ctx);
done:
    free(text);
    free((void *)points.places_ws);
    for (size_t n = 0; n < count && coded; n++) coded_light_free(&coded[n]);
    free(coded);
    return r;
}

/* Add smoke to the lights of a file. */
static vxs_result bake_smoke(const bake_options *o, const smoke_source *source, vxs_bytes *file, bake_report *report,
                             bake_context *ctx)
{
    smoke_counts *counts = calloc(report->light_count, sizeof *counts);
    if (!counts) return fail(ctx->run, VXS_E_MEMORY, "out of memory for the smoke of %u lights", report->light_count);
    stage_begin(ctx, STAGE_SMOKE);
    vxs_result r = smoke_bake(file, source, &o->smoke, (int)o->zstd_level, counts, ctx);
    stage_begin(ctx, STAGE_NONE);
    for (uint32_t n = 0; n < report->light_count; n++) report->lights[n].smoke = counts[n];
    free(counts);
    return r;
}

static vxs_result judge_lights(const light_choice *chosen, run_context *m)
{
    if (chosen->count > VXS_LIGHTS_MAX)
        return fail(m, VXS_E_ARGUMENT,
                    "%zu lights to bake, and a file holds %u at most: choose some with --light NAME, in several bakes",
                    chosen->count, VXS_LIGHTS_MAX);
    warn_about_lights(chosen, m);
    return VXS_OK;
}

static void warn_about_scene(const bake_options *o, const bake_scene *s, const light_choice *chosen, run_context *m)
{
    const casters *c       = &s->casters;
    int            has_sun = 0;
    for (size_t n = 0; n < chosen->count; n++) has_sun |= chosen->lights[n].shape.kind == LIGHT_DIRECTIONAL;
    warn_about_scale(c, m);
    warn_about_ranges(c, chosen, m);
    warn_about_flat(c, m);
    warn_about_names(&s->scene, m);
    if (o->region_given && has_sun) warn_about_region(c, o->region_ws, m); /* regions do not affect punctual lights */
}

vxs_result bake_check_outputs(const bake_options *o, run_context *m)
{
    vxs_result r = o->output_path ? output_file_check(o->output_path, m) : VXS_OK;
    return r == VXS_OK && o->page_path ? output_file_check(o->page_path, m) : r;
}

vxs_result bake_add_folder(const bake_options *o, const char *option, run_context *m)
{
    return o->resume_path ? run_files_add_folder(option, o->resume_path, CACHE_FOLDER_NAMES, m) : VXS_OK;
}

/* Prepare a bake up to its plan; or find that the output is up to date. */
static vxs_result prepare(const bake_options *o, bake_scene *s, bake_report *report, bake_context *ctx)
{
    light_choice chosen = {0};
    run_context *m      = ctx->run;
    vxs_result   r;
    report->warnings_before = m->warning_count;
    stage_begin(ctx, STAGE_LOAD);
    m->memory_bytes = o->memory_bytes;

    /* read a scene, unless it is given, and choose the lights */
    light_question question = {&o->light_names, &o->suns, &chosen, judge_lights};
    scene_check    check    = light_question_check(&question);
    if ((r = o->prepared ? check.check(check.user, &s->scene, ctx->run) : bake_scene_read(s, o, &check, ctx)) != VXS_OK) goto done;

    if ((r = bake_scene_read_smoke(s, o, ctx)) != VXS_OK) goto done;
    if ((r = provenance_inputs(&report->inputs, o, s, &chosen, m)) != VXS_OK) goto done;
    /* a strict run would not have written an output with warnings */
    report->unchanged = o->if_changed &&
                        provenance_is_current(o->output_path, report->inputs, &report->file_bytes, &report->warning_count, m) &&
                        !(m->strict && report->warning_count);
    if (report->unchanged) goto done;
    if (o->if_changed && (r = bake_check_outputs(o, m)) != VXS_OK) goto done; /* else checked before */

    if (!o->prepared && (r = bake_scene_find_casters(s, o, ctx)) != VXS_OK) goto done;
    warn_about_scene(o, s, &chosen, m);
    if ((r = run_check(m)) != VXS_OK) goto done;

    stage_begin(ctx, STAGE_PLAN);
    if ((r = context_check(ctx)) != VXS_OK) goto done;
    watch_say(o->watch, "making a plan");
    if (!(report->plan = calloc(1, sizeof *report->plan))) {
        r = fail(m, VXS_E_MEMORY, "out of memory for a plan");
        goto done;
    }
    if ((r = plan_make(report->plan, o, &s->casters, &s->scene, &chosen, s->file_bytes, m)) != VXS_OK) goto done;
    if ((r = bake_report_begin(report, &s->scene, &s->casters, m)) != VXS_OK) goto done;
    stage_begin(ctx, STAGE_NONE);
    if ((r = run_check(m)) != VXS_OK) goto done;
    r = context_check(ctx);
done:
    light_choice_free(&chosen);
    return r;
}

static bake_context context_of(const bake_options *o, run_context *m)
{
    return (bake_context){.run          = m,
                          .threads      = o->threads,
                          .watch        = o->watch,
                          .subject      = o->scene_path,
                          .memory_bytes = o->memory_bytes,
                          .begun        = clock_seconds()};
}

static void report_stages(bake_report *report, const bake_context *ctx)
{
    memcpy(report->stage, ctx->stage, sizeof report->stage);
    report->peak_bytes      = ctx->peak_bytes;
    report->picture_seconds = ctx->stage[STAGE_PICTURE].seconds;
    report->total_seconds   = clock_seconds() - ctx->begun - report->picture_seconds;
}

vxs_result bake(const bake_options *o, const bake_observer *observer, bake_report *report, run_context *m)
{
    bake_context ctx = context_of(o, m);
    bake_scene   own = {0}, *s = o->prepared ? o->prepared : &own;
    bake_squares squares = {0};
    vxs_bytes    file    = {0};
    vxs_result   r;

    if ((r = prepare(o, s, report, &ctx)) != VXS_OK) goto done;
    if (report->unchanged) goto done;
    stage_begin(&ctx, STAGE_PLAN);
    if ((r = plan_find_closed(report->plan, o, &s->casters, m)) != VXS_OK) goto done;
    if (!o->prepared) scene_drop_triangles(&s->scene);
    stage_begin(&ctx, STAGE_NONE);
    if ((r = bake_file(o, &s->casters, &squares, &file, report, &ctx)) != VXS_OK) goto done;

    smoke_source smoke = bake_scene_smoke(s, o);
    if ((smoke.grid || smoke.capsules) && !is_baked_apart(o)) r = bake_smoke(o, &smoke, &file, report, &ctx);
    if (r != VXS_OK) goto done;

    stage_begin(&ctx, STAGE_WRITE);
    if (o->output_path) watch_say(o->watch, "writing %s", o->output_path);
    if (o->parts) r = bake_squares_end_part(&squares, report, m);
    if (!is_baked_apart(o)) r = asset_write(o, &file, report, m);
    if (r != VXS_OK) goto done;
    if (squares.has_store && !is_baked_apart(o)) cache_folder_clean(&squares.store); /* other processes use the other squares */
    stage_begin(&ctx, STAGE_NONE);
    report_stages(report, &ctx);
    if (observer) r = observer->on_complete(observer->user, o, &s->casters, &file, m);
done:
    if (report->unchanged) report_stages(report, &ctx);
    bake_squares_close(&squares);
    free(file.data);
    bake_scene_free(&own);
    return r;
}

vxs_result bake_plan_only(const bake_options *o, bake_report *report, run_context *m)
{
    bake_context ctx = context_of(o, m);
    bake_scene   s   = {0};
    vxs_result   r   = prepare(o, &s, report, &ctx);
    if (r == VXS_OK && !report->unchanged) {
        stage_begin(&ctx, STAGE_PLAN);
        r = plan_find_closed(report->plan, o, &s.casters, m);
        if (r == VXS_OK) r = plan_find_savings(report->plan, o, &s.casters, m);
        stage_begin(&ctx, STAGE_NONE);
    }
    report_stages(report, &ctx);
    bake_scene_free(&s);
    return r;
}
