/* Messages of a run to its user: one error at most, any number of warnings.
 *
 * A function that fails writes the reason, once, where it knows most, and returns the code; its callers only pass the code on.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef MESSAGE_H
#define MESSAGE_H

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "baker/base/terminal.h"
#include "formats/vxs_result.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct message {
    char   error[1024]; /* one line without a newline; "" when nothing failed */
    char **warnings;    /* [warning_count] one line each, owned */
    size_t warning_count, warning_capacity;
    void (*tell)(const struct message *m, const char *warning); /* is told of each as it comes; NULL: they are kept alone */
    void *tell_user;

    int strict; /* nonzero: a warning is an error, the first of them the one that counts */
    int force;  /* nonzero: files are replaced that are read-only, or of which something is lost (baker/files/replaced_file.h) */
    int wrong;  /* nonzero: the command works, and what it looked at is wrong: its exit status is 1 */

    struct run_files *files; /* what this run writes (baker/files/run_files.h); borrowed; NULL: nothing is known of it */
    struct temporary_files
            *temporary;    /* what a signal would have to remove (baker/files/temporary_files.h); borrowed; NULL: nobody does */
    uint64_t memory_bytes; /* what the process may hold at most (baker/base/memory.h); 0: as much as there is */

    /* how much is said, and how: for people alone, no data depends on it */
    int        verbose;   /* nonzero: reports at full length */
    int        no_report; /* nonzero: no report, and no progress */
    color_mode color;
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

/* Keep a warning for the report, and tell of it. Equal warnings are kept once. Where warnings are errors, the first becomes the error instead,
 * and message_check says so. */
void warn(message *m, const char *format, ...) MESSAGE_PRINTF_WARN;

/* VXS_OK, or VXS_E_STRICT when a warning has become an error. Called before an output appears. */
vxs_result message_check(const message *m);

/* Release the warnings. Accepts a zeroed object. */
void message_free(message *m);

/* Where a report for people goes: standard output, or standard error when an output takes that; NULL: nowhere. */
FILE *report_stream(const message *m, int stdout_is_taken);

/* 1 when progress may be shown on standard error. */
int progress_wanted(const message *m);

/* The exit status of a command that ended with `code`; results are mapped to statuses here alone (docs/manual.md). */
int exit_status(vxs_result code);

#ifdef __cplusplus
}
#endif
#endif
