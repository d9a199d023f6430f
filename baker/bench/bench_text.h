/* Measurements in words.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BENCH_TEXT_H
#define BENCH_TEXT_H

#include <stdio.h>

#include "baker/bench/bench.h"

/* A row for each cell, medians with least and greatest.
 * Returns VXS_OK or VXS_E_MEMORY. */
vxs_result bench_print(FILE *to, const bench_result *result, message *m);

/* "city.glb, 512 texels, exit back": what tells a cell from the others of its result, cut to what fits. Returns text. */
const char *bench_cell_name(char *text, size_t size, const bench_result *result, const bench_cell *cell);

/* "940 ms (931 to 962)", in the unit that fits; "940 ms" where all are the same. Returns text. */
const char *spread_text(char text[64], const spread *seconds);

#endif
