/* What the shadow map itself would take: the 16-bit enter depths under zstd -19, of all rows or of a sample.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BASELINE_H
#define BASELINE_H

#include <stddef.h>
#include <stdint.h>

#include "baker/columns/stored/depth_maps.h"

typedef struct baseline {
    uint16_t *texels; /* kept rows */
    size_t    count, capacity;
    uint64_t  seen;          /* texels of the map so far */
    size_t    limit_per_map; /* texels to keep of each map; 0: all */
} baseline;

/* Add the enter depths of maps; empty: of maps without casters, whose arrays are not looked at. Returns 0 without memory. */
int baseline_add(baseline *b, const depth_maps *maps, int empty);

/* Compressed size over raw size of what was kept; 0 when nothing was kept or memory ran out. *share: of all texels. */
double baseline_ratio(const baseline *b, double *share);

void baseline_free(baseline *b);

#endif
