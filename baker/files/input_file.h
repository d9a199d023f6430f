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

/* What the first bytes of an input say. */
typedef struct input_head {
    /* Called once with the first bytes: 64 KiB, or all that there are. Returns how many bytes the whole input should have: no more than one
     * more are read, which shows that there are more; 0: it is not what was expected, and no more is read. UINT64_MAX: they do not say */
    uint64_t (*wanted)(void *user, const uint8_t *first, size_t size_bytes);
    void *user;
} input_head;

/* All of an input. Memory is asked for before it is taken (memory.h), and counted by m->memory_bytes.
 * bytes        [out] NULL on failure; released with free()
 * limit_bytes  of more is VXS_E_MEMORY, and no more than that is read
 * head         looks at the first bytes before more is read; NULL: nothing does
 * Returns VXS_OK; VXS_E_READ; VXS_E_MEMORY. One line in m says which. */
vxs_result input_read(uint8_t **bytes, size_t *size_bytes, const char *path, uint64_t limit_bytes, const input_head *head,
                      message *m);

#ifdef __cplusplus
}
#endif
#endif
