/* Telling who watches; see watch.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/measure/watch.h"

#include <limits.h>
#include <stdarg.h>
#include <stdio.h>

#include "baker/base/text.h"

enum { DOING_BYTES = PATH_MAX };

void watch_say(const run_watch *w, const char *format, ...)
{
    char    doing[DOING_BYTES];
    va_list args;
    if (!w) return;
    va_start(args, format);
    vsnprintf(doing, sizeof doing, format, args);
    va_end(args);
    w->say(w->user, one_line(doing));
}

void watch_share(const run_watch *w, double share, double since, const char *format, ...)
{
    char    doing[DOING_BYTES];
    va_list args;
    if (!w) return;
    va_start(args, format);
    vsnprintf(doing, sizeof doing, format, args);
    va_end(args);
    w->share(w->user, share, since, one_line(doing));
}
