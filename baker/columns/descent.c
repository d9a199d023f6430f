/* Descent of a map; see descent.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/columns/descent.h"

#include <stdlib.h>
#include <string.h>

#include "baker/base/clock.h"
#include "baker/base/parallel.h"
#include "baker/base/run_control.h"
#include "baker/base/threads.h"
#include "baker/base/z_order.h"
#include "baker/columns/square_record.h"

/* State of a square in the batch. */
typedef enum waiting_kind {
    WAITING_SETTLED, /* settled by its bounds */
    WAITING_KNOWN,   /* known from the square cache */
    WAITING_BUILT,   /* built from the fetched columns */
    WAITING_FETCHED, /* fetched by the building thread, which may find that bounds settle it */
} waiting_kind;

typedef struct waiting {
    waiting_kind kind;
    uint32_t     level, i, j;      /* of the map */
    uint32_t     inner_i, inner_j; /* built: position in the fetched columns */
    vxs_result   result;
    int          done;

    column_bounds      bounds;     /* settled: of its columns */
    const record_step *known;      /* known: its step in the record */
    double             seconds[2]; /* time of fetch and of build */
} waiting;

typedef struct walker {
    const descent       *d;
    const column_map    *columns;
    bake_context        *ctx;
    const column_square *fetched; /* NULL between fetches */
    uint32_t             fetched_level, fetched_i, fetched_j;
    waiting              batch[DESCENT_BATCH];
    uint32_t             count;
    uint32_t             steps; /* steps of progress that the batch completes */

    /* record of the fetched square for the square cache; NULL: none */
    square_record *record;
    vxs_bytes      frames[DESCENT_BATCH]; /* by slot: what was built, packed */
    uint64_t       built_bytes[DESCENT_BATCH];

    /* shared by the threads of a batch, under the lock: one thread at a time adds squares, in order, while others build */
    os_mutex   lock;
    uint32_t   added;
    int        adding;
    vxs_result result; /* first error of the added squares, or VXS_OK */
} walker;

/* Whether the next square to add is made. */
static int next_is_ready(const walker *w)
{
    return w->result == VXS_OK && w->added < w->count && w->batch[w->added].done;
}

/* Add the square's step to the record. Frames move down to be contiguous. */
static vxs_result record_square(walker *w, uint32_t slot)
{
    const waiting *s  = &w->batch[slot];
    uint32_t       to = w->record->built_count;
    if (s->kind == WAITING_SETTLED) return record_add_settled(w->record, s->level, s->i, s->j, &s->bounds);
    if (to != slot) {
        w->frames[to]      = w->frames[slot];
        w->built_bytes[to] = w->built_bytes[slot];
        w->frames[slot]    = (vxs_bytes){0};
    }
    return record_add_built(w->record, s->level, s->i, s->j);
}

static vxs_result add_square(walker *w, uint32_t slot)
{
    const waiting *s = &w->batch[slot];
    vxs_result     r = s->result;
    if (r == VXS_OK && w->record) r = record_square(w, slot);
    if (r != VXS_OK) return r;
    if (s->kind == WAITING_SETTLED) return w->d->settle(w->d->user, &s->bounds, s->level, s->i, s->j);
    if (!w->columns->cache || !w->columns->cache->store_only) return w->d->add(w->d->user, slot, s->level, s->i, s->j);
    w->d->drop(w->d->user, slot);
    return VXS_OK;
}

/* making the squares of a batch ----------------------------------------------------------------------------------------------- */

/* Pack what was built, for the square cache. */
static vxs_result pack_slot(walker *w, uint32_t slot)
{
    vxs_bytes  built = {0};
    vxs_result r     = w->d->save(w->d->user, slot, &built);
    if (r == VXS_OK) r = record_pack(&built, &w->frames[slot]);
    w->built_bytes[slot] = built.size_bytes;
    free(built.data);
    return r;
}

