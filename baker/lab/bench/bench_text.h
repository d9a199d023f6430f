/* Measurements as text: figures, tables of them, names of cells.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BENCH_TEXT_H
#define BENCH_TEXT_H

#include <stdio.h>

#include "baker/lab/bench/bench_json.h"

enum { BENCH_FIGURES_MAX = 192 };

typedef enum figure_kind { FIGURE_SECONDS, FIGURE_BYTES, FIGURE_PEAK_BYTES, FIGURE_COUNT, FIGURE_SHARE } figure_kind;

/* How a figure is used, besides comparing it. */
typedef enum figure_flags {
    FIGURE_COLUMN  = 1, /* a column of the table */
    FIGURE_LIMITED = 2, /* it may be too slow */
    FIGURE_STAGE   = 4, /* a part of the cell's first figure */
    FIGURE_ERROR   = 8  /* comparable only between runs with the same points */
} figure_flags;

typedef struct bench_figure {
    char        name[96]; /* "RMSE 9 x 9, surface" */
    figure_kind kind;
    unsigned    flags;
    spread      value; /* seconds, bytes, number, share of 1; all members are equal for a single value */
} bench_figure;

/* Collect the figures of a cell.
 * figures  [BENCH_FIGURES_MAX] [out]; the first is the time of the bake
 * Returns their number. */
size_t bench_figures(const json_t *cell, bench_figure *figures);

/* Print a row for each cell: medians with minimum and maximum. Returns VXS_OK or VXS_E_MEMORY. */
vxs_result bench_print(FILE *to, const json_t *result, message *m);

/* The options that distinguish a cell from the others of its result: "city.glb, 512 texels, exit back", truncated to size.
 * Returns text. */
const char *bench_cell_name(char *text, size_t size, const json_t *result, const json_t *cell);

/* "940 ms (931 to 962)", in a suitable unit; "940 ms" if all are equal. Returns text. */
const char *spread_text(char text[64], spread seconds);

/* Append a cell to a table, in one line. table: an array of texts, row by row. */
void table_add(json_t *table, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* Print a table, and release it. Columns are as wide as their content; the first is left-aligned, the others right-aligned.
 * Returns VXS_OK; or VXS_E_MEMORY when a value is missing in it: then nothing is printed. */
vxs_result table_print(json_t *table, size_t columns, FILE *to, message *m);

#endif
