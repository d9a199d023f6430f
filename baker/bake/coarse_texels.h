/* Texels, or depths, of a map that are coarser than they should be, as the checks of a plan find them.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef COARSE_TEXELS_H
#define COARSE_TEXELS_H

#include "baker/bake/far_objects.h"
#include "baker/bake/plan.h"

/* What the checks of a plan share. */
typedef struct check_scene {
    bake_plan     *plan;
    const casters *c;
    const scene   *s;                 /* NULL: none is known */
    object_list    components, nodes; /* without nodes where the scene has none */
    message       *m;
} check_scene;

static inline int is_sun(const plan_light *l)
{
    return l->shape.kind == LIGHT_DIRECTIONAL;
}

/* A map of fewer texels was asked for to see something soon: that it is coarse is known. */
enum { PREVIEW_PX = 256 };

/* Warn of objects far from the rest where they make the texels of a sun's map coarse, or its depths; of the sun whose map suffers most.
 * of  the list that far is of
 * Returns 1 when something was said. */
int warn_about_far_objects(const check_scene *k, const far_objects *far, const object_list *of);

/* Whether most of what a light reaches is narrower than two texels: of components, of the quarter of them that is nearest to a lamp, and of
 * nodes, where there are several, so that leaves of trees are not counted one by one.
 * lost, of  [out] components that are; all that count */
int texels_lose_most(const check_scene *k, const plan_light *l, size_t *lost, size_t *of);

void warn_about_lost(const check_scene *k, const plan_light *l, size_t lost, size_t of);

/* The resolution that is as good as a light's own, where that makes texels of less than half a millimetre, with 4096 of them or more across most
 * components, in a map of 16384 a side or more; 0: its own is no finer than that. */
uint32_t coarser_side(const check_scene *k, const plan_light *l);

#endif
