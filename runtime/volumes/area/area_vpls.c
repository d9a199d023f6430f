/* Virtual point lights of a rectangle; see vxs_area_light.h.
 * SPDX-License-Identifier: MIT */
#include <math.h>

#include "area_sites.h"

/* normal  [out] of length 1.   Returns the area in square metres; 0: it has none. */
static double area_of(const vxs_area_rectangle *r, double normal[3])
{
    double square = 0;
    for (int n = 0; n < 3; n++) {
        int a = (n + 1) % 3, b = (n + 2) % 3;
        normal[n] = (double)r->across[a] * (double)r->up[b] - (double)r->across[b] * (double)r->up[a];
        square += normal[n] * normal[n];
    }
    double area = sqrt(square);
    for (int n = 0; n < 3 && area > 0; n++) normal[n] /= area;
    return isfinite(area) ? area : 0;
}

static double length_of(const float v[3])
{
    return sqrt((double)v[0] * (double)v[0] + (double)v[1] * (double)v[1] + (double)v[2] * (double)v[2]);
}

vxs_result vxs_area_sample(const vxs_area_rectangle *r, vxs_area_places places, uint32_t seed, vxs_vpl *vpls, uint32_t count)
{
    area_site    sites[VXS_VPLS_MAX];
    area_picture picture = {r->texture, r->radiance, r->wide_px, r->high_px, 0, length_of(r->across) / length_of(r->up)};
    double       normal[3], area = area_of(r, normal);
    if (!count || count > VXS_VPLS_MAX || (unsigned)places > VXS_AREA_JITTERED || !(area > 0)) return VXS_E_ARGUMENT;
    if (!vxs_area_is_number(r->corner, -INFINITY) || !vxs_area_is_number(r->radiance, 0)) return VXS_E_ARGUMENT;
    if (r->texture && (!r->wide_px || !r->high_px)) return VXS_E_ARGUMENT;
    vxs_area_sites(&picture, places, seed, sites, count);
    for (uint32_t n = 0; n < count; n++) {
        const area_site *at = &sites[n];
        vpls[n]             = (vxs_vpl){.radius_metres = (float)sqrt(area / count / 3.14159265358979324)};
        for (int i = 0; i < 3; i++) {
            vpls[n].place[i]  = (float)((double)r->corner[i] + at->u * (double)r->across[i] + at->v * (double)r->up[i]);
            vpls[n].normal[i] = (float)normal[i];
            vpls[n].colour[i] = (float)((double)r->radiance[i] * at->light[i] * area / count);
        }
    }
    return VXS_OK;
}
