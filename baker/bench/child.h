/* Child processes: this executable with other arguments, one at a time, and signals that wait until nothing is left of them.
 *
 *     interrupts i;
 *     interrupts_hold(&i);
 *     ... make a folder, child_run(&i, ...), take the folder away ...
 *     interrupts_release(&i);       // SIGINT, SIGTERM or SIGHUP that came meanwhile ends the process here
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CHILD_H
#define CHILD_H

#include <signal.h>

#include "baker/base/message.h"

/* Signals that end a run, but those that are ignored, and SIGCHLD; and what was blocked before. */
typedef struct interrupts {
    sigset_t held, before;
    int      caught; /* the signal that stopped a child; 0: none */
} interrupts;

/* From now on signals wait, those to this thread and, in a process of one thread, all. */
void interrupts_hold(interrupts *i);

/* Returns only when none came. */
void interrupts_release(interrupts *i);

typedef struct child_end {
    double seconds;     /* from before its start until it was gone */
    int    exit_status; /* or -N: ended by signal N */
} child_end;

/* Run this executable and wait until it ends. It reads nothing, and what it prints to standard output is lost. It is stopped with
 * SIGTERM when this process ends, or when a signal comes that is held; then with SIGKILL when it takes longer than half a second.
 * arguments   [] NULL at the end; arguments[0] is a name
 * error_path  the file that gets what it prints to standard error, in place of an older one
 * end         [out] written only when VXS_OK is returned
 * Returns VXS_OK whatever the child's exit status is; VXS_E_INTERRUPTED; VXS_E_MEMORY: it could not be started.
 * Threads: only in a process of one thread. */
vxs_result child_run(interrupts *i, const char *const *arguments, const char *error_path, child_end *end, message *m);

#endif
