/* The columns of a planned light; see light_columns.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/bake/light_columns.h"

#include <stdlib.h>
#include <string.h>

static vxs_result take_depths(void *user, uint32_t map, uint32_t i, uint32_t j, const rendered_tile *tile, bake_context *ctx)
{
    light_columns *c = user;
    if (!c->picture) return VXS_OK;
    stage_begin(ctx, STAGE_PICTURE);
    light_picture_add_depths(c->picture, tile, map, i, j, ctx->threads);
    stage_begin(ctx, STAGE_NONE);
    return VXS_OK;
}

void light_columns_init(light_columns *c, void *device, const bake_options *o, const bake_plan *plan, const plan_light *planned,
                        const casters *all, light_picture *picture)
{
    memset(c, 0, sizeof *c);
    c->maps       = o->maps;
    c->renderer   = o->renderer;
    c->picture    = picture;
    uint32_t tile = min_u32(1u << planned->light.levels, plan->tile_px);
    c->rendered   = (rendered_columns){.device       = device,
                                       .casters      = all,
                                       .light        = &planned->light,
                                       .exit         = plan->peels_all ? EXIT_PEEL : o->exit,
                                       .has_exit_map = plan->has_exit_map,
                                       .tile_px      = tile,
                                       .watch        = take_depths,
                                       .watch_user   = c};
    c->sparse     = (sparse_columns){.casters          = all,
                                     .light            = &planned->light,
                                     .free_behind      = o->behind == BEHIND_FREE,
                                     .thickness_metres = o->thickness_metres,
                                     .nearest_back     = o->exit == EXIT_BACK,
                                     .fetch_px         = tile};
}

column_source light_columns_source(light_columns *c)
{
    return c->maps == MAPS_SPARSE ? sparse_columns_source(&c->sparse) : c->renderer->source(&c->rendered);
}

vxs_result light_columns_draw(const light_columns *c, light_picture *picture, bake_context *ctx)
{
    const uint32_t depth_vx = 1u << 16, side = light_picture_enter_px(picture);
    if (c->maps != MAPS_SPARSE) return VXS_OK;
    uint32_t  *enter = malloc((size_t)side * side * sizeof *enter);
    vxs_result r     = enter ? VXS_OK : fail(ctx->run, VXS_E_MEMORY, "out of memory for a picture of %u x %u pixels", side, side);
    stage_begin(ctx, STAGE_PICTURE);
    for (uint32_t map = 0; map < picture->map_count && r == VXS_OK; map++) {
        r = sparse_columns_enter(&c->sparse, map, side, depth_vx, enter, ctx);
        if (r == VXS_OK) light_picture_add_enter(picture, enter, side, depth_vx, map);
    }
    stage_begin(ctx, STAGE_NONE);
    free(enter);
    return r;
}

void light_columns_free(light_columns *c)
{
    if (c->renderer) c->renderer->free(&c->rendered);
    memset(c, 0, sizeof *c);
}
