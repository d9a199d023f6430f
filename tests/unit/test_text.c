/* Sizes in words (baker/base/text.h): in the largest unit of which there is one or more.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include "baker/base/text.h"

#include <cmocka.h>

static void sizes(void **state)
{
    static const struct {
        uint64_t    bytes;
        const char *text;
    } known[] = {{0, "0 B"},
                 {10239, "10239 B"},
                 {10240, "10.0 KiB"},
                 {102 * 1024 + 512, "102.5 KiB"},
                 {1023 * 1024, "1023.0 KiB"},
                 {1048520, "1023.9 KiB"},
                 {1048530, "1.00 MiB"}, /* which rounds to 1024.0 KiB */
                 {1630535, "1.55 MiB"}, /* was 1592.3 KiB */
                 {10474200, "9.99 MiB"},
                 {10485760, "10.0 MiB"},
                 {(uint64_t)1 << 30, "1.00 GiB"},
                 {(uint64_t)40 << 30, "40.0 GiB"},
                 {(uint64_t)3 << 40, "3.00 TiB"},
                 {(uint64_t)5000 << 40, "5000.0 TiB"}};
    char text[32];
    (void)state;
    for (size_t n = 0; n < sizeof known / sizeof *known; n++) assert_string_equal(size_text(text, known[n].bytes), known[n].text);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(sizes)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
