/* Lookups of world-space points; see vxs.h.
 * Source: [CPVS16] 5.
 * SPDX-License-Identifier: MIT */
#include <math.h>

#include "vxs.h"
#include "vxs_lookup.h"

/* As an integer; what is clamped lies far outside any map, and stays there. */
static int32_t clamped(double coordinate)
{
    const double limit = 1 << 30;
    if (!(coordinate > -limit)) return -(1 << 30);
    return coordinate < limit ? (int32_t)coordinate : 1 << 30;
}

/* Away from zero, so that a step too short to leave the voxel of the surface still leaves it. Rounding noise is no step. */
static double away_from_zero(double step)
{
    const double noise = 1e-6;
    if (fabs(step) < noise) return 0;
    return step > 0 ? ceil(step - noise) : floor(step + noise);
}

void vxs_voxel(const vxs_light *light, const double point_ws[3], const double normal_ws[3], int filter_px, int32_t voxel[3])
{
    for (int row = 0; row < 3; row++) {
        const double *m          = light->ls_from_ws + 4 * row;
        double        coordinate = floor(m[0] * point_ws[0] + m[1] * point_ws[1] + m[2] * point_ws[2] + m[3]);
        if (normal_ws) {
            double along = m[0] * normal_ws[0] + m[1] * normal_ws[1] + m[2] * normal_ws[2];
            coordinate += away_from_zero(along * light->texel_metres * 0.5 * filter_px);
        }
        voxel[row] = clamped(coordinate);
    }
}

float vxs_lookup(const vxs_light *light, const double point_ws[3], const double normal_ws[3], int filter_px)
{
    int32_t voxel[3];
    int32_t side = 1 << light->levels;
    vxs_voxel(light, point_ws, normal_ws, filter_px, voxel);
    if (voxel[0] < 0 || voxel[1] < 0 || voxel[0] >= side || voxel[1] >= side) return VXS_OUTSIDE;
    if ((light->flags & VXS_LIGHT_BOUNDED) && (voxel[2] < 0 || voxel[2] >= side)) return VXS_OUTSIDE;
    if (voxel[2] < 0) return 1.0f;

    uint32_t k = (uint32_t)(voxel[2] < side ? voxel[2] : side - 1);
    if (filter_px == 1) return vxs_shadow(light->words, 0, light->levels, (uint32_t)voxel[0], (uint32_t)voxel[1], k) ? 0.0f : 1.0f;
    uint32_t dark = vxs_shadow_count(light->words, 0, light->levels, voxel[0], voxel[1], k, filter_px);
    uint32_t taps = (uint32_t)(filter_px * filter_px);
    return (float)(taps - dark) / (float)taps;
}

void vxs_lookup_many(const vxs_light *light, const double *points_ws, const double *normals_ws, size_t count, int filter_px,
                     float *lit)
{
    for (size_t n = 0; n < count; n++)
        lit[n] = vxs_lookup(light, points_ws + 3 * n, normals_ws ? normals_ws + 3 * n : NULL, filter_px);
}
