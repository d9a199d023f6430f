/* Lookups of world-space points; see vxs.h.
 * Source: [CPVS16] 5.
 * SPDX-License-Identifier: MIT */
#include <float.h>
#include <math.h>
#include <string.h>

#include "vxs.h"
#include "vxs_cube.h"
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

/* A point or a way, by the rows of ls_from_ws; `one` is 1 for a point. */
static void ls_from_ws(const vxs_light *light, const double ws[3], double one, double ls[3])
{
    for (int row = 0; row < 3; row++) {
        const double *m = light->ls_from_ws + 4 * row;
        ls[row]         = m[0] * ws[0] + m[1] * ws[1] + m[2] * ws[2] + m[3] * one;
    }
}

static int cube_map(const double ls[3])
{
    int along = fabs(ls[1]) > fabs(ls[0]) ? 1 : 0;
    if (fabs(ls[2]) > fabs(ls[along])) along = 2;
    return 2 * along + (ls[along] < 0);
}

/* Light space as one of the light's maps sees it: across, down, and away from the light. */
static void turn_to_map(const vxs_light *light, int map, const double ls[3], double out[3])
{
    vxs_map_axes axes = vxs_axes_of_map(light, map);
    out[0]            = ls[axes.u];
    out[1]            = ls[axes.v];
    out[2]            = ls[axes.along] * axes.sign;
}

static void turn_from_map(const vxs_light *light, int map, const double in[3], double ls[3])
{
    vxs_map_axes axes = vxs_axes_of_map(light, map);
    ls[axes.u]        = in[0];
    ls[axes.v]        = in[1];
    ls[axes.along]    = in[2] * axes.sign;
}

static int sun_voxel(const vxs_light *light, const double point_ws[3], const double normal_ws[3], int filter_px, int32_t voxel[3])
{
    double at[3], step[3] = {0, 0, 0};
    ls_from_ws(light, point_ws, 1, at);
    if (normal_ws) ls_from_ws(light, normal_ws, 0, step);
    for (int n = 0; n < 3; n++) voxel[n] = clamped(floor(at[n]) + away_from_zero(step[n] * light->texel_metres * 0.5 * filter_px));

    int32_t side = (int32_t)1 << light->levels;
    if (voxel[0] < 0 || voxel[1] < 0 || voxel[0] >= side || voxel[1] >= side) return -1;
    return (light->flags & VXS_LIGHT_BOUNDED) && (voxel[2] < 0 || voxel[2] >= side) ? -1 : 0;
}

/* In the cone and range of a spot or point light; what is not a number is nowhere. */
static int in_reach(const vxs_light *light, const double ls[3])
{
    double distance2 = ls[0] * ls[0] + ls[1] * ls[1] + ls[2] * ls[2];
    if (!(distance2 >= 0)) return 0;
    if (light->range_metres > 0 && distance2 > light->range_metres * light->range_metres) return 0;
    return light->kind == VXS_LIGHT_KIND_POINT || ls[2] >= light->cos_outer * sqrt(distance2);
}

/* Into the map: a step along a normal leaves one of fewer than 256 texels, which has too narrow a border for it. */
static int32_t within(int32_t texel, int32_t side)
{
    return texel < 0 ? 0 : texel < side ? texel : side - 1;
}

/* Where the axis is z and a point lies at (x, y, z), texels are z * texel_metres wide: the paper's half filter along the normal n is a
 * step of filter / 2 times (nx - nz x / z) texels in u, and of as many voxels along as it is metres. */
