/* Triangles that may touch each cell of a map: the start of the descent.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef TRIANGLE_BINS_H
#define TRIANGLE_BINS_H

#include "baker/columns/sparse/sparse_triangles.h"

enum { BINS_A_SIDE_MAX = 64 };

typedef struct triangle_bins {
    uint32_t  cells, cell_px; /* cells along a side of the map; texels along a side of a cell */
    size_t   *first;          /* [cells^2 + 1] cell n has ids[first[n]] to ids[first[n + 1] - 1] */
    uint32_t *ids;            /* ascending in each cell */
} triangle_bins;

/* Choose cells fine enough to share work among threads, and coarse enough for only a few ids per triangle.
 * Returns VXS_OK or VXS_E_MEMORY; released with triangle_bins_free either way. */
vxs_result triangle_bins_init(triangle_bins *b, const sparse_triangles *s, uint32_t side_px, uint32_t threads);

/* Accepts a zeroed object. */
void triangle_bins_free(triangle_bins *b);

#endif
