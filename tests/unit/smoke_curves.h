/* Maps of random curves, as smoke of a light is written. Include after <cmocka.h>, or without it.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SMOKE_CURVES_H
#define SMOKE_CURVES_H

#include "baker/base/random.h"
#include "formats/vxs_write_file.h"

enum { CURVES_LOG2 = 4, CURVES_SIDE = 1 << CURVES_LOG2, CURVES_A_MAP = CURVES_SIDE * CURVES_SIDE };

typedef struct curve_maps {
    uint8_t  counts[VXS_CUBE_FACES * CURVES_A_MAP];
    uint32_t nodes[VXS_CUBE_FACES * CURVES_A_MAP * VXS_SMOKE_NODES_MAX];
    size_t   first[VXS_CUBE_FACES * CURVES_A_MAP]; /* of each curve */
} curve_maps;

/* Light that falls from 1, with steps, and texels and tiles that have none. */
static inline void random_curves(curve_maps *s, rng *r, size_t map_count)
{
    size_t at = 0;
    for (size_t n = 0; n < map_count * CURVES_A_MAP; n++) {
        int empty      = n % CURVES_A_MAP < 64; /* a tile of each map */
        s->first[n]    = at;
        s->counts[n]   = (uint8_t)(empty || !rng_below(r, 4) ? 0 : rng_below(r, VXS_SMOKE_NODES_MAX + 1));
        uint32_t depth = rng_below(r, 4000), left = 65535 - rng_below(r, 2) * rng_below(r, 65535);
        for (uint32_t k = 0; k < s->counts[n]; k++) {
            s->nodes[at++] = depth | left << 16;
            depth += rng_below(r, 3) ? rng_below(r, 3800) : 0;
            left -= rng_below(r, left / 3 + 1);
        }
    }
}

static inline vxs_smoke_view curves_view(const curve_maps *s, float first_metres, float step_metres)
{
    return (vxs_smoke_view){CURVES_LOG2, first_metres, step_metres, s->counts, s->nodes};
}

#endif
