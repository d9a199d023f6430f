/* Palette blocks of a whole map; see blocks.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <stdlib.h>
#include <string.h>

#include "baker/base/byte_stream.h"
#include "baker/base/cpu.h"
#include "baker/base/run_control.h"
#include "baker/base/z_order.h"
#include "baker/coding/blocks/blocks.h"
#include "baker/columns/descent.h"

/* The square of a map that must contain a set. */
typedef struct block_area {
    uint32_t map, depth_vx;
    uint32_t x, y, side; /* in squares of NODE_PX */
} block_area;

/* Sets of palette blocks as bytes for the square cache, before they are merged. A loaded set merges like the saved one. The bytes
 * belong to one version of vxs, and are not a public format. All numbers are little-endian, of 4 bytes unless noted.
 *
 *     head       counts of uniform squares, nodes, blocks, private-palette patterns, patterns of 2 to PALETTE_MAX depths; 8
 *                bytes: tiles
 *     uniform    level, x, y, depth
 *     nodes      x, y, emin, xmax, slope (2); 8 bytes: which blocks are mixed; 64 depths; ids of mixed blocks
 *     patterns   of each class: id; 16 bytes for each mask: dark, lit
 *     privates   64 depths; ranges (128); count of halves of planes, then these halves, 4 bytes each
 *     blocks     number of depths, plane (3), depths, and of each tile kind | palette << 16, pattern, base */

enum {
    CLASSES       = PALETTE_MAX - 1,
    HEAD_BYTES    = 4 * (4 + CLASSES) + 8,
    UNIFORM_BYTES = 16,
    NODE_BYTES    = 32 + 4 * NODE_BLOCKS, /* without mixed blocks */
    PRIVATE_BYTES = 4 * (64 + 128 + 1),   /* without planes */
    TILE_BYTES    = 12,
    BLOCK_BYTES   = 4 * 4 + TILE_BYTES * BLOCK_TILES, /* without depths */
    DEPTH_LIMIT   = 1 << 24,                          /* limit of depths and bases: their sums do not overflow */
    PLANE_LIMIT   = 1 << 30
};

/* saving ---------------------------------------------------------------------------------------------------------------------- */

static int put_signed(vxs_bytes *out, const int32_t *values, size_t count)
{
    int ok = 1;
    for (size_t n = 0; n < count && ok; n++) ok = put32(out, (uint32_t)values[n]);
    return ok;
}

/* Depths of all blocks of a node. */
static void node_depths(const block_set *s, const packed_node *n, int32_t depth[NODE_BLOCKS])
{
    const uint32_t *mixed = node_parts(s, n) + n->mixed_count, *fresh = mixed + n->mixed_count, *last = fresh;
    for (int b = 0; b < NODE_BLOCKS; b++) {
        if (n->fresh >> b & 1) last = fresh++;
        depth[b] = (int32_t) * (n->mixed >> b & 1 ? mixed++ : last);
    }
}

/* loading --------------------------------------------------------------------------------------------------------------------- */

typedef struct set_loader {
    byte_reader       from;
    block_set        *s;
    const block_area *area;
    uint32_t          blocks, privates, patterns, of_class[PALETTE_MAX + 1];
    uint8_t          *depths_of; /* [patterns] number of depths by id; 0: id not met yet */
} set_loader;

static int within(int32_t value, int32_t least, int32_t most)
{
    return value >= least && value <= most;
}

static int all_within(const int32_t *values, size_t count, int32_t least, int32_t most)
{
    int ok = 1;
    for (size_t n = 0; n < count; n++) ok &= within(values[n], least, most);
    return ok;
}

static void take_signed(byte_reader *r, int32_t *values, size_t count)
{
    for (size_t n = 0; n < count; n++) values[n] = (int32_t)take32(r);
}

/* Whether a square of `side` nodes is in the area. */
static int in_area(const block_area *a, uint32_t x, uint32_t y, uint32_t side)
{
    return side <= a->side && x >= a->x && y >= a->y && x - a->x <= a->side - side && y - a->y <= a->side - side;
}

