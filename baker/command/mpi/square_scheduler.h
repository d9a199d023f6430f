/* Distributes the squares of a bake to the ranks of an MPI job.
 *
 * Every rank goes through the maps once, forward. Rank 0 adds all squares in their order. It also makes squares: of each `ranks`
 * squares one is left for it, so that it does not wait while others make the squares that it needs next. A rank that has
 * finished a square gets the next one, so ranks need not be equally fast. When rank 0 is late, others make its squares, too.
 * When it is very late, they wait, since finished squares are held in memory until they are added.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SQUARE_SCHEDULER_H
#define SQUARE_SCHEDULER_H

#include "baker/columns/columns.h"
#include "formats/vxs_write_file.h"

/* A square that a rank makes. */
typedef struct scheduled_square {
    uint32_t   rank;
    int        is_here, made; /* of other ranks: it was delivered; it was made in this run, not read from a cache */
    column_key key;
    vxs_bytes  record; /* owned */
} scheduled_square;

/* Zero it but for ranks. */
typedef struct square_scheduler {
    uint32_t          ranks;
    uint64_t          at;      /* the current square of rank 0 */
    scheduled_square *squares; /* [count] */
    size_t            count, capacity;
} square_scheduler;

enum {
    SCHEDULER_WAIT = 0, /* none now: call again when rank 0 has advanced */
    SCHEDULER_GIVEN,
    SCHEDULER_MEMORY,
};

/* The next square for another rank. Returns one of the above. */
int square_scheduler_next(square_scheduler *d, uint32_t rank, uint64_t *number);

/* Rank 0 has reached a square. It makes the square itself, unless another rank has it. NULL: out of memory. */
scheduled_square *square_scheduler_take(square_scheduler *d, uint64_t number);

/* A rank delivers a square. NULL: the square was not assigned to it, or is delivered already. */
scheduled_square *square_scheduler_deliver(square_scheduler *d, uint64_t number, uint32_t rank);

/* Accepts a zeroed object. */
void square_scheduler_free(square_scheduler *d);

#endif
