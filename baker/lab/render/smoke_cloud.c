/* Capsules over the picture; see smoke_pass.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/render/smoke_pass.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/memory.h"
#include "baker/base/vec3.h"
#include "baker/lab/render/renderer_state.h"

EMBEDDED(smoke_light_frag_glsl)
EMBEDDED(smoke_quads_glsl)
EMBEDDED(capsule_glsl)

/* quads ------------------------------------------------------------------------------------------------------------------------ */

typedef struct quad_order {
    double   metres; /* from the eye to its middle */
    uint32_t capsule;
} quad_order;

/* The place for light lookups, as a share of the distance from a capsule's middle to a corner: far enough out that the shadows
 * of other capsules may differ. */
static const double ASKED_AT = 0.6;

vxs_result smoke_quads_reserve(smoke_quads *q, const scene_smoke *smoke, run_context *m)
{
    uint64_t   each = sizeof *q->capsules + SMOKE_CORNERS * (sizeof *q->corners + sizeof *q->places) + sizeof *q->order;
    vxs_result r    = memory_check(smoke->count * each, m, "drawing %u capsules of smoke needs", smoke->count);
    *q              = (smoke_quads){.count = smoke->count};
    if (r != VXS_OK) return r;
    q->capsules = malloc(smoke->count * sizeof *q->capsules);
    q->corners  = malloc(SMOKE_CORNERS * (size_t)smoke->count * sizeof *q->corners);
    q->places   = malloc(SMOKE_CORNERS * (size_t)smoke->count * sizeof *q->places);
    q->order    = malloc(smoke->count * sizeof *q->order);
    if (q->capsules && q->corners && q->places && q->order) return VXS_OK;
    return fail(m, VXS_E_MEMORY, "out of memory for %u capsules of smoke", smoke->count);
}

void smoke_quads_free(smoke_quads *q)
{
    free(q->capsules);
    free(q->corners);
    free(q->places);
    free(q->order);
    *q = (smoke_quads){0};
}

/* Order: the farthest first; equal ones in the scene's order. */
static int is_farther(const void *a, const void *b)
{
    const quad_order *x = a, *y = b;
    if (x->metres != y->metres) return x->metres > y->metres ? -1 : 1;
    return x->capsule < y->capsule ? -1 : x->capsule > y->capsule;
}

/* The plane of a quad: through the capsule's middle, perpendicular to the direction from the eye; u along the capsule's axis as
 * seen. */
typedef struct quad_plane {
    double middle[3], u[3], v[3], half_u, half_v;
} quad_plane;

/* Find the plane of a capsule's quad; parts nearer than it appear larger.   Returns 0 when the eye is in the capsule, or nearly */
static int find_plane(const vxs_capsule *c, quad_plane *p)
{
    double axis[3], way[3], radius = (double)c->radius_metres;
    for (int n = 0; n < 3; n++) {
        axis[n]      = 0.5 * ((double)c->end[n] - (double)c->begin[n]);
        p->middle[n] = 0.5 * ((double)c->end[n] + (double)c->begin[n]);
    }
    double metres = sqrt(vec3_dot(p->middle, p->middle));
    if (!vec3_unit(p->middle, way)) return 0;
    double ahead = vec3_dot(axis, way), reach = fabs(ahead) + radius;
    if (!(metres > 1.1 * reach)) return 0;
    vec3_mad(axis, -ahead, way, p->u);
    double aside = sqrt(vec3_dot(p->u, p->u)), larger = metres / (metres - reach);
    if (!(aside > 1e-6 * radius) || !vec3_unit(p->u, p->u)) vec3_across(way, p->u, p->v);
    vec3_cross(way, p->u, p->v);
    p->half_u = larger * (aside + radius);
    p->half_v = larger * radius;
    return 1;
}

