/* Who makes which square of a bake that several ranks make together.
 *
 * Every rank goes through the maps once, forward. Rank 0 adds all squares in their order, and makes squares itself, too: one of as many as
 * there are ranks is left for it. So it does not wait while others make what it comes to next. Who is done with a square is given the next
 * one, so that ranks need not be alike. Where rank 0 lags behind, others make its squares as well; where it lags far behind, they wait, since
 * what they have made is held in memory until it is added.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef DESK_H
#define DESK_H

#include "baker/columns/columns.h"
#include "formats/vxs_file.h"

/* A square that was given to somebody. */
typedef struct desk_square {
    uint32_t   rank;
    int        is_here, made; /* of others: it has come; it was made in this run */
    column_key key;
    vxs_bytes  record; /* owned */
} desk_square;

/* Zero it but for ranks. */
typedef struct desk {
    uint32_t     ranks;
    uint64_t     at;      /* the square that rank 0 has come to */
    desk_square *squares; /* [count] */
    size_t       count, capacity;
} desk;

enum {
    DESK_WAIT = 0, /* nothing yet: ask again when rank 0 has gone on */
    DESK_GIVEN,
    DESK_MEMORY,
};

/* The next square for another rank. Returns one of the above. */
int desk_next(desk *d, uint32_t rank, uint64_t *number);

/* Rank 0 has come to a square: the one of that number is its own, unless another rank has it. NULL: no memory. */
desk_square *desk_arrive(desk *d, uint64_t number);

/* A square that a rank has handed over. NULL: it was not given that one, or has done so before. */
desk_square *desk_deliver(desk *d, uint64_t number, uint32_t rank);

/* Accepts a zeroed object. */
void desk_free(desk *d);

#endif
