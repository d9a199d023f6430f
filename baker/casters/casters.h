/* The triangles that cast shadows, welded and told apart: solids first, then sheets.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CASTERS_H
#define CASTERS_H

#include "baker/scene/scene.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Why a connected component is a sheet, or that it is a solid. The order is the order of the tests. */
typedef enum component_kind {
    COMPONENT_SOLID,
    COMPONENT_SHEET_FORCED,       /* --closed off */
    COMPONENT_SHEET_ALPHA_MASK,   /* has holes that geometry does not show */
    COMPONENT_SHEET_OPEN,         /* an edge whose triangles do not cancel: open or inconsistently oriented */
    COMPONENT_SHEET_DOUBLE_SIDED, /* a material whose both sides are seen */
    COMPONENT_SHEET_INWARD,       /* encloses no positive volume: turned inside out, or flat */
    COMPONENT_SHEET_OCCUPIED,     /* a light, a camera or another whole component is inside */
    COMPONENT_KINDS
} component_kind;

typedef enum closed_mode { CLOSED_AUTO, CLOSED_ON, CLOSED_OFF } closed_mode;
#define CLOSED_CHOICES "auto|on|off" /* their words, in that order */

/* How many solids meet, and how that was found. */
typedef struct meeting_counts {
    size_t solids, meet; /* all; those that meet another or themselves */
    size_t apart_by_box; /* of those that meet nothing: no other solid's box is near */
    size_t assumed;      /* of those that meet: not known, the search was given up */
} meeting_counts;

/* What became of borders of sheets that meet (mesh_split.h). */
typedef struct border_counts {
    size_t edges;  /* that are open; none where nobody asked */
    size_t split;  /* of them, split at vertices that lie on them */
    size_t left;   /* of them, not looked at */
    size_t added;  /* triangles more than before */
    size_t joined; /* vertices that took another one's place */
} border_counts;

typedef struct casters {
    size_t  vertex_count;
    double *positions_ws; /* [3 * vertex_count] welded: no two vertices have the same position */

    size_t    triangle_count;
    size_t    solid_triangle_count; /* triangles [0, solid_triangle_count) belong to solids, the rest to sheets */
    size_t    holed_first;          /* triangles [holed_first, triangle_count) have holes; they are sheets */
    uint32_t *indices;              /* [3 * triangle_count], in the scene's order within solids, sheets, and each mask */

    /* The scene's masks keep their numbers; one whose triangles all collapsed has none. Without masks alpha_mask_count is 0, holed_first is
     * triangle_count, and alpha_mask_first has its one entry. */
    size_t      alpha_mask_count;
    alpha_mask *alpha_masks;   /* [alpha_mask_count] */
    size_t *alpha_mask_first;  /* [alpha_mask_count + 1] mask i cuts the triangles from its entry to the next; [0] is holed_first */
    float  *hole_uvs;          /* [6 * (triangle_count - holed_first)] u, v of each corner, as holed_triangle.uv */
    const alpha_image *images; /* the scene's: borrowed, it must outlive the casters */

    uint8_t *double_sided; /* [triangle_count] 1: both sides of its material are seen; NULL: of none */

    uint32_t *component_of; /* [triangle_count] components are numbered, solids first, each in the order of its first triangle */
    uint8_t  *kind_of;      /* [all components] component_kind */

    part_span  *parts_of; /* [all components] the parts of the scene that it is made of */
    struct box *boxes;    /* [all components] around its triangles, metres (baker/base/box.h) */

    uint8_t       *solid_meets; /* [solid_triangle_count] 1: its solid meets another or itself; NULL before casters_find_meeting */
    meeting_counts meeting;

    size_t        component_count[COMPONENT_KINDS];   /* components of each kind */
    size_t        triangles_of_kind[COMPONENT_KINDS]; /* before any were split */
    border_counts borders;
    size_t        scene_vertex_count; /* before welding */
    size_t        collapsed_count;    /* triangles dropped because two corners welded together */
} casters;

/* Weld vertices at bit-equal world positions (-0 equals +0), drop triangles that collapse, split into components connected by
 * edges, and decide which are solids (docs/overview.md, "Solids and sheets"; design: [CPVS16] 3.3 needs closed objects).
 * CLOSED_ON   every closed component is a solid, whatever its material or contents; inward ones are turned outward.
 * CLOSED_OFF  everything is a sheet.
 * A sheet is always right, only larger, so every doubt makes a sheet.
 * c  [out] zeroed on failure; released with casters_free.
 * Returns VXS_OK, VXS_E_NO_CASTER (no triangle left), VXS_E_MEMORY, VXS_E_SCENE.  The same at any thread count. */
vxs_result casters_from_scene(casters *c, const scene *s, closed_mode closed, uint32_t threads, message *m);

/* The error of a scene in which nothing casts a shadow: it has no triangles, or none is left, and why. Returns VXS_E_NO_CASTER. */
vxs_result casters_none(const scene *s, message *m);

/* The same for maps: where borders of sheets meet, they have the same vertices, so that no light falls between them (mesh_split.h). Which
 * components are solids is told before.
 * Time: as casters_from_scene where nothing is open; else some microseconds more for each open edge. */
vxs_result casters_for_maps(casters *c, const scene *s, closed_mode closed, uint32_t threads, message *m);

/* Fill solid_meets and meeting. A solid meets another when their surfaces have a point in common, or one is inside the other; it
 * meets itself when its surface has a point in common with another part of it that is more than an edge or a corner of both.
 *
 * Of solids that meet nothing the nearest back face is where light leaves their union: no peeling is needed to find it. One that meets
 * must be peeled for the best exit depth; its nearest back face would be right as well, only earlier. So a search that takes too long
 * (a few seconds, for solids in one heap) is given up, and all solids count as meeting: doubt costs time, never truth.
 * About 0.1 s for 100 000 triangles, shared by the threads.
 * Returns VXS_OK or VXS_E_MEMORY (then solid_meets is NULL).  The same at any thread count, unless it is given up. */
vxs_result casters_find_meeting(casters *c, uint32_t threads, message *m);

void casters_free(casters *c);

/* How many triangles there were before any were split. */
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
