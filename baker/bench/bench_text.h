/* Measurements in words.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BENCH_TEXT_H
#define BENCH_TEXT_H

#include <stdio.h>

#include "baker/bench/bench_json.h"

/* A row for each cell of a result, medians with least and greatest. Returns VXS_OK or VXS_E_MEMORY. */
vxs_result bench_print(FILE *to, const json_t *result, message *m);

/* "city.glb, 512 texels, exit back": what tells a cell from the others of its result, cut to what fits. Returns text. */
const char *bench_cell_name(char *text, size_t size, const json_t *result, const json_t *cell);

/* "940 ms (931 to 962)", in the unit that fits; "940 ms" where all are the same. Returns text. */
const char *spread_text(char text[64], spread seconds);

/* "RMSE 9 x 9, surface": what an error or a lookup is of. points: NULL or "" for none. Returns text. */
const char *figure_text(char text[96], const char *name, uint64_t filter_px, const char *points);

/* The next cell of a table, in one line. table: an array of texts, row by row. */
void table_add(json_t *table, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* Print a table, columns as wide as what is in them, the first to the left, the others to the right; it is released.
 * Returns VXS_OK; or VXS_E_MEMORY when something was left out of it: then nothing is printed. */
vxs_result table_print(json_t *table, size_t columns, FILE *to, message *m);

#endif
