/* Objects that make a sun's map much larger than that of the rest: a crate that was forgotten far away, the sea around an island.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef FAR_OBJECTS_H
#define FAR_OBJECTS_H

#include "baker/bake/scene_objects.h"

enum { FAR_OBJECTS_MAX = 8 };

typedef struct far_objects {
    size_t   count, triangles;       /* 0: there are none */
    uint32_t items[FAR_OBJECTS_MAX]; /* of the list, the farthest first */
    box      rest;                   /* around all others, metres */
} far_objects;

/* Find objects without which the scene is a tenth as large or less: at most FAR_OBJECTS_MAX, of a quarter of its triangles at most.
 * Returns 1 when there are some. */
int far_objects_find(far_objects *out, const object_list *objects);

#endif
