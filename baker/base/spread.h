/* Statistics of repeated measurements.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SPREAD_H
#define SPREAD_H

#include <stdint.h>

typedef struct spread {
    double median, min, max;
} spread;

/* values  [count], count > 0; sorted in place */
spread spread_of(double *values, uint32_t count);

#endif
