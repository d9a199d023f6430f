/* Finds an object that hides a light from all others: a sky box around a scene with a sun, the bulb around a lamp, the floor above
 * a lamp that hangs too low.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef LIGHT_HIDER_H
#define LIGHT_HIDER_H

#include "baker/bake/scene_objects.h"
#include "baker/light/lit_points.h"

/* Find the object in whose shadow nearly all other objects lie: 98 of 100 random points on them. An object that is worth a bake by
 * itself does not count: the outside of a house without windows is lit, and so is the inside of a room that is one object.
 *
 * A sun's hider has its back faces toward the sun, because it is made to be seen from inside, or surrounds the others on all sides.
 * A lamp's hider is within 1.5 m of the lamp. It has its back faces toward the lamp, as a solid that contains the lamp has, or
 * does not surround it.
 *
 * points  [point_count] on all objects (lit_points.h): they rule out most objects fast
 * d       of the light; its object_of and without are ignored
 * distance_m  [out] spot, point: greatest distance from the light to the hiding surface
 * Returns an object of the list; NULL: none found, no memory, or too few other points to decide. */
const scene_object *light_hider_find(object_list *objects, const lit_point *points, size_t point_count, const lit_points_desc *d,
                                     double *distance_m);

#endif
