/* The boolean union of some solids that meet.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef MESH_UNITE_H
#define MESH_UNITE_H

#include <stddef.h>
#include <stdint.h>

#include "baker/casters/mesh_intersect.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Why a solid was not united with others, or that it was. */
typedef enum unite_outcome {
    UNITED,
    UNITE_NOT_MANIFOLD, /* an edge of more than two triangles, or a vertex where parts of it touch */
    UNITE_CROSSES_ITSELF,
    UNITE_NOT_OUTWARD, /* does not bound a volume: inward in part */
    UNITE_FAILED,      /* the union with the others is not a manifold, or CGAL says no */
    UNITE_TOO_LARGE,
    UNITE_OUTCOMES
} unite_outcome;

typedef struct unite_part {
    const uint32_t *triangles; /* [count] of the soup: one closed surface */
    size_t          count;
    unite_outcome   outcome; /* [out] */
    uint32_t        result;  /* [out] which one it is in now, where it was united; parts of one result are one solid */
} unite_part;

typedef struct unite_result {
    size_t    result_count;
    size_t    vertex_count, triangle_count;
    double   *positions_ws; /* [3 * vertex_count] exact, then rounded once; different ones may have become equal */
    uint32_t *indices;      /* [3 * triangle_count] */
    uint32_t *result_of;    /* [triangle_count] ascending */
} unite_result;

/* Unite what can be united. Neighbours first, then pairs of what came out, and so on; what fails stays apart.
 * Exact (CGAL, corefinement). Every result is closed and outward, and as large as its largest part at least and all of them at most.
 * out  [out] zeroed on failure; released with unite_result_free. Results that hold one part alone are left out: that part is not UNITED.
 * Returns VXS_OK or VXS_E_MEMORY; never throws.  Deterministic; threads: none. */
vxs_result mesh_unite(const mesh_soup *s, unite_part *parts, size_t count, unite_result *out);

void unite_result_free(unite_result *r);

#ifdef __cplusplus
}
#endif
#endif
