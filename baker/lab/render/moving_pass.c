/* Moving casters; see moving_pass.h. A depth map covers the sphere around all of them: for a sun, a square across its direction;
 * for a punctual light, a frustum towards the sphere's centre, or, if the light is in the sphere or near it, six frusta.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/render/moving_pass.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/vec3.h"
#include "baker/light/map_space.h"

enum { SIDE_PX = 1024, BINDING = 6, UNIT = 6 };

/* A light's view: rows that give texture coordinates, depth and w from world space; and the width of a texel, in metres, per w. */
typedef struct moving_view {
    double rows[4][4], texel;
} moving_view;

/* Layout as in lit.glsl. */
typedef struct shader_view {
    float depth_from_point[16], texel[4];
} shader_view;

typedef struct shader_block {
    shader_view views[MOVING_MAPS];
    uint32_t    lights[][2]; /* [light_count] */
} shader_block;

/* views ------------------------------------------------------------------------------------------------------------------------ */

/* A row that gives the distance of a place from another along an axis, times scale, plus `more`. */
static void set_row(double row[4], const double axis[3], double scale, const double from[3], double more)
{
    for (int n = 0; n < 3; n++) row[n] = scale * axis[n];
    row[3] = more - scale * vec3_dot(axis, from);
}

static moving_view perspective_view(const double place[3], const double forward[3], double half_wide, double near, double far)
{
    moving_view v = {.texel = 2 * half_wide / SIDE_PX};
    double      right[3], up[3];
    vec3_across(forward, right, up);
    set_row(v.rows[3], forward, 1, place, 0);
    set_row(v.rows[0], right, 0.5 / half_wide, place, 0);
    set_row(v.rows[1], up, 0.5 / half_wide, place, 0);
    for (int n = 0; n < 4; n++) {
        v.rows[0][n] += 0.5 * v.rows[3][n];
        v.rows[1][n] += 0.5 * v.rows[3][n];
        v.rows[2][n] += far / (far - near) * v.rows[3][n];
    }
    v.rows[2][3] -= near * far / (far - near);
    return v;
}

/* The views of a sphere from a light.   Returns their number */
static uint32_t views_of(const vxs_light *light, const double middle[3], double radius, moving_view views[MOVING_FACES])
{
    light_shape   shape = baked_light_shape(light);
    const double *place = shape.position_ws;
    double        way[3], forward[3];
    if (shape.kind == LIGHT_DIRECTIONAL) {
        double right[3], up[3];
        views[0] = (moving_view){.rows[3] = {0, 0, 0, 1}, .texel = 2 * radius / SIDE_PX};
        vec3_across(light->direction_ws, right, up);
        set_row(views[0].rows[0], right, 0.5 / radius, middle, 0.5);
        set_row(views[0].rows[1], up, 0.5 / radius, middle, 0.5);
        set_row(views[0].rows[2], light->direction_ws, 0.5 / radius, middle, 0.5);
        return 1;
    }
    vec3_sub(middle, place, way);
    if (!light_reaches_ball(&shape, middle, radius)) return 0;
    double metres = sqrt(vec3_dot(way, way)), beside = metres * metres - radius * radius;
    if (metres > 1.25 * radius) {
        vec3_unit(way, forward);
        views[0] = perspective_view(place, forward, radius / sqrt(beside), metres - radius, metres + radius);
        return 1;
    }
    for (int n = 0; n < MOVING_FACES; n++) {
        double axis[3] = {0};
        axis[n / 2]    = n % 2 ? -1 : 1;
        views[n]       = perspective_view(place, axis, 1, 1e-3 * radius, metres + radius);
    }
    return MOVING_FACES;
}

/* create ----------------------------------------------------------------------------------------------------------------------- */

static size_t block_bytes(const moving_pass *p)
{
    return sizeof *p->block + p->light_count * sizeof *p->block->lights;
}

