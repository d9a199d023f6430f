/* Builds DAGs from columns; see build.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/coding/dag/build.h"

#include <stdlib.h>
#include <string.h>

#include "baker/base/clock.h"
#include "baker/coding/dag/dag.h"
#include "baker/columns/descent.h"

uint32_t sub_dag_side(uint32_t map_side_px)
{
    return max_u32(8, min_u32(map_side_px / 4, SUB_DAG_MAX_PX));
}

/* one square ------------------------------------------------------------------------------------------------------------------ */

/* End a step of a square: add its time, and call `after`. */
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

/* A slot for a sub-DAG. */
typedef struct sub_dag {
    dag         dag;
    build_stats stats;
} sub_dag;

typedef struct map_builder {
    dag_merger          *g;
    const build_options *o;
    build_stats         *stats;
    uint32_t             map, sub_level, slabs;
    sub_dag              batch[DESCENT_SLOTS];
} map_builder;

/* Whether a square is decided: each of its sub-DAGs would have only lit and shadowed slabs, the same in all of them. A sub-DAG is
 * lit up to the last slab boundary that its own xmin allows. That xmin is between the xmin and the xmax of the larger square.
 * lit_slabs  [out] lit slabs, as deep as a sub-DAG is wide */
static int is_decided(const map_builder *b, const column_bounds *bounds, uint32_t level, uint32_t *lit_slabs)
{
    uint32_t shift = b->sub_level + 3, boundary = bounds->xmin >> shift << shift;
    *lit_slabs = boundary >> shift;
    /* a boundary within a slab of the square needs nodes, and unshared parts need nodes of their own */
    if (!b->o->share && boundary & ((8u << level) - 1)) return 0;
    return bounds->emax <= boundary && (level == b->sub_level || bounds->xmax >> shift == *lit_slabs);
}

static descent_step classify(const void *user, const column_bounds *bounds, uint32_t level, int fetched)
{
    const map_builder *b = user;
    uint32_t           lit_slabs;
    (void)fetched;
    if (is_decided(b, bounds, level, &lit_slabs)) return DESCENT_SETTLED;
    return level == b->sub_level || (b->o->share && bounds_alike(bounds)) ? DESCENT_BUILD : DESCENT_SPLIT;
}

static vxs_result settle(void *user, const column_bounds *bounds, uint32_t level, uint32_t i, uint32_t j)
{
    map_builder *b = user;
    uint32_t     lit_slabs;
    is_decided(b, bounds, level, &lit_slabs);
    return dag_merger_add_split(b->g, b->map, level, i, j, b->sub_level, lit_slabs);
}

static vxs_result build_slot(void *user, uint32_t slot, const column_square *columns, uint32_t level, uint32_t i, uint32_t j)
{
    map_builder *b    = user;
    sub_dag     *s    = &b->batch[slot];
    uint32_t     down = level - b->sub_level; /* if all columns are equal, one sub-DAG stands for a larger square */
    s->stats          = (build_stats){0};
    return dag_build_square(&s->dag, columns, b->sub_level, i << down, j << down, b->o, &s->stats);
}

