/* Lists of the triangles that may touch a square of texels, with their depth ranges and flags in the square.
 *
 * Only the centres of texels count: their box is one texel smaller than the square.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SQUARE_LIST_H
#define SQUARE_LIST_H

#include "baker/columns/sparse/sparse_triangles.h"

enum {
    ENTRY_COVERS = 1, /* the triangle covers all texel centres */
    ENTRY_END    = 2, /* the border of its patch may cross the square */
    ENTRY_SAMPLE = 4, /* it covers the middle of the square, which is the sample point of its patch */
};

typedef struct square_entry {
    uint32_t id;   /* index of the triangle; ascending in a list, so that triangles of a patch are adjacent */
    uint32_t bits; /* ENTRY_ flags */
} square_entry;

/* An array for each field, so that vectors of entries are stored at once. */
typedef struct square_list {
    double       *lo, *hi; /* range of the triangle's depths in the square, both computed and true ones. lo owns all arrays */
    square_entry *items;
    sparse_tags  *tags; /* of the triangle */
    size_t        count, capacity;
} square_list;

/* A square of `side` texels at texel (u, v) of the map. */
typedef struct texel_square {
    uint32_t u, v, side;
} texel_square;

/* Minimum and maximum without the NaN handling of fmin and fmax. */
static inline double least(double a, double b)
{
    return a < b ? a : b;
}

static inline double greatest(double a, double b)
{
    return a > b ? a : b;
}

/* Fill a list from triangles that may touch a square.
 * ids  [count] ascending
 * Returns 0 without memory. */
typedef int square_list_gather(square_list *l, const sparse_triangles *s, const uint32_t *ids, size_t count, texel_square square);

/* Split a list into lists of the four quarters: (0, 0), (1, 0), (0, 1), (1, 1). Returns 0 without memory. */
typedef int square_list_split(square_list quarter[4], const sparse_triangles *s, const square_list *l, texel_square square);

/* One for each level of cpu.h; see lanes.h. */
square_list_gather square_list_gather_sse2, square_list_gather_avx2, square_list_gather_avx512;
square_list_split  square_list_split_sse2, square_list_split_avx2, square_list_split_avx512;

#endif
