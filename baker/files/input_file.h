/* Input files: a file, a pipe (`<(...)`), or "-", which is standard input. All are read from where they stand to their end, once.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef INPUT_FILE_H
#define INPUT_FILE_H

#include <stddef.h>
#include <stdint.h>

#include "baker/base/message.h"

#ifdef __cplusplus
extern "C" {
#endif

int is_standard_input(const char *path);

/* How messages call it: the path, or "standard input". */
const char *input_name(const char *path);

/* A descriptor to read from and to close; -1: errno says why. A folder can be opened, and not read. */
int input_open(const char *path);

/* A pipe, a device or standard input: what comes from it once does not come again. */
int is_read_once(const char *path);

/* All of an input.
 * bytes        [out] NULL on failure; released with free()
 * limit_bytes  of more is VXS_E_MEMORY, and no more than that is read
 * Returns VXS_OK; VXS_E_READ; VXS_E_MEMORY. One line in m says which. */
vxs_result input_read(uint8_t **bytes, size_t *size_bytes, const char *path, uint64_t limit_bytes, message *m);

/* Whether an input may be what is wanted, by its first bytes, as many as have come and 1024 at least where it has them. */
typedef int input_look(const uint8_t *bytes, size_t size_bytes);

/* The same; of an input that cannot be what is wanted, by `look`, the beginning alone: it may be endless, or larger than any memory. */
vxs_result input_read_if(uint8_t **bytes, size_t *size_bytes, const char *path, uint64_t limit_bytes, input_look *look, message *m);

#ifdef __cplusplus
}
#endif
#endif
