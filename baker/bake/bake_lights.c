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

/* picture  NULL: not wanted */
static vxs_result bake_planned(const bake_options *o, const bake_plan *plan, const plan_light *planned, const casters *c,
                               void *device, bake_squares *squares, light_picture *picture, coded_light *out, light_report *light,
                               bake_context *ctx)
{
    light_columns columns;
    light_squares cache;
    chosen_coder  coding;
    chosen_coder_init(&coding, o, plan->compress, picture);
    light_columns_init(&columns, device, o, plan, planned, c, picture);
    column_source source = light_columns_source(&columns);
    vxs_result    r      = light_squares_source(&cache, squares, &source, &planned->light, light, ctx->run);
    if (r == VXS_OK) r = bake_light(planned, &source, &coding.coder, is_baked_apart(o) ? NULL : out, ctx);

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
static vxs_result bake_next(const bake_options *o, const plan_light *planned, const casters *c, void *device, coded_light *coded,
                            bake_squares *squares, bake_report *report, bake_context *ctx)
{
    const bake_plan *plan  = report->plan;
    uint32_t         baked = report->light_count++, larger = 0;
    light_picture    picture = {0};
    vxs_result       r       = VXS_OK;

    /* a picture takes time, and with many lights most are dropped: make one of a light that may be one of the largest */
    for (size_t n = 0; n < plan->light_count; n++) larger += plan->lights[n].stored_bytes > planned->stored_bytes;
    int wanted = o->page_path && larger < 4 * PICTURES_MAX;
    if (wanted) r = light_picture_init(&picture, baked, 1u << planned->light.levels, planned->map_count, ctx->run);
    if (r == VXS_OK)
        r = bake_planned(o, plan, planned, c, device, squares, wanted ? &picture : NULL, &coded[baked], &report->lights[baked],
                         ctx);
    if (r == VXS_OK && wanted)
        keep_picture(report, coded, &picture);
    else
        light_picture_free(&picture);
    return r;
}

/* several at once ------------------------------------------------------------------------------------------------------------- */

/* Small lights share nothing but the processor: many threads for each would wait for one another more than they work. */

typedef struct light_group {
    bake_options             own_thread; /* those of the bake, with one thread */
    const casters           *c;
    bake_report             *report;
    coded_light             *coded;
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
    size_t              baked   = g->first + n;
    bake_squares        none    = {0};
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
    vxs_result r = bake_planned(&g->own_thread, g->report->plan, planned, g->c, NULL, &none, NULL, &g->coded[baked],
                                &g->report->lights[baked], &ctx);
    os_lock(&g->lock);
    for (int s = 0; s < STAGE_NONE; s++) g->seconds[s] += ctx.stage[s].seconds;
    g->past_seconds += building_seconds(planned);
    os_unlock(&g->lock);
    return r;
}

static vxs_result bake_group(const bake_options *o, const casters *c, const plan_light *const *planned, size_t count,
                             coded_light *coded, bake_report *report, bake_context *ctx)
{
    light_group g        = {*o, c, report, coded, planned, report->light_count, ctx, .past_seconds = ctx->past_seconds};
    g.own_thread.threads = 1;
    os_mutex_init(&g.lock);
    stage_begin(ctx, STAGE_MAPS);
    vxs_result r = parallel_runs(o->threads, count, bake_alone, &g, ctx->run);
    stage_begin_after(ctx, STAGE_NONE, 0, g.seconds, STAGE_COUNT);
    os_mutex_free(&g.lock);
    report->light_count += (uint32_t)count;
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

vxs_result bake_lights(const bake_options *o, const casters *c, void *device, coded_light *coded, bake_squares *squares,
                       bake_report *report, bake_context *ctx)
{
    const bake_plan   *plan  = report->plan;
    const plan_light **baked = malloc(plan->baked_count * sizeof *baked);
    double             all   = 0;
    size_t             count = 0;
    vxs_result         r     = VXS_OK;
    if (!baked) return fail(ctx->run, VXS_E_MEMORY, "out of memory for %zu lights", plan->baked_count);
    for (size_t n = 0; n < plan->light_count; n++)
        if (!plan->lights[n].left_out) all += building_seconds(baked[count++] = &plan->lights[n]);

    /* memory that is limited, pictures and stored squares need one light after another */
    int together = o->threads > 1 && o->maps == MAPS_SPARSE && !o->page_path && !o->memory_bytes && !stores_squares(o);
    for (size_t n = 0, end; n < count && r == VXS_OK; n = end) {
        for (end = n; together && end < count && is_small(baked[end], o, c, all);) end++;
        if (end > n + 1) {
            r = bake_group(o, c, baked + n, end - n, coded, report, ctx);
            continue;
        }
        r   = bake_next(o, baked[n], c, device, coded, squares, report, ctx);
        end = n + 1;
    }
    free(baked);
    return r;
}
