/* Statistics of repeated measurements, and the order of doubles for qsort.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SPREAD_H
#define SPREAD_H

#include <stdint.h>

typedef struct spread {
    double median, min, max;
} spread;

static inline int doubles_ascending(const void *a, const void *b)
{
    double p = *(const double *)a, q = *(const double *)b;
    return (p > q) - (p < q);
}

/* values  [count], count > 0; sorted in place */
spread spread_of(double *values, uint32_t count);

#endif
