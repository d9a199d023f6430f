/* A surface for a hole.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef MESH_HOLE_H
#define MESH_HOLE_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Fill a closed polygon with triangles: near its best-fit plane, or with minimal area and angles.
 * points     [3 * count] in order; 3 or more, all different
 * triangles  [out] [3 * (count - 2)] point numbers; wound in the polygon's direction
 * Returns 1, or 0 when there is no such surface (CGAL finds none, or out of memory).  Cost: up to cubic, so limit count. */
int mesh_fill_hole(const double *points, size_t count, uint32_t *triangles);

/* 1 when all points are exactly collinear: triangles between them have no area. */
int mesh_is_crack(const double *points, size_t count);

#ifdef __cplusplus
}
#endif
#endif
