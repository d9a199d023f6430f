/* Rendering a block of enter and exit depths; see depth_block.h.
 *
 * Vertices are moved to the block in double and snapped to the 1/256 texel that rasterizers resolve. So the triangle that is
 * interpolated equals the one that is covered; else a wall nearly parallel to the light would get depths far off its ends.
 *
 * Enter depth: nearest solid face s and nearest sheet h, computed separately; e = min(s, h). If a ray meets a sheet first, its
 * exit depth is x = e. Otherwise x is where it first leaves the union of solids:
 *
 *     depth ->      s         b1        b2            b3
 *                   |F  F     B    F    B             B          F front face, B back face of any solid
 *     inside        1  2      1    2    1             0          x = b3: the first back face behind which no solid is open
 *
 * [CPVS16] 3.3 peels front and back layers in pairs and stops at a back layer that is before its front layer. That counts
 * layers, so two faces at one depth (walls of adjoining boxes) count once, and the exit is found too late, outside of solids.
 * Here each pass peels the next back layer and counts, front faces minus back faces, all faces up to it, with as many passes and
 * draws. Faces at one depth count each; a face that starts where another ends keeps the union closed.
 *
 *     pass n:  layer  nearest back face behind layer n - 1, in texels that are still open
 *              count  +1 for every front face, -1 for every back face at or before the layer: a depth test against it, and
 *                     blending
 *              texels whose count is zero are done: x is the layer
 *
 * Done texels start a pass with the nearest depth instead of the farthest, so that the depth test rejects all of their fragments
 * early. A block whose solids do not intersect needs no peeling: its first back face is the exit.
 * A texel that runs out of back faces takes the first one, which is before the true exit. This is correct: the free range is
 * smaller. The same holds for counts beyond the 255 that a texel can store: further front faces are not counted, and the exit is
 * too early. So peeling takes 255 passes at most, and linear time in the triangles, however many layers there are.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/opengl/depth_block.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/integer.h"

static void make_texture(gl_context *gl, GLuint *texture, GLenum format, uint32_t side)
{
    gl->CreateTextures(GL_TEXTURE_2D, 1, texture);
    gl->TextureStorage2D(*texture, 1, format, (GLsizei)side, (GLsizei)side);
}

vxs_result depth_block_init(depth_block *b, block_context *context, run_context *m)
{
    gl_context       *gl     = context->gl;
    const projection *c      = &context->casters;
    size_t            texels = (size_t)context->block_px * context->block_px;
    int               solids = c->solid_triangle_count != 0, sheets = c->solid_triangle_count < c->triangle_count;
    *b = (depth_block){.context = context};

    b->positions = malloc((c->vertex_count + 1) * 3 * sizeof *b->positions);
    b->indices   = malloc((c->triangle_count + 1) * 3 * sizeof *b->indices);
    b->triangles = malloc((c->triangle_count + 1) * sizeof *b->triangles);
    int ok       = b->positions && b->indices && b->triangles;
    if (solids) {
        b->sheet    = malloc(texels * sizeof *b->sheet);
        b->layer[0] = malloc(texels * sizeof *b->layer[0]);
        b->layer[1] = malloc(texels * sizeof *b->layer[1]);
        b->count    = calloc(texels, sizeof *b->count);
        b->cell     = malloc((size_t)context->cell_side * context->cell_side);
        ok          = ok && b->sheet && b->layer[0] && b->layer[1] && b->count && b->cell;
    }
    if (!ok) return fail(m, VXS_E_MEMORY, "out of memory for rendering depth maps");

    if (solids) make_texture(gl, &b->texture_solid, GL_DEPTH_COMPONENT32F, context->block_px);
    if (sheets) make_texture(gl, &b->texture_sheet, GL_DEPTH_COMPONENT32F, context->block_px);
    if (solids) make_texture(gl, &b->texture_layer[0], GL_DEPTH_COMPONENT32F, context->block_px);
    if (solids && context->mode != EXIT_BACK) {
        make_texture(gl, &b->texture_layer[1], GL_DEPTH_COMPONENT32F, context->block_px);
        make_texture(gl, &b->texture_count, GL_R8, context->block_px);
    }
    gl->GenVertexArrays(1, &b->vertex_array);
    gl->BindVertexArray(b->vertex_array);
    gl->GenBuffers(2, b->buffers);
    gl->BindBuffer(GL_ARRAY_BUFFER, b->buffers[0]);
    gl->BindBuffer(GL_ELEMENT_ARRAY_BUFFER, b->buffers[1]);
    gl->EnableVertexAttribArray(0);
    gl->VertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, 0, NULL);
    vxs_result r = holed_triangles_init(&b->masked, &context->images, c, m);
    if (r != VXS_OK || gl->GetError() == GL_NO_ERROR) return r;
    return fail(m, VXS_E_GL, "OpenGL cannot set up depth maps of %u texels", context->block_px);
}

void depth_block_free(depth_block *b)
{
    if (!b->context) return;
    gl_context *gl         = b->context->gl;
    GLuint      textures[] = {b->texture_solid, b->texture_sheet, b->texture_layer[0], b->texture_layer[1], b->texture_count};
    gl->DeleteTextures(sizeof textures / sizeof *textures, textures);
    gl->DeleteBuffers(2, b->buffers);
    gl->DeleteVertexArrays(1, &b->vertex_array);
    holed_triangles_free(&b->masked);
    free(b->positions);
    free(b->indices);
    free(b->triangles);
    free(b->sheet);
    free(b->layer[0]);
    free(b->layer[1]);
    free(b->count);
    free(b->cell);
    *b = (depth_block){0};
}

/* draws of a block ------------------------------------------------------------------------------------------------------------- */

