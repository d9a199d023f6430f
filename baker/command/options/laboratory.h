/* What the laboratory (baker/lab) adds to a program: commands, OpenGL for --maps gl, pages for --report. A program is linked with
 * baker/lab/laboratory.c, or without the laboratory (make core=1) with no_laboratory.c.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef LABORATORY_H
#define LABORATORY_H

#include "baker/bake/bake.h"

/* argv[0] is the command's own name; the result is the exit status (docs/manual.md). */
typedef struct command_entry {
    const char *name;
    int (*run)(int argc, char **argv);
} command_entry;

/* Data for a page, kept from a bake, which is released before the page is written. Zero it first. */
typedef struct bake_page {
    uint8_t *rgb; /* picture of the shadows; owned; NULL: not drawn */
} bake_page;

/* Pages of bakes; see baker/lab/pages/page.h. */
typedef struct bake_pages {
    vxs_result (*on_complete)(void *page, const bake_options *o, const casters *c, vxs_bytes *file, run_context *m);
    vxs_result (*write)(const char *path, const bake_page *page, const bake_options *o, const bake_report *r, run_context *m);
    void (*free)(bake_page *page);
} bake_pages;

typedef struct laboratory {
    const command_entry   *commands; /* ends with a NULL name */
    const column_renderer *renderer; /* NULL: none */
    const bake_pages      *pages;    /* NULL: none */
} laboratory;

extern const laboratory linked_laboratory;

#endif
