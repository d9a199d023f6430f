/* Rendering enter and exit depths; see depth_gl.h.
 *
 * A map is rendered block by block, each with the triangles that may touch it. Vertices are moved to the block in double and
 * snapped to the 1/256 texel that rasterizers resolve, so that the triangle that is interpolated is the one that is covered: else
 * a wall nearly along the light gets depths far off its ends.
 *
 * Enter depth: nearest solid face s and nearest sheet h, apart from each other; e = min(s, h). A ray that meets a sheet first has
 * x = e. Otherwise x is where it first leaves the union of solids:
 *
 *     depth ->      s         b1        b2            b3
 *                   |F  F     B    F    B             B          F front face, B back face of any solid
 *     inside        1  2      1    2    1             0          x = b3: the first back face behind which no solid is open
 *
 * [CPVS16] 3.3 peels front and back layers in pairs and stops at a back layer that lies before its front layer. That counts layers,
 * so two faces at one depth (walls of adjoining boxes) count once and the ray leaves too late, in the open. Here each pass peels the
 * next back layer and counts, front faces minus back faces, all faces up to it, with as many passes and draws. Faces at one depth
 * count each; a face that starts where another ends keeps the union closed.
 *
 *     pass n:  layer  nearest back face behind layer n - 1, in texels that are still open
 *              count  +1 for every front face, -1 for every back face at or before the layer: a depth test against it, and blending
 *              texels whose count is zero are done: x is the layer
 *
 * Done texels start a pass with depth 0 instead of 1, so that the depth test drops all of their fragments before any other work.
 * A texel that runs out of back faces takes the first one, which lies before the true exit: a smaller free range is always right.
 * So is what happens to counts beyond the 255 that a texel holds: front faces too many are not counted, and the ray leaves early.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/maps/depth_gl.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/parallel.h"

enum { BLOCK_MAX_PX = 512, CELL_PX = 32, SUBTEXELS = 256 };

/* A vertex in the light's space. */
typedef struct vertex_ls {
    double u, v; /* texels */
    double z;    /* depth, 0 near plane, 1 far plane */
} vertex_ls;

/* Texels whose centres a triangle's bounding box covers; empty when u0 > u1 or v0 > v1. */
typedef struct texel_box {
    int32_t u0, v0, u1, v1;
} texel_box;

/* A rectangle of a block's texels. */
typedef struct block_rect {
    uint32_t u, v, width, height;
} block_rect;

struct depth_renderer {
    gl_context    *gl;
    const casters *casters;
    const double  *vx_from_ws; /* [12] */
    exit_mode      mode;
    uint32_t       threads;
    uint32_t       side_px; /* of the map */
    uint32_t       block_px;
    depth_stats    stats;

    vertex_ls *vertices;
    texel_box *boxes;

    /* of the block in work */
    float    *positions;   /* clip space, of the vertices that the block uses */
    uint32_t *vertex_slot; /* [vertex_count] position of a vertex, valid when vertex_block is this block */
    uint32_t *vertex_block;
    uint32_t  block_number;
    uint32_t *indices;   /* into positions */
    uint32_t *triangles; /* of the casters: solids first */
    uint32_t  solid_count, triangle_count, vertex_count;

    /* [block_px * block_px] */
    float     *sheet;     /* enter depth of sheets */
    float     *layer[2];  /* back layers, this pass and the last; before a pass 1 for open texels, 0 for done ones */
    uint8_t   *count;     /* solids that are open behind the layer */
    uint8_t   *cell_open; /* [cell_side^2] some texel of the cell is open */
    uint32_t   cell_side;
    block_rect open; /* holds all open cells; texels of the block */

    GLuint vertex_array, buffers[2], framebuffer;
    GLuint texture_solid, texture_sheet, texture_layer[2], texture_count;
    GLuint program_depth, program_count, program_next;
};

/* setting up ------------------------------------------------------------------------------------------------------------------ */

