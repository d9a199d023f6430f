/* A surface for a hole.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef MESH_HOLE_H
#define MESH_HOLE_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Fill a closed line of points with triangles between them: near the plane that fits best, or of least area and least angles.
 * points     [3 * count] along the line; 3 or more, all different
 * triangles  [out] [3 * (count - 2)] point numbers; they run along the line as it does
 * Returns 1, or 0 when there is no such surface (CGAL finds none, or there is no memory).  Cost: cubic at worst, so mind the
 * count. */
int mesh_fill_hole(const double *points, size_t count, uint32_t *triangles);

/* 1 when all points lie on one line, exactly: what fills them covers nothing. */
int mesh_is_crack(const double *points, size_t count);

#ifdef __cplusplus
}
#endif
#endif
