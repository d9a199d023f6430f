/* Computing squares; see sparse_square.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/columns/sparse/sparse_square.h"

#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/integer.h"
#include "baker/base/parallel.h"
#include "baker/base/run_control.h"
#include "baker/columns/columns.h"
#include "baker/columns/sparse/square_bound.h"

enum {
    PAGE_TILES  = 63,
    TASK_PX_MAX = 1024, /* the descent begins with squares of this side: enough tasks for all threads */
    SMALL_PX    = 16,   /* a square of this side or less is settled only if its list gives as much as its texels would */
    PASS_PX     = 64,   /* squares of this side call run_control_wait */
    LOOK_PAGES  = 16,   /* new pages, half a mebibyte, after which a thread checks the memory limit */
};

struct leaf_page {
    leaf_page  *next;
    size_t      count;
    column_tile tiles[PAGE_TILES];
};

/* Scratch memory of a worker: lists of the quarters of a square at each level, what a leaf needs, and the tiles found. */
struct square_worker {
    square_list  list, quarter[SPARSE_LEVELS_MAX][4];
    double       exit;    /* the last exit depth that was rounded: the next one is often the same */
    uint32_t     exit_vx; /* the same, rounded up to voxels; 0: not known */
    leaf_scratch leaf;
    leaf_page   *pages, *spare; /* the first page is being filled; pages of earlier squares */
    uint32_t     page_count;    /* of both lists */
};

typedef struct square_maker {
    sparse_square       *q;
    const sparse_level  *level;
    const leaf_desc     *d;
    const triangle_bins *bins;
    const bake_context  *ctx;
    uint32_t             task_px;
    atomic_int           out_of_memory;
} square_maker;

#define LEVEL(name)                                                                                                                \
    {                                                                                                                              \
        square_list_gather_##name, square_list_split_##name, leaf_columns_##name                                                   \
    }

#ifdef __x86_64__
const sparse_level sparse_levels[3] = {LEVEL(sse2), LEVEL(avx2), LEVEL(avx512)};
#else
const sparse_level sparse_levels[3] = {LEVEL(sse2)};
#endif

/* results --------------------------------------------------------------------------------------------------------------------- */

static size_t tile_at(const sparse_square *q, texel_square at)
{
    return (size_t)((at.v - q->at.v) / 8) * (q->at.side / 8) + (at.u - q->at.u) / 8;
}

/* The bounds of a part, which is not within a settled square. */
static column_bounds *bounds_at(const sparse_square *q, texel_square at)
{
    const uint32_t level = square_level(at.side), shift = level + 3;
    return &q->pyramid[level][(size_t)((at.v - q->at.v) >> shift) * (q->at.side >> shift) + ((at.u - q->at.u) >> shift)];
}

/* Settle a square. */
static void set_bounds(sparse_square *q, texel_square at, column_bounds b)
{
    const size_t across = q->at.side / 8, side = at.side / 8, corner = tile_at(q, at);
    *bounds_at(q, at) = b;
    q->levels[corner] = 0;
    q->tiles[corner]  = NULL;
    for (size_t j = 0; j < side && side > 1; j++) memset(q->levels + corner + j * across, (int)square_level(at.side), side);
}

/* Set the bounds of a square that is split from those of its quarters. */
static void unite_bounds(sparse_square *q, texel_square at)
{
    const uint32_t       half = at.side / 2;
    const column_bounds *near = bounds_at(q, (texel_square){at.u, at.v, half}), *next = near + (q->at.side >> log2_u32(half));
    *bounds_at(q, at) = bounds_of_four(near, next);
}

/* Where the worker's next tile goes. Returns NULL without memory. */
static column_tile *next_tile(const square_maker *w, square_worker *worker)
{
    if (!worker->pages || worker->pages->count == PAGE_TILES) { /* put an empty page before the worker's other pages */
        leaf_page *page = worker->spare;
        if (page)
            worker->spare = page->next;
        else if ((++worker->page_count % LOOK_PAGES == 0 && !context_has_memory(w->ctx)) || !(page = malloc(sizeof *page)))
            return NULL;
        page->next    = worker->pages;
        page->count   = 0;
        worker->pages = page;
    }
    return &worker->pages->tiles[worker->pages->count];
}

/* the descent ----------------------------------------------------------------------------------------------------------------- */

/* Settle the square if one depth separates lit from shadowed, with at least `room` between enter and exit depths. Returns 1 if
 * it was settled. */