static const char vertex_text[] = "#version 450 core\n"
                                  "layout(location = 0) in vec3 position;\n"
                                  "invariant gl_Position;\n"
                                  "void main() { gl_Position = vec4(position, 1.0); }\n";

static const char depth_text[] = "#version 450 core\n"
                                 "void main() {}\n";

static const char count_text[] = "#version 450 core\n"
                                 "layout(location = 0) out float count;\n"
                                 "void main() { count = 1.0 / 255.0; }\n";

static const char next_text[] = "#version 450 core\n"
                                "layout(binding = 0) uniform sampler2D last;\n"
                                "void main()\n"
                                "{\n"
                                "    if (gl_FragCoord.z <= texelFetch(last, ivec2(gl_FragCoord.xy), 0).r) discard;\n"
                                "}\n";

static vxs_result make_program(gl_context *gl, GLuint *program, const char *fragment_text, message *m)
{
    const char *texts[2] = {vertex_text, fragment_text};
    GLenum      kinds[2] = {GL_VERTEX_SHADER, GL_FRAGMENT_SHADER};
    *program             = gl->CreateProgram();
    for (int n = 0; n < 2; n++) {
        GLuint shader = gl->CreateShader(kinds[n]);
        gl->ShaderSource(shader, 1, &texts[n], NULL);
        gl->CompileShader(shader);
        gl->AttachShader(*program, shader);
        gl->DeleteShader(shader);
    }
    gl->LinkProgram(*program);
    GLint linked = 0;
    gl->GetProgramiv(*program, GL_LINK_STATUS, &linked);
    if (linked) return VXS_OK;
    char log[256] = "";
    gl->GetProgramInfoLog(*program, sizeof log, NULL, log);
    return fail(m, VXS_E_GL, "OpenGL cannot link a shader: %s", log);
}

static void make_texture(gl_context *gl, GLuint *texture, GLenum format, uint32_t side)
{
    gl->CreateTextures(GL_TEXTURE_2D, 1, texture);
    gl->TextureStorage2D(*texture, 1, format, (GLsizei)side, (GLsizei)side);
}

static vxs_result set_up_gl(depth_renderer *r, message *m)
{
    gl_context *gl = r->gl;
    vxs_result  result;
    if ((result = make_program(gl, &r->program_depth, depth_text, m)) != VXS_OK) return result;
    if ((result = make_program(gl, &r->program_count, count_text, m)) != VXS_OK) return result;
    if ((result = make_program(gl, &r->program_next, next_text, m)) != VXS_OK) return result;

    const casters *c = r->casters;
    if (c->solid_triangle_count) make_texture(gl, &r->texture_solid, GL_DEPTH_COMPONENT32F, r->block_px);
    if (c->solid_triangle_count < c->triangle_count) make_texture(gl, &r->texture_sheet, GL_DEPTH_COMPONENT32F, r->block_px);
    if (c->solid_triangle_count) make_texture(gl, &r->texture_layer[0], GL_DEPTH_COMPONENT32F, r->block_px);
    if (c->solid_triangle_count && r->mode != EXIT_BACK) {
        make_texture(gl, &r->texture_layer[1], GL_DEPTH_COMPONENT32F, r->block_px);
        make_texture(gl, &r->texture_count, GL_R8, r->block_px);
    }

    gl->GenVertexArrays(1, &r->vertex_array);
    gl->BindVertexArray(r->vertex_array);
    gl->GenBuffers(2, r->buffers);
    gl->BindBuffer(GL_ARRAY_BUFFER, r->buffers[0]);
    gl->BindBuffer(GL_ELEMENT_ARRAY_BUFFER, r->buffers[1]);
    gl->EnableVertexAttribArray(0);
    gl->VertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, 0, NULL);
    gl->GenFramebuffers(1, &r->framebuffer);
    gl->BindFramebuffer(GL_FRAMEBUFFER, r->framebuffer);

    gl->ClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
    gl->FrontFace(GL_CW); /* u, v and the light's direction are right-handed: seen from the light, the map is mirrored */
    gl->Viewport(0, 0, (GLsizei)r->block_px, (GLsizei)r->block_px);
    gl->Enable(GL_DEPTH_TEST);
    gl->Enable(GL_DEPTH_CLAMP); /* casters before the near plane of a region still cast */
    gl->BlendFunc(GL_ONE, GL_ONE);
    return gl->GetError() == GL_NO_ERROR ? VXS_OK : fail(m, VXS_E_GL, "OpenGL cannot set up depth maps of %u texels", r->block_px);
}

