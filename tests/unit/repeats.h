/* How much of a test with many random inputs is queried: a part, or all of it where VXS_TEST_REPEATS=all (make check-repeats).
 * Whatever a test is there to see has to show in the part.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef REPEATS_H
#define REPEATS_H

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

/* A count, or a step through a list. */
static inline uint32_t repeats(uint32_t part, uint32_t all)
{
    const char *asked = getenv("VXS_TEST_REPEATS");
    return asked && !strcmp(asked, "all") ? all : part;
}

#endif