static float snapped(double texels)
{
    return (float)(floor(texels * SUBTEXELS + 0.5) / SUBTEXELS);
}

/* A vertex in the block's clip space: exact, except for the depth. */
static void clip_vertex(const depth_block *b, uint32_t vertex, float clip[3])
{
    const vertex_ls *p  = &b->context->casters.vertices[vertex];
    float            to = 2.0f / (float)b->context->block_px;
    clip[0]             = snapped(p->u - b->u0) * to - 1.0f;
    clip[1]             = snapped(p->v - b->v0) * to - 1.0f;
    clip[2]             = (float)p->z;
}

/* The slot of a vertex in this block. */
static uint32_t block_vertex(depth_block *b, uint32_t vertex)
{
    block_context *x = b->context;
    if (x->vertex_gather[vertex] != x->gather) {
        clip_vertex(b, vertex, b->positions + 3 * (size_t)b->vertex_count);
        x->vertex_gather[vertex] = x->gather;
        x->vertex_slot[vertex]   = b->vertex_count++;
    }
    return x->vertex_slot[vertex];
}

/* Add a triangle with holes: it has its own corners, because of their texture coordinates. */
static void add_masked(depth_block *b, size_t t)
{
    const projection *c  = &b->context->casters;
    hole_corner      *to = b->masked.corners[b->masked.count];
    for (int k = 0; k < 3; k++) {
        clip_vertex(b, c->indices[3 * t + (size_t)k], to[k].clip);
        to[k].at = c->uvq[t - c->holed_first][k];
    }
    b->masked.triangle[b->masked.count++] = (uint32_t)t;
}

/* If solids do not intersect, their insides are disjoint: the nearest back face ends the inside that was entered first. */
static int needs_peeling(const depth_block *b)
{
    const uint8_t *meets = b->context->casters.meets;
    if (b->context->mode != EXIT_AUTO) return b->solid_count && b->context->mode == EXIT_PEEL;
    for (uint32_t n = 0; n < b->solid_count; n++)
        if (!meets || meets[b->triangles[n]]) return 1;
    return 0;
}

/* 1 when some texel in the triangle's box may be open. */
static int touches_open_cell(const depth_block *b, const texel_box *box)
{
    int32_t cells = (int32_t)b->context->cell_side;
    int32_t last  = cells - 1;
    int32_t i0 = box->u0 <= b->u0 ? 0 : (box->u0 - b->u0) / CELL_PX, i1 = (box->u1 - b->u0) / CELL_PX;
    int32_t j0 = box->v0 <= b->v0 ? 0 : (box->v0 - b->v0) / CELL_PX, j1 = (box->v1 - b->v0) / CELL_PX;
    i1 = i1 > last ? last : i1;
    j1 = j1 > last ? last : j1;
    for (int32_t j = j0; j <= j1; j++)
        for (int32_t i = i0; i <= i1; i++)
            if (b->cell[j * cells + i] == CELL_OPEN) return 1;
    return 0;
}

