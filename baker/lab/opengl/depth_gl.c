/* Rendering depth maps block by block; see depth_gl.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/opengl/depth_gl.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/parallel.h"
#include "baker/lab/opengl/depth_block.h"

enum { LANES = 2 }; /* blocks in flight: one is rasterized while the other's texels are resolved */

struct depth_renderer {
    block_context context;
    depth_block   lane[LANES];
    uint32_t      side_px;                   /* of the map */
    void (*watch)(void *user, double share); /* called while a square is rendered: the share of its blocks that have begun, 0 to
                                                1. NULL: no calls */
    void *watch_user;
};

/* setting up ------------------------------------------------------------------------------------------------------------------- */

static const char vertex_text[] = "#version 450 core\n"
                                  "layout(location = 0) in vec3 position;\n"
                                  "invariant gl_Position;\n"
                                  "void main() { gl_Position = vec4(position, 1.0); }\n";

static const char depth_text[] = "#version 450 core\n"
                                 "void main() {}\n";

static const char count_text[] = "#version 450 core\n"
                                 "layout(location = 0) out float count;\n"
                                 "void main() { count = 1.0 / 255.0; }\n";

static const char next_text[] =
    "#version 450 core\n"
    "layout(binding = 0) uniform sampler2D last;\n"
    "layout(location = 0) uniform float order;\n"
    "void main()\n"
    "{\n"
    "    if (order * gl_FragCoord.z <= order * texelFetch(last, ivec2(gl_FragCoord.xy), 0).r) discard;\n"
    "}\n";

static vxs_result make_programs(block_context *x, run_context *m)
{
    gl_context       *gl = x->gl;
    vxs_result        r;
    const char *const texts[3] = {depth_text, count_text, next_text};
    const gl_text     vertex[] = {{vertex_text, -1}, {0}};
    for (int n = 0; n < 3; n++)
        if (!gl->depth_programs[n] &&
            (r = gl_program(gl, &gl->depth_programs[n], vertex, (const gl_text[]){{texts[n], -1}, {0}}, m)) != VXS_OK)
            return r;
    x->program_depth = gl->depth_programs[0];
    x->program_count = gl->depth_programs[1];
    x->program_next  = gl->depth_programs[2];
    return VXS_OK;
}

static void bound_triangles(void *user, size_t begin, size_t end, uint32_t worker)
{
    depth_renderer *r = user;
    (void)worker;
    for (size_t n = begin; n < end; n++) r->context.boxes[n] = texel_box_of(&r->context.casters, n);
}

static vxs_result set_up(depth_renderer *r, uint32_t threads, run_context *m)
{
    block_context    *x = &r->context;
    const projection *p = &x->casters;
    x->boxes            = malloc((p->triangle_count + 1) * sizeof *x->boxes);
    x->vertex_slot      = malloc((p->vertex_count + 1) * sizeof *x->vertex_slot);
    x->candidates       = malloc((p->triangle_count + 1) * sizeof *x->candidates);
    x->vertex_gather    = calloc(p->vertex_count + 1, sizeof *x->vertex_gather);
    if (!x->boxes || !x->candidates || !x->vertex_slot || !x->vertex_gather)
        return fail(m, VXS_E_MEMORY, "out of memory for rendering depth maps");
    parallel_for(threads, p->triangle_count, 4096, bound_triangles, r);
    vxs_result result = make_programs(x, m);
    x->gl->GenFramebuffers(1, &x->framebuffer);
    if (result == VXS_OK) result = hole_images_init(&x->images, x->gl, p->casters, m);
    for (int n = 0; n < LANES && result == VXS_OK; n++) result = depth_block_init(&r->lane[n], x, m);
    return result;
}

