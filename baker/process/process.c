/* What a run expects of the system; see process.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/process/process.h"

#include <fcntl.h>
#include <signal.h>
#include <unistd.h>

#include "baker/files/json_file.h"
#include "baker/files/output_file.h"

/* A number that is free is given to what can only be used the wrong way round: reading standard input is then an error, like writing
 * the other two. open takes the lowest number that is free. */
static void fill_standard_descriptors(void)
{
    for (int number = STDIN_FILENO; number <= STDERR_FILENO; number++)
        if (fcntl(number, F_GETFD) < 0) open("/dev/null", number == STDIN_FILENO ? O_WRONLY : O_RDONLY);
}

void process_begin(void)
{
    fill_standard_descriptors();
    signal(SIGPIPE, SIG_IGN);
    signal(SIGXFSZ, SIG_IGN);
    output_file_catch_signals();
    process_catch_terminate();
    json_watch_memory();
}