/* inner_i, inner_j  position in the columns, in squares of its level */
static vxs_result build_slot(walker *w, uint32_t slot, const column_square *columns, uint32_t inner_i, uint32_t inner_j)
{
    waiting   *s     = &w->batch[slot];
    double     since = clock_seconds();
    vxs_result r     = w->d->build(w->d->user, slot, columns, s->level, inner_i, inner_j);
    s->seconds[1]    = clock_seconds() - since;
    return r == VXS_OK && w->record ? pack_slot(w, slot) : r;
}

static vxs_result fetch_slot(walker *w, uint32_t slot)
{
    waiting          *s       = &w->batch[slot];
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
            r = build_slot(w, slot, &square, 0, 0);
    }
    columns->release(columns->data, &square);
    return r;
}

static vxs_result load_slot(const walker *w, uint32_t slot)
{
    const waiting *s     = &w->batch[slot];
    vxs_bytes      built = {0};
    vxs_result     r     = record_unpack(s->known, &built);
    if (r == VXS_OK) r = w->d->load(w->d->user, slot, &built, s->level, s->i, s->j);
    free(built.data);
    return r;
}

static vxs_result make_slot(walker *w, uint32_t slot)
{
    const waiting *s = &w->batch[slot];
    switch (s->kind) {
    case WAITING_KNOWN: return load_slot(w, slot);
    case WAITING_BUILT: return build_slot(w, slot, w->fetched, s->inner_i, s->inner_j);
    case WAITING_FETCHED: return fetch_slot(w, slot);
    case WAITING_SETTLED: break;
    }
    return VXS_OK;
}

static void make_slots(void *user, size_t begin, size_t end, uint32_t worker)
{
    walker *w = user;
    (void)worker;
    for (size_t n = begin; n < end; n++) {
        waiting *s = &w->batch[n];
        s->result  = run_control_is_cancelled()   ? VXS_E_INTERRUPTED
                     : context_has_memory(w->ctx) ? make_slot(w, (uint32_t)n)
                                                  : VXS_E_MEMORY;
        os_lock(&w->lock);
        s->done = 1;

        /* add all squares that are ready; if another thread is adding, that thread adds them too */
        while (w->d->add_early && s->kind != WAITING_KNOWN && !w->adding && next_is_ready(w)) {
            w->adding = 1;
            os_unlock(&w->lock);
            vxs_result r = add_square(w, w->added);
            os_lock(&w->lock);
            w->adding = 0;
            w->result = r;
            w->added++;
        }
        os_unlock(&w->lock);
    }
}

static void batch_phase(const walker *w, int phase)
{
    double seconds[2] = {0, 0};
    if (!w->d->batch) return;
    for (uint32_t n = 0; n < w->count; n++)
        for (int k = 0; k < 2; k++) seconds[k] += w->batch[n].seconds[k];
    w->d->batch(w->d->user, w->ctx, phase, w->count, seconds);
}

/* Whether the record of a known square was not sound. */
static int is_unsound(const walker *w)
{
    int unsound = 0;
    for (uint32_t n = 0; n < w->count; n++) unsound |= w->batch[n].known && w->batch[n].result == VXS_E_CORRUPT;
    return unsound;
}

/* Make the squares of the batch. VXS_E_CORRUPT: the record of a known square was not sound; all slots are released. */
static vxs_result make_batch(walker *w)
{
    w->added  = 0;
    w->result = VXS_OK;
    batch_phase(w, 0);
    parallel_for(w->ctx->threads, w->count, 1, make_slots, w);
    int unsound = is_unsound(w);
    for (uint32_t n = 0; n < w->count && unsound; n++) w->d->drop(w->d->user, n);
    batch_phase(w, 1);
    return unsound ? VXS_E_CORRUPT : VXS_OK;
}

/* Add the squares in order. */
static vxs_result add_batch(walker *w)
{
    for (; next_is_ready(w); w->added++) w->result = add_square(w, w->added);
    batch_phase(w, 2);
    w->count = 0;
    return w->result;
}