vxs_result depth_renderer_create(depth_renderer **out, gl_context *gl, const casters *c, const vxs_light *light, int map,
                                 exit_mode mode, uint32_t threads, run_context *m)
{
    static const depth_order growing   = {1, 1, 0, GL_LESS, GL_LEQUAL};
    static const depth_order shrinking = {-1, 0, 1, GL_GREATER, GL_GEQUAL};

    *out              = NULL;
    depth_renderer *r = calloc(1, sizeof *r);
    if (!r) return fail(m, VXS_E_MEMORY, "out of memory for rendering depth maps");
    block_context *x = &r->context;
    r->side_px       = 1u << light->levels;
    x->gl            = gl;
    x->mode          = mode;
    x->block_px      = r->side_px < BLOCK_MAX_PX ? r->side_px : BLOCK_MAX_PX;
    x->cell_side     = (x->block_px + CELL_PX - 1) / CELL_PX;

    vxs_result result = projection_init(&x->casters, c, light, map, threads, m);
    x->order          = x->casters.reversed ? shrinking : growing;
    if (result == VXS_OK) result = set_up(r, threads, m);
    if (result != VXS_OK) {
        depth_renderer_destroy(r);
        return result;
    }
    *out = r;
    return VXS_OK;
}

void depth_renderer_destroy(depth_renderer *r)
{
    if (!r) return;
    block_context *x  = &r->context;
    gl_context    *gl = x->gl;
    for (int n = 0; n < LANES; n++) depth_block_free(&r->lane[n]);
    gl->DeleteFramebuffers(1, &x->framebuffer);
    hole_images_free(&x->images);
    projection_free(&x->casters);
    free(x->boxes);
    free(x->candidates);
    free(x->vertex_slot);
    free(x->vertex_gather);
    free(r);
}

depth_stats depth_renderer_stats(const depth_renderer *r)
{
    return r->context.stats;
}

int depth_renderer_has_casters(const depth_renderer *r, uint32_t side_px, uint32_t i, uint32_t j)
{
    for (size_t n = 0; n < r->context.casters.triangle_count; n++)
        if (texel_box_touches(&r->context.boxes[n], (int32_t)(i * side_px), (int32_t)(j * side_px), (int32_t)side_px)) return 1;
    return 0;
}

/* a map tile ------------------------------------------------------------------------------------------------------------------- */

/* The blocks of a tile, in rows. */
typedef struct tile_blocks {
    depth_maps *maps;
    uint32_t    u0, v0; /* texel of the map where the tile starts */
    uint32_t    next, count;
} tile_blocks;

/* Start the next block that has triangles; 0 when there is none left. */
static int start_next(depth_block *lane, tile_blocks *t)
{
    uint32_t side = t->maps->side_px, block = lane->context->block_px;
    while (t->next < t->count) {
        uint32_t n = t->next++;
        uint32_t u = n % (side / block) * block, v = n / (side / block) * block;
        size_t   at = (size_t)v * side + u;
        if (depth_block_start(lane, t->maps->enter + at, t->maps->exit + at, side, (int32_t)(t->u0 + u), (int32_t)(t->v0 + v)))
            return 1;
    }
    return 0;
}

vxs_result depth_renderer_tile(depth_renderer *r, depth_maps *maps, uint32_t i, uint32_t j, run_context *m)
{
    uint32_t    blocks = maps->side_px / r->context.block_px;
    tile_blocks t      = {.maps = maps, .u0 = i * maps->side_px, .v0 = j * maps->side_px, .count = blocks * blocks};

    /* the context is shared with other renderers: set all state that one of them may have changed */
    gl_context *gl = r->context.gl;
    gl->BindFramebuffer(GL_FRAMEBUFFER, r->context.framebuffer);
    gl->ProgramUniform1f(r->context.program_next, 0, r->context.order.sign);
    gl->ClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
    gl->FrontFace(GL_CW); /* u, v and the light's direction are right-handed: the map is mirrored as seen from the light */
    gl->Viewport(0, 0, (GLsizei)r->context.block_px, (GLsizei)r->context.block_px);
    gl->PixelStorei(GL_PACK_ALIGNMENT, 1);
    gl->Enable(GL_DEPTH_TEST);
    gl->Enable(GL_DEPTH_CLAMP); /* casters before the near plane of a region still cast */
    gl->BlendFunc(GL_ONE, GL_ONE);

    r->context.candidate_count = 0;
    for (size_t n = 0; n < r->context.casters.triangle_count; n++)
        if (texel_box_touches(&r->context.boxes[n], (int32_t)t.u0, (int32_t)t.v0, (int32_t)t.maps->side_px))
            r->context.candidates[r->context.candidate_count++] = (uint32_t)n;

    /* Lanes alternate: while one is read and resolved, the rasterizer works on the other. */
    int active[LANES], any = 0;
    for (int n = 0; n < LANES; n++) {
        active[n] = start_next(&r->lane[n], &t);
        if (active[n]) depth_block_issue(&r->lane[n]);
        any |= active[n];
    }
    while (any) {
        any = 0;
        for (int n = 0; n < LANES; n++) {
            if (!active[n]) continue;
            depth_block_read(&r->lane[n]);
            active[n] = depth_block_resolve(&r->lane[n]) || start_next(&r->lane[n], &t);
            if (active[n]) depth_block_issue(&r->lane[n]);
            any |= active[n];
        }
        if (r->watch) r->watch(r->watch_user, (double)t.next / t.count);
    }

    GLenum error = r->context.gl->GetError();
    if (error != GL_NO_ERROR) return fail(m, VXS_E_GL, "OpenGL failed while rendering depth maps (error 0x%04x)", error);
    return VXS_OK;
}

