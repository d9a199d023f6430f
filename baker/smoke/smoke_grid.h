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

#include "baker/base/run_context.h"

/* Optical depth of smoke along a light ray, at any number of depths; and the few nodes of the curve that is stored for it. */

/* XXH3-128 of smoke's numbers and positions in 32 hexadecimal digits, and NUL. */
enum { SMOKE_FINGERPRINT_BYTES = 33 };

/* Zero it; released with smoke_path_free. */
typedef struct smoke_path {
    size_t  count, depth_capacity, thick_capacity, left_capacity;
    double *depth; /* [count] metres along the map's axis, ascending */
    double *thick; /* [count] optical depth up to there; the first is 0. Linear in between */
    double *left;  /* [count] transmittance up to there */
} smoke_path;

/* Optical depth at which less than 1/65535 of the light is left. */
#define SMOKE_OPAQUE 12.0

/* Smoke of more optical depth than SMOKE_PIECE is added in several linear pieces; so is curved smoke, until a line is off by no
 * more than SMOKE_BOW. SMOKE_PARTS_MOST equal pieces are more than opaque. */
#define SMOKE_PIECE      0.05
#define SMOKE_BOW        0.001
#define SMOKE_PARTS_MOST 256

void smoke_path_free(smoke_path *p);

/* Append a piece behind all others, from depth begin to a greater depth end.   thick  optical depth, > 0.   Returns 0 without
 * memory. */
int smoke_path_add(smoke_path *p, double begin, double end, double thick);

/* Add two paths.   sum  [out] neither of them; its contents are replaced.   Returns 0 without memory. */
int smoke_path_sum(const smoke_path *a, const smoke_path *b, smoke_path *sum);

/* Remove all smoke behind a depth. */
void smoke_path_cut(smoke_path *p, double depth);

/* Optical depth up to a depth. */
double smoke_path_thick(const smoke_path *p, double depth);

/* Depths in a file: unit d is first + d * step metres. */
typedef struct smoke_units {
    double first_metres, step_metres;
} smoke_units;

/* Choose the nodes of the curve for a path: its ends, then repeatedly the depth at which the curve is farthest from the path, until
 * the error is at most `error`, or there are `most` nodes.
 * units  must map the whole path to at most 65535
 * error  of transmittance, >= 0
 * most   2 to VXS_SMOKE_NODES_MAX
 * nodes  [out] [most] depth | transmittance << 16 (formats/vxs.md section 15)
 * Returns the number of nodes; 0: the whole path loses at most `error`. */
uint32_t smoke_path_nodes(const smoke_path *p, const smoke_units *units, double error, uint32_t most, uint32_t *nodes);

/* Greatest error of the curve of these nodes against the path. */
double smoke_path_error(const smoke_path *p, const smoke_units *units, const uint32_t *nodes, uint32_t count);

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

/* Reads a grid of smoke from NRRD, a text header before raw numbers (teem.sourceforge.net/nrrd/format.html):
 *
 *     NRRD0004
 *     type: float
 *     dimension: 3
 *     sizes: 64 96 64
 *     encoding: raw
 *     endian: little
 *     space dimension: 3
 *     space directions: (0.25,0,0) (0,0.25,0) (0,0,0.25)
 *     space origin: (-8,0,-8)
 *
 *     numbers, the first axis fastest
 *
 * Space is the world space of the scene, metres, +Y up: sample (i, j, k) is at origin + i, j and k times the directions. Without
 * directions, "spacings" are distances along x, y and z. Numbers are float, unsigned char (uint8) or unsigned short (uint16). */

/* Reads the header first, at most 64 KiB; it gives the count of numbers, and no more are read. Memory is limited by
 * m->memory_bytes.
 * factor  multiplied with all numbers; the products are extinction per metre
 * g       [out] zeroed; released with smoke_grid_free whatever is returned
 * Returns VXS_OK; VXS_E_READ; VXS_E_UNSUPPORTED: a feature of NRRD that this reader lacks; VXS_E_SCENE: not NRRD, or a number that
 * is not a valid extinction; VXS_E_MEMORY. */
vxs_result nrrd_read(smoke_grid *g, const char *path, double factor, run_context *m);

#endif
