/* Descent from the whole map to squares that can be built: the first stage of every coding of columns.
 *
 * If the bounds of a square settle it, the square is added with these bounds. Other squares are fetched, in squares as wide as the
 * source allows, and are split further until they are small enough to be built. All threads build squares at once. Squares are
 * added in z order: after a batch of them, or while others are still being built (descent_batch.h). If the source supports
 * parallel fetches, each thread fetches the squares that it builds. With a square cache (square_record.h), a known square is
 * neither fetched nor built; what was built of it is added in the same order.
 * Source: [CPVS16] 4.3, 6.1.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef DESCENT_H
#define DESCENT_H

#include "baker/columns/columns.h"
#include "formats/vxs_write_file.h"

enum {
    DESCENT_SLOTS = 256, /* the most slots for built squares */
    DESCENT_HELD  = 32,  /* the most squares that are built before the first of them is added, without add_early; and the most in a
                            fetched square with a square cache */
};

/* Slots that a descent uses: squares in memory at once. */
static inline uint32_t descent_slots(uint32_t threads)
{
    return min_u32(max_u32(DESCENT_HELD, 16 * threads), DESCENT_SLOTS);
}

/* What the descent does with a square. */
typedef enum descent_step {
    DESCENT_SETTLED, /* its bounds are enough */
    DESCENT_BUILD,   /* build it as a whole; before it is fetched, the same as DESCENT_SPLIT */
    DESCENT_SPLIT,   /* go on with its quarters */
} descent_step;

typedef struct descent {
    void *user;

    uint32_t  square_px;       /* least side of the squares that are built */
    uint64_t *squares_fetched; /* [in, out] count of fetched squares, of fetch_px or the whole map; added to */

    /* Decide about a square of `level` by its bounds.   fetched  1: bounds of fetched columns, 0: bounds known before the fetch.
     * Threads: any. */
    descent_step (*classify)(const void *user, const column_bounds *bounds, uint32_t level, int fetched);

    /* Add the square (i, j) of `level` of the map; its bounds settle it. Called in z order together with add. */
    vxs_result (*settle)(void *user, const column_bounds *bounds, uint32_t level, uint32_t i, uint32_t j);

    /* Build the square (i, j) of `level`, counted from the corner of the fetched columns. Called once for each slot, [0,
     * DESCENT_SLOTS), before that slot is added.   Threads: any. */
    vxs_result (*build)(void *user, uint32_t slot, const column_square *columns, uint32_t level, uint32_t i, uint32_t j);

    /* Add what was built in a slot; level, i, j are those of the map. Called in z order, one call at a time, and not after a
     * failed build. */
    vxs_result (*add)(void *user, uint32_t slot, uint32_t level, uint32_t i, uint32_t j);

    /* save: what was built in a slot, as bytes, before it is added. load: the reverse, instead of a build; level, i, j are those of
     * the map. Each is called once for each slot. load returns VXS_E_CORRUPT for bytes that save did not write.   Threads: any.
     * out  [out] zeroed; released by the caller with free(out->data) */
    vxs_result (*save)(void *user, uint32_t slot, vxs_bytes *out);
    vxs_result (*load)(void *user, uint32_t slot, const vxs_bytes *bytes, uint32_t level, uint32_t i, uint32_t j);

    /* Release the contents of a slot, in any state. */
    void (*drop)(void *user, uint32_t slot);

    /* Called for a batch in phase 0: before building; 1: between building and adding; 2: after adding. Time stages here. May be
     * NULL.
     * seconds  sum over all threads since the batch began: [0] of fetches by these threads, [1] of builds */
    void (*batch)(void *user, bake_context *ctx, int phase, uint32_t count, const double seconds[2]);

    /* 1: any thread calls add as soon as a square and all squares before it are built; then no work is allowed between building
     * and adding. */
    int add_early;
} descent;

/* Descend a map.
 * ctx  threads; one step of progress is done for each square of fetch_px
 * Returns VXS_OK, or what a callback or the columns return. On failure the user releases what was built and not added. */
vxs_result descend(const descent *d, const column_map *columns, bake_context *ctx);

#endif