static void transform_vertices(void *user, size_t begin, size_t end, uint32_t worker)
{
    depth_renderer *r = user;
    const double   *m = r->vx_from_ws;
    (void)worker;
    for (size_t n = begin; n < end; n++) {
        const double *p = r->casters->positions_ws + 3 * n;
        r->vertices[n]  = (vertex_ls){
             m[0] * p[0] + m[1] * p[1] + m[2] * p[2] + m[3],
             m[4] * p[0] + m[5] * p[1] + m[6] * p[2] + m[7],
             (m[8] * p[0] + m[9] * p[1] + m[10] * p[2] + m[11]) / r->side_px,
        };
    }
}

/* A texel index within int32_t whatever the coordinate; boxes far outside the map stay far outside. */
static int32_t texel_index(double t)
{
    return (int32_t)fmin(fmax(t, -1e9), 1e9);
}

static void bound_triangles(void *user, size_t begin, size_t end, uint32_t worker)
{
    depth_renderer *r = user;
    (void)worker;
    for (size_t n = begin; n < end; n++) {
        const uint32_t  *t = r->casters->indices + 3 * n;
        const vertex_ls *a = &r->vertices[t[0]], *b = &r->vertices[t[1]], *c = &r->vertices[t[2]];
        /* centres lie at half texels; snapping may move an edge by half a subtexel */
        const double     slack = 0.5 / SUBTEXELS;
        r->boxes[n]            = (texel_box){
                       texel_index(ceil(fmin(fmin(a->u, b->u), c->u) - 0.5 - slack)),
                       texel_index(ceil(fmin(fmin(a->v, b->v), c->v) - 0.5 - slack)),
                       texel_index(floor(fmax(fmax(a->u, b->u), c->u) - 0.5 + slack)),
                       texel_index(floor(fmax(fmax(a->v, b->v), c->v) - 0.5 + slack)),
        };
    }
}

static int allocate(depth_renderer *r)
{
    const casters *c      = r->casters;
    size_t         texels = (size_t)r->block_px * r->block_px;
    r->vertices           = malloc(c->vertex_count * sizeof *r->vertices);
    r->boxes              = malloc(c->triangle_count * sizeof *r->boxes);
    r->positions          = malloc(c->vertex_count * 3 * sizeof *r->positions);
    r->vertex_slot        = malloc(c->vertex_count * sizeof *r->vertex_slot);
    r->vertex_block       = calloc(c->vertex_count, sizeof *r->vertex_block);
    r->indices            = malloc(c->triangle_count * 3 * sizeof *r->indices);
    r->triangles          = malloc(c->triangle_count * sizeof *r->triangles);
    int ok = r->vertices && r->boxes && r->positions && r->vertex_slot && r->vertex_block && r->indices && r->triangles;
    if (c->solid_triangle_count) {
        r->sheet     = malloc(texels * sizeof *r->sheet);
        r->layer[0]  = malloc(texels * sizeof *r->layer[0]);
        r->layer[1]  = malloc(texels * sizeof *r->layer[1]);
        r->count     = malloc(texels * sizeof *r->count);
        r->cell_open = malloc((size_t)r->cell_side * r->cell_side);
        ok           = ok && r->sheet && r->layer[0] && r->layer[1] && r->count && r->cell_open;
    }
    return ok;
}

