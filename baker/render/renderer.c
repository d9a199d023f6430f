/* Frames; see render.h.
 *
 *     upload     of a stream, what has come
 *     surfaces   depth (near / distance along the axis, so that far ones keep their digits), normal, albedo
 *     cull       lists of lights of tiles of 8 x 8 (vxs_gl_cull); left out where there is one light
 *     shade      light of each sample, lookups and all
 *     fog        over the picture that this makes (fog_pass.h); left out where there is none
 *     tone       what a screen shows of the mean of a pixel's samples
 *
 * Places count from the camera, in which lookups are as fine as a float can be.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/embedded.h"
#include "baker/base/memory.h"
#include "baker/base/vec3.h"
#include "baker/measure/clock.h"
#include "baker/render/render.h"
#include "baker/render/surface_mesh.h"
#include "runtime/gl/vxs_gl.h"

EMBEDDED(surface_vert_glsl)
EMBEDDED(surface_frag_glsl)
EMBEDDED(screen_vert_glsl)
EMBEDDED(shade_frag_glsl)
EMBEDDED(tone_frag_glsl)

const char *const render_stage_names[RENDER_STAGES] = {"upload", "surfaces", "cull", "shade", "fog", "tone"};

static const double pi = 3.14159265358979324;

enum { COLOURS_BINDING = 3, PICTURE_UNIT = 4, SHOW_LIGHT = 0, SHOW_LIT = 1, SHOW_FULL = 2 };

/* Pictures that are drawn to. */
enum { DEPTHS, NORMALS, ALBEDOS, LIGHTS, SCREEN, PICTURE, TARGETS };

struct renderer {
    render_options options;
    gl_context    *gl;
    vxs_gl        *shadows;
    surface_mesh   mesh;
    uint32_t       light_count, width, height; /* samples */
    fog_pass      *fog;                        /* NULL: there is none */
    double (*colours)[3];                      /* [light_count] the greatest is 1 */
    fog_shine  *shines;                        /* [light_count] the same, as fog has it */
    int         day;                           /* there is a sun */
    GLuint      colour_buffer, empty_array;
    GLuint      surface_program, shade_program, tone_program, picture_program;
    uint64_t    uploaded_bytes; /* up to and with the last frame */
    GLuint      target[TARGETS], surface_frame, light_frame, screen_frame, picture_frame;
    double      exposure; /* 0: not yet chosen */
    camera_pose camera;   /* of the last frame */
    camera_view seen;
    vxs_view    view;
    double      near_metres;
};

/* programs ------------------------------------------------------------------------------------------------------------------------ */

enum { SHADE_PARTS = VXS_GL_TEXTS + 2 };

typedef struct text_part {
    const char *text;
    GLint       size; /* -1: up to its end */
} text_part;

static text_part part_of(embedded e)
{
    return (text_part){e.begin, (GLint)(e.end - e.begin)};
}

static void add_shader(const gl_context *gl, GLuint program, GLenum kind, const text_part *parts, int count)
{
    const char *texts[SHADE_PARTS];
    GLint       sizes[SHADE_PARTS];
    GLuint      shader = gl->CreateShader(kind);
    for (int n = 0; n < count; n++) {
        texts[n] = parts[n].text;
        sizes[n] = parts[n].size;
    }
    gl->ShaderSource(shader, count, texts, sizes);
    gl->CompileShader(shader);
    gl->AttachShader(program, shader);
    gl->DeleteShader(shader);
}

static vxs_result make_program(const gl_context *gl, GLuint *program, embedded vertex, const text_part *fragment, int count,
                               message *m)
{
    text_part head     = part_of(vertex);
    GLint     linked   = 0;
    char      log[256] = "";
    *program           = gl->CreateProgram();
    add_shader(gl, *program, GL_VERTEX_SHADER, &head, 1);
    add_shader(gl, *program, GL_FRAGMENT_SHADER, fragment, count);
    gl->LinkProgram(*program);
    gl->GetProgramiv(*program, GL_LINK_STATUS, &linked);
    if (linked) return VXS_OK;
    gl->GetProgramInfoLog(*program, sizeof log, NULL, log);
    return fail(m, VXS_E_GL, "OpenGL cannot link a shader: %s", log);
}

