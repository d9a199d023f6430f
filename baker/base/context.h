/* What a stage of a bake is given beside its inputs: where errors, time, memory and progress go.
 *
 *     stage_begin(ctx, STAGE_MASKS);       // what passes from here on is the masks'
 *     ...
 *     stage_begin(ctx, STAGE_INSERT);
 *     ...
 *     stage_begin(ctx, STAGE_NONE);        // and from here on nobody's
 *
 * Threads: one at a time; a stage that works on many threads reports from the one that started it.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CONTEXT_H
#define CONTEXT_H

#include <stdint.h>

#include "baker/base/message.h"
#include "baker/base/watch.h"

typedef enum bake_stage {
    STAGE_LOAD,                  /* glTF to triangles */
    STAGE_SOLIDS,                /* weld, components, solids and sheets */
    STAGE_PLAN,                  /* what the scene needs, and which solids meet */
    STAGE_GL,                    /* OpenGL context, vertices in light space */
    STAGE_MAPS,                  /* enter and exit depth */
    STAGE_PYRAMID,               /* min-max pyramid */
    STAGE_MASKS,                 /* visibility masks */
    STAGE_INSERT,                /* sub-DAGs */
    STAGE_COMPRESS,              /* sub-DAG compression */
    STAGE_MERGE,                 /* into one DAG */
    STAGE_ENCODE,                /* sections, zstd */
    STAGE_SMOKE,                 /* what smoke leaves of each light */
    STAGE_WRITE,                 /* reading back what was encoded, and the file */
    STAGE_COUNT,                 /* of the stages that make an asset; the rest are no part of its time */
    STAGE_PICTURE = STAGE_COUNT, /* of the maps, for a page */
    STAGE_NONE
} bake_stage;

typedef struct stage_report {
    double seconds; /* wall time over all tiles and lights */
    uint64_t
        peak_bytes; /* most memory that the process held while in this stage, where that is more than ever before; else what it held when
                            the stage began or ended; 0 where the system does not tell */
} stage_report;

/* Zero it, but for what is marked. */
typedef struct bake_context {
    message         *message;      /* [in] borrowed */
    uint32_t         threads;      /* [in] [1, PARALLEL_THREADS_MAX] for stages that share their work */
    const run_watch *watch;        /* [in] who is told how far it is; NULL: nobody; borrowed */
    const char      *subject;      /* [in] what messages call the work: the scene's path; borrowed */
    uint64_t         memory_bytes; /* [in] what the process may hold at most; 0: any amount */

    stage_report stage[STAGE_NONE];
    uint64_t     peak_bytes; /* over the stages that make an asset */

    bake_stage at;          /* the stage in work; meaningful while stage_since > 0 */
    double     stage_since; /* of the clock */
    uint64_t   held_bytes;  /* when it began */
    uint64_t   past_peak;   /* of the process, before it */

    /* progress through steps of known length: the tiles of a light */
    double   begun;         /* [in] of the clock, when the whole began */
    double   total_seconds; /* [in] planned for the whole; 0: no plan */
    double   past_seconds;  /* [in] of them, what is done */
    char     doing[96];     /* "light sun: tile" */
    uint32_t steps, steps_done;
    double   step_seconds; /* planned for each */
} bake_context;

/* End the stage in work and begin another; STAGE_NONE begins none. */
void stage_begin(bake_context *ctx, bake_stage stage);

/* The same, where stages took turns on many threads since the stage in work began: `seconds` over all threads, [count], of the stages
 * `first`, `first` + 1, ... share the wall time among them. */
void stage_begin_after(bake_context *ctx, bake_stage stage, bake_stage first, const double *seconds, uint32_t count);

const char *bake_stage_name(bake_stage stage);

/* VXS_E_INTERRUPTED when the run is given up (run_control.h); VXS_E_MEMORY when more was held than memory_bytes: estimates may be wrong, the promise is
 * kept. */
vxs_result context_check(const bake_context *ctx);

/* 0 when more is held at the moment: what goes on would break the promise. From any thread. */
int context_has_memory(const bake_context *ctx);

/* Begin `steps` steps that take so long each; `doing` is what a line of progress calls them, as in "light sun: tile". */
void steps_begin(bake_context *ctx, uint32_t steps, double seconds_each, const char *doing);

/* Say how far the step in work is, [0, 1]. */
void step_part(bake_context *ctx, double part);

/* So many steps are done. */
void steps_done(bake_context *ctx, uint32_t steps);

#endif