void smoke_quads_make(smoke_quads *q, const scene_smoke *smoke, const smoke_eye *eye)
{
    for (uint32_t n = 0; n < q->count; n++) {
        double middle[3];
        for (int k = 0; k < 3; k++)
            middle[k] =
                0.5 * ((double)smoke->list[n].begin[k] + (double)smoke->list[n].end[k]) + smoke->origin_ws[k] - eye->at_ws[k];
        q->order[n] = (quad_order){sqrt(vec3_dot(middle, middle)), n};
    }
    qsort(q->order, q->count, sizeof *q->order, is_farther);

    quad_plane whole = {.half_u = 1, .half_v = 1}; /* covers the whole picture, a metre in front of the eye */
    memcpy(whole.middle, eye->seen.forward, sizeof whole.middle);
    memcpy(whole.u, eye->seen.right, sizeof whole.u);
    memcpy(whole.v, eye->seen.up, sizeof whole.v);
    q->covered_px = 0;
    for (uint32_t n = 0; n < q->count; n++) {
        uint32_t       from = q->order[n].capsule;
        drawn_capsule *to   = &q->capsules[n];
        to->capsule         = smoke_widened(smoke->list[from], 0.5 * eye->pixel_metres * q->order[n].metres);
        smoke_from_eye(smoke, &to->capsule, eye->at_ws);
        for (int k = 0; k < 4; k++) to->albedo[k] = k < 3 ? smoke->albedos[from][k] : 0;

        quad_plane p;
        int        is_near = !find_plane(&to->capsule, &p);
        quad_plane drawn   = is_near ? whole : p;
        double     pixel   = eye->pixel_metres * sqrt(vec3_dot(p.middle, p.middle));
        q->covered_px += is_near ? eye->all_px : fmin(eye->all_px, 4 * p.half_u * p.half_v / (pixel * pixel));
        for (int corner = 0; corner < SMOKE_CORNERS; corner++) {
            float *at    = q->corners[SMOKE_CORNERS * (size_t)n + (size_t)corner],
                  *asked = q->places[SMOKE_CORNERS * (size_t)n + (size_t)corner];
            double u = (corner & 1 ? 1 : -1) * drawn.half_u, v = (corner & 2 ? 1 : -1) * drawn.half_v;
            for (int k = 0; k < 3; k++) {
                double aside = u * drawn.u[k] + v * drawn.v[k];
                at[k]        = (float)(drawn.middle[k] + aside);
                asked[k]     = (float)(p.middle[k] + (is_near ? 0 : ASKED_AT * aside));
            }
            at[3] = asked[3] = 0;
        }
    }
}

/* drawing ---------------------------------------------------------------------------------------------------------------------- */

/* Bindings; and the width of the texture with the lights of corners. */
enum {
    CAPSULES_BINDING = 5,
    CORNERS_BINDING  = 6,
    LEFT_BINDING     = 8,
    DEPTHS_UNIT      = 0,
    AIRLIGHT_UNIT    = 1,
    LIGHTS_UNIT      = 3,
    ROW              = 4096
};
enum { CAPSULES, CORNERS, PLACES, LEFT, BUFFERS };

/* Limit on samples that quads cover: they take a minute on two processors. */
static const double COVERED_MOST = 2e9;

struct smoke_cloud {
    const scene_smoke *smoke;
    smoke_quads        quads;
    GLuint             light_program, program, buffers[BUFFERS], lights, lights_frame;
    uint32_t           rows;
};

/* create ----------------------------------------------------------------------------------------------------------------------- */

static void take_buffer(const renderer *r, GLuint buffer, size_t size, const void *data)
{
    r->gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, buffer);
    r->gl->BufferData(GL_SHADER_STORAGE_BUFFER, (GLsizeiptr)size, data, GL_DYNAMIC_DRAW);
}

vxs_result renderer_make_cloud(renderer *r, const scene_smoke *smoke, run_context *m)
{
    const gl_context *gl = r->gl;
    smoke_cloud      *c = r->cloud = calloc(1, sizeof *c);
    if (!c) return fail(m, VXS_E_MEMORY, "out of memory for smoke");
    size_t     corners = SMOKE_CORNERS * (size_t)smoke->count, layers = r->smoke->layers;
    vxs_result result = smoke_quads_reserve(&c->quads, smoke, m);
    if (result == VXS_OK) result = renderer_lit_program(r, &c->light_program, smoke_light_frag_glsl, vxs_box(1), m);
    if (result == VXS_OK) result = gl_program_of(gl, &c->program, smoke_quads_glsl, gl_embedded(capsule_glsl), m);
    if (result != VXS_OK) return result;
    c->smoke = smoke;
    c->rows  = (uint32_t)((corners + ROW - 1) / ROW);
    gl->GenBuffers(BUFFERS, c->buffers);
    take_buffer(r, c->buffers[LEFT], (layers + !layers) * corners * sizeof(float), NULL);
    gl->CreateTextures(GL_TEXTURE_2D, 1, &c->lights);
    gl->TextureStorage2D(c->lights, 1, GL_RGBA32F, ROW, (GLsizei)c->rows);
    c->lights_frame = gl_frame(gl, 0, &c->lights, 1);
    return gl->GetError() == GL_NO_ERROR ? VXS_OK
                                         : fail(m, VXS_E_MEMORY, "OpenGL has no room for %u capsules of smoke", smoke->count);
}

void renderer_free_cloud(renderer *r)
{
    smoke_cloud *c = r->cloud;
    if (!c) return;
    smoke_quads_free(&c->quads);
    r->gl->DeleteBuffers(BUFFERS, c->buffers);
    r->gl->DeleteTextures(1, &c->lights);
    r->gl->DeleteFramebuffers(1, &c->lights_frame);
    if (c->light_program) r->gl->DeleteProgram(c->light_program);
    if (c->program) r->gl->DeleteProgram(c->program);
    free(c);
}

/* frame ------------------------------------------------------------------------------------------------------------------------ */