/* Make and add the squares of the batch; none of them is known. */
static vxs_result end_batch(walker *w)
{
    vxs_result made = VXS_OK;
    if (w->count) {
        make_batch(w);
        made = add_batch(w);
    }
    steps_done(w->ctx, w->steps);
    w->steps     = 0;
    vxs_result r = context_check(w->ctx);
    return r == VXS_OK ? made : r;
}

/* Append a square to the batch. The squares of one record must fit into one batch. */
static vxs_result wait_with(walker *w, const waiting *s)
{
    vxs_result r = w->count < DESCENT_BATCH ? VXS_OK : w->record ? VXS_E_ARGUMENT : end_batch(w);
    if (r == VXS_OK) w->batch[w->count++] = *s;
    return r;
}

/* Progress steps of a square: one for each square of fetch_px. */
static uint32_t steps_of(const walker *w, uint32_t level)
{
    uint32_t across = (8u << level) / w->columns->fetch_px;
    return across * across;
}

static vxs_result visit(walker *w, uint32_t level, uint32_t i, uint32_t j);

/* known squares --------------------------------------------------------------------------------------------------------------- */

/* Complete the record, with what was built, and store it. */
static vxs_result record_end(walker *w, square_record *record, vxs_result r)
{
    const square_cache *cache = w->columns->cache;
    vxs_bytes           bytes = {0};
    if (r == VXS_OK && cache) r = record_write(record, w->frames, w->built_bytes, &bytes);
    if (r == VXS_OK && cache) r = cache->store(cache->data, &bytes, w->ctx);
    for (uint32_t n = 0; n < DESCENT_BATCH; n++) free(w->frames[n].data);
    memset(w->frames, 0, sizeof w->frames);
    free(bytes.data);
    record_free(record);
    w->record = NULL;
    return r;
}

/* Settle the steps that were settled before. Their bounds must still settle them. */
static vxs_result settle_known(const walker *w, const square_record *known)
{
    vxs_result r = VXS_OK;
    for (const record_step *s = known->steps; s < known->steps + known->count && r == VXS_OK; s++) {
        if (s->is_built) continue;
        if (w->d->classify(w->d->user, &s->bounds, s->level, 1) != DESCENT_SETTLED)
            return VXS_E_VERSION; /* sound, but from another version */
        r = w->d->settle(w->d->user, &s->bounds, s->level, s->i, s->j);
    }
    return r;
}

/* Restore a square from its record. VXS_E_CORRUPT: the record is not sound, and nothing was added. */
static vxs_result recall(walker *w, uint32_t level, uint32_t i, uint32_t j, const vxs_bytes *bytes)
{
    square_record known = {0};
    vxs_result    r     = record_read(&known, bytes->data, bytes->size_bytes, level, i, j, w->columns->depth_vx);
    if (r == VXS_OK && known.built_count > DESCENT_BATCH) r = VXS_E_CORRUPT;
    for (const record_step *s = known.steps; s < known.steps + known.count && r == VXS_OK; s++)
        if (s->is_built)
            w->batch[w->count++] = (waiting){.kind = WAITING_KNOWN, .level = s->level, .i = s->i, .j = s->j, .known = s};
    if (r == VXS_OK && w->count) r = make_batch(w);
    if (r == VXS_OK) r = settle_known(w, &known);
    if (r == VXS_OK && w->count) r = add_batch(w);
    w->count = 0;
    record_free(&known);
    return r;
}

/* new squares ----------------------------------------------------------------------------------------------------------------- */

/* Fetch a square, and descend into it. */
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
    if (r == VXS_OK) r = end_batch(w);
    w->fetched = NULL;
    w->columns->release(w->columns->data, &square);
    return r;
}

/* Side of the parts of a square that building threads fetch; 0: they do not. */
static uint32_t part_px(const walker *w, uint32_t level)
{
    uint32_t side = min_u32(8u << level, w->d->square_px);
    return side <= w->columns->parallel_px ? side : 0;
}

