/* The plan; see plan.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/bake/plan.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "baker/bake/light_picture.h"
#include "baker/base/clock.h"
#include "baker/base/integer.h"
#include "baker/base/memory.h"
#include "baker/base/parallel_runs.h"
#include "baker/base/text.h"
#include "baker/light/light_fit.h"

const char REACHES_NOTHING[] = "reaches no caster";

/* lights ---------------------------------------------------------------------------------------------------------------------- */

typedef struct light_fits {
    bake_plan          *plan;
    const bake_options *o;
    const casters      *c;
    const chosen_light *chosen; /* [light_count of the plan] */
} light_fits;

static vxs_result fit_light(void *user, size_t n, uint32_t worker, run_context *m)
{
    const light_fits   *f      = user;
    const chosen_light *chosen = &f->chosen[n];
    plan_light         *l      = &f->plan->lights[n];
    light_fit_desc      fit    = {.name           = chosen->name,
                                  .shape          = &chosen->shape,
                                  .resolution_max = RESOLUTION_MAX_PX,
                                  .region_ws      = f->o->region_given ? f->o->region_ws : NULL,
                                  .threads        = f->plan->light_count > 1 ? 1 : f->o->threads};
    (void)worker;
    fit.resolution  = light_resolution(f->o, chosen->name, &fit.texel_metres);
    vxs_result r    = light_fit(&l->light, f->c, &fit, m);
    l->shape        = chosen->shape;
    l->light.coding = f->o->coding == CODING_DAG ? VXS_CODING_DAG : VXS_CODING_BLOCKS;
    snprintf(l->name, sizeof l->name, "%s", chosen->name);
    if (r == VXS_E_NO_CASTER) {
        l->left_out = REACHES_NOTHING;
        return VXS_OK;
    }
    l->map_count = vxs_map_count(&l->light);
    return r;
}

/* Count the lights to bake, whose names must differ. */
static vxs_result count_lights(bake_plan *plan, run_context *m)
{
    for (const plan_light *l = plan->lights; l < plan->lights + plan->light_count; l++) {
        plan->baked_count += !l->left_out;
        for (const plan_light *other = plan->lights; other < l && !l->left_out; other++)
            if (!other->left_out && !strcmp(other->light.name, l->light.name))
                return fail(m, VXS_E_ARGUMENT, "light '%s': another light of that name is baked too", l->light.name);
    }
    return plan->baked_count ? VXS_OK : fail(m, VXS_E_NO_LIGHT, "no light reaches a caster: there is nothing to bake");
}

/* Fit the maps of the chosen lights. */
static vxs_result fit_lights(bake_plan *plan, const bake_options *o, casters *c, const light_choice *chosen, run_context *m)
{
    int suns = 1;
    for (size_t n = 0; n < chosen->count; n++) suns &= chosen->lights[n].shape.kind == LIGHT_DIRECTIONAL;
    vxs_result r = suns || c->runs ? VXS_OK : casters_find_runs(c, m);
    if (r != VXS_OK) return r;
    plan->lights = calloc(chosen->count, sizeof *plan->lights);
    if (!plan->lights) return fail(m, VXS_E_MEMORY, "out of memory for %zu lights", chosen->count);
    plan->light_count = chosen->count;
    light_fits fits   = {plan, o, c, chosen->lights};
    r                 = parallel_runs(o->threads, chosen->count, fit_light, &fits, m);
    if (r == VXS_OK) r = count_lights(plan, m);
    for (const plan_light *l = plan->lights; l < plan->lights + plan->light_count && r == VXS_OK; l++)
        if (l->left_out)
            warn(m, "light '%s' %s: it is left out; move it, turn it, give it a longer range, or leave it out with --light",
                 l->name, l->left_out);
    return r;
}

/* solids ---------------------------------------------------------------------------------------------------------------------- */

/* Finding the solids that meet costs time per triangle, on all threads, and may save time in each block. */
static const double MEETING_SECONDS_PER_TRIANGLE = 1.4e-6, PEELING_SECONDS_PER_BLOCK = 2.5e-3, PEELING_SECONDS_PER_TRIANGLE = 8e-8;