vxs_result moving_pass_create(moving_pass **out, gl_context *gl, const scene *s, const vxs_baked_light *const *lights,
                              uint32_t light_count, run_context *m)
{
    moving_pass *p = calloc(1, sizeof *p);
    *out           = p;
    if (!p) return fail(m, VXS_E_MEMORY, "out of memory for what moves");
    *p                = (moving_pass){.gl = gl, .lights = lights, .light_count = light_count};
    p->block          = calloc(1, block_bytes(p));
    vxs_result result = p->block ? surface_mesh_make(&p->mesh, gl, s, m) : fail(m, VXS_E_MEMORY, "out of memory for what moves");
    memcpy(p->first_middle_ws, p->mesh.middle_ws, sizeof p->first_middle_ws);
    if (result != VXS_OK) return result;

    gl->CreateTextures(GL_TEXTURE_2D_ARRAY, 1, &p->depths);
    gl->TextureStorage3D(p->depths, 1, GL_DEPTH_COMPONENT32F, SIDE_PX, SIDE_PX, MOVING_MAPS);
    gl->TextureParameteri(p->depths, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    gl->TextureParameteri(p->depths, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    gl->GenTextures(MOVING_MAPS, p->layers);
    gl->GenFramebuffers(MOVING_MAPS, p->frames);
    for (GLuint n = 0; n < MOVING_MAPS; n++) {
        gl->TextureView(p->layers[n], GL_TEXTURE_2D, p->depths, GL_DEPTH_COMPONENT32F, 0, 1, n, 1);
        gl->TextureParameteri(p->layers[n], GL_TEXTURE_MIN_FILTER, GL_NEAREST);
        gl->TextureParameteri(p->layers[n], GL_TEXTURE_MAG_FILTER, GL_NEAREST);
        gl->BindFramebuffer(GL_FRAMEBUFFER, p->frames[n]);
        gl->FramebufferTextureLayer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, p->depths, 0, (GLint)n);
        gl->DrawBuffers(0, NULL);
    }
    gl->GenBuffers(1, &p->buffer);
    if (gl->GetError() == GL_NO_ERROR) return VXS_OK;
    return fail(m, VXS_E_MEMORY, "OpenGL has no room for %d depth maps of what moves", MOVING_MAPS);
}

void moving_pass_destroy(moving_pass *p)
{
    if (!p) return;
    surface_mesh_free(&p->mesh, p->gl);
    if (p->buffer) p->gl->DeleteBuffers(1, &p->buffer);
    p->gl->DeleteFramebuffers(MOVING_MAPS, p->frames);
    p->gl->DeleteTextures(MOVING_MAPS, p->layers);
    p->gl->DeleteTextures(1, &p->depths);
    free(p->block);
    free(p);
}

/* cast ------------------------------------------------------------------------------------------------------------------------- */

/* The matrix from positions relative to from_ws to clip space, where x and y are in [-1, 1] and depth is in [0, 1]; or to
 * texture coordinates. Column-major. */
static void set_matrix(const moving_view *v, const double from_ws[3], int is_clip, float matrix[16])
{
    for (int row = 0; row < 4; row++) {
        double r[4];
        memcpy(r, v->rows[row], sizeof r);
        r[3] += vec3_dot(r, from_ws);
        for (int n = 0; n < 4; n++) matrix[4 * n + row] = (float)r[n];
    }
    for (int n = 0; n < 8 && is_clip; n++) {
        int at     = 4 * (n / 2) + n % 2;
        matrix[at] = 2 * matrix[at] - matrix[4 * (n / 2) + 3];
    }
}

static void draw_light(moving_pass *p, uint32_t light, GLuint program, const double eye_ws[3], moving_plan *plan)
{
    moving_view views[MOVING_FACES];
    uint32_t    count = views_of(&p->lights[light]->light, p->mesh.middle_ws, 0.5 * p->mesh.size_metres, views);
    if (plan->maps + count > MOVING_MAPS) {
        plan->left_out++;
        count = 0;
    }
    p->block->lights[light][0] = plan->maps;
    p->block->lights[light][1] = count;
    plan->lights += count > 0;
    for (uint32_t n = 0; n < count; n++) {
        uint32_t          map      = plan->maps++;
        shader_view      *to       = &p->block->views[map];
        const gl_context *gl       = p->gl;
        const float       farthest = 1;
        float             matrix[16];
        set_matrix(&views[n], p->mesh.middle_ws, 1, matrix);
        gl->BindFramebuffer(GL_FRAMEBUFFER, p->frames[map]);
        gl->ClearBufferfv(GL_DEPTH, 0, &farthest);
        gl->ProgramUniformMatrix4fv(program, gl->GetUniformLocation(program, "clip_from_scene"), 1, GL_FALSE, matrix);
        surface_mesh_draw(&p->mesh, gl, program);
        set_matrix(&views[n], eye_ws, 0, to->depth_from_point);
        to->texel[0] = (float)views[n].texel;
    }
}

void moving_pass_cast(moving_pass *p, GLuint program, const double by_ws[3], const double eye_ws[3], moving_plan *plan)
{
    const gl_context *gl = p->gl;
    *plan                = (moving_plan){0};
    for (int n = 0; n < 3; n++) p->mesh.middle_ws[n] = p->first_middle_ws[n] + by_ws[n];
    gl->Viewport(0, 0, SIDE_PX, SIDE_PX);
    gl->ClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
    gl->Enable(GL_DEPTH_TEST);
    gl->DepthMask(GL_TRUE);
    gl->DepthFunc(GL_LESS);
    gl->UseProgram(program);
    for (uint32_t n = 0; n < p->light_count; n++) draw_light(p, n, program, eye_ws, plan);
    gl->Disable(GL_DEPTH_TEST);
    gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, p->buffer);
    gl->BufferData(GL_SHADER_STORAGE_BUFFER, (GLsizeiptr)block_bytes(p), p->block, GL_STREAM_DRAW);
}

void moving_pass_bind(const moving_pass *p)
{
    p->gl->BindTextureUnit(UNIT, p->depths);
    p->gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, BINDING, p->buffer);
}

uint32_t moving_pass_casters(const moving_pass *p, uint32_t light, vxs_moving_casters casters[MOVING_FACES])
{
    uint32_t first = p->block->lights[light][0], count = p->block->lights[light][1];
    for (uint32_t n = 0; n < count; n++) {
        casters[n] = (vxs_moving_casters){
            .depth_texture = p->layers[first + n], .width_px = SIDE_PX, .height_px = SIDE_PX, .empty_depth = 1};
        memcpy(casters[n].depth_from_point, p->block->views[first + n].depth_from_point, sizeof casters[n].depth_from_point);
    }
    return count;
}
