/* Area lights; see area_pass.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/render/area_pass.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/vec3.h"
#include "baker/render/renderer_state.h"

EMBEDDED(screen_vert_glsl)
EMBEDDED(area_frag_glsl)
EMBEDDED(glow_vert_glsl)
EMBEDDED(glow_frag_glsl)

const char *const area_gather_names[] = {"each", "ninths", "quarter"};

static const double pi = 3.14159265358979324;

/* Of all triangles, by area; and of those that move. Virtual lights are many, and each has its curves of smoke. */
enum { POINTS = 1 << 18, MOVING_POINTS = 1 << 15, SMOKE_SIDE_MOST = 64 };

struct area_pass {
    area_pass_options options;
    const gl_context *gl;
    vxs_volumes      *volumes;
    vxs_area_light   *light;
    double           *powers;        /* [areas] */
    area_share       *shares, *next; /* [areas] of the last frame; of this one */
    double            exposure;      /* that its lamps have; 0: there are none */
    uint32_t          count, points; /* areas; points of what stands, which come first in the buffer */
    uint32_t          moving_points;
    vxs_area_point   *moving, *moved; /* [moving_points] where they are in their file; and now */
    double            moved_ws[3];    /* by how much */
    int               has_moved;      /* since shadow maps were cast */
    vxs_capsule      *capsules;       /* [options.smoke->count] of smoke: those that lamps of the last frame shine on */
    uint32_t          capsule_count;
    GLuint            buffer, add_program, glow_program, empty_array;
    GLuint           *textures; /* [areas] */
};

/* what is made once --------------------------------------------------------------------------------------------------------------- */

/* Over a scene's triangles.   found  [out] how many: none, where they have no area */
static vxs_result scatter(const area_pass *p, const scene *s, vxs_area_point *points, uint32_t count, uint32_t *found, message *m)
{
    float *positions = malloc(3 * s->vertex_count * sizeof *positions);
    if (!positions) return fail(m, VXS_E_MEMORY, "out of memory for %u points of shadows", count);
    for (size_t n = 0; n < 3 * s->vertex_count; n++) positions[n] = (float)(s->positions_ws[n] - p->options.middle_ws[n % 3]);
    *found = vxs_area_scatter(positions, s->indices, (uint32_t)s->triangle_count, points, count) > 0 ? count : 0;
    free(positions);
    return VXS_OK;
}

static vxs_result scatter_moving(area_pass *p, message *m)
{
    if (!p->options.moving) return VXS_OK;
    p->moving = malloc(MOVING_POINTS * sizeof *p->moving);
    p->moved  = malloc(MOVING_POINTS * sizeof *p->moved);
    if (!p->moving || !p->moved) return fail(m, VXS_E_MEMORY, "out of memory for %d points of shadows", MOVING_POINTS);
    return scatter(p, p->options.moving, p->moving, MOVING_POINTS, &p->moving_points, m);
}

/* Where they are now, behind those that stand. */
static void put_moving(area_pass *p, const double moved_ws[3])
{
    GLsizeiptr size = sizeof *p->moved;
    for (uint32_t n = 0; n < p->moving_points; n++) {
        p->moved[n] = p->moving[n];
        for (int k = 0; k < 3; k++) p->moved[n].place[k] += (float)moved_ws[k];
    }
    p->gl->NamedBufferSubData(p->buffer, p->points * size, p->moving_points * size, p->moved);
    memcpy(p->moved_ws, moved_ws, sizeof p->moved_ws);
    p->has_moved = 1;
}

static vxs_result put_points(area_pass *p, message *m)
{
    static const double     nowhere[3] = {0};
    const vxs_baked_points *baked      = p->options.points;
    uint32_t                most       = baked ? baked->count : POINTS;
    vxs_area_point         *points     = malloc(most * sizeof *points);
    vxs_result r = points ? scatter_moving(p, m) : fail(m, VXS_E_MEMORY, "out of memory for %u points of shadows", most);
    p->points    = most;
    if (r == VXS_OK && baked) vxs_points_unpack(baked, p->options.middle_ws, points->place);
    if (r == VXS_OK && !baked) r = scatter(p, p->options.scene, points, most, &p->points, m);
    GLsizeiptr size = sizeof *points, still = r == VXS_OK ? p->points * size : 0;
    p->gl->GenBuffers(1, &p->buffer);
    p->gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, p->buffer);
    p->gl->BufferData(GL_SHADER_STORAGE_BUFFER, still + p->moving_points * size, NULL, GL_DYNAMIC_DRAW);
    if (still) p->gl->NamedBufferSubData(p->buffer, 0, still, points);
    if (p->moving_points) put_moving(p, nowhere);
    free(points);
    return r;
}