int depth_block_start(depth_block *b, float *enter, float *exit, uint32_t row_px, int32_t u0, int32_t v0)
{
    b->enter  = enter;
    b->exit   = exit;
    b->row_px = row_px;
    b->u0     = u0;
    b->v0     = v0;
    b->pass   = 0;
    b->open   = (block_rect){0, 0, b->context->block_px, b->context->block_px};
    if (b->cell) memset(b->cell, CELL_OPEN, (size_t)b->context->cell_side * b->context->cell_side);

    block_context    *x = b->context;
    const projection *c = &x->casters;
    b->triangle_count = b->solid_count = b->vertex_count = b->masked.count = 0;
    x->gather++;
    for (size_t n = 0; n < x->candidate_count; n++) {
        size_t t = x->candidates[n];
        if (!texel_box_touches(&x->boxes[t], b->u0, b->v0, (int32_t)x->block_px)) continue;
        if (t >= c->holed_first) {
            add_masked(b, t);
            continue;
        }
        for (int k = 0; k < 3; k++) b->indices[3 * (size_t)b->triangle_count + k] = block_vertex(b, c->indices[3 * t + k]);
        b->triangles[b->triangle_count++] = (uint32_t)t;
        b->solid_count += t < c->solid_triangle_count;
    }

    b->has_sheets = b->triangle_count > b->solid_count || b->masked.count;
    b->peels      = needs_peeling(b);
    if (b->triangle_count || b->masked.count) {
        b->context->stats.blocks_rendered++;
        b->context->stats.blocks_peeled += (uint64_t)b->peels;
        b->context->stats.blocks_not_peeled += b->solid_count && !b->peels;
        return 1;
    }
    b->context->stats.blocks_empty++;
    float far = b->context->order.sign * b->context->order.far_gl;
    for (uint32_t row = 0; row < b->context->block_px; row++)
        for (uint32_t n = 0; n < b->context->block_px; n++)
            b->enter[(size_t)row * b->row_px + n] = b->exit[(size_t)row * b->row_px + n] = far;
    return 0;
}

/* drawing ---------------------------------------------------------------------------------------------------------------------- */

/* Draw very many triangles in parts, and wait after each: llvmpipe bins triangles into up to 64 scenes of 36 MiB ahead of its
 * rasterizer. */
static void draw(depth_block *b, GLuint program, uint32_t first, uint32_t count)
{
    gl_context *gl = b->context->gl;
    gl->UseProgram(program);
    for (uint32_t at = 0; at < count; at += DRAW_MAX) {
        gl->DrawElements(GL_TRIANGLES, (GLsizei)(3 * min_u32(count - at, DRAW_MAX)), GL_UNSIGNED_INT,
                         (const void *)((uintptr_t)(first + at) * 3 * sizeof *b->indices));
        if (count > DRAW_MAX) gl->Finish();
    }
    b->context->stats.triangles_drawn += count;
}

static void target(const depth_block *b, GLuint depth, GLuint color)
{
    gl_context *gl = b->context->gl;
    gl->FramebufferTexture(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, depth, 0);
    gl->FramebufferTexture(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, color, 0);
}

/* Draw the nearest surface of some triangles into a cleared depth texture. */
static void draw_nearest(depth_block *b, GLuint depth, uint32_t first, uint32_t count)
{
    gl_context *gl = b->context->gl;
    target(b, depth, 0);
    gl->ClearBufferfv(GL_DEPTH, 0, &b->context->order.far_gl);
    gl->DepthFunc(b->context->order.nearer);
    draw(b, b->context->program_depth, first, count);
}

