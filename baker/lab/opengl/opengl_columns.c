/* Rendered columns; see opengl_columns.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/opengl/opengl_columns.h"

#include <stdlib.h>
#include <string.h>

typedef struct opengl_map {
    rendered_columns *owner;
    depth_renderer   *renderer;
    depth_maps       *maps; /* of the tile that was rendered last */
    uint32_t          map;
    bake_context     *ctx; /* while a tile is rendered */
} opengl_map;

static vxs_result map_bounds(void *data, uint32_t level, uint32_t i, uint32_t j, column_bounds *out)
{
    const opengl_map *o     = data;
    uint32_t          depth = o->maps->depth_vx;
    *out = depth_renderer_has_casters(o->renderer, 8u << level, i, j) ? bounds_unknown(depth) : bounds_empty(depth);
    return VXS_OK;
}

static void show_part(void *user, double share)
{
    opengl_map *o = user;
    step_part(o->ctx, share);
}

static vxs_result map_fetch(void *data, uint32_t level, uint32_t i, uint32_t j, column_square *out, bake_context *ctx)
{
    opengl_map *o = data;
    vxs_result  r;
    *out = (column_square){0};
    if (8u << level != o->maps->side_px) return VXS_E_ARGUMENT;
    o->ctx = ctx;
    stage_begin(ctx, STAGE_MAPS);
    if ((r = depth_renderer_tile(o->renderer, o->maps, i, j, ctx->message)) != VXS_OK) return r;
    stage_begin(ctx, STAGE_PYRAMID);
    depth_maps_reduce(o->maps, ctx->threads);
    stage_begin(ctx, STAGE_NONE);
    if (o->owner->watch && (r = o->owner->watch(o->owner->watch_user, o->map, i, j, o->maps, ctx)) != VXS_OK) return r;
    *out      = depth_maps_square(o->maps);
    out->u_px = i * out->side_px;
    out->v_px = j * out->side_px;
    return r;
}

static void map_release(void *data, column_square *square)
{
    (void)data;
    *square = (column_square){0};
}

static void add_stats(depth_stats *sum, depth_stats s)
{
    sum->blocks_rendered += s.blocks_rendered;
    sum->blocks_empty += s.blocks_empty;
    sum->blocks_peeled += s.blocks_peeled;
    sum->blocks_not_peeled += s.blocks_not_peeled;
    sum->triangles_drawn += s.triangles_drawn;
    sum->peel_passes += s.peel_passes;
    if (s.peel_passes_max > sum->peel_passes_max) sum->peel_passes_max = s.peel_passes_max;
}

static void map_close(void *data)
{
    opengl_map *o = data;
    if (o->renderer) add_stats(&o->owner->stats, depth_renderer_stats(o->renderer));
    depth_renderer_destroy(o->renderer);
    opengl_columns_free(o->owner);
    o->owner->spare = o->maps;
    free(o);
}

/* Reuse the memory of the previous map, or allocate it. */
static vxs_result take_maps(opengl_map *o, uint32_t tile_px, uint32_t side_px, message *m)
{
    rendered_columns *owner = o->owner;
    int               lamp  = owner->light->kind != VXS_LIGHT_KIND_DIRECTIONAL;
    o->maps                 = owner->spare;
    owner->spare            = NULL;
    if (o->maps && o->maps->enter) return VXS_OK;
    if (!o->maps && !(o->maps = calloc(1, sizeof *o->maps))) return fail(m, VXS_E_MEMORY, "out of memory for rendering depth maps");
    return depth_maps_init(o->maps, tile_px, side_px, lamp ? owner->light->voxel_metres : 0, owner->has_exit_map, m);
}

static vxs_result open_map(void *data, uint32_t map, column_map *out, bake_context *ctx)
{
    rendered_columns *owner = data;
    uint32_t          side = 1u << owner->light->levels, tile = min_u32(side, owner->tile_px);
    opengl_map       *o = calloc(1, sizeof *o);
    *out                = (column_map){0};
    if (!o) return fail(ctx->message, VXS_E_MEMORY, "out of memory for rendering depth maps");
    *o = (opengl_map){.owner = owner, .map = map};
    stage_begin(ctx, STAGE_GL);
    vxs_result r = take_maps(o, tile, side, ctx->message);
    if (r == VXS_OK)
        r = depth_renderer_create(&o->renderer, owner->device, owner->casters, owner->light, (int)map, owner->exit, ctx->threads,
                                  ctx->message);
    stage_begin(ctx, STAGE_NONE);
    if (r != VXS_OK) {
        map_close(o);
        return r;
    }
    depth_renderer_watch(o->renderer, show_part, o);
    *out = (column_map){.data     = o,
                        .side_px  = side,
                        .depth_vx = side,
                        .fetch_px = tile,
                        .bounds   = map_bounds,
                        .fetch    = map_fetch,
                        .release  = map_release,
                        .close    = map_close};
    return VXS_OK;
}

column_source opengl_columns_source(rendered_columns *c)
{
    return (column_source){.data = c, .map_count = vxs_map_count(c->light), .open = open_map};
}

void opengl_columns_free(rendered_columns *c)
{
    if (!c->spare) return;
    depth_maps_free(c->spare);
    free(c->spare);
    c->spare = NULL;
}

static vxs_result create_device(void **device, device_names *names, gl_backend backend, uint32_t threads, message *m)
{
    gl_context *gl;
    vxs_result  r = gl_context_create(&gl, backend, threads, m);
    *device       = gl;
    if (r != VXS_OK) return r;
    *names = gl->names;
    return r;
}

static void destroy_device(void *device)
{
    gl_context_destroy(device);
}

const column_renderer opengl_renderer = {create_device, destroy_device, opengl_columns_source, opengl_columns_free};
