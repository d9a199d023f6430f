/* Write JSON files and read them.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef JSON_FILE_H
#define JSON_FILE_H

#include "baker/base/run_context.h"
#include "baker/files/json_value.h"

struct output_file;

/* Call this before any other JSON function. From then on json_memory_missing and json_print detect failed allocations of any JSON
 * value. This is needed because jansson reports them for each call that fills an object, but not always when it prints. */
void json_watch_memory(void);

/* Nonzero when any allocation of a JSON value failed in this process. */
int json_memory_missing(void);

/* json_dumps. NULL when any allocation for the text, or for any JSON value of this process, failed. Released with free(). */
char *json_print(const json_t *value, size_t flags);

/* Write a JSON value to an output file ("-" is standard output), indented, with a final newline. Releases the value.
 * Returns VXS_OK, VXS_E_WRITE, or VXS_E_MEMORY, also when the value is NULL or incomplete. */
vxs_result json_write(const char *path, json_t *value, run_context *m);

/* The same into an open output, which is committed or aborted.   digits  of a real number, 1 to 17; json_write has 9 */
vxs_result json_write_opened(struct output_file *out, json_t *value, int digits, run_context *m);

/* Read an untrusted JSON file: at most 256 MiB, nested at most 2048 deep, no duplicate keys in an object.
 * value  [out] NULL on failure; released with json_decref
 * Returns VXS_OK; VXS_E_READ: unreadable or not JSON; VXS_E_MEMORY. */
vxs_result json_read(json_t **value, const char *path, run_context *m);

#endif
