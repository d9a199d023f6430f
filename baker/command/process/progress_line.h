/* The progress line of a terminal (baker/command/process/progress.h): the part that every function that prints needs.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef PROGRESS_LINE_H
#define PROGRESS_LINE_H

#ifdef __cplusplus
extern "C" {
#endif

/* Replace the line by a text, on standard error. */
void progress_line_show(const char *text);

/* 1 while there is a line. */
int progress_line_shown(void);

/* Clear the progress line. Call before anything else is printed, and at the end. No effect without a line. Async-signal-safe. */
void progress_clear(void);

#ifdef __cplusplus
}
#endif
#endif
