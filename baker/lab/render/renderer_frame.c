/* Frames; see render.h.
 *
 *     upload     of a stream, pages that were loaded
 *     moving     depth maps of moving casters, from lights (moving_pass.h); left out without moving casters
 *     surfaces   depth (near / distance along the axis, precise at a distance), normal, albedo
 *     cull       lists of lights of tiles of 8 x 8 (vxs_gl_cull); left out with one light
 *     smoke      its transmittance towards each light (smoke_pass.h), and, after the fog, itself (smoke_cloud.c); left out
 *                without smoke
 *     shade      light of each sample, including lookups
 *     area       light of area lights on surfaces and in the air (area_pass.c); left out without area lights
 *     sky        the same for a map of the sky (sky_pass.c)
 *     fog        over the resulting picture (fog_pass.h); left out without fog
 *     tone       tone mapping, and the mean of a pixel's samples
 *
 * Positions are relative to the camera, where floats are precise enough for lookups.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/clock.h"
#include "baker/base/vec3.h"
#include "baker/lab/render/renderer_state.h"

const char *const render_stage_names[RENDER_STAGES] = {"upload", "moving", "surfaces", "cull", "smoke",
                                                       "shade",  "area",   "sky",      "fog",  "tone"};

enum { PICTURE_UNIT = 4 };

static void draw_mesh(const renderer *r, const surface_mesh *mesh)
{
    const gl_context *gl = r->gl;
    double            eye[3];
    float             matrix[16];
    vec3_sub(r->camera.eye_ws, mesh->middle_ws, eye);
    renderer_clip(r, eye, matrix);
    gl->ProgramUniformMatrix4fv(r->surface_program, gl->GetUniformLocation(r->surface_program, "clip_from_scene"), 1, GL_FALSE,
                                matrix);
    gl->ProgramUniform3f(r->surface_program, gl->GetUniformLocation(r->surface_program, "eye"), (float)eye[0], (float)eye[1],
                         (float)eye[2]);
    surface_mesh_draw(mesh, gl, r->surface_program);
}

static void draw_surfaces(const renderer *r)
{
    const gl_context *gl       = r->gl;
    const float       black[4] = {0};
    gl->BindFramebuffer(GL_FRAMEBUFFER, r->surface_frame);
    gl->Viewport(0, 0, (GLsizei)r->width, (GLsizei)r->height);
    gl->ClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
    gl->Enable(GL_DEPTH_TEST);
    gl->DepthMask(GL_TRUE);
    gl->DepthFunc(GL_GREATER);
    gl->ClearBufferfv(GL_DEPTH, 0, black);
    gl->ClearBufferfv(GL_COLOR, 0, black);
    gl->ClearBufferfv(GL_COLOR, 1, black);
    gl->UseProgram(r->surface_program);
    draw_mesh(r, &r->mesh);
    if (r->moving) draw_mesh(r, &r->moving->mesh);
    gl->Disable(GL_DEPTH_TEST);
}

static void draw_screen(const renderer *r, GLuint frame, GLuint program, GLuint textures, uint32_t width, uint32_t height)
{
    renderer_begin_screen(r, frame, program, textures, width, height);
    r->gl->UseProgram(program);
    r->gl->BindVertexArray(r->empty_array);
    r->gl->DrawArrays(GL_TRIANGLES, 0, 3);
}

/* Set the program of tone_frag.glsl.   samples  0: linear, before fog;   picture  the texture with the fog; 0: none */
static void set_tone(const renderer *r, uint32_t samples, GLuint picture)
{
    GLuint p = r->tone_program;
    r->gl->BindTextureUnit(PICTURE_UNIT, picture);
    r->gl->ProgramUniform1i(p, r->gl->GetUniformLocation(p, "samples"), (GLint)samples);
    r->gl->ProgramUniform1i(p, r->gl->GetUniformLocation(p, "has_picture"), picture != 0);
    r->gl->ProgramUniform4f(p, r->gl->GetUniformLocation(p, "sizes"), (float)r->width, (float)r->height, (float)r->exposure,
                            (float)renderer_day(r));
}

static vxs_result begin_air(const renderer *r, run_context *m)
{
    double ambient[3];
    renderer_fog_ambient(r, ambient);
    return fog_pass_begin(r->fog, &r->view, r->target[DEPTHS], r->camera.eye_ws, ambient, m);
}

/* The picture, emissive surfaces, and the air over it. */
static vxs_result fog(const renderer *r, fog_plan *plan, run_context *m)
{
    double eye[3];
    float  matrix[16];
    set_tone(r, 0, 0);
    draw_screen(r, r->picture_frame, r->tone_program, SCREEN, r->width, r->height);
    vec3_sub(r->camera.eye_ws, r->mesh.middle_ws, eye);
    renderer_clip(r, eye, matrix);
    vxs_result result = r->areas || r->sky ? VXS_OK : begin_air(r, m);
    if (r->areas) area_pass_add_glow(r->areas, matrix, r->target[DEPTHS], r->camera.eye_ws, r->exposure);
    if (r->sky) sky_pass_add_map(r->sky, &r->view, r->target[DEPTHS], r->exposure);
    return result != VXS_OK ? result : fog_pass_draw(r->fog, r->emissions, r->moving, r->smoke, r->exposure, plan, m);
}

