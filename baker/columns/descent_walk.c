/* The walk of a descent; see descent.h. descent_batch.c builds and adds what it finds.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <stdlib.h>
#include <string.h>

#include "baker/base/z_order.h"
#include "baker/columns/descent_batch.h"

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
    for (uint32_t n = 0; n < DESCENT_HELD; n++) free(w->frames[n].data);
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
    if (r == VXS_OK && known.built_count > DESCENT_HELD) r = VXS_E_CORRUPT;
    for (const record_step *s = known.steps; s < known.steps + known.count && r == VXS_OK; s++)
        if (s->is_built) r = batch_put(w, &(waiting){.kind = WAITING_KNOWN, .level = s->level, .i = s->i, .j = s->j, .known = s});
    if (r == VXS_OK && w->count) r = batch_make(w);
    if (r == VXS_OK) r = settle_known(w, &known);
    if (r == VXS_OK && w->count) r = batch_add(w);
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
    if (r == VXS_OK) r = batch_end(w);
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
        r = batch_put(w, &(waiting){.kind = WAITING_FETCHED, .level = part, .i = i * across + at.i, .j = j * across + at.j});
    }
    return r == VXS_OK && w->record ? batch_end(w) : r;
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
    vxs_result          r      = cache ? batch_end(w) : VXS_OK;
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
    return r == VXS_OK && cache ? batch_end(w) : r;
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
        return batch_put(w, &s);
    }
    if (!w->fetched && 8u << level <= w->columns->fetch_px) return make_square(w, level, i, j);
    if (w->fetched && step == DESCENT_BUILD) {
        uint32_t inner = w->fetched_level - level;
        s.kind         = WAITING_BUILT;
        s.inner_i      = i - (w->fetched_i << inner);
        s.inner_j      = j - (w->fetched_j << inner);
        return batch_put(w, &s);
    }
    for (uint32_t c = 0; c < 4 && r == VXS_OK; c++) r = visit(w, level - 1, 2 * i + (c & 1), 2 * j + (c >> 1));
    return r;
}

vxs_result descend(const descent *d, const column_map *columns, bake_context *ctx)
{
    walker w = {.d = d, .columns = columns, .ctx = ctx};
    batch_init(&w);
    vxs_result r = visit(&w, square_level(columns->side_px), 0, 0);
    if (r == VXS_OK) r = batch_end(&w);
    batch_free(&w);
    return r;
}