static void put_texture(area_pass *p, uint32_t n)
{
    static const float white[3] = {1, 1, 1};
    const gl_context  *gl       = p->gl;
    const scene_area  *a        = &p->options.scene->areas[n];
    GLsizei            wide = a->texture ? (GLsizei)a->wide_px : 1, high = a->texture ? (GLsizei)a->high_px : 1;
    gl->CreateTextures(GL_TEXTURE_2D, 1, &p->textures[n]);
    gl->TextureStorage2D(p->textures[n], 1, GL_RGBA32F, wide, high);
    gl->TextureSubImage2D(p->textures[n], 0, 0, 0, wide, high, GL_RGB, GL_FLOAT, a->texture ? a->texture : white);
    gl->TextureParameteri(p->textures[n], GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    gl->TextureParameteri(p->textures[n], GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    gl->TextureParameteri(p->textures[n], GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
}

static vxs_result make(area_pass *p, message *m)
{
    text_part           add = part_of(area_frag_glsl), glow = part_of(glow_frag_glsl);
    uint32_t            capsules = p->options.smoke ? p->options.smoke->count : 0;
    vxs_area_light_desc desc     = {.lamps = p->options.lamps, .capsules = capsules, .smoke_side_px = p->options.smoke_side};
    vxs_result          r;
    p->powers   = calloc(p->count, sizeof *p->powers);
    p->shares   = calloc(p->count, sizeof *p->shares);
    p->next     = calloc(p->count, sizeof *p->next);
    p->textures = calloc(p->count, sizeof *p->textures);
    p->capsules = calloc(capsules + !capsules, sizeof *p->capsules);
    if (!p->powers || !p->shares || !p->next || !p->textures || !p->capsules)
        return fail(m, VXS_E_MEMORY, "out of memory for %u area lights", p->count);
    for (uint32_t n = 0; n < p->count; n++) p->powers[n] = area_power(&p->options.scene->areas[n]);
    if ((r = vxs_area_light_create(&p->light, p->volumes, &desc)) != VXS_OK)
        return fail(m, r, "OpenGL cannot draw area lights of %u lamps: %s", p->options.lamps, vxs_result_text(r));
    if ((r = renderer_program(p->gl, &p->add_program, screen_vert_glsl, &add, 1, m)) != VXS_OK) return r;
    if ((r = renderer_program(p->gl, &p->glow_program, glow_vert_glsl, &glow, 1, m)) != VXS_OK) return r;
    p->gl->GenVertexArrays(1, &p->empty_array);
    for (uint32_t n = 0; n < p->count; n++) put_texture(p, n);
    return put_points(p, m);
}

vxs_result area_pass_create(area_pass **out, const area_pass_options *o, const gl_context *gl, vxs_volumes *volumes, message *m)
{
    area_pass *p = calloc(1, sizeof *p);
    *out         = NULL;
    if (!p) return fail(m, VXS_E_MEMORY, "out of memory for area lights");
    p->options   = *o;
    if (o->smoke_side > SMOKE_SIDE_MOST) p->options.smoke_side = SMOKE_SIDE_MOST;
    p->gl        = gl;
    p->volumes   = volumes;
    p->count     = (uint32_t)o->scene->area_count;
    vxs_result r = make(p, m);
    if (r == VXS_OK)
        *out = p;
    else
        area_pass_destroy(p);
    return r;
}

void area_pass_destroy(area_pass *p)
{
    if (!p) return;
    vxs_area_light_destroy(p->light);
    if (p->textures) p->gl->DeleteTextures((GLsizei)p->count, p->textures);
    if (p->buffer) p->gl->DeleteBuffers(1, &p->buffer);
    if (p->add_program) p->gl->DeleteProgram(p->add_program);
    if (p->glow_program) p->gl->DeleteProgram(p->glow_program);
    if (p->empty_array) p->gl->DeleteVertexArrays(1, &p->empty_array);
    free(p->moving);
    free(p->moved);
    free(p->capsules);
    free(p->powers);
    free(p->shares);
    free(p->next);
    free(p->textures);
    free(p);
}

/* a frame ------------------------------------------------------------------------------------------------------------------------- */

static vxs_area_rectangle rectangle_of(const area_pass *p, const scene_area *a, double exposure)
{
    vxs_area_rectangle r = {.texture = a->texture, .wide_px = a->wide_px, .high_px = a->high_px};
    for (int n = 0; n < 3; n++) {
        r.corner[n]   = (float)(a->corner_ws[n] - p->options.middle_ws[n]);
        r.across[n]   = (float)a->across_ws[n];
        r.up[n]       = (float)a->up_ws[n];
        r.radiance[n] = (float)(exposure * p->options.scale * (double)a->radiance[n]);
    }
    return r;
}

/* Whether some of a capsule is before a light that is drawn.   c  places count from the middle */
static int is_shone_on(const area_pass *p, const vxs_capsule *c)
{
    for (uint32_t n = 0; n < p->count; n++) {
        const scene_area *a    = &p->options.scene->areas[n];
        double            most = -INFINITY, normal[3], way[3];
        vec3_cross(a->across_ws, a->up_ws, normal);
        for (int end = 0; end < 2; end++) {
            for (int i = 0; i < 3; i++) way[i] = (double)(end ? c->end : c->begin)[i] + p->options.middle_ws[i] - a->corner_ws[i];
            most = fmax(most, vec3_dot(way, normal));
        }
        if (p->shares[n].lamps && most > -(double)c->radius_metres * sqrt(vec3_dot(normal, normal))) return 1;
    }
    return 0;
}

/* What smoke leaves of each lamp. */
static vxs_result dim(area_pass *p)
{
    const scene_smoke *smoke = p->options.smoke;
    p->capsule_count         = 0;
    for (uint32_t n = 0; smoke && n < smoke->count; n++) {
        vxs_capsule *c = &p->capsules[p->capsule_count];
        *c             = smoke->list[n];
        smoke_from_eye(smoke, c, p->options.middle_ws);
        p->capsule_count += (uint32_t)is_shone_on(p, c);
    }
    return vxs_area_light_smoke(p->light, &(vxs_capsules){.list = p->capsules, .count = p->capsule_count});
}

/* Lamps of all that are drawn, what smoke leaves of them, and their shadow maps: again, where something has moved. */
static vxs_result cast(area_pass *p, double exposure)
{
    vxs_area_lamp lamps[VXS_AREA_LAMPS];
    uint32_t      count  = 0;
    vxs_result    result = VXS_OK;
    for (uint32_t n = 0; n < p->count && result == VXS_OK; n++) {
        vxs_area_rectangle r = rectangle_of(p, &p->options.scene->areas[n], exposure);
        if (p->shares[n].lamps) result = vxs_area_sample(&r, VXS_AREA_IMPORTANCE, 0, lamps + count, p->shares[n].lamps);
        count += p->shares[n].lamps;
    }
    if (result == VXS_OK) result = vxs_area_light_set(p->light, lamps, count);
    int stay = vxs_area_light_is_cast(p->light);
    if (result == VXS_OK && !stay) result = dim(p);
    if (result == VXS_OK && (p->has_moved || !stay))
        result = vxs_area_light_cast(p->light, &(vxs_area_casters){p->buffer, p->points + p->moving_points, 0});
    p->exposure  = result == VXS_OK ? exposure : 0;
    p->has_moved = 0;
    return result;
}

static int is_as_before(const area_pass *p, double exposure)
{
    return exposure == p->exposure && !memcmp(p->shares, p->next, p->count * sizeof *p->next);
}

vxs_result area_pass_draw(area_pass *p, const double eye_ws[3], const camera_view *seen, const double moved_ws[3],
                          double far_metres, unsigned normals, double exposure, area_plan *plan, message *m)
{
    float      anchor[3];
    vxs_result r = VXS_OK;
    if (p->moving_points && memcmp(moved_ws, p->moved_ws, sizeof p->moved_ws)) put_moving(p, moved_ws);
    for (uint32_t n = 0; n < p->count; n++)
        p->next[n].fate = area_is_behind(&p->options.scene->areas[n], eye_ws, seen, far_metres) ? AREA_BEHIND : AREA_FAINT;
    area_plan_share(p->powers, p->next, p->count, p->options.lamps, plan);
    int same = is_as_before(p, exposure);
    memcpy(p->shares, p->next, p->count * sizeof *p->next);
    for (int n = 0; n < 3; n++) anchor[n] = (float)(p->options.middle_ws[n] - eye_ws[n]);
    if (plan->lamps && (p->has_moved || !same)) r = cast(p, exposure);
    if (r == VXS_OK) r = vxs_area_light_anchor(p->light, anchor);
    if (r == VXS_OK && plan->lamps)
        r = vxs_volumes_area(p->volumes, p->light, &(vxs_area_look){.gather = p->options.gather, .normal_texture = normals});
    return r == VXS_OK ? VXS_OK : fail(m, r, "area lights cannot be drawn: %s", vxs_result_text(r));
}

static void begin_adding(const area_pass *p, GLuint program)
{
    p->gl->Enable(GL_BLEND);
    p->gl->BlendEquation(GL_FUNC_ADD);
    p->gl->BlendFunc(GL_ONE, GL_ONE);
    p->gl->UseProgram(program);
    p->gl->BindVertexArray(p->empty_array);
}

void area_pass_add_light(const area_pass *p)
{
    const gl_context *gl = p->gl;
    begin_adding(p, p->add_program);
    gl->BindTextureUnit(0, vxs_area_light_irradiance(p->light));
    gl->ProgramUniform1f(p->add_program, gl->GetUniformLocation(p->add_program, "factor"), (float)(1 / (pi * p->exposure)));
    gl->DrawArrays(GL_TRIANGLES, 0, 3);
    gl->Disable(GL_BLEND);
}

static void set_vector(const gl_context *gl, GLuint program, const char *name, const float v[3])
{
    gl->ProgramUniform3f(program, gl->GetUniformLocation(program, name), v[0], v[1], v[2]);
}

/* Whether the eye sees the side that shines. */
static int is_seen(const scene_area *a, const double eye_ws[3])
{
    double normal[3], way[3];
    vec3_cross(a->across_ws, a->up_ws, normal);
    vec3_sub(eye_ws, a->corner_ws, way);
    return vec3_dot(normal, way) > 0;
}

void area_pass_add_glow(const area_pass *p, const float clip_from_scene[16], unsigned depths, const double eye_ws[3],
                        double exposure)
{
    const gl_context *gl      = p->gl;
    GLuint            program = p->glow_program;
    begin_adding(p, program);
    gl->ProgramUniformMatrix4fv(program, gl->GetUniformLocation(program, "clip_from_scene"), 1, GL_FALSE, clip_from_scene);
    gl->BindTextureUnit(0, depths);
    for (uint32_t n = 0; n < p->count; n++) {
        const scene_area *a = &p->options.scene->areas[n];
        if (!is_seen(a, eye_ws)) continue;
        vxs_area_rectangle r = rectangle_of(p, a, exposure);
        set_vector(gl, program, "corner", r.corner);
        set_vector(gl, program, "across", r.across);
        set_vector(gl, program, "up", r.up);
        set_vector(gl, program, "radiance", r.radiance);
        gl->BindTextureUnit(1, p->textures[n]);
        gl->DrawArrays(GL_TRIANGLE_STRIP, 0, 4);
    }
    gl->Disable(GL_BLEND);
}

const area_share *area_pass_shares(const area_pass *p)
{
    return p->shares;
}

uint32_t area_pass_points(const area_pass *p)
{
    return p->points + p->moving_points;
}

uint32_t area_pass_capsules(const area_pass *p, uint32_t *smoke_side)
{
    *smoke_side = p->options.smoke_side;
    return p->capsule_count;
}

unsigned area_pass_irradiance(const area_pass *p)
{
    return vxs_area_light_irradiance(p->light);
}
