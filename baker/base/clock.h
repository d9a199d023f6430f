/* Wall time and peak memory of this process, for reports only: nothing that is written to an asset depends on them.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CLOCK_H
#define CLOCK_H

#include <stdint.h>

/* Seconds since some moment, steady. */
double clock_seconds(void);

/* Start a new peak: later calls of memory_peak_bytes count from here. Does nothing where the system cannot. For programs that measure
 * themselves: what the system tells others of the process (ru_maxrss) is then the new peak, too. */
void memory_peak_reset(void);

/* Most resident memory since memory_peak_reset, or since the start; 0 when unknown. */
uint64_t memory_peak_bytes(void);

#endif
