/* How something grows with resolution: a line through its logarithms.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef GROWTH_H
#define GROWTH_H

#include "baker/page/bench_set.h"

/* value(side) = scale * side^slope */
typedef struct growth {
    double slope;
    double scale;
    double factor; /* 2^slope: of a doubling */
    size_t count;  /* bakes that it rests on; 0: fewer than two resolutions, or a value that is not above 0, and no slope */
} growth;

/* Of a cell: what grows. */
typedef double growth_value(const bench_cell *c);

/* Least squares of log2(value) over log2(resolution), of medians. */
growth growth_of(const bench_set *set, const bench_series *s, growth_value *value);

#endif
