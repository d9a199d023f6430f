/* Lists of the triangles that may touch a square of texels, and what is known of each there.
 *
 * All that is asked of a square is asked of its texels' centres: the box of them is a texel smaller than the square.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SQUARE_LIST_H
#define SQUARE_LIST_H

#include "baker/columns/sparse/sparse_triangles.h"

enum {
    ENTRY_COVERS = 1, /* the triangle covers all texels */
    ENTRY_END    = 2, /* an end of its patch may cross the square */
    ENTRY_SAMPLE = 4, /* it covers the middle of the square, which speaks for its patch */
};

typedef struct square_entry {
    double   lo, hi; /* depths of the triangle in the square, computed or true, lie between them */
    uint32_t id;     /* of the triangle; lists ascend, so that patches are together */
    uint32_t bits;   /* ENTRY_ */
} square_entry;

typedef struct square_list {
    square_entry *items;
    size_t        count, capacity;
} square_list;

/* A square of `side` texels at texel (u, v) of the map. */
typedef struct texel_square {
    uint32_t u, v, side;
} texel_square;

/* Of numbers, without the care that fmin and fmax take of others. */
static inline double least(double a, double b)
{
    return a < b ? a : b;
}

static inline double greatest(double a, double b)
{
    return a > b ? a : b;
}

/* Fill a list with those of some triangles that may touch a square.
 * ids  [count] ascending
 * Returns 0 without memory. */
typedef int square_list_gather(square_list *l, const sparse_triangles *s, const uint32_t *ids, size_t count, texel_square square);

/* The lists of the four quarters of a square: (0, 0), (1, 0), (0, 1), (1, 1). Returns 0 without memory. */
typedef int square_list_split(square_list quarter[4], const sparse_triangles *s, const square_list *l, texel_square square);

/* For the levels of cpu.h; see lanes.h. */
square_list_gather square_list_gather_sse2, square_list_gather_avx2;
square_list_split  square_list_split_sse2, square_list_split_avx2;

#endif
