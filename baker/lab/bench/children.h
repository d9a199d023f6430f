/* Child processes: this executable with other arguments, one at a time; a folder for their outputs; and signals, held back until
 * both are gone.
 *
 *     children c;
 *     if ((r = children_begin(&c, m)) == VXS_OK) ... child_run(&c, ...) ...
 *     children_end(&c);       // SIGINT, SIGTERM or SIGHUP that came meanwhile ends the process here
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CHILDREN_H
#define CHILDREN_H

#include <dirent.h>
#include <signal.h>

#include "baker/base/run_context.h"

typedef struct children {
    sigset_t held, before;            /* held: SIGCHLD and the signals that end a run, except ignored ones; before: the signal
                                         mask before */
    int      caught;                  /* the signal that stopped a child; 0: none */
    char    *folder;                  /* owned, as the paths are */
    DIR     *names;                   /* the folder, open for listing */
    char    *asset, *report, *errors; /* files in the folder: outputs of a child, and its standard error */
} children;

/* Create a folder in $TMPDIR, or in /tmp if that is not set. From now on, signals to this thread are held back; in a process of
 * one thread, these are all.
 * c  [out] ends with children_end, whatever is returned
 * Returns VXS_OK, VXS_E_WRITE, VXS_E_MEMORY. */
vxs_result children_begin(children *c, run_context *m);

/* Remove the folder and the files in it (it has no folders). Does not return if a signal came. */
void children_end(children *c);

/* Run this executable and wait until it ends. Its standard output is discarded. When this process ends, or a held signal comes,
 * the child gets SIGTERM; if it then runs for more than half a second, SIGKILL.
 * arguments    [] NULL at the end; arguments[0] is a name
 * input        a file's descriptor, which becomes its standard input, from the start of the file; -1: its standard input is
 *              empty
 * seconds      [out] from before the start of the child to its end; only written when VXS_OK is returned, as is exit_status
 * exit_status  [out] or -N: ended by signal N
 * Returns VXS_OK whatever the child's exit status is; VXS_E_INTERRUPTED; VXS_E_MEMORY: it could not be started.
 * Threads: only in a process of one thread. */
vxs_result child_run(children *c, const char *const *arguments, int input, double *seconds, int *exit_status, run_context *m);

#endif
