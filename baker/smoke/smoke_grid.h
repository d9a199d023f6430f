/* Smoke as a grid of extinction, and light rays through it.
 *
 * Samples lie at the voxels' middles; between them extinction is trilinear, in the outer half of the outermost voxels it goes on as
 * it is, and outside the grid there is none. A ray is cut where it passes a plane of samples: in between, extinction along it is a
 * cubic, whose integral Simpson's rule gives exactly.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SMOKE_GRID_H
#define SMOKE_GRID_H

#include <stddef.h>
#include <stdint.h>

#include "baker/smoke/smoke_path.h"

/* Zero it; released with smoke_grid_free. */
typedef struct smoke_grid {
    uint32_t size[3];          /* samples along each axis of the grid */
    float   *extinction;       /* [size[2]][size[1]][size[0]] per metre, 0 and more */
    double   grid_from_ws[12]; /* three rows: sample (i, j, k) lies where they give i, j and k */
    double   ws_from_grid[12];
} smoke_grid;

/* Accepts a zeroed object. */
void smoke_grid_free(smoke_grid *g);

/* Set both matrices.
 * axes    from a sample to the next one along each axis of the grid, metres
 * origin  of sample (0, 0, 0)
 * Returns 0: the axes have no volume, or a corner of the box lies beyond 1e9 m. */
int smoke_grid_place(smoke_grid *g, const double axes[3][3], const double origin[3]);

void smoke_grid_fingerprint(const smoke_grid *g, char text[SMOKE_FINGERPRINT_BYTES]);

/* The corner of the grid's box, 0 to 7, half a voxel beyond the outermost samples. */
void smoke_grid_corner(const smoke_grid *g, int corner, double ws[3]);

/* The middle of the box. */
void smoke_grid_middle(const smoke_grid *g, double ws[3]);

/* Metres from a sample to the next one, along the axis where that is least. */
double smoke_grid_spacing(const smoke_grid *g);

/* Add to a path what a ray meets between two depths. It may end where nothing is left of the light.
 * from, way   at depth d the ray is at from + d * way
 * Returns 0 without memory. */
int smoke_grid_march(const smoke_grid *g, const double from[3], const double way[3], double begin, double end, smoke_path *path);

#endif
