/* Set-up of the process; see process.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/command/process/process.h"

#include <fcntl.h>
#ifdef __GLIBC__
#include <malloc.h>
#endif
#include <signal.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

#include "baker/base/clock.h"
#include "baker/base/run_context.h"
#include "baker/base/system.h"
#include "baker/base/text.h"
#include "baker/base/threads.h"
#include "baker/files/json_file.h"
#include "baker/files/temporary_files.h"

static const char clear_line[] = "\r\033[K";

static atomic_int line_shown; /* a signal handler reads it */

void progress_clear(void)
{
    if (!atomic_exchange(&line_shown, 0)) return;
    if (write(STDERR_FILENO, clear_line, sizeof clear_line - 1) < 0) return; /* ignore errors: the terminal is gone */
}

/* Longer lines would wrap on narrow terminals, and could not be cleared. */
enum { LINE_MAX_BYTES = 79 };

/* ", about 12 s left"; "" when unknown, or about to end. */
static void time_left(char text[32], double seconds)
{
    text[0] = 0;
    if (seconds >= 120)
        snprintf(text, 32, ", about %.0f min left", seconds / 60);
    else if (seconds >= 0.5)
        snprintf(text, 32, ", about %.0f s left", seconds);
}

static const double interval_seconds = 0.1;

static double printed_at;

/* {"share": 0.42, "seconds_left": 12, "doing": "TEXT"}. Nothing without memory. */
static void print_json(double share, double seconds_left, const char *doing)
{
    json_t *line = json_object();
    if (share >= 0) json_set(&line, "share", json_real(share));
    if (seconds_left >= 0) json_set(&line, "seconds_left", json_real(seconds_left));
    json_set(&line, "doing", json_text(doing));
    char *text = json_whole_text(line, JSON_COMPACT | JSON_REAL_PRECISION(4));
    if (text) fprintf(stderr, "%s\n", text);
    free(text);
    json_decref(line);
}

/* share, seconds_left  negative: unknown */
static void print_progress(int shown, double share, double seconds_left, const char *format, va_list args)
{
    char text[LINE_MAX_BYTES + 1], line[LINE_MAX_BYTES + 1], left[32];
    printed_at = clock_seconds();
    if (shown == PROGRESS_LINES_OF_JSON) {
        vsnprintf(text, sizeof text, format, args);
        print_json(share, seconds_left, one_line(text));
        return;
    }
    time_left(left, seconds_left);
    int room = LINE_MAX_BYTES - (int)strlen("vxs: ") - (int)strlen(left);
    vsnprintf(text, (size_t)room + 1, format, args);
    snprintf(line, sizeof line, "vxs: %s%s", one_line(text), left);

    /* Replace the line by a text, on standard error. */
    atomic_store(&line_shown, 1);
    fprintf(stderr, "%s%s", clear_line, line);
    fflush(stderr);
}

void progress_say(int shown, const char *format, ...)
{
    if (!shown) return;
    va_list args;
    va_start(args, format);
    print_progress(shown, -1, -1, format, args);
    va_end(args);
}

void progress_share(int shown, double share, double since, const char *format, ...)
{
    double now = shown ? clock_seconds() : 0;
    /* a line that was cleared is shown again at once */
    if (!shown || ((shown == PROGRESS_LINES_OF_JSON || atomic_load(&line_shown)) && now - printed_at < interval_seconds)) return;
    va_list args;
    va_start(args, format);
    print_progress(shown, share, share > 0 ? (now - since) / share * (1 - share) : -1, format, args);
    va_end(args);
}

static void watch_shown(void *user, const char *doing)
{
    (void)user;
    if (system_shows_progress())
        system_show_progress(-1, doing);
    else
        progress_say(PROGRESS_LINE, "%s", doing);
}

static void watch_shared(void *user, double share, double since, const char *doing)
{
    (void)user;
    if (system_shows_progress())
        system_show_progress(share, doing);
    else
        progress_share(PROGRESS_LINE, share, since, "%u %%: %s", (unsigned)(100 * share), doing);
}

static void json_shown(void *user, const char *doing)
{
    (void)user;
    progress_say(PROGRESS_LINES_OF_JSON, "%s", doing);
}

static void json_shared(void *user, double share, double since, const char *doing)
{
    (void)user;
    progress_share(PROGRESS_LINES_OF_JSON, share, since, "%s", doing);
}

const run_watch *progress_watch(const run_context *m)
{
    static const run_watch line = {.say = watch_shown, .share = watch_shared}, json = {.say = json_shown, .share = json_shared};
    int                    shown = progress_wanted(m);
    return shown == PROGRESS_LINES_OF_JSON ? &json : shown ? &line : NULL;
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
    mallopt(M_TRIM_THRESHOLD, 4 << 20);
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
    /* Open a closed standard descriptor in the wrong mode: write-only for standard input, read-only for the other two. Using it
     * stays an error, and no other file gets its number. open returns the lowest free number, so it is this one. */
    for (int number = STDIN_FILENO; number <= STDERR_FILENO; number++)
        if (fcntl(number, F_GETFD) < 0) open("/dev/null", number == STDIN_FILENO ? O_WRONLY : O_RDONLY);
    signal(SIGPIPE, SIG_IGN);
    signal(SIGXFSZ, SIG_IGN);

    static const int numbers[] = {SIGINT, SIGTERM, SIGHUP};
    for (size_t n = 0; n < sizeof numbers / sizeof *numbers; n++) {
        struct sigaction action;
        if (sigaction(numbers[n], NULL, &action) || (action.sa_flags & SA_SIGINFO) || action.sa_handler != SIG_DFL) continue;
        action = (struct sigaction){.sa_handler = end_run, .sa_flags = SA_RESTART};
        sigfillset(&action.sa_mask);
        sigaction(numbers[n], &action, NULL);
    }

    process_catch_terminate();
    json_watch_memory();
}
