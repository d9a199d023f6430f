/* Which solids meet; see casters_find_meeting in casters.h.
 *
 *   corners ---in common---> meet
 *   triangles ---touch, cross---> meet          (also within one solid)
 *   boxes in boxes ---a corner inside---> meet  (without contact, a solid is inside as a whole or not at all)
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/casters/casters.h"

#include <stdlib.h>
#include <string.h>

#include "baker/base/array.h"
#include "baker/base/box.h"
#include "baker/base/group.h"
#include "baker/casters/casters_cgal.h"

/* Limits of the searches: a few seconds each. */
#define OVERLAPS_MAX 400000000u
#define TESTS_MAX    20000000u
#define PAIRS_MAX    4000000u /* pairs of a box in another box */

typedef struct meeting {
    const casters *c;
    size_t         solids, open; /* number of solids; number of undecided solids */
    uint8_t       *meets;        /* [solids] */
    box           *boxes;        /* [solids] */
    uint32_t      *first;        /* [solids + 1] */
    uint32_t      *members;      /* [solid_triangle_count] grouped by solid */
    uint8_t       *near;         /* [solids] the box of another solid touches its box */
    uint32_t      *solid_at;     /* [vertex_count] 1 + a solid with this corner; 0: none */
    shell_pair    *pairs;        /* [pair_count] candidates: a box in another box */
    size_t         pair_count, pair_room;
    int            gave_up;
} meeting;

static void mark(meeting *w, uint32_t solid)
{
    w->open -= !w->meets[solid];
    __atomic_store_n(&w->meets[solid], 1, __ATOMIC_RELAXED); /* is_undecided may read it now: an old value costs a test */
}

static void mark_pair(meeting *w, uint32_t a, uint32_t b)
{
    mark(w, a);
    mark(w, b);
}

/* 1 when both solids are decided already. */
static int is_known(const meeting *w, uint32_t a, uint32_t b)
{
    return __atomic_load_n(&w->meets[a], __ATOMIC_RELAXED) && __atomic_load_n(&w->meets[b], __ATOMIC_RELAXED);
}

/* --- solids ----------------------------------------------------------------------------------------------------------- */

static int box_holds(const box *outer, const box *inner)
{
    for (int axis = 0; axis < 3; axis++)
        if (inner->min[axis] < outer->min[axis] || inner->max[axis] > outer->max[axis]) return 0;
    return 1;
}

/* --- surfaces --------------------------------------------------------------------------------------------------------- */

static int is_undecided(void *user, uint32_t a, uint32_t b)
{
    const meeting  *w  = user;
    const uint32_t *of = w->c->component_of;
    return !is_known(w, of[a], of[b]);
}

static int surfaces_meet(void *user, uint32_t a, uint32_t b)
{
    meeting *w = user;
    mark_pair(w, w->c->component_of[a], w->c->component_of[b]);
    return !w->open;
}

/* --- insides ---------------------------------------------------------------------------------------------------------- */

static int add_pair(meeting *w, uint32_t outer, uint32_t inner)
{
    if (w->pair_count >= PAIRS_MAX || !array_reserve(&w->pairs, &w->pair_room, w->pair_count + 1, sizeof *w->pairs)) return 0;
    w->pairs[w->pair_count++] = (shell_pair){.outer = outer, .inner = inner};
    return 1;
}

/* Callback for two overlapping boxes of solids: one solid may be inside the other. */
static int boxes_meet(void *user, uint32_t a, uint32_t b)
{
    meeting *w = user;
    w->near[a] = w->near[b] = 1;
    if (is_known(w, a, b)) return 0;
    if (box_holds(&w->boxes[a], &w->boxes[b])) w->gave_up |= !add_pair(w, a, b);
    if (box_holds(&w->boxes[b], &w->boxes[a])) w->gave_up |= !add_pair(w, b, a);
    return w->gave_up;
}

static int by_outer(const void *a, const void *b)
{
    const shell_pair *p = a, *q = b;
    if (p->outer != q->outer) return p->outer < q->outer ? -1 : 1;
    return p->inner < q->inner ? -1 : p->inner > q->inner;
}

