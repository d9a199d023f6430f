/* Building a DAG with something spoilt; see spoil.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "tests/exact/spoil.h"

#include "baker/base/random.h"
#include "baker/coding/dag/build.h"
#include "tests/columns/stored_maps.h"

static void spoil_depth(depth_maps *maps, rng *random)
{
    size_t texels = (size_t)maps->side_px * maps->side_px;
    size_t at     = rng_below(random, (uint32_t)texels);
    while (maps->exit[at] >= 1 - 1.0f / (float)maps->depth_vx) at = (at + 1) % texels;
    maps->enter[at] = maps->exit[at] = 1;
}

static void spoil_tile(depth_maps *maps, rng *random)
{
    size_t tiles = (size_t)(maps->side_px / 8) * (maps->side_px / 8);
    size_t at    = rng_below(random, (uint32_t)tiles);
    while (maps->pyramid[0][at].emax <= maps->pyramid[0][at].xmin) at = (at + 1) % tiles;
    maps->pyramid[0][at].emax = maps->pyramid[0][at].xmin;
}

/* The square nearest the light of a larger one that is looked into: there it must be dark somewhere. */
static void spoil_square(depth_maps *maps, rng *random)
{
    uint32_t level = 1 + rng_below(random, maps->pyramid_levels - 3);
    uint32_t side  = maps->side_px >> (3 + level);
    for (size_t at = rng_below(random, side * side);; at = (at + 1) % ((size_t)side * side)) {
        column_bounds *square = &maps->pyramid[level][at];
        column_bounds *parent = &maps->pyramid[level + 1][at / side / 2 * (side / 2) + at % side / 2];
        if (square->xmin != parent->xmin || parent->emax <= parent->xmin) continue;
        square->xmin = square->emax = maps->depth_vx;
        return;
    }
}

/* A tile's first run starts at its nearest exit depth: a texel with that exit depth has to be dark in it. */
static int spoil_mask(column_tree *t, const tree_tile *tile, const column_tile *columns)
{
    uint32_t nearest = 0;
    for (uint32_t n = 1; n < 64; n++)
        if (columns->x[n] < columns->x[nearest]) nearest = n;
    t->runs[tile->first].mask &= ~((uint64_t)1 << nearest);
    return 1;
}

/* The first run goes on to where a texel that it leaves lit has to be dark. */
static int spoil_until(column_tree *t, const tree_tile *tile, const column_tile *columns)
{
    mask_run *run = &t->runs[tile->first];
    uint32_t  end = t->runs[tile->end - 1].until, x = end;
    for (uint32_t n = 0; n < 64; n++)
        if (!(run->mask >> n & 1) && columns->x[n] < x) x = columns->x[n];
    if (x == end) return 0;
    run->until = x + 1;
    return 1;
}

/* The tiles of a square in turn, from a random one on, until one of them can be spoilt. */
static int spoil_some_tile(column_tree *t, rng *random,
                           int (*spoil)(column_tree *t, const tree_tile *tile, const column_tile *columns))
{
    size_t at = t->tile_count ? rng_below(random, (uint32_t)t->tile_count) : 0;
    for (size_t n = 0; n < t->tile_count; n++, at = (at + 1) % t->tile_count) {
        column_tile columns;
        if (t->columns->tile(t->columns->data, t->tiles[at].x, t->tiles[at].y, &columns) == VXS_OK &&
            spoil(t, &t->tiles[at], &columns))
            return 1;
    }
    return 0;
}

/* A child that is a node or a mask has voxels that must be dark: else it would have been lit. */
static int spoil_node(dag *d, uint32_t level, rng *random)
{
    dag_level *l = &d->level[level];
    if (!l->count) return 0;
    for (uint32_t at = rng_below(random, l->count * 8);; at = (at + 1) % (l->count * 8)) {
        uint32_t *child = &l->nodes[at / 8].child[at % 8];
        if (*child < REF_FIRST) continue;
        *child = REF_LIT;
        return 1;
    }
}

/* A fault, and the square that it is planted in while that is built. */
typedef struct spoiler {
    fault    planted;
    uint64_t skip; /* squares that are passed over before one is spoilt */
    int      left; /* faults still to be planted */
    rng      random;
} spoiler;

