/* Who watches a run, and is told how far it is: a terminal (progress.h), or a program that has the run done.
 * Threads: all calls of a run come from the one that runs it.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef WATCH_H
#define WATCH_H

#include "baker/base/message.h"

typedef struct run_watch {
    /* Work of unknown length begins.   doing  one line */
    void (*say)(void *user, const char *doing);

    /* So much of the whole is done.   share  0 to 1;   since  clock_seconds() when it was begun */
    void (*share)(void *user, double share, double since, const char *doing);

    void *user;
} run_watch;

/* w  NULL: nobody watches */
void watch_say(const run_watch *w, const char *format, ...) MESSAGE_PRINTF_WARN;

void watch_share(const run_watch *w, double share, double since, const char *format, ...) __attribute__((format(printf, 4, 5)));

#endif
