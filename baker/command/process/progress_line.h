/* The line of a terminal that shows how far a run is (baker/command/process/progress.h), as far as everything that prints has to
 * know it.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef PROGRESS_LINE_H
#define PROGRESS_LINE_H

#ifdef __cplusplus
extern "C" {
#endif

/* Write a text over the line that is shown, to standard error. */
void progress_line_show(const char *text);

/* 1 while there is a line. */
int progress_line_shown(void);

/* Take the line away; call it before anything else is printed and in the end. Does nothing when there is none. Safe in a signal
 * handler. */
void progress_clear(void);

#ifdef __cplusplus
}
#endif
#endif
