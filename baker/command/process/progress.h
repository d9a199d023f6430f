/* Progress of a run: one line on a terminal, overwritten each time and cleared at the end.
 *
 *     progress_say(shown, "reading %s", path);
 *     double since = clock_seconds();
 *     for (...) progress_share(shown, (double)done / count, since, "light %s: tile %u of %u", ...);
 *     progress_clear();
 *
 * shown  0: standard error is no terminal, and nothing is printed.   Threads: one at a time.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef PROGRESS_H
#define PROGRESS_H

#include "baker/base/watch.h"
#include "baker/command/process/progress_line.h"

#ifdef __cplusplus
extern "C" {
#endif

#if defined(__GNUC__)
#define PROGRESS_PRINTF(text, values) __attribute__((format(printf, text, values)))
#else
#define PROGRESS_PRINTF(text, values)
#endif

/* Show "vxs: TEXT", before work of unknown length. TEXT may contain text from files (one_line). */
void progress_say(int shown, const char *format, ...) PROGRESS_PRINTF(2, 3);

/* Show "vxs: TEXT, about 12 s left", at most ten times a second.
 * share  of the work that is done, 0 to 1;   since  clock_seconds() at the start of the work */
void progress_share(int shown, double share, double since, const char *format, ...) PROGRESS_PRINTF(4, 5);

/* Run callbacks that show progress on a terminal. */
extern const run_watch progress_watch;

#ifdef __cplusplus
}
#endif
#endif