vxs_result depth_renderer_create(depth_renderer **out, gl_context *gl, const casters *c, const vxs_light *light, exit_mode mode,
                                 uint32_t threads, message *m)
{
    *out              = NULL;
    depth_renderer *r = calloc(1, sizeof *r);
    if (!r) return fail(m, VXS_E_MEMORY, "out of memory for rendering depth maps");
    r->gl         = gl;
    r->casters    = c;
    r->vx_from_ws = light->vx_from_ws;
    r->mode       = mode;
    r->threads    = threads;
    r->side_px    = 1u << light->levels;
    r->block_px   = r->side_px < BLOCK_MAX_PX ? r->side_px : BLOCK_MAX_PX;
    r->cell_side  = (r->block_px + CELL_PX - 1) / CELL_PX;

    vxs_result result = allocate(r) ? set_up_gl(r, m) : fail(m, VXS_E_MEMORY, "out of memory for rendering depth maps");
    if (result != VXS_OK) {
        depth_renderer_destroy(r);
        return result;
    }
    parallel_for(threads, c->vertex_count, 4096, transform_vertices, r);
    parallel_for(threads, c->triangle_count, 4096, bound_triangles, r);
    *out = r;
    return VXS_OK;
}

void depth_renderer_destroy(depth_renderer *r)
{
    if (!r) return;
    gl_context *gl         = r->gl;
    GLuint      textures[] = {r->texture_solid, r->texture_sheet, r->texture_layer[0], r->texture_layer[1], r->texture_count};
    gl->DeleteTextures(sizeof textures / sizeof *textures, textures);
    gl->DeleteFramebuffers(1, &r->framebuffer);
    gl->DeleteBuffers(2, r->buffers);
    gl->DeleteVertexArrays(1, &r->vertex_array);
    gl->DeleteProgram(r->program_depth);
    gl->DeleteProgram(r->program_count);
    gl->DeleteProgram(r->program_next);
    free(r->vertices);
    free(r->boxes);
    free(r->positions);
    free(r->vertex_slot);
    free(r->vertex_block);
    free(r->indices);
    free(r->triangles);
    free(r->sheet);
    free(r->layer[0]);
    free(r->layer[1]);
    free(r->count);
    free(r->cell_open);
    free(r);
}

depth_stats depth_renderer_stats(const depth_renderer *r)
{
    return r->stats;
}

int depth_renderer_has_exit(const depth_renderer *r)
{
    return r->casters->solid_triangle_count != 0;
}

/* what a block draws ---------------------------------------------------------------------------------------------------------- */

static int touches(const texel_box *b, int32_t u0, int32_t v0, int32_t side)
{
    return b->u0 <= b->u1 && b->v0 <= b->v1 && b->u0 < u0 + side && b->v0 < v0 + side && b->u1 >= u0 && b->v1 >= v0;
}

int depth_renderer_has_casters(const depth_renderer *r, uint32_t side_px, uint32_t i, uint32_t j)
{
    for (size_t n = 0; n < r->casters->triangle_count; n++)
        if (touches(&r->boxes[n], (int32_t)(i * side_px), (int32_t)(j * side_px), (int32_t)side_px)) return 1;
    return 0;
}

static float snapped(double texels)
{
    return (float)(floor(texels * SUBTEXELS + 0.5) / SUBTEXELS);
}

/* The slot of a vertex among those of this block; its position in clip space is exact but for the depth. */
static uint32_t block_vertex(depth_renderer *r, uint32_t vertex, int32_t u0, int32_t v0)
{
    if (r->vertex_block[vertex] != r->block_number) {
        const vertex_ls *p      = &r->vertices[vertex];
        float            to     = 2.0f / (float)r->block_px;
        float           *clip   = r->positions + 3 * (size_t)r->vertex_count;
        clip[0]                 = snapped(p->u - u0) * to - 1.0f;
        clip[1]                 = snapped(p->v - v0) * to - 1.0f;
        clip[2]                 = (float)p->z;
        r->vertex_block[vertex] = r->block_number;
        r->vertex_slot[vertex]  = r->vertex_count++;
    }
    return r->vertex_slot[vertex];
}

