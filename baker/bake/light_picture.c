/* Pictures of a light's maps; see light_picture.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/bake/light_picture.h"

#include <stdlib.h>
#include <string.h>

#include "baker/base/integer.h"
#include "baker/base/parallel.h"

enum { SAMPLES = 4 }; /* along a side of a pixel */

static uint32_t side_of(uint32_t map_px, uint32_t map_count)
{
    return min_u32(map_px, map_count > 1 ? CUBE_PICTURE_MAX_PX : PICTURE_MAX_PX);
}

static uint32_t mask_side_of(uint32_t map_px, uint32_t map_count)
{
    return min_u32(map_px / 8, side_of(map_px, map_count));
}

uint64_t light_picture_bytes(uint32_t map_px, uint32_t map_count)
{
    uint64_t side = side_of(map_px, map_count), masks = mask_side_of(map_px, map_count);
    return map_count * (sizeof(uint16_t) * side * side + masks * masks);
}

vxs_result light_picture_init(light_picture *p, uint32_t light, uint32_t map_px, uint32_t map_count, run_context *m)
{
    *p            = (light_picture){.light     = light,
                                    .map_count = map_count,
                                    .map_px    = map_px,
                                    .side_px   = side_of(map_px, map_count),
                                    .mask_px   = mask_side_of(map_px, map_count)};
    size_t depths = (size_t)map_count * p->side_px * p->side_px;
    p->mask_tiles = (map_px / 8 / p->mask_px) * (map_px / 8 / p->mask_px);
    p->depth      = malloc(depths * sizeof *p->depth);
    p->masks      = calloc((size_t)map_count * p->mask_px * p->mask_px, sizeof *p->masks);
    if (!p->depth || !p->masks) {
        light_picture_free(p);
        return fail(m, VXS_E_MEMORY, "out of memory for a picture of %u x %u pixels", map_px, map_px);
    }
    memset(p->depth, 0xff, depths * sizeof *p->depth);
    return VXS_OK;
}

void light_picture_free(light_picture *p)
{
    free(p->depth);
    free(p->masks);
    *p = (light_picture){0};
}

typedef struct depth_job {
    light_picture       *p;
    const rendered_tile *tile;
    uint16_t            *corner; /* position of the tile in the picture */
    uint32_t             pixel;  /* texels a side */
} depth_job;

/* Mean depth of the samples with a caster, if they are at least half.   sum  of their depths, shares of the whole */
static uint16_t mean_depth(double sum, uint32_t seen, uint32_t all)
{
    return 2 * seen < all ? PICTURE_NO_CASTER : (uint16_t)(sum / seen * (PICTURE_NO_CASTER - 1));
}

static uint16_t depth_of_pixel(const depth_job *job, size_t x, size_t y)
{
    uint32_t     step = job->pixel > SAMPLES ? job->pixel / SAMPLES : 1, seen = 0, all = 0;
    const float *corner = job->tile->enter + y * job->pixel * job->tile->side_px + x * job->pixel;
    double       sum    = 0;
    for (uint32_t v = step / 2; v < job->pixel; v += step)
        for (uint32_t u = step / 2; u < job->pixel; u += step, all++) {
            double voxels = depth_in_voxels(job->tile->scale, (double)corner[(size_t)v * job->tile->side_px + u]);
            if (voxels >= job->tile->scale.depth_vx) continue;
            sum += voxels;
            seen++;
        }
    return mean_depth(sum / job->tile->scale.depth_vx, seen, all);
}

static void depth_rows(void *user, size_t begin, size_t end, uint32_t worker)
{
    const depth_job *job = user;
    (void)worker;
    for (size_t y = begin; y < end; y++)
        for (size_t x = 0; x < job->tile->side_px / job->pixel; x++)
            job->corner[y * job->p->side_px + x] = depth_of_pixel(job, x, y);
}

void light_picture_add_depths(light_picture *p, const rendered_tile *tile, uint32_t map, uint32_t i, uint32_t j, uint32_t threads)
{
    uint32_t  pixel = p->map_px / p->side_px, side = tile->side_px / pixel;
    uint16_t *picture = p->depth + (size_t)map * p->side_px * p->side_px;
    depth_job job     = {p, tile, picture + (size_t)j * side * p->side_px + (size_t)i * side, pixel};
    parallel_for(threads, side, 8, depth_rows, &job);
}

uint32_t light_picture_enter_px(const light_picture *p)
{
    return min_u32(p->map_px, 2 * p->side_px);
}

void light_picture_add_enter(light_picture *p, const uint32_t *enter, uint32_t side_px, uint32_t depth_vx, uint32_t map)
{
    uint32_t  pixel   = side_px / p->side_px;
    uint16_t *picture = p->depth + (size_t)map * p->side_px * p->side_px;
    for (size_t n = 0; n < (size_t)p->side_px * p->side_px; n++) {
        const uint32_t *corner = enter + n / p->side_px * pixel * side_px + n % p->side_px * pixel;
        double          sum    = 0;
        uint32_t        seen   = 0;
        for (uint32_t k = 0; k < pixel * pixel; k++) {
            uint32_t depth = corner[(size_t)(k / pixel) * side_px + k % pixel];
            if (depth >= depth_vx) continue;
            sum += depth;
            seen++;
        }
        picture[n] = mean_depth(sum / depth_vx, seen, pixel * pixel);
    }
}

void light_picture_add_masks(light_picture *p, const column_tree *tree, uint32_t map)
{
    uint32_t pixel = p->map_px / 8 / p->mask_px; /* tiles along a side of a pixel */
    uint32_t x = tree->columns->u_px / 8, y = tree->columns->v_px / 8;
    uint8_t *picture = p->masks + (size_t)map * p->mask_px * p->mask_px;
    for (size_t n = 0; n < tree->tile_count; n++) {
        const tree_tile *t    = &tree->tiles[n];
        uint8_t         *most = &picture[(size_t)((y + t->y) / pixel) * p->mask_px + (x + t->x) / pixel];
        if (t->end - t->first > *most) *most = (uint8_t)(t->end - t->first); /* 64 at most */
    }
}
