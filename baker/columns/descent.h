/* From the top of a map down to squares that can be built: what every coding of columns begins with.
 *
 * A square whose bounds settle it is added as it is. What is left is fetched, in squares as wide as the source can give, and descended
 * further, until a square is small enough to be built. Squares are built on all threads, a batch at once, and added in z order:
 * behind the batch, or while others of it are still built. Of a source that many threads may ask, each thread fetches what it builds. Where somebody keeps what becomes of fetched squares (square_keeper.h), a
 * square that is known is neither fetched nor built, and what was built is added in the same order.
 * Source: [CPVS16] 4.3, 6.1.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef DESCENT_H
#define DESCENT_H

#include "baker/columns/columns.h"
#include "formats/vxs_file.h"

enum { DESCENT_BATCH = 32 }; /* squares that are in memory at once; where squares are kept, a fetched one has no more of them */

/* What becomes of a square. */
typedef enum descent_step {
    DESCENT_SETTLED, /* its bounds are all that matters */
    DESCENT_BUILD,   /* it is small enough, or as good as small; as DESCENT_SPLIT until it is fetched */
    DESCENT_SPLIT,   /* on with its quarters */
} descent_step;

typedef struct descent {
    void *user;

    uint32_t  square_px;       /* side of the squares that are built, at least */
    uint64_t *squares_fetched; /* [in, out] how many had to be, of fetch_px or what the map has: so many more */

    /* What to do with a square of `level`, by its bounds.   fetched  1: they are bounds of fetched columns, else what is known before.
     * From any thread. */
    descent_step (*look)(const void *user, const column_bounds *bounds, uint32_t level, int fetched);

    /* Add the square (i, j) of `level` of the map, which its bounds settle. Called in z order with add. */
    vxs_result (*settle)(void *user, const column_bounds *bounds, uint32_t level, uint32_t i, uint32_t j);

    /* Build the square (i, j) of `level` of fetched columns, counted from where these start. From any thread, once for each slot,
     * [0, DESCENT_BATCH), before it is added. */
    vxs_result (*build)(void *user, uint32_t slot, const column_square *columns, uint32_t level, uint32_t i, uint32_t j);

    /* Add what was built in a slot; level, i, j as look was given them. Called in z order, once at a time, and not where building failed. */
    vxs_result (*add)(void *user, uint32_t slot, uint32_t level, uint32_t i, uint32_t j);

    /* What was built in a slot as bytes, before it is added, and back, in the place of building; level, i, j as look was given them. Each from
     * any thread, once for each slot. load returns VXS_E_CORRUPT for bytes that are none of its own.
     * out  [out] zeroed; released by the caller with free(out->data) */
    vxs_result (*save)(void *user, uint32_t slot, vxs_bytes *out);
    vxs_result (*load)(void *user, uint32_t slot, const vxs_bytes *bytes, uint32_t level, uint32_t i, uint32_t j);

    /* Release what is in a slot, whatever that is. */
    void (*drop)(void *user, uint32_t slot);

    /* Of a batch: before it is built; between building and adding; behind it. Stages of time belong there. May be NULL.
     * seconds  over all threads, since the batch began: of fetching, where threads do that; of building */
    void (*batch)(void *user, bake_context *ctx, int phase, uint32_t count, const double seconds[2]);

    /* 1: add is called from any thread, as soon as a square and all before it are built: there is nothing between building and adding. */
    int add_early;
} descent;

/* Descend a map.
 * ctx  threads; a step of progress is done for each square of fetch_px
 * Returns VXS_OK, or what a callback or the columns return; what was built and not added is the user's to release. */
vxs_result descend(const descent *d, const column_map *columns, bake_context *ctx);

#endif