static void gather_triangles(depth_renderer *r, int32_t u0, int32_t v0)
{
    const casters *c  = r->casters;
    r->triangle_count = r->solid_count = r->vertex_count = 0;
    r->block_number++;
    for (size_t n = 0; n < c->triangle_count; n++) {
        if (!touches(&r->boxes[n], u0, v0, (int32_t)r->block_px)) continue;
        for (int k = 0; k < 3; k++) r->indices[3 * (size_t)r->triangle_count + k] = block_vertex(r, c->indices[3 * n + k], u0, v0);
        r->triangles[r->triangle_count++] = (uint32_t)n;
        r->solid_count += n < c->solid_triangle_count;
    }
}

/* 1 when some texel of the triangle's box may be open. */
static int touches_open_cell(const depth_renderer *r, const texel_box *b, int32_t u0, int32_t v0)
{
    int32_t cells = (int32_t)r->cell_side;
    int32_t last  = cells - 1;
    int32_t i0 = b->u0 <= u0 ? 0 : (b->u0 - u0) / CELL_PX, i1 = (b->u1 - u0) / CELL_PX;
    int32_t j0 = b->v0 <= v0 ? 0 : (b->v0 - v0) / CELL_PX, j1 = (b->v1 - v0) / CELL_PX;
    i1 = i1 > last ? last : i1;
    j1 = j1 > last ? last : j1;
    for (int32_t j = j0; j <= j1; j++)
        for (int32_t i = i0; i <= i1; i++)
            if (r->cell_open[j * cells + i]) return 1;
    return 0;
}

/* Of the block's solid triangles, keep those that may touch an open texel. */
static void gather_open_triangles(depth_renderer *r, int32_t u0, int32_t v0)
{
    uint32_t kept = 0;
    for (uint32_t n = 0; n < r->solid_count; n++) {
        if (!touches_open_cell(r, &r->boxes[r->triangles[n]], u0, v0)) continue;
        memmove(r->indices + 3 * (size_t)kept, r->indices + 3 * (size_t)n, 3 * sizeof *r->indices);
        r->triangles[kept++] = r->triangles[n];
    }
    r->solid_count = r->triangle_count = kept;
}

static void upload_indices(const depth_renderer *r)
{
    r->gl->BufferData(GL_ELEMENT_ARRAY_BUFFER, (GLsizeiptr)r->triangle_count * 3 * (GLsizeiptr)sizeof *r->indices, r->indices,
                      GL_STREAM_DRAW);
}

/* drawing --------------------------------------------------------------------------------------------------------------------- */

static void draw(depth_renderer *r, GLuint program, uint32_t first, uint32_t count)
{
    r->gl->UseProgram(program);
    r->gl->DrawElements(GL_TRIANGLES, (GLsizei)(count * 3), GL_UNSIGNED_INT,
                        (const void *)((uintptr_t)first * 3 * sizeof *r->indices));
    r->stats.triangles_drawn += count;
}

static void target(depth_renderer *r, GLuint depth, GLuint color)
{
    r->gl->FramebufferTexture(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, depth, 0);
    r->gl->FramebufferTexture(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, color, 0);
}

/* Read a rectangle of the current target into the same place of `to`, rows of row_px elements of `size` bytes. */
static void read_rect(const depth_renderer *r, block_rect a, GLenum format, GLenum type, void *to, uint32_t row_px, size_t size)
{
    r->gl->PixelStorei(GL_PACK_ROW_LENGTH, (GLint)row_px);
    r->gl->ReadPixels((GLint)a.u, (GLint)a.v, (GLsizei)a.width, (GLsizei)a.height, format, type,
                      (uint8_t *)to + ((size_t)a.v * row_px + a.u) * size);
}

static void read_depth(const depth_renderer *r, block_rect a, float *to, uint32_t row_px)
{
    read_rect(r, a, GL_DEPTH_COMPONENT, GL_FLOAT, to, row_px, sizeof *to);
}

