/* Which triangles may touch which cells of a map: where the descent begins.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef TRIANGLE_BINS_H
#define TRIANGLE_BINS_H

#include "baker/columns/sparse/sparse_triangles.h"

enum { BINS_A_SIDE_MAX = 64 };

typedef struct triangle_bins {
    uint32_t  cells, cell_px; /* a side; of a cell */
    size_t   *first;          /* [cells^2 + 1] cell n has ids[first[n]] to ids[first[n + 1]] */
    uint32_t *ids;            /* ascending in each */
} triangle_bins;

/* Bins as fine as it takes to share work among threads, and no finer than keeps them within a few ids for each triangle.
 * Returns VXS_OK or VXS_E_MEMORY; released with triangle_bins_free either way. */
vxs_result triangle_bins_init(triangle_bins *b, const sparse_triangles *s, uint32_t side_px, uint32_t threads);

/* Accepts a zeroed object. */
void triangle_bins_free(triangle_bins *b);

#endif
