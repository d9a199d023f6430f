/* From the least to the greatest of some values.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef RANGE_H
#define RANGE_H

#include <math.h>

typedef struct range {
    double min, max; /* min > max: of nothing */
} range;

static const range RANGE_NOTHING = {INFINITY, -INFINITY};

static inline void range_add(range *r, double value)
{
    r->min = fmin(r->min, value);
    r->max = fmax(r->max, value);
}

#endif
