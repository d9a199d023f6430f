/* Build JSON values; see json_value.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/files/json_value.h"

#include <stdlib.h>
#include <string.h>

static void lose(json_t **value)
{
    json_decref(*value);
    *value = NULL;
}

void json_set(json_t **object, const char *key, json_t *value)
{
    if (!*object)
        json_decref(value);
    else if (json_object_set_new(*object, key, value))
        lose(object);
}

void json_append(json_t **array, json_t *value)
{
    if (!*array)
        json_decref(value);
    else if (json_array_append_new(*array, value))
        lose(array);
}

char *json_whole_text(const json_t *value, size_t flags)
{
    size_t size = json_dumpb(value, NULL, 0, flags);
    char  *text = size ? malloc(size + 1) : NULL;
    if (!text) return NULL;
    if (json_dumpb(value, text, size, flags) == size) {
        text[size] = 0;
        return text;
    }
    free(text);
    return NULL;
}

json_t *json_vector(const double v[3])
{
    return json_pack("[f,f,f]", v[0], v[1], v[2]);
}

json_t *json_text(const char *text)
{
    json_t *value = json_string(text);
    char   *ascii = value ? NULL : strdup(text);
    if (!ascii) return value;
    for (char *c = ascii; *c; c++)
        if ((unsigned char)*c > 0x7f) *c = '?';
    value = json_string(ascii);
    free(ascii);
    return value;
}

json_t *json_texts(const text_list *texts)
{
    json_t *array = json_array();
    for (size_t i = 0; i < texts->count; i++) json_append(&array, json_text(texts->items[i]));
    return array;
}
