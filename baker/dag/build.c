/* From columns to DAGs; see build.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/dag/build.h"

#include <stdlib.h>
#include <string.h>

#include "baker/base/array.h"
#include "baker/base/parallel.h"
#include "baker/measure/clock.h"

uint32_t sub_dag_side(uint32_t map_side_px)
{
    return max_u32(8, min_u32(map_side_px / 4, SUB_DAG_MAX_PX));
}

/* one square ------------------------------------------------------------------------------------------------------------------ */

/* The end of a step of a square: its time is noted, and `after` is called. */
static vxs_result step_end(const build_options *o, bake_stage stage, double *since, column_tree *tree, dag *d, build_stats *stats)
{
    double now = clock_seconds();
    stats->seconds[stage - STAGE_MASKS] += now - *since;
    *since = now;
    return o->after ? o->after(o->user, stage, tree, d) : VXS_OK;
}

vxs_result dag_build_square(dag *d, const column_square *columns, uint32_t level, uint32_t i, uint32_t j, const build_options *o,
                            build_stats *stats)
{
    column_tree tree  = {0};
    double      since = clock_seconds();
    vxs_result  r;
    memset(d, 0, sizeof *d);
    if ((r = column_tree_build(&tree, columns, level, i, j, o->rule, o->share)) != VXS_OK) goto done;
    stats->squares_built++;
    stats->mask_tiles += tree.tile_count;
    stats->mask_runs += tree.run_count;
    if ((r = step_end(o, STAGE_MASKS, &since, &tree, d, stats)) != VXS_OK) goto done;
    if ((r = dag_insert(d, &tree, o->reuse)) != VXS_OK) goto done;
    column_tree_free(&tree);
    stats->inserted_nodes += dag_node_count(d);
    stats->inserted_masks += d->mask_count;
    if ((r = step_end(o, STAGE_INSERT, &since, &tree, d, stats)) != VXS_OK) goto done;
    if ((r = dag_compress(d, o->compress)) != VXS_OK) goto done;
    r = step_end(o, STAGE_COMPRESS, &since, &tree, d, stats);
done:
    column_tree_free(&tree);
    if (r != VXS_OK) dag_free(d);
    return r;
}

/* a map ----------------------------------------------------------------------------------------------------------------------- */

/* A square that is to be built. */
typedef struct sub_dag {
    uint32_t    level, i, j;    /* the square of the map that it fills: larger than a sub-DAG where all columns are alike */
    uint32_t    from_i, from_j; /* the square of a sub-DAG's side that is built, in the fetched columns */
    dag         dag;
    build_stats stats;
    vxs_result  result;
} sub_dag;

/* As many sub-DAGs are in memory at once. */
enum { BATCH = 64 };

typedef struct map_builder {
    dag_merger          *g;
    const column_map    *columns;
    const build_options *o;
    build_stats         *stats;
    bake_context        *ctx;
    uint32_t             map, sub_level;

    const column_square *fetched; /* NULL between fetches */
    uint32_t             fetched_level, fetched_i, fetched_j;
    sub_dag              batch[BATCH];
    uint32_t             batch_count;
} map_builder;

/* A square is decided when each of its sub-DAGs would be nothing but slabs of light and shadow, the same in all of them. A sub-DAG is lit up
 * to the last boundary of slabs that its xmin allows, which lies anywhere between the xmin and the xmax of a larger square.
 * lit_slabs  [out] slabs as deep as a sub-DAG is wide that are lit */
static int is_decided(const map_builder *b, const column_bounds *bounds, uint32_t level, uint32_t *lit_slabs)
{
    uint32_t shift = b->sub_level + 3, boundary = bounds->xmin >> shift << shift;
    *lit_slabs = boundary >> shift;
    /* within a slab of the square the boundary takes nodes, of which parts that are not shared want their own */
    if (!b->o->share && boundary & ((8u << level) - 1)) return 0;
    return bounds->emax <= boundary && (level == b->sub_level || bounds->xmax >> shift == *lit_slabs);
}

static void build_subs(void *user, size_t begin, size_t end, uint32_t worker)
{
    map_builder *b = user;
    (void)worker;
    for (size_t n = begin; n < end; n++) {
        sub_dag *s = &b->batch[n];
        s->result  = dag_build_square(&s->dag, b->fetched, b->sub_level, s->from_i, s->from_j, b->o, &s->stats);
    }
}

static void add_stats(build_stats *to, const build_stats *from)
{
    for (int n = 0; n < SQUARE_STAGES; n++) to->seconds[n] += from->seconds[n];
    to->mask_tiles += from->mask_tiles;
    to->mask_runs += from->mask_runs;
    to->inserted_nodes += from->inserted_nodes;
    to->inserted_masks += from->inserted_masks;
    to->squares_built += from->squares_built;
}

