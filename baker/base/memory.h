/* Memory is asked for before it is taken: what a run may hold (--memory), what the machine has, and what the address space still holds.
 *
 * Where the size of what comes is known from counts, memory_check says no before the arrays are made: a run that is too large ends with
 * one line instead of being killed. The budget is counted against what the process holds, as memory is.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef MEMORY_H
#define MEMORY_H

#include <stdint.h>

#include "baker/base/message.h"

#ifdef __cplusplus
extern "C" {
#endif

/* What the process holds: its resident set. 0 where the system does not say. */
uint64_t memory_held_bytes(void);

/* What it may still take: the least of the memory that the system has available, what its control groups leave it, and what is left of its
 * address space. UINT64_MAX where nothing is known. */
uint64_t memory_available_bytes(void);

/* 1 when so many bytes may be taken beside what is held: m->memory_bytes allows it, and there are so many. */
int memory_allows(uint64_t bytes, const message *m);

/* VXS_OK when so many bytes may be taken beside what is held, of m->memory_bytes; VXS_E_MEMORY with a line that begins with the format's text and says how much is
 * needed, and how much there is: the text says what it is for, with its counts. */
vxs_result memory_check(uint64_t bytes, message *m, const char *format, ...) MESSAGE_PRINTF;

/* 1 when the address space still has room for so many bytes. Asked where a library does not survive that it has none. */
int memory_has_room(uint64_t bytes);

#ifdef __cplusplus
}
#endif
#endif
