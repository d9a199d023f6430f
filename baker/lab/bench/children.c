/* Child processes; see children.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/bench/children.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "baker/base/clock.h"

enum { CANNOT_START = 127 }; /* exit status of a child whose exec failed; the command has no status as large except 130 */

static const struct timespec patience = {.tv_nsec = 500000000};

/* Signals and the folder ------------------------------------------------------------------------------------------------------- */

static char *path_in(const char *folder, const char *name)
{
    char *path;
    return asprintf(&path, "%s/%s", folder, name) < 0 ? NULL : path;
}

vxs_result children_begin(children *c, run_context *m)
{
    const char *parent = getenv("TMPDIR");
    if (!parent || !parent[0]) parent = "/tmp";
    *c = (children){0};

    static const int numbers[] = {SIGINT, SIGTERM, SIGHUP};
    sigemptyset(&c->held);
    sigaddset(&c->held, SIGCHLD);
    for (size_t n = 0; n < sizeof numbers / sizeof *numbers; n++) {
        struct sigaction action;
        if (!sigaction(numbers[n], NULL, &action) && action.sa_handler != SIG_IGN) sigaddset(&c->held, numbers[n]);
    }
    signal(SIGCHLD, SIG_DFL); /* if SIGCHLD is ignored, the exit status of a child is lost */
    sigprocmask(SIG_BLOCK, &c->held, &c->before);

    char *folder = path_in(parent, "vxs-bench-XXXXXX");
    if (folder && !mkdtemp(folder)) {
        int failed = errno;
        free(folder);
        return fail(m, VXS_E_WRITE, "cannot make a folder for temporary files in %s: %s", parent, strerror(failed));
    }
    c->folder = folder;
    c->names  = folder ? opendir(folder) : NULL; /* open it now: it needs memory, which may be exhausted later */
    c->asset  = folder ? path_in(folder, "asset.vxs") : NULL;
    c->report = folder ? path_in(folder, "report.json") : NULL;
    c->errors = folder ? path_in(folder, "errors.txt") : NULL;
    return c->names && c->asset && c->report && c->errors ? VXS_OK : fail(m, VXS_E_MEMORY, "out of memory");
}

void children_end(children *c)
{
    if (c->names) {
        rewinddir(c->names);
        for (struct dirent *entry; (entry = readdir(c->names));) unlinkat(dirfd(c->names), entry->d_name, 0);
        closedir(c->names);
    }
    if (c->folder) rmdir(c->folder);
    free(c->folder);
    free(c->asset);
    free(c->report);
    free(c->errors);
    if (c->caught) raise(c->caught);
    sigprocmask(SIG_SETMASK, &c->before, NULL);
}

/* The child -------------------------------------------------------------------------------------------------------------------- */

static int redirect(const char *path, int flags, int descriptor)
{
    int opened = open(path, flags | O_CLOEXEC, 0666);
    return opened >= 0 && dup2(opened, descriptor) == descriptor;
}

vxs_result child_run(children *c, const char *const *arguments, int input, double *seconds, int *exit_status, run_context *m)
{
    double begin  = clock_seconds();
    pid_t  parent = getpid(), child = fork();
    if (child < 0) return fail(m, VXS_E_MEMORY, "cannot start a process: %s", strerror(errno));
    if (!child) {
        /* between fork and exec: async-signal-safe calls only */
        prctl(PR_SET_PDEATHSIG, SIGTERM);
        if (getppid() != parent) _exit(CANNOT_START);
        int has_input = input < 0 ? redirect("/dev/null", O_RDONLY, STDIN_FILENO)
                                  : lseek(input, 0, SEEK_SET) == 0 && dup2(input, STDIN_FILENO) == STDIN_FILENO;
        if (has_input && redirect("/dev/null", O_WRONLY, STDOUT_FILENO) &&
            redirect(c->errors, O_WRONLY | O_CREAT | O_TRUNC, STDERR_FILENO)) {
            sigprocmask(SIG_SETMASK, &c->before, NULL);
            execv("/proc/self/exe", (char *const *)arguments);
        }
        _exit(CANNOT_START);
    }

    int status;
    while (!waitpid(child, &status, WNOHANG)) {
        int number = sigwaitinfo(&c->held, NULL);
        if (number <= 0 || number == SIGCHLD) continue;

        sigset_t ended;
        sigemptyset(&ended);
        sigaddset(&ended, SIGCHLD);
        kill(child, SIGTERM);
        sigtimedwait(&ended, NULL, &patience);
        if (!waitpid(child, NULL, WNOHANG)) {
            kill(child, SIGKILL);
            waitpid(child, NULL, 0);
        }

        c->caught = number;
        return fail(m, VXS_E_INTERRUPTED, "interrupted");
    }
    *seconds     = clock_seconds() - begin;
    *exit_status = WIFSIGNALED(status) ? -WTERMSIG(status) : WEXITSTATUS(status);
    if (*exit_status == CANNOT_START)
        return fail(m, VXS_E_MEMORY, "cannot start a process of this command, or write to %s", c->errors);
    return VXS_OK;
}
