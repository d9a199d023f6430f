/* Measure bakes and lookups: each scene with each combination of options (a cell).
 *
 * Every bake and every comparison is a process of its own, so that its time and memory are those of `vxs bake` and `vxs
 * compare`. Each round runs all cells once, so that a slow minute of the machine affects all cells alike.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BENCH_H
#define BENCH_H

#include "baker/base/text.h"
#include "baker/command/options/options.h"
#include "baker/lab/bench/bench_json.h"
#include "baker/lab/bench/children.h"

/* Options of bake that can be swept, in the order of the table of options. Each combination of their values is a cell. Values
 * for one light ("sun=512") are combined with those for other lights, and with those for all ("64"). */
enum { BENCH_SWEEPS = 14 };

typedef struct bench_options {
    text_list   scenes;
    const char *sweep_name[BENCH_SWEEPS];  /* "--resolution": the first varies slowest */
    text_list   sweep_value[BENCH_SWEEPS]; /* empty: bake's default */
    text_list   light_names, suns;         /* passed to every bake, too; NULL or empty: not given */
    text_list   exclude, include;
    const char *region, *scene_name;
    int         allow_outside;        /* 1: likewise */
    vxs_filter  filters[FILTERS_MAX]; /* besides single taps; from filters_take */
    uint32_t    filter_count;
    uint32_t    runs;
    uint32_t    points;   /* points of each kind for measuring errors; 0: measure neither errors nor lookups */
    int         progress; /* how progress is shown (progress_wanted) */
} bench_options;

typedef struct bench_job {
    const char  *scene_path; /* "-" when there is an input */
    int          input;      /* file descriptor for the standard input of children; -1: none; borrowed */
    const char **arguments;  /* of the bake: "vxs", "bake", ...; NULL at the end; owned, the texts are not */
    json_t      *cell;       /* of the result: "scene" and "options" */
    json_t      *runs;       /* cells of one run each; owned */
    uint64_t     asset_hash; /* of the first run's bytes */
    double       weight;     /* expected time without a unit, before its first run */
    double       seconds;    /* of its last run; 0: has not run */
} bench_job;

/* Make a job and its cell for each scene and combination of options, checked as bake checks its own.
 * cells  an array to which the cells are added
 * inputs [scene] descriptors; -1: the scene is a file
 * c      where bakes write; outlives the jobs
 * jobs   [out] [count], released with bench_jobs_free, whatever is returned
 * count  [out]
 * Returns VXS_OK; VXS_E_ARGUMENT: a value is wrong, two cells are the same, or there are too many; VXS_E_MEMORY. */
vxs_result bench_jobs_make(bench_job **jobs, size_t *count, json_t *cells, const bench_options *o, const int *inputs,
                           const children *c, run_context *m);

void bench_jobs_free(bench_job *jobs, size_t count);

/* The cell of one run; single numbers where bench_cell_of_runs puts spreads. NULL when out of memory.
 * cell          has its "scene" and "options"
 * bake          the JSON of `vxs bake --json` (docs/bake-report.schema.json)
 * compare       the JSON of `vxs compare --json` (docs/compare.schema.json); NULL: no comparison
 * wall_seconds  of the whole process of the bake */
json_t *bench_cell_of_run(const json_t *cell, const json_t *bake, const json_t *compare, double wall_seconds);

/* Combine the runs of one cell: times become spreads, peaks their maximum; all other values are the same in all runs. NULL when
 * out of memory.
 * runs  an array of at most BENCH_RUNS_MAX; released */
json_t *bench_cell_of_runs(json_t *runs);

/* Measure.
 * result           [out] JSON as in docs/bench.schema.json; NULL on failure; released with json_decref
 * outputs_differ   [out] 1: it failed because two runs of a cell made different bytes
 * Returns VXS_OK; VXS_E_ARGUMENT when options are wrong or two cells the same, before anything is measured; the result of a bake
 * or comparison that failed; VXS_E_WRITE, VXS_E_MEMORY. After a signal that ends runs, it first ends its children and removes
 * its folder; then the signal ends the process.
 * Threads: only in a process of one thread. */
vxs_result bench_run(const bench_options *o, json_t **result, int *outputs_differ, run_context *m);

#endif
