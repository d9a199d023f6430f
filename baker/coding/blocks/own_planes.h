/* Patterns of tiles whose texels lie on one plane or on two, for instance where a slanted sheet ends in front of another.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef OWN_PLANES_H
#define OWN_PLANES_H

#include "baker/coding/blocks/plane.h"
#include "baker/coding/blocks/tile_ranges.h"

enum { OWN_PLANE_HALVES = 3, OWN_PAIR_HALVES = 6, OWN_PLANES_HALVES_MAX = 10 };

/* The ranges of a tile in parts of a voxel, relative to depth `from`. */
void plane_ranges_of(plane_ranges *to, const tile_ranges *t, int32_t from);

/* Planes that pass through all ranges of a tile. */
typedef struct own_planes {
    uint32_t count;                         /* number of halves; 0: no planes */
    uint16_t halves[OWN_PLANES_HALVES_MAX]; /* [count] formats/vxs.md 13.3 */
    int32_t  depth[64], base;               /* depths of the planes relative to the base, all >= 0 */
} own_planes;

/* Whether `count` halves from any writer are valid planes. */
int own_planes_are_sound(const uint16_t *halves, uint32_t count);

/* Fit one plane: count becomes OWN_PLANE_HALVES, or 0. */
void own_plane(own_planes *to, const tile_ranges *t);

/* Fit two planes. */
void own_plane_pair(own_planes *to, const tile_ranges *t);

#endif
