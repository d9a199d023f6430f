/* Casters: the welded triangles that cast shadow, classified. Solids come first, then sheets.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CASTERS_H
#define CASTERS_H

#include "baker/scene/scene.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Solid, or the reason why a connected component is a sheet. The order is that of the tests. */
typedef enum component_kind {
    COMPONENT_SOLID,
    COMPONENT_SHEET_FORCED,       /* --closed off */
    COMPONENT_SHEET_ALPHA_MASK,   /* has holes from an alpha mask, which geometry does not show */
    COMPONENT_SHEET_OPEN,         /* has an edge whose triangles do not cancel: open, or inconsistently oriented */
    COMPONENT_SHEET_DOUBLE_SIDED, /* has a double-sided material */
    COMPONENT_SHEET_INWARD,       /* encloses no positive volume: inside out, or flat */
    COMPONENT_SHEET_OCCUPIED,     /* contains a light, a camera or another whole component */
    COMPONENT_KINDS
} component_kind;

typedef enum closed_mode { CLOSED_AUTO, CLOSED_ON, CLOSED_OFF } closed_mode;
#define CLOSED_CHOICES "auto|on|off" /* words in the order of closed_mode */

/* Counts of solids that meet, and of how this was determined. */
typedef struct meeting_counts {
    size_t solids, meet; /* all solids; solids that meet another solid or themselves */
    size_t apart_by_box; /* of those that do not meet: no other solid's box is near */
    size_t assumed;      /* of those that meet: unknown, because the search gave up */
} meeting_counts;

/* Counts of welding and splitting borders of sheets (mesh_split.h). */
typedef struct border_counts {
    size_t edges;  /* open edges; 0 when borders were not split */
    size_t split;  /* open edges split at vertices that lie on them */
    size_t left;   /* open edges not searched, because the search gave up */
    size_t added;  /* number of triangles added by splitting */
    size_t joined; /* vertices merged into another vertex */
} border_counts;

enum { CASTERS_RUN = 64 };

typedef struct casters {
    size_t  vertex_count;
    double *positions_ws; /* [3 * vertex_count] welded: vertices have different positions */

    size_t    triangle_count;
    size_t    solid_triangle_count; /* triangles [0, solid_triangle_count) belong to solids, the others to sheets */
    size_t    holed_first;          /* triangles [holed_first, triangle_count) have holes; all are sheets */
    uint32_t *indices;              /* [3 * triangle_count] in the scene's order within solids, within sheets, and within each
                                       mask */

    /* Masks have the same numbers as in the scene. A mask may have no triangles if all of them collapsed. Without masks
     * alpha_mask_count is 0, holed_first is triangle_count, and alpha_mask_first has one entry. */
    size_t      alpha_mask_count;
    alpha_mask *alpha_masks;   /* [alpha_mask_count] */
    size_t *alpha_mask_first;  /* [alpha_mask_count + 1] mask i applies to triangles [alpha_mask_first[i], alpha_mask_first[i + 1]);
                                  [0] is holed_first */
    float  *hole_uvs;          /* [6 * (triangle_count - holed_first)] u, v of each corner, as holed_triangle.uv */
    const alpha_image *images; /* the scene's; borrowed, must outlive the casters */

    uint8_t *double_sided; /* [triangle_count] 1: double-sided material; NULL: none */

    /* [3 * triangle_count] half-edges, 3 t + i from corner i of triangle t. Where an edge has just two, in opposite directions, each
     * has the other one here; else UINT32_MAX. NULL: not known */
    uint32_t *edge_mates;

    /* Bounding boxes of each CASTERS_RUN consecutive triangles; the last run may be shorter. NULL before casters_find_runs: maps of
     * spot and point lights then look at each triangle */
    struct box *runs;

    uint32_t *component_of; /* [triangle_count] component numbers: solids first, each kind in the order of first triangles */
    uint8_t  *kind_of;      /* [all components] component_kind */

    part_span  *parts_of; /* [all components] the scene parts of each component */
    struct box *boxes;    /* [all components] bounding box of its triangles, metres (baker/base/box.h) */

    uint8_t       *solid_meets; /* [solid_triangle_count] 1: its solid meets another solid or itself; NULL before
                                   casters_find_meeting */
    meeting_counts meeting;

    size_t        component_count[COMPONENT_KINDS];   /* number of components of each kind */
    size_t        triangles_of_kind[COMPONENT_KINDS]; /* before splitting */
    border_counts borders;
    size_t        scene_vertex_count; /* before welding */
    size_t        collapsed_count;    /* triangles dropped because two corners were welded */
} casters;

