/* The sparse source; see sparse_columns.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/columns/sparse/sparse_columns.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/cpu.h"
#include "baker/base/memory.h"
#include "baker/base/threads.h"
#include "baker/columns/sparse/sparse_key.h"
#include "baker/columns/sparse/sparse_square.h"

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

/* NULL without memory. */
static pooled_square *take_square(sparse_map *o)
{
    os_lock(&o->lock);
    pooled_square *p = o->spare;
    if (p) o->spare = p->next;
    os_unlock(&o->lock);
    return p ? p : calloc(1, sizeof *p);
}

static void put_square(sparse_map *o, pooled_square *p)
{
    os_lock(&o->lock);
    p->next  = o->spare;
    o->spare = p;
    os_unlock(&o->lock);
}

static vxs_result fetch_square(sparse_map *o, texel_square at, column_square *out, uint32_t threads)
{
    pooled_square *p = take_square(o);
    vxs_result     r = p ? sparse_square_make(&p->square, o->level, &o->desc, &o->bins, at, threads, o->ctx) : VXS_E_MEMORY;
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
    return r == VXS_OK ? r : fail(ctx->message, r, "out of memory for the columns of %u x %u texels", side, side);
}

static vxs_result map_key(void *data, uint32_t level, uint32_t i, uint32_t j, column_key *out)
{
    sparse_map *o    = data;
    uint32_t    side = 8u << level;
    return sparse_key(&o->keys, &o->desc, &o->bins, (texel_square){i * side, j * side, side}, out);
}

static void map_release(void *data, column_square *square)
{
    pooled_square *p = square->data; /* square is its first member */
    sparse_square_clear(&p->square);
    put_square(data, p);
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
    sparse_keys_free(&o->keys);
    triangle_bins_free(&o->bins);
    sparse_triangles_free(&o->triangles);
}

static void map_close(void *data)
{
    map_free(data);
    free(data);
}

/* side  of the map that p is in */
static vxs_result prepare(sparse_map *o, const projection *p, uint32_t side, bake_context *ctx)
{
    o->ctx       = ctx;
    vxs_result r = memory_check(sparse_triangles_bytes(p), ctx->message, "%zu triangles of a map: they need", p->triangle_count);
    if (r == VXS_OK) r = sparse_triangles_init(&o->triangles, p, side, ctx->threads);
    if (r == VXS_OK) r = triangle_bins_init(&o->bins, &o->triangles, side, ctx->threads);
    return r == VXS_OK ? r : fail(ctx->message, r, "out of memory for the triangles of a map");
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
    vxs_result r = projection_init(&p, owner->casters, owner->light, (int)map, ctx->threads, ctx->message);
    for (size_t n = 0; n < p.vertex_count && coarser < 1; n++) {
        p.vertices[n].u *= coarser;
        p.vertices[n].v *= coarser;
    }
    if (r == VXS_OK) r = prepare(&o, &p, side_px, ctx);
    projection_free(&p);
    if (r == VXS_OK) {
        r = fetch_square(&o, (texel_square){0, 0, side_px}, &square, ctx->threads);
        if (r != VXS_OK) fail(ctx->message, r, "out of memory for the depths of %u x %u texels", side_px, side_px);
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
    if (!o) return fail(ctx->message, VXS_E_MEMORY, "out of memory for the triangles of a map");
    o->desc  = (leaf_desc){.triangles    = &o->triangles,
                           .scale        = scale_of(owner->light, side),
                           .nearest_back = owner->nearest_back,
                           .dont_care    = dont_care_rules_of(owner->light, owner->free_behind, owner->thickness_m)};
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
    vxs_result r = projection_init(&p, owner->casters, owner->light, (int)map, ctx->threads, ctx->message);
    if (r == VXS_OK) r = sparse_columns_open(owner, &p, out, ctx);
    projection_free(&p);
    stage_begin(ctx, STAGE_NONE);
    return r;
}

column_source sparse_columns_source(sparse_columns *o)
{
    return (column_source){.data = o, .map_count = vxs_map_count(o->light), .open = open_map};
}
