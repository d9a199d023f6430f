/* Smoke as a grid of extinction, and light rays through it.
 *
 * Samples are at the centres of voxels. Extinction is trilinear between them, constant in the outer half of the outermost voxels,
 * and zero outside the grid. A ray is split where it crosses a plane of samples. Between two planes the extinction along the ray is
 * a cubic, which Simpson's rule integrates exactly.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SMOKE_GRID_H
#define SMOKE_GRID_H

#include <stddef.h>
#include <stdint.h>

#include "baker/smoke/smoke_path.h"

/* Zero it; released with smoke_grid_free. */
typedef struct smoke_grid {
    uint32_t size[3];          /* samples along each axis of the grid */
    float   *extinction;       /* [size[2]][size[1]][size[0]] per metre, >= 0 */
    double   grid_from_ws[12]; /* three rows: world space to grid coordinates (i, j, k); sample (i, j, k) is at integers */
    double   ws_from_grid[12];
} smoke_grid;

/* Accepts a zeroed object. */
void smoke_grid_free(smoke_grid *g);

/* Set both matrices.
 * axes    step to the next sample along each axis of the grid, metres
 * origin  of sample (0, 0, 0)
 * Returns 0: the axes have no volume, or a corner of the box is beyond 1e9 m. */
int smoke_grid_place(smoke_grid *g, const double axes[3][3], const double origin[3]);

void smoke_grid_fingerprint(const smoke_grid *g, char text[SMOKE_FINGERPRINT_BYTES]);

/* A corner of the grid's box, 0 to 7, half a voxel beyond the outermost samples. */
void smoke_grid_corner(const smoke_grid *g, int corner, double ws[3]);

/* The centre of the box. */
void smoke_grid_middle(const smoke_grid *g, double ws[3]);

/* Least distance between neighbouring samples, metres. */
double smoke_grid_spacing(const smoke_grid *g);

/* Add the smoke along a ray between two depths to a path. May end early where no light is left.
 * from, way   at depth d the ray is at from + d * way
 * Returns 0 without memory. */
int smoke_grid_march(const smoke_grid *g, const double from[3], const double way[3], double begin, double end, smoke_path *path);

#endif
