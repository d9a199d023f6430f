/* A renderer is made; see render.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/memory.h"
#include "baker/base/vec3.h"
#include "baker/lab/render/renderer_state.h"

EMBEDDED(surface_glsl)
EMBEDDED(shade_frag_glsl)
EMBEDDED(tone_frag_glsl)

static const double pi = 3.14159265358979324;

/* targets ---------------------------------------------------------------------------------------------------------------------- */

static vxs_result make_targets(renderer *r, run_context *m)
{
    static const GLenum formats[TARGETS] = {
        GL_DEPTH_COMPONENT32F, GL_RGBA32F, GL_RGBA8, GL_RGBA32F, GL_RGBA32F, GL_RGBA32F, GL_RGBA32F};
    const gl_context *gl = r->gl;
    for (int n = 0; n < TARGETS; n++) {
        int small = n == SCREEN || n == LINEAR;
        if (n == PICTURE && !r->fog) continue;
        gl->CreateTextures(GL_TEXTURE_2D, 1, &r->target[n]);
        gl->TextureStorage2D(r->target[n], 1, formats[n], (GLsizei)(small ? r->options.width_px : r->width),
                             (GLsizei)(small ? r->options.height_px : r->height));
        gl->TextureParameteri(r->target[n], GL_TEXTURE_MIN_FILTER, GL_NEAREST);
        gl->TextureParameteri(r->target[n], GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    }
    r->surface_frame = gl_frame(gl, r->target[DEPTHS], &r->target[NORMALS], 2);
    r->light_frame   = gl_frame(gl, 0, &r->target[LIGHTS], 1);
    r->screen_frame  = gl_frame(gl, 0, &r->target[SCREEN], 2);
    if (r->fog) r->picture_frame = gl_frame(gl, 0, &r->target[PICTURE], 1);
    gl->GenVertexArrays(1, &r->empty_array);
    if (gl->GetError() == GL_NO_ERROR) return VXS_OK;
    return fail(m, VXS_E_MEMORY, "OpenGL has no room for a picture of %u x %u samples", r->width, r->height);
}

/* lights ----------------------------------------------------------------------------------------------------------------------- */

/* As floats, scaled so that the greatest is 1; the fourth number is the cosine of a spot light's inner cone. */
static vxs_result put_colours(renderer *r, const scene *s, const vxs_baked_light *const *lights, run_context *m)
{
    double     most   = 0;
    vxs_result result = VXS_OK;
    float(*rows)[4]   = calloc(r->light_count, sizeof *rows);
    r->colours        = calloc(r->light_count, sizeof *r->colours);
    r->emissions      = calloc(r->light_count, sizeof *r->emissions);
    if (!rows || !r->colours || !r->emissions) {
        result = fail(m, VXS_E_MEMORY, "out of memory for %u lights", r->light_count);
        goto done;
    }
    for (uint32_t n = 0; n < r->light_count; n++) {
        /* The scene's light with the name of a baked light. Defaults for missing values: white, an inner cone of angle 0.
         * Lights that are dark in the scene, or hidden, get colour 0. */
        scene_light light = {.colour = {1, 1, 1}};
        for (size_t i = 0; i < s->lost_light_count; i++)
            if (!strcmp(s->lost_lights[i].name, lights[n]->light.name)) memset(light.colour, 0, sizeof light.colour);
        for (size_t i = 0; i < s->light_count; i++) {
            if (strcmp(s->lights[i].name, lights[n]->light.name) != 0) continue;
            light    = s->lights[i];
            int said = light.dark || vec3_dot(light.colour, light.colour) > 0;
            for (int k = 0; k < 3 && !said; k++) light.colour[k] = 1;
        }
        memcpy(r->colours[n], light.colour, sizeof light.colour);
        r->emissions[n].cos_inner = cos(light.inner_rad);
        rows[n][3]                = (float)r->emissions[n].cos_inner;
        r->day |= lights[n]->light.kind == VXS_LIGHT_KIND_DIRECTIONAL && vec3_dot(light.colour, light.colour) > 0;
        for (int k = 0; k < 3; k++) most = fmax(most, r->colours[n][k]);
    }
    if (!(most > 0)) most = 1; /* all are dark */
    r->scale = 1 / most;
    for (uint32_t n = 0; n < r->light_count; n++)
        for (int k = 0; k < 3; k++) {
            rows[n][k] = (float)(r->colours[n][k] /= most);
            r->emissions[n].colour[k] =
                pi * r->colours[n][k]; /* a matt surface reflects 1 / pi of the light that reaches it in each direction */
        }
    r->gl->GenBuffers(1, &r->colour_buffer);
    r->gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, r->colour_buffer);
    r->gl->BufferData(GL_SHADER_STORAGE_BUFFER, (GLsizeiptr)(r->light_count * sizeof *rows), rows, GL_STATIC_DRAW);
done:
    free(rows);
    return result;
}