/* Put the parts of a square into the batch; the building threads fetch them. */
static vxs_result fetch_parts(walker *w, uint32_t level, uint32_t i, uint32_t j, uint32_t side)
{
    uint32_t   part = square_level(side), across = 1u << (level - part);
    vxs_result r = VXS_OK;
    for (uint32_t n = 0; n < across * across && r == VXS_OK; n++) {
        z_place at = z_order(n);
        r = wait_with(w, &(waiting){.kind = WAITING_FETCHED, .level = part, .i = i * across + at.i, .j = j * across + at.j});
    }
    return r == VXS_OK && w->record ? end_batch(w) : r;
}

/* the descent ----------------------------------------------------------------------------------------------------------------- */

static vxs_result bounds_of(const walker *w, uint32_t level, uint32_t i, uint32_t j, column_bounds *out)
{
    if (!w->fetched) {
        const square_cache *cache = w->columns->cache;
        vxs_result          r     = w->columns->bounds(w->columns->data, level, i, j, out);
        return r == VXS_OK && cache && cache->note ? cache->note(cache->data, out) : r;
    }
    uint32_t inner = w->fetched_level - level;
    return w->fetched->bounds(w->fetched->data, level, i - (w->fetched_i << inner), j - (w->fetched_j << inner), out);
}

/* Make a square that cannot be settled as a whole before a fetch. */
static vxs_result make_square(walker *w, uint32_t level, uint32_t i, uint32_t j)
{
    const square_cache *cache  = w->columns->cache;
    square_action       action = SQUARE_MAKE;
    vxs_bytes           known  = {0};
    vxs_result          r      = cache ? end_batch(w) : VXS_OK;
    ++*w->d->squares_fetched;
    w->steps += steps_of(w, level);
    if (r == VXS_OK && cache) r = cache->find(cache->data, w->columns, level, i, j, &action, &known, w->ctx);
    if (r == VXS_OK && action == SQUARE_KNOWN) r = recall(w, level, i, j, &known);
    free(known.data);
    if ((r == VXS_OK && action == SQUARE_MAKE) || (r == VXS_E_CORRUPT && action == SQUARE_KNOWN)) {
        square_record record = {0};
        uint32_t      side   = part_px(w, level);
        w->record            = cache ? &record : NULL;
        r                    = side ? fetch_parts(w, level, i, j, side) : fetch(w, level, i, j);
        r                    = record_end(w, &record, r);
    }
    return r == VXS_OK && cache ? end_batch(w) : r;
}

/* Descend into the square (i, j) of `level` of the map. */
static vxs_result visit(walker *w, uint32_t level, uint32_t i, uint32_t j)
{
    waiting    s = {.level = level, .i = i, .j = j};
    vxs_result r = bounds_of(w, level, i, j, &s.bounds);
    if (r != VXS_OK) return r;
    descent_step step = w->d->classify(w->d->user, &s.bounds, level, w->fetched != NULL);
    if (step == DESCENT_SETTLED) {
        s.kind = WAITING_SETTLED;
        if (!w->fetched) w->steps += steps_of(w, level);
        return wait_with(w, &s);
    }
    if (!w->fetched && 8u << level <= w->columns->fetch_px) return make_square(w, level, i, j);
    if (w->fetched && step == DESCENT_BUILD) {
        uint32_t inner = w->fetched_level - level;
        s.kind         = WAITING_BUILT;
        s.inner_i      = i - (w->fetched_i << inner);
        s.inner_j      = j - (w->fetched_j << inner);
        return wait_with(w, &s);
    }
    for (uint32_t c = 0; c < 4 && r == VXS_OK; c++) r = visit(w, level - 1, 2 * i + (c & 1), 2 * j + (c >> 1));
    return r;
}

vxs_result descend(const descent *d, const column_map *columns, bake_context *ctx)
{
    walker w = {.d = d, .columns = columns, .ctx = ctx};
    os_mutex_init(&w.lock);
    vxs_result r = visit(&w, square_level(columns->side_px), 0, 0);
    if (r == VXS_OK) r = end_batch(&w);
    os_mutex_free(&w.lock);
    return r;
}
