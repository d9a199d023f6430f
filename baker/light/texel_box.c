/* Bounding boxes of triangles in texels; see texel_box.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/light/texel_box.h"

/* Clamp a coordinate, so that it fits an int32_t. Boxes far outside the map stay far outside. */
static double in_range(double t)
{
    t = t > -1e9 ? t : -1e9;
    return t < 1e9 ? t : 1e9;
}

/* First texel at or after t; last texel at or before t. */
static int32_t texel_from(double t)
{
    int32_t index = (int32_t)in_range(t);
    return index + (index < in_range(t));
}

static int32_t texel_to(double t)
{
    int32_t index = (int32_t)in_range(t);
    return index - (index > in_range(t));
}

static double least(double a, double b, double c)
{
    a = a < b ? a : b;
    return a < c ? a : c;
}

static double most(double a, double b, double c)
{
    a = a > b ? a : b;
    return a > c ? a : c;
}

texel_box texel_box_of(const projection *p, size_t triangle)
{
    const uint32_t  *t = p->indices + 3 * triangle;
    const vertex_ls *a = &p->vertices[t[0]], *b = &p->vertices[t[1]], *c = &p->vertices[t[2]];
    /* texel centres are at half integers; snapping may move an edge by half a subtexel */
    const double     slack = 0.5 / SUBTEXELS;
    return (texel_box){
        texel_from(least(a->u, b->u, c->u) - 0.5 - slack),
        texel_from(least(a->v, b->v, c->v) - 0.5 - slack),
        texel_to(most(a->u, b->u, c->u) - 0.5 + slack),
        texel_to(most(a->v, b->v, c->v) - 0.5 + slack),
    };
}

int texel_box_touches(const texel_box *box, int32_t u0, int32_t v0, int32_t side)
{
    return box->u0 <= box->u1 && box->v0 <= box->v1 && box->u0 < u0 + side && box->v0 < v0 + side && box->u1 >= u0 && box->v1 >= v0;
}
