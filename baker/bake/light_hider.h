/* The object that leaves nothing for a light to light: a sky box around a scene under a sun, the bulb around a lamp, the floor over a
 * lamp that hangs too low.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef LIGHT_HIDER_H
#define LIGHT_HIDER_H

#include "baker/bake/scene_objects.h"
#include "baker/light/lit_points.h"

/* Find the object in whose shadow from the light nearly all others lie, 98 of 100 random points on them, and that is not worth a bake
 * itself: a house without windows is lit from outside, and a room that is one object from inside.
 *
 * A sun's hider turns its back to the sun, as what is made to be seen from inside, or is around the others on all sides. A lamp's hider
 * is within 1.5 m of it, turns its back to it, as a solid that it is stuck in, or is not around it.
 *
 * points  [point_count] of the light, of all objects (lit_points.h): what rules most objects out soon
 * d       of the light; its object_of and without are not looked at
 * distance_m  [out] spot, point: from the light to where it is hidden, at most
 * Returns an object of the list, NULL when there is none, no memory, or too little else to tell. */
const scene_object *light_hider_find(object_list *objects, const lit_point *points, size_t point_count, const lit_points_desc *d,
                                     double *distance_m);

#endif