static int brighter(const void *a, const void *b)
{
    float x = *(const float *)a, y = *(const float *)b;
    return x < y ? -1 : x > y;
}

/* Count the samples that are answered in full. */
static vxs_result count_full(renderer *r, render_frame *frame, run_context *m)
{
    size_t     count  = (size_t)r->width * r->height;
    float     *full   = malloc(count * sizeof *full);
    vxs_result result = full ? renderer_read_full(r, full, m)
                             : fail(m, VXS_E_MEMORY, "out of memory for a picture of %u x %u samples", r->width, r->height);
    for (size_t n = 0; result == VXS_OK && n < count; n++) frame->full_pixels += full[n] >= 1 || full[n] == RENDER_NOT_ASKED;
    free(full);
    return result;
}

/* stage  that ends; RENDER_STAGES: no stage, the time since the last one is not counted */
static void stage_ends(const renderer *r, render_frame *frame, int stage, double *since)
{
    r->gl->Finish();
    double now = clock_seconds();
    if (stage < RENDER_STAGES) frame->seconds[stage] += now - *since;
    *since = now;
}

/* All light on surfaces. Area lights and the sky share a frame of the air, to which they add their airlight. */
static vxs_result light_surfaces(const renderer *r, render_frame *frame, double *since, run_context *m)
{
    vxs_result result   = VXS_OK;
    double     exposure = r->exposure > 0 ? r->exposure : 1, moved_ws[3] = {0};
    renderer_shade(r, SHOW_LIGHT, 0);
    stage_ends(r, frame, RENDER_SHADE, since);
    if (r->moving) vec3_sub(r->moving->mesh.middle_ws, r->moving->first_middle_ws, moved_ws);
    if (r->areas || r->sky) result = begin_air(r, m);
    if (result == VXS_OK && r->areas) {
        result = area_pass_draw(r->areas, r->camera.eye_ws, &r->seen, moved_ws, fog_pass_far_metres(r->fog), r->target[NORMALS],
                                exposure, &frame->area, m);
        if (result == VXS_OK && frame->area.vpls) {
            r->gl->BindFramebuffer(GL_FRAMEBUFFER, r->light_frame);
            area_pass_add_light(r->areas);
        }
        stage_ends(r, frame, RENDER_AREA, since);
    }
    if (result == VXS_OK && r->sky) {
        result = sky_pass_draw(r->sky, r->camera.eye_ws, moved_ws, r->target[NORMALS], exposure, m);
        if (result == VXS_OK) {
            r->gl->BindFramebuffer(GL_FRAMEBUFFER, r->light_frame);
            sky_pass_add_light(r->sky);
        }
        stage_ends(r, frame, RENDER_SKY, since);
    }
    return result;
}

/* The exposure is that of clear air: fog does not make a picture brighter. Airlight of area lights and of the sky depends on the
 * exposure, so they are drawn again. */
static vxs_result light_exposed(renderer *r, render_frame *frame, double *since, run_context *m)
{
    int is_first      = r->exposure <= 0;
    r->is_clear       = is_first;
    vxs_result result = light_surfaces(r, frame, since, m);
    r->is_clear       = 0;
    if (result != VXS_OK || !is_first) return result;

    size_t count = (size_t)r->width * r->height;
    float *light = malloc(4 * count * sizeof *light), *albedos = malloc(3 * count * sizeof *albedos);
    result = light && albedos ? renderer_read(r, NULL, NULL, albedos, light, m)
                              : fail(m, VXS_E_MEMORY, "out of memory for a picture of %u x %u samples", r->width, r->height);
    if (result == VXS_OK) {
        /* the brightest tenth of lit samples begins near white */
        const double white = 0.8, share = 0.9;
        size_t       lit    = 0;
        float       *bright = malloc((count + 1) * sizeof *bright);
        double       value  = 0;
        for (size_t n = 0; bright && n < count; n++) {
            const float *c = light + 4 * n, *a = albedos + 3 * n;
            bright[lit] = 0.2126f * a[0] * c[0] + 0.7152f * a[1] * c[1] + 0.0722f * a[2] * c[2];
            lit += bright[lit] > 0;
        }
        if (lit) {
            qsort(bright, lit, sizeof *bright, brighter);
            value = (double)bright[(size_t)(share * (double)(lit - 1))];
        }
        free(bright);
        r->exposure = (value > 0 ? white / value : 1) * exp2(r->options.stops);
    }
    free(light);
    free(albedos);

    stage_ends(r, frame, RENDER_STAGES, since);
    return result == VXS_OK && (r->options.fog || r->areas || r->sky) ? light_surfaces(r, frame, since, m) : result;
}

