// peak FILE COMMAND...: run a command, write into FILE the most bytes that it has held, and end as it does. A process of its own,
// because what the parent holds when it forks counts for the child.
// SPDX-License-Identifier: GPL-3.0-or-later
#define _GNU_SOURCE
#include <signal.h>
#include <stdio.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

int main(int argc, char **argv)
{
    struct rusage usage;
    int           status;
    if (argc < 3) return 99;
    pid_t child = fork();
    if (!child) {
        execv(argv[2], argv + 2);
        _exit(98);
    }
    if (wait4(child, &status, 0, &usage) != child) return 97;
    FILE *file = fopen(argv[1], "w");
    if (!file || fprintf(file, "%lld\n", usage.ru_maxrss * 1024LL) < 0 || fclose(file)) return 96;
    if (WIFSIGNALED(status)) kill(getpid(), WTERMSIG(status));
    return WEXITSTATUS(status);
}
