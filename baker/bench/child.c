/* Child processes; see child.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/bench/child.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "baker/measure/clock.h"

enum { CANNOT_START = 127 }; /* exit status of a child that is not yet the command; the command has none so large but 130 */

static const struct timespec patience = {.tv_nsec = 500000000};

/* Signals -------------------------------------------------------------------------------------------------------------------- */

void interrupts_hold(interrupts *i)
{
    static const int numbers[] = {SIGINT, SIGTERM, SIGHUP};
    i->caught                  = 0;
    sigemptyset(&i->held);
    sigaddset(&i->held, SIGCHLD);
    for (size_t n = 0; n < sizeof numbers / sizeof *numbers; n++) {
        struct sigaction action;
        if (!sigaction(numbers[n], NULL, &action) && action.sa_handler != SIG_IGN) sigaddset(&i->held, numbers[n]);
    }
    signal(SIGCHLD, SIG_DFL); /* where it is ignored nobody learns how a child ended */
    sigprocmask(SIG_BLOCK, &i->held, &i->before);
}

void interrupts_release(interrupts *i)
{
    if (i->caught) raise(i->caught);
    sigprocmask(SIG_SETMASK, &i->before, NULL);
}

/* The child ------------------------------------------------------------------------------------------------------------------ */

static int redirect(const char *path, int flags, int descriptor)
{
    int opened = open(path, flags | O_CLOEXEC, 0666);
    return opened >= 0 && dup2(opened, descriptor) == descriptor;
}

/* Between fork and exec: only what is safe in a signal handler. */
static void become(const interrupts *i, const char *const *arguments, const char *error_path, pid_t parent)
{
    prctl(PR_SET_PDEATHSIG, SIGTERM);
    if (getppid() != parent) _exit(CANNOT_START);
    if (redirect("/dev/null", O_RDONLY, STDIN_FILENO) && redirect("/dev/null", O_WRONLY, STDOUT_FILENO) &&
        redirect(error_path, O_WRONLY | O_CREAT | O_TRUNC, STDERR_FILENO)) {
        sigprocmask(SIG_SETMASK, &i->before, NULL);
        execv("/proc/self/exe", (char *const *)arguments);
    }
    _exit(CANNOT_START);
}

static void stop(pid_t child)
{
    sigset_t ended;
    sigemptyset(&ended);
    sigaddset(&ended, SIGCHLD);
    kill(child, SIGTERM);
    sigtimedwait(&ended, NULL, &patience);
    if (!waitpid(child, NULL, WNOHANG)) {
        kill(child, SIGKILL);
        waitpid(child, NULL, 0);
    }
}

vxs_result child_run(interrupts *i, const char *const *arguments, const char *error_path, child_end *end, message *m)
{
    double begin  = clock_seconds();
    pid_t  parent = getpid(), child = fork();
    if (child < 0) return fail(m, VXS_E_MEMORY, "cannot start a process: %s", strerror(errno));
    if (!child) become(i, arguments, error_path, parent);

    int status;
    while (!waitpid(child, &status, WNOHANG)) {
        int number = sigwaitinfo(&i->held, NULL);
        if (number <= 0 || number == SIGCHLD) continue;
        stop(child);
        i->caught = number;
        return fail(m, VXS_E_INTERRUPTED, "interrupted");
    }
    end->seconds     = clock_seconds() - begin;
    end->exit_status = WIFSIGNALED(status) ? -WTERMSIG(status) : WEXITSTATUS(status);
    if (end->exit_status == CANNOT_START)
        return fail(m, VXS_E_MEMORY, "cannot start a process of this command, or write to %s", error_path);
    return VXS_OK;
}
