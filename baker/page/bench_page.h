/* The page about benches: what `vxs report` writes.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BENCH_PAGE_H
#define BENCH_PAGE_H

#include "baker/page/bench_plots.h"

/* Write the page: the answers first, then plots, then the tables that they were drawn from. Who calls sees errors of `to`. */
void bench_page_print(FILE *to, const bench_set *set, const bench_plots *plots);

#endif
