/* Objects of a scene, as warnings name them: single components, or all that one node places.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SCENE_OBJECTS_H
#define SCENE_OBJECTS_H

#include "baker/base/box.h"
#include "baker/base/threads.h"
#include "baker/casters/casters.h"
#include "baker/light/lit_points.h"

typedef struct scene_object {
    box      around;    /* bounding box, metres */
    size_t   triangles; /* number of the casters' triangles in it */
    uint32_t component; /* its first component */
} scene_object;

typedef struct object_list {
    size_t        count;
    scene_object *items;
    uint32_t     *of; /* [components] the object of each component */

    uint32_t *first;   /* [count + 1] object n has members[first[n]] and on; NULL before objects_find_members */
    uint32_t *members; /* [triangles of the casters] triangles, object by object */
    os_mutex  lock;    /* of these two: several lights are checked at once */
} object_list;

/* Make a list of objects. By component: each component is an object. By node: all components of a node are one object; a component
 * of several nodes belongs to the first.
 * list  [out] released with objects_free, also on failure
 * Returns 1; 0 without memory; objects_by_node also if the scene has no parts. */
int  objects_by_component(object_list *list, const casters *c);
int  objects_by_node(object_list *list, const casters *c, const scene *s);
void objects_free(object_list *list);

/* Name of an object, and the option that excludes it. */
typedef struct object_name {
    char text[160];   /* "node 'Sky'", "material 'Glass'", "the component of 12 triangles at (1, 2, 3)" */
    char option[128]; /* "--exclude node:Sky"; "": no pattern selects it without much else */
} object_name;

/* Find a name: the first node, mesh or material that has about as many triangles as the object.
 * s  NULL, or without parts: no names are known */
void object_name_find(object_name *name, const scene_object *object, const casters *c, const scene *s);

/* Finds an object that hides a light from all others: a sky box around a scene with a sun, the bulb around a punctual light, the
 * floor above a punctual light that hangs too low. */

/* Find the object in whose shadow nearly all other objects lie: 98 of 100 random points on them. An object that is worth a bake by
 * itself does not count: the outside of a house without windows is lit, and so is the inside of a room that is one object.
 *
 * A sun's hider has its back faces toward the sun, because it is made to be seen from inside, or surrounds the others on all sides.
 * A punctual light's hider is within 1.5 m of the light. It has its back faces toward the light, as a solid that contains the light
 * has, or does not surround it.
 *
 * points  [point_count] on all objects (lit_points.h): they rule out most objects fast
 * d       of the light; its object_of and without are ignored
 * distance_metres  [out] spot, point: greatest distance from the light to the hiding surface
 * Returns an object of the list; NULL: none found, no memory, or too few other points to decide. */
const scene_object *light_hider_find(object_list *objects, const lit_point *points, size_t point_count, const lit_points_desc *d,
                                     double *distance_metres);

#endif
