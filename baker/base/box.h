/* Axis-aligned boxes of points.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BOX_H
#define BOX_H

#include <math.h>
#include <stddef.h>
#include <stdint.h>

typedef struct box {
    double min[3], max[3]; /* max < min while the box is empty */
} box;

static inline box box_empty(void)
{
    return (box){{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
}

/* Ignores NaN coordinates. */
static inline void box_add(box *b, const double point[3])
{
    for (int axis = 0; axis < 3; axis++) {
        if (point[axis] < b->min[axis]) b->min[axis] = point[axis];
        if (point[axis] > b->max[axis]) b->max[axis] = point[axis];
    }
}

/* Length of the diagonal. INFINITY for an empty box. */
static inline double box_diagonal(const box *b)
{
    double x = b->max[0] - b->min[0], y = b->max[1] - b->min[1], z = b->max[2] - b->min[2];
    return sqrt(x * x + y * y + z * z);
}

/* The middle of the three side lengths: the visible width of a long object. For example, the width of a pole's shadow. */
static inline double box_width(const box *b)
{
    double x = b->max[0] - b->min[0], y = b->max[1] - b->min[1], z = b->max[2] - b->min[2];
    return fmax(fmin(x, y), fmin(fmax(x, y), z));
}

/* Bounding box of the corners of triangles.
 * positions  [3 * vertices]
 * indices    [count] vertex numbers */
static inline box box_of_corners(const double *positions, const uint32_t *indices, size_t count)
{
    box b = box_empty();
    for (size_t i = 0; i < count; i++) box_add(&b, &positions[3 * (size_t)indices[i]]);
    return b;
}

#endif
