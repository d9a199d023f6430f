/* Baking one light; see bake_light.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/bake/bake_light.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "baker/measure/clock.h"
#include "baker/base/integer.h"
#include "baker/base/parallel.h"
#include "baker/measure/progress.h"

/* A light while it is baked. */
typedef struct light_job {
    light_baker      *baker;
    const plan_light *planned;
    casters           casters; /* that the light may reach */
    light_report     *report;
    baseline         *base;
    light_picture    *picture; /* NULL: nobody asked for one */
    dag_merger       *merger;
    depth_renderer   *renderer; /* of the map in work */
    depth_maps        maps;     /* of the tile in work */
    uint32_t          map, map_count;
    uint32_t          tiles_done;
} light_job;

/* one map tile into sub-DAGs -------------------------------------------------------------------------------------------------- */

typedef struct sub_dag {
    tile_masks masks;
    dag        dag;
    vxs_result result;
    uint64_t   nodes, mask_nodes, mask_tiles, mask_runs;
} sub_dag;

typedef struct tile_job {
    const bake_options *o;
    const bake_plan    *plan;
    light_picture      *picture; /* NULL, or what gets the masks of the tile at (i, j) of a map */
    uint32_t            map, i, j;
    column_source       source;
    uint32_t            sub_px; /* side of a sub-DAG */
    sub_dag            *subs;   /* in z order */
} tile_job;

/* A sub-DAG is a quarter of the map as wide, so that threads have something to share, and at most SUB_DAG_MAX_PX: whatever the size
 * of map tiles, because where sub-DAGs end decides some undefined voxels. */
static uint32_t sub_dag_side(uint32_t side_px)
{
    uint32_t side = min_u32(side_px / 4, SUB_DAG_MAX_PX);
    return side < 8 ? 8 : side;
}

/* Every other bit. */
static uint32_t even_bits(uint32_t n)
{
    uint32_t even = 0;
    for (uint32_t bit = 0; bit < 16; bit++) even |= (n >> 2 * bit & 1) << bit;
    return even;
}

typedef struct square_at {
    uint32_t i, j;
} square_at;

/* The n-th square of a power of two of them, in z order. Tiles of any size then visit sub-DAGs in one order, and the bytes are the same. */
static square_at z_order(uint32_t n)
{
    return (square_at){even_bits(n), even_bits(n >> 1)};
}

