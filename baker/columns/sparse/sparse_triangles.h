/* The casters of a map as triangles of exact edges.
 *
 * Corners lie on a grid of subtexels, as fine as whole numbers of 64 bits allow for the map: an edge function is never rounded. A texel
 * belongs to a triangle when its centre is inside, or on an edge that is the triangle's own: of the two sides of an edge one owns it, so
 * that a closed surface covers every texel exactly as often by front faces as by back faces.
 *
 * Depth is a plane through the corner that is nearest to the light, kept within the range of the corners. It is computed in one way only
 * (lanes_depth in lanes.h), and `slack` is more than it can be off, so that what is known of it in a square of texels
 * holds for computed depths and for true ones.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SPARSE_TRIANGLES_H
#define SPARSE_TRIANGLES_H

#include "baker/base/integer.h"
#include "baker/light/projection.h"

enum {
    SPARSE_SOLID = 1, /* of a solid; else a sheet */
    SPARSE_BACK  = 2, /* faces away from the light */
    SPARSE_HOLED = 4, /* has holes where its alpha mask says so */
    SPARSE_FACES = 8, /* of a sheet without holes, only one side of which is seen, and that side faces the light */
};

typedef struct sparse_triangle {
    int32_t  x[3], y[3]; /* subtexels; counter-clockwise for x to the right and y up. Corner 0 has zmin */
    double   zmin, zmax; /* depths as in depth_scale.h */
    double   gx, gy;     /* of depth, for a subtexel */
    double   slack;
    uint32_t patch;
    uint8_t  kind; /* SPARSE_ bits */
    uint8_t  ends; /* bit k: the edge from corner k to the next is an end of the patch */
} sparse_triangle;

typedef struct sparse_triangles {
    size_t           count;
    sparse_triangle *all;         /* [count] by patch */
    uint32_t         grid;        /* log2 of the subtexels that are a texel */
    size_t           holed_first; /* triangles [holed_first, count) have holes */
    hole_uvq (*uvq)[3];           /* [count - holed_first] of each corner */
    uint32_t      *mask_of;       /* [count - holed_first] their alpha masks */
    const casters *casters;       /* whose masks they are; borrowed */
} sparse_triangles;

/* Returns VXS_OK or VXS_E_MEMORY; released with sparse_triangles_free either way. Nothing is kept of p but its casters. */
vxs_result sparse_triangles_init(sparse_triangles *s, const projection *p, uint32_t side_px, uint32_t threads);

/* What that takes at its most, nearly: bytes. */
uint64_t sparse_triangles_bytes(const projection *p);

/* Accepts a zeroed object. */
void sparse_triangles_free(sparse_triangles *s);

/* The grid of a map of side_px texels. Corners are at most two sides from any texel and three from each other: edge functions stay below
 * 12 * 2^58, and what is added to them for a square below half of it. Finer than 1/65536 texel gains nothing. */
static inline uint32_t sparse_grid(uint32_t side_px)
{
    return min_u32(16, 29 - log2_u32(side_px));
}

/* The edge from corner k to the next: a (x - x0) + b (y - y0) - c >= 0 for texels that are inside by it. */
typedef struct sparse_edge {
    int64_t a, b, x0, y0;
    int64_t c; /* 1 where the edge is not the triangle's own, which leaves out what lies on it */
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

/* A back face of a solid: light leaves there. */
static inline int sparse_is_exit(const sparse_triangle *t)
{
    return (t->kind & (SPARSE_SOLID | SPARSE_BACK)) == (SPARSE_SOLID | SPARSE_BACK);
}

static inline int sparse_is_sheet(const sparse_triangle *t)
{
    return !(t->kind & SPARSE_SOLID);
}

#endif
