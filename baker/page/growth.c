/* How something grows with resolution; see growth.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/page/growth.h"

#include <math.h>

growth growth_of(const bench_set *set, const bench_series *s, growth_value *value)
{
    const growth none   = {0, 0, 0, 0};
    double       mean_x = 0, mean_y = 0, xx = 0, xy = 0;
    for (size_t n = 0; n < s->count; n++) {
        const set_cell *c = &set->cells[s->cells[n]];
        if (!(value(c->measured) > 0)) return none;
        mean_x += log2(c->side_px) / (double)s->count;
        mean_y += log2(value(c->measured)) / (double)s->count;
    }
    for (size_t n = 0; n < s->count; n++) {
        const set_cell *c = &set->cells[s->cells[n]];
        double          x = log2(c->side_px) - mean_x;
        xx += x * x;
        xy += x * (log2(value(c->measured)) - mean_y);
    }
    if (!(xx > 1e-9)) return none;
    double slope = xy / xx;
    return (growth){.slope = slope, .scale = exp2(mean_y - slope * mean_x), .factor = exp2(slope), .count = s->count};
}
