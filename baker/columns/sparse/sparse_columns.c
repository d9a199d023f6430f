/* The sparse source; see sparse_columns.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/columns/sparse/sparse_columns.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/cpu.h"
#include "baker/base/memory.h"
#include "baker/base/threads.h"
#include "baker/columns/sparse/sparse_square.h"
#include "baker/columns/sparse/sparse_triangles.h"
#include "baker/scene/fingerprint.h"

/* Key of a square: a hash of everything that its columns are computed from, and of nothing else in the map.
 *
 * The columns follow from: the triangles in the bins of the square, in order; which neighbouring triangles there share a patch, not
 * the numbers of the patches; the position of the square and of its bins; the scale of depths. So the key stays the same when other
 * parts of the map change. Casters, position and name of the light count only as far as they change these triangles. */

/* What keys need. Zero it. */
typedef struct sparse_keys {
    mask_fingerprint *masks; /* of the casters' alpha masks; NULL: not computed yet */
} sparse_keys;

#define XXH_INLINE_ALL
#include <xxhash.h>

enum { HASHED_AT_ONCE = 64 };

/* A triangle as it is hashed: 8-byte numbers, so that there is no padding. */
typedef struct hashed_triangle {
    int64_t  x[3], y[3];
    double   zmin, zmax, gx, gy, slack;
    uint64_t bits; /* kind, ends, and whether its patch is that of the triangle before it */
} hashed_triangle;

/* Additional data of a triangle with holes. */
typedef struct hashed_holes {
    mask_fingerprint mask;
    float            uvq[3][3];
    uint32_t         padding; /* 0 */
} hashed_holes;

static void hash_holes(XXH3_state_t *state, const sparse_keys *keys, const sparse_triangles *s, uint32_t id)
{
    size_t       n = id - s->holed_first;
    hashed_holes h = {.mask = keys->masks[s->mask_of[n]]};
    for (int k = 0; k < 3; k++) {
        h.uvq[k][0] = s->uvq[n][k].u;
        h.uvq[k][1] = s->uvq[n][k].v;
        h.uvq[k][2] = s->uvq[n][k].q;
    }
    XXH3_128bits_update(state, &h, sizeof h);
}

static vxs_result know_masks(sparse_keys *k, const casters *c)
{
    if (k->masks) return VXS_OK;
    if (!(k->masks = malloc((c->alpha_mask_count + 1) * sizeof *k->masks))) return VXS_E_MEMORY;
    for (size_t n = 0; n < c->alpha_mask_count; n++)
        k->masks[n] = alpha_mask_fingerprint(&c->alpha_masks[n], &c->images[c->alpha_masks[n].image]);
    return VXS_OK;
}

/* ids  [count] of the triangles of a cell */
static void hash_cell(XXH3_state_t *state, const sparse_keys *k, const sparse_triangles *s, const uint32_t *ids, uint64_t count)
{
    hashed_triangle some[HASHED_AT_ONCE];
    size_t          held = 0;
    XXH3_128bits_update(state, &count, sizeof count);
    for (size_t n = 0; n < count; n++) {
        const sparse_triangle *t    = &s->all[ids[n]];
        const sparse_tags      tags = s->tags[ids[n]];
        uint64_t               same = n && tags.patch == s->tags[ids[n - 1]].patch;

        some[held++] = (hashed_triangle){.x     = {t->x[0], t->x[1], t->x[2]},
                                         .y     = {t->y[0], t->y[1], t->y[2]},
                                         .zmin  = t->zmin,
                                         .zmax  = t->zmax,
                                         .gx    = t->gx,
                                         .gy    = t->gy,
                                         .slack = t->slack,
                                         .bits  = (uint64_t)tags.kind | (uint64_t)tags.ends << 8 | same << 16};
        if (held < HASHED_AT_ONCE && n + 1 < count) continue;
        XXH3_128bits_update(state, some, held * sizeof *some);
        held = 0;
    }
    for (size_t n = 0; n < count; n++)
        if (ids[n] >= s->holed_first) hash_holes(state, k, s, ids[n]);
}

/* Returns VXS_OK or VXS_E_MEMORY. */
static vxs_result sparse_key(sparse_keys *k, const leaf_desc *d, const triangle_bins *bins, texel_square at, column_key *out)
{
    vxs_result   r = know_masks(k, d->triangles->casters);
    XXH3_state_t state;
    if (r != VXS_OK) return r;
    const uint64_t place[] = {
        at.u, at.v, at.side, bins->cell_px, d->scale.depth_vx, (uint64_t)(d->nearest_back != 0), (uint64_t)(d->every_texel != 0)};
    uint32_t cells = max_u32(at.side / bins->cell_px, 1), i = at.u / bins->cell_px, j = at.v / bins->cell_px;
    XXH3_128bits_reset(&state);
    XXH3_128bits_update(&state, place, sizeof place);
    const double measures[] = {d->scale.voxel_log, d->dont_care.thickness, d->dont_care.behind != 0};
    XXH3_128bits_update(&state, measures, sizeof measures);
    for (uint32_t cell = 0; cell < cells * cells; cell++) {
        const size_t *first = bins->first + (size_t)(j + cell / cells) * bins->cells + i + cell % cells;
        hash_cell(&state, k, d->triangles, bins->ids + first[0], first[1] - first[0]);
    }
    XXH128_hash_t hash = XXH3_128bits_digest(&state);
    *out               = (column_key){hash.low64, hash.high64};
    return VXS_OK;
}