static vxs_result make_programs(renderer *r, message *m)
{
    const char *texts[VXS_GL_TEXTS];
    text_part   shade[SHADE_PARTS], surface = part_of(surface_frag_glsl);
    text_part   tone[]    = {{"#version 450 core\n", -1}, {r->fog ? "#define FROM_PICTURE\n" : "", -1}, part_of(tone_frag_glsl)};
    text_part   picture[] = {tone[0], {"#define TO_PICTURE\n", -1}, tone[2]};
    char        knows[64];
    vxs_result  result;
    snprintf(knows, sizeof knows, "#define FILTER_PX %d\n%s", r->options.filter_px, r->options.stream ? "#define STREAMED\n" : "");
    vxs_gl_texts(r->shadows, texts);
    for (int n = 0; n < VXS_GL_TEXTS; n++) shade[n] = (text_part){texts[n], -1};
    shade[VXS_GL_TEXTS]     = (text_part){knows, -1};
    shade[VXS_GL_TEXTS + 1] = part_of(shade_frag_glsl);
    if ((result = make_program(r->gl, &r->surface_program, surface_vert_glsl, &surface, 1, m)) != VXS_OK) return result;
    if ((result = make_program(r->gl, &r->tone_program, screen_vert_glsl, tone, 3, m)) != VXS_OK) return result;
    if (r->fog && (result = make_program(r->gl, &r->picture_program, screen_vert_glsl, picture, 3, m)) != VXS_OK) return result;
    return make_program(r->gl, &r->shade_program, screen_vert_glsl, shade, SHADE_PARTS, m);
}

/* targets ------------------------------------------------------------------------------------------------------------------------- */

static GLuint make_frame(const gl_context *gl, GLuint depth, const GLuint *colours, GLsizei count)
{
    static const GLenum attached[2] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1};
    GLuint              frame;
    gl->GenFramebuffers(1, &frame);
    gl->BindFramebuffer(GL_FRAMEBUFFER, frame);
    if (depth) gl->FramebufferTexture(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, depth, 0);
    for (GLsizei n = 0; n < count; n++) gl->FramebufferTexture(GL_FRAMEBUFFER, attached[n], colours[n], 0);
    gl->DrawBuffers(count, attached);
    return frame;
}

