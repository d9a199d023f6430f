/* Checks of a plan: texels or depths of a map that are coarser than they should be.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef COARSE_TEXELS_H
#define COARSE_TEXELS_H

#include "baker/bake/plan.h"
#include "baker/bake/scene_objects.h"

/* Objects that make a sun's map much larger than the rest of the scene needs: a forgotten crate far away, the sea
 * around an island. */

enum { FAR_OBJECTS_MAX = 8 };

typedef struct far_objects {
    size_t   count, triangles;       /* 0: none found */
    uint32_t items[FAR_OBJECTS_MAX]; /* indices into the list, farthest first */
    box      rest;                   /* bounding box of all other objects, metres */
} far_objects;

/* Find objects without which the scene is at most a tenth as large: at most FAR_OBJECTS_MAX, with at most a quarter of the
 * triangles.
 * Returns 1 if some were found. */
int far_objects_find(far_objects *out, const object_list *objects);

/* State shared by the checks of a plan. */
typedef struct check_scene {
    bake_plan     *plan;
    const casters *c;
    const scene   *s;                 /* NULL: not known */
    object_list    components, nodes; /* nodes is empty if the scene has none */
    run_context   *m;
} check_scene;

static inline int is_sun(const plan_light *l)
{
    return l->shape.kind == LIGHT_DIRECTIONAL;
}

/* A map with fewer texels is a preview: the user knows that it is coarse. */
enum { PREVIEW_PX = 256 };

/* Warn of far objects that make the texels or depths of a sun's map coarse, for the sun whose map is affected most.
 * of  the list that `far` refers to
 * Returns 1 if it has warned. */
int warn_about_far_objects(const check_scene *k, const far_objects *far, const object_list *of);

/* Whether most of what a light reaches is narrower than two texels. Counts components; for a punctual light, the nearest quarter of
 * them; and nodes, if there are several, so that leaves of trees do not count one by one.
 * lost, of  [out] number of narrow components; of all that count */
int texels_lose_most(const check_scene *k, const plan_light *l, size_t *lost, size_t *of);

void warn_about_lost(const check_scene *k, const plan_light *l, size_t lost, size_t of);

/* A resolution that is as good as the light's own one: used if its texels are below half a millimetre, with at least 4096 of them
 * across most components, in a map of at least 16384 a side. 0: the own one is not that fine. */
uint32_t coarser_side(const check_scene *k, const plan_light *l);

#endif
