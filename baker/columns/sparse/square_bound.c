/* Bounds from lists of triangles; see square_bound.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/columns/sparse/square_bound.h"

/* The triangles of one patch in a list, items [begin, end), and their common properties in the square. */
typedef struct patch_run {
    size_t   begin, end;
    int      ends;    /* the border of the patch may cross the square */
    double   lo, hi;  /* depth range of all */
    double   covered; /* least hi of the triangles that cover the whole square */
    uint32_t sampled; /* triangles that cover the middle. Not next to `ends`: gcc would load both as one, after a stall */
    int      exits;   /* they are back faces of solids */
    int      sheets;  /* they belong to sheets */
    int      faces;   /* all belong to one-sided sheets that face the light */
} patch_run;

/* Added to a depth, which then counts only if a bit is set: without a branch, which would be unpredictable. */
static const double if_set[2] = {INFINITY, 0};

static inline patch_run patch_run_from(const square_list *l, size_t begin)
{
    const sparse_tags  first = l->tags[begin];
    const sparse_tags *tags  = l->tags;
    const size_t       count = l->count;
    size_t             n     = begin;
    double             lo = INFINITY, hi = -INFINITY, covered = INFINITY;
    uint32_t           sampled = 0, any = 0, all = first.kind;
    do {
        const uint32_t bits = l->items[n].bits;
        lo                  = least(lo, l->lo[n]);
        hi                  = greatest(hi, l->hi[n]);
        covered             = least(covered, l->hi[n] + if_set[bits & ENTRY_COVERS]);
        sampled += bits / ENTRY_SAMPLE & 1;
        any |= bits;
        all &= tags[n].kind;
    } while (++n < count && tags[n].patch == first.patch);
    return (patch_run){.begin   = begin,
                       .end     = n,
                       .ends    = (any & ENTRY_END) != 0,
                       .lo      = lo,
                       .hi      = hi,
                       .covered = covered,
                       .sampled = sampled,
                       .exits   = sparse_is_exit(first),
                       .sheets  = sparse_is_sheet(first),
                       .faces   = (all & SPARSE_FACES) != 0};
}

/* No texel's centre is in the patch. A patch that has lost triangles in larger squares may look like this too; but then it reaches
 * those triangles, which begin behind the known F of the square. */
static inline int patch_run_is_missed(const patch_run *r, double known)
{
    return !r->ends && !r->sampled && r->hi < known;
}

enum { LAYERED_MAX = 64 }; /* most triangles of a patch that are sorted by depth; larger groups rarely have gaps */

typedef struct layered_entry {
    double   lo, hi;
    uint32_t bits;
} layered_entry;

