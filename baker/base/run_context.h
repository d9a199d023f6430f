/* Messages of a run to its user: at most one error, any number of warnings.
 *
 * The function that detects a failure writes the reason once and returns the code. Its callers only pass the code on.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef RUN_CONTEXT_H
#define RUN_CONTEXT_H

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "baker/base/terminal.h"
#include "formats/vxs_result.h"

#ifdef __cplusplus
extern "C" {
#endif

/* How progress is shown. AUTO: a line on a terminal, else none. JSON: lines on standard error for a program that reads them, also
 * with --quiet. */
typedef enum progress_mode { PROGRESS_AUTO, PROGRESS_JSON } progress_mode;
#define PROGRESS_CHOICES "auto|json"

/* What progress_wanted returns. */
enum { NO_PROGRESS, PROGRESS_LINE, PROGRESS_LINES_OF_JSON };

typedef struct run_context {
    char        error[1024]; /* one line without a newline; "": no failure */
    char      **warnings;    /* [warning_count] one line each, owned */
    size_t      warning_count, warning_capacity;
    vxs_log_fn *log; /* called for each new warning, but not for the error; NULL: warnings are only stored */
    void       *log_user;

    int strict; /* nonzero: the first warning becomes an error */
    int force;  /* nonzero: replace files that are read-only, or that lose attributes (baker/files/replaced_file.h) */
    int wrong;  /* nonzero: the command worked, but found its input wrong: exit status 1 */

    struct run_files *files; /* files of this run (baker/files/run_files.h); borrowed; NULL: not tracked */
    struct temporary_files
        *temporary; /* files that a signal handler removes (baker/files/temporary_files.h); borrowed; NULL: none */
    const struct file_access *access; /* files of the caller (baker/files/file_access.h); borrowed; NULL: files of the system */
    uint64_t                  memory_bytes; /* memory limit of the process (baker/base/memory.h); 0: no limit */

    /* verbosity and colours: for people only; no data depends on them */
    int           verbose;   /* nonzero: full reports */
    int           no_report; /* nonzero: no report, no progress */
    color_mode    color;
    progress_mode progress;
} run_context;

#if defined(__GNUC__)
#define RUN_PRINTF      __attribute__((format(printf, 3, 4)))
#define RUN_PRINTF_WARN __attribute__((format(printf, 2, 3)))
#else
#define RUN_PRINTF
#define RUN_PRINTF_WARN
#endif

/* Record the reason of a failure (the first reason wins) and return `code`, for `return fail(m, CODE, ...)`.
 * The text is one line; control characters become '?'. It names the object (file, element), the place, the value found and the
 * value expected. */
vxs_result fail(run_context *m, vxs_result code, const char *format, ...) RUN_PRINTF;

/* Store a warning for the report, and call m->log. Equal warnings are stored once. With m->strict the first warning becomes the
 * error, and run_check returns VXS_E_STRICT. */
void warn(run_context *m, const char *format, ...) RUN_PRINTF_WARN;

/* VXS_OK, or VXS_E_STRICT when a warning has become an error. Call it before an output appears. */
vxs_result run_check(const run_context *m);

/* Release the warnings. Accepts a zeroed object. */
void run_free(run_context *m);

/* Stream of a report for people: standard output, or standard error when an output uses standard output; NULL: none. */
FILE *report_stream(const run_context *m, int stdout_is_taken);

/* Whether and how progress is shown on standard error: NO_PROGRESS, which is 0, or another of these constants. */
int progress_wanted(const run_context *m);

/* Exit status of a command that ended with `code`. Only this function maps results to statuses (docs/manual.md). */
int exit_status(vxs_result code);

#ifdef __cplusplus
}
#endif
#endif
