/* How far a run is; see progress.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/base/progress.h"

#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "baker/base/clock.h"
#include "baker/base/text.h"

/* A longer line would wrap on the narrowest of terminals, and could not be taken back. */
enum { LINE_MAX_BYTES = 79 };

static const double interval_seconds = 0.1;
static const char   clear_line[]     = "\r\033[K";

static atomic_int line_shown; /* a signal handler asks */
static double     printed_at;

static void print_line(const char *left, const char *format, va_list args)
{
    char text[LINE_MAX_BYTES + 1];
    int  room = LINE_MAX_BYTES - (int)strlen("vxs: ") - (int)strlen(left);
    vsnprintf(text, (size_t)room + 1, format, args);
    atomic_store(&line_shown, 1);
    printed_at = clock_seconds();
    fprintf(stderr, "%svxs: %s%s", clear_line, one_line(text), left);
    fflush(stderr);
}

void progress_say(int shown, const char *format, ...)
{
    if (!shown) return;
    va_list args;
    va_start(args, format);
    print_line("", format, args);
    va_end(args);
}

/* ", about 12 s left", or nothing when that cannot be told, or is over at once. */
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
    if (!shown || (atomic_load(&line_shown) && now - printed_at < interval_seconds)) return;
    char left[32];
    estimate(left, share, now - since);
    va_list args;
    va_start(args, format);
    print_line(left, format, args);
    va_end(args);
}

void progress_clear(void)
{
    if (!atomic_exchange(&line_shown, 0)) return;
    if (write(STDERR_FILENO, clear_line, sizeof clear_line - 1) < 0) return; /* a terminal that is gone shows nothing */
}
