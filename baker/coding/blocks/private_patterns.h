/* Private-palette patterns, for tiles with many depths: 64 depths relative to a base. Tiles whose ranges allow it share a pattern,
 * with different bases.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef PRIVATE_PATTERNS_H
#define PRIVATE_PATTERNS_H

#include <stddef.h>
#include <stdint.h>

#include "baker/coding/blocks/plane.h"
#include "formats/vxs_result.h"

/* Depth ranges in which the columns of a tile allow the shadow to begin. */

/* [low, high] of 64 texels, in the order of patterns.h, in voxels. */
typedef struct tile_ranges {
    int32_t low[64], high[64];
} tile_ranges;

static inline int32_t least_high(const tile_ranges *t)
{
    int32_t least = t->high[0];
    for (int n = 1; n < 64; n++) least = t->high[n] < least ? t->high[n] : least;
    return least;
}

/* Patterns of tiles whose texels lie on one plane or on two, for instance where a slanted sheet ends in front of another. */

enum { PRIVATE_PLANE_HALVES = 3, PRIVATE_PAIR_HALVES = 6, PRIVATE_PLANES_HALVES_MAX = 10 };

/* The ranges of a tile in parts of a voxel, relative to depth `from`. */
void plane_ranges_of(plane_ranges *to, const tile_ranges *t, int32_t from);

/* A fast test, which rejects most tiles that have no plane: lines of three texels and squares of four, whose ranges leave no room
 * for one. */
int tile_may_be_plane(const tile_ranges *t);

/* Planes that pass through all ranges of a tile. */
typedef struct private_planes {
    uint32_t count;                             /* number of halves; 0: no planes */
    uint16_t halves[PRIVATE_PLANES_HALVES_MAX]; /* [count] formats/vxs.md 13.3 */
    int32_t  depth[64], base;                   /* depths of the planes relative to the base, all >= 0 */
} private_planes;

/* Whether `count` halves from any writer are valid planes. */
int private_planes_are_sound(const uint16_t *halves, uint32_t count);

/* Fit one plane: count becomes PRIVATE_PLANE_HALVES, or 0. */
void private_plane(private_planes *to, const tile_ranges *t);

/* Fit two planes.   thorough  whether it may take longer */
void private_plane_pair(private_planes *to, const tile_ranges *t, int thorough);

/* Number of patterns that a tile is compared with, at most; less if searches may not take longer. */
enum { PRIVATE_WINDOW = 4096, PRIVATE_WINDOW_LESS = 1024 };

typedef struct private_pattern {
    int32_t     depth[64]; /* all >= 0 */
    tile_ranges may;       /* intersection of the ranges of all its tiles, relative to their bases */
    uint32_t    plane_halves;
    uint16_t    planes[PRIVATE_PLANES_HALVES_MAX]; /* [plane_halves] the pattern as planes, if it is planes */
} private_pattern;

/* Zero it. */
typedef struct private_set {
    private_pattern *patterns; /* by id */
    size_t           count, pattern_capacity;

    /* search order is last to first; only patterns whose depths fit into halves */
    struct private_known *known;
    struct pair_group    *groups;
    size_t                known_count, known_capacity, group_capacity;
    int                   thorough; /* [in] whether searches may take longer */
    int                   cpu;      /* [in] level of cpu.h for searches; affects only time */
} private_set;

/* Find a pattern that fits, or add one: planes, or depths that follow their neighbours as far as the ranges allow.
 * planes  that were fitted to the ranges: one or two, or none
 * id      [out];   base  [out] added to the pattern's depths
 * Returns VXS_OK or VXS_E_MEMORY. */
vxs_result private_find(private_set *s, const tile_ranges *t, const private_planes *planes, uint32_t *id, int32_t *base);

/* The same for a pattern of another set, within the ranges that its tiles allow. If no pattern fits, the pattern itself is
 * added. */
vxs_result private_adopt(private_set *s, const private_pattern *p, uint32_t *id, int32_t *base);

/* Number of halves of a pattern.   halves  [out] [PRIVATE_HALVES_MAX] */
uint32_t private_pattern_encode(const private_pattern *p, uint16_t *halves);

void private_set_free(private_set *s);

#endif
