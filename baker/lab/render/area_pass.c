/* Area lights; see vpl_pass.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/render/vpl_pass.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/vec3.h"

EMBEDDED(glow_glsl)

enum { DENSE = 16 }; /* virtual lights that determine where points for shadows are densest */

/* shares ----------------------------------------------------------------------------------------------------------------------- */

static double luminance_of(const scene_area *a, const float *texel)
{
    return 0.2126 * (double)(a->radiance[0] * texel[0]) + 0.7152 * (double)(a->radiance[1] * texel[1]) +
           0.0722 * (double)(a->radiance[2] * texel[2]);
}

/* Distribute virtual lights by power to the parallelograms that are not behind the view, in descending order of power. Each gets
 * at least one, until none is left.
 * powers  [count]
 * shares  [count] in: cull_result AREA_BEHIND or any other; out: the decisions */
static void area_plan_share(const double *powers, area_share *shares, uint32_t count, uint32_t vpls, area_plan *plan)
{
    double   all  = 0;
    uint32_t rest = 0;
    *plan         = (area_plan){0};
    for (uint32_t n = 0; n < count; n++) {
        shares[n] = (area_share){shares[n].cull_result == AREA_BEHIND ? AREA_BEHIND : AREA_FAINT, 0};
        if (shares[n].cull_result == AREA_FAINT) all += powers[n];
        rest += shares[n].cull_result == AREA_FAINT && powers[n] > 0;
    }
    while (plan->vpls < vpls && rest) {
        uint32_t best = count; /* the brightest parallelogram without a share */
        for (uint32_t n = 0; n < count; n++)
            if (shares[n].cull_result == AREA_FAINT && powers[n] > 0 && (best == count || powers[n] > powers[best])) best = n;
        uint32_t left = vpls - plan->vpls, most = left > rest-- ? left - rest : 1;
        double   part = all > powers[best] ? round(left * (powers[best] / all)) : left;
        shares[best]  = (area_share){AREA_DRAWN, (uint32_t)fmin(fmax(part, 1), most)};
        plan->vpls += shares[best].vpls;
        all -= powers[best];
    }
    for (uint32_t n = 0; n < count; n++) plan->areas[shares[n].cull_result]++;
}

/* set-up ----------------------------------------------------------------------------------------------------------------------- */

static vxs_area_rectangle rectangle_of(const area_pass *p, const scene_area *a, double exposure)
{
    vxs_area_rectangle r = {.texture = a->texture, .wide_px = a->wide_px, .high_px = a->high_px};
    for (int n = 0; n < 3; n++) {
        r.corner[n]   = (float)(a->corner_ws[n] - p->options.lit.middle_ws[n]);
        r.across[n]   = (float)a->across_ws[n];
        r.up[n]       = (float)a->up_ws[n];
        r.radiance[n] = (float)(exposure * p->options.scale * (double)a->radiance[n]);
    }
    return r;
}

/* The virtual lights of all parallelograms with a share.   vpls  [out] as many as all shares, `count` */
static vxs_result place_vpls(const area_pass *p, double exposure, vxs_vpl *vpls, uint32_t *count)
{
    vxs_result result = VXS_OK;
    *count            = 0;
    for (uint32_t n = 0; n < p->count && result == VXS_OK; n++) {
        vxs_area_rectangle r = rectangle_of(p, &p->options.lit.scene->areas[n], exposure);
        if (p->shares[n].vpls) result = vxs_area_sample(&r, VXS_AREA_IMPORTANCE, 0, vpls + *count, p->shares[n].vpls);
        *count += p->shares[n].vpls;
    }
    return result;
}

