/* Memory limits; see memory.h. What the system says is in system_linux.c.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/base/memory.h"

#include <stdarg.h>
#include <stdio.h>

#include "baker/base/text.h"

/* Bytes; smaller amounts are not checked against the budget, and against the system, which takes 130 us. */
enum { WORTH_A_LOOK = 1 << 20, WORTH_ASKING = 16 << 20 };

static uint64_t available_for(uint64_t bytes)
{
    return bytes < WORTH_ASKING ? UINT64_MAX : memory_available_bytes();
}

int memory_allows(uint64_t bytes, const run_context *m)
{
    if (bytes < WORTH_A_LOOK) return 1;
    return (!m->memory_bytes || memory_held_bytes() + bytes <= m->memory_bytes) && bytes <= available_for(bytes);
}

vxs_result memory_check(uint64_t bytes, run_context *m, const char *format, ...)
{
    char what[512], needed[32], there[32];
    if (bytes < WORTH_A_LOOK) return VXS_OK;
    uint64_t available = available_for(bytes), budget_bytes = m->memory_bytes, held = budget_bytes ? memory_held_bytes() : 0;
    if ((!budget_bytes || held + bytes <= budget_bytes) && bytes <= available) return VXS_OK;

    va_list args;
    va_start(args, format);
    vsnprintf(what, sizeof what, format, args);
    va_end(args);
    if (budget_bytes && held + bytes > budget_bytes)
        return fail(m, VXS_E_MEMORY, "%s about %s of memory, --memory allows %s", what, size_text(needed, held + bytes),
                    size_text(there, budget_bytes));
    return fail(m, VXS_E_MEMORY, "%s about %s of memory, there are %s left", what, size_text(needed, bytes),
                size_text(there, available));
}
