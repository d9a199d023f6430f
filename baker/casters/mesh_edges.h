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

#include "formats/vxs_result.h"

#ifdef __cplusplus
extern "C" {
#endif

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

#ifdef __cplusplus
}
#endif
#endif
