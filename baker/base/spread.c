/* Statistics of repeated measurements; see spread.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/base/spread.h"

#include <stdlib.h>

spread spread_of(double *values, uint32_t count)
{
    qsort(values, count, sizeof *values, doubles_ascending);
    return (spread){.median = (values[(count - 1) / 2] + values[count / 2]) / 2, .min = values[0], .max = values[count - 1]};
}
