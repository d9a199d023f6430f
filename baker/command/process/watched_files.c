/* Watched files and processes on Linux; see watched_files.h. baker/web/system_web.c has what WebAssembly does instead.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/command/process/watched_files.h"

#include <errno.h>
#include <limits.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/inotify.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

int run_apart(int (*run)(void *work), void *work)
{
    int status;
    fflush(NULL);
    pid_t child = fork();
    if (child < 0) return -1;
    if (!child) {
        prctl(PR_SET_PDEATHSIG, SIGTERM); /* a bake does not outlive the command that watches */
        status = run(work);
        fflush(NULL);
        _exit(status);
    }
    while (waitpid(child, &status, 0) < 0)
        if (errno != EINTR) return -1;
    return WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
}

static const char *name_in_folder(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

int watched_files_begin(const char *const *paths, size_t count)
{
    /* folders are watched: editors put a new file in the place of the old one */
    int descriptor = inotify_init1(IN_CLOEXEC);
    for (size_t n = 0; n < count && descriptor >= 0; n++) {
        char folder[PATH_MAX];
        int  length = (int)(name_in_folder(paths[n]) - paths[n]);
        if ((size_t)length >= sizeof folder - 1) continue;
        snprintf(folder, sizeof folder, "%.*s", length ? length : 1, length ? paths[n] : ".");
        if (inotify_add_watch(descriptor, folder, IN_CLOSE_WRITE | IN_MOVED_TO | IN_ONLYDIR) < 0 && !n) {
            close(descriptor);
            return -1;
        }
    }
    return descriptor;
}

/* Take in events. Returns 1 when one is about the name of a watched file, 0 when none is, -1 on an error. */
static int watched_change(int descriptor, const char *const *paths, size_t count)
{
    union {
        struct inotify_event first;
        char                 bytes[4096];
    } events;
    ssize_t size = read(descriptor, &events, sizeof events);
    if (size < 0) return errno == EINTR || errno == EAGAIN ? 0 : -1;
    int changed = 0;
    for (ssize_t at = 0; at < size;) {
        const struct inotify_event *event = (const void *)(events.bytes + at);
        changed |= (event->mask & IN_Q_OVERFLOW) != 0;
        for (size_t n = 0; n < count && event->len; n++) changed |= !strcmp(event->name, name_in_folder(paths[n]));
        at += (ssize_t)(sizeof *event + event->len);
    }
    return changed;
}

int watched_files_wait(int descriptor, const char *const *paths, size_t count, int quiet_ms)
{
    int           changed = 0, seen = 0, ready;
    struct pollfd waiting = {.fd = descriptor, .events = POLLIN};
    while (seen >= 0 && ((ready = poll(&waiting, 1, changed ? quiet_ms : -1)) || !changed))
        if (ready > 0)
            changed |= (seen = watched_change(descriptor, paths, count)) > 0;
        else if (ready < 0 && errno != EINTR)
            seen = -1;
    close(descriptor);
    return seen >= 0;
}
