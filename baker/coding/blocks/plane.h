/* Planes through the depth ranges of texels. A slanted sheet needs a different depth for each texel, but only three numbers as a
 * plane.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef PLANE_H
#define PLANE_H

#include <stdint.h>

enum {
    PLANE_ONE       = 256, /* parts of a voxel: the unit of slopes and depths of planes */
    PLANE_SHIFT_MAX = 8,
    PLANES_RECENT   = 4,
    PLANE_TILES_MIN = 3,      /* least tiles of a block on a plane that pay for its size */
    PLANE_FREE      = 1 << 22 /* range of a texel that does not bound planes. Sums of such numbers are exact in float */
};

/* Depth at the corner where it is least, and slopes from there (formats/vxs.md 13). */
typedef struct plane {
    int32_t across, down; /* slopes per texel; each within +-32767 << PLANE_SHIFT_MAX */
    int32_t least;
} plane;

/* Ranges of a tile's texels, in the order of patterns.h: integers in parts of a voxel, within +-PLANE_FREE; and the position of the
 * tile's first texel in the area of the plane. */
typedef struct plane_ranges {
    float    low[64], high[64];
    int32_t  x, y;
    uint32_t quadrants; /* bit mask of quadrants with texels that bound planes */
} plane_ranges;

/* Shift of the slopes that makes them fit into halves. */
int plane_shift(const plane *p);

/* Depth of texel (x, y) of an area of `side` texels, in voxels. */
static inline int32_t plane_depth(const plane *p, int32_t side, int32_t x, int32_t y)
{
    return (p->least + p->across * (p->across < 0 ? x - side + 1 : x) + p->down * (p->down < 0 ? y - side + 1 : y)) >> 8;
}

/* Move a plane until it passes through all ranges of all tiles, with room to spare if possible.
 * p     slopes to start from; [out] the slopes found, multiples of 1 << plane_shift(p), and the roundest depth that fits
 * side  of the area: 8, or 32
 * Returns 0 if none was found; then *p is undefined. */
int plane_fit(plane *p, const plane_ranges *const *tiles, int count, int32_t side);

/* Find only the depth; keep the slopes, which can be written already. Returns 0 if there is less room than `least_room`; then *p is
 * undefined. */
int plane_place(plane *p, const plane_ranges *const *tiles, int count, int32_t side, int32_t least_room);

/* The nearest slopes that are multiples of 1 << zeros. */
plane plane_rounded(const plane *p, int zeros);

/* Give a plane that was fitted to one tile of 8 x 8 rounder slopes, which take fewer bits: the roundest that keep its depth as
 * round as before. */
void plane_round(plane *p, const plane_ranges *t);

/* Where a plane may pass the texels outside its set. */
typedef enum plane_others { OTHERS_ANYWHERE, OTHERS_BEHIND, OTHERS_BEFORE } plane_others;

/* Like plane_fit, for the texels of one tile of 8 x 8 whose bits are set. With OTHERS_BEHIND or OTHERS_BEFORE slopes are
 * rounded, too. */
int plane_fit_texels(plane *p, const plane_ranges *t, uint64_t texels, plane_others others);

/* The same as plane_round for a plane through these texels. */
void plane_round_texels(plane *p, const plane_ranges *t, uint64_t texels);

/* Start slopes, from the ends of a tile. */
plane plane_start(const plane_ranges *t);

/* Find a plane for as many tiles of a block of 32 x 32 texels as possible.
 * p       [out] the plane, in the block
 * tiles   [16] rows; only those with bits in `mixed` are used
 * flat    tiles of these that may lie on a plane
 * recent  [PLANES_RECENT] slopes to try first; a plane that is found is added
 * Returns the bits of its tiles; 0: not worth it. */
uint32_t plane_of_block(plane *p, const plane_ranges tiles[16], uint32_t mixed, uint32_t flat, plane recent[PLANES_RECENT]);

/* Put a plane in front. */
void plane_remember(plane recent[PLANES_RECENT], plane p);

/* Bits of those of some tiles that the plane of a block passes through. */
uint32_t plane_passes(const plane *p, const plane_ranges tiles[16], uint32_t some);

/* Move a plane in depth until it passes through all 16 tiles. Returns 0 if there is no such depth; then *p stays as it is. */
int plane_of_all(plane *p, const plane_ranges tiles[16]);

/* Find two planes that pass through all texels of a tile of 8 x 8, each through its own texels.
 * thorough  whether it may take longer
 * second  [out] texels of the second plane
 * Returns 0 if none were found; 1 otherwise, with *second 0 if one plane is enough. */
int plane_fit_pair(plane pair[2], uint64_t *second, const plane_ranges *t, int thorough);

/* Slope of a node: it is added to the depths of the node's tiles, so that flat ground under slanted light has a single depth. */

enum { NODE_TILES = 32, NODE_PX = 256, SLOPE_MAX = 20000 };

/* In 1/256 voxel per tile, to the right and down; each within +-SLOPE_MAX. */
typedef struct node_slope {
    int32_t x, y;
} node_slope;

/* Depth added to tile (x, y), [0, 32): never negative. Must equal formats/vxs_lookup_blocks.h. */
static inline int32_t slope_shift(node_slope s, int32_t x, int32_t y)
{
    return ((s.x < 0 ? s.x * (x - 31) : s.x * x) + (s.y < 0 ? s.y * (y - 31) : s.y * y)) >> 8;
}

/* Greatest depth added to any tile. */
static inline int32_t slope_shift_max(node_slope s)
{
    return ((s.x < 0 ? -s.x : s.x) * 31 + (s.y < 0 ? -s.y : s.y) * 31) >> 8;
}

/* Whether a slope could help: whether two blocks of 4 x 4 tiles or more have no common depth for all of their columns, though each of
 * their tiles has one.
 * emax, xmin  [32 * 32] rows of tiles: the last enter and the first exit depth of each, [0, 2^19] voxels
 * deepest     greatest enter depth of the node
 * mixed       blocks without a common depth; only their tiles are read */
int slope_may_help(const int32_t *emax, const int32_t *xmin, int32_t deepest, uint64_t mixed);

/* Find a slope with which few blocks have no common depth.
 * emax, xmin  of all tiles
 * first       tried first: the slope of the previous node
 * Returns {0, 0} if no slope helps. Other arguments as for slope_may_help. */
node_slope slope_find(const int32_t *emax, const int32_t *xmin, int32_t deepest, uint64_t mixed, node_slope first);

#endif
