/* What JSON that anyone may have written must be, said as JSON with single quotes:
 *
 *     {'name': 'text', 'runs': 'u32', 'bytes?': 'count', 'kind': 'tops|pages', 'cells': [4096, {'side': 'u32'}]}
 *
 * A name with a question mark may be missing; there may be more names than these. Leaves are 'text', 'bool', words that a text
 * may be, a kind of numbers (json_shape.c), 'size or null', or 'spread', of times. In an array, the most items that it may have
 * come first, and then what an item is; where there are two, the second is of those that are smooth, refused, or have a
 * "filter_px" above 1.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef JSON_SHAPE_H
#define JSON_SHAPE_H

#include <jansson.h>

#include "baker/base/message.h"

/* writer  who writes such files; path  of the file: for the error.
 * Returns VXS_OK; VXS_E_READ: it is another, and one line in m says where; VXS_E_MEMORY. */
vxs_result json_shape_check(const json_t *value, const char *shape, const char *writer, const char *path, message *m);

#endif
