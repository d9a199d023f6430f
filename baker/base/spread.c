/* Statistics of repeated measurements; see spread.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/base/spread.h"

#include <stdlib.h>

static int compare_doubles(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

spread spread_of(double *values, uint32_t count)
{
    qsort(values, count, sizeof *values, compare_doubles);
    return (spread){.median = (values[(count - 1) / 2] + values[count / 2]) / 2, .min = values[0], .max = values[count - 1]};
}
