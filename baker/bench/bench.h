/* Measuring bakes and lookups: what was measured, of each scene with each combination of options.
 *
 * Every bake and every comparison is a process of its own, so that its time and memory are those of `vxs bake` and `vxs compare`.
 * Runs go round by round over all cells: a slow minute of the machine lies on all of them, not on one.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BENCH_H
#define BENCH_H

#include "baker/base/text.h"
#include "baker/bench/bench_json.h"

/* Options of bake that are swept, in the order of the table of options; a cell for each combination of their values. */
enum { BENCH_SWEEPS = 9 };

typedef struct bench_options {
    const char *const *scenes;
    size_t             scene_count;
    const char        *sweep_name[BENCH_SWEEPS];  /* "--resolution": the first varies slowest */
    text_list          sweep_value[BENCH_SWEEPS]; /* none: what bake does by default */
    text_list          light_names;               /* what follows goes to every bake; NULL or none: not given */
    const char        *sun, *region, *scene_name;
    uint32_t           filters_px[BENCH_FILTERS_MAX]; /* besides single taps: odd, above 1, none twice */
    uint32_t           filter_count;
    uint32_t           runs;
    uint32_t           points;   /* that errors are measured at, of each kind; 0: neither errors nor lookups */
    int                progress; /* 1: say on standard error how far it is */
} bench_options;

/* Measure.
 * result           [out] as docs/bench.schema.json has it; NULL on failure; released with json_decref
 * outputs_differ   [out] 1: it failed because two runs of a cell made different bytes
 * Returns VXS_OK; VXS_E_ARGUMENT when options are wrong or two cells the same, before anything is measured; what a bake or a
 * comparison failed with; VXS_E_WRITE, VXS_E_MEMORY. A signal that ends runs ends this one when
 * its children and its folder are gone.
 * Threads: only in a process of one thread. */
vxs_result bench_run(const bench_options *o, json_t **result, int *outputs_differ, message *m);

#endif