static vxs_result take_uniform(set_loader *l)
{
    if (!has(&l->from, 1, UNIFORM_BYTES)) return VXS_E_CORRUPT;
    uniform_square u     = {.map = l->area->map, .level = take32(&l->from)};
    uint32_t       least = square_level(NODE_PX);
    u.x                  = take32(&l->from);
    u.y                  = take32(&l->from);
    u.depth              = take32(&l->from);
    if (u.level < least || u.level > least + 10 || u.depth > l->area->depth_vx) return VXS_E_CORRUPT;
    uint32_t side = 1u << (u.level - least);
    if (u.x > UINT32_MAX / side || u.y > UINT32_MAX / side) return VXS_E_CORRUPT;
    return in_area(l->area, u.x * side, u.y * side, side) ? block_set_add_uniform(l->s, &u) : VXS_E_CORRUPT;
}

static vxs_result take_node(set_loader *l)
{
    block_node n;
    uint32_t   head[6];
    memset(&n, 0, sizeof n);
    if (!has(&l->from, 1, NODE_BYTES)) return VXS_E_CORRUPT;
    take32s(&l->from, head, 6);
    n.map   = l->area->map;
    n.x     = head[0];
    n.y     = head[1];
    n.emin  = head[2];
    n.xmax  = head[3];
    n.slope = (node_slope){(int32_t)head[4], (int32_t)head[5]};
    n.mixed = take64(&l->from);
    take_signed(&l->from, n.depth, NODE_BLOCKS);
    if (!has(&l->from, (uint64_t)__builtin_popcountll(n.mixed), 4)) return VXS_E_CORRUPT;
    for (int b = 0; b < NODE_BLOCKS; b++)
        if (n.mixed >> b & 1 && (n.block[b] = take32(&l->from)) >= l->blocks) return VXS_E_CORRUPT;
    if (!in_area(l->area, n.x, n.y, 1) || n.emin > l->area->depth_vx || n.xmax > l->area->depth_vx) return VXS_E_CORRUPT;
    if (!within(n.slope.x, -SLOPE_MAX, SLOPE_MAX) || !within(n.slope.y, -SLOPE_MAX, SLOPE_MAX)) return VXS_E_CORRUPT;
    return all_within(n.depth, NODE_BLOCKS, 0, DEPTH_LIMIT) ? block_set_add_node(l->s, &n) : VXS_E_CORRUPT;
}

static vxs_result take_class(set_loader *l, int depths)
{
    mask_need  needs[PALETTE_MAX - 1];
    vxs_result r = VXS_OK;
    if (!has(&l->from, l->of_class[depths], 4 + 16 * (uint64_t)(depths - 1))) return VXS_E_CORRUPT;
    for (uint32_t n = 0; n < l->of_class[depths] && r == VXS_OK; n++) {
        uint32_t id = take32(&l->from), contradicts = 0;
        if (id >= l->patterns || l->depths_of[id]) return VXS_E_CORRUPT;
        l->depths_of[id] = (uint8_t)depths;
        for (int mask = 0; mask < depths - 1; mask++) {
            needs[mask].dark = take64(&l->from);
            needs[mask].lit  = take64(&l->from);
            contradicts |= (needs[mask].dark & needs[mask].lit) != 0;
        }
        r = contradicts ? VXS_E_CORRUPT : pattern_put(&l->s->patterns, depths, needs, id);
    }
    return r;
}

static vxs_result take_private(set_loader *l)
{
    if (!has(&l->from, 1, PRIVATE_BYTES)) return VXS_E_CORRUPT;
    private_pattern *p = &l->s->privates.patterns[l->s->privates.count];
    memset(p, 0, sizeof *p);
    take_signed(&l->from, p->depth, 64);
    take_signed(&l->from, p->may.low, 64);
    take_signed(&l->from, p->may.high, 64);
    p->plane_halves = take32(&l->from);
    if (p->plane_halves > PRIVATE_PLANES_HALVES_MAX || !has(&l->from, p->plane_halves, 4)) return VXS_E_CORRUPT;
    for (uint32_t n = 0; n < p->plane_halves; n++) p->planes[n] = (uint16_t)take32(&l->from);
    if (p->plane_halves && !private_planes_are_sound(p->planes, p->plane_halves)) return VXS_E_CORRUPT;
    if (!all_within(p->depth, 64, 0, DEPTH_LIMIT - 1) || !all_within(p->may.low, 64, -DEPTH_LIMIT, DEPTH_LIMIT) ||
        !all_within(p->may.high, 64, -DEPTH_LIMIT, DEPTH_LIMIT))
        return VXS_E_CORRUPT;
    for (int n = 0; n < 64; n++)
        if (p->may.low[n] > p->depth[n] || p->may.high[n] < p->depth[n]) return VXS_E_CORRUPT;
    l->s->privates.count++;
    return VXS_OK;
}

