/* From the top of a map down; see descent.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/columns/descent.h"

#include <pthread.h>

#include "baker/base/parallel.h"

/* A square that waits to be built. */
typedef struct waiting {
    uint32_t   level, i, j;      /* of the map */
    uint32_t   inner_i, inner_j; /* the same square, of the fetched columns */
    vxs_result result;
    int        built;
} waiting;

typedef struct walker {
    const descent       *d;
    const column_map    *columns;
    bake_context        *ctx;
    const column_square *fetched; /* NULL between fetches */
    uint32_t             fetched_level, fetched_i, fetched_j;
    waiting              batch[DESCENT_BATCH];
    uint32_t             count;

    /* of the batch: what one thread at a time adds, in order, while others build */
    pthread_mutex_t lock;
    uint32_t        added;
    int             adding;
    vxs_result      result; /* of the squares that were added, or the first that failed */
} walker;

/* Whether the next square waits only for being added. */
static int next_is_ready(const walker *w)
{
    return w->result == VXS_OK && w->added < w->count && w->batch[w->added].built;
}

static vxs_result add_square(walker *w, uint32_t slot)
{
    const waiting *s = &w->batch[slot];
    return s->result == VXS_OK ? w->d->add(w->d->user, slot, s->level, s->i, s->j) : s->result;
}

/* Add all that can be. Where another thread does so, it goes on with what is built meanwhile. */
static void add_ready(walker *w)
{
    while (!w->adding && next_is_ready(w)) {
        w->adding = 1;
        pthread_mutex_unlock(&w->lock);
        vxs_result r = add_square(w, w->added);
        pthread_mutex_lock(&w->lock);
        w->adding = 0;
        w->result = r;
        w->added++;
    }
}

static void build_slots(void *user, size_t begin, size_t end, uint32_t worker)
{
    walker *w = user;
    (void)worker;
    for (size_t n = begin; n < end; n++) {
        waiting *s = &w->batch[n];
        s->result  = w->d->build(w->d->user, (uint32_t)n, w->fetched, s->level, s->inner_i, s->inner_j);
        pthread_mutex_lock(&w->lock);
        s->built = 1;
        if (w->d->add_early) add_ready(w);
        pthread_mutex_unlock(&w->lock);
    }
}

static void batch_phase(const walker *w, int phase)
{
    if (w->d->batch) w->d->batch(w->d->user, w->ctx, phase, w->count);
}

/* Build the squares that wait, and add them in the order in which they came. */
static vxs_result build_batch(walker *w)
{
    if (!w->count) return VXS_OK;
    w->added  = 0;
    w->result = VXS_OK;
    batch_phase(w, 0);
    parallel_for(w->ctx->threads, w->count, 1, build_slots, w);
    batch_phase(w, 1);
    for (; next_is_ready(w); w->added++) w->result = add_square(w, w->added);
    batch_phase(w, 2);
    w->count = 0;
    return w->result;
}

static vxs_result build_later(walker *w, uint32_t level, uint32_t i, uint32_t j)
{
    uint32_t inner       = w->fetched_level - level;
    w->batch[w->count++] = (waiting){level, i, j, i - (w->fetched_i << inner), j - (w->fetched_j << inner), VXS_OK, 0};
    return w->count < DESCENT_BATCH ? VXS_OK : build_batch(w);
}

/* Of the steps of progress, one for each square of fetch_px a side. */
static uint32_t steps_of(const walker *w, uint32_t level)
{
    uint32_t across = (8u << level) / w->columns->fetch_px;
    return across * across;
}

static vxs_result visit(walker *w, uint32_t level, uint32_t i, uint32_t j);

static vxs_result fetch(walker *w, uint32_t level, uint32_t i, uint32_t j)
{
    column_square square;
    vxs_result    r = w->columns->fetch(w->columns->data, level, i, j, &square, w->ctx);
    if (r != VXS_OK) return r;
    w->fetched       = &square;
    w->fetched_level = level;
    w->fetched_i     = i;
    w->fetched_j     = j;
    r                = visit(w, level, i, j);
    if (r == VXS_OK) r = build_batch(w);
    w->fetched = NULL;
    w->columns->release(w->columns->data, &square);
    steps_done(w->ctx, steps_of(w, level));
    return r == VXS_OK ? context_within_memory(w->ctx) : r;
}

static vxs_result bounds_of(const walker *w, uint32_t level, uint32_t i, uint32_t j, column_bounds *out)
{
    if (!w->fetched) return w->columns->bounds(w->columns->data, level, i, j, out);
    uint32_t inner = w->fetched_level - level;
    return w->fetched->bounds(w->fetched->data, level, i - (w->fetched_i << inner), j - (w->fetched_j << inner), out);
}

/* The square (i, j) of `level` of the map. */
static vxs_result visit(walker *w, uint32_t level, uint32_t i, uint32_t j)
{
    column_bounds bounds;
    descent_step  step;
    vxs_result    r = bounds_of(w, level, i, j, &bounds);
    if (r == VXS_OK) r = w->d->look(w->d->user, &bounds, level, i, j, w->fetched != NULL, &step);
    if (r != VXS_OK) return r;
    if (step == DESCENT_SETTLED) {
        if (!w->fetched) steps_done(w->ctx, steps_of(w, level));
        return VXS_OK;
    }
    if (!w->fetched && 8u << level <= w->columns->fetch_px) return fetch(w, level, i, j);
    if (w->fetched && step == DESCENT_BUILD) return build_later(w, level, i, j);
    for (uint32_t c = 0; c < 4 && r == VXS_OK; c++) r = visit(w, level - 1, 2 * i + (c & 1), 2 * j + (c >> 1));
    return r;
}

vxs_result descend(const descent *d, const column_map *columns, bake_context *ctx)
{
    walker     w = {.d = d, .columns = columns, .ctx = ctx, .lock = PTHREAD_MUTEX_INITIALIZER};
    vxs_result r = visit(&w, square_level(columns->side_px), 0, 0);
    pthread_mutex_destroy(&w.lock);
    return r;
}