static void set4(const renderer *r, const char *name, const double rgb[3], double last)
{
    GLuint p = r->cloud->program;
    r->gl->ProgramUniform4f(p, r->gl->GetUniformLocation(p, name), (float)rgb[0], (float)rgb[1], (float)rgb[2], (float)last);
}

/* Smoke gets the sky light of vertical surfaces; of a sky map, its mean. */
static void set_uniforms(const renderer *r)
{
    static const double sky[3] = {0.375, 0.4425, 0.5775}; /* between the ground and the sky of tone_frag.glsl */
    const fog_medium   *medium = r->options.fog;
    double              ambient[3], fog_ambient[3], extinction[3] = {0}, turned[3] = {0};
    renderer_fog_ambient(r, fog_ambient);
    if (r->sky) sky_pass_mean(r->sky, r->exposure, ambient);
    for (int n = 0; n < 3; n++) {
        if (!r->sky) ambient[n] = 0.30 * renderer_day(r) * sky[n];
        if (!medium) continue;
        extinction[n] = medium->extinction[n];
        if (extinction[n] > 0) turned[n] = fog_ambient[n] * medium->scattering[n] / extinction[n];
    }
    set4(r, "lights", (const double[3]){r->exposure, r->near_metres, 0}, 0);
    set4(r, "ambient", ambient, 0);
    set4(r, "extinction", extinction, medium ? fmin(medium->top_ws - r->camera.eye_ws[1], 1e30) : 1e30);
    set4(r, "turned", turned, fog_pass_far_metres(r->fog));
}

vxs_result renderer_draw_cloud(renderer *r, run_context *m)
{
    const gl_context *gl     = r->gl;
    smoke_cloud      *c      = r->cloud;
    const double      eye[3] = {0};
    float             matrix[16];

    smoke_eye view    = {.seen         = r->seen,
                         .pixel_metres = 2 * sqrt(vec3_dot(r->seen.up, r->seen.up)) / r->height,
                         .all_px       = (double)r->width * r->height};
    size_t    corners = SMOKE_CORNERS * (size_t)c->quads.count;
    for (int n = 0; n < 3; n++) view.at_ws[n] = r->camera.eye_ws[n];
    smoke_quads_make(&c->quads, c->smoke, &view);
    take_buffer(r, c->buffers[CAPSULES], c->quads.count * sizeof *c->quads.capsules, c->quads.capsules);
    take_buffer(r, c->buffers[CORNERS], corners * sizeof *c->quads.corners, c->quads.corners);
    take_buffer(r, c->buffers[PLACES], corners * sizeof *c->quads.places, c->quads.places);

    if (c->quads.covered_px > COVERED_MOST)
        warn(m,
             "smoke: %u capsules cover the picture %.0f times, which takes long to draw: a smaller picture, or --samples 1, takes "
             "less",
             c->quads.count, c->quads.covered_px / ((double)r->width * r->height));
    vxs_result result = smoke_pass_ask(r->smoke, c->buffers[PLACES], (uint32_t)corners, c->buffers[LEFT]);
    if (result != VXS_OK) return fail(m, result, "smoke cannot be drawn: %s", vxs_result_text(result));
    renderer_bind_lights(r); /* the light at corners */
    gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, CAPSULES_BINDING, c->buffers[PLACES]);
    gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, LEFT_BINDING, c->buffers[LEFT]);
    gl->BindFramebuffer(GL_FRAMEBUFFER, c->lights_frame);
    gl->Viewport(0, 0, ROW, (GLsizei)c->rows);
    renderer_add_lights(r, c->light_program, "sizes", 2, (const GLint[4]){ROW, (GLint)corners, 0, 0});

    set_uniforms(r);
    renderer_clip(r, eye, matrix);
    gl->ProgramUniformMatrix4fv(c->program, gl->GetUniformLocation(c->program, "clip_from_eye"), 1, GL_FALSE, matrix);
    gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, CAPSULES_BINDING, c->buffers[CAPSULES]);
    gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, CORNERS_BINDING, c->buffers[CORNERS]);
    gl->BindTextureUnit(DEPTHS_UNIT, r->target[DEPTHS]);
    gl->BindTextureUnit(AIRLIGHT_UNIT, vxs_volumes_airlight(r->fog->volumes));
    gl->BindTextureUnit(LIGHTS_UNIT, c->lights);
    gl->BindFramebuffer(GL_FRAMEBUFFER, r->picture_frame);
    gl->Viewport(0, 0, (GLsizei)r->width, (GLsizei)r->height);
    gl->Enable(GL_BLEND);
    gl->BlendFunc(GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
    gl->UseProgram(c->program);
    gl->BindVertexArray(r->empty_array);
    gl->DrawArrays(GL_TRIANGLES, 0, (GLsizei)(6 * c->quads.count));
    gl->Disable(GL_BLEND);
    return VXS_OK;
}
