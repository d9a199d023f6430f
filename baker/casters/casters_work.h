/* State between a scene and its casters; see casters_work.c.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CASTERS_WORK_H
#define CASTERS_WORK_H

#include <stdlib.h>

#include "baker/base/box.h"
#include "baker/base/memory.h"
#include "baker/casters/casters.h"
#include "baker/casters/casters_cgal.h"
#include "baker/casters/mesh_edges.h"

#define NONE UINT32_MAX

/* in addition to the scene's TRIANGLE_*; the corner that a triangle of the result starts at, and whether it is turned */
enum { EDGE_OPEN = 0x80, STARTS_SHIFT = 4, STARTS = 3 << STARTS_SHIFT, TURNED = 0x40 };

enum { GRAIN = 1 << 14 };

typedef struct component {
    uint32_t       triangle_count;
    part_span      parts;
    uint8_t        flags; /* OR of the flags of all its triangles */
    component_kind kind;
    uint32_t       number; /* component number in the result */
    double         volume; /* signed: positive when it faces outward. Summed around one of its corners: large coordinates cancel */
} component;

/* State between scene and result. Vertex numbers are those of welded vertices. */
typedef struct work {
    uint32_t  threads;
    mesh_weld mesh;
    uint8_t  *flags;        /* [triangle_count] TRIANGLE_*, EDGE_OPEN */
    uint32_t *hole_of;      /* [triangle_count] index into holes, or NONE; NULL: the scene has no holes */
    uint32_t *component_of; /* [triangle_count] */
    uint32_t *edge_mates;   /* [3 * triangle_count] as in casters; NULL: not wanted, or not valid any more */

    const holed_triangle *holes;     /* the scene's; own_holes after triangles with holes are split */
    holed_triangle       *own_holes; /* the scene's holes, followed by those of pieces */

    int       has_unused; /* 1: no triangle uses some vertex */
    size_t    border_count, border_capacity;
    uint32_t *border; /* [border_count] open half-edges, grouped by edge; empty when not wanted */

    size_t     component_count;
    component *components; /* in the order of first triangles */
    box       *boxes;      /* [component_count] */
    uint32_t  *first_of;   /* [component_count + 1] component i owns members[first_of[i]] .. members[first_of[i + 1] - 1] */
    uint32_t  *members;    /* [triangle_count] */
} work;

/* Zeroed memory. Never NULL for a count of 0, unlike calloc. */
static inline void *allocate(size_t count, size_t size)
{
    return calloc(count ? count : 1, size);
}

/* Check the memory for the arrays of a step: bytes_each per triangle, and bytes_of_vertex per vertex. */
static inline vxs_result check_room(size_t triangles, size_t bytes_each, size_t vertices, size_t bytes_of_vertex, run_context *m)
{
    uint64_t bytes = (uint64_t)triangles * bytes_each + (uint64_t)vertices * bytes_of_vertex;
    return memory_check(bytes, m, "telling solids from sheets among %zu triangles needs", triangles);
}

static inline vxs_result out_of_memory(run_context *m, size_t triangle_count)
{
    return fail(m, VXS_E_MEMORY, "out of memory while sorting %zu triangles into solids and sheets", triangle_count);
}

/* Write the casters of classified components.
 * c  [out] released with casters_free, whatever is returned. Takes over some arrays of the work
 * Returns VXS_OK or VXS_E_MEMORY. */
vxs_result casters_emit(casters *c, work *w, const scene *s, run_context *m);

#endif
