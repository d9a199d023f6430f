/* Context that each stage of a bake gets beside its inputs: destination of errors, time, memory and progress.
 *
 *     stage_begin(ctx, STAGE_MASKS);       // time counts for STAGE_MASKS from here on
 *     ...
 *     stage_begin(ctx, STAGE_INSERT);
 *     ...
 *     stage_begin(ctx, STAGE_NONE);        // time counts for no stage from here on
 *
 * Threads: one at a time. A stage that uses many threads reports from the thread that started it.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CONTEXT_H
#define CONTEXT_H

#include <stdint.h>

#include "baker/base/run_context.h"
#include "baker/base/watch.h"

typedef enum bake_stage {
    STAGE_LOAD,                  /* glTF to triangles */
    STAGE_SOLIDS,                /* weld, components, solids and sheets */
    STAGE_PLAN,                  /* needs of the scene, and which solids meet */
    STAGE_GL,                    /* OpenGL context, vertices in light space */
    STAGE_MAPS,                  /* enter and exit depth */
    STAGE_PYRAMID,               /* min-max pyramid */
    STAGE_MASKS,                 /* visibility masks */
    STAGE_INSERT,                /* sub-DAGs */
    STAGE_COMPRESS,              /* compression of sub-DAGs */
    STAGE_MERGE,                 /* merging into one DAG */
    STAGE_ENCODE,                /* sections, zstd */
    STAGE_SMOKE,                 /* transmittance of smoke for each light */
    STAGE_WRITE,                 /* check the encoded data, write the file */
    STAGE_COUNT,                 /* number of stages that make an asset; later stages do not count in its time */
    STAGE_PICTURE = STAGE_COUNT, /* pictures of the maps, for a page */
    STAGE_NONE
} bake_stage;

typedef struct stage_report {
    double seconds; /* wall time over all tiles and lights */

    /* Peak memory of the process during the stage, if this stage raised the peak of the process; else the larger of the amounts
     * held at the begin and at the end of the stage. 0: unknown. */
    uint64_t peak_bytes;
} stage_report;

/* Zero it, then set the fields marked [in]. */
typedef struct bake_context {
    run_context     *run;          /* [in] borrowed */
    uint32_t         threads;      /* [in] [1, PARALLEL_THREADS_MAX] for stages that share their work */
    const run_watch *watch;        /* [in] receives progress; NULL: not wanted; borrowed */
    const char      *subject;      /* [in] name of the work in messages: the path of the scene; borrowed */
    uint64_t         memory_bytes; /* [in] memory limit of the process; 0: no limit */
    int              unmeasured;   /* [in] 1: memory is not measured: this is one of many contexts that are in use at once */

    stage_report stage[STAGE_NONE];
    uint64_t     peak_bytes; /* maximum over the stages that make an asset */

    bake_stage at;          /* current stage; meaningful while stage_since > 0 */
    double     stage_since; /* clock_seconds() when the current stage began */
    uint64_t   held_bytes;  /* memory held when the current stage began */
    uint64_t   past_peak;   /* peak of the process before the current stage */

    /* progress through steps of known length: the tiles of a light */
    double   begun;         /* [in] clock_seconds() when the whole work began */
    double   total_seconds; /* [in] planned for the whole work; 0: no plan */
    double   past_seconds;  /* [in] part of total_seconds that is done */
    char     doing[96];     /* "light sun: tile" */
    uint32_t steps, steps_done;
    double   step_seconds; /* planned for each step */
} bake_context;

/* End the current stage and begin another. STAGE_NONE only ends. */
void stage_begin(bake_context *ctx, bake_stage stage);

/* The same, after several stages took turns on many threads within the current stage. The wall time is divided among the stages
 * first, first + 1, ..., in proportion to `seconds` [count], each summed over all threads. */
void stage_begin_after(bake_context *ctx, bake_stage stage, bake_stage first, const double *seconds, uint32_t count);

const char *bake_stage_name(bake_stage stage);

/* Returns VXS_E_INTERRUPTED when the run was cancelled (run_control.h); VXS_E_MEMORY when peak_bytes exceeds memory_bytes, since
 * estimates may be too low; else VXS_OK. */
vxs_result context_check(const bake_context *ctx);

/* 0 when the process holds more than memory_bytes now. From any thread. */
int context_has_memory(const bake_context *ctx);

/* Begin `steps` steps of `seconds_each` planned seconds. `doing` names them in progress lines, as in "light sun: tile". */
void steps_begin(bake_context *ctx, uint32_t steps, double seconds_each, const char *doing);

/* Report the finished share of the current step, [0, 1]. */
void step_part(bake_context *ctx, double part);

/* Report that `steps` more steps are done. */
void steps_done(bake_context *ctx, uint32_t steps);

#endif
