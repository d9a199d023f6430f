/* Plots, drawn by gnuplot: a program that is started when a plot is made, and needed for nothing else.
 *
 *     plot p = {0};
 *     FILE *to = plot_begin(&p, "growth-bytes", 480, 340);
 *     fprintf(to, ...);                            // axes, data blocks and one plot command, in gnuplot's language
 *     r = plot_end(&p, m);                         // p.svg is the drawing
 *
 * A script holds numbers, own words, and text from files through plot_text. gnuplot runs what stands in backquotes and calls of
 * system(): neither is possible in what plot_text prints.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef PLOT_H
#define PLOT_H

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "baker/base/message.h"

typedef struct plot {
    char     name[64];      /* of its files, without folder and suffix */
    char     title[256];    /* what is seen: clean text */
    char     caption[512];  /* how to read it: clean text */
    uint32_t width, height; /* CSS pixels */
    char    *script, *svg;  /* owned */
    size_t   script_bytes, svg_bytes;
    FILE    *to; /* the script while it is written */
} plot;

/* Colours that a page replaces by its own, for light and dark paper. */
#define PLOT_INK  "#22221f"
#define PLOT_SOFT "#66645d"
#define PLOT_RULE "#dcd9cf"

/* Start a script: size, font, colours, grid. NULL without memory: plot_end says so. */
FILE *plot_begin(plot *p, const char *name, uint32_t width, uint32_t height);

/* Room below the axis for its label and `key_rows` rows of a key. Returns how high it is in CSS pixels. */
uint32_t plot_bottom(FILE *to, size_t key_rows);

/* Close the script and draw it as SVG.
 * Returns VXS_OK; VXS_E_PROGRAM when gnuplot is not there or fails: one line says which; VXS_E_MEMORY. */
vxs_result plot_end(plot *p, message *m);

/* Print the drawing into a page, in the page's ink. number: of the plot in the page, so that no two things have one name. */
void plot_print_inline(const plot *p, FILE *to, unsigned number);

/* Write NAME.svg and NAME.png, with the title in them, to a folder. Returns VXS_OK, VXS_E_WRITE, VXS_E_PROGRAM (as plot_end),
 * VXS_E_MEMORY. */
vxs_result plot_write(const plot *p, const char *folder, message *m);

/* Accepts a zeroed object. */
void plot_free(plot *p);

/* Text of anybody in single quotes, of at most `most` characters, as gnuplot takes it and XML may hold it; an apostrophe becomes ’. */
void plot_text(FILE *to, const char *text, size_t most);

/* A tic of an axis: the same text, which gnuplot takes for a format there, at a place. */
void plot_tic(FILE *to, const char *text, size_t most, double at);

/* series ---------------------------------------------------------------------------------------------------------------------- */

/* One colour a scene, one mark a setting, one dash a file. They repeat after 8, 12 and 5. */
const char *plot_colour(uint32_t scene); /* "#3d7ab8" */
int         plot_mark(uint32_t setting);
int         plot_dash(uint32_t file);

#endif
