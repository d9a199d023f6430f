/* Lit intervals along a ray; see vxs_query.h. The computations are those of formats/vxs_intervals.h, in double.
 * SPDX-License-Identifier: MIT */
#include <math.h>

#include "vxs_intervals.h"
#include "vxs_query.h"

_Static_assert(sizeof(vxs_walk) <= sizeof((vxs_lit_walk *)0)->room, "there is room for it");
_Static_assert(VXS_CHILD_LIT == VXS_INTERVAL_LIT && VXS_CHILD_SHADOW == VXS_INTERVAL_SHADOW && VXS_BLOCKS_LIT == VXS_INTERVAL_LIT &&
                   VXS_BLOCKS_SHADOW == VXS_INTERVAL_SHADOW,
               "lit is 0 and shadow is 1 in every enumeration");
_Static_assert(VXS_SPAN_SHADOW == VXS_INTERVAL_SHADOW && VXS_SPAN_LIT == VXS_INTERVAL_LIT &&
                   VXS_SPAN_OUTSIDE == VXS_INTERVAL_OUTSIDE,
               "one number for one state");

static vxs_walk *walk_in(vxs_lit_walk *walk)
{
    return (vxs_walk *)walk->room;
}

vxs_result vxs_lit_begin(vxs_lit_walk *walk, const vxs_baked_light *baked, const vxs_ray *ray)
{
    const double most = 1e50;
    vxs_result   r    = VXS_OK;
    walk->baked       = baked;
    for (int n = 0; n < 3; n++)
        if (!(fabs(ray->origin_ws[n]) <= most && fabs(ray->direction_ws[n]) <= most)) r = VXS_E_ARGUMENT;
    if (!isfinite(ray->t_begin) || !(ray->t_end >= ray->t_begin)) r = VXS_E_ARGUMENT;
    *walk_in(walk) =
        vxs_walk_of(&baked->light, ray->origin_ws, ray->direction_ws, ray->t_begin, r == VXS_OK ? ray->t_end : ray->t_begin);
    return r;
}

size_t vxs_lit_next(vxs_lit_walk *walk, vxs_interval *intervals, size_t capacity)
{
    size_t   count = 0;
    vxs_span span  = {0};
    while (count < capacity && vxs_walk_next(walk->baked->words, &walk->baked->light, walk_in(walk), &span))
        intervals[count++] = (vxs_interval){span.begin, span.end, span.state, span.coarse};
    return count;
}