/* Count front faces minus back faces at or before the layer. */
static void draw_count(depth_block *b)
{
    gl_context *gl      = b->context->gl;
    const float zero[4] = {0};
    target(b, b->texture_layer[b->pass & 1], b->texture_count);
    gl->ClearBufferfv(GL_COLOR, 0, zero);
    gl->DepthFunc(b->context->order.nearer_or_equal);
    gl->DepthMask(GL_FALSE);
    gl->Enable(GL_BLEND);
    gl->Enable(GL_CULL_FACE);
    gl->CullFace(GL_BACK);
    gl->BlendEquation(GL_FUNC_ADD);
    draw(b, b->context->program_count, 0, b->solid_count);
    gl->CullFace(GL_FRONT);
    gl->BlendEquation(GL_FUNC_REVERSE_SUBTRACT);
    draw(b, b->context->program_count, 0, b->solid_count);
    gl->Disable(GL_CULL_FACE);
    gl->Disable(GL_BLEND);
    gl->DepthMask(GL_TRUE);
}

void depth_block_issue(depth_block *b)
{
    gl_context *gl = b->context->gl;
    gl->BindVertexArray(b->vertex_array);
    if (!b->pass) {
        gl->BindBuffer(GL_ARRAY_BUFFER, b->buffers[0]);
        gl->BufferData(GL_ARRAY_BUFFER, (GLsizeiptr)b->vertex_count * 3 * (GLsizeiptr)sizeof *b->positions, b->positions,
                       GL_STREAM_DRAW);
    }
    gl->BufferData(GL_ELEMENT_ARRAY_BUFFER, (GLsizeiptr)b->triangle_count * 3 * (GLsizeiptr)sizeof *b->indices, b->indices,
                   GL_STREAM_DRAW);
    if (b->pass) {
        gl->Enable(GL_SCISSOR_TEST);
        gl->Scissor((GLint)b->open.u, (GLint)b->open.v, (GLsizei)b->open.width, (GLsizei)b->open.height);

        /* the nearest back faces behind the last layer, in open texels */
        GLuint       texture = b->texture_layer[b->pass & 1];
        const float *start   = b->layer[b->pass & 1];
        block_rect   a       = b->open;
        gl->PixelStorei(GL_UNPACK_ROW_LENGTH, (GLint)b->context->block_px);
        gl->TextureSubImage2D(texture, 0, (GLint)a.u, (GLint)a.v, (GLsizei)a.width, (GLsizei)a.height, GL_DEPTH_COMPONENT, GL_FLOAT,
                              start + (size_t)a.v * b->context->block_px + a.u);
        target(b, texture, 0);
        gl->BindTextureUnit(0, b->texture_layer[(b->pass - 1) & 1]);
        gl->Enable(GL_CULL_FACE);
        gl->CullFace(GL_FRONT);
        gl->DepthFunc(b->context->order.nearer);
        draw(b, b->context->program_next, 0, b->solid_count);
        gl->Disable(GL_CULL_FACE);

        draw_count(b);
        gl->Disable(GL_SCISSOR_TEST);
    } else {
        if (b->has_sheets) {
            draw_nearest(b, b->texture_sheet, b->solid_count, b->triangle_count - b->solid_count);
            holed_triangles_draw(&b->masked);
            b->context->stats.triangles_drawn += b->masked.count;
            b->context->gl->BindVertexArray(b->vertex_array);
        }
        if (b->solid_count) {
            /* the nearest front faces, and the nearest back faces, which are the first layer: the nearer of the two is
             * where a ray enters solids; it can be a back face only if a part of a solid is inside out */
            gl->Enable(GL_CULL_FACE);
            gl->CullFace(GL_BACK);
            draw_nearest(b, b->texture_solid, 0, b->solid_count);
            gl->CullFace(GL_FRONT);
            draw_nearest(b, b->texture_layer[0], 0, b->solid_count);
            gl->Disable(GL_CULL_FACE);

            if (b->peels) draw_count(b);
        }
    }
    gl->Flush();
}

/* reading ---------------------------------------------------------------------------------------------------------------------- */

/* Read a rectangle of a texture into the same place of `to`, rows of row_px elements of `size` bytes. */
static void read_rect(const depth_block *b, block_rect a, GLenum format, GLenum type, void *to, uint32_t row_px, size_t size)
{
    gl_context *gl = b->context->gl;
    gl->PixelStorei(GL_PACK_ROW_LENGTH, (GLint)row_px);
    gl->ReadPixels((GLint)a.u, (GLint)a.v, (GLsizei)a.width, (GLsizei)a.height, format, type,
                   (uint8_t *)to + ((size_t)a.v * row_px + a.u) * size);
}

