/* Bounds of the parts of a square; see columns.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/columns/columns.h"

#include "baker/base/parallel.h"

enum { ROWS_TO_SHARE = 128 }; /* levels with fewer rows are faster on one thread */

/* Compute a level from the finer one. */
typedef struct reduction {
    const column_bounds *finer;
    column_bounds       *level;
    uint32_t             side;
} reduction;

static void reduce_rows(void *user, size_t begin, size_t end, uint32_t worker)
{
    const reduction *r = user;
    (void)worker;
    for (size_t j = begin; j < end; j++)
        for (size_t i = 0; i < r->side; i++) {
            const column_bounds *near = r->finer + 4 * j * r->side + 2 * i, *next = near + (size_t)2 * r->side;
            r->level[j * r->side + i] = bounds_of_four(near, next);
        }
}

void bounds_pyramid_reduce(column_bounds *const *pyramid, uint32_t tiles, uint32_t threads)
{
    for (uint32_t l = 1, side = tiles / 2; side; side /= 2, l++)
        parallel_for(side >= ROWS_TO_SHARE ? threads : 1, side, ROWS_TO_SHARE / 2, reduce_rows,
                     &(reduction){pyramid[l - 1], pyramid[l], side});
}
