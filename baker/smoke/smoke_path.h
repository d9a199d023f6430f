/* Light on its way through smoke: how thick the smoke is up to each depth of a light ray, at as many depths as there are; and the
 * few nodes of the curve that is kept of it.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SMOKE_PATH_H
#define SMOKE_PATH_H

#include <stddef.h>
#include <stdint.h>

/* 32 hexadecimal digits of XXH3-128 of smoke's numbers and places, and NUL. */
enum { SMOKE_FINGERPRINT_BYTES = 33 };

/* Zero it; released with smoke_path_free. */
typedef struct smoke_path {
    size_t  count, depth_capacity, thick_capacity;
    double *depth; /* [count] metres along the map's axis; they rise */
    double *thick; /* [count] optical depth up to there; 0 at the first. Between two of them, a line */
} smoke_path;

/* Nothing that is thicker lets a 65535th of the light through. */
#define SMOKE_OPAQUE 12.0

/* What takes more than this, optical depth, is added in several pieces, between which a line is near enough; and what bends, too: such
 * that a line is off by no more. So many equal pieces are as opaque as can be. */
#define SMOKE_PIECE      0.05
#define SMOKE_BOW        0.001
#define SMOKE_PARTS_MOST 256

void smoke_path_free(smoke_path *p);

/* A piece behind all others, from a depth to a greater one.   thick  optical depth, > 0.   Returns 0 without memory. */
int smoke_path_add(smoke_path *p, double begin, double end, double thick);

/* Both at once.   sum  [out] neither of them; its count is set anew.   Returns 0 without memory. */
int smoke_path_sum(const smoke_path *a, const smoke_path *b, smoke_path *sum);

/* Forget what lies behind a depth. */
void smoke_path_cut(smoke_path *p, double depth);

/* Optical depth up to a depth. */
double smoke_path_thick(const smoke_path *p, double depth);

/* Depths as a file has them: unit d is first + d * step metres. */
typedef struct smoke_units {
    double first_metres, step_metres;
} smoke_units;

/* The nodes that are kept of a path: its ends, and in between the depth at which the curve is farthest from the path, until it is
 * nowhere farther than `error`, or there are as many as may be.
 * units  that have the path within 65535
 * error  of transmittance, 0 and more
 * most   2 to VXS_SMOKE_NODES_MAX
 * nodes  [out] [most] depth | transmittance << 16 (formats/vxs.md section 15)
 * Returns how many; 0: no more than `error` is lost on the whole path. */
uint32_t smoke_path_nodes(const smoke_path *p, const smoke_units *units, double error, uint32_t most, uint32_t *nodes);

/* How far the curve of these nodes is from the path where it is farthest. */
double smoke_path_error(const smoke_path *p, const smoke_units *units, const uint32_t *nodes, uint32_t count);

#endif
