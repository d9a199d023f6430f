/* From the top of a map down; see descent.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/columns/descent.h"

#include <pthread.h>
#include <stdlib.h>

#include "baker/base/parallel.h"
#include "baker/columns/square_keeper.h"
#include "baker/columns/square_record.h"

/* A square that waits to be built. */
typedef struct waiting {
    uint32_t   level, i, j;      /* of the map */
    uint32_t   inner_i, inner_j; /* the same square, of the fetched columns */
    vxs_result result;
    int        built;

    const record_step *known; /* what it was before; NULL: it is built */
} waiting;

typedef struct walker {
    const descent       *d;
    const column_map    *columns;
    bake_context        *ctx;
    const column_square *fetched; /* NULL between fetches */
    uint32_t             fetched_level, fetched_i, fetched_j;
    waiting              batch[DESCENT_BATCH];
    uint32_t             count;

    /* of the fetched square, where somebody keeps what becomes of it; NULL: nobody does */
    square_record *record;
    vxs_bytes      frames[DESCENT_BATCH]; /* what was built */
    uint64_t       built_bytes[DESCENT_BATCH];

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
    if (s->result != VXS_OK) return s->result;
    if (!w->columns->keeper || !w->columns->keeper->apart) return w->d->add(w->d->user, slot, s->level, s->i, s->j);
    w->d->drop(w->d->user, slot);
    return VXS_OK;
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

/* What was built, as it is kept. */
static vxs_result pack_slot(walker *w, uint32_t slot)
{
    vxs_bytes  built = {0};
    vxs_result r     = w->d->save(w->d->user, slot, &built);
    if (r == VXS_OK) r = record_pack(&built, &w->frames[slot]);
    w->built_bytes[slot] = built.size_bytes;
    free(built.data);
    return r;
}

static vxs_result build_slot(walker *w, uint32_t slot, const waiting *s)
{
    vxs_result r = w->d->build(w->d->user, slot, w->fetched, s->level, s->inner_i, s->inner_j);
    return r == VXS_OK && w->record ? pack_slot(w, slot) : r;
}

static vxs_result load_slot(const walker *w, uint32_t slot, const waiting *s)
{
    vxs_bytes  built = {0};
    vxs_result r     = record_unpack(s->known, &built);
    if (r == VXS_OK) r = w->d->load(w->d->user, slot, &built, s->level, s->i, s->j);
    free(built.data);
    return r;
}

static void build_slots(void *user, size_t begin, size_t end, uint32_t worker)
{
    walker *w = user;
    (void)worker;
    for (size_t n = begin; n < end; n++) {
        waiting *s = &w->batch[n];
        s->result  = s->known ? load_slot(w, (uint32_t)n, s) : build_slot(w, (uint32_t)n, s);
        pthread_mutex_lock(&w->lock);
        s->built = 1;
        if (w->d->add_early && !s->known) add_ready(w);
        pthread_mutex_unlock(&w->lock);
    }
}

static void batch_phase(const walker *w, int phase)
{
    if (w->d->batch) w->d->batch(w->d->user, w->ctx, phase, w->count);
}

/* Whether a square that was known turned out not to be. */
static int is_unsound(const walker *w)
{
    int unsound = 0;
    for (uint32_t n = 0; n < w->count; n++) unsound |= w->batch[n].known && w->batch[n].result == VXS_E_CORRUPT;
    return unsound;
}

/* Build the squares that wait, or load them. VXS_E_CORRUPT: one that was known was not sound, and nothing is left of any. */
static vxs_result make_batch(walker *w)
{
    w->added  = 0;
    w->result = VXS_OK;
    batch_phase(w, 0);
    parallel_for(w->ctx->threads, w->count, 1, build_slots, w);
    int unsound = is_unsound(w);
    for (uint32_t n = 0; n < w->count && unsound; n++) w->d->drop(w->d->user, n);
    batch_phase(w, 1);
    return unsound ? VXS_E_CORRUPT : VXS_OK;
}

/* Add them in the order in which they came. */
static vxs_result add_batch(walker *w)
{
    for (; next_is_ready(w); w->added++) w->result = add_square(w, w->added);
    batch_phase(w, 2);
    w->count = 0;
    return w->result;
}

static vxs_result build_batch(walker *w)
{
    if (!w->count) return VXS_OK;
    make_batch(w); /* none of them is known */
    return add_batch(w);
}

static vxs_result build_later(walker *w, uint32_t level, uint32_t i, uint32_t j)
{
    uint32_t inner = w->fetched_level - level;
    if (w->count == DESCENT_BATCH) return VXS_E_ARGUMENT; /* kept squares are no larger */
    w->batch[w->count++] =
        (waiting){.level = level, .i = i, .j = j, .inner_i = i - (w->fetched_i << inner), .inner_j = j - (w->fetched_j << inner)};
    if (w->record) return record_add_built(w->record, level, i, j);
    return w->count < DESCENT_BATCH ? VXS_OK : build_batch(w);
}

/* Of the steps of progress, one for each square of fetch_px a side. */
static uint32_t steps_of(const walker *w, uint32_t level)
{
    uint32_t across = (8u << level) / w->columns->fetch_px;
    return across * across;
}

static vxs_result visit(walker *w, uint32_t level, uint32_t i, uint32_t j);

/* squares that are kept ------------------------------------------------------------------------------------------------------- */

/* Begin what is kept of the square that is fetched. */
static void record_begin(walker *w, square_record *record)
{
    *record   = (square_record){0};
    w->record = w->columns->keeper ? record : NULL;
}

static vxs_result record_keep(walker *w)
{
    const square_keeper *keeper = w->columns->keeper;
    vxs_bytes            bytes  = {0};
    vxs_result           r      = record_write(w->record, w->frames, w->built_bytes, &bytes);
    if (r == VXS_OK) r = keeper->keep(keeper->data, &bytes, w->ctx);
    free(bytes.data);
    return r;
}

static void record_end(walker *w, square_record *record)
{
    for (uint32_t n = 0; n < DESCENT_BATCH; n++) {
        free(w->frames[n].data);
        w->frames[n] = (vxs_bytes){0};
    }
    record_free(record);
    w->record = NULL;
}

/* What bounds settled is settled by them again. */
static vxs_result settle_known(const walker *w, const square_record *known)
{
    vxs_result r = VXS_OK;
    for (const record_step *s = known->steps; s < known->steps + known->count && r == VXS_OK; s++) {
        descent_step step = DESCENT_SETTLED;
        if (!s->is_built) r = w->d->look(w->d->user, &s->bounds, s->level, s->i, s->j, 1, &step);
        if (step != DESCENT_SETTLED) r = VXS_E_VERSION; /* sound, and made by another program */
    }
    return r;
}

/* The square as it was. VXS_E_CORRUPT: it is not sound, and nothing was added. */
static vxs_result recall(walker *w, uint32_t level, uint32_t i, uint32_t j, const vxs_bytes *bytes)
{
    square_record known = {0};
    vxs_result    r     = record_read(&known, bytes->data, bytes->size_bytes, level, i, j, w->columns->depth_vx);
    if (r == VXS_OK && known.built_count > DESCENT_BATCH) r = VXS_E_CORRUPT;
    for (const record_step *s = known.steps; s < known.steps + known.count && r == VXS_OK; s++)
        if (s->is_built) w->batch[w->count++] = (waiting){.level = s->level, .i = s->i, .j = s->j, .known = s};
    if (r == VXS_OK && w->count) r = make_batch(w);
    if (r == VXS_OK) r = settle_known(w, &known);
    if (r == VXS_OK && w->count) r = add_batch(w);
    w->count = 0;
    record_free(&known);
    return r;
}

static vxs_result fetch(walker *w, uint32_t level, uint32_t i, uint32_t j)
{
    column_square square;
    square_record record;
    vxs_result    r = w->columns->fetch(w->columns->data, level, i, j, &square, w->ctx);
    if (r != VXS_OK) return r;
    record_begin(w, &record);
    w->fetched       = &square;
    w->fetched_level = level;
    w->fetched_i     = i;
    w->fetched_j     = j;
    r                = visit(w, level, i, j);
    if (r == VXS_OK) r = build_batch(w);
    if (r == VXS_OK && w->record) r = record_keep(w);
    w->fetched = NULL;
    record_end(w, &record);
    w->columns->release(w->columns->data, &square);
    return r;
}

/* A square that cannot be settled as a whole before it is fetched. */
static vxs_result make_square(walker *w, uint32_t level, uint32_t i, uint32_t j)
{
    const square_keeper *keeper = w->columns->keeper;
    square_fate          fate   = SQUARE_MAKE;
    vxs_bytes            known  = {0};
    vxs_result           r      = VXS_OK;
    if (keeper) r = keeper->ask(keeper->data, w->columns, level, i, j, &fate, &known, w->ctx);
    if (r == VXS_OK && fate == SQUARE_KNOWN) r = recall(w, level, i, j, &known);
    free(known.data);
    if ((r == VXS_OK && fate == SQUARE_MAKE) || (r == VXS_E_CORRUPT && fate == SQUARE_KNOWN)) r = fetch(w, level, i, j);
    steps_done(w->ctx, steps_of(w, level));
    return r == VXS_OK ? context_within_memory(w->ctx) : r;
}

/* the descent ----------------------------------------------------------------------------------------------------------------- */

static vxs_result bounds_of(const walker *w, uint32_t level, uint32_t i, uint32_t j, column_bounds *out)
{
    if (!w->fetched) {
        const square_keeper *keeper = w->columns->keeper;
        vxs_result           r      = w->columns->bounds(w->columns->data, level, i, j, out);
        return r == VXS_OK && keeper && keeper->note ? keeper->note(keeper->data, out) : r;
    }
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
        return w->record ? record_add_settled(w->record, level, i, j, &bounds) : VXS_OK;
    }
    if (!w->fetched && 8u << level <= w->columns->fetch_px) return make_square(w, level, i, j);
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
