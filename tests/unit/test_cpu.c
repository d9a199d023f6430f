/* What loops are chosen by: the processor, and what the environment leaves of it.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include "baker/base/cpu.h"

#include <cmocka.h>

static void the_environment_only_takes_away(void **state)
{
    (void)state;
    int all = cpu_level_of_machine();
    setenv("VXS_CPU", "sse2", 1);
    assert_int_equal(cpu_level(), CPU_SSE2);
    setenv("VXS_CPU", "avx2", 1);
    assert_int_equal(cpu_level(), all < CPU_AVX2 ? all : CPU_AVX2);
    setenv("VXS_CPU", "avx512", 1);
    assert_int_equal(cpu_level(), all);
    setenv("VXS_CPU", "avx", 1);
    assert_int_equal(cpu_level(), all);
    unsetenv("VXS_CPU");
    assert_int_equal(cpu_level(), all);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(the_environment_only_takes_away)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
