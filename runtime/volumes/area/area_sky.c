/* Virtual point lights of a sky; see vxs_area_light.h.
 * SPDX-License-Identifier: MIT */
#include <math.h>

#include "area_sites.h"

static const double pi = 3.14159265358979324;

vxs_result vxs_area_sample_sky(const vxs_area_sky *sky, vxs_area_places places, uint32_t seed, vxs_vpl *vpls, uint32_t count)
{
    area_site    sites[VXS_VPLS_MAX];
    double       from[3];
    area_picture picture = {sky->texture, sky->radiance, sky->wide_px, sky->high_px, 1, 2};
    if (!count || count > VXS_VPLS_MAX || (unsigned)places > VXS_AREA_JITTERED) return VXS_E_ARGUMENT;
    if (!vxs_area_is_number(sky->middle, -INFINITY) || !vxs_area_is_number(sky->radiance, 0)) return VXS_E_ARGUMENT;
    if (!(sky->radius_metres > 0) || !isfinite(sky->radius_metres) || !sky->texture || !sky->wide_px || !sky->high_px)
        return VXS_E_ARGUMENT;
    vxs_area_sites(&picture, places, seed, sites, count);
    for (uint32_t n = 0; n < count; n++) {
        vpls[n] = (vxs_vpl){.is_far = 1, .radius_metres = sky->radius_metres};
        vxs_area_place_of(&picture, sites[n].u, sites[n].v, from);
        for (int i = 0; i < 3; i++) {
            vpls[n].place[i]  = sky->middle[i];
            vpls[n].normal[i] = (float)-from[i];
            vpls[n].colour[i] = (float)((double)sky->radiance[i] * sites[n].light[i] * 4 * pi / count);
        }
    }
    return VXS_OK;
}
