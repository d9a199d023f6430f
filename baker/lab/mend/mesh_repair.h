/* Mend components, so that more of them are solids: after a scene is loaded and before its casters are classified.
 *
 * Only components that are not closed or not consistently oriented are changed. All others stay as they are, even if oriented
 * inward: a room seen from inside has that orientation on purpose. Components with alpha-tested triangles are
 * not changed.
 *
 *   remove   repeated triangles, and those without area
 *   orient   triangles whose winding differs from that of most of their neighbours
 *   fill     small holes, if this closes the component; else all its holes stay, since light may be meant to pass through them
 *
 * casters_from_scene decides whether the result is a solid, as for any other component.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef MESH_REPAIR_H
#define MESH_REPAIR_H

#include <stddef.h>
#include <stdint.h>

#include "baker/scene/scene.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct repair_options {
    uint32_t hole_edges_max; /* holes with more edges are not filled; 3 to REPAIR_HOLE_EDGES_MAX, 0: none */
    double
        hole_diameter_metres; /* [0, inf) metres: the largest diagonal of a filled hole's box. A crack (all points on one line) may
                                 have any length */
} repair_options;

#define REPAIR_HOLE_EDGES_MAX 1000u
#define REPAIR_DEFAULTS                                                                                                            \
    {                                                                                                                              \
        .hole_edges_max = 64, .hole_diameter_metres = 0.1                                                                          \
    }

/* Holes longer than this share of their component's diagonal are not filled: they are openings, as of a cup, or the rim of a
 * sheet. */
#define REPAIR_HOLE_SHARE 0.25

/* Triangles with mixed winding get the winding that at least this share of their area has; if neither has it, the outward one. */
#define REPAIR_MAJORITY 0.75

enum { REPAIR_COUNTS = 6 };

typedef struct repaired_component {
    uint32_t  triangle, triangles; /* its first triangle in the original scene, and their number */
    part_span parts;
    uint8_t   closed_before; /* closed and consistently oriented */
    uint8_t   closed_after;  /* 1: all parts of the component are closed now */
    union {
        struct {
            uint32_t removed_repeated, removed_zero_area;
            uint32_t turned_triangles;
            uint32_t filled_holes, added_triangles;
            uint32_t left_holes; /* too large, or the component stays open for other reasons */
        };
        uint32_t counts[REPAIR_COUNTS]; /* the same as an array */
    };
} repaired_component;

typedef struct repair_report {
    size_t              count;
    repaired_component *components; /* [count] components that were changed or still have holes, in the scene's order */
    repaired_component  total;      /* sums over all components; its flags are unused */
    size_t              component_count, closed_before, closed_after; /* over all components of the original scene */
} repair_report;

/* Mend a scene in place. Triangles keep their order; new ones are appended; holed_triangles and parts are updated; parts keep
 * their numbers.
 * out  [out] zeroed on failure; released with repair_report_free
 * Returns VXS_OK, VXS_E_MEMORY, VXS_E_SCENE (as mesh_weld_scene). After a failure the scene can only be freed. A scene without
 * triangles is no error here.  Deterministic; threads: none. Cost: linear, except for filling holes. */
vxs_result scene_repair(scene *s, const repair_options *o, repair_report *out, run_context *m);

void repair_report_free(repair_report *r);

/* mesh_hole.cc: Fill a closed polygon with triangles: near its best-fit plane, or with minimal area and angles.
 * points     [3 * count] in order; 3 or more, all different
 * triangles  [out] [3 * (count - 2)] point numbers; wound in the polygon's direction
 * Returns 1, or 0 when there is no such surface (CGAL finds none, or out of memory).  Cost: up to cubic, so limit count. */
int mesh_fill_hole(const double *points, size_t count, uint32_t *triangles);

/* 1 when all points are exactly collinear: triangles between them have no area. */
int mesh_is_crack(const double *points, size_t count);

#ifdef __cplusplus
}
#endif

#endif