/* A fetched square, or a released one that will be used again. */
typedef struct pooled_square {
    sparse_square         square;
    struct pooled_square *next;
} pooled_square;

typedef struct sparse_map {
    sparse_triangles    triangles;
    triangle_bins       bins;
    leaf_desc           desc;
    const sparse_level *level;
    sparse_keys         keys;
    const bake_context *ctx;   /* for the memory limit */
    os_mutex            lock;  /* of the pool */
    pooled_square      *spare; /* released squares */
} sparse_map;

/* If no triangle's box touches the square, it has no caster. */
static vxs_result map_bounds(void *data, uint32_t level, uint32_t i, uint32_t j, column_bounds *out)
{
    const sparse_map    *o    = data;
    const triangle_bins *bins = &o->bins;
    uint32_t             side = 8u << level, depth = o->desc.scale.depth_vx;
    uint32_t             cells = max_u32(side / bins->cell_px, 1);
    size_t               count = 0;
    for (uint32_t y = j * side / bins->cell_px, row = 0; row < cells; row++) {
        const size_t *first = bins->first + (size_t)(y + row) * bins->cells + i * side / bins->cell_px;
        count += first[cells] - first[0];
    }
    *out = count ? bounds_unknown(depth) : bounds_empty(depth);
    return VXS_OK;
}

static vxs_result fetch_square(sparse_map *o, texel_square at, column_square *out, uint32_t threads)
{
    os_lock(&o->lock);
    pooled_square *p = o->spare;
    if (p) o->spare = p->next;
    os_unlock(&o->lock);
    if (!p) p = calloc(1, sizeof *p);
    vxs_result r = p ? sparse_square_make(&p->square, o->level, &o->desc, &o->bins, at, threads, o->ctx) : VXS_E_MEMORY;
    if (r == VXS_OK) {
        *out = sparse_square_columns(&p->square);
    } else if (p) {
        sparse_square_free(&p->square);
        free(p);
    }
    return r;
}

static vxs_result map_fetch(void *data, uint32_t level, uint32_t i, uint32_t j, column_square *out, bake_context *ctx)
{
    uint32_t side = 8u << level;
    *out          = (column_square){0};
    if (!ctx) return fetch_square(data, (texel_square){i * side, j * side, side}, out, 1);
    stage_begin(ctx, STAGE_MAPS);
    vxs_result r = fetch_square(data, (texel_square){i * side, j * side, side}, out, ctx->threads);
    stage_begin(ctx, STAGE_NONE);
    if (r == VXS_E_MEMORY) context_check(ctx); /* explains the failure if a limit was reached */
    return r == VXS_OK ? r : fail(ctx->run, r, "out of memory for the columns of %u x %u texels", side, side);
}

static vxs_result map_key(void *data, uint32_t level, uint32_t i, uint32_t j, column_key *out)
{
    sparse_map *o    = data;
    uint32_t    side = 8u << level;
    return sparse_key(&o->keys, &o->desc, &o->bins, (texel_square){i * side, j * side, side}, out);
}

static void map_release(void *data, column_square *square)
{
    sparse_map    *o = data;
    pooled_square *p = square->data; /* square is its first member */
    sparse_square_clear(&p->square);
    os_lock(&o->lock);
    p->next  = o->spare;
    o->spare = p;
    os_unlock(&o->lock);
    *square = (column_square){0};
}

static void map_free(sparse_map *o)
{
    for (pooled_square *p = o->spare, *next; p; p = next) {
        next = p->next;
        sparse_square_free(&p->square);
        free(p);
    }
    os_mutex_free(&o->lock);
    free(o->keys.masks);
    o->keys = (sparse_keys){0};
    triangle_bins_free(&o->bins);
    sparse_triangles_free(&o->triangles);
}

static void map_close(void *data)
{
    map_free(data);
    free(data);
}

/* Memory of the lists of all threads: each takes a cell, and splits its list again and again. */
static uint64_t list_bytes(const triangle_bins *b, uint32_t threads)
{
    enum { LISTS = 4 }; /* at once, in lengths of the first one */
    const uint64_t each    = 2 * sizeof(double) + sizeof(square_entry) + sizeof(sparse_tags);
    uint64_t       longest = 0;
    for (size_t n = 0; n < (size_t)b->cells * b->cells; n++) longest = max_u64(longest, b->first[n + 1] - b->first[n]);
    return threads * LISTS * each * longest;
}

