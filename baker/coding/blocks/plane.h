/* Planes through the ranges that texels allow: slanted sheets, which need a depth for each texel, but are three numbers.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef PLANE_H
#define PLANE_H

#include <stdint.h>

enum {
    PLANE_ONE       = 256, /* parts of a voxel that slopes and depths of planes are in */
    PLANE_SHIFT_MAX = 8,
    PLANES_RECENT   = 4,
    PLANE_FREE      = 1 << 22 /* a texel that any plane may pass in front of or behind: sums of such numbers are exact as floats */
};

/* Depth is that of the corner where it is least, and grows from there: as formats/vxs.md 13 has it. */
typedef struct plane {
    int32_t across, down; /* a texel on; each within +-32767 << PLANE_SHIFT_MAX */
    int32_t least;
} plane;

/* The ranges of a tile's texels, in the order of patterns.h, in parts of a voxel, whole numbers within
 * +-PLANE_FREE; and where its first texel is in the area of the plane. */
typedef struct plane_ranges {
    float    low[64], high[64];
    int32_t  x, y;
    uint32_t quadrants; /* bits of those in which a texel bounds planes */
} plane_ranges;

/* How far slopes are shifted so that they fit into halves. */
int plane_shift(const plane *p);

/* Depth of texel (x, y) of an area of `side` texels, in voxels. */
static inline int32_t plane_depth(const plane *p, int32_t side, int32_t x, int32_t y)
{
    return (p->least + p->across * (p->across < 0 ? x - side + 1 : x) + p->down * (p->down < 0 ? y - side + 1 : y)) >> 8;
}

/* Whether three texels of any of a few lines, at equal distances, leave room for a plane. Most tiles that none passes through are told so. */
int plane_may_fit(const plane_ranges *t);

/* Move a plane until it passes through all ranges of all tiles, with room to spare if there is some.
 * p     slopes to start from; [out] the slopes found, multiples of 1 << plane_shift(p), and as round a depth as there is
 * side  of the area: 8, or 32
 * Returns 0 where none was found; then *p means nothing. */
int plane_fit(plane *p, const plane_ranges *const *tiles, int count, int32_t side);

/* The same without a move of slopes that can be written already: only the depth is found. */
int plane_place(plane *p, const plane_ranges *const *tiles, int count, int32_t side);

/* Give a plane that was fitted to one tile of 8 x 8 rounder slopes, which take fewer bits: as round as there are that leave its depth as
 * round as it is. */
void plane_round(plane *p, const plane_ranges *t);

/* Where a plane may pass the texels that are not its own. */
typedef enum plane_others { OTHERS_ANYWHERE, OTHERS_BEHIND, OTHERS_BEFORE } plane_others;

/* The same as plane_fit for texels of one tile of 8 x 8, whose bits are set; behind or before the others, slopes are rounded, too. */
int plane_fit_texels(plane *p, const plane_ranges *t, uint64_t texels, plane_others others);

/* Texels of a tile of 8 x 8 whose ranges, each `margin` wider, the plane passes through. */
uint64_t plane_texels(const plane *p, const plane_ranges *t, int32_t margin);

/* Slopes between the ends of a tile, as a start. */
plane plane_start(const plane_ranges *t);

/* The tiles of a block of 32 x 32 texels that lie on one plane, as many as are found to.
 * p       [out] the plane, in the block
 * tiles   [16] rows; those whose bits of `mixed` are set are looked at
 * flat    those of them that plane_may_fit says
 * recent  [PLANES_RECENT] slopes that are tried first; what is found joins them
 * Returns the bits of those tiles; 0: it is not worth it. */
uint32_t plane_of_block(plane *p, const plane_ranges tiles[16], uint32_t mixed, uint32_t flat, plane recent[PLANES_RECENT]);

/* Two planes that pass through all texels of a tile of 8 x 8, each through its own.
 * second  [out] texels of the second plane
 * Returns 0 where none were found; 1: *second is 0, and one plane does. */
int plane_fit_pair(plane pair[2], uint64_t *second, const plane_ranges *t);

#endif
