/* Squares that the descent has found, in z order, on their way to being built and added; see descent.h.
 *
 * Threads take squares in order. What a thread has built waits in a slot until all squares before it are added; a thread that comes
 * too far ahead waits for a slot. One thread at a time adds, while others build.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef DESCENT_BATCH_H
#define DESCENT_BATCH_H

#include "baker/base/threads.h"
#include "baker/columns/descent.h"
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
    uint32_t     steps;            /* of progress, which are done when it is added */
    uint64_t     turn;             /* squares before it, in this and all past batches, that have slots */
    uint32_t     slot;
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
    waiting             *batch; /* [count] */
    size_t               count, capacity;
    uint64_t             turns; /* squares with slots that were put into batches */
    uint32_t             steps; /* steps of progress that the next square or the end of the batch completes */

    /* record of the fetched square for the square cache; NULL: none */
    square_record *record;
    vxs_bytes      frames[DESCENT_HELD]; /* of the squares of the batch: what was built, packed */
    uint64_t       built_bytes[DESCENT_HELD];

    /* shared by the threads of a batch, under the lock: one thread at a time adds squares, in order, while others build */
    os_mutex   lock;
    os_signal  moved; /* squares were added while a thread waited for a slot */
    uint32_t   waiters;
    size_t     added;
    int        adding;
    uint32_t   added_steps; /* steps of progress that are not reported yet */
    vxs_result result;      /* first error of the added squares, or VXS_OK */
} walker;

void batch_init(walker *w);
void batch_free(walker *w);

/* Append a square to the batch; a full batch is ended before. The squares of one record must fit into one batch. */
vxs_result batch_put(walker *w, const waiting *s);

/* Make the squares of the batch. VXS_E_CORRUPT: the record of a known square was not sound; all slots are released. */
vxs_result batch_make(walker *w);

/* Add the squares in order. */
vxs_result batch_add(walker *w);

/* Make and add the squares of the batch; none of them is known. */
vxs_result batch_end(walker *w);

#endif
