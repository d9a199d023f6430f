/* Axis-aligned boxes of points.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BOX_H
#define BOX_H

#include <math.h>

typedef struct box {
    double min[3], max[3]; /* max < min while it holds no point */
} box;

static inline box box_empty(void)
{
    return (box){{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
}

/* What is not a number is passed over. */
static inline void box_add(box *b, const double point[3])
{
    for (int axis = 0; axis < 3; axis++) {
        if (point[axis] < b->min[axis]) b->min[axis] = point[axis];
        if (point[axis] > b->max[axis]) b->max[axis] = point[axis];
    }
}

#endif
