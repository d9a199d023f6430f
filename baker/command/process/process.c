/* Set-up of the process; see process.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/command/process/process.h"

#include <fcntl.h>
#ifdef __GLIBC__
#include <malloc.h>
#endif
#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

#include "baker/base/message.h"
#include "baker/base/threads.h"
#include "baker/command/process/progress_line.h"
#include "baker/files/json_file.h"
#include "baker/files/temporary_files.h"

/* Open a closed standard descriptor in the wrong mode: write-only for standard input, read-only for the other two. Using it
 * stays an error, and no other file gets its number. open returns the lowest free number, so it is this one. */
static void fill_standard_descriptors(void)
{
    for (int number = STDIN_FILENO; number <= STDERR_FILENO; number++)
        if (fcntl(number, F_GETFD) < 0) open("/dev/null", number == STDIN_FILENO ? O_WRONLY : O_RDONLY);
}

static temporary_files temporary;

struct temporary_files *process_temporary_files(void)
{
    return &temporary;
}

void process_return_large(void)
{
#ifdef __GLIBC__
    mallopt(M_MMAP_THRESHOLD, 4 << 20);
#endif
}

void process_remove_temporary(void)
{
    temporary_files_remove(&temporary);
}

/* The signal handler: async-signal-safe calls only. A file that another thread commits meanwhile is either complete or removed. */
static void end_run(int number)
{
    process_remove_temporary();
    progress_clear();
    if (number == SIGINT) _exit(exit_status(VXS_E_INTERRUPTED));
    signal(number, SIG_DFL);
    raise(number); /* takes effect when the handler returns */
}

static void catch_signals(void)
{
    static const int numbers[] = {SIGINT, SIGTERM, SIGHUP};
    for (size_t n = 0; n < sizeof numbers / sizeof *numbers; n++) {
        struct sigaction action;
        if (sigaction(numbers[n], NULL, &action) || (action.sa_flags & SA_SIGINFO) || action.sa_handler != SIG_DFL) continue;
        action = (struct sigaction){.sa_handler = end_run, .sa_flags = SA_RESTART};
        sigfillset(&action.sa_mask);
        sigaction(numbers[n], &action, NULL);
    }
}

/* stacks ----------------------------------------------------------------------------------------------------------------------- */

enum { STACK_LEAST = 1 << 20, STACK_BYTES = 8 << 20 }; /* the least that a run needs, and the usual default of systems */

/* Whether the first thread's stack may grow as far as a run needs. Raises its limit if that is allowed. */
static int has_stack(void)
{
    struct rlimit limit;
    if (getrlimit(RLIMIT_STACK, &limit) || limit.rlim_cur >= STACK_LEAST) return 1;
    limit.rlim_cur = limit.rlim_max < STACK_BYTES ? limit.rlim_max : STACK_BYTES;
    return !setrlimit(RLIMIT_STACK, &limit) && limit.rlim_cur >= STACK_LEAST;
}

typedef struct started {
    int (*run)(int argc, char **argv);
    int    argc, status;
    char **argv;
} started;

static void *run_started(void *user)
{
    started *s = user;
    s->status  = s->run(s->argc, s->argv);
    return NULL;
}

int process_run(int (*run)(int argc, char **argv), int argc, char **argv)
{
    started s = {run, argc, 0, argv};
    process_begin();
    return !has_stack() && threads_run_on_stack(STACK_BYTES, run_started, &s) ? s.status : run(argc, argv);
}

/* ------------------------------------------------------------------------------------------------------------------------------ */

void process_begin(void)
{
    threads_set_stacks(STACK_LEAST, STACK_BYTES); /* the default follows the limit of the process, which may be too small */
    fill_standard_descriptors();
    signal(SIGPIPE, SIG_IGN);
    signal(SIGXFSZ, SIG_IGN);
    catch_signals();
    process_catch_terminate();
    json_watch_memory();
}
