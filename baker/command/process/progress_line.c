/* A line that is written over; see progress_line.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/command/process/progress_line.h"

#include <stdatomic.h>
#include <stdio.h>
#include <unistd.h>

static const char clear_line[] = "\r\033[K";

static atomic_int line_shown; /* a signal handler reads it */

void progress_line_show(const char *text)
{
    atomic_store(&line_shown, 1);
    fprintf(stderr, "%s%s", clear_line, text);
    fflush(stderr);
}

int progress_line_shown(void)
{
    return atomic_load(&line_shown);
}

void progress_clear(void)
{
    if (!atomic_exchange(&line_shown, 0)) return;
    if (write(STDERR_FILENO, clear_line, sizeof clear_line - 1) < 0) return; /* ignore errors: the terminal is gone */
}
