/* The adjacent triangles of one patch in a list, and their common properties in the square.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef PATCH_RUN_H
#define PATCH_RUN_H

#include <math.h>

#include "baker/columns/sparse/square_list.h"

/* The triangles of one patch in a list: items [begin, end). */
typedef struct patch_run {
    size_t   begin, end;
    int      ends;    /* the border of the patch may cross the square */
    double   lo, hi;  /* depth range of all */
    double   covered; /* least hi of the triangles that cover the whole square */
    uint32_t sampled; /* triangles that cover the middle. Not next to `ends`: gcc would load both as one, after a stall */
    int      exits;   /* some are back faces of solids */
    int      sheets;  /* some belong to sheets */
    int      faces;   /* all belong to one-sided sheets that face the light */
} patch_run;

static inline patch_run patch_run_from(const square_list *l, const sparse_triangles *s, size_t begin)
{
    patch_run r     = {.begin = begin, .end = begin, .lo = INFINITY, .hi = -INFINITY, .covered = INFINITY, .faces = 1};
    uint32_t  patch = s->all[l->items[begin].id].patch;
    for (; r.end < l->count && s->all[l->items[r.end].id].patch == patch; r.end++) {
        const square_entry    *e = &l->items[r.end];
        const sparse_triangle *t = &s->all[e->id];
        r.exits |= sparse_is_exit(t);
        r.sheets |= sparse_is_sheet(t);
        r.faces &= (t->kind & SPARSE_FACES) != 0;
        r.sampled += (e->bits & ENTRY_SAMPLE) != 0;
        r.ends |= (e->bits & ENTRY_END) != 0;
        r.lo                      = least(r.lo, e->lo);
        r.hi                      = greatest(r.hi, e->hi);
        const double if_covers[2] = {INFINITY, e->hi}; /* no branch: it would be unpredictable */
        r.covered                 = least(r.covered, if_covers[e->bits & ENTRY_COVERS]);
    }
    return r;
}

/* No texel's centre is in the patch. A patch that has lost triangles in larger squares may look like this too; but then it reaches
 * those triangles, which begin behind the known F of the square. */
static inline int patch_run_is_missed(const patch_run *r, double known)
{
    return !r->ends && !r->sampled && r->hi < known;
}

#endif
