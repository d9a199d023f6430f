/* Objects that make a sun's map much larger than the rest of the scene needs: a forgotten crate far away, the sea around an island.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef FAR_OBJECTS_H
#define FAR_OBJECTS_H

#include "baker/bake/scene_objects.h"

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

#endif
