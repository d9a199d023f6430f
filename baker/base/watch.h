/* Progress callbacks of a run: for a terminal (process.h), or for a program that uses the baker as a library.
 * Threads: all calls of a run come from the thread that runs it.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef WATCH_H
#define WATCH_H

#include "baker/base/run_context.h"

typedef struct run_watch {
    /* Work of unknown length begins.
     * doing  one line */
    void (*say)(void *user, const char *doing);

    /* Progress of the whole run.
     * share  [0, 1]
     * since  clock_seconds() at the begin */
    void (*share)(void *user, double share, double since, const char *doing);

    void *user;
} run_watch;

/* w  NULL: no callbacks */
void watch_say(const run_watch *w, const char *format, ...) RUN_PRINTF_WARN;

void watch_share(const run_watch *w, double share, double since, const char *format, ...) __attribute__((format(printf, 4, 5)));

#endif
