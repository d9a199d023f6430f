/* Why components of the casters are not solids, and their other faults.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef MESH_HEALTH_H
#define MESH_HEALTH_H

#include "baker/base/box.h"
#include "baker/casters/casters.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { HEALTH_FAULTS = 3, HEALTH_COUNTS = 11 }; /* index of the first count that is a fault, and the number of counts */

/* One connected component, or the sum of all. */
typedef struct component_health {
    component_kind kind; /* as the casters have it */
    union {
        struct {
            uint64_t triangles, vertices, edges;
            uint64_t boundary_edges;       /* edges of one triangle: the first fault */
            uint64_t holes;                /* connected groups of boundary edges */
            uint64_t nonmanifold_edges;    /* of more than two triangles */
            uint64_t misoriented_edges;    /* edges of two triangles with different windings */
            uint64_t nonmanifold_vertices; /* vertices whose triangles form several groups that no edge connects */
            /* pairs of its triangles that share more than an edge or a corner; without repeated triangles */
            uint64_t self_intersections;
            uint64_t zero_area_triangles; /* three corners on one line */
            uint64_t repeated_triangles;  /* triangles with the same three corners as an earlier one, in any order */
        };
        uint64_t counts[HEALTH_COUNTS]; /* the same as an array */
    };
    uint64_t meets_first, meets; /* [meets_first, meets_first + meets) of mesh_health.met */

    uint8_t closed;     /* each edge has an even number of triangles */
    uint8_t orientable; /* it has two sides, unlike Moebius bands and Klein bottles; determined by edges of two triangles */
    uint8_t oriented;   /* each edge has as many half-edges in each direction; open edges may have one more */

    double volume_m3; /* enclosed, if it is closed and oriented: negative when inside out */
    box    box_ws;
} component_health;

typedef struct mesh_health {
    size_t            count;
    component_health *components; /* [count] by the casters' numbers: solids first */
    component_health  total;      /* its flags: all components have them; its volume: of solids */
    uint32_t *met; /* [total.meets] solids that a solid touches or crosses in more than a common corner, ascending; each pair is
                      listed for both */
    size_t    collapsed_triangles; /* in no component */
    int       gave_up;             /* 1: there are more intersections than were listed */
} mesh_health;

/* Examine all components. Intersections are exact (CGAL); they do not include solids that are wholly inside another.
 * h         [out] zeroed on failure; released with mesh_health_free
 * progress  NULL, or called with the name of the next step
 * Cost: a few seconds at most for intersections, linear time for the rest.
 * Returns VXS_OK or VXS_E_MEMORY.  Deterministic; threads: none. */
vxs_result mesh_health_examine(mesh_health *h, const casters *c, void (*progress)(const char *what), run_context *m);

void mesh_health_free(mesh_health *h);

/* 2 when the component is not a closed surface, oriented outward; else 1 when any count of faults is not 0; else 0.
 * Intersections of solids are no fault. */
int component_faults(const component_health *c);

#ifdef __cplusplus
}
#endif
#endif