static vxs_result draw_frame(renderer *r, render_frame *frame, run_context *m)
{
    double since;
    stage_ends(r, frame, RENDER_STAGES, &since);
    if (r->options.stream) { /* upload a slice of the pages that were loaded */
        size_t slice          = r->options.upload_bytes < SIZE_MAX ? (size_t)r->options.upload_bytes : SIZE_MAX;
        frame->waiting_bytes  = vxs_gl_upload(r->shadows, slice);
        frame->uploaded_bytes = vxs_gl_uploaded_bytes(r->shadows) - r->uploaded_bytes;
        r->uploaded_bytes += frame->uploaded_bytes;
    }
    stage_ends(r, frame, RENDER_UPLOAD, &since);
    if (r->moving) {
        double by_ws[3];
        for (int n = 0; n < 3; n++) by_ws[n] = r->frames_drawn * r->options.moving_by_ws[n];
        moving_pass_cast(r->moving, r->surface_program, by_ws, r->camera.eye_ws, &frame->moving);
    }
    stage_ends(r, frame, RENDER_MOVING, &since);
    vxs_gl_origin(r->shadows, r->camera.eye_ws);
    draw_surfaces(r);
    stage_ends(r, frame, RENDER_SURFACES, &since);
    if (renderer_culls(r) && vxs_gl_cull(r->shadows, &r->view, r->target[DEPTHS], r->options.tile_lights) != VXS_OK)
        return fail(m, VXS_E_GL, "OpenGL cannot make lists of lights for %u x %u samples", r->width, r->height);
    stage_ends(r, frame, RENDER_CULL, &since);
    if (r->smoke) {
        vxs_result result = begin_air(r, m);
        if (result == VXS_OK) result = smoke_pass_draw(r->smoke, r->camera.eye_ws, &r->seen, &frame->smoke, m);
        if (result != VXS_OK) return result;
        stage_ends(r, frame, RENDER_SMOKE, &since);
    }
    if (r->options.stream) {
        vxs_result result = count_full(r, frame, m);
        if (result != VXS_OK) return result;
        stage_ends(r, frame, RENDER_STAGES, &since);
    }
    vxs_result result = light_exposed(r, frame, &since, m);
    if (result == VXS_OK && r->fog) result = fog(r, &frame->fog, m);
    stage_ends(r, frame, RENDER_FOG, &since);
    if (result == VXS_OK && r->smoke) {
        result = renderer_draw_cloud(r, m);
        stage_ends(r, frame, RENDER_SMOKE, &since);
    }
    if (result != VXS_OK) return result;

    set_tone(r, r->options.samples, r->fog ? r->target[PICTURE] : 0);
    draw_screen(r, r->screen_frame, r->tone_program, SCREEN, r->options.width_px, r->options.height_px);

    stage_ends(r, frame, RENDER_TONE, &since);
    return VXS_OK;
}

vxs_result renderer_draw(renderer *r, const camera_pose *camera, uint8_t *rgb, render_frame *frame, run_context *m)
{
    const camera_view *v      = &r->seen;
    float             *matrix = r->view.point_from_depth;
    *frame                    = (render_frame){0};
    r->camera                 = *camera;
    r->near_metres            = camera->near_metres > 0 ? camera->near_metres : 1e-5 * r->mesh.size_metres;
    r->seen                   = camera_view_of(camera, (double)r->width / r->height);
    r->view = (vxs_view){.width_px = r->width, .height_px = r->height, .empty_depth = 0, .filter = r->options.filter};
    for (int n = 0; n < 3; n++) { /* column-major; depths are near / z; u and v go up from the lower left corner */
        matrix[n]      = (float)(2 * v->right[n]);
        matrix[4 + n]  = (float)(2 * v->up[n]);
        matrix[12 + n] = (float)(v->forward[n] - v->right[n] - v->up[n]);
    }
    matrix[11] = (float)(1 / r->near_metres);

    vxs_result result = draw_frame(r, frame, m);
    r->frames_drawn++;
    if (result == VXS_OK) {
        size_t count  = (size_t)r->width * r->height;
        float *depths = malloc(count * sizeof *depths), *light = malloc(4 * count * sizeof *light);
        result = depths && light ? renderer_read(r, depths, NULL, NULL, light, m)
                                 : fail(m, VXS_E_MEMORY, "out of memory for a picture of %u x %u samples", r->width, r->height);
        for (size_t n = 0; result == VXS_OK && n < count; n++) {
            uint32_t asked = (uint32_t)light[4 * n + 3];
            frame->surface_pixels += depths[n] > 0;
            frame->asked_lights += asked;
            if (renderer_culls(r) && asked > frame->longest_list) frame->longest_list = asked;
        }
        free(depths);
        free(light);
    }
    if (result != VXS_OK) return result;
    if (!r->options.stream) frame->full_pixels = frame->surface_pixels;
    if (rgb && (result = renderer_read_screen(r, rgb, m)) != VXS_OK) return result;
    GLenum error = r->gl->GetError();
    return error == GL_NO_ERROR ? VXS_OK : fail(m, VXS_E_GL, "OpenGL says error 0x%x of a frame", error);
}
