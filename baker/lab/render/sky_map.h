/* Radiance from far away in all directions: an equirectangular map, twice as wide as high, rows of equal angles from the zenith
 * (+Y) down to the nadir, columns of equal angles, to the right as seen from inside; its middle column is in direction +X.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SKY_MAP_H
#define SKY_MAP_H

#include "baker/base/run_context.h"

enum { SKY_HIGH_MAX = 4096 }; /* rows; there are twice as many columns */

typedef struct sky_map {
    uint32_t wide_px, high_px; /* wide_px is 2 * high_px */
    float   *radiance;         /* [high_px][wide_px][3] linear, primaries of Rec. 709; finite, >= 0, not all 0; owned */
} sky_map;

/* Read a picture: Radiance (.hdr, RGBE), or PNG with sRGB colours of 8 bits, at most 1. Sizes are checked before memory is
 * allocated.
 * map  [out] zeroed on failure; released with sky_map_free
 * Returns VXS_OK; VXS_E_READ; VXS_E_TRUNCATED, VXS_E_CORRUPT; VXS_E_UNSUPPORTED: another format, another shape, or too large;
 * VXS_E_SCENE: all of it is black; VXS_E_MEMORY. */
vxs_result sky_map_read(sky_map *map, const char *path, run_context *m);

/* The same of a picture in memory.   name  of its file, for messages */
vxs_result sky_map_decode(sky_map *map, const char *name, const uint8_t *bytes, size_t size_bytes, run_context *m);

/* Accepts a zeroed object. */
void sky_map_free(sky_map *map);

#endif