/* Build the squares that wait, and merge them in the order in which they came. */
static vxs_result build_batch(map_builder *b)
{
    build_stats batch = {0};
    vxs_result  r     = VXS_OK;
    if (!b->batch_count) return VXS_OK;
    stage_begin(b->ctx, STAGE_MASKS);
    parallel_for(b->ctx->threads, b->batch_count, 1, build_subs, b);
    for (uint32_t n = 0; n < b->batch_count; n++) add_stats(&batch, &b->batch[n].stats);
    add_stats(b->stats, &batch);
    stage_begin_after(b->ctx, STAGE_MERGE, STAGE_MASKS, batch.seconds, SQUARE_STAGES);
    for (uint32_t n = 0; n < b->batch_count; n++) {
        sub_dag *s = &b->batch[n];
        if (r == VXS_OK) r = s->result;
        if (r == VXS_OK) r = dag_merger_add(b->g, &s->dag, b->map, s->level, s->i, s->j);
        dag_free(&s->dag);
    }
    stage_begin(b->ctx, STAGE_NONE);
    b->batch_count = 0;
    return r;
}

static vxs_result visit(map_builder *b, uint32_t level, uint32_t i, uint32_t j);

static vxs_result visit_parts(map_builder *b, uint32_t level, uint32_t i, uint32_t j)
{
    vxs_result r = VXS_OK;
    for (uint32_t c = 0; c < 4 && r == VXS_OK; c++) r = visit(b, level - 1, 2 * i + (c & 1), 2 * j + (c >> 1));
    return r;
}

/* Let a sub-DAG be built for a square of the fetched columns. */
static vxs_result build_later(map_builder *b, uint32_t level, uint32_t i, uint32_t j)
{
    uint32_t down = level - b->sub_level, inner = b->fetched_level - level;
    uint32_t from_i = (i - (b->fetched_i << inner)) << down, from_j = (j - (b->fetched_j << inner)) << down;
    b->batch[b->batch_count++] = (sub_dag){.level = level, .i = i, .j = j, .from_i = from_i, .from_j = from_j};
    return b->batch_count < BATCH ? VXS_OK : build_batch(b);
}

/* Of the steps of progress, one for each square of fetch_px a side. */
static uint32_t steps_of(const map_builder *b, uint32_t level)
{
    uint32_t across = (8u << level) / b->columns->fetch_px;
    return across * across;
}

static vxs_result fetch(map_builder *b, uint32_t level, uint32_t i, uint32_t j)
{
    column_square square;
    vxs_result    r = b->columns->fetch(b->columns->data, level, i, j, &square, b->ctx);
    if (r != VXS_OK) return r;
    b->stats->squares_fetched++;
    b->fetched       = &square;
    b->fetched_level = level;
    b->fetched_i     = i;
    b->fetched_j     = j;
    r                = visit(b, level, i, j);
    if (r == VXS_OK) r = build_batch(b);
    b->fetched = NULL;
    b->columns->release(b->columns->data, &square);
    steps_done(b->ctx, steps_of(b, level));
    return r == VXS_OK ? context_within_memory(b->ctx) : r;
}

static vxs_result bounds_of(const map_builder *b, uint32_t level, uint32_t i, uint32_t j, column_bounds *out)
{
    if (!b->fetched) return b->columns->bounds(b->columns->data, level, i, j, out);
    uint32_t inner = b->fetched_level - level;
    return b->fetched->bounds(b->fetched->data, level, i - (b->fetched_i << inner), j - (b->fetched_j << inner), out);
}

/* The square (i, j) of `level` of the map, from the top down. */
static vxs_result visit(map_builder *b, uint32_t level, uint32_t i, uint32_t j)
{
    column_bounds bounds;
    uint32_t      lit_slabs;
    vxs_result    r = bounds_of(b, level, i, j, &bounds);
    if (r != VXS_OK) return r;
    if (is_decided(b, &bounds, level, &lit_slabs)) {
        if (!b->fetched) steps_done(b->ctx, steps_of(b, level));
        return dag_merger_add_split(b->g, b->map, level, i, j, b->sub_level, lit_slabs);
    }
    if (!b->fetched) return 8u << level <= b->columns->fetch_px ? fetch(b, level, i, j) : visit_parts(b, level, i, j);
    int alike = b->o->share && bounds_alike(&bounds);
    return level == b->sub_level || alike ? build_later(b, level, i, j) : visit_parts(b, level, i, j);
}

vxs_result dag_build_map(dag_merger *g, uint32_t map, const column_map *columns, const build_options *o, build_stats *stats,
                         bake_context *ctx)
{
    if (columns->fetch_px < sub_dag_side(columns->side_px)) return VXS_E_ARGUMENT;
    map_builder *b = calloc(1, sizeof *b);
    if (!b) return VXS_E_MEMORY;
    *b           = (map_builder){.g         = g,
                                 .columns   = columns,
                                 .o         = o,
                                 .stats     = stats,
                                 .ctx       = ctx,
                                 .map       = map,
                                 .sub_level = square_level(sub_dag_side(columns->side_px))};
    vxs_result r = visit(b, square_level(columns->side_px), 0, 0);
    for (uint32_t n = 0; n < b->batch_count; n++) dag_free(&b->batch[n].dag);
    free(b);
    return r;
}
