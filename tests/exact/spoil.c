/* Building a DAG with something spoilt; see spoil.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "tests/exact/spoil.h"

#include "baker/bake/bake.h"
#include "baker/bake/map_sample.h"
#include "baker/base/random.h"

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

/* The tiles of a sub-DAG in turn, from a random one on, until one of them can be spoilt. */
static int spoil_some_tile(tile_masks *t, const column_source *source, uint32_t i, uint32_t j, rng *random,
                           int (*spoil)(tile_masks *t, uint32_t tile, const column_tile *columns))
{
    uint32_t tiles = t->side_tiles * t->side_tiles;
    uint32_t at    = rng_below(random, tiles);
    for (uint32_t n = 0; n < tiles; n++, at = (at + 1) % tiles) {
        column_tile columns;
        source->tile(source->data, i + at % t->side_tiles, j + at / t->side_tiles, &columns);
        if (t->first[at] < t->first[at + 1] && spoil(t, at, &columns)) return 1;
    }
    return 0;
}

/* A tile's first run starts at xmin: a texel with that exit depth has to be dark in it. */
static int spoil_mask(tile_masks *t, uint32_t tile, const column_tile *columns)
{
    uint32_t texel = 0;
    while (columns->x[texel] != t->xmin[tile]) texel++;
    t->mask[t->first[tile]] &= ~((uint64_t)1 << texel);
    return 1;
}

/* The first run goes on to where a texel that it leaves lit has to be dark. */
static int spoil_until(tile_masks *t, uint32_t tile, const column_tile *columns)
{
    uint32_t run = t->first[tile], x = t->emax[tile];
    for (uint32_t n = 0; n < 64; n++)
        if (!(t->mask[run] >> n & 1) && columns->x[n] < x) x = columns->x[n];
    if (x == t->emax[tile]) return 0;
    t->until[run] = x + 1;
    return 1;
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

/* One sub-DAG as bake.c makes it; *left counts the faults still to be planted. */
static vxs_result build_sub(const spoil_desc *s, const column_source *source, uint32_t sub_px, uint32_t i, uint32_t j,
                            dag_merger *merger, int *left, rng *random)
{
    tile_masks masks = {0};
    dag        d     = {0};
    uint32_t   tiles = sub_px / 8, levels = 1;
    vxs_result r;
    while (8u << (levels - 1) < sub_px) levels++;

    if ((r = tile_masks_build(&masks, source, i * tiles, j * tiles, tiles, s->bake->rule)) != VXS_OK) goto done;
    if (*left && s->planted == FAULT_MASK) *left -= spoil_some_tile(&masks, source, i * tiles, j * tiles, random, spoil_mask);
    if (*left && s->planted == FAULT_UNTIL) *left -= spoil_some_tile(&masks, source, i * tiles, j * tiles, random, spoil_until);
    if ((r = dag_insert(&d, source, i, j, levels, &masks, s->bake->reuse)) != VXS_OK) goto done;
    uint32_t level = rng_below(random, levels);
    if (*left && s->planted == FAULT_INSERTED) *left -= spoil_node(&d, level, random);
    if (s->bake->stop != STOP_INSERT &&
        (r = dag_compress(&d, s->bake->compress == COMPRESS_CHOICE_BOTTOM_UP ? COMPRESS_BOTTOM_UP : COMPRESS_TOP_DOWN)) != VXS_OK)
        goto done;
    if (*left && s->planted == FAULT_COMPRESSED) *left -= spoil_node(&d, level, random);
    r = dag_merger_add(merger, &d, 0, i, j);
done:
    tile_masks_free(&masks);
    dag_free(&d);
    return r;
}

vxs_result spoilt_dag(const spoil_desc *s, dag *out, message *m)
{
    rng             random   = rng_split(s->seed, 1);
    depth_renderer *renderer = NULL;
    dag_merger     *merger   = NULL;
    depth_maps      maps     = {0};
    vxs_result      r;
    uint32_t        side = 1u << s->light->levels, sub = side / 4 < SUB_DAG_MAX_PX ? side / 4 : SUB_DAG_MAX_PX;
    int             faults = s->planted != FAULT_STAGES && s->planted != FAULT_WORD;

    if ((r = depth_renderer_create(&renderer, s->gl, s->casters, s->light, 0, s->bake->exit, s->bake->threads, m)) != VXS_OK)
        goto done;
    if ((r = depth_maps_init(&maps, side, side, 0, s->casters->solid_triangle_count != 0, m)) != VXS_OK) goto done;
    if ((r = dag_merger_create(&merger, side, sub, 1, s->bake->stop == STOP_FINAL)) != VXS_OK) goto done;
    if ((r = depth_renderer_tile(renderer, &maps, 0, 0, m)) != VXS_OK) goto done;
    if (s->planted == FAULT_DEPTH) spoil_depth(&maps, &random);
    depth_maps_reduce(&maps, s->bake->threads);
    if (s->planted == FAULT_TILE) spoil_tile(&maps, &random);
    if (s->planted == FAULT_SQUARE) spoil_square(&maps, &random);

    column_source source = depth_maps_columns(&maps);
    uint32_t      count = (side / sub) * (side / sub), first = rng_below(&random, count);
    for (uint32_t n = 0; n < count && r == VXS_OK; n++) {
        uint32_t at = (first + n) % count;
        r           = build_sub(s, &source, sub, at % (side / sub), at / (side / sub), merger, &faults, &random);
    }
    if (r == VXS_OK) r = dag_merger_finish(merger, out);
    if (r == VXS_OK && s->planted == FAULT_MERGED) spoil_node(out, out->level_count - 1, &random);
done:
    dag_merger_destroy(merger);
    depth_maps_free(&maps);
    depth_renderer_destroy(renderer);
    return r;
}