static vxs_result make_targets(renderer *r, message *m)
{
    static const GLenum formats[TARGETS] = {GL_DEPTH_COMPONENT32F, GL_RGBA32F, GL_RGBA8, GL_RGBA32F, GL_RGBA8, GL_RGBA32F};
    const gl_context   *gl               = r->gl;
    for (int n = 0; n < TARGETS; n++) {
        int small = n == SCREEN;
        if (n == PICTURE && !r->fog) continue;
        gl->CreateTextures(GL_TEXTURE_2D, 1, &r->target[n]);
        gl->TextureStorage2D(r->target[n], 1, formats[n], (GLsizei)(small ? r->options.width_px : r->width),
                             (GLsizei)(small ? r->options.height_px : r->height));
        gl->TextureParameteri(r->target[n], GL_TEXTURE_MIN_FILTER, GL_NEAREST);
        gl->TextureParameteri(r->target[n], GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    }
    r->surface_frame = make_frame(gl, r->target[DEPTHS], &r->target[NORMALS], 2);
    r->light_frame   = make_frame(gl, 0, &r->target[LIGHTS], 1);
    r->screen_frame  = make_frame(gl, 0, &r->target[SCREEN], 1);
    if (r->fog) r->picture_frame = make_frame(gl, 0, &r->target[PICTURE], 1);
    gl->GenVertexArrays(1, &r->empty_array);
    if (gl->GetError() == GL_NO_ERROR) return VXS_OK;
    return fail(m, VXS_E_MEMORY, "OpenGL has no room for a picture of %u x %u samples", r->width, r->height);
}

/* lights -------------------------------------------------------------------------------------------------------------------------- */

static vxs_gl_function lookup(const char *name, void *user)
{
    return (vxs_gl_function)((const gl_context *)user)->lookup(name);
}

/* What the scene says of a light; where it has none of its name, and of what it does not say, that is white, and an inner cone without width. */
static scene_light described(const scene *s, const vxs_light *light)
{
    scene_light found = {0};
    for (size_t n = 0; n < s->light_count; n++)
        if (!strcmp(s->lights[n].name, light->name)) found = s->lights[n];
    for (int n = 0, said = vec3_dot(found.colour, found.colour) > 0; n < 3 && !said; n++) found.colour[n] = 1;
    return found;
}

/* As floats the greatest is 1: exposure does the rest. Beside them the cosine of a spot light's inner cone. */
static vxs_result put_colours(renderer *r, const scene *s, const vxs_baked_light *const *lights, message *m)
{
    double most     = 0;
    float(*rows)[4] = calloc(r->light_count, sizeof *rows);
    r->colours      = calloc(r->light_count, sizeof *r->colours);
    r->shines       = calloc(r->light_count, sizeof *r->shines);
    if (!rows || !r->colours || !r->shines) {
        free(rows);
        return fail(m, VXS_E_MEMORY, "out of memory for %u lights", r->light_count);
    }
    for (uint32_t n = 0; n < r->light_count; n++) {
        scene_light light = described(s, &lights[n]->light);
        memcpy(r->colours[n], light.colour, sizeof light.colour);
        r->shines[n].cos_inner = cos(light.inner_rad);
        rows[n][3]             = (float)r->shines[n].cos_inner;
        r->day |= lights[n]->light.kind == VXS_LIGHT_KIND_DIRECTIONAL;
        for (int k = 0; k < 3; k++) most = fmax(most, r->colours[n][k]);
    }
    for (uint32_t n = 0; n < r->light_count; n++)
        for (int k = 0; k < 3; k++) {
            rows[n][k] = (float)(r->colours[n][k] /= most);
            r->shines[n].colour[k] =
                pi * r->colours[n][k]; /* a matt surface sends back 1 / pi of what reaches it to each direction */
        }
    r->gl->GenBuffers(1, &r->colour_buffer);
    r->gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, r->colour_buffer);
    r->gl->BufferData(GL_SHADER_STORAGE_BUFFER, (GLsizeiptr)(r->light_count * sizeof *rows), rows, GL_STATIC_DRAW);
    free(rows);
    return VXS_OK;
}

static vxs_result put_asset(renderer *r, const vxs_baked_light *const *lights, vxs_gl_desc *desc)
{
    uint64_t      words  = 0;
    vxs_gl_light *placed = calloc(r->light_count, sizeof *placed);
    vxs_result    result = placed ? VXS_OK : VXS_E_MEMORY;
    for (uint32_t n = 0; n < r->light_count && placed; n++) {
        placed[n] = (vxs_gl_light){&lights[n]->light, (uint32_t)words};
        words += lights[n]->word_count;
    }
    if (words > UINT32_MAX) result = VXS_E_MEMORY;
    desc->lights      = placed;
    desc->light_count = r->light_count;
    desc->word_count  = (uint32_t)words;
    if (result == VXS_OK) result = vxs_gl_create(&r->shadows, desc);
    for (uint32_t n = 0; n < r->light_count && result == VXS_OK; n++)
        result = vxs_gl_put(r->shadows, lights[n]->words, placed[n].first_word, lights[n]->word_count);
    free(placed);
    return result;
}

static vxs_result put_shadows(renderer *r, const vxs_baked_light *const *lights, message *m)
{
    vxs_gl_desc desc   = {.struct_size      = sizeof desc,
                          .get_proc_address = lookup,
                          .user             = r->gl,
                          .storage          = VXS_GL_BUFFER,
                          .stream           = r->options.stream};
    vxs_result  result = desc.stream ? vxs_gl_create(&r->shadows, &desc) : put_asset(r, lights, &desc);
    if (result != VXS_OK) return fail(m, result, "%u lights cannot be uploaded: %s", r->light_count, vxs_result_text(result));
    vxs_gl_upload(r->shadows, SIZE_MAX);
    return VXS_OK;
}

/* ---------------------------------------------------------------------------------------------------------------------------------- */

static vxs_result make_fog(renderer *r, message *m)
{
    const render_options *o   = &r->options;
    fog_pass_options      fog = {.medium      = o->fog,
                                 .by          = o->fog_by,
                                 .steps       = o->fog_steps,
                                 .grid        = o->fog_grid,
                                 .width       = r->width,
                                 .height      = r->height,
                                 .size_metres = r->mesh.size_metres};
    return o->fog ? fog_pass_create(&r->fog, &fog, r->gl, r->shadows, m) : VXS_OK;
}

