/* What is to be measured: a job for each cell.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BENCH_JOBS_H
#define BENCH_JOBS_H

#include <xxhash.h>

#include "baker/bench/bench.h"
#include "baker/bench/work_folder.h"

typedef struct bench_job {
    const char   *scene_path;
    const char  **arguments;  /* of the bake: "vxs", "bake", ...; NULL at the end; owned, the texts are not */
    json_t       *cell;       /* of the result */
    XXH128_hash_t asset_hash; /* of the first run's bytes */
    double        weight;     /* how long it may take, in no unit, until it has run */
    double        seconds;    /* that its last run took; 0: has not run */
} bench_job;

/* Make a job and its cell for each scene and combination of options, checked as bake checks its own.
 * cells  an array, which gets the cells
 * f      where bakes write; outlives the jobs
 * jobs   [out] [count], released with bench_jobs_free, whatever is returned
 * count  [out]
 * Returns VXS_OK; VXS_E_ARGUMENT: a value is wrong, two cells are the same, or there are too many; VXS_E_MEMORY. */
vxs_result bench_jobs_make(bench_job **jobs, size_t *count, json_t *cells, const bench_options *o, const work_folder *f,
                           message *m);

void bench_jobs_free(bench_job *jobs, size_t count);

#endif
