/* Depth maps, their pyramid and their columns; see depth_maps.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/opengl/depth_maps.h"

#include <stdlib.h>
#include <string.h>

#include "baker/base/pages.h"
#include "baker/base/parallel.h"
#include "baker/base/simd.h"
#include "baker/columns/columns.h"

vxs_result depth_maps_init(depth_maps *d, uint32_t side_px, uint32_t depth_vx, double voxel_log, int with_exit, run_context *m)
{
    memset(d, 0, sizeof *d);
    d->side_px   = side_px;
    d->depth_vx  = depth_vx;
    d->voxel_log = voxel_log;

    size_t texels = (size_t)side_px * side_px;
    d->enter      = pages_alloc(texels * sizeof *d->enter);
    d->exit       = with_exit ? pages_alloc(texels * sizeof *d->exit) : d->enter;

    size_t squares = 0;
    for (uint32_t side = side_px / 8; side; side /= 2) squares += (size_t)side * side;
    d->pyramid[0] = pages_alloc(squares * sizeof *d->pyramid[0]);
    if (!d->enter || !d->exit || !d->pyramid[0]) {
        depth_maps_free(d);
        return fail(m, VXS_E_MEMORY, "out of memory for depth maps of %u x %u texels", side_px, side_px);
    }
    for (uint32_t side = side_px / 8; side; side /= 2) {
        uint32_t l = d->pyramid_levels++;
        if (side > 1) d->pyramid[l + 1] = d->pyramid[l] + (size_t)side * side;
    }
    return VXS_OK;
}

void depth_maps_free(depth_maps *d)
{
    if (d->exit != d->enter) free(d->exit);
    free(d->enter);
    free(d->pyramid[0]);
    memset(d, 0, sizeof *d);
}

static uint32_t voxels_down(const depth_maps *d, float depth)
{
    return depth_down((depth_scale){d->depth_vx, d->voxel_log}, (double)depth);
}

static uint32_t voxels_up(const depth_maps *d, float depth)
{
    return depth_up((depth_scale){d->depth_vx, d->voxel_log}, (double)depth);
}

/* Level 0 of the pyramid, rows [begin, end) of tiles. Rounding is monotonic, so minimum and maximum are taken of floats. */
static void reduce_tiles(void *user, size_t begin, size_t end, uint32_t worker)
{
    depth_maps *d     = user;
    uint32_t    tiles = d->side_px / 8;
    (void)worker;
    for (size_t j = begin; j < end; j++)
        for (uint32_t i = 0; i < tiles; i++) {
            const float *e = d->enter + j * 8 * d->side_px + i * 8;
            const float *x = d->exit + j * 8 * d->side_px + i * 8;

            float emin[8], emax[8], xmin[8], xmax[8];
            for (int n = 0; n < 8; n++) emin[n] = xmin[n] = 2.0f, emax[n] = xmax[n] = -2.0f;
            for (int row = 0; row < 8; row++, e += d->side_px, x += d->side_px)
                for (int n = 0; n < 8; n++) {
                    emin[n] = e[n] < emin[n] ? e[n] : emin[n];
                    emax[n] = e[n] > emax[n] ? e[n] : emax[n];
                    xmin[n] = x[n] < xmin[n] ? x[n] : xmin[n];
                    xmax[n] = x[n] > xmax[n] ? x[n] : xmax[n];
                }
            for (int n = 1; n < 8; n++) {
                emin[0] = emin[n] < emin[0] ? emin[n] : emin[0];
                emax[0] = emax[n] > emax[0] ? emax[n] : emax[0];
                xmin[0] = xmin[n] < xmin[0] ? xmin[n] : xmin[0];
                xmax[0] = xmax[n] > xmax[0] ? xmax[n] : xmax[0];
            }
            d->pyramid[0][j * tiles + i] =
                (column_bounds){voxels_down(d, emin[0]), voxels_down(d, emax[0]), voxels_up(d, xmin[0]), voxels_up(d, xmax[0])};
        }
}

void depth_maps_reduce(depth_maps *d, uint32_t threads)
{
    parallel_for(threads, d->side_px / 8, 4, reduce_tiles, d);
    bounds_pyramid_reduce(d->pyramid, d->side_px / 8, threads);
}

static vxs_result maps_bounds(void *data, uint32_t level, uint32_t i, uint32_t j, column_bounds *out)
{
    const depth_maps *d = data;
    *out                = d->pyramid[level][(size_t)j * (d->side_px >> (3 + level)) + i];
    return VXS_OK;
}

static void four_up(const depth_maps *d, const float *depths, uint32_t *to)
{
    f32x4 voxels = f32x4_load(depths) * (float)d->depth_vx;
    i32x4 up     = __builtin_convertvector(voxels, i32x4);
    up -= (i32x4)(__builtin_convertvector(up, f32x4) < voxels);
    memcpy(to, &up, sizeof up);
}

static vxs_result maps_tile(void *data, uint32_t i, uint32_t j, column_tile *out)
{
    const depth_maps *d = data;
    const float      *e = d->enter + (size_t)j * 8 * d->side_px + i * 8;
    const float      *x = d->exit + (size_t)j * 8 * d->side_px + i * 8;
    for (int row = 0; row < 8; row++, e += d->side_px, x += d->side_px)
        for (int n = 0; n < 8; n += 4) {
            uint32_t *to_e = out->e + row * 8 + n, *to_x = out->x + row * 8 + n;
            if (d->voxel_log == 0) {
                /* voxels_down and voxels_up for four linear depths at once; this is exact in float, too. */
                i32x4 down = __builtin_convertvector(f32x4_load(e + n) * (float)d->depth_vx, i32x4);
                memcpy(to_e, &down, sizeof down);
                four_up(d, x + n, to_x);
                continue;
            }
            for (int m = 0; m < 4; m++) {
                to_e[m] = voxels_down(d, e[n + m]);
                to_x[m] = voxels_up(d, x[n + m]);
            }
        }
    return VXS_OK;
}

column_square depth_maps_square(const depth_maps *d)
{
    return (column_square){
        .data = (void *)d, .side_px = d->side_px, .depth_vx = d->depth_vx, .bounds = maps_bounds, .tile = maps_tile};
}
