/* Temporary files of a run, for a signal handler that removes them.
 *
 * A signal handler must not lock or allocate. So names are copied to fixed slots that are never freed, and an atomic state marks
 * the valid ones. Files may be opened and closed by several threads. A program that handles signals itself uses none of this
 * (run_context.h).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef TEMPORARY_FILES_H
#define TEMPORARY_FILES_H

#include <limits.h>
#include <stdatomic.h>

enum { TEMPORARY_FILES_MAX = 8 };

/* Zero it; it must outlive the handler. At most TEMPORARY_FILES_MAX files are remembered at a time; further ones are left
 * behind. */
typedef struct temporary_files {
    struct {
        atomic_int state;
        char       name[PATH_MAX];
    } slots[TEMPORARY_FILES_MAX];
} temporary_files;

/* Store `name` in a slot. Returns the slot number, from 1; 0 when all slots are in use. */
int temporary_files_remember(temporary_files *t, const char *name);

/* Release a slot; 0 does nothing. */
void temporary_files_forget(temporary_files *t, int slot);

/* Remove all remembered files. Async-signal-safe. */
void temporary_files_remove(temporary_files *t);

#endif