static block_rect whole_block(const depth_renderer *r)
{
    return (block_rect){0, 0, r->block_px, r->block_px};
}

/* Nearest of some triangles into a cleared depth texture, and from there into `to`, rows of row_px texels. */
static void render_nearest(depth_renderer *r, GLuint depth, uint32_t first, uint32_t count, float *to, uint32_t row_px)
{
    const float far = 1.0f;
    target(r, depth, 0);
    r->gl->ClearBufferfv(GL_DEPTH, 0, &far);
    r->gl->DepthFunc(GL_LESS);
    draw(r, r->program_depth, first, count);
    read_depth(r, whole_block(r), to, row_px);
}

/* Nearest back faces of all texels, the first layer. */
static void render_first_layer(depth_renderer *r)
{
    r->gl->Enable(GL_CULL_FACE);
    r->gl->CullFace(GL_FRONT);
    render_nearest(r, r->texture_layer[0], 0, r->solid_count, r->layer[0], r->block_px);
    r->gl->Disable(GL_CULL_FACE);
}

/* Nearest back faces behind the last layer, in open texels. */
static void render_next_layer(depth_renderer *r, uint32_t pass)
{
    gl_context *gl      = r->gl;
    GLuint      texture = r->texture_layer[pass & 1];
    float      *layer   = r->layer[pass & 1];
    block_rect  a       = r->open;
    gl->PixelStorei(GL_UNPACK_ROW_LENGTH, (GLint)r->block_px);
    gl->TextureSubImage2D(texture, 0, (GLint)a.u, (GLint)a.v, (GLsizei)a.width, (GLsizei)a.height, GL_DEPTH_COMPONENT, GL_FLOAT,
                          layer + (size_t)a.v * r->block_px + a.u);
    target(r, texture, 0);
    gl->BindTextureUnit(0, r->texture_layer[(pass - 1) & 1]);
    gl->Enable(GL_CULL_FACE);
    gl->CullFace(GL_FRONT);
    gl->DepthFunc(GL_LESS);
    draw(r, r->program_next, 0, r->solid_count);
    gl->Disable(GL_CULL_FACE);
    read_depth(r, a, layer, r->block_px);
}

/* Front faces minus back faces at or before the layer. */
static void render_count(depth_renderer *r, uint32_t pass)
{
    gl_context *gl      = r->gl;
    const float zero[4] = {0};
    target(r, r->texture_layer[pass & 1], r->texture_count);
    gl->ClearBufferfv(GL_COLOR, 0, zero);
    gl->DepthFunc(GL_LEQUAL);
    gl->DepthMask(GL_FALSE);
    gl->Enable(GL_BLEND);
    gl->Enable(GL_CULL_FACE);
    gl->CullFace(GL_BACK);
    gl->BlendEquation(GL_FUNC_ADD);
    draw(r, r->program_count, 0, r->solid_count);
    gl->CullFace(GL_FRONT);
    gl->BlendEquation(GL_FUNC_REVERSE_SUBTRACT);
    draw(r, r->program_count, 0, r->solid_count);
    gl->Disable(GL_CULL_FACE);
    gl->Disable(GL_BLEND);
    gl->DepthMask(GL_TRUE);
    read_rect(r, r->open, GL_RED, GL_UNSIGNED_BYTE, r->count, r->block_px, sizeof *r->count);
}

/* exit depths ----------------------------------------------------------------------------------------------------------------- */

typedef struct block_job {
    depth_renderer *r;
    float          *enter, *exit; /* of the block, in rows of row_px */
    uint32_t        row_px;
    uint32_t        pass;
    uint32_t        first_is_exit; /* --exit back */
} block_job;

/* A run of texels of one cell, `count` of them, after the first pass: the first layer is everybody's exit for now, and stays it for
 * those that are done. `next` is where the next pass starts from. Returns whether one is open. */
