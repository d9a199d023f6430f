/* Mending components, so that more of them are solids: between loading a scene and sorting its casters.
 *
 * What is mended is what is not closed and consistently oriented; a component that is, is left as it is, inward ones too: a room
 * whose walls are seen from inside has that orientation on purpose. Components with alpha-tested triangles are left alone.
 *
 *   remove   repeated triangles, and those without area
 *   orient   triangles whose winding differs from that of most of their neighbours
 *   fill     small holes, where that closes the component: what stays open anyway keeps its holes, light may be meant to pass
 *
 * Whether the result is a solid is judged by casters_from_scene, as for any other component.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef MESH_REPAIR_H
#define MESH_REPAIR_H

#include "baker/scene/scene.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct repair_options {
    uint32_t hole_edges_max; /* holes with more edges are not filled; 3 to REPAIR_HOLE_EDGES_MAX, 0: none */
    double
        hole_diameter_m; /* [0, inf) metres: nor holes whose box has a longer diagonal. A crack, all on one line, may have any
                            length */
} repair_options;

#define REPAIR_HOLE_EDGES_MAX 1000u
#define REPAIR_DEFAULTS                                                                                                            \
    {                                                                                                                              \
        .hole_edges_max = 64, .hole_diameter_m = 0.1                                                                               \
    }

/* No hole is filled that is longer than this part of its component's diagonal: it is not a hole but the opening of a cup, or the
 * rim of a sheet. */
#define REPAIR_HOLE_SHARE 0.25

/* Triangles with mixed winding are given the winding that at least this share of their area has; where neither has, the outward
 * one. */
#define REPAIR_MAJORITY 0.75

enum { REPAIR_COUNTS = 6 };

typedef struct repaired_component {
    uint32_t  triangle, triangles; /* its first in the scene as it was, and how many it had */
    part_span parts;
    uint8_t   closed_before; /* closed and consistently oriented */
    uint8_t   closed_after;  /* what has become of all of it is */
    union {
        struct {
            uint32_t removed_repeated, removed_zero_area;
            uint32_t turned_triangles;
            uint32_t filled_holes, added_triangles;
            uint32_t left_holes; /* too large, or the component stays open for other reasons */
        };
        uint32_t counts[REPAIR_COUNTS]; /* the same, one after the other */
    };
} repaired_component;

typedef struct repair_report {
    size_t              count;
    repaired_component *components; /* [count] those to which something was done or that still have holes, in the scene's order */
    repaired_component  total;      /* of all: its flags count nothing */
    size_t              component_count, closed_before, closed_after; /* of all components of the scene as it was */
} repair_report;

/* Mend a scene in place. Triangles keep their order; new ones are added at its end, holed_triangles and parts are
 * kept right; a part keeps its number.
 * out  [out] zeroed on failure; released with repair_report_free
 * Returns VXS_OK, VXS_E_MEMORY, VXS_E_SCENE (as mesh_weld_scene). After a failure the scene can only be freed. A scene without
 * triangles is not
 * an error here.  Deterministic; threads: none. Linear but for the holes that are filled. */
vxs_result scene_repair(scene *s, const repair_options *o, repair_report *out, message *m);

void repair_report_free(repair_report *r);

#ifdef __cplusplus
}
#endif
#endif
