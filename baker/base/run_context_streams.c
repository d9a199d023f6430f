/* Streams of a command for people; see run_context.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/base/run_context.h"
#include "baker/base/system.h"

FILE *report_stream(const run_context *m, int stdout_is_taken)
{
    return m->no_report ? NULL : stdout_is_taken ? stderr : stdout;
}

int progress_wanted(const run_context *m)
{
    if (m->progress == PROGRESS_JSON) return PROGRESS_LINES_OF_JSON;
    return !m->no_report && (system_shows_progress() || terminal_can_clear(stderr)) ? PROGRESS_LINE : NO_PROGRESS;
}
