/* What a light says of a tile, so that every voxel can be requested, run by run: of a DAG its nodes, read without the lookup; of
 * palette blocks where each texel's shadow begins, and lookups at both ends of what lies between.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef EXACT_CODED_RUNS_H
#define EXACT_CODED_RUNS_H

#include "formats/vxs_file.h"

/* Voxels [begin, end) of the tile, which all have the texels `dark` in shadow: texel (x, y) is bit x + 8y.
 * misread  1: a lookup finds something else at one end */
typedef void coded_run_fn(void *user, uint32_t begin, uint32_t end, uint64_t dark, int misread);

/* All runs of the tile of 8 x 8 texels at (x, y), in tiles of map `map`, near to far. */
void coded_runs(const uint32_t *words, const vxs_light *light, uint32_t map, uint32_t x, uint32_t y, coded_run_fn *found,
                void *user);

#endif
