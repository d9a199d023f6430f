/* What a run expects of the system before it begins.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef PROCESS_H
#define PROCESS_H

#ifdef __cplusplus
extern "C" {
#endif

/* Call first, before a file is opened or a thread is started.
 * A closed standard input, output or error stays useless, and using it an error, but no file that is opened later takes its
 * number: a report would go into the asset. A reader that has gone away (terminal.h) and a file that grows beyond a limit are
 * errors of writing, not the end of the process. SIGINT, SIGTERM and SIGHUP take the temporary files of a run with them, and
 * then end it: SIGINT with the exit status of an interrupted run, the others as they do by default. A signal that is ignored
 * stays ignored, a handler of the caller's stays too. Memory that is missing where C++ cannot throw, in a destructor, ends the
 * process as it does elsewhere: one line, and the exit status for it. Threads have stacks of a megabyte at least. */
void process_begin(void);

/* Begin, and run main's work: on a thread with a stack of its own where that of the process may not grow as far as a run needs
 * (ulimit -s).
 * Returns what it returns. */
int process_run(int (*run)(int argc, char **argv), int argc, char **argv);

/* The last part, which is C++. */
void process_catch_terminate(void);

/* From now on every array of a few megabytes goes back to the system when it is freed. Else glibc keeps such arrays once some
 * were freed, and small ones that lie between them hold their memory: a bake of many lights grew with each. */
void process_return_large(void);

/* The temporary files that a signal removes: those of a run whose messages borrow this (message.h). */
struct temporary_files *process_temporary_files(void);

/* Remove those that there are, before a process ends that cannot go on. Safe in a signal handler. */
void process_remove_temporary(void);

#ifdef __cplusplus
}
#endif

#endif
