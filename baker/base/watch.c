/* Progress callbacks; see watch.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/base/watch.h"

#include <limits.h>
#include <stdarg.h>
#include <stdio.h>

#include "baker/base/text.h"

enum { DOING_BYTES = PATH_MAX };

/* Format the description as one line. */
static const char *line_of(char doing[DOING_BYTES], const char *format, va_list args)
{
    vsnprintf(doing, DOING_BYTES, format, args);
    return one_line(doing);
}

void watch_say(const run_watch *w, const char *format, ...)
{
    char    doing[DOING_BYTES];
    va_list args;
    va_start(args, format);
    if (w) w->say(w->user, line_of(doing, format, args));
    va_end(args);
}

void watch_share(const run_watch *w, double share, double since, const char *format, ...)
{
    char    doing[DOING_BYTES];
    va_list args;
    va_start(args, format);
    if (w) w->share(w->user, share, since, line_of(doing, format, args));
    va_end(args);
}
