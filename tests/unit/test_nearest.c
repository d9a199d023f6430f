/* The word that was probably meant: which edits count, how many, and which of several words it is.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "baker/base/nearest.h"

#include <cmocka.h>

static void is_meant(const char *typed, const char *choices, const char *word)
{
    nearest n = {.typed = typed};
    char    text[64];
    nearest_try_choices(&n, choices);
    assert_string_equal(nearest_text(text, &n), word);
}

#define MEANT(word) ": did you mean '" word "'?"

static void each_edit_is_one(void **state)
{
    (void)state;
    is_meant("bkae", "bake", MEANT("bake")); /* neighbours */
    is_meant("bak", "bake", MEANT("bake"));  /* missing */
    is_meant("abke", "bake", MEANT("bake"));
    is_meant("baake", "bake", MEANT("bake")); /* too many */
    is_meant("bage", "bake", MEANT("bake"));  /* another */
    is_meant("--resolutoin", "--threads|--resolution|--region", MEANT("--resolution"));
    is_meant("atuo", "auto|on|off", MEANT("auto"));
    is_meant("bake", "bake", MEANT("bake"));
    is_meant("BAKE", "rake|bake", MEANT("bake")); /* in other letters */
    is_meant("sUn", "moon|SUN", MEANT("SUN"));
    is_meant("BKAE", "bake", MEANT("bake"));
}

static void far_words_are_not_meant(void **state)
{
    (void)state;
    is_meant("ekab", "bake|plan", "");
    is_meant("toast", "bake|plan|info|validate|query|truth|compare|bench|report|picture|health|mend|scene", "");
    is_meant("", "on|off", "");
    is_meant("x", "on|off", "");
    is_meant("no", "on|off", ""); /* half of a word of two */
    is_meant("abcdefxxx", "abcdefghi", MEANT("abcdefghi"));
    is_meant("abcdexxxx", "abcdefghi", "");       /* a third is the most */
    is_meant("abcdefghxxxx", "abcdefghijkl", ""); /* and three */
    is_meant("abcdefghixxx", "abcdefghijkl", MEANT("abcdefghijkl"));
}

static void the_nearest_wins_and_of_equals_the_first(void **state)
{
    (void)state;
    is_meant("bakes", "baker|bakes1|bake", MEANT("baker"));
    is_meant("planned", "plane|planner|plan", MEANT("planner"));
}

static void long_words_are_not_compared(void **state)
{
    (void)state;
    char most[NEAREST_LENGTH_MAX + 1], more[NEAREST_LENGTH_MAX + 2];
    memset(most, 'a', sizeof most);
    memset(more, 'a', sizeof more);
    most[NEAREST_LENGTH_MAX] = more[NEAREST_LENGTH_MAX + 1] = '\0';
    nearest n                                               = {.typed = most};
    nearest_try(&n, most, strlen(most));
    assert_ptr_equal(n.word, most);
    n = (nearest){.typed = more};
    nearest_try(&n, most, strlen(most));
    assert_null(n.word);
    n = (nearest){.typed = most};
    nearest_try(&n, more, strlen(more));
    assert_null(n.word);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_edit_is_one),
        cmocka_unit_test(far_words_are_not_meant),
        cmocka_unit_test(the_nearest_wins_and_of_equals_the_first),
        cmocka_unit_test(long_words_are_not_compared),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