static vxs_result spoil_square_dag(void *user, bake_stage stage, column_tree *tree, dag *d)
{
    spoiler *s = user;
    if (stage == STAGE_MASKS && s->skip) s->skip--;
    if (!s->left || s->skip) return VXS_OK;
    uint32_t level = d->level_count ? rng_below(&s->random, d->level_count) : 0;
    if (stage == STAGE_MASKS && s->planted == FAULT_MASK) s->left -= spoil_some_tile(tree, &s->random, spoil_mask);
    if (stage == STAGE_MASKS && s->planted == FAULT_UNTIL) s->left -= spoil_some_tile(tree, &s->random, spoil_until);
    if (stage == STAGE_INSERT && s->planted == FAULT_INSERTED) s->left -= spoil_node(d, level, &s->random);
    if (stage == STAGE_COMPRESS && s->planted == FAULT_COMPRESSED) s->left -= spoil_node(d, level, &s->random);
    return VXS_OK;
}

/* The DAG of the maps, as bake() builds it, with what the spoiler does; on one thread, so that it spoils one square at a time. */
static vxs_result build_dag(const bake_options *bake, const depth_maps *maps, spoiler *s, dag *out, build_stats *stats,
                            run_context *m)
{
    build_options o       = build_options_of(bake, compress_order_of(bake->compress));
    bake_context  ctx     = {.run = m, .threads = 1};
    column_map    columns = stored_map(maps);
    dag_merger    merger;
    o.after      = spoil_square_dag;
    o.user       = s;
    vxs_result r = dag_merger_init(&merger, maps->side_px, 1, bake->stop == STOP_FINAL);
    if (r == VXS_OK) r = dag_build_map(&merger, 0, &columns, &o, stats, &ctx);
    if (r == VXS_OK) r = dag_merger_finish(&merger, out);
    dag_merger_free(&merger);
    return r;
}

/* With a fault in some square: a random one, or where those from there on cannot be spoilt, the first that can. */
static vxs_result build_spoilt(const spoil_desc *s, const depth_maps *maps, rng *random, dag *out, run_context *m)
{
    int         in_square = s->planted >= FAULT_MASK && s->planted <= FAULT_COMPRESSED;
    build_stats stats     = {0};
    spoiler     none = {.planted = FAULT_NONE}, some = {.planted = s->planted, .left = in_square, .random = *random};
    vxs_result  r = build_dag(s->bake, maps, &none, out, &stats, m);
    if (r != VXS_OK || !in_square) return r;
    dag_free(out);
    some.skip = stats.squares_built ? 1 + rng_below(random, (uint32_t)stats.squares_built) : 0;
    if ((r = build_dag(s->bake, maps, &some, out, &stats, m)) != VXS_OK || !some.left) return r;
    dag_free(out);
    some.skip = 0;
    return build_dag(s->bake, maps, &some, out, &stats, m);
}

vxs_result spoilt_dag(const spoil_desc *s, dag *out, run_context *m)
{
    rng             random   = rng_split(s->seed, 1);
    depth_renderer *renderer = NULL;
    depth_maps      maps     = {0};
    vxs_result      r;
    uint32_t        side = 1u << s->light->levels;

    if ((r = depth_renderer_create(&renderer, s->gl, s->casters, s->light, 0, s->bake->exit, s->bake->threads, m)) != VXS_OK)
        goto done;
    if ((r = depth_maps_init(&maps, side, side, 0, s->casters->solid_triangle_count != 0, m)) != VXS_OK) goto done;
    if ((r = depth_renderer_tile(renderer, &maps, 0, 0, m)) != VXS_OK) goto done;
    if (s->planted == FAULT_DEPTH) spoil_depth(&maps, &random);
    depth_maps_reduce(&maps, s->bake->threads);
    if (s->planted == FAULT_TILE) spoil_tile(&maps, &random);
    if (s->planted == FAULT_SQUARE) spoil_square(&maps, &random);
    if ((r = build_spoilt(s, &maps, &random, out, m)) != VXS_OK) goto done;
    if (s->planted == FAULT_MERGED) spoil_node(out, out->level_count - 1, &random);
done:
    depth_maps_free(&maps);
    depth_renderer_destroy(renderer);
    return r;
}
