/* Memory limits: the budget of a run (--memory), the memory of the machine, and the address space.
 *
 * Where counts give the size of the next arrays, memory_check fails before they are allocated. So a run that is too large ends with
 * an error message and is not killed. The budget covers all memory that the process holds.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef MEMORY_H
#define MEMORY_H

#include <stdint.h>

#include "baker/base/run_context.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Resident set of the process. 0: unknown. */
uint64_t memory_held_bytes(void);

/* Memory that the process may still take: the minimum of the memory available in the system, the rest of its control groups'
 * limits, and the rest of its address space. UINT64_MAX: unknown. */
uint64_t memory_available_bytes(void);

/* 1 when `bytes` more bytes fit both m->memory_bytes and the available memory. */
int memory_allows(uint64_t bytes, const run_context *m);

/* Check that `bytes` more bytes fit m->memory_bytes and the available memory. Returns VXS_OK; or VXS_E_MEMORY with a message: the
 * formatted text, then how much is needed and how much is there. The text names the purpose and its counts. */
vxs_result memory_check(uint64_t bytes, run_context *m, const char *format, ...) RUN_PRINTF;

/* 1 when the address space has room for `bytes` more bytes. For libraries that crash when an allocation fails. */
int memory_has_room(uint64_t bytes);

#ifdef __cplusplus
}
#endif
#endif
