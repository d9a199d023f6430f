/* Depths in a square of texels, relative to a plane. Surfaces one behind the other often have nearly the same slope. Relative to a
 * plane of that slope their depth ranges do not overlap, however steep they are.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef LEAN_H
#define LEAN_H

#include <math.h>

#include "baker/columns/sparse/square_list.h"

/* Of a square or a tile: the box of its texels' centres, and the plane. */
typedef struct lean {
    double x, y, half;   /* centre of the box, half of its side: subtexels */
    double gx, gy;       /* gradient of the plane, which has depth 0 in the centre */
    double steep, slack; /* greatest absolute depth of the plane in the box; bound of rounding errors */
} lean;

/* Take the plane of the farthest triangle that covers the square: usually the ground, or a floor. */
static inline lean lean_of(const square_list *l, const sparse_triangles *s, texel_square at)
{
    const square_entry *farthest = NULL;
    for (size_t n = 0; n < l->count; n++)
        if (l->items[n].bits & ENTRY_COVERS && (!farthest || l->items[n].lo > farthest->lo)) farthest = &l->items[n];
    const double px = (double)((int64_t)1 << s->grid);
    lean         w  = {.x    = (at.u + at.side / 2.0) * px,
                       .y    = (at.v + at.side / 2.0) * px,
                       .half = (at.side - 1) / 2.0 * px,
                       .gx   = farthest ? s->all[farthest->id].gx : 0,
                       .gy   = farthest ? s->all[farthest->id].gy : 0};
    w.steep         = (fabs(w.gx) + fabs(w.gy)) * w.half;
    w.slack         = ldexp(w.steep, -45);
    return w;
}

/* Depth range of a triangle of the list, relative to the plane. */
static inline void lean_range(const lean *w, const square_entry *e, const sparse_triangle *t, double *lo, double *hi)
{
    const double middle = t->zmin + t->gy * (w->y - t->y[0]) + t->gx * (w->x - t->x[0]);
    const double rise   = (fabs(t->gx - w->gx) + fabs(t->gy - w->gy)) * (w->half * (1 + 1e-12)) + t->slack + w->slack;
    *lo                 = greatest(middle - rise, e->lo - w->steep - w->slack);
    *hi                 = least(middle + rise, e->hi + w->steep + w->slack);
}

#endif
