/* Child processes: this executable with other arguments, one at a time, a folder for what they write, and signals that wait until
 * nothing is left of either.
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

#include "baker/base/message.h"

typedef struct children {
    sigset_t held, before;            /* SIGCHLD and signals that end a run, but those that are ignored; what was blocked before */
    int      caught;                  /* the signal that stopped a child; 0: none */
    char    *folder;                  /* owned, as the paths are */
    DIR     *names;                   /* what is in it; open */
    char    *asset, *report, *errors; /* in the folder: what a child writes, and its standard error */
} children;

/* From now on signals wait, those to this thread and, in a process of one thread, all; and there is a new folder in $TMPDIR, or
 * /tmp where that is not set.
 * c  [out] ends with children_end, whatever is returned
 * Returns VXS_OK, VXS_E_WRITE, VXS_E_MEMORY. */
vxs_result children_begin(children *c, message *m);

/* Take the folder away with all files in it (there are no folders in it). Returns only when no signal came. */
void children_end(children *c);

/* Run this executable and wait until it ends. What it prints to standard output is lost. It is stopped with
 * SIGTERM when this process ends, or when a signal comes that is held; then with SIGKILL when it takes longer than half a second.
 * arguments    [] NULL at the end; arguments[0] is a name
 * input        a file's descriptor, which becomes its standard input, from the start of the file; -1: it reads nothing
 * seconds      [out] from before its start until it was gone; written only when VXS_OK is returned, as the next is
 * exit_status  [out] or -N: ended by signal N
 * Returns VXS_OK whatever the child's exit status is; VXS_E_INTERRUPTED; VXS_E_MEMORY: it could not be started.
 * Threads: only in a process of one thread. */
vxs_result child_run(children *c, const char *const *arguments, int input, double *seconds, int *exit_status, message *m);

#endif
