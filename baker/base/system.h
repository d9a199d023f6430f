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

/* Progress by other means than a line on a terminal: 1 where system_show_progress shows it.
 * share  [0, 1]; negative: unknown */
int  system_shows_progress(void);
void system_show_progress(double share, const char *doing);

#ifdef __cplusplus
}
#endif
#endif
