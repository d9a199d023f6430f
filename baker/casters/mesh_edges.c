/* Sorting edges; see mesh_edges.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/casters/mesh_edges.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/group.h"
#include "baker/base/pages.h"
#include "baker/base/parallel.h"
#include "baker/base/system.h"

/* Welding; see mesh_edges.h.
 *
 *     vertices ---hash table---> the first at each position ---in the order of triangles---> welded
 * */

#define XXH_INLINE_ALL
#include <xxhash.h>

#define NONE UINT32_MAX

enum { GRAIN = 1 << 14 };

/* Vertices of a position share a slot of the table, which threads fill without locks: a slot never changes its position, and its
 * vertex only becomes lower. So the result does not depend on their order. */
typedef struct welder {
    const double *positions_ws; /* the scene's */
    uint64_t     *table;        /* [slot_mask + 1] upper half: bits of the hash; lower half: vertex; or EMPTY */
    size_t        slot_mask;
    uint32_t     *alike;     /* [the scene's vertex_count] slot of the position, then the first vertex there */
    uint32_t     *welded_as; /* [the scene's vertex_count] welded vertex of the first vertex at a position, or NONE */
} welder;

#define EMPTY UINT64_MAX

/* Normalizes -0 to +0. */
static void take_position(double p[3], const double *positions_ws, size_t vertex)
{
    for (int axis = 0; axis < 3; axis++) p[axis] = positions_ws[3 * vertex + (size_t)axis] + 0.0;
}

static int is_at(const welder *d, uint32_t vertex, const double p[3])
{
    double q[3];
    take_position(q, d->positions_ws, vertex);
    return !memcmp(p, q, sizeof q);
}

/* Returns the slot of a vertex. */
static size_t insert(const welder *d, uint32_t vertex)
{
    double p[3];
    take_position(p, d->positions_ws, vertex);
    uint64_t hash = XXH3_64bits(p, sizeof p), own = hash >> 32 << 32 | vertex;
    for (size_t slot = hash & d->slot_mask;; slot = (slot + 1) & d->slot_mask) {
        uint64_t there = __atomic_load_n(&d->table[slot], __ATOMIC_RELAXED);
        while (there == EMPTY || there >> 32 == own >> 32) {
            if (there != EMPTY && !is_at(d, (uint32_t)there, p)) break;
            if (there <= own) return slot;
            if (__atomic_compare_exchange_n(&d->table[slot], &there, own, 1, __ATOMIC_RELAXED, __ATOMIC_RELAXED)) return slot;
        }
    }
}

static void clear_slots(void *user, size_t begin, size_t end, uint32_t worker)
{
    welder *d = user;
    (void)worker;
    memset(d->table + begin, 0xff, (end - begin) * sizeof *d->table);
}

static void insert_some(void *user, size_t begin, size_t end, uint32_t worker)
{
    welder *d = user;
    (void)worker;
    for (size_t v = begin; v < end; v++) d->alike[v] = (uint32_t)insert(d, (uint32_t)v);
}

static void look_up_some(void *user, size_t begin, size_t end, uint32_t worker)
{
    welder *d = user;
    (void)worker;
    for (size_t v = begin; v < end; v++) d->alike[v] = (uint32_t)d->table[d->alike[v]];
}

/* Find vertices at equal positions. */
static vxs_result find_alike(welder *d, size_t vertex_count, uint32_t threads)
{
    uint64_t slots = 16;
    while (2 * slots < 3 * (uint64_t)vertex_count) slots *= 2;
    if (slots > UINT32_MAX || slots > SIZE_MAX / sizeof *d->table) return VXS_E_MEMORY;
    d->slot_mask = (size_t)slots - 1;
    d->table     = pages_alloc((size_t)slots * sizeof *d->table);
    d->alike     = pages_alloc((vertex_count + 1) * sizeof *d->alike);
    if (!d->table || !d->alike) return VXS_E_MEMORY;
    parallel_for(threads, (size_t)slots, GRAIN, clear_slots, d);
    parallel_for(threads, vertex_count, GRAIN, insert_some, d);
    parallel_for(threads, vertex_count, GRAIN, look_up_some, d);
    free(d->table);
    d->table     = NULL;
    d->welded_as = pages_alloc((vertex_count + 1) * sizeof *d->welded_as);
    return d->welded_as ? VXS_OK : VXS_E_MEMORY;
}

static int is_finite(const double p[3])
{
    return isfinite(p[0]) && isfinite(p[1]) && isfinite(p[2]);
}

static vxs_result not_finite(const double p[3], size_t triangle, run_context *m)
{
    return fail(m, VXS_E_SCENE, "triangle %zu: corner at (%g, %g, %g), expected finite coordinates", triangle, p[0], p[1], p[2]);
}

/* Vertices of collapsed triangles alone, and those that no triangle uses, are left out: they must not enlarge the bounds. The latter
 * may be invalid. */