static int is_sound_tile(const set_loader *l, const block_tile *t, uint32_t depths)
{
    switch (t->kind) {
    case TILE_UNIFORM: return t->palette < depths && !t->pattern && !t->base;
    case TILE_PATTERN:
        return !(t->palette >> depths) && !t->base && t->pattern < l->patterns &&
               l->depths_of[t->pattern] == __builtin_popcount(t->palette);
    case TILE_PRIVATE: return !t->palette && t->pattern < l->privates && within(t->base, -DEPTH_LIMIT, DEPTH_LIMIT);
    case TILE_PLANE: return !t->palette && !t->pattern && !t->base;
    }
    return 0;
}

static vxs_result take_block(set_loader *l)
{
    block    b;
    int32_t  slopes[3], slope_most = INT16_MAX << PLANE_SHIFT_MAX;
    uint32_t number;
    memset(&b, 0, sizeof b);
    if (!has(&l->from, 1, BLOCK_BYTES)) return VXS_E_CORRUPT;
    b.depths = take32(&l->from);
    if (b.depths < 1 || b.depths > PALETTE_MAX || !has(&l->from, 1, BLOCK_BYTES - 4 + 4 * (uint64_t)b.depths)) return VXS_E_CORRUPT;
    take_signed(&l->from, b.depth, b.depths);
    take_signed(&l->from, slopes, 3);
    b.plane = (plane){slopes[0], slopes[1], slopes[2]};
    if (b.depth[0] || !all_within(slopes, 2, -slope_most, slope_most) || !within(slopes[2], -PLANE_LIMIT, PLANE_LIMIT))
        return VXS_E_CORRUPT;
    for (uint32_t n = 1; n < b.depths; n++)
        if (b.depth[n] <= b.depth[n - 1] || b.depth[n] > DEPTH_LIMIT) return VXS_E_CORRUPT;
    for (block_tile *t = b.tile; t < b.tile + BLOCK_TILES; t++) {
        uint32_t kind = take32(&l->from);
        t->kind       = (uint16_t)kind;
        t->palette    = (uint16_t)(kind >> 16);
        t->pattern    = take32(&l->from);
        t->base       = (int32_t)take32(&l->from);
        if (!is_sound_tile(l, t, b.depths)) return VXS_E_CORRUPT;
    }
    vxs_result r = block_set_find(l->s, &b, &number);
    return r == VXS_OK && number + 1 != l->s->blocks.count ? VXS_E_CORRUPT : r; /* two blocks are equal */
}

/* Read a set from all of the bytes. Checks any input: all references are in range, and all squares are in the area.
 * s  [out] zero it first; released with block_set_free, whatever is returned
 * Returns VXS_OK, VXS_E_MEMORY, VXS_E_CORRUPT. */
static vxs_result block_set_load(block_set *s, const void *bytes, size_t size_bytes, const block_area *area)
{
    set_loader l   = {.from = {bytes, size_bytes}, .s = s, .area = area};
    uint64_t   all = 0;
    if (!has(&l.from, 1, HEAD_BYTES)) return VXS_E_CORRUPT;
    uint32_t uniforms = take32(&l.from), nodes = take32(&l.from);
    l.blocks   = take32(&l.from);
    l.privates = take32(&l.from);
    for (int depths = 2; depths <= PALETTE_MAX; depths++) all += l.of_class[depths] = take32(&l.from);
    s->tile_count = take64(&l.from);
    if (all > size_bytes) return VXS_E_CORRUPT;
    l.patterns = (uint32_t)all;
    if (!(l.depths_of = calloc(all + 1, 1))) return VXS_E_MEMORY;

    /* counts are checked against the remaining bytes before memory is allocated */
    private_set *p = &s->privates;
    vxs_result   r = VXS_OK;
    for (uint32_t n = 0; n < uniforms && r == VXS_OK; n++) r = take_uniform(&l);
    for (uint32_t n = 0; n < nodes && r == VXS_OK; n++) r = take_node(&l);
    for (int depths = 2; depths <= PALETTE_MAX && r == VXS_OK; depths++) r = take_class(&l, depths);
    if (r == VXS_OK && !has(&l.from, l.privates, PRIVATE_BYTES)) r = VXS_E_CORRUPT;
    if (r == VXS_OK && !array_reserve(&p->patterns, &p->pattern_capacity, l.privates, sizeof *p->patterns)) r = VXS_E_MEMORY;
    for (uint32_t n = 0; n < l.privates && r == VXS_OK; n++) r = take_private(&l);
    for (uint32_t n = 0; n < l.blocks && r == VXS_OK; n++) r = take_block(&l);
    free(l.depths_of);
    return r == VXS_OK && l.from.left ? VXS_E_CORRUPT : r;
}