static vxs_result put_shadows(renderer *r, const vxs_baked_light *const *lights, run_context *m)
{
    vxs_gl_desc desc = {.struct_size      = sizeof desc,
                        .get_proc_address = gl_lookup,
                        .user             = r->gl,
                        .storage          = VXS_GL_BUFFER,
                        .smoke            = r->options.baked_smoke,
                        .stream           = r->options.stream};
    if (!desc.stream) {
        desc.baked       = lights;
        desc.light_count = r->light_count;
    }
    vxs_result result = vxs_gl_create(&r->shadows, &desc);
    if (result != VXS_OK) return fail(m, result, "%u lights cannot be uploaded: %s", r->light_count, vxs_result_text(result));
    vxs_gl_upload(r->shadows, SIZE_MAX);
    return VXS_OK;
}

/* Without fog, make clear air: area lights, a sky and smoke need its frame. */
static vxs_result make_fog(renderer *r, run_context *m)
{
    static const fog_medium clear = {.top_ws = INFINITY};
    const render_options   *o     = &r->options;
    fog_pass_options        fog   = {.medium      = o->fog ? o->fog : &clear,
                                     .by          = o->fog_by,
                                     .steps       = o->fog_steps,
                                     .grid        = o->fog_grid,
                                     .is_half     = o->fog_is_half,
                                     .width       = r->width,
                                     .height      = r->height,
                                     .size_metres = r->mesh.size_metres,
                                     .baked_smoke = o->baked_smoke,
                                     .streamed    = o->stream != NULL};
    return fog_pass_create(&r->fog, &fog, r->gl, r->shadows, m);
}

/* Area lights and the sky are virtual point lights. Light that a matt surface reflects is counted pi times here, so emitted light
 * is, too. */
static vxs_result make_vpls(renderer *r, const scene *s, int has_areas, run_context *m)
{
    const render_options  *o      = &r->options;
    const vpl_pass_options lit    = {.scene      = s,
                                     .points     = o->area_points,
                                     .moving     = o->moving,
                                     .smoke      = o->smoke == SMOKE_ON && s->smoke.count ? &s->smoke : NULL,
                                     .smoke_side = o->smoke_side,
                                     .middle_ws  = r->mesh.middle_ws,
                                     .vpls       = o->area_vpls,
                                     .gather     = o->area_gather};
    area_pass_options      area   = {.lit = lit, .scale = pi * r->scale};
    sky_pass_options       sky    = {.lit           = lit,
                                     .radius_metres = 0.5 * r->mesh.size_metres,
                                     .map           = o->sky,
                                     .scale         = pi * r->scale * o->sky_light,
                                     .turn_rad      = o->sky_turn_degrees * pi / 180};
    vxs_result             result = has_areas ? area_pass_create(&r->areas, &area, r->gl, r->fog->volumes, m) : VXS_OK;
    return result == VXS_OK && o->sky ? sky_pass_create(&r->sky, &sky, r->gl, r->fog->volumes, m) : result;
}