static int settle(const square_maker *w, square_worker *worker, texel_square at, double enter_most, double exit_least,
                  uint32_t room)
{
    depth_scale s = w->d->scale;
    if (exit_least != worker->exit || !worker->exit_vx) {
        worker->exit    = exit_least;
        worker->exit_vx = depth_up(s, depth_clamped(s, exit_least));
    }
    uint32_t e = depth_down(s, depth_clamped(s, enter_most)), x = worker->exit_vx;
    if (x < e || x - e < room) return 0;
    set_bounds(w->q, at, (column_bounds){e, e, x, x});
    return 1;
}

/* Settle a square without triangles. */
static int settle_empty(const square_maker *w, texel_square at)
{
    set_bounds(w->q, at, bounds_empty(w->d->scale.depth_vx));
    return 1;
}

static int settle_large(const square_maker *w, square_worker *worker, texel_square at, square_bound *bound, square_list *l)
{
    square_bound_tighten(bound, l, &w->d->dont_care);
    return l->count ? settle(w, worker, at, bound->enter_most, bound->exit_least, 0) : settle_empty(w, at);
}

static int settle_small(const square_maker *w, square_worker *worker, texel_square at, const square_bound *bound,
                        const square_list *l)
{
    square_parting p;
    if (dont_care_needs_next(&w->d->dont_care)) return 0; /* the additional don't-care voxels can only be found from texels */
    if (!square_settle(l, w->d->triangles, at, bound, w->d->nearest_back, &p)) return 0;
    if (at.side == 8) return p.is_certain && settle(w, worker, at, p.enter_most, p.exit_least, 1);
    /* with less room its tiles are better: each has more room by itself */
    return settle(w, worker, at, p.enter_most, p.exit_least, at.side);
}

/* Compute a square from the bound of the larger one and its own list, which is used up. Returns 0 without memory. */
static int make_square(const square_maker *w, square_worker *worker, texel_square at, square_bound bound, square_list *l)
{
    if (!l->count) return settle_empty(w, at);
    if (!w->d->every_texel &&
        (at.side > SMALL_PX ? settle_large(w, worker, at, &bound, l) : settle_small(w, worker, at, &bound, l)))
        return 1;
    if (at.side == 8) {
        /* evaluate all texels; columns are not stored if several depths separate lit from shadowed. A sheet that happens to leave
         * one may lie on a plane with its neighbours */
        column_tile  *tile = next_tile(w, worker);
        column_bounds b;
        if (!tile || !w->level->leaf(&worker->leaf, w->d, l, &bound, at, tile, &b)) return 0;
        set_bounds(w->q, at, b);
        if (b.emax < b.xmin && !w->d->every_texel) return 1;
        w->q->tiles[tile_at(w->q, at)] = tile;
        worker->pages->count++;
        return 1;
    }
    if (at.side == PASS_PX) run_control_wait();
    uint32_t     half    = at.side / 2;
    square_list *quarter = worker->quarter[log2_u32(at.side)];
    if (!w->level->split(quarter, w->d->triangles, l, at)) return 0;
    for (uint32_t n = 0; n < 4; n++) {
        texel_square part = {at.u + (n & 1) * half, at.v + (n >> 1) * half, half};
        if (!make_square(w, worker, part, bound, &quarter[n])) return 0;
    }
    unite_bounds(w->q, at);
    return 1;
}

static void make_tasks(void *user, size_t begin, size_t end, uint32_t worker)
{
    square_maker        *w      = user;
    const triangle_bins *bins   = w->bins;
    uint32_t             across = w->q->at.side / w->task_px;
    for (size_t n = begin; n < end && !w->out_of_memory; n++) {
        texel_square at      = {w->q->at.u + (uint32_t)n % across * w->task_px, w->q->at.v + (uint32_t)n / across * w->task_px,
                                w->task_px};
        size_t       cell    = (size_t)(at.v / bins->cell_px) * bins->cells + at.u / bins->cell_px;
        square_list *l       = &w->q->workers[worker].list;
        square_bound nothing = {.enter_most = depth_none(w->d->scale), .left_out = INFINITY, .exit_least = INFINITY};
        if (!w->level->gather(l, w->d->triangles, bins->ids + bins->first[cell], bins->first[cell + 1] - bins->first[cell], at) ||
            !make_square(w, &w->q->workers[worker], at, nothing, l))
            w->out_of_memory = 1;
    }
}

/* the square ------------------------------------------------------------------------------------------------------------------ */

