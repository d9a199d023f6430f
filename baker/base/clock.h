/* Wall time and peak memory of this process, for reports only. No asset depends on them.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CLOCK_H
#define CLOCK_H

#include <stdint.h>

/* Seconds since an arbitrary fixed moment. Monotonic. */
double clock_seconds(void);

/* Start a new peak for memory_peak_bytes. Does nothing where the system does not support it. For measuring programs only: it also
 * resets the system's own figure for the process (ru_maxrss). */
void memory_peak_reset(void);

/* Peak resident memory since memory_peak_reset, or since the start of the process. 0: unknown. */
uint64_t memory_peak_bytes(void);

#endif