vxs_result area_pass_create(area_pass **out, const area_pass_options *o, const gl_context *gl, vxs_volumes *volumes, run_context *m)
{
    area_pass *p = calloc(1, sizeof *p);
    *out         = p;
    if (!p) return fail(m, VXS_E_MEMORY, "out of memory for area lights");
    p->options = *o;
    p->gl      = gl;
    p->count   = (uint32_t)o->lit.scene->area_count;

    static const float white[3] = {1, 1, 1};
    const scene       *s        = p->options.lit.scene;
    vxs_vpl            dense[DENSE];
    vxs_result         r;
    p->powers   = calloc(p->count, sizeof *p->powers);
    p->shares   = calloc(p->count, sizeof *p->shares);
    p->next     = calloc(p->count, sizeof *p->next);
    p->textures = calloc(p->count, sizeof *p->textures);
    if (!p->powers || !p->shares || !p->next || !p->textures)
        return fail(m, VXS_E_MEMORY, "out of memory for %u area lights", p->count);
    for (uint32_t n = 0; n < p->count; n++) {
        /* the power that is emitted on its front: its area times the mean luminance */
        size_t texels = (size_t)s->areas[n].wide_px * s->areas[n].high_px;
        double normal[3], sum = texels ? 0 : luminance_of(&s->areas[n], white);
        for (size_t k = 0; k < texels; k++) sum += luminance_of(&s->areas[n], s->areas[n].texture + 3 * k);
        vec3_cross(s->areas[n].across_ws, s->areas[n].up_ws, normal);
        p->powers[n] = sqrt(vec3_dot(normal, normal)) * sum / (double)(texels ? texels : 1);
    }
    vpl_pass_options lit = p->options.lit;
    area_plan        plan;
    area_plan_share(p->powers, p->shares, p->count, DENSE, &plan);
    if (place_vpls(p, 1, dense, &lit.dense_count) != VXS_OK) lit.dense_count = 0; /* the frame reports the reason */
    lit.dense = dense;
    if ((r = vpl_pass_create(&p->vpls, &lit, gl, volumes, m)) != VXS_OK) return r;
    if ((r = gl_program_of(gl, &p->glow_program, glow_glsl, (gl_text){0}, m)) != VXS_OK) return r;
    for (uint32_t n = 0; n < p->count; n++) {
        const scene_area *a    = &p->options.lit.scene->areas[n];
        GLsizei           wide = a->texture ? (GLsizei)a->wide_px : 1, high = a->texture ? (GLsizei)a->high_px : 1;
        gl->CreateTextures(GL_TEXTURE_2D, 1, &p->textures[n]);
        gl->TextureStorage2D(p->textures[n], 1, GL_RGBA32F, wide, high);
        gl->TextureSubImage2D(p->textures[n], 0, 0, 0, wide, high, GL_RGB, GL_FLOAT, a->texture ? a->texture : white);
        gl->TextureParameteri(p->textures[n], GL_TEXTURE_MIN_FILTER, GL_LINEAR);
        gl->TextureParameteri(p->textures[n], GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
        gl->TextureParameteri(p->textures[n], GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    }
    return VXS_OK;
}

void area_pass_destroy(area_pass *p)
{
    if (!p) return;
    vpl_pass_destroy(p->vpls);
    if (p->textures) p->gl->DeleteTextures((GLsizei)p->count, p->textures);
    if (p->glow_program) p->gl->DeleteProgram(p->glow_program);
    free(p->powers);
    free(p->shares);
    free(p->next);
    free(p->textures);
    free(p);
}

/* frame ------------------------------------------------------------------------------------------------------------------------ */

/* Whether a capsule is, at least partly, in front of a drawn area light. */
static int is_reached(const void *pass, const vxs_capsule *c)
{
    const area_pass *p = pass;
    for (uint32_t n = 0; n < p->count; n++) {
        const scene_area *a    = &p->options.lit.scene->areas[n];
        double            most = -INFINITY, normal[3], way[3];
        vec3_cross(a->across_ws, a->up_ws, normal);
        for (int end = 0; end < 2; end++) {
            for (int i = 0; i < 3; i++)
                way[i] = (double)(end ? c->end : c->begin)[i] + p->options.lit.middle_ws[i] - a->corner_ws[i];
            most = fmax(most, vec3_dot(way, normal));
        }
        if (p->shares[n].vpls && most > -(double)c->radius_metres * sqrt(vec3_dot(normal, normal))) return 1;
    }
    return 0;
}

vxs_result area_pass_draw(area_pass *p, const double eye_ws[3], const camera_view *seen, const double moved_ws[3],
                          double far_metres, unsigned normals, double exposure, area_plan *plan, run_context *m)
{
    vxs_result r     = VXS_OK;
    int        moved = vpl_pass_move(p->vpls, moved_ws);
    for (uint32_t n = 0; n < p->count; n++) {
        const scene_area *a = &p->options.lit.scene->areas[n];
        double            normal[3], way[3];
        vec3_cross(a->across_ws, a->up_ws, normal);
        vec3_sub(eye_ws, a->corner_ws, way);
        double eye = vec3_dot(way, normal), across = fabs(vec3_dot(seen->right, normal)), up = fabs(vec3_dot(seen->up, normal));
        double farthest        = eye + far_metres * (vec3_dot(seen->forward, normal) + across + up);
        p->next[n].cull_result = eye <= 0 && farthest <= 0 ? AREA_BEHIND : AREA_FAINT; /* no point of a ray is in front of it */
    }
    area_plan_share(p->powers, p->next, p->count, p->options.lit.vpls, plan);
    int same = exposure == p->exposure && !memcmp(p->shares, p->next, p->count * sizeof *p->next);
    memcpy(p->shares, p->next, p->count * sizeof *p->next);
    if (plan->vpls && (moved || !same)) {
        vxs_vpl  vpls[VXS_VPLS_MAX];
        uint32_t count;
        r = place_vpls(p, exposure, vpls, &count);
        if (r == VXS_OK) r = vpl_pass_set(p->vpls, vpls, count, is_reached, p);
        p->exposure = r == VXS_OK ? exposure : 0;
    }
    if (r == VXS_OK && plan->vpls) r = vpl_pass_draw(p->vpls, eye_ws, normals);
    return r == VXS_OK ? VXS_OK : fail(m, r, "area lights cannot be drawn: %s", vxs_result_text(r));
}

void area_pass_add_light(const area_pass *p)
{
    vpl_pass_add_light(p->vpls, p->exposure);
}

static void set_vector(const gl_context *gl, GLuint program, const char *name, const float v[3])
{
    gl->ProgramUniform3f(program, gl->GetUniformLocation(program, name), v[0], v[1], v[2]);
}

void area_pass_add_glow(const area_pass *p, const float clip_from_scene[16], unsigned depths, const double eye_ws[3],
                        double exposure)
{
    const gl_context *gl      = p->gl;
    GLuint            program = p->glow_program;
    vpl_pass_begin_adding(p->vpls, program);
    gl->ProgramUniformMatrix4fv(program, gl->GetUniformLocation(program, "clip_from_scene"), 1, GL_FALSE, clip_from_scene);
    gl->BindTextureUnit(0, depths);
    for (uint32_t n = 0; n < p->count; n++) {
        const scene_area *a = &p->options.lit.scene->areas[n];
        double            normal[3], way[3];
        vec3_cross(a->across_ws, a->up_ws, normal);
        vec3_sub(eye_ws, a->corner_ws, way);
        if (!(vec3_dot(normal, way) > 0)) continue; /* the eye sees its back */
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
