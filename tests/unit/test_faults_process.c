/* What a run expects of the system: standard streams that are closed stay closed, whatever is opened later.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/command/process/process.h"

#include <errno.h>
#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

/* last: cmocka's macro fail() hides the function of run_context.h, and it needs the four headers above */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

/* In a process of its own, whose streams `closed` (bit n: stream n) are closed: 0 when all is as it should be. */
static int streams_after(unsigned closed)
{
    for (int n = 0; n < 3; n++)
        if (closed >> n & 1) close(n);
    process_begin();
    int file = open("/dev/null", O_RDWR);
    if (file < 3) return 10;
    char byte = 0;
    for (int n = 0; n < 3; n++) {
        if (!(closed >> n & 1)) continue;
        if ((n ? write(n, &byte, 1) : read(n, &byte, 1)) >= 0 || errno != EBADF) return 11 + n;
    }
    return 0;
}

static void test_closed_streams(void **state)
{
    (void)state;
    for (unsigned closed = 0; closed < 8; closed++) {
        pid_t child = fork();
        assert_true(child >= 0);
        if (!child) _exit(streams_after(closed));
        int status;
        assert_int_equal(waitpid(child, &status, 0), child);
        assert_true(WIFEXITED(status));
        assert_int_equal(WEXITSTATUS(status), 0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_closed_streams)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
