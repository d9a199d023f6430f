/* A self-contained page: the frame page.html with data, a script that displays it, and page.js, which all scripts use. Pages
 * need no network and no other file.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef PAGE_H
#define PAGE_H

#include <jansson.h>

#include "baker/base/message.h"

/* The content of a page, which selects its script. */
typedef enum page_kind {
    PAGE_BAKE,   /* bake_page.js */
    PAGE_BENCH,  /* bench_page.js, with charts.js and the chart library */
    PAGE_VOLUMES /* volumes_page.js, with them */
} page_kind;

/* Write a page; path "-" is standard output.
 * data  as described at the head of the script; released. NULL: out of memory
 * Returns VXS_OK, VXS_E_WRITE, VXS_E_MEMORY; the file is complete under its name, or unchanged. */
vxs_result page_write(const char *path, page_kind kind, json_t *data, message *m);

#endif