/* Depths as OpenGL has them. */
static void read_depth(const depth_block *b, GLuint texture, block_rect a, float *to, uint32_t row_px)
{
    target(b, texture, 0);
    read_rect(b, a, GL_DEPTH_COMPONENT, GL_FLOAT, to, row_px, sizeof *to);
}

void depth_block_read(depth_block *b)
{
    uint32_t block_px = b->context->block_px;
    if (!b->pass && !b->solid_count) {
        read_depth(b, b->texture_sheet, b->open, b->enter, b->row_px);
        return; /* resolve turns them */
    }
    if (!b->pass && b->has_sheets) read_depth(b, b->texture_sheet, b->open, b->sheet, block_px);
    if (!b->pass) read_depth(b, b->texture_solid, b->open, b->enter, b->row_px);
    if (b->peels) {
        target(b, b->texture_layer[b->pass & 1], b->texture_count);
        read_rect(b, b->open, GL_RED, GL_UNSIGNED_BYTE, b->count, block_px, sizeof *b->count);
    }
    read_depth(b, b->texture_layer[b->pass & 1], b->open, b->layer[b->pass & 1], block_px);
}

/* exit depths ------------------------------------------------------------------------------------------------------------------ */

/* A run of at most CELL_PX texels of one cell after the first pass. `enter` holds front faces and becomes the nearer of front
 * and back: where a ray enters solids. The first layer becomes the exit of all texels; for those that are done, it is final.
 * `next` is the start depth of the next pass. Returns whether a texel is open.
 * These two loops process every texel of every pass: no branches and independent loads, so that compilers vectorize them. */
static int resolve_first_run(depth_order order, float *restrict enter, const float *restrict layer,
                             const uint8_t *restrict open_solids, uint32_t peel, float *restrict exit, float *restrict next,
                             uint32_t count)
{
    uint32_t solids[CELL_PX], any = 0;
    float    far = order.sign * order.far_gl;
    for (uint32_t n = 0; n < count; n++) solids[n] = open_solids[n];
    for (uint32_t n = 0; n < count; n++) {
        float    f = order.sign * enter[n], b = order.sign * layer[n];
        float    e     = b < f ? b : f;
        float    first = b < far ? b : e;
        uint32_t open  = peel & (uint32_t)(b < far) & (uint32_t)(solids[n] > 0);
        enter[n]       = e;
        exit[n]        = first;
        next[n]        = open ? order.far_gl : order.near_gl;
        any |= open;
    }
    return any != 0;
}

/* The same after a later pass; done texels have the nearest possible layer. A layer that did not advance would be found again
 * forever, so it ends the search, too. `last` is the layer before, and becomes the start depth of the next pass. */
static int resolve_next_run(depth_order order, const float *restrict layer, const uint8_t *restrict open_solids,
                            float *restrict exit, float *restrict last, uint32_t count)
{
    uint32_t solids[CELL_PX], any = 0;
    float    sign = order.sign, far_gl = order.far_gl, near_gl = order.near_gl, step = far_gl - near_gl;
    float    far = sign * far_gl, near = sign * near_gl;
    for (uint32_t n = 0; n < count; n++) solids[n] = open_solids[n];
    for (uint32_t n = 0; n < count; n++) {
        float    b = sign * layer[n], before = sign * last[n], x = exit[n];
        uint32_t more = (uint32_t)(b > near) & (uint32_t)(b < far) & (uint32_t)(b > before);
        uint32_t open = more & (uint32_t)(solids[n] > 0);
        exit[n]       = more > open ? b : x;
        last[n]       = near_gl + (float)(int32_t)open * step; /* far_gl or near_gl, without a branch */
        any |= open;
    }
    return any != 0;
}

/* One row of texels of a cell after a pass. Returns whether one is open. A cell that the last pass closed still has that pass's
 * layer as the start of the next one: reset its texels to the nearest depth. */
