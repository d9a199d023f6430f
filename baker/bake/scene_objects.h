/* What a scene is made of, as warnings name it: components, or what one node places.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SCENE_OBJECTS_H
#define SCENE_OBJECTS_H

#include "baker/base/box.h"
#include "baker/casters/casters.h"

typedef struct scene_object {
    box      around;    /* metres */
    size_t   triangles; /* of the casters */
    uint32_t component; /* its first */
} scene_object;

typedef struct object_list {
    size_t        count;
    scene_object *items;
    uint32_t     *of; /* [components] the object that a component belongs to */

    uint32_t
        *first; /* [count + 1] an object's triangles are members from its entry to the next; NULL before objects_find_members */
    uint32_t *members; /* [triangles of the casters] */
} object_list;

/* Each component is an object; or all components of a node are one, where a component of several nodes counts to its first.
 * list  [out] released with objects_free, also when this fails
 * Returns 1; 0 without memory, and by nodes where the scene has no parts. */
int  objects_by_component(object_list *list, const casters *c);
int  objects_by_node(object_list *list, const casters *c, const scene *s);
void objects_free(object_list *list);

/* Which triangles each object has; nothing is done the second time. Returns 0 without memory. */
int objects_find_members(object_list *list, const casters *c);

/* What to call an object, and the option that leaves it out. */
typedef struct object_name {
    char text[160];   /* "node 'Sky'", "material 'Glass'", "the component of 12 triangles at (1, 2, 3)" */
    char option[128]; /* "--exclude node:Sky"; "": no pattern names it without much else */
} object_name;

/* A node, a mesh or a material names an object when it has about as many triangles as the object; the first of them that does.
 * s  NULL, or without parts: nothing has a name */
void object_name_find(object_name *name, const scene_object *object, const casters *c, const scene *s);

#endif
