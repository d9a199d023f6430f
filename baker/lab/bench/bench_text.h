/* Measurements as text: figures, tables of them, names of cells; changes between two measurements.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BENCH_TEXT_H
#define BENCH_TEXT_H

#include <jansson.h>
#include <stdio.h>

#include "baker/base/run_context.h"
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
vxs_result bench_print(FILE *to, const json_t *result, run_context *m);

/* The options that distinguish a cell from the others of its result: "city.glb, 512 texels, exit back", truncated to size.
 * Returns text. */
const char *bench_cell_name(char *text, size_t size, const json_t *result, const json_t *cell);

/* "940 ms (931 to 962)", in a suitable unit; "940 ms" if all are equal. Returns text. */
const char *spread_text(char text[64], spread seconds);

/* Append a cell to a table, in one line. table: an array of texts, row by row. */
void table_add(json_t *table, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* Print a table, and release it. Columns are as wide as their content; the first is left-aligned, the others right-aligned.
 * Returns VXS_OK; or VXS_E_MEMORY when a value is missing in it: then nothing is printed. */
vxs_result table_print(json_t *table, size_t columns, FILE *to, run_context *m);

/* Print the differences: first of versions and machines, then of the cells that both have. A time has changed when each median
 * is outside of the other's spread; with five runs each, chance does this once in twenty. Sizes and errors have changed when
 * they differ at all; peak memory, which always varies, by 5 %.
 * to           NULL: print nothing
 * before_path  the earlier file's name in messages
 * max_slower   ratio of times
 * too_slow     [out] number of baking or lookup times that changed to more than max_slower times the earlier ones
 * Returns VXS_OK or VXS_E_MEMORY. */
vxs_result bench_against(FILE *to, const json_t *now, const json_t *before, const char *before_path, double max_slower,
                         size_t *too_slow, run_context *m);

#endif