static int resolve_row(depth_block *b, cell_state state, uint32_t u, uint32_t row)
{
    uint32_t     block_px = b->context->block_px;
    uint32_t     run      = block_px < CELL_PX ? block_px : CELL_PX;
    size_t       at = (size_t)row * block_px + u, out = (size_t)row * b->row_px + u;
    const float *now   = b->layer[b->pass & 1] + at;
    float       *old   = b->layer[(b->pass + 1) & 1] + at;
    depth_order  order = b->context->order;
    for (uint32_t n = 0; n < run && state == CELL_CLOSED; n++) old[n] = order.near_gl;
    if (state != CELL_OPEN) return 0;
    if (b->pass) return resolve_next_run(order, now, b->count + at, b->exit + out, old, run);
    return resolve_first_run(order, b->enter + out, now, b->count + at, (uint32_t)b->peels, b->exit + out, old, run);
}

/* Write the exits of texels that were open, and find the rectangle of those that stay open; 0 when there are none. */
static int resolve_layer(depth_block *b)
{
    uint32_t side = b->context->cell_side, block_px = b->context->block_px;
    uint32_t cell = block_px < CELL_PX ? block_px : CELL_PX;
    uint32_t u0 = side, v0 = side, u1 = 0, v1 = 0;
    for (uint32_t v = b->open.v / cell; v < (b->open.v + b->open.height) / cell; v++) {
        uint8_t  open[BLOCK_MAX_PX / CELL_PX] = {0};
        uint8_t *state                        = b->cell + (size_t)v * side;
        uint32_t first = b->open.u / cell, end = (b->open.u + b->open.width) / cell;
        for (uint32_t row = v * cell; row < (v + 1) * cell; row++)
            for (uint32_t u = first; u < end; u++) open[u] |= (uint8_t)resolve_row(b, (cell_state)state[u], u * cell, row);
        for (uint32_t u = first; u < end; u++) {
            state[u] = open[u] ? CELL_OPEN : state[u] == CELL_OPEN ? CELL_CLOSED : CELL_CLEAN;
            if (!open[u]) continue;
            u0 = u < u0 ? u : u0;
            v0 = v < v0 ? v : v0;
            u1 = u + 1 > u1 ? u + 1 : u1;
            v1 = v + 1;
        }
    }
    if (u0 < u1) b->open = (block_rect){u0 * cell, v0 * cell, (u1 - u0) * cell, (v1 - v0) * cell};
    return u0 < u1;
}

int depth_block_resolve(depth_block *b)
{
    depth_stats *stats = &b->context->stats;
    if (!b->pass && !b->solid_count) {
        /* there are only sheets, read into enter */
        uint32_t block_px = b->context->block_px;
        for (uint32_t row = 0; row < block_px; row++) {
            float *e = b->enter + (size_t)row * b->row_px;
            for (uint32_t n = 0; n < block_px && b->context->casters.reversed; n++) e[n] = -e[n];
            if (b->exit != b->enter) memcpy(b->exit + (size_t)row * b->row_px, e, block_px * sizeof *e);
        }
        return 0;
    }
    if (resolve_layer(b)) {
        /* keep only solid triangles that may touch an open texel */
        uint32_t kept = 0;
        for (uint32_t n = 0; n < b->solid_count; n++) {
            if (!touches_open_cell(b, &b->context->boxes[b->triangles[n]])) continue;
            memmove(b->indices + 3 * (size_t)kept, b->indices + 3 * (size_t)n, 3 * sizeof *b->indices);
            b->triangles[kept++] = b->triangles[n];
        }
        b->solid_count = b->triangle_count = kept;

        b->pass++;
        return 1;
    }
    uint32_t passes = b->peels ? b->pass + 1 : 0;
    stats->peel_passes += passes;
    if (passes > stats->peel_passes_max) stats->peel_passes_max = passes;
    if (b->has_sheets) {
        /* Where a ray meets a sheet first, or at the same depth, it enters and leaves there. */
        for (uint32_t row = 0; row < b->context->block_px; row++) {
            const float *sheet = b->sheet + (size_t)row * b->context->block_px;
            float       *e = b->enter + (size_t)row * b->row_px, *x = b->exit + (size_t)row * b->row_px;
            for (uint32_t n = 0; n < b->context->block_px; n++) {
                float h     = b->context->order.sign * sheet[n];
                int   first = h <= e[n];
                e[n]        = first ? h : e[n];
                x[n]        = first ? h : x[n];
            }
        }
    }
    return 0;
}