static void plan_exit(bake_plan *plan, const bake_options *o, const casters *c)
{
    double blocks = 0, draws = 0;
    for (size_t n = 0; n < plan->light_count; n++) {
        const plan_light *l    = &plan->lights[n];
        double            side = (double)(1u << l->light.levels) / 512;
        if (l->left_out) continue;
        blocks += l->map_count * side * side;
        draws += l->map_count * (side < 1 ? 1 : side);
    }
    plan->has_exit_map    = c->solid_triangle_count != 0;
    plan->peels_all       = o->exit == EXIT_PEEL && o->maps != MAPS_SPARSE;
    plan->meeting_seconds = (double)c->solid_triangle_count * MEETING_SECONDS_PER_TRIANGLE / o->threads;
    plan->peeling_seconds =
        blocks * PEELING_SECONDS_PER_BLOCK + draws * (double)c->solid_triangle_count * PEELING_SECONDS_PER_TRIANGLE;
    if (o->maps == MAPS_SPARSE) return; /* nothing is peeled */
    plan->meeting_known = plan->has_exit_map && o->exit == EXIT_AUTO && plan->peeling_seconds > plan->meeting_seconds;
    if (o->exit == EXIT_AUTO && !plan->meeting_known) plan->peels_all = plan->has_exit_map;
}

/* sub-DAGs -------------------------------------------------------------------------------------------------------------------- */

/* Compression finds repetition within a sub-DAG on all threads. The merge would find it too, on one thread, but spends less on
 * known nodes. */
static const double TOP_DOWN_SECONDS_PER_NODE = 4.5e-8, MERGE_SECONDS_PER_REPEATED_NODE = 1.5e-8;

/* estimates ------------------------------------------------------------------------------------------------------------------- */

typedef struct light_samples {
    bake_plan     *plan;
    bake_options   o;
    const casters *c;
    uint32_t       maps;
} light_samples;

static vxs_result sample_light(void *user, size_t n, uint32_t worker, run_context *m)
{
    light_samples *s = user;
    plan_light    *l = &s->plan->lights[n];
    (void)worker;
    if (l->left_out) return VXS_OK;
    return plan_sample_light(l, s->plan, s->maps, &s->o, s->c, m);
}

vxs_result plan_estimate(bake_plan *plan, const bake_options *o, const casters *c, run_context *m)
{
    light_samples s = {plan, *o, c, 0};
    for (size_t n = 0; n < plan->light_count; n++) s.maps += plan->lights[n].left_out ? 0 : plan->lights[n].map_count;
    int few = plan->baked_count < 2 * o->threads || o->memory_bytes; /* each is sampled on all threads */
    if (!few) s.o.threads = 1;
    vxs_result r = parallel_runs(few ? 1 : o->threads, plan->light_count, sample_light, &s, m);
    for (size_t n = 0; n < plan->light_count && r == VXS_OK; n++)
        if (!plan->lights[n].left_out) plan_estimate_light(&plan->lights[n], o);
    if (r != VXS_OK) return r;

    double inserted = 0, repeated = 0;
    for (size_t n = 0; n < plan->light_count; n++) {
        const plan_light *l   = &plan->lights[n];
        double            all = l->inserted_nodes + l->inserted_masks, kept = l->nodes + l->masks;
        inserted += all;
        repeated += all > kept ? all - kept : 0;
    }
    plan->compress_seconds     = inserted * TOP_DOWN_SECONDS_PER_NODE / o->threads;
    plan->merge_seconds_spared = repeated * MERGE_SECONDS_PER_REPEATED_NODE;
    int pays =
        o->stop == STOP_PARTIAL || o->compress != COMPRESS_CHOICE_AUTO || plan->merge_seconds_spared > plan->compress_seconds;
    plan->compress = o->stop == STOP_INSERT || !pays ? COMPRESS_NONE : compress_order_of(o->compress);

    plan_estimate_scene(plan, c);
    return VXS_OK;
}

/* memory ---------------------------------------------------------------------------------------------------------------------- */

/* Memory of the kept pictures and one in work; each counts as the largest. */
static uint64_t picture_bytes(const bake_plan *plan)
{
    uint64_t largest = 0;
    for (size_t n = 0; n < plan->light_count; n++) {
        const plan_light *l     = &plan->lights[n];
        uint64_t          bytes = l->left_out ? 0 : light_picture_bytes(1u << l->light.levels, l->map_count);
        if (bytes > largest) largest = bytes;
    }
    return largest * (plan->baked_count < PICTURES_MAX ? plan->baked_count : PICTURES_MAX + 1);
}

