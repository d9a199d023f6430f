/* Optical depth of smoke along a light ray, at any number of depths; and the few nodes of the curve that is stored for it.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SMOKE_PATH_H
#define SMOKE_PATH_H

#include <stddef.h>
#include <stdint.h>

/* XXH3-128 of smoke's numbers and positions in 32 hexadecimal digits, and NUL. */
enum { SMOKE_FINGERPRINT_BYTES = 33 };

/* Zero it; released with smoke_path_free. */
typedef struct smoke_path {
    size_t  count, depth_capacity, thick_capacity;
    double *depth; /* [count] metres along the map's axis, ascending */
    double *thick; /* [count] optical depth up to there; the first is 0. Linear in between */
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

/* Remove what is behind a depth. */
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

#endif
