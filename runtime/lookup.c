/* Lookups of a point or a texel; see vxs.h and vxs_query.h. The computations are those of formats/vxs_space.h, in double.
 * SPDX-License-Identifier: MIT */
#include <math.h>
#include <string.h>

#define VXS_WALKS_HERE
#include "taps_many.h"
#include "vxs_query.h"
#include "vxs_smoke.h"
#include "vxs_space.h"

/* points ------------------------------------------------------------------------------------------------------------------------ */

static const double zero[3] = {0, 0, 0}; /* no normal; also the origin of the world */

int vxs_voxel(const vxs_light *light, const double point_ws[3], const double normal_ws[3], vxs_filter filter, int32_t voxel[3])
{
    return vxs_voxel_from_ws(light, point_ws, normal_ws ? normal_ws : zero, filter, voxel);
}

void vxs_point(const vxs_light *light, int map, const double coordinates[3], double point_ws[3])
{
    int last = (int)vxs_map_count(light) - 1;
    vxs_ws_from_voxel(light, map < 0 ? 0 : map < last ? map : last, coordinates, point_ws);
}

float vxs_lookup(const vxs_baked_light *baked, const double point_ws[3], const double normal_ws[3], vxs_filter filter)
{
    return (float)vxs_lit(baked->words, &baked->light, point_ws, normal_ws ? normal_ws : zero, filter);
}

int vxs_lookup_is_full(const vxs_baked_light *baked, const double point_ws[3], const double normal_ws[3], vxs_filter filter)
{
    return vxs_lit_is_full(baked->words, &baked->light, point_ws, normal_ws ? normal_ws : zero, filter);
}

void vxs_lookup_many(const vxs_baked_light *baked, const double *points_ws, const double *normals_ws, size_t count,
                     vxs_filter filter, float *lit)
{
    vxs_lookup_batch(
        baked, 1,
        &(vxs_batch){
            .points_ws = {.data = points_ws}, .normals_ws = {.data = normals_ws}, .count = count, .filter = filter, .lit = lit});
}

float vxs_smoke_lookup(const vxs_light *light, const vxs_baked_smoke *smoke, const double point_ws[3])
{
    return smoke ? (float)vxs_smoke_left(smoke->words, light, point_ws) : 1;
}

/* constants --------------------------------------------------------------------------------------------------------------------- */

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

/* first shadowed voxel of a texel: palette blocks contain it; in a DAG the column is walked ------------------------------------- */

int32_t vxs_first_shadow(const vxs_baked_light *baked, int map, int32_t i, int32_t j, int *coarse)
{
    int32_t depth[64], side = 1 << baked->light.levels, n = (i & 7) + 8 * (j & 7);
    if (coarse) *coarse = 0;
    if (map < 0 || map >= (int)vxs_map_count(&baked->light) || i < 0 || j < 0 || i >= side || j >= side) return -1;
    if (baked->light.coding == VXS_CODING_BLOCKS) {
        vxs_depth_square s = vxs_depth_square_at((vxs_blocks_map){baked->words, (uint32_t)map, baked->light.levels}, i, j, -1, 1);
        if (coarse) *coarse = s.coarse && s.low < s.high;
        return s.least;
    }
    vxs_dag_first_shadows(baked, (uint32_t)map, (uint32_t)i >> 3, (uint32_t)j >> 3, (uint64_t)1 << n, depth);
    return depth[n];
}
