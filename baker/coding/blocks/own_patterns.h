/* Patterns of tiles with many depths: 64 depths relative to a base, shared wherever tiles may have the same ones, at any base.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef OWN_PATTERNS_H
#define OWN_PATTERNS_H

#include <stddef.h>
#include <stdint.h>

#include "baker/coding/blocks/own_planes.h"
#include "formats/vxs_result.h"

enum { OWN_WINDOW = 1024 }; /* patterns that a tile is compared with */

typedef struct own_pattern {
    int32_t     depth[64]; /* none below 0 */
    tile_ranges may;       /* what all tiles that have it allow, from their bases on */
    uint32_t    plane_halves;
    uint16_t    planes[OWN_PLANES_HALVES_MAX]; /* [plane_halves] the pattern, if it is planes */
} own_pattern;

/* Zero it. */
typedef struct own_set {
    own_pattern *patterns; /* by id */
    size_t       count, pattern_capacity;

    /* as they are searched, the last first; those with depths that fit into halves */
    struct own_known *known;
    struct own_group *groups;
    size_t            known_count, known_capacity, group_capacity;
    int               cpu; /* [in] what searches may use, of cpu.h: it decides on time alone */
} own_set;

/* A pattern that fits, or a new one: planes, or depths that follow their neighbours as far as they may.
 * one   what own_plane found for the ranges
 * id    [out];   base  [out] what is added to its depths
 * Returns VXS_OK or VXS_E_MEMORY. */
vxs_result own_find(own_set *s, const tile_ranges *t, const own_planes *one, uint32_t *id, int32_t *base);

/* The same for what all tiles of a pattern of another set allow; where none fits, the pattern itself. */
vxs_result own_adopt(own_set *s, const own_pattern *p, uint32_t *id, int32_t *base);

/* How many halves a pattern takes.   halves  [out] [OWN_HALVES_MAX] */
uint32_t own_pattern_encode(const own_pattern *p, uint16_t *halves);

void own_set_free(own_set *s);

#endif
