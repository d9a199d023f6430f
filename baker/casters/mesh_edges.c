/* Sorting edges; see mesh_edges.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/casters/mesh_edges.h"

#include <stdlib.h>
#include <string.h>

#include "baker/casters/mesh_join.h"

/* counts[k] items of key k become the place where the first of them goes. */
static void counts_to_places(uint32_t *counts, size_t key_count)
{
    uint32_t place = 0;
    for (size_t k = 0; k < key_count; k++) {
        uint32_t count = counts[k];
        counts[k]      = place;
        place += count;
    }
}

/* Two stable counting passes, by high and then by low.  scratch  [3 * triangle_count];  places  [vertex_count] */
static void sort_edges(uint32_t *sorted, uint32_t *scratch, uint32_t *places, const uint32_t *indices, uint32_t edge_count,
                       size_t vertex_count)
{
    memset(places, 0, vertex_count * sizeof *places);
    for (uint32_t h = 0; h < edge_count; h++) places[mesh_edge_high(indices, h)]++;
    counts_to_places(places, vertex_count);
    for (uint32_t h = 0; h < edge_count; h++) scratch[places[mesh_edge_high(indices, h)]++] = h;

    memset(places, 0, vertex_count * sizeof *places);
    for (uint32_t h = 0; h < edge_count; h++) places[mesh_edge_low(indices, h)]++;
    counts_to_places(places, vertex_count);
    for (uint32_t i = 0; i < edge_count; i++) sorted[places[mesh_edge_low(indices, scratch[i])]++] = scratch[i];
}

vxs_result mesh_sort_edges(uint32_t *sorted, const uint32_t *indices, size_t triangle_count, size_t vertex_count)
{
    uint32_t *scratch = malloc((3 * triangle_count + 1) * sizeof *scratch);
    uint32_t *places  = malloc((vertex_count + 1) * sizeof *places);
    int       ok      = scratch && places;
    if (ok) sort_edges(sorted, scratch, places, indices, (uint32_t)(3 * triangle_count), vertex_count);
    free(scratch);
    free(places);
    return ok ? VXS_OK : VXS_E_MEMORY;
}

size_t mesh_find_components(uint32_t *component_of, const uint32_t *sorted, const uint32_t *indices, size_t triangle_count)
{
    uint32_t edge_count = (uint32_t)(3 * triangle_count);
    size_t   count      = 0;
    for (uint32_t t = 0; t < triangle_count; t++) component_of[t] = t; /* first the parents of a forest */
    for (uint32_t i = 1; i < edge_count; i++)
        if (mesh_same_edge(indices, sorted[i - 1], sorted[i])) mesh_join(component_of, sorted[i - 1] / 3, sorted[i] / 3);
    for (uint32_t t = 0; t < triangle_count; t++) component_of[t] = mesh_find(component_of, t);
    /* a root is the first of its component: it has its number before anyone asks for it */
    for (uint32_t t = 0; t < triangle_count; t++)
        component_of[t] = component_of[t] == t ? (uint32_t)count++ : component_of[component_of[t]];
    return count;
}

void mesh_group(uint32_t *first, uint32_t *members, const uint32_t *key_of, size_t count, size_t key_count)
{
    memset(first, 0, (key_count + 1) * sizeof *first);
    for (size_t i = 0; i < count; i++) first[key_of[i]]++;
    counts_to_places(first, key_count);
    for (uint32_t i = 0; i < count; i++) members[first[key_of[i]]++] = i;
    /* each place has moved on to where the next key begins */
    memmove(first + 1, first, key_count * sizeof *first);
    first[0] = 0;
}
