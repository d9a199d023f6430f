/* Set-up of the process before a command runs.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef PROCESS_H
#define PROCESS_H

#include "baker/base/watch.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Call first, before a file is opened or a thread is started.
 * Descriptors: a closed standard input, output or error stays an error to use, and no file opened later gets its number. Else a
 * report could be written into the asset.
 * Errors of writing: a reader that has closed the pipe (terminal.h), or a file above its size limit, is an error and does not
 * end the process.
 * Signals: SIGINT, SIGTERM and SIGHUP remove the temporary files of a run, and then end it: SIGINT with the exit status of an
 * interrupted run, the others with their default action. Ignored signals stay ignored; handlers of the caller stay installed.
 * Memory: when an allocation fails where C++ cannot throw, as in a destructor, the process ends with the usual line and exit
 * status.
 * Threads: stacks have at least a megabyte. */
void process_begin(void);

/* Call process_begin, then run(argc, argv): on a new thread with a larger stack, if the stack limit of the process (ulimit -s)
 * is too small.
 * Returns what run returns. */
int process_run(int (*run)(int argc, char **argv), int argc, char **argv);

/* The part of process_begin that is C++: sets the terminate handler. */
void process_catch_terminate(void);

/* From now on, free every array of a few megabytes to the system at once. By default glibc keeps such arrays after some were
 * freed, and small allocations between them hold their memory: a bake of many lights grew with each light. Less than such an array at
 * the end of the heap is kept: with a limit of its own, glibc gives back 128 KiB at a time, and pages are new again and again. */
void process_return_large(void);

/* The temporary files that a signal handler removes: those of a run whose messages borrow this (run_context.h). */
struct temporary_files *process_temporary_files(void);

/* Remove all temporary files, before a fatal end of the process. Async-signal-safe. */
void process_remove_temporary(void);

/* Progress of a run: one line on a terminal, overwritten each time and cleared at the end.
 *
 *     progress_say(shown, "reading %s", path);
 *     double since = clock_seconds();
 *     for (...) progress_share(shown, (double)done / count, since, "light %s: square %u of %u", ...);
 *     progress_clear();
 *
 * With --progress json, instead: a line {"share": 0.42, "seconds_left": 12, "doing": "TEXT"} each time, not overwritten; share and
 * seconds_left only where they are known.
 *
 * shown  progress_wanted()   Threads: one at a time. */

#if defined(__GNUC__)
#define PROGRESS_PRINTF(text, values) __attribute__((format(printf, text, values)))
#else
#define PROGRESS_PRINTF(text, values)
#endif

/* Show "vxs: TEXT", before work of unknown length. TEXT may contain text from files (one_line). */
void progress_say(int shown, const char *format, ...) PROGRESS_PRINTF(2, 3);

/* Show "vxs: TEXT, about 12 s left", at most ten times a second.
 * share  of the work that is done, 0 to 1;   since  clock_seconds() at the start of the work */
void progress_share(int shown, double share, double since, const char *format, ...) PROGRESS_PRINTF(4, 5);

/* Run callbacks that show progress in this way; NULL: no progress is shown. */
const run_watch *progress_watch(const run_context *m);

/* The progress line of a terminal (baker/command/process/process.h): the part that every function that prints needs. */

/* Clear the progress line. Call before anything else is printed, and at the end. No effect without a line. Async-signal-safe. */
void progress_clear(void);

#ifdef __cplusplus
}
#endif

#endif