static int resolve_first_run(const float *enter, const float *layer, const uint8_t *open_solids, uint32_t peel, float *x,
                             float *next, uint32_t count)
{
    uint32_t any = 0;
    for (uint32_t n = 0; n < count; n++) {
        float    first = layer[n] < 1.0f ? layer[n] : enter[n];
        uint32_t open  = peel & (layer[n] < 1.0f) & (open_solids[n] != 0);
        x[n]           = first > enter[n] ? first : enter[n];
        next[n]        = (float)open;
        any |= open;
    }
    return any != 0;
}

/* The same after a later pass; texels that were done have layer 0. A layer that did not move on would be met for ever: it ends the
 * search too. `last` is the layer before, and becomes where the next pass starts from. */
static int resolve_next_run(const float *layer, const uint8_t *open_solids, float *x, float *last, uint32_t count)
{
    uint32_t any = 0;
    for (uint32_t n = 0; n < count; n++) {
        uint32_t more = (layer[n] > 0.0f) & (layer[n] < 1.0f) & (layer[n] > last[n]);
        uint32_t open = more & (open_solids[n] != 0);
        x[n]          = more & !open ? layer[n] : x[n];
        last[n]       = (float)open;
        any |= open;
    }
    return any != 0;
}

/* Rows [begin, end) of open cells after a pass. */
static void resolve(void *user, size_t begin, size_t end, uint32_t worker)
{
    const block_job *job = user;
    depth_renderer  *r   = job->r;
    const float     *now = r->layer[job->pass & 1];
    float           *old = r->layer[(job->pass + 1) & 1];
    (void)worker;
    for (uint32_t row = r->open.v + (uint32_t)begin; row < r->open.v + (uint32_t)end; row++)
        for (uint32_t u = r->open.u; u < r->open.u + r->open.width; u += CELL_PX) {
            size_t   at = (size_t)row * r->block_px + u, out = (size_t)row * job->row_px + u;
            uint32_t count = r->block_px < CELL_PX ? r->block_px : CELL_PX;
            int      open  = job->pass ? resolve_next_run(now + at, r->count + at, job->exit + out, old + at, count)
                                       : resolve_first_run(job->enter + out, now + at, r->count + at, !job->first_is_exit,
                                                           job->exit + out, old + at, count);
            if (open) r->cell_open[row / CELL_PX * r->cell_side + u / CELL_PX] = 1;
        }
}

/* The rectangle of open cells; 0 when there is none. */
static int find_open(depth_renderer *r)
{
    uint32_t u0 = r->cell_side, v0 = r->cell_side, u1 = 0, v1 = 0;
    for (uint32_t v = 0; v < r->cell_side; v++)
        for (uint32_t u = 0; u < r->cell_side; u++) {
            if (!r->cell_open[v * r->cell_side + u]) continue;
            u0 = u < u0 ? u : u0;
            v0 = v < v0 ? v : v0;
            u1 = u + 1 > u1 ? u + 1 : u1;
            v1 = v + 1 > v1 ? v + 1 : v1;
        }
    uint32_t cell = r->block_px < CELL_PX ? r->block_px : CELL_PX;
    if (u0 < u1) r->open = (block_rect){u0 * cell, v0 * cell, (u1 - u0) * cell, (v1 - v0) * cell};
    return u0 < u1;
}