/* Allocate arrays for a square. Arrays of a square of the same side are used again: new pages cost as much time as filling them. */
static int make_room(sparse_square *q, texel_square at, uint32_t threads)
{
    size_t   squares = 0, tiles = (size_t)(at.side / 8) * (at.side / 8);
    uint32_t l = 0;
    if (q->at.side != at.side || q->worker_count < threads) sparse_square_free(q);
    q->at = at;
    if (q->pyramid[0]) return 1;
    for (uint32_t side = at.side / 8; side; side /= 2) squares += (size_t)side * side;
    q->pyramid[0] = malloc(squares * sizeof *q->pyramid[0]);
    q->tiles      = malloc(tiles * sizeof *q->tiles);
    q->levels     = malloc(tiles);
    q->workers    = calloc(threads, sizeof *q->workers);
    if (!q->pyramid[0] || !q->tiles || !q->levels || !q->workers) return 0;
    q->worker_count = threads;
    for (uint32_t side = at.side / 8; side > 1; side /= 2, l++) q->pyramid[l + 1] = q->pyramid[l] + (size_t)side * side;
    return 1;
}

vxs_result sparse_square_make(sparse_square *q, const sparse_level *level, const leaf_desc *d, const triangle_bins *bins,
                              texel_square at, uint32_t threads, const bake_context *ctx)
{
    square_maker w = {
        .q = q, .level = level, .d = d, .bins = bins, .ctx = ctx, .task_px = min_u32(at.side, min_u32(bins->cell_px, TASK_PX_MAX))};
    uint32_t across = at.side / w.task_px, tasks = across * across;
    threads = min_u32(max_u32(threads, 1), min_u32(tasks, PARALLEL_THREADS_MAX));
    if (!make_room(q, at, threads)) return VXS_E_MEMORY;
    q->scale = d->scale;
    for (uint32_t n = 0; n < threads; n++) q->workers[n].exit_vx = 0;
    parallel_for(threads, tasks, 1, make_tasks, &w);
    if (w.out_of_memory) return VXS_E_MEMORY;
    bounds_pyramid_reduce(q->pyramid + square_level(w.task_px), across, threads);
    return VXS_OK;
}

void sparse_square_clear(sparse_square *q)
{
    for (uint32_t n = 0; n < q->worker_count; n++) {
        square_worker *worker = &q->workers[n];
        for (leaf_page *page = worker->pages, *next; page; page = next) {
            next          = page->next;
            page->next    = worker->spare;
            worker->spare = page;
        }
        worker->pages = NULL;
    }
}

void sparse_square_free(sparse_square *q)
{
    sparse_square_clear(q);
    for (square_worker *w = q->workers; w < q->workers + q->worker_count; w++) {
        for (leaf_page *page = w->spare, *next; page; page = next) {
            next = page->next;
            free(page);
        }
        free(w->list.lo);
        for (int k = 0; k < 4 * SPARSE_LEVELS_MAX; k++) free(w->quarter[k / 4][k % 4].lo);
        free(w->leaf.room);
    }
    free(q->workers);
    free(q->levels);
    free(q->tiles);
    free(q->pyramid[0]);
    *q = (sparse_square){0};
}

/* columns --------------------------------------------------------------------------------------------------------------------- */

static vxs_result square_bounds(void *data, uint32_t level, uint32_t i, uint32_t j, column_bounds *out)
{
    const sparse_square *q      = data;
    const uint32_t       across = q->at.side / 8, settled = q->levels[((size_t)j << level) * across + ((size_t)i << level)];
    const uint32_t       up = settled > level ? settled - level : 0;
    *out                    = q->pyramid[level + up][(size_t)(j >> up) * (across >> (level + up)) + (i >> up)];
    return VXS_OK;
}

static vxs_result square_tile(void *data, uint32_t i, uint32_t j, column_tile *out)
{
    const sparse_square *q  = data;
    size_t               at = (size_t)j * (q->at.side / 8) + i;
    column_bounds        b;
    if (!q->levels[at] && q->tiles[at]) {
        *out = *q->tiles[at];
        return VXS_OK;
    }
    square_bounds(data, 0, i, j, &b);
    for (int n = 0; n < 64; n++) {
        out->e[n] = b.emax;
        out->x[n] = b.xmin;
    }
    return VXS_OK;
}

column_square sparse_square_columns(sparse_square *q)
{
    return (column_square){.data     = q,
                           .side_px  = q->at.side,
                           .depth_vx = q->scale.depth_vx,
                           .u_px     = q->at.u,
                           .v_px     = q->at.v,
                           .bounds   = square_bounds,
                           .tile     = square_tile};
}
