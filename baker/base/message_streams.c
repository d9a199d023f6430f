/* Streams of a command for people; see message.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/base/message.h"

FILE *report_stream(const message *m, int stdout_is_taken)
{
    return m->no_report ? NULL : stdout_is_taken ? stderr : stdout;
}

int progress_wanted(const message *m)
{
    return !m->no_report && terminal_can_clear(stderr);
}