static vxs_result add_slot(void *user, uint32_t slot, uint32_t level, uint32_t i, uint32_t j)
{
    map_builder *b = user;
    vxs_result   r = dag_merger_add(b->g, &b->batch[slot].dag, b->map, level, i, j);
    dag_free(&b->batch[slot].dag);
    return r;
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

enum { STAT_COUNT = 5 };

/* The counts of a square that are saved with it. */
static void stats_of(build_stats *s, uint64_t *of[STAT_COUNT])
{
    of[0] = &s->mask_tiles;
    of[1] = &s->mask_runs;
    of[2] = &s->inserted_nodes;
    of[3] = &s->inserted_masks;
    of[4] = &s->squares_built;
}

/* A sub-DAG as bytes: counts, 8 bytes each; number of roots, roots, 4 bytes each; then dag.h. */
static vxs_result save_slot(void *user, uint32_t slot, vxs_bytes *out)
{
    map_builder *b  = user;
    sub_dag     *s  = &b->batch[slot];
    int          ok = 1;
    uint64_t    *of[STAT_COUNT];
    stats_of(&s->stats, of);
    for (int n = 0; n < STAT_COUNT && ok; n++) ok = put64(out, *of[n]);
    ok = ok && put32(out, s->dag.root_count) && put32s(out, s->dag.roots, s->dag.root_count) && dag_put(&s->dag, out);
    return ok ? VXS_OK : VXS_E_MEMORY;
}

static vxs_result take_roots(dag *d, byte_reader *from, uint32_t count)
{
    if (!has(from, (uint64_t)count + 1, 4) || take32(from) != count) return VXS_E_CORRUPT;
    if (!(d->roots = malloc(count * sizeof *d->roots))) return VXS_E_MEMORY;
    take32s(from, d->roots, count);
    d->root_count = count;
    return VXS_OK;
}

static vxs_result load_slot(void *user, uint32_t slot, const vxs_bytes *bytes, uint32_t level, uint32_t i, uint32_t j)
{
    map_builder *b    = user;
    sub_dag     *s    = &b->batch[slot];
    byte_reader  from = {bytes->data, bytes->size_bytes};
    uint64_t    *of[STAT_COUNT];
    (void)i;
    (void)j;
    s->stats = (build_stats){0};
    s->dag   = (dag){.level_count = b->sub_level + 1};
    if (level < b->sub_level || !has(&from, STAT_COUNT, 8)) return VXS_E_CORRUPT;
    stats_of(&s->stats, of);
    for (int n = 0; n < STAT_COUNT; n++) *of[n] = take64(&from);
    vxs_result r = take_roots(&s->dag, &from, b->slabs);
    if (r == VXS_OK) r = dag_take(&s->dag, &from);
    const dag_level *top = &s->dag.level[b->sub_level];
    for (uint32_t n = 0; n < s->dag.root_count && r == VXS_OK; n++)
        if (s->dag.roots[n] >= REF_FIRST && s->dag.roots[n] - REF_FIRST >= top->count) r = VXS_E_CORRUPT;
    return r == VXS_OK && from.left ? VXS_E_CORRUPT : r;
}

static void drop_slot(void *user, uint32_t slot)
{
    map_builder *b       = user;
    b->batch[slot].stats = (build_stats){0};
    dag_free(&b->batch[slot].dag);
}

/* The stages of a square run in turn on all threads. */
static void time_batch(void *user, bake_context *ctx, int phase, uint32_t count, const double seconds[2])
{
    map_builder *b     = user;
    build_stats  batch = {0};
    for (uint32_t n = 0; n < count && phase == 1; n++) {
        add_stats(&batch, &b->batch[n].stats);
        b->batch[n].stats = (build_stats){0};
    }
    if (phase == 0) stage_begin(ctx, STAGE_MASKS);
    if (phase == 1) {
        double all[2 + SQUARE_STAGES] = {seconds[0], 0}; /* [0] is the time of fetches */
        memcpy(all + 2, batch.seconds, sizeof batch.seconds);
        stage_begin_after(ctx, STAGE_MERGE, STAGE_MAPS, all, 2 + SQUARE_STAGES);
    }
    if (phase == 2) stage_begin(ctx, STAGE_NONE);
    add_stats(b->stats, &batch);
}

vxs_result dag_build_map(dag_merger *g, uint32_t map, const column_map *columns, const build_options *o, build_stats *stats,
                         bake_context *ctx)
{
    if (columns->fetch_px < sub_dag_side(columns->side_px)) return VXS_E_ARGUMENT;
    map_builder *b = calloc(1, sizeof *b);
    if (!b) return VXS_E_MEMORY;
    *b           = (map_builder){.g         = g,
                                 .o         = o,
                                 .stats     = stats,
                                 .map       = map,
                                 .sub_level = square_level(sub_dag_side(columns->side_px)),
                                 .slabs     = columns->depth_vx / sub_dag_side(columns->side_px)};
    descent    d = {.user            = b,
                    .square_px       = sub_dag_side(columns->side_px),
                    .squares_fetched = &stats->squares_fetched,
                    .classify        = classify,
                    .settle          = settle,
                    .build           = build_slot,
                    .add             = add_slot,
                    .save            = save_slot,
                    .load            = load_slot,
                    .drop            = drop_slot,
                    .batch           = time_batch};
    vxs_result r = descend(&d, columns, ctx);
    for (uint32_t n = 0; n < DESCENT_SLOTS; n++) dag_free(&b->batch[n].dag);
    free(b);
    return r;
}
