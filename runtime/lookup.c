/* Lookups of world-space points; see vxs.h. The computation is that of formats/vxs_space.h, in double.
 * SPDX-License-Identifier: MIT */
#include "vxs_query.h"
#include "vxs_smoke.h"
#include "vxs_space.h"

static const double zero[3] = {0, 0, 0}; /* no normal; also the origin of the world */

int vxs_voxel(const vxs_light *light, const double point_ws[3], const double normal_ws[3], int filter_px, int32_t voxel[3])
{
    return vxs_voxel_from_ws(light, point_ws, normal_ws ? normal_ws : zero, filter_px, voxel);
}

void vxs_point(const vxs_light *light, int map, const double coordinates[3], double point_ws[3])
{
    int last = (int)vxs_map_count(light) - 1;
    vxs_ws_from_voxel(light, map < 0 ? 0 : map < last ? map : last, coordinates, point_ws);
}

float vxs_lookup(const vxs_baked_light *baked, const double point_ws[3], const double normal_ws[3], int filter_px)
{
    return (float)vxs_lit(baked->words, &baked->light, point_ws, normal_ws ? normal_ws : zero, filter_px);
}

int vxs_lookup_is_full(const vxs_baked_light *baked, const double point_ws[3], const double normal_ws[3], int filter_px)
{
    return vxs_lit_is_full(baked->words, &baked->light, point_ws, normal_ws ? normal_ws : zero, filter_px);
}

void vxs_lookup_many(const vxs_baked_light *baked, const double *points_ws, const double *normals_ws, size_t count, int filter_px,
                     float *lit)
{
    vxs_lookup_batch(baked, 1,
                     &(vxs_batch){.points_ws  = {.data = points_ws},
                                  .normals_ws = {.data = normals_ws},
                                  .count      = count,
                                  .filter_px  = filter_px,
                                  .lit        = lit});
}

float vxs_smoke_lookup(const vxs_light *light, const vxs_baked_smoke *smoke, const double point_ws[3])
{
    return smoke ? (float)vxs_smoke_left(smoke->words, light, point_ws) : 1;
}

/* Rounding error of (float)x in 2^-20, as 16 signed bits, clamped. 16 bits are enough for |x| below 2^19. */
static uint32_t rest_of(double x)
{
    return (uint32_t)lround(fmin(fmax((x - (double)(float)x) * 0x1p20, -32768), 32767)) & 0xffffu;
}

vxs_light_constants vxs_light_constants_of(const vxs_light *light, const double origin_ws[3], uint32_t first_word)
{
    vxs_light_constants c = {
        .texel_metres = (float)light->texel_metres,
        .voxel_metres = (float)light->voxel_metres,
        .near_metres  = (float)light->near_metres,
        .range_metres = (float)light->range_metres,
        .cos_outer    = (float)light->cos_outer,
        .kind         = light->kind,
        .flags        = light->flags,
        .levels       = light->levels,
        .first_word   = first_word,
        .coding       = light->coding,
    };
    double at_origin[3];
    vxs_ls_from_ws(light, origin_ws ? origin_ws : zero, 1, at_origin);
    for (int row = 0; row < 3; row++) {
        const double *m = light->ls_from_ws + 4 * row;
        for (int column = 0; column < 3; column++) c.ls_from_ws[4 * row + column] = (float)m[column];
        c.ls_from_ws[4 * row + 3] = (float)at_origin[row];
    }
    if (light->kind != VXS_LIGHT_KIND_DIRECTIONAL) return c;
    c.origin_fraction_ij = rest_of(at_origin[0]) | rest_of(at_origin[1]) << 16;
    c.origin_fraction_k  = rest_of(at_origin[2]);
    return c;
}
