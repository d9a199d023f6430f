/* How an asset was made, in words.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef PROVENANCE_TEXT_H
#define PROVENANCE_TEXT_H

#include <stdio.h>

#include "baker/bake/provenance.h"

/* Some lines: version, scene, fingerprints, the options that were not left alone, lights that were left out. What is not known
 * is not said.
 * made  as provenance_read returns it, not NULL */
void provenance_print(FILE *to, const json_t *made);

#endif
