/* Making and adding the squares of a batch; see descent_batch.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/columns/descent_batch.h"

#include <stdlib.h>

#include "baker/base/array.h"
#include "baker/base/clock.h"
#include "baker/base/parallel.h"
#include "baker/base/run_control.h"

enum { BATCH_MOST = 4096 }; /* squares in a batch whose squares are added while others are built */

/* Whether the next square to add is made. */
static int next_is_ready(const walker *w)
{
    return w->result == VXS_OK && w->added < w->count && w->batch[w->added].done;
}

/* Add the square's step to the record. Frames move down to be contiguous. */
static vxs_result record_square(walker *w, size_t n)
{
    const waiting *s  = &w->batch[n];
    uint32_t       to = w->record->built_count;
    if (s->kind == WAITING_SETTLED) return record_add_settled(w->record, s->level, s->i, s->j, &s->bounds);
    if (to != n) {
        w->frames[to]      = w->frames[n];
        w->built_bytes[to] = w->built_bytes[n];
        w->frames[n]       = (vxs_bytes){0};
    }
    return record_add_built(w->record, s->level, s->i, s->j);
}

static vxs_result add_square(walker *w, size_t n)
{
    const waiting *s = &w->batch[n];
    vxs_result     r = s->result;
    if (r == VXS_OK && w->record) r = record_square(w, n);
    if (r != VXS_OK) return r;
    if (s->kind == WAITING_SETTLED) return w->d->settle(w->d->user, &s->bounds, s->level, s->i, s->j);
    if (!w->columns->cache || !w->columns->cache->store_only) return w->d->add(w->d->user, s->slot, s->level, s->i, s->j);
    w->d->drop(w->d->user, s->slot);
    return VXS_OK;
}

/* making the squares of a batch ----------------------------------------------------------------------------------------------- */

/* Pack what was built, for the square cache. */
static vxs_result pack_built(walker *w, size_t n)
{
    vxs_bytes  built = {0};
    vxs_result r     = w->d->save(w->d->user, w->batch[n].slot, &built);
    if (r == VXS_OK) r = record_pack(&built, &w->frames[n]);
    w->built_bytes[n] = built.size_bytes;
    free(built.data);
    return r;
}

/* inner_i, inner_j  position in the columns, in squares of its level */
static vxs_result build(walker *w, size_t n, const column_square *columns, uint32_t inner_i, uint32_t inner_j)
{
    waiting   *s     = &w->batch[n];
    double     since = clock_seconds();
    vxs_result r     = w->d->build(w->d->user, s->slot, columns, s->level, inner_i, inner_j);
    s->seconds[1]    = clock_seconds() - since;
    return r == VXS_OK && w->record ? pack_built(w, n) : r;
}

static vxs_result fetch_and_build(walker *w, size_t n)
{
    waiting          *s       = &w->batch[n];
    const column_map *columns = w->columns;
    double            since   = clock_seconds();
    column_square     square;
    vxs_result        r = columns->fetch(columns->data, s->level, s->i, s->j, &square, NULL);
    if (r != VXS_OK) return r;
    s->seconds[0] = clock_seconds() - since;
    if ((r = square.bounds(square.data, s->level, 0, 0, &s->bounds)) == VXS_OK) {
        if (w->d->classify(w->d->user, &s->bounds, s->level, 1) == DESCENT_SETTLED)
            s->kind = WAITING_SETTLED;
        else
            r = build(w, n, &square, 0, 0);
    }
    columns->release(columns->data, &square);
    return r;
}

static vxs_result load(const walker *w, const waiting *s)
{
    vxs_bytes  built = {0};
    vxs_result r     = record_unpack(s->known, &built);
    if (r == VXS_OK) r = w->d->load(w->d->user, s->slot, &built, s->level, s->i, s->j);
    free(built.data);
    return r;
}

static vxs_result make(walker *w, size_t n)
{
    const waiting *s = &w->batch[n];
    if (run_control_is_cancelled()) return VXS_E_INTERRUPTED;
    if (!context_has_memory(w->ctx)) return VXS_E_MEMORY;
    switch (s->kind) {
    case WAITING_KNOWN: return load(w, s);
    case WAITING_BUILT: return build(w, n, w->fetched, s->inner_i, s->inner_j);
    case WAITING_FETCHED: return fetch_and_build(w, n);
    case WAITING_SETTLED: break;
    }
    return VXS_OK;
}

/* Whether the slot of a square still has the square that was in it before. */
static int must_wait(const walker *w, const waiting *s)
{
    return s->kind != WAITING_SETTLED && w->result == VXS_OK && s->turn >= w->batch[w->added].turn + descent_slots(w->ctx->threads);
}

