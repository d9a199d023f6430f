/* Virtual lights of a sky; see vxs_area_light.h.
 * SPDX-License-Identifier: MIT */
#include <math.h>

#include "area_sites.h"

static const double pi = 3.14159265358979324;

/* The way light travels from a site. */
static void way_from(const area_site *at, float way[3])
{
    double up = 1 - 2 * at->v, across = 2 * sqrt(fmax(at->v * (1 - at->v), 0)); /* v may be rounded to beyond 1 */
    way[0] = (float)(-across * cos(2 * pi * at->u));
    way[1] = (float)-up;
    way[2] = (float)(-across * sin(2 * pi * at->u));
}

vxs_result vxs_area_sample_sky(const vxs_area_sky *sky, vxs_area_places places, uint32_t seed, vxs_area_lamp *lamps, uint32_t count)
{
    area_site    sites[VXS_AREA_LAMPS];
    area_picture picture = {sky->texture, sky->radiance, sky->wide_px, sky->high_px, 1, 2};
    if (!count || count > VXS_AREA_LAMPS || (unsigned)places > VXS_AREA_JITTERED) return VXS_E_ARGUMENT;
    if (!vxs_area_is_number(sky->middle, -INFINITY) || !vxs_area_is_number(sky->radiance, 0)) return VXS_E_ARGUMENT;
    if (!(sky->radius_metres > 0) || !isfinite(sky->radius_metres) || !sky->texture || !sky->wide_px || !sky->high_px)
        return VXS_E_ARGUMENT;
    vxs_area_sites(&picture, places, seed, sites, count);
    for (uint32_t n = 0; n < count; n++) {
        lamps[n] = (vxs_area_lamp){.is_far = 1, .radius_metres = sky->radius_metres};
        way_from(&sites[n], lamps[n].normal);
        for (int i = 0; i < 3; i++) {
            lamps[n].place[i]  = sky->middle[i];
            lamps[n].colour[i] = (float)((double)sky->radiance[i] * (double)sites[n].texel[i] * sites[n].scale * 4 * pi / count);
        }
    }
    return VXS_OK;
}
