/* JSON to files and from them.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef JSON_FILE_H
#define JSON_FILE_H

#include "baker/base/message.h"
#include "baker/files/json_value.h"

/* Call this first: from then on json_memory_missing and json_print notice when any value could not be allocated. jansson reports that
 * call by call where an object is filled, and not always where one is printed. */
void json_watch_memory(void);

/* Nonzero when any value of this process was made without enough memory. */
int json_memory_missing(void);

/* json_dumps, or NULL when the text, or any value of this process, was made without enough memory. Released with free(). */
char *json_print(const json_t *value, size_t flags);

/* Write any JSON value as an output file ("-" is standard output), indented, with a newline at its end; the value is released.
 * Returns VXS_OK, VXS_E_WRITE, or VXS_E_MEMORY, also when the value is NULL or incomplete. */
vxs_result json_write(const char *path, json_t *value, message *m);

/* Read a file that anyone may have written, of at most 256 MiB, nested at most 2048 deep; an object has no key twice.
 * value  [out] NULL on failure; released with json_decref
 * Returns VXS_OK, VXS_E_READ: it cannot be read, or is no JSON; VXS_E_MEMORY. */
vxs_result json_read(json_t **value, const char *path, message *m);

#endif
