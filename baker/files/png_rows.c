/* Rows of a PNG; see png_rows.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/files/png_rows.h"

#include <png.h>
#include <stdint.h>
#include <stdlib.h>

#ifdef PNG_WRITE_SUPPORTED

struct png_rows {
    png_struct  *png;
    png_info    *info;
    output_file *out;
    run_context *run;
    vxs_result   result; /* of the last write */
    uint32_t     width_px;
    uint8_t     *row; /* [2 * width_px] big endian */
};

/* libpng goes back to setjmp after an error: here, for one of the file, with its result stored. */
static void write_bytes(png_struct *png, png_byte *bytes, size_t size)
{
    png_rows *p = png_get_io_ptr(png);
    p->result   = output_file_write(p->out, bytes, size, p->run);
    if (p->result != VXS_OK) png_error(png, "");
}

static void flush_nothing(png_struct *png)
{
    (void)png;
}

static void ignore(png_struct *png, const char *text)
{
    (void)png, (void)text;
}

static void leave(png_struct *png, const char *text)
{
    (void)text;
    png_longjmp(png, 1);
}

static vxs_result failed(const png_rows *p, run_context *m)
{
    return p->result != VXS_OK ? p->result : fail(m, VXS_E_MEMORY, "out of memory for a PNG");
}

vxs_result png_rows_open(png_rows **out_rows, output_file *out, uint32_t width_px, uint32_t height_px, run_context *m)
{
    png_rows *p = calloc(1, sizeof *p);
    *out_rows   = p;
    if (!p) return fail(m, VXS_E_MEMORY, "out of memory for a PNG");
    p->out      = out;
    p->run      = m;
    p->width_px = width_px;
    p->row      = malloc(2 * (size_t)width_px);
    p->png      = png_create_write_struct(PNG_LIBPNG_VER_STRING, NULL, leave, ignore);
    p->info     = p->png ? png_create_info_struct(p->png) : NULL;
    if (!p->row || !p->info || setjmp(png_jmpbuf(p->png))) {
        vxs_result r = failed(p, m);
        png_rows_free(p);
        *out_rows = NULL;
        return r;
    }
    png_set_write_fn(p->png, p, write_bytes, flush_nothing);
    png_set_IHDR(p->png, p->info, width_px, height_px, 16, PNG_COLOR_TYPE_GRAY, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
                 PNG_FILTER_TYPE_DEFAULT);
    png_write_info(p->png, p->info);
    return VXS_OK;
}

vxs_result png_rows_write(png_rows *p, const float *values, uint32_t rows, run_context *m)
{
    if (setjmp(png_jmpbuf(p->png))) return failed(p, m);
    for (uint32_t y = 0; y < rows; y++) {
        for (uint32_t x = 0; x < p->width_px; x++) {
            unsigned value    = (unsigned)(65535 * (double)values[(size_t)y * p->width_px + x] + 0.5);
            p->row[2 * x]     = (uint8_t)(value >> 8);
            p->row[2 * x + 1] = (uint8_t)value;
        }
        png_write_row(p->png, p->row);
    }
    return VXS_OK;
}

vxs_result png_rows_end(png_rows *p, run_context *m)
{
    if (setjmp(png_jmpbuf(p->png))) return failed(p, m);
    png_write_end(p->png, p->info);
    return VXS_OK;
}

void png_rows_free(png_rows *p)
{
    if (!p) return;
    png_destroy_write_struct(&p->png, &p->info);
    free(p->row);
    free(p);
}

#else

vxs_result png_rows_open(png_rows **out_rows, output_file *out, uint32_t width_px, uint32_t height_px, run_context *m)
{
    (void)out, (void)width_px, (void)height_px;
    *out_rows = NULL;
    return fail(m, VXS_E_ARGUMENT, "this build of vxs writes no PNG: choose --format raw");
}

vxs_result png_rows_write(png_rows *p, const float *values, uint32_t rows, run_context *m)
{
    (void)p, (void)values, (void)rows, (void)m;
    return VXS_E_ARGUMENT;
}

vxs_result png_rows_end(png_rows *p, run_context *m)
{
    (void)p, (void)m;
    return VXS_E_ARGUMENT;
}

void png_rows_free(png_rows *p)
{
    (void)p;
}

#endif
