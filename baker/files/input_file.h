/* Input files: a file, a pipe (`<(...)`), or "-" for standard input. Each is read once, from its current position to its end.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef INPUT_FILE_H
#define INPUT_FILE_H

#include <stddef.h>
#include <stdint.h>

#include "baker/base/run_context.h"

#ifdef __cplusplus
extern "C" {
#endif

int is_standard_input(const char *path);

/* Name of the input in messages: the path, or "standard input". */
const char *input_name(const char *path);

/* Size of a regular file in bytes; 0: no such file, or a pipe. */
uint64_t input_bytes(const char *path, const run_context *m);

/* Returns a descriptor to read from and to close; -1 and errno on failure. A folder can be opened, but not read. */
int input_open(const char *path);

/* 1 for a pipe, a device or standard input: its data can be read only once. */
int is_read_once(const char *path);

/* Looks at the first bytes of an input. */
typedef struct input_head {
    /* Called once with the first 64 KiB, or all bytes if there are fewer. Returns the expected size of the whole input; at most one
     * byte more is read, to detect longer inputs. 0: not the expected format, stop reading. UINT64_MAX: the size is not known */
    uint64_t (*wanted)(void *user, const uint8_t *first, size_t size_bytes);
    void *user;
} input_head;

/* Read a whole input, through m->access where it is set. Memory is checked against m->memory_bytes before it is allocated
 * (memory.h).
 * bytes        [out] NULL on failure; released with free()
 * limit_bytes  maximum size; a larger input is VXS_E_MEMORY and is not read further
 * head         called with the first bytes before the rest is read; NULL: none
 * Returns VXS_OK, VXS_E_READ, VXS_E_MEMORY. On failure m has the reason. */
vxs_result input_read(uint8_t **bytes, size_t *size_bytes, const char *path, uint64_t limit_bytes, const input_head *head,
                      run_context *m);

#ifdef __cplusplus
}
#endif
#endif
