/* Build JSON values. One check at the end detects all allocation failures:
 *
 *     json_t *o = json_object();
 *     json_set(&o, "threads", json_integer(4));
 *     json_set(&o, "name", json_text(name));
 *     if (!o) ...                                  // some allocation failed
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef JSON_VALUE_H
#define JSON_VALUE_H

#include <jansson.h>

#include "baker/base/text.h"

/* Set a member of an object, or append an item to an array. Takes ownership of the value. When the value is NULL, or an allocation
 * fails, the object is released and becomes NULL; further calls leave it NULL. */
void json_set(json_t **object, const char *key, json_t *value);
void json_append(json_t **array, json_t *value);

/* The complete JSON text, or NULL without memory: json_dumps would leave out keys in this case. Released with free().
 * flags  as for json_dumps */
char *json_whole_text(const json_t *value, size_t flags);

/* [x, y, z]. NULL without memory. */
json_t *json_vector(const double v[3]);

/* A JSON string. If the text is not UTF-8 (as file names may be), each byte beyond ASCII becomes '?'. NULL without memory. */
json_t *json_text(const char *text);

/* A JSON array of the texts. NULL without memory. */
json_t *json_texts(const text_list *texts);

#endif