static vxs_result make(renderer *r, const scene *s, const vxs_baked_light *const *lights, message *m)
{
    uint64_t   samples    = (uint64_t)r->width * r->height;
    uint64_t   bytes_each = 4 + 16 + 4 + 16 + 28 + (r->options.fog ? 32 : 0); /* targets, and two that are read back */
    vxs_result result     = memory_check(samples * bytes_each, m, "a picture of %u x %u samples needs", r->width, r->height);
    if (result != VXS_OK) return result;
    if ((result = gl_context_create(&r->gl, r->options.backend, r->options.threads, m)) != VXS_OK) return result;
    if ((result = surface_mesh_make(&r->mesh, r->gl, s, m)) != VXS_OK) return result;
    if ((result = put_colours(r, s, lights, m)) != VXS_OK) return result;
    if ((result = put_shadows(r, lights, m)) != VXS_OK) return result;
    if ((result = make_fog(r, m)) != VXS_OK) return result;
    if ((result = make_programs(r, m)) != VXS_OK) return result;
    r->near_metres = 1e-5 * r->mesh.size_metres;
    return make_targets(r, m);
}

vxs_result renderer_create(renderer **out, const render_options *o, const scene *s, const vxs_baked_light *const *lights,
                           uint32_t light_count, message *m)
{
    renderer *r = calloc(1, sizeof *r);
    *out        = NULL;
    if (!r) return fail(m, VXS_E_MEMORY, "out of memory for a picture");
    r->options        = *o;
    r->light_count    = light_count;
    r->width          = o->width_px * o->samples;
    r->height         = o->height_px * o->samples;
    vxs_result result = make(r, s, lights, m);
    if (result == VXS_OK)
        *out = r;
    else
        renderer_destroy(r);
    return result;
}

void renderer_destroy(renderer *r)
{
    if (!r) return;
    if (r->gl) {
        surface_mesh_free(&r->mesh, r->gl);
        fog_pass_destroy(r->fog);
        vxs_gl_destroy(r->shadows);
        r->gl->DeleteTextures(TARGETS, r->target);
        r->gl->DeleteFramebuffers(4, (const GLuint[4]){r->surface_frame, r->light_frame, r->screen_frame, r->picture_frame});
        for (int n = 0; n < 4; n++) {
            GLuint program = (const GLuint[4]){r->surface_program, r->shade_program, r->tone_program, r->picture_program}[n];
            if (program) r->gl->DeleteProgram(program);
        }
        r->gl->DeleteBuffers(1, &r->colour_buffer);
        r->gl->DeleteVertexArrays(1, &r->empty_array);
        gl_context_destroy(r->gl);
    }
    free(r->colours);
    free(r->shines);
    free(r);
}

/* frames -------------------------------------------------------------------------------------------------------------------------- */

/* Depths are near / z; u and v go up from the lower left corner. By columns. */
static void set_view(renderer *r, const camera_pose *camera)
{
    const camera_view *v = &r->seen;
    float             *m = r->view.point_from_depth;
    r->camera            = *camera;
    r->seen              = camera_view_of(camera, (double)r->width / r->height);
    r->view =
        (vxs_view){.width_px = r->width, .height_px = r->height, .empty_depth = 0, .filter_px = (int32_t)r->options.filter_px};
    for (int n = 0; n < 3; n++) {
        m[n]      = (float)(2 * v->right[n]);
        m[4 + n]  = (float)(2 * v->up[n]);
        m[12 + n] = (float)(v->forward[n] - v->right[n] - v->up[n]);
    }
    m[11] = (float)(1 / r->near_metres);
}

/* From the scene's middle to clip space: x / w and y / w in [-1, 1], z / w = near / w. */
static void clip_from_scene(const renderer *r, const double eye[3], float m[16])
{
    const camera_view *v      = &r->seen;
    const double      *row[3] = {v->right, v->up, v->forward};
    memset(m, 0, 16 * sizeof *m);
    for (int i = 0; i < 3; i++) {
        int    to     = i == 2 ? 3 : i;
        double square = vec3_dot(row[i], row[i]);
        for (int n = 0; n < 3; n++) m[4 * n + to] = (float)(row[i][n] / square);
        m[12 + to] = (float)(-vec3_dot(row[i], eye) / square);
    }
    m[14] = (float)r->near_metres;
}

