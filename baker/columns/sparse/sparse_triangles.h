/* The casters of a map as triangles of exact edges.
 *
 * Corners lie on the grid of 1/256 texel that OpenGL's rasterizers snap to, so that both sources see the same shapes; edge functions
 * are whole numbers then, below 2^50 in a map of 16384 texels, and doubles hold them exactly. A texel belongs to a triangle when its centre
 * is inside, or on an edge that is the triangle's own: of the two sides of an edge one owns it, so that a closed surface covers every texel
 * exactly as often by front faces as by back faces.
 *
 * Depth is a plane through the corner that is nearest to the light, kept within the range of the corners. It is computed in one way only
 * (sparse_depth), and `slack` is more than it can be off, so that what is known of it in a square of texels holds for computed depths and
 * for true ones.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SPARSE_TRIANGLES_H
#define SPARSE_TRIANGLES_H

#include "baker/base/simd.h"
#include "baker/light/projection.h"

enum { SUBTEXELS_PER_PX = 256 };

enum {
    SPARSE_SOLID = 1, /* of a solid; else a sheet */
    SPARSE_BACK  = 2, /* faces away from the light */
    SPARSE_HOLED = 4, /* has holes where its alpha mask says so */
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
    size_t           holed_first; /* triangles [holed_first, count) have holes */
    hole_uvq (*uvq)[3];           /* [count - holed_first] of each corner */
    uint32_t      *mask_of;       /* [count - holed_first] their alpha masks */
    const casters *casters;       /* whose masks they are; borrowed */
} sparse_triangles;

/* Returns VXS_OK or VXS_E_MEMORY; released with sparse_triangles_free either way. Nothing is kept of p but its casters. */
vxs_result sparse_triangles_init(sparse_triangles *s, const projection *p, uint32_t side_px, uint32_t threads);

/* Accepts a zeroed object. */
void sparse_triangles_free(sparse_triangles *s);

/* The edge from corner k to the next: a x + b y + c >= 0 for texels that are inside by it. Whole numbers; where the edge is not the
 * triangle's own, c is less by one, which leaves out what lies on it. */
typedef struct sparse_edge {
    double a, b, c;
} sparse_edge;

static inline sparse_edge sparse_edge_of(const sparse_triangle *t, int k)
{
    int    n = k < 2 ? k + 1 : 0;
    double a = (double)t->y[k] - t->y[n], b = (double)t->x[n] - t->x[k];
    double c = -(a * t->x[k] + b * t->y[k]);
    return (sparse_edge){a, b, a > 0 || (a == 0 && b > 0) ? c : c - 1};
}

/* Depths at two points of a row. */
static inline f64x2 sparse_depth(const sparse_triangle *t, f64x2 x, double y)
{
    f64x2 row = f64x2_all(t->zmin + t->gy * (y - t->y[0]));
    f64x2 z   = row + f64x2_all(t->gx) * (x - f64x2_all(t->x[0]));
    return f64x2_min(f64x2_max(z, f64x2_all(t->zmin)), f64x2_all(t->zmax));
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
