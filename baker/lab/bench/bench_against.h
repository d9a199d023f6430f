/* Changes between two measurements.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BENCH_AGAINST_H
#define BENCH_AGAINST_H

#include <jansson.h>
#include <stdio.h>

#include "baker/base/message.h"

/* Print the differences: first of versions and machines, then of the cells that both have. A time has changed when each median
 * is outside of the other's spread; with five runs each, chance does this once in twenty. Sizes and errors have changed when
 * they differ at all; peak memory, which always varies, by 5 %.
 * to           NULL: print nothing
 * before_path  the earlier file's name in messages
 * max_slower   ratio of times
 * too_slow     [out] number of baking or lookup times that changed to more than max_slower times the earlier ones
 * Returns VXS_OK or VXS_E_MEMORY. */
vxs_result bench_against(FILE *to, const json_t *now, const json_t *before, const char *before_path, double max_slower,
                         size_t *too_slow, message *m);

#endif
