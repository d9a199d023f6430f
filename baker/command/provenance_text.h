/* The provenance of an asset as text.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef PROVENANCE_TEXT_H
#define PROVENANCE_TEXT_H

#include <stdio.h>

#include "baker/bake/provenance.h"

/* Print some lines: version, scene, fingerprints, options that are not default, lights that were left out. Unknown values are
 * omitted.
 * made  as provenance_read returns it, not NULL */
void provenance_print(FILE *to, const json_t *made);

#endif