/* a column source -------------------------------------------------------------------------------------------------------------- */

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
    if ((r = depth_renderer_tile(o->renderer, o->maps, i, j, ctx->run)) != VXS_OK) return r;
    stage_begin(ctx, STAGE_PYRAMID);
    depth_maps_reduce(o->maps, ctx->threads);
    stage_begin(ctx, STAGE_NONE);
    rendered_tile tile = {o->maps->side_px, {o->maps->depth_vx, o->maps->voxel_log}, o->maps->enter};
    if (o->owner->watch && (r = o->owner->watch(o->owner->watch_user, o->map, i, j, &tile, ctx)) != VXS_OK) return r;
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

static void map_close(void *data)
{
    opengl_map *o = data;
    if (o->renderer) {
        depth_stats s = depth_renderer_stats(o->renderer);
        o->owner->stats.blocks_rendered += s.blocks_rendered;
        o->owner->stats.blocks_empty += s.blocks_empty;
        o->owner->stats.blocks_peeled += s.blocks_peeled;
        o->owner->stats.blocks_not_peeled += s.blocks_not_peeled;
        o->owner->stats.triangles_drawn += s.triangles_drawn;
        o->owner->stats.peel_passes += s.peel_passes;
        if (s.peel_passes_max > o->owner->stats.peel_passes_max) o->owner->stats.peel_passes_max = s.peel_passes_max;
    }
    depth_renderer_destroy(o->renderer);
    opengl_columns_free(o->owner);
    o->owner->spare = o->maps;
    free(o);
}

static vxs_result open_map(void *data, uint32_t map, column_map *out, bake_context *ctx)
{
    rendered_columns *owner = data;
    uint32_t          side = 1u << owner->light->levels, tile = min_u32(side, owner->tile_px);
    opengl_map       *o = calloc(1, sizeof *o);
    *out                = (column_map){0};
    if (!o) return fail(ctx->run, VXS_E_MEMORY, "out of memory for rendering depth maps");
    *o = (opengl_map){.owner = owner, .map = map};
    stage_begin(ctx, STAGE_GL);

    /* reuse the memory of the previous map, or allocate it */
    double voxel_log = owner->light->kind == VXS_LIGHT_KIND_DIRECTIONAL ? 0 : owner->light->voxel_metres;
    o->maps          = owner->spare ? owner->spare : calloc(1, sizeof *o->maps);
    owner->spare     = NULL;
    vxs_result r     = o->maps ? VXS_OK : fail(ctx->run, VXS_E_MEMORY, "out of memory for rendering depth maps");
    if (r == VXS_OK && !o->maps->enter) r = depth_maps_init(o->maps, tile, side, voxel_log, owner->has_exit_map, ctx->run);
    if (r == VXS_OK)
        r = depth_renderer_create(&o->renderer, owner->device, owner->casters, owner->light, (int)map, owner->exit, ctx->threads,
                                  ctx->run);
    stage_begin(ctx, STAGE_NONE);
    if (r != VXS_OK) {
        map_close(o);
        return r;
    }
    o->renderer->watch      = show_part;
    o->renderer->watch_user = o;
    *out                    = (column_map){.data     = o,
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

static vxs_result create_device(void **device, device_names *names, gl_backend backend, uint32_t threads, run_context *m)
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