static vxs_result weld_triangles(mesh_weld *w, const welder *d, const scene *s, run_context *m)
{
    for (size_t t = 0; t < s->triangle_count; t++) {
        const uint32_t *corners = &s->indices[3 * t];
        assert(corners[0] < s->vertex_count && corners[1] < s->vertex_count && corners[2] < s->vertex_count);
        const uint32_t alike[3]  = {d->alike[corners[0]], d->alike[corners[1]], d->alike[corners[2]]};
        int            collapses = alike[0] == alike[1] || alike[1] == alike[2] || alike[2] == alike[0];
        for (size_t i = 0; i < 3; i++) {
            uint32_t     *as = &d->welded_as[alike[i]];
            const double *p  = &s->positions_ws[3 * (size_t)corners[i]];
            if (*as == NONE && !is_finite(p)) return not_finite(p, t, m);
            if (collapses) continue;
            if (*as == NONE) {
                *as = (uint32_t)w->vertex_count++;
                take_position(&w->positions_ws[3 * (size_t)*as], d->positions_ws, corners[i]);
            }
            w->indices[3 * w->triangle_count + i] = *as;
        }
        if (!collapses) w->from[w->triangle_count++] = (uint32_t)t;
    }
    return VXS_OK;
}

static void find_welded(void *user, size_t begin, size_t end, uint32_t worker)
{
    welder *d = user;
    (void)worker;
    for (size_t v = begin; v < end; v++) d->alike[v] = d->welded_as[d->alike[v]];
}

vxs_result mesh_weld_scene(mesh_weld *w, const scene *s, uint32_t threads, run_context *m)
{
    welder d = {.positions_ws = s->positions_ws};

    *w = (mesh_weld){0};
    /* half-edge numbers have 32 bits */
    if (s->triangle_count >= NONE / 3 || s->vertex_count >= NONE)
        return fail(m, VXS_E_SCENE, "%zu triangles with %zu vertices, expected fewer than %u and %u", s->triangle_count,
                    s->vertex_count, NONE / 3, NONE);
    vxs_result r = find_alike(&d, s->vertex_count, threads);
    if (r == VXS_OK) {
        w->positions_ws = pages_alloc((3 * s->vertex_count + 1) * sizeof *w->positions_ws);
        w->indices      = pages_alloc((3 * s->triangle_count + 3) * sizeof *w->indices);
        w->from         = pages_alloc((s->triangle_count + 1) * sizeof *w->from);
        if (!w->positions_ws || !w->indices || !w->from) r = VXS_E_MEMORY;
    }
    if (r == VXS_OK) {
        memset(d.welded_as, 0xff, s->vertex_count * sizeof *d.welded_as);
        if ((r = weld_triangles(w, &d, s, m)) == VXS_OK) {
            parallel_for(threads, s->vertex_count, GRAIN, find_welded, &d);
            w->welded_of = d.alike; /* reuses the memory */
            d.alike      = NULL;
        }
    } else {
        fail(m, r, "out of memory while welding %zu triangles", s->triangle_count);
    }

    free(d.table);
    free(d.alike);
    free(d.welded_as);

    if (r != VXS_OK) mesh_weld_free(w);
    return r;
}

void mesh_weld_free(mesh_weld *w)
{
    free(w->positions_ws);
    free(w->indices);
    free(w->from);
    free(w->welded_of);
    *w = (mesh_weld){0};
}

/* --- sort ------------------------------------------------------------------------------------------------------------- */

typedef struct edge_sorter {
    const uint32_t *indices;
    uint32_t       *low;    /* [3 * triangle_count] lower vertex of each half-edge */
    uint32_t       *first;  /* [vertex_count + 1] first half-edge of each lower vertex in `sorted` */
    uint32_t       *sorted; /* [3 * triangle_count] sorted by lower vertex */
} edge_sorter;

static void find_low(void *user, size_t begin, size_t end, uint32_t worker)
{
    edge_sorter *w = user;
    (void)worker;
    for (size_t h = begin; h < end; h++) w->low[h] = mesh_edge_low(w->indices, (uint32_t)h);
}

static int by_high(const void *a, const void *b, void *indices)
{
    uint32_t h = *(const uint32_t *)a, g = *(const uint32_t *)b;
    uint32_t p = mesh_edge_high(indices, h), q = mesh_edge_high(indices, g);
    return p != q ? p < q ? -1 : 1 : h < g ? -1 : h > g;
}