static void draw_surfaces(renderer *r)
{
    const gl_context *gl       = r->gl;
    const float       black[4] = {0};
    double            eye[3];
    float             matrix[16];
    vec3_sub(r->camera.eye_ws, r->mesh.middle_ws, eye);
    clip_from_scene(r, eye, matrix);
    gl->BindFramebuffer(GL_FRAMEBUFFER, r->surface_frame);
    gl->Viewport(0, 0, (GLsizei)r->width, (GLsizei)r->height);
    gl->ClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
    gl->Enable(GL_DEPTH_TEST);
    gl->DepthMask(GL_TRUE);
    gl->DepthFunc(GL_GREATER);
    gl->ClearBufferfv(GL_DEPTH, 0, black);
    gl->ClearBufferfv(GL_COLOR, 0, black);
    gl->ClearBufferfv(GL_COLOR, 1, black);
    gl->ProgramUniformMatrix4fv(r->surface_program, gl->GetUniformLocation(r->surface_program, "clip_from_scene"), 1, GL_FALSE,
                                matrix);
    gl->ProgramUniform3f(r->surface_program, gl->GetUniformLocation(r->surface_program, "eye"), (float)eye[0], (float)eye[1],
                         (float)eye[2]);
    gl->UseProgram(r->surface_program);
    surface_mesh_draw(&r->mesh, gl, r->surface_program);
    gl->Disable(GL_DEPTH_TEST);
}

int renderer_culls(const renderer *r)
{
    return r->options.cull == CULL_ON || (r->options.cull == CULL_AUTO && r->light_count > 1);
}

int renderer_is_in_fog(const renderer *r)
{
    return r->fog != NULL;
}

uint32_t renderer_fog_grid(const renderer *r)
{
    return r->fog ? fog_pass_grid(r->fog) : 0;
}

vxs_result renderer_read_grid(const renderer *r, float *dark, message *m)
{
    return fog_pass_read_grid(r->fog, dark, m);
}

static void draw_screen(const renderer *r, GLuint frame, GLuint program, uint32_t width, uint32_t height)
{
    const gl_context *gl = r->gl;
    gl->BindFramebuffer(GL_FRAMEBUFFER, frame);
    gl->Viewport(0, 0, (GLsizei)width, (GLsizei)height);
    for (GLuint n = 0; n < SCREEN; n++) gl->BindTextureUnit(n, r->target[n]);
    gl->ProgramUniformMatrix4fv(program, gl->GetUniformLocation(program, "point_from_depth"), 1, GL_FALSE,
                                r->view.point_from_depth);
    gl->UseProgram(program);
    gl->BindVertexArray(r->empty_array);
    gl->DrawArrays(GL_TRIANGLES, 0, 3);
}

/* light  of SHOW_LIT */
static void shade(const renderer *r, int show, uint32_t light)
{
    const gl_context *gl = r->gl;
    GLuint            p  = r->shade_program;
    gl->ProgramUniform4f(p, gl->GetUniformLocation(p, "sizes"), (float)r->width, (float)r->height, 0, 0);
    gl->ProgramUniform3i(p, gl->GetUniformLocation(p, "asked"), show, (GLint)light, renderer_culls(r));
    gl->BindTextureUnit(3, 0); /* what is drawn to */
    vxs_gl_bind(r->shadows);
    gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, COLOURS_BINDING, r->colour_buffer);
    gl->BindFramebuffer(GL_FRAMEBUFFER, r->light_frame);
    gl->Viewport(0, 0, (GLsizei)r->width, (GLsizei)r->height);
    for (GLuint n = 0; n < LIGHTS; n++) gl->BindTextureUnit(n, r->target[n]);
    gl->ProgramUniformMatrix4fv(p, gl->GetUniformLocation(p, "point_from_depth"), 1, GL_FALSE, r->view.point_from_depth);
    gl->UseProgram(p);
    gl->BindVertexArray(r->empty_array);
    gl->DrawArrays(GL_TRIANGLES, 0, 3);
}

