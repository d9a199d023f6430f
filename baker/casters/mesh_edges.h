/* Edges of welded triangles, and components connected by them.
 *
 * Half-edge h = 3 t + i runs from corner i of triangle t to the next corner. After sorting, the half-edges of an edge are adjacent,
 * in whichever direction they run:
 *
 *     for (uint32_t begin = 0, end; begin < edge_count; begin = end) {
 *         end = mesh_edge_run(indices, sorted, begin, edge_count);
 *         ...
 *     }
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef MESH_EDGES_H
#define MESH_EDGES_H

#include <stddef.h>
#include <stdint.h>

#include "baker/scene/scene.h"
#include "formats/vxs_result.h"

/* Union-find: items are numbers. The name of a set is its lowest item, so it does not depend on the order of joins. */

/* Lock-free: several threads may find and join at once. A value read may be outdated, but it is still an ancestor: only roots get a
 * new parent, by compare-and-exchange; other items only move up to an ancestor.
 * parents  parents[i] = i at first */
static inline uint32_t mesh_find(uint32_t *parents, uint32_t i)
{
    for (;;) {
        uint32_t up = __atomic_load_n(&parents[i], __ATOMIC_RELAXED), top = __atomic_load_n(&parents[up], __ATOMIC_RELAXED);
        if (up == top) return up;
        __atomic_store_n(&parents[i], top, __ATOMIC_RELAXED);
        i = top;
    }
}

/* Call after all joins: attach an item directly to its root. Several threads may do this for different items. */
static inline void mesh_settle(uint32_t *parents, uint32_t item)
{
    uint32_t i = item, up;
    while ((up = __atomic_load_n(&parents[i], __ATOMIC_RELAXED)) != i) i = up;
    __atomic_store_n(&parents[item], i, __ATOMIC_RELAXED);
}

static inline void mesh_join(uint32_t *parents, uint32_t a, uint32_t b)
{
    for (;;) {
        a = mesh_find(parents, a);
        b = mesh_find(parents, b);
        if (a == b) return;
        uint32_t low = a < b ? a : b, high = a < b ? b : a, root = high;
        if (__atomic_compare_exchange_n(&parents[high], &root, low, 0, __ATOMIC_RELAXED, __ATOMIC_RELAXED)) return;
    }
}

/* The same for items with orientation: turned[i] is 1 when i is reversed relative to its parent. */
static inline uint32_t mesh_find_turned(uint32_t *parents, uint8_t *turned, uint32_t i, int *is_turned)
{
    *is_turned = 0;
    while (parents[i] != i) {
        uint32_t up = parents[i];
        if (parents[up] != up) { /* path halving: attach i to its grandparent */
            turned[i] ^= turned[up];
            parents[i] = parents[up];
        }
        *is_turned ^= turned[i];
        i = parents[i];
    }
    return i;
}

/* Join a and b, with `turn` 1 when they are reversed relative to each other. Returns 0 when they are already joined with the
 * opposite orientation. */
static inline int mesh_join_turned(uint32_t *parents, uint8_t *turned, uint32_t a, uint32_t b, int turn)
{
    int      a_turned, b_turned;
    uint32_t p = mesh_find_turned(parents, turned, a, &a_turned), q = mesh_find_turned(parents, turned, b, &b_turned);
    turn ^= a_turned ^ b_turned;
    if (p == q) return !turn;
    uint32_t low = p < q ? p : q, high = p < q ? q : p;
    parents[high] = low;
    turned[high]  = (uint8_t)turn;
    return 1;
}

/* One vertex for each position. */

