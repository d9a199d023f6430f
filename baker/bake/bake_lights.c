/* The lights of a bake; see bake_lights.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/bake/bake_lights.h"

#include <stdlib.h>

#include "baker/bake/bake_light.h"
#include "baker/bake/light_columns.h"
#include "baker/base/parallel_runs.h"
#include "baker/base/threads.h"

enum { SMALL_TRIANGLES = 1 << 16 };

/* pictures -------------------------------------------------------------------------------------------------------------------- */

/* Keep the picture of a light that is one of the largest so far; release that of a smaller one. */
static void keep_picture(bake_report *report, const coded_light *coded, light_picture *picture)
{
    light_picture *least = &report->pictures[0];
    if (report->picture_count < PICTURES_MAX) {
        report->pictures[report->picture_count++] = *picture;
        return;
    }
    for (uint32_t n = 1; n < PICTURES_MAX; n++)
        if (coded[report->pictures[n].light].memory_bytes < coded[least->light].memory_bytes) least = &report->pictures[n];
    if (coded[picture->light].memory_bytes <= coded[least->light].memory_bytes) {
        light_picture_free(picture);
        return;
    }
    light_picture_free(least);
    *least = *picture;
}

/* one light ------------------------------------------------------------------------------------------------------------------- */

/* baked    its number among the baked ones
 * picture  NULL: not wanted */
static vxs_result bake_planned(const lights_job *job, const plan_light *planned, size_t baked, light_picture *picture,
                               bake_context *ctx)
{
    const bake_plan *plan  = job->report->plan;
    light_report    *light = &job->report->lights[baked];
    light_columns    columns;
    light_squares    cache;
    chosen_coder     coding;
    chosen_coder_init(&coding, job->o, plan->compress, picture);
    light_columns_init(&columns, job->device, job->o, plan, planned, job->c, picture);
    column_source source = light_columns_source(&columns);
    vxs_result    r      = light_squares_source(&cache, job->squares, &source, &planned->light, light, ctx->run);
    if (r == VXS_OK) r = bake_light(planned, &source, &coding.coder, is_baked_apart(job->o) ? NULL : &job->coded[baked], ctx);

    const build_stats *stats  = coding.stats;
    uint64_t           across = max_u32(1, (1u << planned->light.levels) / plan->tile_px);
    light->light              = planned->light;
    light->texels             = planned->texels;
    light->depth              = columns.rendered.stats;
    light->tiles              = planned->map_count * across * across;
    light->tiles_skipped      = light->tiles - stats->squares_fetched;
    light->mask_tiles         = stats->mask_tiles;
    light->mask_runs          = stats->mask_runs;
    light->inserted_nodes     = stats->inserted_nodes;
    light->inserted_masks     = stats->inserted_masks;
    light->palette            = coding.blocks.counts;
    chosen_coder_free(&coding);
    if (r == VXS_OK && picture) r = light_columns_draw(&columns, picture, ctx);
    light_columns_free(&columns);
    return r;
}

/* Bake the next light, with a picture if wanted. */
static vxs_result bake_next(const lights_job *job, const plan_light *planned, bake_context *ctx)
{
    const bake_plan *plan  = job->report->plan;
    uint32_t         baked = job->report->light_count++, larger = 0;
    light_picture    picture = {0};
    vxs_result       r       = VXS_OK;

    /* a picture takes time, and with many lights most are dropped: make one of a light that may be one of the largest */
    for (size_t n = 0; n < plan->light_count; n++) larger += plan->lights[n].stored_bytes > planned->stored_bytes;
    int wanted = job->o->page_path && larger < 4 * PICTURES_MAX;
    if (wanted) r = light_picture_init(&picture, baked, 1u << planned->light.levels, planned->map_count, ctx->run);
    if (r == VXS_OK) r = bake_planned(job, planned, baked, wanted ? &picture : NULL, ctx);
    if (r == VXS_OK && wanted)
        keep_picture(job->report, job->coded, &picture);
    else
        light_picture_free(&picture);
    return r;
}

/* several at once ------------------------------------------------------------------------------------------------------------- */

/* Small lights share nothing but the processor: many threads for each would wait for one another more than they work. */

