/* Estimates of a plan; see plan.h.
 *
 * Counts are those of the sample times its weight. The number of distinct nodes is a power of the number of inserted ones, as the
 * vocabulary of a text is of its length (Heaps' law). The same holds for distinct blocks and patterns. The exponent is computed
 * from the share of distinct ones in the sample. Seconds and bytes are linear in the counts. The coefficients were fitted to 45
 * bakes of 21 scenes at 1024 to 16384 texels, those of palette blocks to 55 bakes of 20 scenes at 256 to 8192. Their seconds, and
 * those of maps straight from triangles, were fitted to the bakes of a city, a landscape and Sponza at 4096 to 65536 in
 * docs/measurements.md.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <math.h>

#include "baker/bake/plan.h"
#include "baker/base/portable_math.h"
#include "baker/columns/descent.h"
#include "baker/columns/sparse/sparse_columns.h"

/* counts ---------------------------------------------------------------------------------------------------------------------- */

/* Number of distinct ones among `weight` times as many; `unlike`: the exponent if all in the sample are distinct. */
static double different(uint64_t unique, uint64_t all, double weight, double alike, double unlike)
{
    double share = all ? (double)unique / (double)all : 0;
    return (double)unique * portable_pow(weight, alike + (unlike - alike) * share);
}

static void estimate_dag(plan_light *l)
{
    const light_sample *s        = &l->sample;
    int                 top      = (int)fmin(SAMPLE_LEVELS, l->light.levels - 2) - 1;
    double              inserted = 0;
    for (int n = 0; n <= top; n++) inserted += (double)s->nodes[n];

    /* of the levels above a window, each has fewer nodes by the same factor */
    double upper = 0;
    if (top == SAMPLE_LEVELS - 1) {
        double ratio = s->nodes[top - 1] ? (double)s->nodes[top] / (double)s->nodes[top - 1] : 0.25;
        ratio        = fmin(fmax(ratio, 0.25), 0.6);
        upper        = (double)s->nodes[top] * ratio / (1 - ratio);
    }
    l->mask_runs      = (double)s->mask_runs * s->weight;
    l->inserted_masks = (double)s->masks * s->weight;
    l->inserted_nodes = (inserted + upper) * s->weight;
    l->masks          = different(s->unique_masks, s->masks, s->weight, 0.55, 0.82);
    l->nodes          = different(s->unique_nodes, (uint64_t)inserted, s->weight, 0.70, 0.98);
    l->memory_bytes   = 8 * l->masks + 15.5 * l->nodes;
    l->stored_bytes   = 3.9 * (l->masks + l->nodes) + 600;
    l->built_bytes    = 71 * (l->nodes + l->masks);
    l->part_bytes     = 11 * (l->inserted_nodes + l->inserted_masks);
}

/* fast: packing of its pages */
static void estimate_blocks(plan_light *l, int fast)
{
    const light_sample *s       = &l->sample;
    palette_estimate   *p       = &l->palette;
    double              weight  = l->sample.weight;
    double              squares = fmax(1, ldexp(1, 2 * ((int)l->light.levels - 8))) * l->map_count;
    double              grown   = different(s->patterns, s->mask_tiles, weight, 0.85, 0.95) / fmax(1, (double)s->patterns);
    p->blocks                   = different(s->unique_blocks, s->palette_blocks, weight, 0.70, 1.0);
    p->patterns                 = (double)s->patterns * grown;
    p->private_patterns         = (double)s->private_patterns * grown;
    p->block_words              = (double)s->block_words * p->blocks / fmax(1, (double)s->unique_blocks);
    p->pattern_words            = (double)s->pattern_words * grown;

    /* a node takes a word for each of its blocks, fewer if blocks repeat, and some words for itself */
    double blocks     = (double)l->sample.palette_blocks * l->sample.weight;
    double node_words = 1.1 * sqrt(blocks * l->palette.blocks) + 5.5 * fmin(squares, blocks);
    p->words          = 8 + 2 * squares + node_words + p->block_words + p->pattern_words;
    l->memory_bytes   = 4 * p->words;
    l->stored_bytes   = (fast ? 1.75 : 1) * (1.1 * p->block_words + 1.7 * p->pattern_words) + 600;

    /* memory until all is built: patterns with freely chosen depths repeat more often the more there are; private-palette patterns
     * rarely repeat */
    enum { REPEATING = 20000 };
    double own  = (double)s->private_patterns * portable_pow(weight, 0.95);
    double free = fmax(0, p->patterns - p->private_patterns);
    if (free > REPEATING) free = REPEATING * portable_pow(free / REPEATING, 0.35);
    l->built_bytes = 1200 * own + 150 * free + 60 * p->blocks + 6 * p->words;
    l->part_bytes  = 0.3 * l->built_bytes;
}

