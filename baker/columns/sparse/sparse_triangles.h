/* The casters of a map as triangles with exact edges.
 *
 * Corners are on a grid of subtexels, as fine as 64-bit integers allow for the map, so that edge functions are never rounded. A
 * texel belongs to a triangle if its centre is inside, or on an edge that the triangle owns. Of the two triangles at an edge
 * exactly one owns it. So front faces and back faces of a closed surface cover every texel the same number of times.
 *
 * Depth is a plane through the corner nearest to the light, clamped to the range of the corners. Only lanes_depth (lanes.h)
 * computes it. `slack` is greater than its rounding error, so that depth ranges in a square of texels hold for computed and for
 * true depths.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SPARSE_TRIANGLES_H
#define SPARSE_TRIANGLES_H

#include "baker/base/integer.h"
#include "baker/light/projection.h"

enum {
    SPARSE_SOLID = 1, /* of a solid; else a sheet */
    SPARSE_BACK  = 2, /* faces away from the light */
    SPARSE_HOLED = 4, /* has holes from its alpha mask */
    SPARSE_FACES = 8, /* triangle of a one-sided sheet without holes whose visible side faces the light */
};

/* 64 bytes: one cache line. */
typedef struct sparse_triangle {
    int32_t x[3], y[3]; /* subtexels; counter-clockwise for x to the right and y up. Corner 0 has zmin */
    double  zmin, zmax; /* depths as in columns.h */
    double  gx, gy;     /* gradient of depth, per subtexel */
    double  slack;
} sparse_triangle;

/* What lists of triangles copy. */
typedef struct sparse_tags {
    uint32_t patch;
    uint8_t  kind;    /* SPARSE_ bits */
    uint8_t  ends;    /* bit k: the edge from corner k to the next is on the border of the patch */
    uint16_t padding; /* 0 */
} sparse_tags;

typedef struct sparse_triangles {
    size_t           count;
    sparse_triangle *all;         /* [count] sorted by patch; owner of the tags, too */
    sparse_tags     *tags;        /* [count] */
    uint32_t         grid;        /* log2 of subtexels per texel */
    size_t           holed_first; /* triangles [holed_first, count) have holes */
    hole_uvq (*uvq)[3];           /* [count - holed_first] for each corner */
    uint32_t      *mask_of;       /* [count - holed_first] their alpha masks */
    const casters *casters;       /* owner of the masks; borrowed */
} sparse_triangles;

/* Returns VXS_OK or VXS_E_MEMORY; released with sparse_triangles_free either way. Keeps only the casters of p. */
vxs_result sparse_triangles_init(sparse_triangles *s, const projection *p, uint32_t side_px, uint32_t threads);

/* Approximate peak memory of sparse_triangles_init, bytes. */
uint64_t sparse_triangles_bytes(const projection *p);

/* Accepts a zeroed object. */
void sparse_triangles_free(sparse_triangles *s);

/* Grid of a map of side_px texels. Corners are at most two map sides from any texel and three from each other, so edge functions
 * stay below 12 * 2^58, and the additions to them for a square below half of that. A grid finer than 1/65536 texel gains
 * nothing. */
static inline uint32_t sparse_grid(uint32_t side_px)
{
    return min_u32(16, 29 - log2_u32(side_px));
}

/* The edge from corner k to the next: a (x - x0) + b (y - y0) - c >= 0 on its inner side. */
typedef struct sparse_edge {
    int64_t a, b, x0, y0;
    int64_t c; /* 1 if the triangle does not own the edge: points on the edge are then outside */
} sparse_edge;

static inline sparse_edge sparse_edge_of(const sparse_triangle *t, int k)
{
    int     n = k < 2 ? k + 1 : 0;
    int64_t a = (int64_t)t->y[k] - t->y[n], b = (int64_t)t->x[n] - t->x[k];
    return (sparse_edge){a, b, t->x[k], t->y[k], !(a > 0 || (a == 0 && b > 0))};
}

static inline int64_t sparse_edge_at(const sparse_edge *e, int64_t x, int64_t y)
{
    return e->a * (x - e->x0) + e->b * (y - e->y0) - e->c;
}

/* Whether it is a back face of a solid, where light may exit. */
static inline int sparse_is_exit(sparse_tags t)
{
    return (t.kind & (SPARSE_SOLID | SPARSE_BACK)) == (SPARSE_SOLID | SPARSE_BACK);
}

static inline int sparse_is_sheet(sparse_tags t)
{
    return !(t.kind & SPARSE_SOLID);
}

/* Patches: adjacent triangles of a map that face the same way.
 *
 * Away from the border of a patch, the number of its triangles that cover a point is constant: where one triangle ends, the next
 * begins. So if no border of the patch crosses a square of texels, the patch covers each texel as often as any other. Thousands of
 * small triangles then bound the square as a single large triangle does. */

/* Find the patches of a projection.
 * patch_of  [out] [p->triangle_count] index of the first triangle of the patch. Triangles with holes, and those with facing 0,
 *           are patches alone
 * ends      [out] [p->triangle_count] bit k: the edge from corner k to the next is on the border of the patch
 * facing    [p->triangle_count] 1 and -1: the two sides, 0: seen edge-on
 * Returns VXS_OK or VXS_E_MEMORY. The result does not depend on the number of threads. */
vxs_result patches_find(uint32_t *patch_of, uint8_t *ends, const int8_t *facing, const projection *p, uint32_t threads);

/* Triangles that may touch each cell of a map: the start of the descent. */

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