static vxs_result search_insides(meeting *w)
{
    const casters *c      = w->c;
    shell_set      shells = {.positions_ws = c->positions_ws,
                             .indices      = c->indices,
                             .count        = w->solids,
                             .first        = w->first,
                             .members      = w->members,
                             .boxes        = w->boxes};
    vxs_result     r      = mesh_find_overlaps(w->boxes, w->solids, boxes_meet, w);
    if (r != VXS_OK || w->gave_up || !w->pair_count) return r;
    qsort(w->pairs, w->pair_count, sizeof *w->pairs, by_outer);
    if ((r = shells_find_inside(&shells, w->pairs, w->pair_count)) != VXS_OK) return r;
    for (size_t i = 0; i < w->pair_count; i++)
        if (w->pairs[i].inside) mark_pair(w, w->pairs[i].outer, w->pairs[i].inner);
    return VXS_OK;
}

/* ---------------------------------------------------------------------------------------------------------------------- */

/* Decide all solids of c. */
static vxs_result search(meeting *w, uint32_t threads, run_context *m)
{
    const casters *c = w->c;
    vxs_result     r = VXS_E_MEMORY;

    size_t triangles = c->solid_triangle_count + 1; /* + 1: an allocation of 0 bytes may return NULL */
    w->meets         = calloc(w->solids + 1, sizeof *w->meets);
    w->boxes         = malloc((w->solids + 1) * sizeof *w->boxes);
    w->first         = calloc(w->solids + 1, sizeof *w->first);
    w->members       = malloc(triangles * sizeof *w->members);
    w->near          = calloc(w->solids + 1, sizeof *w->near);
    w->solid_at      = calloc(c->vertex_count + 1, sizeof *w->solid_at);
    if (w->meets && w->boxes && w->first && w->members && w->near && w->solid_at) {
        r = group_by_key(w->first, w->members, c->component_of, c->solid_triangle_count, w->solids, threads);
        for (size_t i = 0; i < w->solids; i++) w->boxes[i] = box_empty();
        for (size_t i = 0; i < 3 * c->solid_triangle_count; i++)
            box_add(&w->boxes[c->component_of[i / 3]], &c->positions_ws[3 * (size_t)c->indices[i]]);

        /* Find solids with a common corner; the search of triangles does not report these. */
        uint32_t *solid_at = w->solid_at;
        for (size_t i = 0; i < 3 * c->solid_triangle_count; i++) {
            uint32_t solid = c->component_of[i / 3], *at = &solid_at[c->indices[i]];
            if (*at && *at != solid + 1) mark_pair(w, *at - 1, solid);
            *at = solid + 1;
        }

        if (r == VXS_OK && w->open) {
            mesh_soup   soup   = {c->positions_ws, c->indices, c->solid_triangle_count};
            mesh_search search = {.wanted       = is_undecided,
                                  .found        = surfaces_meet,
                                  .user         = w,
                                  .threads      = threads,
                                  .overlaps_max = OVERLAPS_MAX,
                                  .tests_max    = TESTS_MAX};
            r                  = mesh_find_intersections(&soup, &search);
            w->gave_up         = search.gave_up;
        }
        if (r == VXS_OK && w->open && !w->gave_up) r = search_insides(w);
    }

    return r == VXS_OK ? r : fail(m, VXS_E_MEMORY, "out of memory while finding out which of %zu solids meet", w->solids);
}

vxs_result casters_find_meeting(casters *c, uint32_t threads, run_context *m)
{
    size_t     solids = c->component_count[COMPONENT_SOLID];
    meeting    w      = {.c = c, .solids = solids, .open = solids};
    vxs_result r      = search(&w, threads, m);

    free(c->solid_meets);
    c->solid_meets = r == VXS_OK ? calloc(c->solid_triangle_count + 1, sizeof *c->solid_meets) : NULL;
    if (c->solid_meets) {
        meeting_counts counts = {.solids = w.solids, .assumed = w.gave_up ? w.open : 0};
        counts.meet           = w.solids - w.open + counts.assumed;
        for (size_t i = 0; i < w.solids; i++) counts.apart_by_box += !w.gave_up && !w.meets[i] && !w.near[i];
        for (size_t t = 0; t < c->solid_triangle_count; t++) c->solid_meets[t] = w.gave_up || w.meets[c->component_of[t]];
        c->meeting = counts;
    }
    if (r == VXS_OK && !c->solid_meets) r = fail(m, VXS_E_MEMORY, "out of memory for %zu solids", solids);

    free(w.meets);
    free(w.boxes);
    free(w.first);
    free(w.members);
    free(w.near);
    free(w.solid_at);
    free(w.pairs);

    return r;
}
