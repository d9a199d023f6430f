/* How far a run is; see progress.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/command/process/progress.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "baker/base/clock.h"
#include "baker/base/text.h"

/* Longer lines would wrap on narrow terminals, and could not be cleared. */
enum { LINE_MAX_BYTES = 79 };

static const double interval_seconds = 0.1;

static double printed_at;

static void print_line(const char *left, const char *format, va_list args)
{
    char text[LINE_MAX_BYTES + 1], line[LINE_MAX_BYTES + 1];
    int  room = LINE_MAX_BYTES - (int)strlen("vxs: ") - (int)strlen(left);
    vsnprintf(text, (size_t)room + 1, format, args);
    snprintf(line, sizeof line, "vxs: %s%s", one_line(text), left);
    printed_at = clock_seconds();
    progress_line_show(line);
}

void progress_say(int shown, const char *format, ...)
{
    if (!shown) return;
    va_list args;
    va_start(args, format);
    print_line("", format, args);
    va_end(args);
}

/* ", about 12 s left"; "" when unknown, or about to end. */
static void estimate(char text[32], double share, double spent_seconds)
{
    double left = share > 0 ? spent_seconds / share * (1 - share) : 0;
    text[0]     = 0;
    if (left >= 120)
        snprintf(text, 32, ", about %.0f min left", left / 60);
    else if (left >= 0.5)
        snprintf(text, 32, ", about %.0f s left", left);
}

void progress_share(int shown, double share, double since, const char *format, ...)
{
    double now = shown ? clock_seconds() : 0;
    if (!shown || (progress_line_shown() && now - printed_at < interval_seconds)) return;
    char left[32];
    estimate(left, share, now - since);
    va_list args;
    va_start(args, format);
    print_line(left, format, args);
    va_end(args);
}

static void watch_shown(void *user, const char *doing)
{
    (void)user;
    progress_say(1, "%s", doing);
}

static void watch_shared(void *user, double share, double since, const char *doing)
{
    (void)user;
    progress_share(1, share, since, "%u %%: %s", (unsigned)(100 * share), doing);
}

const run_watch progress_watch = {.say = watch_shown, .share = watch_shared};
