/* What the nodes of a DAG say of a tile, read without the lookup: so that every voxel can be asked for, run by run.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef EXACT_DAG_RUNS_H
#define EXACT_DAG_RUNS_H

#include "formats/vxs_file.h"

/* Voxels [begin, end) of the tile, which all have the texels `dark` in shadow: texel (x, y) is bit x + 8y.
 * misread  1: a lookup finds something else at one end */
typedef void dag_run_fn(void *user, uint32_t begin, uint32_t end, uint64_t dark, int misread);

/* All runs of the tile of 8 x 8 texels at (x, y), in tiles of map `map`, near to far. */
void dag_runs(const uint32_t *words, const vxs_light *light, uint32_t map, uint32_t x, uint32_t y, dag_run_fn *found, void *user);

#endif
