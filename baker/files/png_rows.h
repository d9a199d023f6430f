/* Write a picture of 16-bit grey as PNG, some rows at a time, into an output file.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef PNG_ROWS_H
#define PNG_ROWS_H

#include "baker/files/output_file.h"

typedef struct png_rows png_rows;

/* p  [out] NULL on failure;   out  borrowed, open until png_rows_free
 * Returns VXS_OK, VXS_E_WRITE, VXS_E_MEMORY, or VXS_E_ARGUMENT: a libpng that only reads. */
vxs_result png_rows_open(png_rows **p, output_file *out, uint32_t width_px, uint32_t height_px, run_context *m);

/* Append rows, top row first.
 * values  [rows * width_px] in [0, 1], rounded to 1/65535 */
vxs_result png_rows_write(png_rows *p, const float *values, uint32_t rows, run_context *m);

/* After the last row. */
vxs_result png_rows_end(png_rows *p, run_context *m);

/* Accepts NULL. */
void png_rows_free(png_rows *p);

#endif
