/* Functions of the operating system that POSIX does not have; others are in memory.h, clock.h, pages.h and terminal.h. system_linux.c
 * implements them for native builds. For WebAssembly baker/web/system_web.c calls the host: Node or a browser.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SYSTEM_H
#define SYSTEM_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* qsort with an argument for `compare`. The order of items that compare equal is undefined. */
void system_sort(void *items, size_t count, size_t item_bytes, int (*compare)(const void *a, const void *b, void *user),
                 void *user);

/* Processors that this process may use, at least 1. */
uint32_t system_processors(void);

/* Copy the extended attributes and the access list of the file `path` to an open file. Returns 0, or an errno. */
int system_copy_attributes(const char *path, int descriptor);

/* The path of the running program, NUL-terminated, in `room` bytes. Returns 0 where it is not known or longer. */
int system_program(char *path, size_t room);

/* Run a function in a process of its own, which ends with its result as exit status. Call it while there is no other thread.
 * Returns the exit status, 128 and the signal that ended it, or -1: no process can be made. */
int system_run_apart(int (*run)(void *work), void *work);

/* Begin to watch files, which need not exist. Returns a descriptor, or -1: it cannot be done. */
int system_watch_begin(const char *const *paths, size_t count);

/* Wait until one of these files was written, made or replaced since system_watch_begin, and then until none was for quiet_ms. Closes
 * the descriptor. Returns 0 on an error. */
int system_watch_wait(int descriptor, const char *const *paths, size_t count, int quiet_ms);

/* Progress by other means than a line on a terminal: 1 where system_show_progress shows it.
 * share  [0, 1]; negative: unknown */
int  system_shows_progress(void);
void system_show_progress(double share, const char *doing);

#ifdef __cplusplus
}
#endif
#endif
