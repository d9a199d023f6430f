/* Bounds from lists of triangles; see square_bound.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/columns/sparse/square_bound.h"

#include <math.h>
#include <string.h>

enum { LAYERED_MAX = 64 }; /* triangles of a patch that are taken by depth; more of them are rarely apart */

/* The triangles of one patch in a list: items [begin, end). */
typedef struct patch_run {
    size_t   begin, end;
    uint32_t sampled; /* how many cover the middle of the square */
    int      ends;    /* an end of the patch may cross the square */
    double   hi;      /* of all */
    double   covered; /* hi of the nearest that covers the square alone */
} patch_run;

static patch_run run_from(const square_list *l, const sparse_triangles *s, size_t begin)
{
    patch_run r     = {.begin = begin, .end = begin, .hi = -INFINITY, .covered = INFINITY};
    uint32_t  patch = s->all[l->items[begin].id].patch;
    for (; r.end < l->count && s->all[l->items[r.end].id].patch == patch; r.end++) {
        const square_entry *e = &l->items[r.end];
        r.sampled += (e->bits & ENTRY_SAMPLE) != 0;
        r.ends |= (e->bits & ENTRY_END) != 0;
        r.hi = greatest(r.hi, e->hi);
        if (e->bits & ENTRY_COVERS) r.covered = least(r.covered, e->hi);
    }
    return r;
}

/* No texel's centre is in it. One that has lost triangles to larger squares may only seem so; but it reaches those, which begin behind what
 * was known of the square. */
static int is_missed(const patch_run *r, double known)
{
    return !r->ends && !r->sampled && r->hi < known;
}

/* The farthest depth of the nearest layer of a run that covers the square. */
static double nearest_layer(const square_list *l, const patch_run *r, double known)
{
    square_entry sorted[LAYERED_MAX];
    size_t       count = r->end - r->begin;
    double       hi    = -INFINITY;
    uint32_t     all   = 0; /* bits of the layer */
    memcpy(sorted, l->items + r->begin, count * sizeof *sorted);
    for (size_t n = 1; n < count; n++) {
        square_entry e  = sorted[n];
        size_t       to = n;
        for (; to && sorted[to - 1].lo > e.lo; to--) sorted[to] = sorted[to - 1];
        sorted[to] = e;
    }
    for (size_t n = 0; n < count && sorted[n].lo <= known; n++) {
        if (sorted[n].lo > hi) { /* a gap: the layer before it is whole */
            if (all & ENTRY_SAMPLE && !(all & ENTRY_END)) return hi;
            all = 0;
        }
        hi = greatest(hi, sorted[n].hi);
        all |= sorted[n].bits;
    }
    return all & ENTRY_SAMPLE && !(all & ENTRY_END) ? hi : INFINITY;
}

/* Where the run has covered the square. */
static double covered_by(const square_list *l, const sparse_triangles *s, const patch_run *r, double known)
{
    if (r->sampled == 1 && !r->ends) return least(r->covered, r->hi);
    size_t count = r->end - r->begin;
    if (count < 2 || count > LAYERED_MAX || sparse_is_exit(&s->all[l->items[r->begin].id])) return r->covered;
    return least(r->covered, nearest_layer(l, r, known));
}

static void find_enter_most(square_bound *b, square_list *l, const sparse_triangles *s)
{
    double known = b->enter_most;
    size_t kept  = 0;
    for (size_t begin = 0; begin < l->count;) {
        patch_run r = run_from(l, s, begin);
        begin       = r.end;
        if (is_missed(&r, known)) continue;
        b->enter_most = least(b->enter_most, covered_by(l, s, &r, known));
        memmove(l->items + kept, l->items + r.begin, (r.end - r.begin) * sizeof *l->items);
        kept += r.end - r.begin;
    }
    l->count = kept;
}

void square_bound_tighten(square_bound *b, square_list *l, const sparse_triangles *s)
{
    size_t kept   = 0;
    double nearer = INFINITY;
    find_enter_most(b, l, s);
    for (size_t n = 0; n < l->count; n++) {
        const square_entry    *e = &l->items[n];
        const sparse_triangle *t = &s->all[e->id];
        if (e->lo > b->enter_most) {
            if (sparse_is_exit(t)) b->left_out = least(b->left_out, e->lo);
            continue;
        }
        if (sparse_is_exit(t) || sparse_is_sheet(t)) nearer = least(nearer, e->lo);
        l->items[kept++] = *e;
    }
    l->count      = kept;
    b->exit_least = least(nearer, b->left_out);
}
