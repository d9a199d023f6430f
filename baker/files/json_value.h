/* JSON that is put together. One look in the end tells whether all of it is there:
 *
 *     json_t *o = json_object();
 *     json_set(&o, "threads", json_integer(4));
 *     json_set(&o, "name", json_text(name));
 *     if (!o) ...                                  // no memory for some of it
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef JSON_VALUE_H
#define JSON_VALUE_H

#include <jansson.h>

#include "baker/base/text.h"

/* Give an object a member, or an array an item; the value is owned from then on. Where there is no value, or no memory, the object is
 * released and becomes NULL, and stays so. */
void json_set(json_t **object, const char *key, json_t *value);
void json_append(json_t **array, json_t *value);

/* JSON as text, whole, or NULL without memory: json_dumps leaves out keys then.   flags  of json_dumps. Released with free(). */
char *json_whole_text(const json_t *value, size_t flags);

/* [x, y, z]. NULL without memory. */
json_t *json_vector(const double v[3]);

/* A text as JSON; what is not UTF-8, as a file's name may be, gets '?' for each byte beyond ASCII. NULL without memory. */
json_t *json_text(const char *text);

/* An array of them. NULL without memory. */
json_t *json_texts(const text_list *texts);

#endif
