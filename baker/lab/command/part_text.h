/* The origin of a component as text and as JSON, for reports: the node, mesh and material of its first triangle.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef PART_TEXT_H
#define PART_TEXT_H

#include <jansson.h>

#include "baker/scene/scene.h"

enum { PART_TEXT_BYTES = 512 };

/* "node 3 'lamp', mesh 2, material 1 'steel' and 2 more". Long names are cut in the middle.
 * text  [PART_TEXT_BYTES] out
 * Returns text. */
const char *part_text(char *text, const scene *s, const part_span *span);

/* An object with node, mesh, material and the name of each (null if missing), and the number of parts. NULL when out of memory. */
json_t *part_json(const scene *s, const part_span *span);

#endif