static void masks_of_sub(void *user, size_t begin, size_t end, uint32_t worker)
{
    tile_job *t     = user;
    uint32_t  tiles = t->sub_px / 8;
    (void)worker;
    for (size_t n = begin; n < end; n++) {
        sub_dag  *s  = &t->subs[n];
        square_at at = z_order((uint32_t)n);
        s->result    = tile_masks_build(&s->masks, &t->source, at.i * tiles, at.j * tiles, tiles, t->o->rule);
        if (s->result != VXS_OK) continue;
        s->mask_runs  = s->masks.run_count;
        uint32_t side = t->source.side_px / 8;
        if (t->picture)
            light_picture_add_masks(t->picture, &s->masks, t->map, t->i * side + at.i * tiles, t->j * side + at.j * tiles);
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
        square_at at = z_order((uint32_t)n);
        s->result    = dag_insert(&s->dag, &t->source, at.i, at.j, dag_levels(t->sub_px), &s->masks, t->o->reuse);
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
        if (t->subs[n].result == VXS_OK) t->subs[n].result = dag_compress(&t->subs[n].dag, t->plan->compress);
}

/* A rendered tile into the merger: pyramid, masks, insertion, compression, merge. */
static vxs_result add_tile(light_job *job, uint32_t i, uint32_t j)
{
    const bake_options *o     = job->baker->options;
    light_report       *light = job->report;
    depth_maps         *maps  = &job->maps;
    stage_timer         timer = stage_begin(job->baker->report);
    depth_maps_reduce(maps, o->threads);
    stage_end(&timer, STAGE_PYRAMID);

    tile_job t     = {.o       = o,
                      .plan    = job->baker->plan,
                      .picture = job->picture,
                      .map     = job->map,
                      .i       = i,
                      .j       = j,
                      .source  = depth_maps_columns(maps),
                      .sub_px  = sub_dag_side(maps->depth_vx)};
    uint32_t side  = maps->side_px / t.sub_px;
    uint32_t count = side * side;
    t.subs         = calloc(count, sizeof *t.subs);
    if (!t.subs) return VXS_E_MEMORY;

    parallel_for(o->threads, count, 1, masks_of_sub, &t);
    stage_end(&timer, STAGE_MASKS);
    parallel_for(o->threads, count, 1, insert_sub, &t);
    stage_end(&timer, STAGE_INSERT);
    if (t.plan->compresses) parallel_for(o->threads, count, 1, compress_sub, &t);
    stage_end(&timer, STAGE_COMPRESS);

    vxs_result r = VXS_OK;
    for (uint32_t n = 0; n < count; n++) {
        sub_dag *s = &t.subs[n];
        if (r == VXS_OK) r = s->result;
        square_at at = z_order(n);
        if (r == VXS_OK) r = dag_merger_add(job->merger, &s->dag, job->map, i * side + at.i, j * side + at.j);
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

/* Planned seconds of a tile of the light. */
static double tile_seconds(const light_job *job)
{
    const plan_light *l     = job->planned;
    double            light = 0;
    for (int s = STAGE_MAPS; s <= STAGE_MERGE; s++) light += l->seconds[s];
    return light / (double)l->tiles;
}

/* Before a tile, and while its maps are rendered, which takes most of its time: `part` of it is done. The first of a bake is always
 * named. */
static void say_progress(void *user, double part)
{
    const light_job   *job   = user;
    const light_baker *b     = job->baker;
    double             share = fmin(1, (b->past_seconds + part * tile_seconds(job)) / b->plan->total_seconds);
    unsigned           all = (unsigned)job->planned->tiles, tile = job->tiles_done + 1, percent = (unsigned)(100 * share);
    if (part == 0 && tile == 1 && b->report->light_count == 1)
        progress_say(b->options->progress, "light %s: tile 1 of %u", job->planned->name, all);
    else
        progress_share(b->options->progress, share, b->start, "%u %%: light %s: tile %u of %u", percent, job->planned->name, tile,
                       all);
}

static vxs_result bake_tile(light_job *job, uint32_t i, uint32_t j, message *m)
{
    bake_report *report = job->baker->report;
    int          empty  = !depth_renderer_has_casters(job->renderer, job->maps.side_px, i, j);
    vxs_result   r      = VXS_OK;
    job->report->tiles++;
    job->report->tiles_skipped += (uint64_t)empty;
    stage_timer timer = stage_begin(report);
    if (!empty) {
        r = depth_renderer_tile(job->renderer, &job->maps, i, j, m);
        stage_end(&timer, STAGE_MAPS);
    }
    if (r == VXS_OK && job->baker->plan->baseline != BASELINE_OFF && !baseline_add(job->base, &job->maps, empty)) r = VXS_E_MEMORY;
    report->baseline_seconds += clock_seconds() - timer.start;
    timer = stage_begin(report);
    if (r == VXS_OK && job->picture && !empty)
        light_picture_add_depths(job->picture, &job->maps, job->map, i, j, job->baker->options->threads);
    report->picture_seconds += clock_seconds() - timer.start;
    return r == VXS_OK && !empty ? add_tile(job, i, j) : r;
}

static void add_stats(depth_stats *sum, depth_stats s)
{
    sum->blocks_rendered += s.blocks_rendered;
    sum->blocks_empty += s.blocks_empty;
    sum->blocks_peeled += s.blocks_peeled;
    sum->blocks_not_peeled += s.blocks_not_peeled;
    sum->triangles_drawn += s.triangles_drawn;
    sum->peel_passes += s.peel_passes;
    if (s.peel_passes_max > sum->peel_passes_max) sum->peel_passes_max = s.peel_passes_max;
}

static exit_mode exit_of(const light_baker *b)
{
    return b->plan->peels_all ? EXIT_PEEL : b->options->exit;
}

static vxs_result bake_map(light_job *job, message *m)
{
    light_baker        *b     = job->baker;
    const bake_options *o     = b->options;
    const vxs_light    *light = &job->report->light;
    uint32_t            side  = (1u << light->levels) / job->maps.side_px;
    stage_timer         timer = stage_begin(b->report);
    vxs_result r = depth_renderer_create(&job->renderer, b->gl, &job->casters, light, (int)job->map, exit_of(b), o->threads, m);
    stage_end(&timer, STAGE_GL);
    if (r == VXS_OK) depth_renderer_watch(job->renderer, say_progress, job);
    for (uint32_t n = 0; n < side * side && r == VXS_OK; n++) {
        square_at at = z_order(n);
        say_progress(job, 0);
        r = bake_tile(job, at.i, at.j, m);
        if (r == VXS_OK) r = bake_within_budget(o, b->report, m);
        job->tiles_done++;
        b->past_seconds += tile_seconds(job);
    }
    if (r == VXS_OK) add_stats(&job->report->depth, depth_renderer_stats(job->renderer));
    depth_renderer_destroy(job->renderer);
    job->renderer = NULL;
    return r;
}

vxs_result bake_light(light_baker *b, const plan_light *planned, dag *out, baseline *base, light_picture *picture,
                      light_report *light, message *m)
{
    const bake_options *o    = b->options;
    light_job           job  = {.baker = b, .planned = planned, .report = light, .base = base, .picture = picture};
    int                 lamp = planned->light.kind != VXS_LIGHT_KIND_DIRECTIONAL;
    uint32_t            side = 1u << planned->light.levels;
    uint32_t            tile = min_u32(side, b->plan->tile_px);
    vxs_result          r;

    stage_timer timer = stage_begin(b->report);
    if ((r = reach_casters(&job.casters, &b->plan->reach, b->casters, &planned->shape, m)) != VXS_OK) goto done;
    light->light  = planned->light;
    job.map_count = planned->map_count;
    if ((r = depth_maps_init(&job.maps, tile, side, lamp ? light->light.voxel_metres : 0, b->plan->has_exit_map, m)) != VXS_OK)
        goto done;
    if ((r = dag_merger_create(&job.merger, side, sub_dag_side(side), job.map_count, o->stop == STOP_FINAL)) != VXS_OK) goto done;
    stage_end(&timer, STAGE_GL);

    base->limit_per_map =
        b->plan->baseline == BASELINE_FULL ? 0 : ((size_t)256 << 10) / ((side / tile) * (side / tile) * job.map_count);
    for (job.map = 0; job.map < job.map_count && r == VXS_OK; job.map++) r = bake_map(&job, m);
    if (r != VXS_OK) goto done;

    timer = stage_begin(b->report);
    r     = dag_merger_finish(job.merger, out);
    stage_end(&timer, STAGE_MERGE);
done:
    if (r == VXS_E_MEMORY) fail(m, r, "out of memory while baking light '%s'", planned->name);
    dag_merger_destroy(job.merger);
    reach_release(&job.casters, b->casters);
    depth_maps_free(&job.maps);
    return r;
}
