/* Radiance from far away in all directions: an equirectangular map, twice as wide as high, rows of equal angles from the zenith
 * (+Y) down to the nadir, columns of equal angles, to the right as seen from inside; its middle column is in direction +X.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SKY_MAP_H
#define SKY_MAP_H

#include "baker/base/message.h"

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
vxs_result sky_map_read(sky_map *map, const char *path, message *m);

/* Accepts a zeroed object. */
void sky_map_free(sky_map *map);

/* internal, for its readers ---------------------------------------------------------------------------------------------------- */

/* A file in memory, and its name in messages. */
typedef struct sky_file {
    const char    *name;
    const uint8_t *bytes, *end;
} sky_file;

/* Allocate a map of the size that a file states.   Returns VXS_OK, VXS_E_UNSUPPORTED, VXS_E_MEMORY. */
vxs_result sky_map_make(sky_map *map, const sky_file *file, uint32_t wide_px, uint32_t high_px, message *m);

/* Whether the file begins with Radiance's signature. */
int sky_is_radiance(const sky_file *file);
int sky_is_png(const sky_file *file);

/* map  [out] released by the caller, whatever is returned */
vxs_result sky_read_radiance(sky_map *map, const sky_file *file, message *m);
vxs_result sky_read_png(sky_map *map, const sky_file *file, message *m);

#endif
