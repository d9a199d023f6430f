/* What moved between two measurements.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BENCH_AGAINST_H
#define BENCH_AGAINST_H

#include <jansson.h>
#include <stdio.h>

#include "baker/base/message.h"

/* Print what differs: first of versions and machines, then of the cells that both have. A time moved when each median lies outside
 * of the other's spread; by chance alone that is so of one in twenty, with five runs each. Sizes and errors moved when they differ
 * at all, peak memory, which is never quite the same, by 5 %.
 * to           NULL: print nothing
 * before_path  what messages call the earlier one
 * max_slower   ratio of times
 * too_slow     [out] how many baking or lookup times moved to more than max_slower times what they were
 * Returns VXS_OK or VXS_E_MEMORY. */
vxs_result bench_against(FILE *to, const json_t *now, const json_t *before, const char *before_path, double max_slower,
                         size_t *too_slow, message *m);

#endif
