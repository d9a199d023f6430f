/* The page about one bake: what `vxs bake --report` writes.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BAKE_PAGE_H
#define BAKE_PAGE_H

#include "baker/bake/bake.h"

/* Write the page: the report as JSON, and pictures of the largest lights. path "-" is standard output.
 * Returns VXS_OK, VXS_E_WRITE, VXS_E_MEMORY; the file is complete under its name, or untouched. */
vxs_result bake_page_write(const char *path, const bake_options *o, const bake_report *r, message *m);

#endif
