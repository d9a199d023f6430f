/* Set-up of the process; see process.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/command/process/process.h"

#include <fcntl.h>
#ifdef __GLIBC__
#include <malloc.h>
#endif
#include <pthread.h>
#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

#include "baker/base/message.h"
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

/* Set the default stack size of threads, including those of libraries. It follows the limit of the process, which may be too
 * small. */
static void give_threads_stacks(void)
{
#ifdef __GLIBC__
    pthread_attr_t attributes;
    size_t         size;
    if (pthread_getattr_default_np(&attributes)) return;
    if (!pthread_attr_getstacksize(&attributes, &size) && size < STACK_LEAST &&
        !pthread_attr_setstacksize(&attributes, STACK_BYTES))
        pthread_setattr_default_np(&attributes);
    pthread_attr_destroy(&attributes);
#endif
}

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
    started        s = {run, argc, 0, argv};
    pthread_attr_t attributes;
    pthread_t      thread;
    process_begin();
    if (has_stack() || pthread_attr_init(&attributes)) return run(argc, argv);
    int failed = pthread_attr_setstacksize(&attributes, STACK_BYTES) || pthread_create(&thread, &attributes, run_started, &s);
    pthread_attr_destroy(&attributes);
    if (failed) return run(argc, argv);
    sigset_t all;
    sigfillset(&all);
    pthread_sigmask(SIG_BLOCK, &all, NULL); /* the other thread handles signals */
    pthread_join(thread, NULL);
    return s.status;
}

/* ------------------------------------------------------------------------------------------------------------------------------ */

void process_begin(void)
{
    give_threads_stacks();
    fill_standard_descriptors();
    signal(SIGPIPE, SIG_IGN);
    signal(SIGXFSZ, SIG_IGN);
    catch_signals();
    process_catch_terminate();
    json_watch_memory();
}
