/* Who makes which square; see desk.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/command/mpi/desk.h"

#include <stdlib.h>

#include "baker/base/array.h"

/* Squares of each rank that the others may be ahead of rank 0: before they make its squares, and before they wait. */
enum { AHEAD = 2, FAR_AHEAD = 32 };

static int give_next(desk *d, uint32_t rank)
{
    if (!array_reserve(&d->squares, &d->capacity, d->count + 1, sizeof *d->squares)) return 0;
    d->squares[d->count++] = (desk_square){.rank = rank};
    return 1;
}

static int is_left_for_zero(const desk *d, uint64_t number)
{
    return number % d->ranks == 0 && number < d->at + AHEAD * (uint64_t)d->ranks;
}

int desk_next(desk *d, uint32_t rank, uint64_t *number)
{
    if (is_left_for_zero(d, d->count) && !give_next(d, 0)) return DESK_MEMORY;
    if (d->count >= d->at + FAR_AHEAD * (uint64_t)d->ranks) return DESK_WAIT;
    *number = d->count;
    return give_next(d, rank) ? DESK_GIVEN : DESK_MEMORY;
}

desk_square *desk_arrive(desk *d, uint64_t number)
{
    d->at = number;
    while (d->count <= number)
        if (!give_next(d, 0)) return NULL;
    return &d->squares[number];
}

desk_square *desk_deliver(desk *d, uint64_t number, uint32_t rank)
{
    desk_square *s = number < d->count ? &d->squares[number] : NULL;
    return s && s->rank == rank && !s->is_here ? s : NULL;
}

void desk_free(desk *d)
{
    for (size_t n = 0; n < d->count; n++) free(d->squares[n].record.data);
    free(d->squares);
    *d = (desk){.ranks = 0};
}
