/* The temporary files of a run, for a signal handler that removes them.
 *
 * A handler may not lock or allocate, so names are copied to where they are never freed, and a state marks those that count. Files may be
 * opened and closed by several threads. A run whose signals are its own has none of these (message.h).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef TEMPORARY_FILES_H
#define TEMPORARY_FILES_H

#include <limits.h>
#include <stdatomic.h>

enum { TEMPORARY_FILES_MAX = 8 };

/* Zero it; it outlives the handler. Up to 8 files are remembered at a time; further ones would be left behind. */
typedef struct temporary_files {
    struct {
        atomic_int state;
        char       name[PATH_MAX];
    } slots[TEMPORARY_FILES_MAX];
} temporary_files;

/* The number of a slot for `name`, from 1; 0 when there is none. */
int temporary_files_remember(temporary_files *t, const char *name);

/* Slot 0 is none. */
void temporary_files_forget(temporary_files *t, int slot);

/* Remove those that there are. Safe in a signal handler. */
void temporary_files_remove(temporary_files *t);

#endif
