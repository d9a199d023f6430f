/* Checks the shape of untrusted JSON. A shape is JSON with single quotes:
 *
 *     {'name': 'text', 'runs': 'u32', 'bytes?': 'count', 'kind': 'tops|pages', 'cells': [4096, {'side': 'u32'}]}
 *
 * A name with a question mark may be missing. Unknown names are allowed. A leaf is 'text', 'bool', a choice of words, a kind of
 * number (json_shape.c), 'size or null', or 'spread' (of times). An array has the maximum number of items, then the shape of an
 * item; if it has two shapes, the second is for items that are smooth, refused, or have a "filter_px" above 1.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef JSON_SHAPE_H
#define JSON_SHAPE_H

#include <jansson.h>

#include "baker/base/message.h"

/* writer  the program that writes such files; path  of the file: both for the error.
 * Returns VXS_OK; VXS_E_READ: the shape differs, with the place in one line of m; VXS_E_MEMORY. */
vxs_result json_shape_check(const json_t *value, const char *shape, const char *writer, const char *path, message *m);

#endif