/* What is left of the sky at night. */
static double day_of(const renderer *r)
{
    return r->day ? 1 : 0.07;
}

static void set_sizes(const renderer *r, GLuint program)
{
    r->gl->ProgramUniform4f(program, r->gl->GetUniformLocation(program, "sizes"), (float)r->width, (float)r->height,
                            (float)r->exposure, (float)day_of(r));
}

/* Of the sky's light fog scatters as much as if a tenth of its horizon were seen from everywhere. */
static vxs_result fog(const renderer *r, fog_plan *plan, message *m)
{
    const double ambient[3] = {0.070 * day_of(r), 0.081 * day_of(r), 0.095 * day_of(r)};
    set_sizes(r, r->picture_program);
    draw_screen(r, r->picture_frame, r->picture_program, r->width, r->height);
    return fog_pass_draw(r->fog, &r->view, r->target[DEPTHS], r->camera.eye_ws, r->shines, r->exposure, ambient, plan, m);
}

static void tone(const renderer *r)
{
    GLuint p = r->tone_program;
    set_sizes(r, p);
    if (r->fog) r->gl->BindTextureUnit(PICTURE_UNIT, r->target[PICTURE]);
    r->gl->ProgramUniform1i(p, r->gl->GetUniformLocation(p, "samples"), (GLint)r->options.samples);
    draw_screen(r, r->screen_frame, p, r->options.width_px, r->options.height_px);
}

static int brighter(const void *a, const void *b)
{
    float x = *(const float *)a, y = *(const float *)b;
    return x < y ? -1 : x > y;
}

/* So that of the samples that have light, the brightest tenth begins where a screen is nearly white. */
static double exposure_of(const float *light, const float *albedos, size_t count, double stops)
{
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
    return (value > 0 ? white / value : 1) * exp2(stops);
}

static vxs_result choose_exposure(renderer *r, message *m)
{
    size_t     count = (size_t)r->width * r->height;
    float     *light = malloc(4 * count * sizeof *light), *albedos = malloc(3 * count * sizeof *albedos);
    vxs_result result = light && albedos
                            ? renderer_read(r, NULL, NULL, albedos, light, m)
                            : fail(m, VXS_E_MEMORY, "out of memory for a picture of %u x %u samples", r->width, r->height);
    if (result == VXS_OK) r->exposure = exposure_of(light, albedos, count, r->options.stops);
    free(light);
    free(albedos);
    return result;
}

/* How many lights samples asked for, and how long lists are. */
static vxs_result count_lights(renderer *r, render_frame *frame, message *m)
{
    size_t     count  = (size_t)r->width * r->height;
    float     *depths = malloc(count * sizeof *depths), *light = malloc(4 * count * sizeof *light);
    vxs_result result = depths && light
                            ? renderer_read(r, depths, NULL, NULL, light, m)
                            : fail(m, VXS_E_MEMORY, "out of memory for a picture of %u x %u samples", r->width, r->height);
    for (size_t n = 0; result == VXS_OK && n < count; n++) {
        uint32_t asked = (uint32_t)light[4 * n + 3];
        frame->surface_pixels += depths[n] > 0;
        frame->asked_lights += asked;
        if (renderer_culls(r) && asked > frame->longest_list) frame->longest_list = asked;
    }
    free(depths);
    free(light);
    return result;
}

/* How many samples are answered in full. */
static vxs_result count_full(renderer *r, render_frame *frame, message *m)
{
    size_t     count  = (size_t)r->width * r->height;
    float     *full   = malloc(count * sizeof *full);
    vxs_result result = full ? renderer_read_full(r, full, m)
                             : fail(m, VXS_E_MEMORY, "out of memory for a picture of %u x %u samples", r->width, r->height);
    for (size_t n = 0; result == VXS_OK && n < count; n++) frame->full_pixels += full[n] >= 1 || full[n] == RENDER_NOT_ASKED;
    free(full);
    return result;
}

