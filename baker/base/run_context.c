/* Errors, warnings and exit statuses; see run_context.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/base/run_context.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/array.h"
#include "baker/base/text.h"

vxs_result fail(run_context *m, vxs_result code, const char *format, ...)
{
    if (!m->error[0]) {
        va_list args;
        va_start(args, format);
        vsnprintf(m->error, sizeof m->error, format, args);
        va_end(args);
        one_line(m->error);
    }
    return code;
}

void warn(run_context *m, const char *format, ...)
{
    char    text[1024];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    one_line(text);

    if (m->strict) {
        fail(m, VXS_E_STRICT, "%s (--strict: a warning is an error)", text);
        return;
    }
    for (size_t i = 0; i < m->warning_count; i++)
        if (!strcmp(m->warnings[i], text)) return;
    if (m->log) m->log(VXS_SEVERITY_WARNING, text, m->log_user);

    /* no memory for a copy: the warning was already shown, but is missing in the report */
    char *copy = strdup(text);
    if (copy && array_reserve(&m->warnings, &m->warning_capacity, m->warning_count + 1, sizeof *m->warnings))
        m->warnings[m->warning_count++] = copy;
    else
        free(copy);
}

vxs_result run_check(const run_context *m)
{
    return m->strict && m->error[0] ? VXS_E_STRICT : VXS_OK;
}

void run_free(run_context *m)
{
    for (size_t i = 0; i < m->warning_count; i++) free(m->warnings[i]);
    free(m->warnings);
    m->warnings      = NULL;
    m->warning_count = m->warning_capacity = 0;
}

int exit_status(vxs_result code)
{
    switch (code) {
    case VXS_OK: return 0;
    case VXS_E_STRICT: return 1;
    case VXS_E_ARGUMENT: return 2;
    case VXS_E_READ:
    case VXS_E_NO_FILE:
    case VXS_E_NOT_VXS:
    case VXS_E_VERSION:
    case VXS_E_TRUNCATED:
    case VXS_E_CORRUPT:
    case VXS_E_SCENE:
    case VXS_E_UNSUPPORTED: return 3;
    case VXS_E_WRITE: return 4;
    case VXS_E_NO_CASTER:
    case VXS_E_NO_LIGHT: return 5;
    case VXS_E_MEMORY:
    case VXS_E_REFERENCES:
    case VXS_E_GL:
    case VXS_E_PROGRAM: return 6;
    case VXS_E_INTERRUPTED: return 130;
    case VXS_E_BROKEN_PIPE: return 141; /* the status that a shell reports after SIGPIPE */
    }
    return 6;
}