enum { SQUARE_PX_MAX = 1024 };

uint32_t block_square_side(uint32_t map_side_px)
{
    return min_u32(map_side_px, max_u32(NODE_PX, min_u32(map_side_px / 4, SQUARE_PX_MAX)));
}

typedef struct map_builder {
    block_set          *set;
    const bake_context *ctx;
    uint32_t            map, square_level, depth_vx;
    int                 cpu;
    block_set           batch[DESCENT_SLOTS];
} map_builder;

/* Before a fetch, a square is settled only if every part of it would get the same depth: bounds may be tighter after the fetch. */
static descent_step classify(const void *user, const column_bounds *bounds, uint32_t level, int fetched)
{
    const map_builder *b = user;
    if (!fetched && (bounds->xmin >= b->depth_vx || bounds_alike(bounds))) return DESCENT_SETTLED;
    return level == b->square_level ? DESCENT_BUILD : DESCENT_SPLIT;
}

static vxs_result settle(void *user, const column_bounds *bounds, uint32_t level, uint32_t i, uint32_t j)
{
    map_builder *b = user;
    return block_set_add_uniform(b->set, &(uniform_square){b->map, level, i, j, uniform_depth(bounds, b->depth_vx)});
}

static vxs_result build_slot(void *user, uint32_t slot, const column_square *columns, uint32_t level, uint32_t i, uint32_t j)
{
    map_builder *b     = user;
    uint32_t     nodes = max_u32((8u << level) / NODE_PX, 1);
    vxs_result   r     = VXS_OK;
    b->batch[slot]     = (block_set){.patterns.cpu = b->cpu, .privates.cpu = b->cpu, .fast = b->set->fast};
    for (uint32_t n = 0; n < nodes * nodes && r == VXS_OK; n++) {
        z_place at = z_order(n);
        run_control_wait();
        if (!context_has_memory(b->ctx)) return VXS_E_MEMORY; /* nodes of a dense square take megabytes */
        r = block_build_node(&b->batch[slot], columns, b->map, i * nodes + at.i, j * nodes + at.j);
    }
    return r;
}

static vxs_result add_slot(void *user, uint32_t slot, uint32_t level, uint32_t i, uint32_t j)
{
    map_builder *b = user;
    (void)level;
    (void)i;
    (void)j;
    return block_set_merge(b->set, &b->batch[slot]);
}

