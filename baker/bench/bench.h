/* Measuring bakes and lookups: what was measured, of each scene with each combination of options.
 *
 * Every bake and every comparison is a process of its own, so that its time and memory are those of `vxs bake` and `vxs compare`.
 * Runs go round by round over all cells: a slow minute of the machine lies on all of them, not on one.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BENCH_H
#define BENCH_H

#include <jansson.h>
#include <stdint.h>

#include "baker/base/message.h"
#include "baker/measure/spread.h"
#include "baker/base/text.h"
#include "baker/measure/machine.h"

enum { BENCH_STAGES_MAX = 32, BENCH_LEVELS_MAX = 32, BENCH_FILTERS_MAX = 9, BENCH_CELLS_MAX = 4096 };

typedef struct bench_stage {
    char     name[32];
    spread   seconds;
    uint64_t peak_bytes; /* the most of all runs */
} bench_stage;

/* A level of the DAGs of all lights. */
typedef struct bench_level {
    uint64_t count, memory_bytes, stored_bytes;
} bench_level;

typedef enum bench_points { BENCH_RANDOM, BENCH_SURFACE, BENCH_POINTS_COUNT } bench_points;
#define BENCH_POINTS_WORDS "random|surface"

/* Against the ray-traced truth, of all lights. */
typedef struct bench_error {
    bench_points points;
    uint32_t     filter_px;
    uint64_t     checked;

    uint64_t leaks, false_shadows, unexplained; /* single taps */
    double   wrong_share;

    double rmse, max_error; /* wider filters: of the lit share, 0 to 1 */
} bench_error;

/* One lookup on one thread, the mean of all lights. */
typedef struct bench_lookup {
    uint32_t filter_px;
    spread   nanoseconds;
    spread   ray_nanoseconds; /* single taps: of the truth; else zero */
} bench_lookup;

/* A scene with one combination of options. */
typedef struct bench_cell {
    char    *scene; /* the file's name, without its folder; owned, like all texts here */
    json_t  *options;
    char    *key; /* scene and options: equal keys are the same cell, in files of different runs too */
    uint64_t triangles, solid_triangles;
    char    *light; /* the first */
    uint64_t lights, maps;

    spread      wall_seconds;        /* the whole process */
    spread      total_seconds;       /* as the bake says: from the scene to the file under its name */
    spread      maps_to_dag_seconds; /* from ready depth maps to the DAG */
    bench_stage stages[BENCH_STAGES_MAX];
    uint32_t    stage_count;
    uint64_t    peak_bytes; /* the most of all runs */

    uint64_t    file_bytes, memory_bytes, nodes, masks, inserted_nodes, inserted_masks;
    bench_level levels[BENCH_LEVELS_MAX]; /* levels[n]: nodes of side 2^n voxels; levels[0]: masks */
    uint32_t    level_set;                /* bit n: levels[n] is there */

    bench_error  errors[BENCH_POINTS_COUNT * BENCH_FILTERS_MAX];
    uint32_t     error_count;
    bench_lookup lookups[BENCH_FILTERS_MAX];
    uint32_t     lookup_count;
} bench_cell;

typedef struct bench_result {
    char         *vxs;     /* version */
    char         *started; /* UTC, "2026-01-31T12:00:00Z" */
    bench_machine machine;
    uint32_t      runs, points;
    bench_cell   *cells; /* [cell_count] */
    size_t        cell_count;
} bench_result;

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
 * result           [out] zero it first; released with bench_result_free, whatever is returned
 * outputs_differ   [out] 1: it failed because two runs of a cell made different bytes
 * Returns VXS_OK; VXS_E_ARGUMENT when options are wrong or two cells the same, before anything is measured; what a bake or a
 * comparison failed with; VXS_E_WRITE, VXS_E_MEMORY. A signal that ends runs ends this one when
 * its children and its folder are gone.
 * Threads: only in a process of one thread. */
vxs_result bench_run(const bench_options *o, bench_result *result, int *outputs_differ, message *m);

/* Accepts a zeroed object. */
void bench_result_free(bench_result *result);
void bench_cell_free(bench_cell *cell);

/* Scene and options as a cell's key. Returns NULL without memory; released with free(). */
char *bench_key(const char *scene_name, const json_t *options);

#endif