/* Exit depths of the block's solids, whose enter depths are in job->enter. */
static void render_exit(depth_renderer *r, block_job *job, int32_t u0, int32_t v0)
{
    gl_context *gl     = r->gl;
    job->first_is_exit = r->mode == EXIT_BACK;
    r->open            = whole_block(r);
    for (job->pass = 0;; job->pass++) {
        if (job->pass) {
            gather_open_triangles(r, u0, v0);
            upload_indices(r);
            gl->Enable(GL_SCISSOR_TEST);
            gl->Scissor((GLint)r->open.u, (GLint)r->open.v, (GLsizei)r->open.width, (GLsizei)r->open.height);
            render_next_layer(r, job->pass);
        } else {
            render_first_layer(r);
        }
        if (!job->first_is_exit) render_count(r, job->pass);
        memset(r->cell_open, 0, (size_t)r->cell_side * r->cell_side);
        /* grain: a row of cells belongs to one worker */
        parallel_for(r->threads, r->open.height, CELL_PX, resolve, job);
        if (!find_open(r)) break;
    }
    gl->Disable(GL_SCISSOR_TEST);
    uint32_t passes = job->first_is_exit ? 0 : job->pass + 1;
    r->stats.peel_passes += passes;
    if (passes > r->stats.peel_passes_max) r->stats.peel_passes_max = passes;
}

/* Where a sheet is met first, or at the same depth, a ray enters it and leaves it at once. */
static void mix_sheets(void *user, size_t begin, size_t end, uint32_t worker)
{
    const block_job *job = user;
    (void)worker;
    for (size_t row = begin; row < end; row++) {
        const float *sheet = job->r->sheet + row * job->r->block_px;
        float       *e = job->enter + row * job->row_px, *x = job->exit + row * job->row_px;
        for (uint32_t n = 0; n < job->r->block_px; n++) {
            int first = sheet[n] <= e[n];
            e[n]      = first ? sheet[n] : e[n];
            x[n]      = first ? sheet[n] : x[n];
        }
    }
}

static void fill_empty(const block_job *job)
{
    for (uint32_t row = 0; row < job->r->block_px; row++)
        for (uint32_t n = 0; n < job->r->block_px; n++)
            job->enter[(size_t)row * job->row_px + n] = job->exit[(size_t)row * job->row_px + n] = 1.0f;
}

static void copy_enter(const block_job *job)
{
    for (uint32_t row = 0; row < job->r->block_px && job->exit != job->enter; row++)
        memcpy(job->exit + (size_t)row * job->row_px, job->enter + (size_t)row * job->row_px, job->r->block_px * sizeof *job->exit);
}

static void render_block(depth_renderer *r, block_job *job, int32_t u0, int32_t v0)
{
    gather_triangles(r, u0, v0);
    if (!r->triangle_count) {
        r->stats.blocks_empty++;
        fill_empty(job);
        return;
    }
    r->stats.blocks_rendered++;
    r->gl->BufferData(GL_ARRAY_BUFFER, (GLsizeiptr)r->vertex_count * 3 * (GLsizeiptr)sizeof *r->positions, r->positions,
                      GL_STREAM_DRAW);
    upload_indices(r);

    uint32_t solids = r->solid_count, sheets = r->triangle_count - r->solid_count;
    if (!solids) {
        render_nearest(r, r->texture_sheet, 0, sheets, job->enter, job->row_px);
        copy_enter(job);
        return;
    }
    if (sheets) render_nearest(r, r->texture_sheet, solids, sheets, r->sheet, r->block_px);
    render_nearest(r, r->texture_solid, 0, solids, job->enter, job->row_px);
    render_exit(r, job, u0, v0);
    if (sheets) parallel_for(r->threads, r->block_px, CELL_PX, mix_sheets, job);
}

vxs_result depth_renderer_tile(depth_renderer *r, depth_maps *maps, uint32_t i, uint32_t j, message *m)
{
    for (uint32_t v = 0; v < maps->side_px; v += r->block_px)
        for (uint32_t u = 0; u < maps->side_px; u += r->block_px) {
            size_t    at  = (size_t)v * maps->side_px + u;
            block_job job = {.r = r, .enter = maps->enter + at, .exit = maps->exit + at, .row_px = maps->side_px};
            render_block(r, &job, (int32_t)(i * maps->side_px + u), (int32_t)(j * maps->side_px + v));
        }
    GLenum error = r->gl->GetError();
    if (error != GL_NO_ERROR) return fail(m, VXS_E_GL, "OpenGL failed while rendering depth maps (error 0x%04x)", error);
    return VXS_OK;
}
