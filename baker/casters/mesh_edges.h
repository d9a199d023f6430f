/* The edges of welded triangles, and what they connect.
 *
 * Half-edge h = 3 t + i runs from corner i of triangle t to the next one. Those of one edge, whichever way they run, are together once
 * they are sorted:
 *
 *     for (uint32_t begin = 0, end; begin < edge_count; begin = end) {
 *         end = mesh_edge_run(indices, sorted, begin, edge_count);
 *         ...
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

/* Which corner of a triangle has the least position, by x, then y, then z: the same wherever a file begins it. */
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

/* The end of the run of half-edges that are one edge, of which `begin` is the first.
 * sorted  [edge_count], edge_count = 3 * triangle_count */
static inline uint32_t mesh_edge_run(const uint32_t *indices, const uint32_t *sorted, uint32_t begin, uint32_t edge_count)
{
    uint32_t end = begin + 1;
    while (end < edge_count && mesh_same_edge(indices, sorted[begin], sorted[end])) end++;
    return end;
}

/* How many more half-edges of a run go the way of its first one than the other way: 0 where windings agree and nothing is open. */
static inline int64_t mesh_edge_balance(const uint32_t *indices, const uint32_t *sorted, uint32_t begin, uint32_t end)
{
    int64_t balance = 0;
    for (uint32_t i = begin; i < end; i++) balance += indices[sorted[i]] == indices[sorted[begin]] ? 1 : -1;
    return balance;
}

/* Sort all half-edges by (low, high), equal ones by number.
 * sorted   [out] [3 * triangle_count]
 * indices  [3 * triangle_count] < vertex_count; triangle_count < UINT32_MAX / 3
 * Returns VXS_OK or VXS_E_MEMORY.  The same at any thread count. */
vxs_result mesh_sort_edges(uint32_t *sorted, const uint32_t *indices, size_t triangle_count, size_t vertex_count, uint32_t threads);

/* Call body with the run [begin, end) of each edge, from several threads at once. */
void mesh_for_each_edge(const uint32_t *indices, const uint32_t *sorted, size_t triangle_count, uint32_t threads,
                        void (*body)(void *user, uint32_t begin, uint32_t end), void *user);

/* Number the components of triangles that are connected by edges, in the order of their first triangles.
 * component_of  [out] [triangle_count]
 * sorted        as mesh_sort_edges has made it
 * Returns their count. */
size_t mesh_find_components(uint32_t *component_of, const uint32_t *sorted, const uint32_t *indices, size_t triangle_count,
                            uint32_t threads);

#ifdef __cplusplus
}
#endif
#endif
