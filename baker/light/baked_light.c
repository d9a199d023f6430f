/* Shape of a baked light; see baked_light.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/light/baked_light.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "baker/base/vec3.h"
#include "runtime/vxs.h"

light_shape baked_light_shape(const vxs_light *light)
{
    light_shape shape = {.kind = LIGHT_DIRECTIONAL, .range_m = INFINITY};
    memcpy(shape.direction_ws, light->direction_ws, sizeof shape.direction_ws);
    if (light->kind == VXS_LIGHT_KIND_DIRECTIONAL) return shape;

    shape.kind      = light->kind == VXS_LIGHT_KIND_SPOT ? LIGHT_SPOT : LIGHT_POINT;
    shape.outer_rad = acos(light->cos_outer);
    if (light->range_metres > 0) shape.range_m = light->range_metres;
    /* the pyramid of a map ends at the light, where log depth is -infinity */
    double middle = ldexp(0.5, (int)light->levels);
    vxs_point(light, 0, (double[]){middle, middle, -INFINITY}, shape.position_ws);
    return shape;
}

/* A point in metres across, down and away from the light, along the axes of a map. The axes are found with a copy of the light
 * whose light space is world space. */
static void map_from_ws(const vxs_light *light, int map, const double point_ws[3], double out[3])
{
    vxs_light plain    = *light;
    double    half     = ldexp(0.5, (int)light->levels), ls[3];
    double    one      = -log(light->near_metres) / light->voxel_metres; /* depth at one metre */
    double    texels   = 1 / light->texel_metres;                        /* per metre, at that depth */
    double    at[3][3] = {{half + texels, half, one}, {half, half + texels, one}, {half, half, one}}, axis[3][3];
    memcpy(plain.ls_from_ws, (double[12]){1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}, sizeof plain.ls_from_ws);
    for (int row = 0; row < 3; row++) {
        const double *m = light->ls_from_ws + 4 * row;
        ls[row]         = vec3_dot(m, point_ws) + m[3];
        vxs_point(&plain, map, at[row], axis[row]);
    }
    for (int row = 0; row < 3; row++) {
        for (int k = 0; k < 3 && row < 2; k++) axis[row][k] -= axis[2][k];
        for (int k = 0; k < 3; k++) axis[row][k] = round(axis[row][k]); /* they are axes of light space */
        out[row] = vec3_dot(axis[row], ls);
    }
}

void baked_light_coordinates(const vxs_light *light, int map, const double point_ws[3], double coordinates[3])
{
    if (light->kind == VXS_LIGHT_KIND_DIRECTIONAL) {
        for (int row = 0; row < 3; row++)
            coordinates[row] = vec3_dot(light->ls_from_ws + 4 * row, point_ws) + light->ls_from_ws[4 * row + 3];
        return;
    }
    double p[3];
    map_from_ws(light, map, point_ws, p);
    double z = fmax(p[2], DBL_MIN);
    for (int i = 0; i < 2; i++) coordinates[i] = ldexp(0.5, (int)light->levels) + p[i] / z / light->texel_metres;
    coordinates[2] = log(z / light->near_metres) / light->voxel_metres;
}
