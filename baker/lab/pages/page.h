/* A self-contained page: the frame page.html with data, a script that displays it, and page.js, which all scripts use. Pages
 * need no network and no other file. The page of a bake has its JSON, and pictures of its maps and of its shadows.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef PAGE_H
#define PAGE_H

#include <jansson.h>

#include "baker/base/run_context.h"
#include "baker/command/options/laboratory.h"

/* The content of a page, which selects its script. */
typedef enum page_kind {
    PAGE_BAKE,   /* bake_page.js */
    PAGE_BENCH,  /* bench_page.js, with charts.js and the chart library */
    PAGE_VOLUMES /* volumes_page.js, with them */
} page_kind;

/* Write a page; path "-" is standard output.
 * data  as described at the head of the script; released. NULL: out of memory
 * Returns VXS_OK, VXS_E_WRITE, VXS_E_MEMORY; the file is complete under its name, or unchanged. */
vxs_result page_write(const char *path, page_kind kind, json_t *data, run_context *m);

/* Observe a bake (bake_observer): draw its shadows, unless that needs more memory than the bake may use. */
vxs_result bake_page_look(void *page, const bake_options *o, const casters *c, vxs_bytes *file, run_context *m);

/* Write the page. path  "-" is standard output.   Returns VXS_OK, VXS_E_WRITE or VXS_E_MEMORY. */
vxs_result bake_page_write(const char *path, const bake_page *page, const bake_options *o, const bake_report *r, run_context *m);

/* Accepts a zeroed object. */
void bake_page_free(bake_page *page);

#endif
