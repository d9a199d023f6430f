/* Counting layers; see square_settle.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/columns/sparse/square_settle.h"

#include "baker/columns/sparse/lean.h"
#include "baker/columns/sparse/patch_run.h"

/* A layer of faces. Layers cover the square, unless noted otherwise. */
typedef struct layer {
    double near, far; /* relative to the plane of lean.h */
    double lo;        /* depth */
} layer;

typedef struct layers {
    layer  fronts[SETTLE_LIST_MAX], backs[SETTLE_LIST_MAX]; /* of solids */
    int    front_count, back_count;
    double partial; /* nearest layer that may not cover the square */
} layers;

static void widen(layer *a, const layer *b)
{
    a->near = least(a->near, b->near);
    a->far  = greatest(a->far, b->far);
    a->lo   = least(a->lo, b->lo);
}

static const layer nothing = {INFINITY, -INFINITY, INFINITY};

/* Add a triangle; covers: it covers the square. Back faces count wherever they may be, front faces only where they are certain. */
static void add(layers *y, const sparse_triangle *t, const layer *of, int covers)
{
    if (!covers) y->partial = least(y->partial, of->near);
    if (sparse_is_sheet(t)) return; /* a ray meets it after a solid */
    if (sparse_is_exit(t))
        y->backs[y->back_count++] = *of;
    else if (covers)
        y->fronts[y->front_count++] = *of;
}

/* A run of the list: items [begin, end). */
typedef struct patch_items {
    size_t begin, end;
    int    is_whole; /* 1: one layer that covers the square */
} patch_items;

/* Depths that are known without counting, from the nearest possible exit face. Returns the number of patches; 0: a texel may have
 * met a sheet first, or may have exited before another one enters. */
static size_t find_patches(patch_items *patches, const square_list *l, const sparse_triangles *s, const square_bound *outer,
                           square_parting *out)
{
    const double known = outer->enter_most;
    double       sheet = INFINITY;
    size_t       count = 0;
    out->enter_most    = known;
    out->exit_least    = outer->left_out;
    for (size_t n = 0; n < l->count;) {
        const patch_run r     = patch_run_from(l, s, n);
        const int       whole = !r.ends && r.hi < known && r.sampled == 1; /* and no part of it was removed in larger squares */
        n                     = r.end;
        out->enter_most       = least(out->enter_most, whole ? least(r.covered, r.hi) : r.covered);
        if (patch_run_is_missed(&r, known)) continue;
        if (r.sheets) sheet = least(sheet, r.lo);
        if (r.exits) out->exit_least = least(out->exit_least, r.lo);
        patches[count++] = (patch_items){r.begin, r.end, whole};
    }
    return out->exit_least < out->enter_most || sheet <= out->enter_most ? 0 : count; /* counting could still settle it */
}

static void add_patch(layers *y, const lean *w, const square_list *l, const sparse_triangles *s, const patch_items *p)
{
    const sparse_triangle *first = &s->all[l->items[p->begin].id];
    layer                  all   = nothing;
    for (size_t n = p->begin; n < p->end; n++) {
        const square_entry *e  = &l->items[n];
        layer               of = {.lo = e->lo};
        lean_range(w, e, &s->all[e->id], &of.near, &of.far);
        if (p->is_whole)
            widen(&all, &of);
        else
            add(y, first, &of, (e->bits & ENTRY_COVERS) != 0);
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
static int is_apart(const layers *y, const layer *back)
{
    if (y->partial <= back->far) return 0;
    for (int n = 0; n < y->front_count; n++)
        if (y->fronts[n].near <= back->far && y->fronts[n].far > back->near) return 0;
    for (int n = 0; n < y->back_count; n++)
        if (&y->backs[n] != back && y->backs[n].near <= back->far && y->backs[n].far > back->near) return 0;
    return 1;
}

/* The first back face that may be an exit. NULL: none */
static const layer *first_exit(const layers *y, int nearest_back)
{
    const layer *first = NULL;
    for (int n = 0; n < y->back_count; n++) {
        const layer *b = &y->backs[n];
        if (first && first->near <= b->near) continue;
        if (nearest_back || closed(y, b->near) >= opened(y, b->near)) first = b;
    }
    return first;
}

int square_settle(const square_list *l, const sparse_triangles *s, texel_square at, const square_bound *outer, int nearest_back,
                  square_parting *out)
{
    layers      y;
    patch_items patches[SETTLE_LIST_MAX];
    if (l->count > SETTLE_LIST_MAX) return 0;
    const size_t count = find_patches(patches, l, s, outer, out);
    if (!count) return 0;
    const lean w  = lean_of(l, s, at);
    y.front_count = 0;
    y.back_count  = 0;
    y.partial     = INFINITY;
    for (size_t n = 0; n < count; n++) add_patch(&y, &w, l, s, &patches[n]);

    const layer *exit = first_exit(&y, nearest_back);
    out->exit_least   = outer->left_out;
    for (int n = 0; n < y.back_count && exit; n++)
        if (y.backs[n].near >= exit->near) out->exit_least = least(out->exit_least, y.backs[n].lo);
    out->is_certain = out->exit_least == outer->left_out || is_apart(&y, exit);
    return 1;
}