static vxs_result save_slot(void *user, uint32_t slot, vxs_bytes *out)
{
    const block_set *s = &((map_builder *)user)->batch[slot];

    int ok = put32(out, (uint32_t)s->uniform_count) && put32(out, (uint32_t)s->node_count) &&
             put32(out, (uint32_t)s->blocks.count) && put32(out, (uint32_t)s->privates.count);
    for (int depths = 2; depths <= PALETTE_MAX && ok; depths++) ok = put32(out, (uint32_t)s->patterns.by_depths[depths].count);
    ok = ok && put64(out, s->tile_count);
    for (const uniform_square *u = s->uniform; u < s->uniform + s->uniform_count && ok; u++)
        ok = put32s(out, (uint32_t[]){u->level, u->x, u->y, u->depth}, 4);
    for (const packed_node *n = s->nodes; n < s->nodes + s->node_count && ok; n++) {
        uint32_t head[] = {n->x, n->y, n->emin, n->xmax, (uint32_t)n->slope.x, (uint32_t)n->slope.y};
        int32_t  depth[NODE_BLOCKS];
        node_depths(s, n, depth);
        ok = put32s(out, head, 6) && put64(out, n->mixed) && put_signed(out, depth, NODE_BLOCKS) &&
             put32s(out, node_parts(s, n), n->mixed_count);
    }
    for (int depths = 2; depths <= PALETTE_MAX && ok; depths++) {
        const pattern_class *c = &s->patterns.by_depths[depths];
        for (size_t n = 0; n < c->count && ok; n++) {
            mask_need needs[PALETTE_MAX - 1];
            pattern_needs(&s->patterns, depths, n, needs);
            ok = put32(out, c->ids[n]);
            for (int mask = 0; mask < depths - 1 && ok; mask++) ok = put64(out, needs[mask].dark) && put64(out, needs[mask].lit);
        }
    }
    for (const private_pattern *p = s->privates.patterns; p < s->privates.patterns + s->privates.count && ok; p++) {
        ok = put_signed(out, p->depth, 64) && put_signed(out, p->may.low, 64) && put_signed(out, p->may.high, 64) &&
             put32(out, p->plane_halves);
        for (uint32_t n = 0; n < p->plane_halves && ok; n++) ok = put32(out, p->planes[n]);
    }
    for (uint32_t n = 0; n < s->blocks.count && ok; n++) {
        const block b = block_at(s, n);

        int32_t slopes[] = {b.plane.across, b.plane.down, b.plane.least};
        ok               = put32(out, b.depths) && put_signed(out, b.depth, b.depths) && put_signed(out, slopes, 3);
        for (const block_tile *t = b.tile; t < b.tile + BLOCK_TILES && ok; t++)
            ok = put32(out, t->kind | (uint32_t)t->palette << 16) && put32(out, t->pattern) && put32(out, (uint32_t)t->base);
    }
    return ok ? VXS_OK : VXS_E_MEMORY;
}

static vxs_result load_slot(void *user, uint32_t slot, const vxs_bytes *bytes, uint32_t level, uint32_t i, uint32_t j)
{
    map_builder *b    = user;
    uint32_t     side = max_u32((8u << level) / NODE_PX, 1);
    block_area   area = {b->map, b->depth_vx, i * side, j * side, side};
    if (level != b->square_level) return VXS_E_CORRUPT;
    return block_set_load(&b->batch[slot], bytes->data, bytes->size_bytes, &area);
}

static void drop_slot(void *user, uint32_t slot)
{
    map_builder *b = user;
    block_set_free(&b->batch[slot]);
}

/* Merging overlaps with building. */
static void time_batch(void *user, bake_context *ctx, int phase, uint32_t count, const double seconds[2])
{
    (void)user;
    (void)count;
    if (phase == 0) stage_begin(ctx, STAGE_MASKS);
    if (phase == 1) stage_begin_after(ctx, STAGE_NONE, STAGE_MAPS, (double[]){seconds[0], 0, seconds[1]}, 3);
}

vxs_result block_build_map(block_set *s, uint32_t map, const column_map *columns, bake_context *ctx)
{
    uint32_t side = block_square_side(columns->side_px);
    if (columns->fetch_px < side) return VXS_E_ARGUMENT;
    map_builder *b = calloc(1, sizeof *b);
    if (!b) return VXS_E_MEMORY;
    *b = (map_builder){
        .ctx = ctx, .cpu = cpu_level(), .set = s, .map = map, .square_level = square_level(side), .depth_vx = columns->depth_vx};
    s->patterns.cpu = b->cpu;
    s->privates.cpu = b->cpu;
    descent    d    = {.user            = b,
                       .square_px       = side,
                       .squares_fetched = &s->squares_fetched,
                       .classify        = classify,
                       .settle          = settle,
                       .build           = build_slot,
                       .add             = add_slot,
                       .save            = save_slot,
                       .load            = load_slot,
                       .drop            = drop_slot,
                       .batch           = time_batch,
                       .add_early       = 1};
    vxs_result r    = descend(&d, columns, ctx);
    for (uint32_t n = 0; n < DESCENT_SLOTS; n++) block_set_free(&b->batch[n]);
    free(b);
    return r;
}