static int lamp_voxel(const vxs_light *light, const double point_ws[3], const double normal_ws[3], int filter_px, int32_t voxel[3])
{
    double ls[3], normal_ls[3], p[3], n[3] = {0, 0, 0};
    ls_from_ws(light, point_ws, 1, ls);
    int map = light->flags & VXS_LIGHT_CUBE ? cube_map(ls) : 0;
    turn_to_map(light, map, ls, p);
    if (normal_ws) {
        ls_from_ws(light, normal_ws, 0, normal_ls);
        turn_to_map(light, map, normal_ls, n);
    }
    double  z    = p[2] > DBL_MIN ? p[2] : DBL_MIN; /* the light's own place is lit */
    double  half = 0.5 * filter_px;
    int32_t side = (int32_t)1 << light->levels;
    for (int c = 0; c < 2; c++) {
        double texel = floor(0.5 * side + p[c] / z / light->texel_metres);
        voxel[c]     = within(clamped(texel + away_from_zero(half * (n[c] - n[2] * p[c] / z))), side);
    }
    double depth = floor(log(z / light->near_metres) / light->voxel_metres);
    voxel[2]     = clamped(depth + away_from_zero(half * n[2] * light->texel_metres / light->voxel_metres));
    return in_reach(light, ls) ? map : -1;
}

int vxs_voxel(const vxs_light *light, const double point_ws[3], const double normal_ws[3], int filter_px, int32_t voxel[3])
{
    int sun = light->kind == VXS_LIGHT_KIND_DIRECTIONAL;
    return sun ? sun_voxel(light, point_ws, normal_ws, filter_px, voxel) : lamp_voxel(light, point_ws, normal_ws, filter_px, voxel);
}

void vxs_point(const vxs_light *light, int map, const double at[3], double point_ws[3])
{
    const double *m = light->ls_from_ws;
    double        ls[3], from[3], cofactor[3][3];
    memcpy(ls, at, sizeof ls);
    if (light->kind != VXS_LIGHT_KIND_DIRECTIONAL) {
        double z = light->near_metres * exp(at[2] * light->voxel_metres), half = ldexp(0.5, (int)light->levels);
        double p[3] = {(at[0] - half) * light->texel_metres * z, (at[1] - half) * light->texel_metres * z, z};
        turn_from_map(light, map, p, ls);
    }
    for (int row = 0; row < 3; row++) {
        const double *a = m + 4 * ((row + 1) % 3), *b = m + 4 * ((row + 2) % 3);
        for (int c = 0; c < 3; c++) cofactor[row][c] = a[(c + 1) % 3] * b[(c + 2) % 3] - a[(c + 2) % 3] * b[(c + 1) % 3];
        from[row] = ls[row] - m[4 * row + 3];
    }
    double determinant = m[0] * cofactor[0][0] + m[1] * cofactor[0][1] + m[2] * cofactor[0][2];
    for (int c = 0; c < 3; c++)
        point_ws[c] = (from[0] * cofactor[0][c] + from[1] * cofactor[1][c] + from[2] * cofactor[2][c]) / determinant;
}

float vxs_lookup(const vxs_baked_light *baked, const double point_ws[3], const double normal_ws[3], int filter_px)
{
    const vxs_light *light = &baked->light;
    const uint32_t  *words = baked->dag.words;
    int32_t          voxel[3];
    int32_t          side = (int32_t)1 << light->levels;
    int              map  = vxs_voxel(light, point_ws, normal_ws, filter_px, voxel);
    if (map < 0) return VXS_OUTSIDE;
    if (voxel[2] < 0) return 1.0f;

    uint32_t root = light->flags & VXS_LIGHT_CUBE ? vxs_face_root(words, (uint32_t)map) : 0;
    uint32_t k    = (uint32_t)(voxel[2] < side ? voxel[2] : side - 1);
    if (filter_px == 1) return vxs_shadow(words, root, light->levels, (uint32_t)voxel[0], (uint32_t)voxel[1], k) ? 0.0f : 1.0f;
    uint32_t dark = vxs_shadow_count(words, root, light->levels, voxel[0], voxel[1], k, filter_px);
    uint32_t taps = (uint32_t)(filter_px * filter_px);
    return (float)(taps - dark) / (float)taps;
}

void vxs_lookup_many(const vxs_baked_light *baked, const double *points_ws, const double *normals_ws, size_t count, int filter_px,
                     float *lit)
{
    for (size_t n = 0; n < count; n++)
        lit[n] = vxs_lookup(baked, points_ws + 3 * n, normals_ws ? normals_ws + 3 * n : NULL, filter_px);
}