#ifdef __cplusplus
extern "C" {
#endif

typedef struct mesh_weld {
    size_t    vertex_count;
    double   *positions_ws; /* [3 * vertex_count] finite and distinct; -0 is stored as +0 */
    size_t    triangle_count;
    uint32_t *indices;   /* [3 * triangle_count] three different vertices per triangle, in the scene's order */
    uint32_t *from;      /* [triangle_count] triangle number in the scene, ascending */
    uint32_t *welded_of; /* [the scene's vertex_count] welded vertex; UINT32_MAX: no triangle uses the position */
} mesh_weld;

/* Weld vertices at bit-equal positions, and drop triangles with two corners at one position.
 * w  [out] zeroed on failure; released with mesh_weld_free
 * Returns VXS_OK, VXS_E_MEMORY, or VXS_E_SCENE: a corner is not finite, or there are 2^32 / 3 triangles or more. The result does
 * not depend on the number of threads. */
vxs_result mesh_weld_scene(mesh_weld *w, const scene *s, uint32_t threads, run_context *m);

void mesh_weld_free(mesh_weld *w);

static inline uint32_t mesh_edge_end(const uint32_t *indices, uint32_t h)
{
    return indices[h % 3 == 2 ? h - 2 : h + 1];
}

/* The third corner of a half-edge's triangle. */
static inline uint32_t mesh_edge_opposite(const uint32_t *indices, uint32_t h)
{
    return indices[h % 3 == 0 ? h + 2 : h - 1];
}

/* The lower and the higher of an edge's two vertices. */
static inline uint32_t mesh_edge_low(const uint32_t *indices, uint32_t h)
{
    uint32_t a = indices[h], b = mesh_edge_end(indices, h);
    return a < b ? a : b;
}

static inline uint32_t mesh_edge_high(const uint32_t *indices, uint32_t h)
{
    uint32_t a = indices[h], b = mesh_edge_end(indices, h);
    return a < b ? b : a;
}

/* Corner of a triangle with the least position (by x, then y, then z). Does not depend on the corner that the file starts with. */
static inline uint32_t mesh_least_corner(const double *positions, const uint32_t corners[3])
{
    uint32_t least = 0;
    for (uint32_t n = 1; n < 3; n++) {
        const double *a = &positions[3 * (size_t)corners[n]], *b = &positions[3 * (size_t)corners[least]];
        int           axis = 0;
        while (axis < 2 && a[axis] == b[axis]) axis++;
        if (a[axis] < b[axis]) least = n;
    }
    return least;
}

static inline int mesh_same_edge(const uint32_t *indices, uint32_t h, uint32_t g)
{
    return mesh_edge_low(indices, h) == mesh_edge_low(indices, g) && mesh_edge_high(indices, h) == mesh_edge_high(indices, g);
}

/* End of the run of half-edges of one edge that starts at `begin`.
 * sorted  [edge_count], edge_count = 3 * triangle_count */
static inline uint32_t mesh_edge_run(const uint32_t *indices, const uint32_t *sorted, uint32_t begin, uint32_t edge_count)
{
    uint32_t end = begin + 1;
    while (end < edge_count && mesh_same_edge(indices, sorted[begin], sorted[end])) end++;
    return end;
}

/* Number of half-edges in a run with the direction of the first one, minus the number in the opposite direction. 0: closed and
 * consistently oriented. */
static inline int64_t mesh_edge_balance(const uint32_t *indices, const uint32_t *sorted, uint32_t begin, uint32_t end)
{
    int64_t balance = 0;
    for (uint32_t i = begin; i < end; i++) balance += indices[sorted[i]] == indices[sorted[begin]] ? 1 : -1;
    return balance;
}

/* Sort all half-edges by (low, high); ties by number.
 * sorted   [out] [3 * triangle_count]
 * indices  [3 * triangle_count] < vertex_count; triangle_count < UINT32_MAX / 3
 * Returns VXS_OK or VXS_E_MEMORY. The result does not depend on the number of threads. */
vxs_result mesh_sort_edges(uint32_t *sorted, const uint32_t *indices, size_t triangle_count, size_t vertex_count, uint32_t threads);

/* Call body with the run [begin, end) of each edge, from several threads at once. */
void mesh_for_each_edge(const uint32_t *indices, const uint32_t *sorted, size_t triangle_count, uint32_t threads,
                        void (*body)(void *user, uint32_t begin, uint32_t end), void *user);

/* Number the components of triangles connected by edges, in the order of first triangles.
 * component_of  [out] [triangle_count]
 * sorted        from mesh_sort_edges
 * Returns the number of components. */
size_t mesh_find_components(uint32_t *component_of, const uint32_t *sorted, const uint32_t *indices, size_t triangle_count,
                            uint32_t threads);

/* The same for triangles that are joined already (mesh_join).
 * component_of  [triangle_count] in: a forest over the triangles; out: numbers */
size_t mesh_number_components(uint32_t *component_of, size_t triangle_count, uint32_t threads);

#ifdef __cplusplus
}
#endif

#endif
