/* Patterns of tiles with many depths: 64 depths relative to a base, shared wherever tiles may have the same ones, at any base.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef OWN_PATTERNS_H
#define OWN_PATTERNS_H

#include <stddef.h>
#include <stdint.h>

#include "formats/vxs_result.h"

enum { OWN_WINDOW = 1024 }; /* patterns that a tile is compared with */

/* Where the columns of 64 texels let the shadow begin: [low, high], texels in the order of patterns.h. */
typedef struct tile_ranges {
    int32_t low[64], high[64];
} tile_ranges;

typedef struct own_pattern {
    int32_t     depth[64]; /* of which the least is 0 */
    tile_ranges may;       /* what all tiles that have it allow, from their bases on */
} own_pattern;

/* Zero it. */
typedef struct own_set {
    own_pattern *patterns; /* by id */
    size_t       count, pattern_capacity;

    /* as they are searched, the last first; those with depths that fit into halves */
    struct own_known *known;
    size_t            known_count, known_capacity;
} own_set;

/* A pattern that fits, or a new one: depths that follow their neighbours as far as they may.
 * id    [out];   base  [out] what is added to its depths
 * Returns VXS_OK or VXS_E_MEMORY. */
vxs_result own_find(own_set *s, const tile_ranges *t, uint32_t *id, int32_t *base);

void own_set_free(own_set *s);

#endif