/* Weld vertices at bit-equal world positions (-0 equals +0), drop triangles that collapse, split the rest into components connected
 * by edges, and classify these as solids or sheets (docs/overview.md, "Solids and sheets"; [CPVS16] 3.3 needs closed objects).
 * CLOSED_ON   every closed component without alpha mask is a solid, whatever its material or contents; inside-out ones are turned.
 * CLOSED_OFF  every component is a sheet.
 * A sheet is always correct, only larger in the asset. So doubtful components become sheets.
 * c  [out] zeroed on failure; released with casters_free.
 * Returns VXS_OK, VXS_E_NO_CASTER (no triangle left), VXS_E_MEMORY, VXS_E_SCENE. The result does not depend on the number of
 * threads. */
vxs_result casters_from_scene(casters *c, const scene *s, closed_mode closed, uint32_t threads, run_context *m);

/* Write the error message for a scene without casters: it has no triangles, or all were left out, with the reasons. Returns
 * VXS_E_NO_CASTER. */
vxs_result casters_none(const scene *s, run_context *m);

/* casters_from_scene for maps: also gives borders of sheets that meet the same vertices, so that no light leaks between them
 * (mesh_split.h). Solids are determined before this step.
 * Time: as casters_from_scene if there are no open edges; else some microseconds more for each open edge. */
vxs_result casters_for_maps(casters *c, const scene *s, closed_mode closed, uint32_t threads, run_context *m);

/* Fill solid_meets and meeting. A solid meets another one when their surfaces have a common point, or one is inside the other. It
 * meets itself when two parts of its surface have a common point that is not just a shared edge or corner.
 *
 * Light leaves the union of solids that meet nothing at the nearest back face, so these need no peeling. A solid that meets must be
 * peeled to find the best exit depth; its nearest back face would also be correct, but is earlier. A search that takes too long (a
 * few seconds, for a heap of solids) gives up, and all solids count as meeting: this costs time, but the result stays correct.
 * Time: about 0.1 s for 100 000 triangles, shared by the threads.
 * Returns VXS_OK or VXS_E_MEMORY (then solid_meets is NULL). The result does not depend on the number of threads, unless the search
 * gives up. */
vxs_result casters_find_meeting(casters *c, uint32_t threads, run_context *m);

/* How many runs there are, whether they are filled or not; and the triangle behind the last one of a run. */
static inline size_t casters_run_count(const casters *c)
{
    return (c->triangle_count + CASTERS_RUN - 1) / CASTERS_RUN;
}

static inline size_t casters_run_end(const casters *c, size_t run)
{
    const size_t end = (run + 1) * CASTERS_RUN;
    return end < c->triangle_count ? end : c->triangle_count;
}

/* Fill runs. Returns VXS_OK or VXS_E_MEMORY. */
vxs_result casters_find_runs(casters *c, run_context *m);

void casters_free(casters *c);

/* Number of components of all kinds. */
static inline size_t casters_component_count(const casters *c)
{
    size_t count = 0;
    for (int kind = 0; kind < COMPONENT_KINDS; kind++) count += c->component_count[kind];
    return count;
}

/* Bounding box of all triangles. */
struct box casters_bounds(const casters *c);

/* Number of triangles before splitting. */
static inline size_t casters_whole_count(const casters *c)
{
    return c->triangle_count - c->borders.added;
}

/* "solid", "open", ... for reports. */
const char *component_kind_name(component_kind kind);

#ifdef __cplusplus
}
#endif
#endif
