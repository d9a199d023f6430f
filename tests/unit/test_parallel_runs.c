/* Messages of work on many threads are those of the same work in turn.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/base/parallel_runs.h"

#include <stdio.h>
#include <string.h>

/* last: cmocka's macro fail() hides the function of run_context.h, and it needs the four headers above */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#undef fail

enum { PIECES = 200 };

typedef struct work {
    size_t  fails_from;   /* pieces from here on fail */
    uint8_t done[PIECES]; /* 1: the piece has run */
} work;

static vxs_result one(void *user, size_t n, uint32_t worker, run_context *own)
{
    work *w = user;
    (void)worker;
    w->done[n] = 1;
    warn(own, "piece %zu", n / 2 * 2); /* equal warnings are stored once */
    return n < w->fails_from ? VXS_OK : fail(own, VXS_E_SCENE, "piece %zu failed", n);
}

/* Checks result, error and warnings of pieces that fail from a number on. */
static void check(uint32_t threads, size_t fails_from, int strict)
{
    run_context m = {.strict = strict};
    work        w = {.fails_from = fails_from};
    vxs_result  r = parallel_runs(threads, PIECES, one, &w, &m);
    char        text[64];
    size_t      ran = fails_from < PIECES ? fails_from + 1 : PIECES;
    assert_int_equal(r, fails_from < PIECES ? VXS_E_SCENE : VXS_OK);
    for (size_t n = 0; n < ran; n++) assert_int_equal(w.done[n], 1);
    snprintf(text, sizeof text, "piece %zu failed", fails_from);
    if (strict)
        assert_non_null(strstr(m.error, "piece 0 (--strict"));
    else
        assert_string_equal(m.error, fails_from < PIECES ? text : "");
    assert_int_equal(m.warning_count, strict ? 0 : (ran + 1) / 2);
    for (size_t n = 0; n < m.warning_count; n++) {
        snprintf(text, sizeof text, "piece %zu", 2 * n);
        assert_string_equal(m.warnings[n], text);
    }
    run_free(&m);
}

static void test_messages_in_order(void **state)
{
    (void)state;
    for (uint32_t threads = 1; threads <= 8; threads *= 2)
        for (int strict = 0; strict <= 1; strict++) {
            check(threads, PIECES, strict);
            check(threads, 0, strict);
            check(threads, 117, strict);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_messages_in_order)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
