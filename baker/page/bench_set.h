/* Measurements of `vxs bench`, of one file or several, as series that pages and plots walk over.
 *
 * Cells of one scene, setting and file that differ in resolution alone form a series: a line of a plot. What a setting is follows from
 * the cells: only options that differ between them are named.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BENCH_SET_H
#define BENCH_SET_H

#include "baker/bench/bench.h"

/* A cell, and what it belongs to: indices into the set. */
typedef struct set_cell {
    const bench_cell *measured;
    uint32_t          file, scene, setting;
    double            side_px; /* texels a side of a map */
} set_cell;

typedef struct set_file {
    const char  *path;  /* as given */
    char        *label; /* tells it from the others; clean_text */
    bench_result result;
} set_file;

/* By resolution. */
typedef struct bench_series {
    uint32_t  file, scene, setting;
    uint32_t *cells; /* [count] indices into the set */
    size_t    count;
} bench_series;

typedef struct bench_set {
    set_file     *files;
    size_t        file_count;
    set_cell     *cells;
    size_t        cell_count;
    char        **scenes; /* "city.glb", or "city.glb, noon" where it occurs with several lights or suns; clean_text */
    size_t        scene_count;
    char        **settings; /* "base" for that of the first cell, or what is not as it is there: "rule shadow, stop insert" */
    size_t        setting_count;
    char         *base; /* options of the first cell that others have otherwise: "rule greedy, stop final"; "" when none differ */
    bench_series *series;
    size_t        series_count;
} bench_set;

/* Read and check files.
 * set  [out] released with bench_set_free, whatever is returned.
 * Returns VXS_OK; VXS_E_READ when a file is not what bench writes, or holds no cell: one line in m says where; VXS_E_MEMORY. */
vxs_result bench_set_read(bench_set *set, const char *const *paths, size_t count, message *m);

void bench_set_free(bench_set *set);

/* The part of a cell for these points or this filter; NULL when it was not measured. */
const bench_error  *bench_error_of(const bench_cell *c, bench_points points, uint32_t filter_px);
const bench_lookup *bench_lookup_of(const bench_cell *c, uint32_t filter_px);

/* Root mean square of what a lookup is off, 0 to 1; single taps are right or wrong. */
double bench_rmse(const bench_error *e);

/* "random points", "surface points" */
const char *bench_points_text(bench_points points);

#endif
