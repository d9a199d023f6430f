/* Distributes squares to ranks; see square_scheduler.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/command/mpi/square_scheduler.h"

#include <stdlib.h>

#include "baker/base/array.h"

/* How far other ranks may be ahead of rank 0, in squares for each rank: before they also make rank 0's squares, and before they
 * wait. */
enum { AHEAD = 2, FAR_AHEAD = 32 };

static int give_next(square_scheduler *d, uint32_t rank)
{
    if (!array_reserve(&d->squares, &d->capacity, d->count + 1, sizeof *d->squares)) return 0;
    d->squares[d->count++] = (scheduled_square){.rank = rank};
    return 1;
}

int square_scheduler_next(square_scheduler *d, uint32_t rank, uint64_t *number)
{
    int for_zero = d->count % d->ranks == 0 && d->count < d->at + AHEAD * (uint64_t)d->ranks;
    if (for_zero && !give_next(d, 0)) return SCHEDULER_MEMORY;
    if (d->count >= d->at + FAR_AHEAD * (uint64_t)d->ranks) return SCHEDULER_WAIT;
    *number = d->count;
    return give_next(d, rank) ? SCHEDULER_GIVEN : SCHEDULER_MEMORY;
}

scheduled_square *square_scheduler_take(square_scheduler *d, uint64_t number)
{
    d->at = number;
    while (d->count <= number)
        if (!give_next(d, 0)) return NULL;
    return &d->squares[number];
}

scheduled_square *square_scheduler_deliver(square_scheduler *d, uint64_t number, uint32_t rank)
{
    scheduled_square *s = number < d->count ? &d->squares[number] : NULL;
    return s && s->rank == rank && !s->is_here ? s : NULL;
}

void square_scheduler_free(square_scheduler *d)
{
    for (size_t n = 0; n < d->count; n++) free(d->squares[n].record.data);
    free(d->squares);
    *d = (square_scheduler){.ranks = 0};
}
