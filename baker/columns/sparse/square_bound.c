/* Bounds from lists of triangles; see square_bound.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/columns/sparse/square_bound.h"

#include <math.h>
#include <string.h>

#include "baker/columns/sparse/patch_run.h"

enum { LAYERED_MAX = 64 }; /* most triangles of a patch that are sorted by depth; larger groups rarely have gaps */

/* The greatest depth of the nearest layer of a run that covers the square. */
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
        if (sorted[n].lo > hi) { /* a gap: the layer before it is complete */
            if (all & ENTRY_SAMPLE && !(all & ENTRY_END)) return hi;
            all = 0;
        }
        hi = greatest(hi, sorted[n].hi);
        all |= sorted[n].bits;
    }
    return all & ENTRY_SAMPLE && !(all & ENTRY_END) ? hi : INFINITY;
}

/* Depth at which the run has covered the square. */
static double covered_by(const square_list *l, const sparse_triangles *s, const patch_run *r, double known)
{
    if (r->sampled == 1 && !r->ends) return least(r->covered, r->hi);
    size_t count = r->end - r->begin;
    if (count < 2 || count > LAYERED_MAX || sparse_is_exit(&s->all[l->items[r->begin].id])) return r->covered;
    return least(r->covered, nearest_layer(l, r, known));
}

/* complete  no triangle that begins before this depth was removed from the list */
static void find_enter_most(square_bound *b, square_list *l, const sparse_triangles *s, double complete)
{
    double known = b->enter_most;
    size_t kept  = 0;
    for (size_t begin = 0; begin < l->count;) {
        patch_run r = patch_run_from(l, s, begin);
        begin       = r.end;
        if (patch_run_is_missed(&r, complete)) continue;
        b->enter_most = least(b->enter_most, covered_by(l, s, &r, known));
        memmove(l->items + kept, l->items + r.begin, (r.end - r.begin) * sizeof *l->items);
        kept += r.end - r.begin;
    }
    l->count = kept;
}

/* more don't-care voxels ------------------------------------------------------------------------------------------------------ */

/* Whether a surface lies behind F in every texel. Back faces of solids do not count: they may be the exit. */
static int is_followed(const square_bound *b, const square_list *l, const sparse_triangles *s)
{
    for (size_t begin = 0; begin < l->count;) {
        patch_run r      = patch_run_from(l, s, begin);
        int       covers = r.covered < INFINITY || (r.sampled && !r.ends);
        if (covers && r.lo > b->enter_most && !r.exits) return 1;
        begin = r.end;
    }
    return 0;
}

/* Extreme depths over all runs of a list, with which those of all other runs are found. */
typedef struct run_depths {
    double lo[2], hi[2]; /* the extreme depth, and the next one */
    size_t lo_of, hi_of; /* begin of the runs that have the extreme depths */
} run_depths;

static run_depths depths_of_runs(const square_list *l, const sparse_triangles *s)
{
    run_depths d = {{INFINITY, INFINITY}, {-INFINITY, -INFINITY}, 0, 0};
    for (size_t begin = 0; begin < l->count;) {
        patch_run r = patch_run_from(l, s, begin);
        if (r.lo < d.lo[0])
            d = (run_depths){{r.lo, d.lo[0]}, {d.hi[0], d.hi[1]}, begin, d.hi_of};
        else
            d.lo[1] = least(d.lo[1], r.lo);
        if (r.hi > d.hi[0])
            d = (run_depths){{d.lo[0], d.lo[1]}, {r.hi, d.hi[0]}, d.lo_of, begin};
        else
            d.hi[1] = greatest(d.hi[1], r.hi);
        begin = r.end;
    }
    return d;
}

/* Least exit depth at a run of sheets, or of back faces of solids. It holds if every texel meets the run once, so that no part of
 * the run lies behind the exit. This is not certain for a run that reaches triangles removed from the list. */
static double run_exit_least(const square_bound *b, const dont_care_rules *f, const patch_run *r, const run_depths *d,
                             double left_out)
{
    const double nearest = d->lo[d->lo_of == r->begin], farthest = d->hi[d->hi_of == r->begin]; /* over the other runs */
    if (r->sampled != 1 || r->ends || r->hi > left_out) return r->lo;
    if (f->behind && !b->behind && farthest < r->lo) return INFINITY;
    if (!r->faces || !(f->thickness > 0)) return r->lo;
    const double rounded = ldexp(1, -50); /* greater than the rounding error of dont_care_through */
    return greatest(r->lo, least(dont_care_through(f, r->lo) - rounded, nearest));
}

/* xmin, with more don't-care voxels than the insides of solids.   left_out  triangles that begin behind this depth may be
 * missing */
static double later_exit_least(const square_bound *b, const square_list *l, const sparse_triangles *s, const dont_care_rules *f,
                               double left_out)
{
    run_depths d    = depths_of_runs(l, s);
    double     exit = b->left_out;
    for (size_t begin = 0; begin < l->count;) {
        patch_run r = patch_run_from(l, s, begin);
        if (r.exits || r.sheets) exit = least(exit, run_exit_least(b, f, &r, &d, left_out));
        begin = r.end;
    }
    return exit;
}

/* the square ------------------------------------------------------------------------------------------------------------------ */

/* Triangles that begin behind this depth no longer matter. */
static double limit_of(const square_bound *b, const dont_care_rules *f)
{
    if (!dont_care_needs_next(f)) return b->enter_most;
    return f->behind && !b->behind ? INFINITY : dont_care_through(f, b->enter_most);
}

void square_bound_tighten(square_bound *b, square_list *l, const sparse_triangles *s, const dont_care_rules *f)
{
    size_t kept   = 0;
    double nearer = INFINITY;
    find_enter_most(b, l, s, f->behind && !b->behind ? INFINITY : b->enter_most);
    if (f->behind && !b->behind) b->behind = is_followed(b, l, s);
    const double limit = limit_of(b, f);
    for (size_t n = 0; n < l->count; n++) {
        const square_entry    *e = &l->items[n];
        const sparse_triangle *t = &s->all[e->id];
        if (e->lo > limit) {
            if (sparse_is_exit(t)) b->left_out = least(b->left_out, e->lo);
            continue;
        }
        if (sparse_is_exit(t) || sparse_is_sheet(t)) nearer = least(nearer, e->lo);
        l->items[kept++] = *e;
    }
    l->count      = kept;
    b->exit_least = dont_care_needs_next(f) ? later_exit_least(b, l, s, f, limit) : least(nearer, b->left_out);
}