typedef struct light_group {
    lights_job               job;     /* that of the bake, with one thread */
    const plan_light *const *planned; /* [count of the group] */
    uint32_t                 first;   /* number of its first light among the baked ones */
    const bake_context      *ctx;     /* of the bake */

    os_mutex lock;
    double   past_seconds;        /* planned for lights that are done */
    double   seconds[STAGE_NONE]; /* sums over the threads */
} light_group;

static double building_seconds(const plan_light *planned)
{
    double seconds = 0;
    for (int s = STAGE_MAPS; s <= STAGE_MERGE; s++) seconds += planned->seconds[s];
    return seconds;
}

static vxs_result bake_alone(void *user, size_t n, uint32_t worker, run_context *own)
{
    light_group        *g       = user;
    const plan_light   *planned = g->planned[n];
    const bake_context *all     = g->ctx;
    os_lock(&g->lock);
    bake_context ctx = {.run           = own,
                        .threads       = 1,
                        .watch         = worker ? NULL : all->watch, /* the caller's thread */
                        .subject       = all->subject,
                        .unmeasured    = 1,
                        .begun         = all->begun,
                        .total_seconds = all->total_seconds,
                        .past_seconds  = g->past_seconds,
                        .steps         = all->steps + 1};
    os_unlock(&g->lock);
    bake_squares none = {0};
    lights_job   job  = g->job;
    job.squares       = &none;
    vxs_result r      = bake_planned(&job, planned, g->first + n, NULL, &ctx);
    os_lock(&g->lock);
    for (int s = 0; s < STAGE_NONE; s++) g->seconds[s] += ctx.stage[s].seconds;
    g->past_seconds += building_seconds(planned);
    os_unlock(&g->lock);
    return r;
}

static vxs_result bake_group(const lights_job *job, const plan_light *const *planned, size_t count, bake_context *ctx)
{
    bake_options own_thread = *job->o;
    light_group  g          = {*job, planned, job->report->light_count, ctx, .past_seconds = ctx->past_seconds};
    own_thread.threads      = 1;
    g.job.o                 = &own_thread;
    os_mutex_init(&g.lock);
    stage_begin(ctx, STAGE_MAPS);
    vxs_result r = parallel_runs(job->o->threads, count, bake_alone, &g, ctx->run);
    stage_begin_after(ctx, STAGE_NONE, 0, g.seconds, STAGE_COUNT);
    os_mutex_free(&g.lock);
    job->report->light_count += (uint32_t)count;
    ctx->past_seconds = g.past_seconds;
    ctx->steps        = 1;
    return r == VXS_OK ? context_check(ctx) : r;
}

/* Whether a light takes so little of the bake and of memory that it can be baked beside others. */
static int is_small(const plan_light *planned, const bake_options *o, const casters *c, double all_seconds)
{
    return o->threads * planned->sample.triangles <= max_u64(c->triangle_count, SMALL_TRIANGLES) &&
           2 * o->threads * building_seconds(planned) <= all_seconds;
}

vxs_result bake_lights(const lights_job *job, bake_context *ctx)
{
    const bake_options *o     = job->o;
    const bake_plan    *plan  = job->report->plan;
    const plan_light  **baked = malloc(plan->baked_count * sizeof *baked);
    double              all   = 0;
    size_t              count = 0;
    vxs_result          r     = VXS_OK;
    if (!baked) return fail(ctx->run, VXS_E_MEMORY, "out of memory for %zu lights", plan->baked_count);
    for (size_t n = 0; n < plan->light_count; n++)
        if (!plan->lights[n].left_out) all += building_seconds(baked[count++] = &plan->lights[n]);

    /* memory that is limited, pictures and stored squares need one light after another */
    int together = o->threads > 1 && o->maps == MAPS_SPARSE && !o->page_path && !o->memory_bytes && !stores_squares(o);
    for (size_t n = 0, end; n < count && r == VXS_OK; n = end) {
        for (end = n; together && end < count && is_small(baked[end], o, job->c, all);) end++;
        if (end > n + 1) {
            r = bake_group(job, baked + n, end - n, ctx);
            continue;
        }
        r   = bake_next(job, baked[n], ctx);
        end = n + 1;
    }
    free(baked);
    return r;
}
