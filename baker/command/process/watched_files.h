/* Waiting until files change, and a process for each piece of work meanwhile: vxs bake --watch.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef WATCHED_FILES_H
#define WATCHED_FILES_H

#include <stddef.h>

/* Run a function in a process of its own, which ends with its result as exit status. Call it while there is no other thread.
 * Returns the exit status, 128 and the signal that ended it, or -1: no process can be made. */
int run_apart(int (*run)(void *work), void *work);

/* Begin to watch files, which need not exist. Returns a descriptor, or -1: it cannot be done. */
int watched_files_begin(const char *const *paths, size_t count);

/* Wait until one of these files was written, made or replaced since watched_files_begin, and then until none was for quiet_ms. Closes
 * the descriptor. Returns 0 on an error. */
int watched_files_wait(int descriptor, const char *const *paths, size_t count, int quiet_ms);

#endif
