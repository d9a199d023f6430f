/* Patterns of tiles whose texels lie on one plane or on two, as where a slanted sheet ends before another.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef OWN_PLANES_H
#define OWN_PLANES_H

#include "baker/coding/blocks/plane.h"
#include "baker/coding/blocks/tile_ranges.h"

enum { OWN_PLANE_HALVES = 3, OWN_PAIR_HALVES = 6, OWN_PLANES_HALVES_MAX = 10 };

/* The ranges of a tile in parts of a voxel, from depth `from` on. */
void plane_ranges_of(plane_ranges *to, const tile_ranges *t, int32_t from);

/* Planes that pass through all ranges of a tile. */
typedef struct own_planes {
    uint32_t count;                         /* of halves; 0: there are none */
    uint16_t halves[OWN_PLANES_HALVES_MAX]; /* [count] formats/vxs.md 13.3 */
    int32_t  depth[64], base;               /* what they give from the base on; none is below 0 */
} own_planes;

/* Whether halves that anyone may have written are planes, as many as `count` says. */
int own_planes_are_sound(const uint16_t *halves, uint32_t count);

/* One plane: count is OWN_PLANE_HALVES, or 0. */
void own_plane(own_planes *to, const tile_ranges *t);

/* Two planes. */
void own_plane_pair(own_planes *to, const tile_ranges *t);

#endif