/* What has come, in a slice. */
static void upload(renderer *r, render_frame *frame)
{
    size_t slice          = r->options.upload_bytes < SIZE_MAX ? (size_t)r->options.upload_bytes : SIZE_MAX;
    frame->waiting_bytes  = vxs_gl_upload(r->shadows, slice);
    frame->uploaded_bytes = vxs_gl_uploaded_bytes(r->shadows) - r->uploaded_bytes;
    r->uploaded_bytes += frame->uploaded_bytes;
}

static double finished(const gl_context *gl)
{
    gl->Finish();
    return clock_seconds();
}

static vxs_result draw_frame(renderer *r, render_frame *frame, message *m)
{
    double since = finished(r->gl), now;
#define STAGE_ENDS(stage)                                                                                                          \
    now                   = finished(r->gl);                                                                                       \
    frame->seconds[stage] = now - since;                                                                                           \
    since                 = now;
    if (r->options.stream) upload(r, frame);
    STAGE_ENDS(RENDER_UPLOAD)
    vxs_gl_origin(r->shadows, r->camera.eye_ws);
    draw_surfaces(r);
    STAGE_ENDS(RENDER_SURFACES)
    if (renderer_culls(r) && vxs_gl_cull(r->shadows, &r->view, r->target[DEPTHS], r->options.tile_lights) != VXS_OK)
        return fail(m, VXS_E_GL, "OpenGL cannot make lists of lights for %u x %u samples", r->width, r->height);
    STAGE_ENDS(RENDER_CULL)
    if (r->options.stream) {
        vxs_result result = count_full(r, frame, m);
        if (result != VXS_OK) return result;
        since = finished(r->gl);
    }
    shade(r, SHOW_LIGHT, 0);
    STAGE_ENDS(RENDER_SHADE)
    if (r->exposure <= 0) {
        vxs_result result = choose_exposure(r, m);
        if (result != VXS_OK) return result;
        since = finished(r->gl);
    }
    if (r->fog) {
        vxs_result result = fog(r, &frame->fog, m);
        if (result != VXS_OK) return result;
    }
    STAGE_ENDS(RENDER_FOG)
    tone(r);
    STAGE_ENDS(RENDER_TONE)
#undef STAGE_ENDS
    return VXS_OK;
}

/* Rows of a picture from the bottom up, turned over. */
static void turn_over(void *pixels, size_t row_bytes, uint32_t height)
{
    char *p = pixels;
    for (uint32_t y = 0; y < height / 2; y++) {
        char *a = p + y * row_bytes, *b = p + (height - 1 - y) * row_bytes;
        for (size_t n = 0; n < row_bytes; n++) {
            char c = a[n];
            a[n]   = b[n];
            b[n]   = c;
        }
    }
}

static void read_target(const renderer *r, int target, GLenum format, GLenum type, size_t pixel_bytes, void *out)
{
    uint32_t width  = target == SCREEN ? r->options.width_px : r->width,
             height = target == SCREEN ? r->options.height_px : r->height;
    r->gl->PixelStorei(GL_PACK_ALIGNMENT, 1);
    r->gl->GetTextureImage(r->target[target], 0, format, type, (GLsizei)(width * height * pixel_bytes), out);
    turn_over(out, width * pixel_bytes, height);
}

vxs_result renderer_draw(renderer *r, const camera_pose *camera, uint8_t *rgb, render_frame *frame, message *m)
{
    *frame = (render_frame){0};
    set_view(r, camera);
    vxs_result result = draw_frame(r, frame, m);
    if (result == VXS_OK) result = count_lights(r, frame, m);
    if (result != VXS_OK) return result;
    if (!r->options.stream) frame->full_pixels = frame->surface_pixels;
    if (rgb) read_target(r, SCREEN, GL_RGB, GL_UNSIGNED_BYTE, 3, rgb);
    GLenum error = r->gl->GetError();
    return error == GL_NO_ERROR ? VXS_OK : fail(m, VXS_E_GL, "OpenGL says error 0x%x of a frame", error);
}

/* what it shows -------------------------------------------------------------------------------------------------------------------- */

void renderer_size(const renderer *r, uint32_t *width, uint32_t *height)
{
    *width  = r->width;
    *height = r->height;
}