/* Wait for the slot of a square. Returns the first error of the squares before it. The lock is held. */
static vxs_result wait_for_slot(walker *w, const waiting *s)
{
    if (!must_wait(w, s)) return w->result;
    run_control *run = run_control_current();
    os_unlock(&w->lock);
    run_control_leave(run); /* waiting does not count as work */
    os_lock(&w->lock);
    w->waiters++;
    while (must_wait(w, s)) os_wait(&w->moved, &w->lock);
    w->waiters--;
    os_unlock(&w->lock);
    run_control_enter(run);
    os_lock(&w->lock);
    return w->result;
}

/* Add all squares that are ready; if another thread is adding, that thread adds them too. The lock is held. */
static void add_ready(walker *w)
{
    while (!w->adding && next_is_ready(w)) {
        w->adding = 1;
        os_unlock(&w->lock);
        vxs_result r = add_square(w, w->added);
        os_lock(&w->lock);
        w->adding = 0;
        w->result = r;
        w->added_steps += w->batch[w->added++].steps;
        if (w->waiters) os_wake_all(&w->moved);
    }
}

static void report_steps(walker *w)
{
    os_lock(&w->lock);
    uint32_t steps = w->added_steps;
    w->added_steps = 0;
    os_unlock(&w->lock);
    if (steps) steps_done(w->ctx, steps);
}

static void make_some(void *user, size_t begin, size_t end, uint32_t worker)
{
    walker *w = user;
    for (size_t n = begin; n < end; n++) {
        waiting *s = &w->batch[n];
        os_lock(&w->lock);
        s->result = wait_for_slot(w, s);
        os_unlock(&w->lock);
        if (s->result == VXS_OK) s->result = make(w, n);
        os_lock(&w->lock);
        s->done = 1;
        if (w->d->add_early && s->kind != WAITING_KNOWN) add_ready(w);
        os_unlock(&w->lock);
        if (!worker) report_steps(w); /* the caller's thread */
    }
}

static void batch_phase(const walker *w, int phase)
{
    double seconds[2] = {0, 0};
    if (!w->d->batch) return;
    for (size_t n = 0; n < w->count; n++)
        for (int k = 0; k < 2; k++) seconds[k] += w->batch[n].seconds[k];
    w->d->batch(w->d->user, w->ctx, phase, (uint32_t)w->count, seconds);
}

/* Whether the record of a known square was not sound. */
static int is_unsound(const walker *w)
{
    int unsound = 0;
    for (size_t n = 0; n < w->count; n++) unsound |= w->batch[n].known && w->batch[n].result == VXS_E_CORRUPT;
    return unsound;
}

vxs_result batch_make(walker *w)
{
    w->added  = 0;
    w->result = VXS_OK;
    batch_phase(w, 0);
    parallel_for(w->ctx->threads, w->count, 1, make_some, w);
    int unsound = is_unsound(w);
    for (size_t n = 0; n < w->count && unsound; n++) w->d->drop(w->d->user, w->batch[n].slot);
    batch_phase(w, 1);
    return unsound ? VXS_E_CORRUPT : VXS_OK;
}

vxs_result batch_add(walker *w)
{
    for (; next_is_ready(w); w->added++) {
        w->result = add_square(w, w->added);
        w->added_steps += w->batch[w->added].steps;
    }
    batch_phase(w, 2);
    w->count = 0;
    report_steps(w);
    return w->result;
}

vxs_result batch_end(walker *w)
{
    vxs_result made = VXS_OK;
    if (w->count) {
        batch_make(w);
        made = batch_add(w);
    }
    steps_done(w->ctx, w->steps);
    w->steps     = 0;
    vxs_result r = context_check(w->ctx);
    return r == VXS_OK ? made : r;
}

vxs_result batch_put(walker *w, const waiting *s)
{
    const size_t most = w->d->add_early && !w->record ? BATCH_MOST : DESCENT_HELD;
    vxs_result   r    = w->count < most ? VXS_OK : w->record ? VXS_E_ARGUMENT : batch_end(w);
    if (r == VXS_OK && !array_reserve(&w->batch, &w->capacity, w->count + 1, sizeof *w->batch)) r = VXS_E_MEMORY;
    if (r != VXS_OK) return r;
    waiting *to = &w->batch[w->count++];
    *to         = *s;
    to->turn    = w->turns;
    to->slot    = (uint32_t)(w->d->add_early ? w->turns % descent_slots(w->ctx->threads) : w->count - 1);
    to->steps   = w->steps;
    w->steps    = 0;
    w->turns += s->kind != WAITING_SETTLED;
    return VXS_OK;
}

void batch_init(walker *w)
{
    os_mutex_init(&w->lock);
    os_signal_init(&w->moved);
}

void batch_free(walker *w)
{
    free(w->batch);
    os_signal_free(&w->moved);
    os_mutex_free(&w->lock);
}