/* The greatest depth of the nearest layer of a run that covers the square. */
static double nearest_layer(const square_list *l, const patch_run *r, double known)
{
    layered_entry sorted[LAYERED_MAX];
    size_t        count = 0;
    double        hi    = -INFINITY;
    uint32_t      all   = 0; /* bits of the layer */
    for (size_t n = r->begin; n < r->end; n++) {
        layered_entry e  = {l->lo[n], l->hi[n], l->items[n].bits};
        size_t        to = count++;
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
static double covered_by(const square_list *l, const patch_run *r, double known)
{
    if (r->sampled == 1 && !r->ends) return least(r->covered, r->hi);
    size_t count = r->end - r->begin;
    if (count < 2 || count > LAYERED_MAX || sparse_is_exit(l->tags[r->begin])) return r->covered;
    return least(r->covered, nearest_layer(l, r, known));
}

static inline void move_entry(square_list *l, size_t to, size_t from)
{
    l->lo[to]    = l->lo[from];
    l->hi[to]    = l->hi[from];
    l->items[to] = l->items[from];
    l->tags[to]  = l->tags[from];
}

/* complete  no triangle that begins before this depth was removed from the list */
static void find_enter_most(square_bound *b, square_list *l, double complete)
{
    double known = b->enter_most;
    size_t kept  = 0;
    for (size_t begin = 0; begin < l->count;) {
        patch_run r = patch_run_from(l, begin);
        begin       = r.end;
        if (patch_run_is_missed(&r, complete)) continue;
        b->enter_most = least(b->enter_most, covered_by(l, &r, known));
        if (kept == r.begin)
            kept = r.end;
        else
            for (size_t n = r.begin; n < r.end; n++) move_entry(l, kept++, n);
    }
    l->count = kept;
}

/* more don't-care voxels ------------------------------------------------------------------------------------------------------ */

/* Whether a surface lies behind F in every texel. Back faces of solids do not count: they may be the exit. */
static int is_followed(const square_bound *b, const square_list *l)
{
    for (size_t begin = 0; begin < l->count;) {
        patch_run r      = patch_run_from(l, begin);
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

static run_depths depths_of_runs(const square_list *l)
{
    run_depths d = {{INFINITY, INFINITY}, {-INFINITY, -INFINITY}, 0, 0};
    for (size_t begin = 0; begin < l->count;) {
        patch_run r = patch_run_from(l, begin);
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
static double later_exit_least(const square_bound *b, const square_list *l, const dont_care_rules *f, double left_out)
{
    run_depths d    = depths_of_runs(l);
    double     exit = b->left_out;
    for (size_t begin = 0; begin < l->count;) {
        patch_run r = patch_run_from(l, begin);
        if (r.exits || r.sheets) exit = least(exit, run_exit_least(b, f, &r, &d, left_out));
        begin = r.end;
    }
    return exit;
}

/* the square ------------------------------------------------------------------------------------------------------------------ */

void square_bound_tighten(square_bound *b, square_list *l, const dont_care_rules *f)
{
    size_t kept   = 0;
    double nearer = INFINITY;
    find_enter_most(b, l, f->behind && !b->behind ? INFINITY : b->enter_most);
    if (f->behind && !b->behind) b->behind = is_followed(b, l);

    /* triangles that begin behind this depth no longer matter */
    const double limit = !dont_care_needs_next(f)  ? b->enter_most
                         : f->behind && !b->behind ? INFINITY
                                                   : dont_care_through(f, b->enter_most);
    for (size_t n = 0; n < l->count; n++) {
        const double      lo   = l->lo[n];
        const sparse_tags tags = l->tags[n];
        if (lo > limit) {
            if (sparse_is_exit(tags)) b->left_out = least(b->left_out, lo);
            continue;
        }
        if (sparse_is_exit(tags) || sparse_is_sheet(tags)) nearer = least(nearer, lo);
        move_entry(l, kept++, n);
    }
    l->count      = kept;
    b->exit_least = dont_care_needs_next(f) ? later_exit_least(b, l, f, limit) : least(nearer, b->left_out);
}

/* Depths in a square of texels, relative to a plane. Surfaces one behind the other often have nearly the same slope. Relative to a
 * plane of that slope their depth ranges do not overlap, however steep they are. */

/* The box of the texels' centres of a square, and the plane. */
typedef struct tilted_box {
    double x, y, half;   /* centre of the box, half of its side: subtexels */
    double gx, gy;       /* gradient of the plane, which has depth 0 in the centre */
    double steep, slack; /* greatest absolute depth of the plane in the box; bound of rounding errors */
} tilted_box;

/* Take the plane of the farthest triangle that covers the square: usually the ground, or a floor. */
static inline tilted_box tilted_box_of(const square_list *l, const sparse_triangles *s, texel_square at)
{
    size_t farthest = SIZE_MAX;
    for (size_t n = 0; n < l->count; n++)
        if (l->items[n].bits & ENTRY_COVERS && (farthest == SIZE_MAX || l->lo[n] > l->lo[farthest])) farthest = n;
    const sparse_triangle *plane = farthest == SIZE_MAX ? NULL : &s->all[l->items[farthest].id];
    const double           px    = (double)((int64_t)1 << s->grid);
    tilted_box             w     = {.x    = (at.u + at.side / 2.0) * px,
                                    .y    = (at.v + at.side / 2.0) * px,
                                    .half = (at.side - 1) / 2.0 * px,
                                    .gx   = plane ? plane->gx : 0,
                                    .gy   = plane ? plane->gy : 0};
    w.steep                      = (fabs(w.gx) + fabs(w.gy)) * w.half;
    w.slack                      = w.steep * 0x1p-45;
    return w;
}

/* A layer of faces. Layers cover the square, unless noted otherwise. */
typedef struct layer {
    double near, far; /* relative to the plane */
    double lo;        /* depth */
} layer;

typedef struct layers {
    layer  fronts[SETTLE_LIST_MAX], backs[SETTLE_LIST_MAX]; /* of solids */
    int    front_count, back_count;
    double partial; /* nearest layer that may not cover the square */
} layers;

static const layer nothing = {INFINITY, -INFINITY, INFINITY};

/* Add a triangle; covers: it covers the square. Back faces count wherever they may be, front faces only where they are certain. */
static void add(layers *y, sparse_tags tags, const layer *of, int covers)
{
    if (!covers) y->partial = least(y->partial, of->near);
    if (sparse_is_sheet(tags)) return; /* a ray meets it after a solid */
    if (sparse_is_exit(tags))
        y->backs[y->back_count++] = *of;
    else if (covers)
        y->fronts[y->front_count++] = *of;
}

/* A run of the list: items [begin, end). */
typedef struct patch_items {
    size_t begin, end;
    int    is_whole; /* 1: one layer that covers the square */
} patch_items;

/* Depths that are known without counting, from the nearest possible exit face. They are certain if there is no such face. Returns
 * the number of patches; 0: a texel may have met a sheet first, or may have exited before another one enters. */
static size_t find_patches(patch_items *patches, const square_list *l, const square_bound *outer, square_parting *out)
{
    const double known = outer->enter_most;
    double       sheet = INFINITY;
    size_t       count = 0;
    out->enter_most    = known;
    out->exit_least    = outer->left_out;
    out->is_certain    = 1;
    for (size_t n = 0; n < l->count;) {
        const patch_run r     = patch_run_from(l, n);
        const int       whole = !r.ends && r.hi < known && r.sampled == 1; /* and no part of it was removed in larger squares */
        n                     = r.end;
        out->enter_most       = least(out->enter_most, whole ? least(r.covered, r.hi) : r.covered);
        if (patch_run_is_missed(&r, known)) continue;
        if (r.sheets) sheet = least(sheet, r.lo);
        if (r.exits) out->exit_least = least(out->exit_least, r.lo);
        out->is_certain &= !r.exits;
        patches[count++] = (patch_items){r.begin, r.end, whole};
    }
    return out->exit_least < out->enter_most || sheet <= out->enter_most ? 0 : count; /* counting could still settle it */
}

static void add_patch(layers *y, const tilted_box *w, const square_list *l, const sparse_triangles *s, const patch_items *p)
{
    const sparse_tags first = l->tags[p->begin];
    layer             all   = nothing;
    for (size_t n = p->begin; n < p->end; n++) {
        layer of = {.lo = l->lo[n]};

        /* its depth range, relative to the plane */
        const sparse_triangle *t      = &s->all[l->items[n].id];
        const double           middle = t->zmin + t->gy * (w->y - t->y[0]) + t->gx * (w->x - t->x[0]);
        const double           rise   = (fabs(t->gx - w->gx) + fabs(t->gy - w->gy)) * (w->half * (1 + 1e-12)) + t->slack + w->slack;
        of.near                       = greatest(middle - rise, l->lo[n] - w->steep - w->slack);
        of.far                        = least(middle + rise, l->hi[n] + w->steep + w->slack);

        if (p->is_whole) {
            all.near = least(all.near, of.near);
            all.far  = greatest(all.far, of.far);
            all.lo   = least(all.lo, of.lo);
        } else
            add(y, first, &of, (l->items[n].bits & ENTRY_COVERS) != 0);
    }
    if (p->is_whole) add(y, first, &all, 1);
}

/* Number of front faces that surely lie before a depth; number of back faces that may lie there. */
static int opened(const layers *y, double near)
{
    int count = 0;
    for (int n = 0; n < y->front_count; n++) count += y->fronts[n].far <= near;
    return count;
}

static int closed(const layers *y, double near)
{
    int count = 0;
    for (int n = 0; n < y->back_count; n++) count += y->backs[n].near <= near;
    return count;
}

/* Whether all faces that a ray may meet before the end of a layer are met before its begin, and cover the square. */
static int is_separate(const layers *y, const layer *back)
{
    if (y->partial <= back->far) return 0;
    for (int n = 0; n < y->front_count; n++)
        if (y->fronts[n].near <= back->far && y->fronts[n].far > back->near) return 0;
    for (int n = 0; n < y->back_count; n++)
        if (&y->backs[n] != back && y->backs[n].near <= back->far && y->backs[n].far > back->near) return 0;
    return 1;
}

int square_settle(const square_list *l, const sparse_triangles *s, texel_square at, const square_bound *outer, int nearest_back,
                  square_parting *out)
{
    layers      y;
    patch_items patches[SETTLE_LIST_MAX];
    if (l->count > SETTLE_LIST_MAX) return 0;
    const size_t count = find_patches(patches, l, outer, out);
    if (!count || out->is_certain) return count != 0;
    const tilted_box w = tilted_box_of(l, s, at);
    y.front_count      = 0;
    y.back_count       = 0;
    y.partial          = INFINITY;
    for (size_t n = 0; n < count; n++) add_patch(&y, &w, l, s, &patches[n]);

    /* the first back face that may be an exit */
    const layer *exit = NULL;
    for (int n = 0; n < y.back_count; n++) {
        const layer *b = &y.backs[n];
        if (exit && exit->near <= b->near) continue;
        if (nearest_back || closed(&y, b->near) >= opened(&y, b->near)) exit = b;
    }

    out->exit_least = outer->left_out;
    for (int n = 0; n < y.back_count && exit; n++)
        if (y.backs[n].near >= exit->near) out->exit_least = least(out->exit_least, y.backs[n].lo);
    out->is_certain = out->exit_least == outer->left_out || is_separate(&y, exit);
    return 1;
}
