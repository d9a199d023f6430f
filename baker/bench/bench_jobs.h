/* What is to be measured: a job for each cell.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BENCH_JOBS_H
#define BENCH_JOBS_H

#include <xxhash.h>

#include "baker/bench/bench.h"

/* Figures that have a spread: a row of samples each. */
enum {
    ROW_WALL,
    ROW_TOTAL,
    ROW_MAPS_TO_DAG,
    ROW_RAY,
    ROW_LOOKUP,
    ROW_STAGE = ROW_LOOKUP + BENCH_FILTERS_MAX,
    ROW_COUNT = ROW_STAGE + BENCH_STAGES_MAX
};

typedef struct bench_job {
    const char   *scene_path;
    const char  **arguments; /* of the bake, but its outputs: options, "--", the scene; NULL at the end; owned, the texts are not */
    bench_cell   *cell;
    double       *samples;    /* [ROW_COUNT * runs] owned */
    XXH128_hash_t asset_hash; /* of the first run's bytes */
    double        weight;     /* how long it may take, in no unit, until it has run */
    double        seconds;    /* that its last run took; 0: has not run */
} bench_job;

/* Make a cell with its key, and a job, for each scene and combination of options, checked as bake checks its own.
 * result  gets its cells
 * jobs    [out] [result->cell_count], released with bench_jobs_free, whatever is returned
 * Returns VXS_OK; VXS_E_ARGUMENT: a value is wrong, two cells are the same, or there are too many; VXS_E_MEMORY. */
vxs_result bench_jobs_make(bench_job **jobs, bench_result *result, const bench_options *o, message *m);

void bench_jobs_free(bench_job *jobs, size_t count);

/* The samples of a figure, one for each run. */
static inline double *job_row(const bench_job *job, int row, uint32_t runs)
{
    return job->samples + (size_t)row * runs;
}

#endif