static void sort_vertices(void *user, size_t begin, size_t end, uint32_t worker)
{
    edge_sorter *w = user;
    (void)worker;
    for (size_t v = begin; v < end; v++) {
        /* Sort half-edges with the same lower vertex. There are few of them, except at the centre of a large fan. */
        uint32_t       *edges   = w->sorted + w->first[v];
        uint32_t        count   = w->first[v + 1] - w->first[v];
        const uint32_t *indices = w->indices;
        enum { FEW = 32 };
        uint32_t high[FEW];
        if (count > FEW) {
            system_sort(edges, count, sizeof *edges, by_high, (void *)(size_t)indices);
            continue;
        }
        for (uint32_t n = 0; n < count; n++) {
            uint32_t h = edges[n], key = mesh_edge_high(indices, h), k = n;
            for (; k > 0 && high[k - 1] > key; k--) {
                high[k]  = high[k - 1];
                edges[k] = edges[k - 1];
            }
            high[k]  = key;
            edges[k] = h;
        }
    }
}

vxs_result mesh_sort_edges(uint32_t *sorted, const uint32_t *indices, size_t triangle_count, size_t vertex_count, uint32_t threads)
{
    size_t      edge_count = 3 * triangle_count;
    edge_sorter w          = {.indices = indices,
                              .low     = pages_alloc((edge_count + 1) * sizeof *w.low),
                              .first   = pages_alloc((vertex_count + 1) * sizeof *w.first),
                              .sorted  = sorted};
    vxs_result  r          = VXS_E_MEMORY;
    if (w.low && w.first) {
        parallel_for(threads, edge_count, GRAIN, find_low, &w);
        r = group_by_key(w.first, sorted, w.low, edge_count, vertex_count, threads);
    }
    free(w.low);
    if (r == VXS_OK) parallel_for(threads, vertex_count, GRAIN, sort_vertices, &w);
    free(w.first);
    return r;
}

/* --- edges ------------------------------------------------------------------------------------------------------------ */

typedef struct edge_walk {
    const uint32_t *indices, *sorted;
    uint32_t        edge_count;
    void (*body)(void *user, uint32_t begin, uint32_t end);
    void *user;
} edge_walk;

/* The lower and the higher vertex of a half-edge. */
static uint64_t edge_key(const uint32_t *indices, uint32_t h)
{
    uint32_t a = indices[h], b = mesh_edge_end(indices, h);
    return a < b ? (uint64_t)a << 32 | b : (uint64_t)b << 32 | a;
}

/* Visit the edges whose runs begin in [part_begin, part_end). */
static void walk_edges(void *user, size_t part_begin, size_t part_end, uint32_t worker)
{
    const edge_walk *w     = user;
    uint32_t         begin = (uint32_t)part_begin;
    uint64_t         key = begin ? edge_key(w->indices, w->sorted[begin - 1]) : 0, next = key;
    (void)worker;
    while (begin && begin < part_end && (next = edge_key(w->indices, w->sorted[begin])) == key) begin++;
    if (!begin) next = edge_key(w->indices, w->sorted[0]);
    for (uint32_t end; begin < part_end; begin = end) {
        key = next;
        for (end = begin + 1; end < w->edge_count && (next = edge_key(w->indices, w->sorted[end])) == key;) end++;
        w->body(w->user, begin, end);
    }
}

void mesh_for_each_edge(const uint32_t *indices, const uint32_t *sorted, size_t triangle_count, uint32_t threads,
                        void (*body)(void *user, uint32_t begin, uint32_t end), void *user)
{
    edge_walk w = {indices, sorted, (uint32_t)(3 * triangle_count), body, user};
    parallel_for(threads, w.edge_count, GRAIN, walk_edges, &w);
}

/* --- components ------------------------------------------------------------------------------------------------------- */

typedef struct joining {
    uint32_t       *component_of; /* first the parents in a union-find forest */
    const uint32_t *sorted;
} joining;

static void join_edge(void *user, uint32_t begin, uint32_t end)
{
    const joining *j = user;
    for (uint32_t i = begin + 1; i < end; i++) mesh_join(j->component_of, j->sorted[begin] / 3, j->sorted[i] / 3);
}

static void find_roots(void *user, size_t begin, size_t end, uint32_t worker)
{
    const joining *j = user;
    (void)worker;
    for (size_t t = begin; t < end; t++) mesh_settle(j->component_of, (uint32_t)t);
}

size_t mesh_number_components(uint32_t *component_of, size_t triangle_count, uint32_t threads)
{
    joining j     = {component_of, NULL};
    size_t  count = 0;
    parallel_for(threads, triangle_count, GRAIN, find_roots, &j);
    /* a root is the first triangle of its component, so its number is known before its members need it */
    for (uint32_t t = 0; t < triangle_count; t++)
        component_of[t] = component_of[t] == t ? (uint32_t)count++ : component_of[component_of[t]];
    return count;
}

size_t mesh_find_components(uint32_t *component_of, const uint32_t *sorted, const uint32_t *indices, size_t triangle_count,
                            uint32_t threads)
{
    joining j = {component_of, sorted};
    for (uint32_t t = 0; t < triangle_count; t++) component_of[t] = t;
    mesh_for_each_edge(indices, sorted, triangle_count, threads, join_edge, &j);
    return mesh_number_components(component_of, triangle_count, threads);
}