/* Halve the tiles until the plan fits; the smallest are a sub-DAG, or a block. */
static vxs_result plan_memory(bake_plan *plan, const bake_options *o, const casters *c, run_context *m)
{
    uint32_t side = 8;
    for (size_t n = 0; n < plan->light_count; n++)
        if (!plan->lights[n].left_out) side = max_u32(side, 1u << plan->lights[n].light.levels);
    uint32_t least = min_u32(side, max_u32(TILE_MIN_PX, min_u32(side / 4, SUB_DAG_MAX_PX)));

    /* Cached squares have an eighth of the map's side, so that a change affects a small part of it. Rendered squares are as large
     * as possible, because each draws all triangles that it may see. */
    plan->tile_px       = stores_squares(o) && o->maps == MAPS_SPARSE ? max_u32(least, side / 8) : side;
    plan->tile_px       = min_u32(plan->tile_px, TILE_MAX_PX);
    plan->budget_bytes  = o->memory_bytes;
    plan->picture_bytes = o->page_path ? picture_bytes(plan) : 0;
    plan->peak_bytes    = plan_peak_bytes(plan, o, c, plan->tile_px);
    uint64_t held = memory_held_bytes(), left = memory_available_bytes();
    uint64_t machine  = left < UINT64_MAX - held ? held + left : UINT64_MAX;
    uint64_t most     = plan->budget_bytes ? min_u64(plan->budget_bytes, machine) : machine;
    /* straight from triangles, memory is what is built, which a sample estimates only within a half: a bake that may fit is begun,
     * and fails if it does not */
    uint64_t bytes    = plan_peak_bytes(plan, o, c, least);
    plan->least_bytes = o->maps == MAPS_SPARSE ? bytes / 3 * 2 : bytes;
    while (plan->peak_bytes > most && plan->tile_px > least) {
        plan->tile_px /= 2;
        plan->peak_bytes = plan_peak_bytes(plan, o, c, plan->tile_px);
    }
    if (plan->least_bytes <= most) return VXS_OK;
    char there[32], needed[32];
    if (most < machine)
        return fail(m, VXS_E_MEMORY, "--memory %s is too little for '%s': this bake needs about %s at least",
                    size_text(there, most), o->scene_path, size_text(needed, plan->least_bytes));
    return fail(m, VXS_E_MEMORY, "there is too little memory for '%s', %s: this bake needs about %s at least", o->scene_path,
                size_text(there, machine), size_text(needed, plan->least_bytes));
}

/* Take the number of tiles from the samples. */
static void take_tiles(bake_plan *plan)
{
    uint32_t size = 0;
    while (size + 1 < TILE_SIZES && (uint32_t)TILE_MAX_PX >> size > plan->tile_px) size++;
    for (plan_light *l = plan->lights; l < plan->lights + plan->light_count; l++) {
        l->tiles       = l->sample.tiles[size];
        l->tiles_empty = l->sample.tiles_empty[size];
    }
}

vxs_result plan_make(bake_plan *plan, const bake_options *o, casters *c, const scene *s, const light_choice *chosen,
                     uint64_t scene_bytes, run_context *m)
{
    double start = clock_seconds();
    *plan        = (bake_plan){.scene_bytes = scene_bytes};
    vxs_result r = light_choice_require(chosen, "--resolution", &o->resolutions, m);
    if (r == VXS_OK) r = light_choice_require(chosen, "--texel", &o->texels, m);
    if (r == VXS_OK) r = fit_lights(plan, o, c, chosen, m);
    if (r == VXS_OK) {
        plan_check_lights(plan, o, c, s, m);
        r = run_check(m);
    }
    if (r == VXS_OK) {
        plan_exit(plan, o, c);
        if (plan->meeting_known) r = casters_find_meeting(c, o->threads, m);
    }
    if (r == VXS_OK) r = plan_estimate(plan, o, c, m);
    if (r == VXS_OK) r = plan_memory(plan, o, c, m);
    if (r == VXS_OK) take_tiles(plan);
    plan->plan_seconds = clock_seconds() - start;
    if (r != VXS_OK) plan_free(plan);
    return r;
}

void plan_free(bake_plan *plan)
{
    free(plan->lights);
    memset(plan, 0, sizeof *plan);
}
