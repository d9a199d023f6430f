/* Procedural test scenes: the same options give the same scene on every machine.
 *
 * This code calls no libm function except sqrt, and computes with plain +, -, *, / in double, with one rounding to float at the
 * end. So no rounding depends on a library or a compiler.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef GENERATE_H
#define GENERATE_H

#include <stdint.h>

#include "baker/scene/gltf/glb_write.h"

#ifdef __cplusplus
extern "C" {
#endif

/* limits of the options, checked by the caller */
#define GENERATE_TRIANGLES_MIN 1000
#define GENERATE_TRIANGLES_MAX 5000000
#define CITY_BLOCKS_MAX        64
#define CITY_SPOTS_MAX         10000
#define LANDSCAPE_SIZE_MIN     1.0
#define LANDSCAPE_SIZE_MAX     100000.0
#define LANDSCAPE_HEIGHT_MAX   10000.0

typedef struct city_options {
    uint32_t blocks;    /* blocks along a side, [1, CITY_BLOCKS_MAX] */
    uint32_t triangles; /* [GENERATE_TRIANGLES_MIN, GENERATE_TRIANGLES_MAX], met within a dozen */
    uint32_t seed;
    double   sun[3]; /* direction of the light; not zero */
    uint32_t spots;  /* [0, CITY_SPOTS_MAX] spot lights; the boxes do not depend on it */
} city_options;

/* A city of closed boxes, each with its own 12 triangles and 8 vertices: ground, kerbs, buildings, street lamps, roof and
 * wall clutter. Boxes touch or intersect, as solids do in real levels; each touches an earlier one or the ground, and none is
 * wholly inside another. One mesh for the ground, then one for each block that has a box.
 * Spots are distributed evenly over the blocks: under the arms of street lamps, at most 12 a block, and the rest alternately on
 * walls and over streets. None is inside a box. Cones of 20 to 60 degrees from the axis to the edge, 15 to 40 m of range.
 * s  [out] zeroed on failure; released with glb_scene_free.
 * Returns VXS_OK, VXS_E_MEMORY, VXS_E_ARGUMENT (too many triangles for so few blocks). */
vxs_result generate_city(glb_scene *s, const city_options *o, run_context *m);

typedef struct landscape_options {
    uint32_t triangles; /* [GENERATE_TRIANGLES_MIN, GENERATE_TRIANGLES_MAX], met within 2% */
    uint32_t seed;
    double   size_metres;   /* of a side; [LANDSCAPE_SIZE_MIN, LANDSCAPE_SIZE_MAX] */
    double   height_metres; /* from lowest to highest point; [0, LANDSCAPE_HEIGHT_MAX] */
    double   sun[3];        /* direction of the light; not zero */
} landscape_options;

/* Fractal terrain as one closed mesh: a heightfield, skirts, and a flat bottom.
 * s  [out] zeroed on failure; released with glb_scene_free.  Returns VXS_OK, VXS_E_MEMORY. */
vxs_result generate_landscape(glb_scene *s, const landscape_options *o, run_context *m);

typedef struct room_options {
    uint32_t triangles; /* [GENERATE_TRIANGLES_MIN, GENERATE_TRIANGLES_MAX], met within 2% */
    uint32_t seed;
    int      screen; /* 1: add an emissive screen above the cabinet */
} room_options;

/* A furnished room, 8 x 3 x 6 m. Walls, floor and ceiling are one open sheet that faces inward, with an opening for a door.
 * Furniture, hanging objects and the objects beyond the door are closed solids, except the lampshade, an open sheet. A point
 * light "lamp" in the shade, a spot "corner" under the ceiling; no sun. Neither light is inside a solid.
 * s  [out] zeroed on failure; released with glb_scene_free.  Returns VXS_OK, VXS_E_MEMORY. */
vxs_result generate_room(glb_scene *s, const room_options *o, run_context *m);

typedef struct forest_options {
    uint32_t triangles; /* [GENERATE_TRIANGLES_MIN, GENERATE_TRIANGLES_MAX], met within 2% */
    uint32_t seed;
    double   size_metres; /* of a side; [FOREST_SIZE_MIN, LANDSCAPE_SIZE_MAX] */
    double   sun[3];      /* direction of the light; not zero */
} forest_options;

#define FOREST_SIZE_MIN 10.0

/* Trees on hilly ground. The ground, trunks and branches are closed solids; each branch intersects its trunk, and each trunk the
 * ground. Leaves are cards, two triangles each, of a double-sided MASK material whose image is about half transparent.
 * s  [out] zeroed on failure; released with glb_scene_free.  Returns VXS_OK, VXS_E_MEMORY. */
vxs_result generate_forest(glb_scene *s, const forest_options *o, run_context *m);

typedef struct smoke_options {
    uint32_t capsules; /* [SMOKE_MIN, SMOKE_MAX] */
    uint32_t seed;
} smoke_options;

#define SMOKE_MIN 8
#define SMOKE_MAX 1000000

/* A yard between houses, with a low sun "sun" through three columns of smoke from barrels, and a spot "street lamp" in one of
 * them. The smoke has `capsules` points, of three materials; its density does not depend on their number. All other objects are
 * closed solids.
 * s  [out] zeroed on failure; released with glb_scene_free.  Returns VXS_OK, VXS_E_MEMORY. */
vxs_result generate_smoke(glb_scene *s, const smoke_options *o, run_context *m);

/* A head with hair on a table, and a thread of smoke beside it, between two spots, "lamp" and "behind". Three in four capsules
 * are parts of strands, eight for each strand; the others are puffs of smoke. All other objects are closed solids.
 * s  [out] as above.  Returns VXS_OK, VXS_E_MEMORY. */
vxs_result generate_hair(glb_scene *s, const smoke_options *o, run_context *m);

/* Edge cases for a baker, some of them broken on purpose (scenes/README.md, "Stress").
 * name  one of stress_name
 * s     [out] zeroed on failure; released with glb_scene_free.  Returns VXS_OK, VXS_E_MEMORY, VXS_E_ARGUMENT (no such case). */
vxs_result generate_stress(glb_scene *s, const char *name, run_context *m);

/* Returns VXS_OK, or VXS_E_ARGUMENT with the names of all cases in the message. */
vxs_result stress_check(const char *name, run_context *m);

/* The name of case i, and its purpose; NULL after the last. */
const char *stress_name(size_t i);
const char *stress_purpose(size_t i);

#ifdef __cplusplus
}
#endif
#endif
