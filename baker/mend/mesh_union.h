/* Solids that meet, replaced by their union, so that the nearest back face is the exit depth.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef MESH_UNION_H
#define MESH_UNION_H

#include "baker/casters/casters.h"
#include "baker/mend/mesh_unite.h"

#ifdef __cplusplus
extern "C" {
#endif

#define UNION_TRIANGLES_MAX 20000u /* a cluster of more is left as it is */

/* One cluster of solids that meet. */
typedef struct union_cluster {
    uint32_t solid;                /* its lowest number before */
    uint32_t solids, triangles;    /* before */
    uint32_t left[UNITE_OUTCOMES]; /* solids that are as they were, by why; left[UNITED]: solids that were united */
    uint32_t results;              /* solids that took the place of those that were united */
} union_cluster;

typedef struct union_report {
    size_t         count;
    union_cluster *clusters; /* [count] of two solids or more, by their lowest number */
    union_cluster  total;
    size_t         solids_after, triangles_after; /* all solids of the casters; their triangles */
    int            gave_up;                       /* 1: not all solids that meet were found */
} union_report;

/* Replace solids that meet by their boolean union. It is exact, and each new vertex is rounded once, so that no crack opens, though
 * faces may come to cross each other by the width of a rounding: casters_find_meeting then says that the solid meets itself. What fails
 * stays as it was, and is counted with its reason. A solid that came of a union has one number, even if its surface is in several parts.
 * Solids that are left come first, in their order, then the new ones, then sheets as before. solid_meets is taken away: it is to be found anew.
 * out  [out] zeroed on failure; released with union_report_free
 * Returns VXS_OK or VXS_E_MEMORY: then c is as it was.  Deterministic; threads: none. */
vxs_result casters_unite(casters *c, union_report *out, message *m);

void union_report_free(union_report *r);

/* "united", "not manifold", ... */
const char *unite_outcome_name(unite_outcome outcome);

#ifdef __cplusplus
}
#endif
#endif