/* seconds and bytes, for one light -------------------------------------------------------------------------------------------- */

void plan_estimate_light(plan_light *l, const bake_options *o)
{
    l->mask_tiles = (double)l->sample.mask_tiles * l->sample.weight;
    int fast      = o->pack == PACK_FAST;
    o->coding == CODING_DAG ? estimate_dag(l) : estimate_blocks(l, fast);

    const light_sample *s       = &l->sample;
    double              texels  = ldexp(1, 2 * (int)l->light.levels) * l->map_count;
    double              full    = texels * (1 - (double)s->tiles_empty[0] / (double)s->tiles[0]); /* of tiles with triangles */
    double              block   = texels / (double)s->blocks / (512.0 * 512.0); /* relative to a block of full size */
    double              drawn   = (double)(s->blocks - s->blocks_empty) * block;
    double              solid   = (double)(s->blocks_peeled + s->blocks_not_peeled) * block;
    double              peeled  = (double)s->blocks_peeled * block;
    double              threads = o->threads;

    if (o->maps == MAPS_SPARSE) {
        l->seconds[STAGE_MAPS] = (1.7e-7 * (double)l->sample.triangles + 7.5e-7 * l->mask_tiles) / threads;
    } else {
        /* rendering waits for one of two threads */
        l->seconds[STAGE_GL]      = 5e-4 * l->map_count + 4.5e-8 * (double)l->sample.triangles;
        l->seconds[STAGE_MAPS]    = 6e-4 * drawn + 1e-3 * solid + 5e-3 * peeled + 4e-7 * (double)s->block_triangles;
        l->seconds[STAGE_PYRAMID] = 1e-9 * full / threads;
    }
    if (o->coding == CODING_DAG) {
        double inserted = l->inserted_nodes + l->inserted_masks, kept = l->nodes + l->masks;
        l->seconds[STAGE_MASKS]  = (1.7e-10 * full + 2.4e-7 * l->mask_tiles) / threads;
        l->seconds[STAGE_INSERT] = (7e-11 * full + 3.3e-8 * inserted) / threads;
        l->seconds[STAGE_MERGE]  = 1.2e-8 * inserted + 7e-8 * kept;
        l->seconds[STAGE_ENCODE] = 3.7e-7 * kept;
        l->seconds[STAGE_WRITE]  = 3.7e-8 * kept;
    } else {
        l->seconds[STAGE_MASKS]  = (5e-12 * full + 8e-7 * l->mask_tiles) / threads;
        l->seconds[STAGE_MERGE]  = 3.5e-7 * l->palette.patterns;
        l->seconds[STAGE_ENCODE] = (fast ? 4e-7 : 6e-8) * l->palette.words;
        l->seconds[STAGE_WRITE]  = (fast ? 5e-8 : 3e-9) * l->palette.words;
    }
}

/* the scene ------------------------------------------------------------------------------------------------------------------- */

