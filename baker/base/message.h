/* Messages of a run to its user: one error at most, any number of warnings.
 *
 * A function that fails writes the reason, once, where it knows most, and returns the code; its callers only pass the code on.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef MESSAGE_H
#define MESSAGE_H

#include <stddef.h>

#include "formats/vxs_result.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct message {
    char   error[1024]; /* one line without a newline; "" when nothing failed */
    char **warnings;    /* [warning_count] one line each, owned */
    size_t warning_count, warning_capacity;
    int    quiet; /* nonzero: warnings are kept, not printed */
} message;

#if defined(__GNUC__)
#define MESSAGE_PRINTF      __attribute__((format(printf, 3, 4)))
#define MESSAGE_PRINTF_WARN __attribute__((format(printf, 2, 3)))
#else
#define MESSAGE_PRINTF
#define MESSAGE_PRINTF_WARN
#endif

/* Record why something failed (the first reason wins) and return `code`, so that `return fail(m, CODE, ...)` reads well.
 * The text is one line (control characters become '?'): what (file, element), where, what was found, what was expected. */
vxs_result fail(message *m, vxs_result code, const char *format, ...) MESSAGE_PRINTF;

/* Keep a warning for the report and print "vxs: warning: ..." to standard error. Equal warnings are kept once. */
void warn(message *m, const char *format, ...) MESSAGE_PRINTF_WARN;

/* Release the warnings. Accepts a zeroed object. */
void message_free(message *m);

/* The exit status of a command that ended with `code`; results are mapped to statuses here alone (docs/manual.md). */
int exit_status(vxs_result code);

#ifdef __cplusplus
}
#endif
#endif