/* side  of the map that p is in */
static vxs_result prepare(sparse_map *o, const projection *p, uint32_t side, bake_context *ctx)
{
    o->ctx       = ctx;
    vxs_result r = memory_check(sparse_triangles_bytes(p), ctx->run, "%zu triangles of a map: they need", p->triangle_count);
    if (r == VXS_OK) r = sparse_triangles_init(&o->triangles, p, side, ctx->threads);
    if (r == VXS_OK) r = triangle_bins_init(&o->bins, &o->triangles, side, ctx->threads);
    if (r == VXS_OK)
        r = memory_check(list_bytes(&o->bins, ctx->threads), ctx->run, "%zu triangles of a map: their lists need",
                         p->triangle_count);
    return r == VXS_OK ? r : fail(ctx->run, r, "out of memory for the triangles of a map");
}

static vxs_result take_enter(const column_square *square, uint32_t *enter)
{
    column_tile tile;
    for (uint32_t n = 0; n < square->side_px / 8 * (square->side_px / 8); n++) {
        uint32_t   i = n % (square->side_px / 8), j = n / (square->side_px / 8);
        vxs_result r = square->tile(square->data, i, j, &tile);
        if (r != VXS_OK) return r;
        for (uint32_t v = 0; v < 8; v++)
            memcpy(enter + (size_t)(8 * j + v) * square->side_px + 8 * i, tile.e + 8 * v, 8 * sizeof *enter);
    }
    return VXS_OK;
}

/* Voxels of a punctual light are equal steps of log depth. */
static depth_scale scale_of(const vxs_light *light, uint32_t depth_vx)
{
    double log = light->kind == VXS_LIGHT_KIND_DIRECTIONAL ? 0 : light->voxel_metres;
    return (depth_scale){depth_vx, ldexp(log, (int)light->levels) / depth_vx};
}

vxs_result sparse_columns_enter(const sparse_columns *owner, uint32_t map, uint32_t side_px, uint32_t depth_vx, uint32_t *enter,
                                bake_context *ctx)
{
    sparse_map    o = {.level = &sparse_levels[cpu_level()],
                       .desc  = {.triangles = &o.triangles, .scale = scale_of(owner->light, depth_vx), .every_texel = 1}};
    column_square square;
    projection    p;
    double        coarser = ldexp(side_px, -(int)owner->light->levels);
    os_mutex_init(&o.lock);
    vxs_result r = projection_init(&p, owner->casters, owner->light, (int)map, ctx->threads, ctx->run);
    for (size_t n = 0; n < p.vertex_count && coarser < 1; n++) {
        p.vertices[n].u *= coarser;
        p.vertices[n].v *= coarser;
    }
    if (r == VXS_OK) r = prepare(&o, &p, side_px, ctx);
    projection_free(&p);
    if (r == VXS_OK) {
        r = fetch_square(&o, (texel_square){0, 0, side_px}, &square, ctx->threads);
        if (r != VXS_OK) fail(ctx->run, r, "out of memory for the depths of %u x %u texels", side_px, side_px);
    }
    if (r == VXS_OK) {
        r = take_enter(&square, enter);
        map_release(&o, &square);
    }
    map_free(&o);
    return r;
}

vxs_result sparse_columns_open(const sparse_columns *owner, const projection *p, column_map *out, bake_context *ctx)
{
    uint32_t    side = 1u << owner->light->levels;
    sparse_map *o    = calloc(1, sizeof *o);
    *out             = (column_map){0};
    if (!o) return fail(ctx->run, VXS_E_MEMORY, "out of memory for the triangles of a map");
    o->desc  = (leaf_desc){.triangles    = &o->triangles,
                           .scale        = scale_of(owner->light, side),
                           .nearest_back = owner->nearest_back,
                           .dont_care    = dont_care_rules_of(owner->light, owner->free_behind, owner->thickness_metres)};
    o->level = &sparse_levels[cpu_level()];
    os_mutex_init(&o->lock);
    vxs_result r = prepare(o, p, side, ctx);
    if (r != VXS_OK) {
        map_close(o);
        return r;
    }
    *out = (column_map){.data        = o,
                        .side_px     = side,
                        .depth_vx    = side,
                        .fetch_px    = min_u32(side, owner->fetch_px),
                        .parallel_px = min_u32(min_u32(side, owner->fetch_px), SPARSE_PARALLEL_PX),
                        .bounds      = map_bounds,
                        .fetch       = map_fetch,
                        .release     = map_release,
                        .close       = map_close,
                        .key         = map_key};
    return VXS_OK;
}

static vxs_result open_map(void *data, uint32_t map, column_map *out, bake_context *ctx)
{
    const sparse_columns *owner = data;
    projection            p;
    *out = (column_map){0};
    stage_begin(ctx, STAGE_MAPS);
    vxs_result r = projection_init(&p, owner->casters, owner->light, (int)map, ctx->threads, ctx->run);
    if (r == VXS_OK) r = sparse_columns_open(owner, &p, out, ctx);
    projection_free(&p);
    stage_begin(ctx, STAGE_NONE);
    return r;
}

column_source sparse_columns_source(sparse_columns *o)
{
    return (column_source){.data = o, .map_count = vxs_map_count(o->light), .open = open_map};
}
