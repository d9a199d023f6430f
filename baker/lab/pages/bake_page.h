/* The page of a bake: its JSON, pictures of its maps and of its shadows, and the script that shows them.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BAKE_PAGE_H
#define BAKE_PAGE_H

#include "baker/command/options/laboratory.h"

/* Observe a bake (bake_observer): draw its shadows, unless that needs more memory than the bake may use. */
vxs_result bake_page_look(void *page, const bake_options *o, const casters *c, vxs_bytes *file, message *m);

/* Write the page. path  "-" is standard output.   Returns VXS_OK, VXS_E_WRITE or VXS_E_MEMORY. */
vxs_result bake_page_write(const char *path, const bake_page *page, const bake_options *o, const bake_report *r, message *m);

/* Accepts a zeroed object. */
void bake_page_free(bake_page *page);

#endif