static vxs_result make_smoke(renderer *r, const scene *s, const vxs_baked_light *const *lights, run_context *m)
{
    const smoke_pass_options o      = {.smoke       = &s->smoke,
                                       .lights      = lights,
                                       .light_count = r->light_count,
                                       .side_px     = r->options.smoke_side,
                                       .is_asked    = r->options.smoke_side_is_asked,
                                       .width       = r->width,
                                       .height      = r->height};
    vxs_result               result = smoke_pass_create(&r->smoke, &o, r->gl, r->fog->volumes, m);
    return result == VXS_OK ? renderer_make_cloud(r, &s->smoke, m) : result;
}

vxs_result renderer_create(renderer **out, const render_options *o, const scene *s, const vxs_baked_light *const *lights,
                           uint32_t light_count, run_context *m)
{
    renderer *r = calloc(1, sizeof *r);
    *out        = r;
    if (!r) return fail(m, VXS_E_MEMORY, "out of memory for a picture");
    r->options     = *o;
    r->light_count = light_count;
    r->width       = o->width_px * o->samples;
    r->height      = o->height_px * o->samples;

    uint64_t samples   = (uint64_t)r->width * r->height;
    int      has_areas = r->options.area_vpls && s->area_count, has_smoke = r->options.smoke == SMOKE_ON && s->smoke.count,
        is_airy         = r->options.fog || has_areas || has_smoke || r->options.sky;
    uint64_t bytes_each = 4 + 16 + 4 + 16 + 28 + (is_airy ? 32 : 0) + (has_areas ? 48 : 0) + (r->options.sky ? 48 : 0) +
                          (has_smoke ? 4 * SMOKE_MAPS : 0); /* targets, and two that are read back */
    vxs_result result = memory_check(samples * bytes_each, m, "a picture of %u x %u samples needs", r->width, r->height);
    if (result != VXS_OK) return result;
    if ((result = gl_context_create(&r->gl, r->options.backend, r->options.threads, m)) != VXS_OK) return result;
    if ((result = surface_mesh_make(&r->mesh, r->gl, s, m)) != VXS_OK) return result;
    if ((result = put_colours(r, s, lights, m)) != VXS_OK) return result;
    if ((result = put_shadows(r, lights, m)) != VXS_OK) return result;
    if (r->options.moving &&
        (result = moving_pass_create(&r->moving, r->gl, r->options.moving, lights, r->light_count, m)) != VXS_OK)
        return result;
    if (is_airy && (result = make_fog(r, m)) != VXS_OK) return result;
    if ((result = make_vpls(r, s, has_areas, m)) != VXS_OK) return result;
    if (has_smoke && (result = make_smoke(r, s, lights, m)) != VXS_OK) return result;

    const gl_text tone[] = {{"#version 450 core\n", -1}, gl_embedded(tone_frag_glsl), {0}};
    if ((result = gl_program_of(r->gl, &r->surface_program, surface_glsl, (gl_text){0}, m)) != VXS_OK) return result;
    if ((result = gl_screen_program(r->gl, &r->tone_program, tone, m)) != VXS_OK) return result;
    result = renderer_lit_program(r, &r->shade_program, shade_frag_glsl, r->options.filter, m);
    return result == VXS_OK ? make_targets(r, m) : result;
}

void renderer_destroy(renderer *r)
{
    if (!r) return;
    if (r->gl) {
        surface_mesh_free(&r->mesh, r->gl);
        moving_pass_destroy(r->moving);
        area_pass_destroy(r->areas);
        sky_pass_destroy(r->sky);
        renderer_free_cloud(r);
        smoke_pass_destroy(r->smoke);
        fog_pass_destroy(r->fog);
        vxs_gl_destroy(r->shadows);
        r->gl->DeleteTextures(TARGETS, r->target);
        r->gl->DeleteFramebuffers(4, (const GLuint[4]){r->surface_frame, r->light_frame, r->screen_frame, r->picture_frame});
        for (int n = 0; n < 3; n++) {
            GLuint program = (const GLuint[3]){r->surface_program, r->shade_program, r->tone_program}[n];
            if (program) r->gl->DeleteProgram(program);
        }
        r->gl->DeleteBuffers(1, &r->colour_buffer);
        r->gl->DeleteVertexArrays(1, &r->empty_array);
        gl_context_destroy(r->gl);
    }
    free(r->colours);
    free(r->emissions);
    free(r);
}