void plan_estimate_scene(bake_plan *plan, const casters *c)
{
    double compress = plan->compress != COMPRESS_NONE ? plan->compress_seconds : 0;
    double bytes    = 1200;
    double memory   = 0;
    for (int s = 0; s < STAGE_COUNT; s++) plan->seconds[s] = 0;
    for (size_t n = 0; n < plan->light_count; n++) {
        const plan_light *l = &plan->lights[n];
        for (int s = 0; s < STAGE_COUNT; s++) plan->seconds[s] += l->seconds[s];
        bytes += l->stored_bytes;
        memory += l->memory_bytes;
    }
    plan->seconds[STAGE_LOAD]   = 1e-3 + 3e-10 * (double)plan->scene_bytes + 2.5e-8 * (double)c->triangle_count;
    plan->seconds[STAGE_SOLIDS] = 6.5e-8 * (double)c->triangle_count;
    plan->seconds[STAGE_PLAN]   = (plan->meeting_known ? plan->meeting_seconds : 0) + 3e-8 * (double)c->triangle_count + 1e-3 +
                                5e-4 * (double)plan->baked_count;
    if (plan->seconds[STAGE_GL] > 0) { /* some light is rendered */
        plan->seconds[STAGE_GL] += 0.026;
        plan->seconds[STAGE_MAPS] += 0.02; /* compilation of shaders */
    }
    plan->seconds[STAGE_COMPRESS] = compress;
    plan->total_seconds           = 0;
    for (int s = 0; s < STAGE_COUNT; s++) plan->total_seconds += plan->seconds[s];
    plan->file_bytes   = (uint64_t)bytes;
    plan->memory_bytes = (uint64_t)memory;
}

/* Memory of the scene, the casters and their projection. */
static double array_bytes(const casters *c)
{
    return 54 * (double)c->triangle_count + 24 * (double)c->scene_vertex_count + 56 * (double)c->vertex_count;
}

/* Peak while squares are computed straight from triangles: triangles and their lists; for each thread a square, with bounds of all
 * of its tiles and columns of some, unevenly distributed; and built squares that wait for their turn. */
static uint64_t sparse_peak_bytes(const bake_plan *plan, const bake_options *o, const casters *c, uint32_t tile_px)
{
    double square = 0, built = 0;
    for (size_t n = 0; n < plan->light_count; n++) {
        const plan_light *l = &plan->lights[n];
        if (l->left_out) continue;
        double map = ldexp(1, (int)l->light.levels), side = fmin(fmin(map / 4, tile_px), SPARSE_PARALLEL_PX);
        double part  = side * side / (map * map) / l->map_count;
        double tiles = fmin(side * side / 64, (part < 1 ? 2 : 1) * part * l->mask_tiles);
        square       = fmax(square, o->threads * (side * side / 64 * 30 + 540 * tiles) +
                                        fmin(1, descent_slots(o->threads) * part) * l->part_bytes + 80 * (double)l->sample.triangles);
        built += l->built_bytes;
    }
    return (uint64_t)(1.15 * (11e6 + 20e3 * (double)plan->baked_count + array_bytes(c) + square + built));
}

uint64_t plan_peak_bytes(const bake_plan *plan, const bake_options *o, const casters *c, uint32_t tile_px)
{
    if (o->maps == MAPS_SPARSE) return sparse_peak_bytes(plan, o, c, tile_px) + plan->picture_bytes;

    /* Peak while a tile is rendered or merged: its maps, the memory of OpenGL and the scene, everything built so far, and what
     * is built of the tile. */
    double texel = plan->has_exit_map ? 8 : 4, pyramid = 1.0 / 3, tile = 0, built = 0, drawn = 0;
    for (size_t n = 0; n < plan->light_count; n++) {
        const plan_light *l = &plan->lights[n];
        if (l->left_out) continue;
        double side = fmin(ldexp(1, (int)l->light.levels), tile_px);
        double part = side * side / ldexp(1, 2 * (int)l->light.levels) / l->map_count;
        tile        = fmax(tile, side * side * (texel + pyramid) + part * l->part_bytes);
        built += l->built_bytes;
        drawn = fmax(drawn, (double)l->sample.block_most);
    }
    /* triangles of a block, with separate vertices in the worst case, and llvmpipe's bins for them */
    double block = 28 * drawn + 24 * fmin(3 * drawn, (double)c->vertex_count) + 150 * fmin(drawn, DRAW_MAX);
    return (uint64_t)(1.06 * (118e6 + 150e3 * (double)plan->baked_count + array_bytes(c) + block + built + tile +
                              (double)plan->picture_bytes));
}