vxs_result renderer_read(renderer *r, float *depths, float *normals, float *albedos, float *light, message *m)
{
    size_t count = (size_t)r->width * r->height;
    if (depths) {
        read_target(r, DEPTHS, GL_DEPTH_COMPONENT, GL_FLOAT, sizeof(float), depths);
        for (size_t n = 0; n < count; n++) depths[n] = depths[n] > 0 ? (float)r->near_metres / depths[n] : 0;
    }
    if (normals) read_target(r, NORMALS, GL_RGB, GL_FLOAT, 3 * sizeof(float), normals);
    if (albedos) read_target(r, ALBEDOS, GL_RGB, GL_FLOAT, 3 * sizeof(float), albedos);
    if (light) read_target(r, LIGHTS, GL_RGBA, GL_FLOAT, 4 * sizeof(float), light);
    return r->gl->GetError() == GL_NO_ERROR ? VXS_OK : fail(m, VXS_E_GL, "OpenGL cannot give back a picture");
}

vxs_result renderer_read_lit(renderer *r, uint32_t n, float *lit, message *m)
{
    size_t count = (size_t)r->width * r->height;
    float *light = malloc(4 * count * sizeof *light);
    if (!light) return fail(m, VXS_E_MEMORY, "out of memory for a picture of %u x %u samples", r->width, r->height);
    shade(r, SHOW_LIT, n);
    vxs_result result = renderer_read(r, NULL, NULL, NULL, light, m);
    for (size_t i = 0; result == VXS_OK && i < count; i++) lit[i] = light[4 * i + 3] > 0 ? light[4 * i] : -1;
    free(light);
    return result;
}

vxs_result renderer_read_airlight(renderer *r, float *air, message *m)
{
    size_t row = 3 * sizeof *air * r->width;
    r->gl->PixelStorei(GL_PACK_ALIGNMENT, 1);
    r->gl->GetTextureImage(fog_pass_airlight(r->fog), 0, GL_RGB, GL_FLOAT, (GLsizei)(row * r->height), air);
    turn_over(air, row, r->height);
    return r->gl->GetError() == GL_NO_ERROR ? VXS_OK : fail(m, VXS_E_GL, "OpenGL cannot give back a picture");
}

vxs_result renderer_read_full(renderer *r, float *full, message *m)
{
    size_t count = (size_t)r->width * r->height;
    float *found = malloc(4 * count * sizeof *found); /* lookups, those in full, -, whether there is a surface */
    if (!found) return fail(m, VXS_E_MEMORY, "out of memory for a picture of %u x %u samples", r->width, r->height);
    shade(r, SHOW_FULL, 0);
    vxs_result result = renderer_read(r, NULL, NULL, NULL, found, m);
    for (size_t n = 0; result == VXS_OK && n < count; n++) {
        const float *f = found + 4 * n;
        full[n]        = !(f[3] > 0) ? -1 : f[0] > 0 ? f[1] / f[0] : RENDER_NOT_ASKED;
    }
    free(found);
    return result;
}

void renderer_place(const renderer *r, uint32_t x, uint32_t y, float depth, double place_ws[3])
{
    double across = 2 * (x + 0.5) / r->width - 1, up = 1 - 2 * (y + 0.5) / r->height;
    for (int n = 0; n < 3; n++)
        place_ws[n] = r->camera.eye_ws[n] + (double)depth * (r->seen.forward[n] + across * r->seen.right[n] + up * r->seen.up[n]);
}

void renderer_fog_left(const renderer *r, const float *depths, float *left)
{
    for (uint32_t n = 0; n < r->width * r->height; n++) {
        double way[3], direction[3], part[3];
        renderer_place(r, n % r->width, n / r->width, depths[n] > 0 ? depths[n] : 1, way);
        vec3_sub(way, r->camera.eye_ws, way);
        double metres = sqrt(vec3_dot(way, way));
        for (int k = 0; k < 3; k++) direction[k] = way[k] / metres;
        fog_pass_left(r->fog, r->camera.eye_ws, direction, depths[n] > 0 ? metres : INFINITY, part);
        for (size_t k = 0; k < 3; k++) left[3 * (size_t)n + k] = (float)part[k];
    }
}

double renderer_exposure(const renderer *r)
{
    return r->exposure;
}

const double *renderer_light_colour(const renderer *r, uint32_t n)
{
    return r->colours[n];
}

const char *renderer_name(const renderer *r)
{
    return r->gl->renderer;
}
