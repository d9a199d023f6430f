/* Lines of reports: on an output, and on the origin of a component, as text and as JSON: the node, mesh and material of its first
 * triangle.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef REPORT_TEXT_H
#define REPORT_TEXT_H

#include <jansson.h>
#include <stdio.h>

#include "baker/scene/scene.h"

/* Print "wrote        city.png: 1280 x 720 pixels, 1.25 MiB". The size is read from the regular file at the path.
 * path  NULL: no output, print nothing; "-": standard output */
void written_print(FILE *to, const char *path, const char *what);

enum { PART_TEXT_BYTES = 512 };

/* "node 3 'lamp', mesh 2, material 1 'steel' and 2 more". Long names are cut in the middle.
 * text  [PART_TEXT_BYTES] out
 * Returns text. */
const char *part_text(char *text, const scene *s, const part_span *span);

/* An object with node, mesh, material and the name of each (null if missing), and the number of parts. NULL when out of memory. */
json_t *part_json(const scene *s, const part_span *span);

#endif
