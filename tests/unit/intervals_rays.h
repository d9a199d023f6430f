/* Questions to shaders: the lit intervals of random rays; and their answers against intervals in double. Included behind cmocka.h,
 * with baker/lab/opengl/gl.h first of all.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef INTERVALS_RAYS_H
#define INTERVALS_RAYS_H

#include <math.h>
#include <stdlib.h>

#include "random_light.h"
#include "repeats.h"
#include "runtime/gl/vxs_gl.h"
#include "runtime/volumes/volumes_text.h"
#include "runtime/vxs_query.h"
#include "tests/gl_choice.h"

enum { RAYS = 512, SPANS = 400, RAYS_AT = 10, SPANS_AT = 11, ROOM = 4 * (1 + SPANS) };

/* As shaders read it. */
typedef struct asked_ray {
    float    origin[3], begin, direction[3], end;
    uint32_t light, unused[3];
} asked_ray;

/* What one answers: how many spans, and each. */
typedef struct answer {
    float count, unused[3];
    struct {
        float begin, end, state, coarse;
    } span[SPANS];
} answer;

static const char rays_text[] =
    "layout(local_size_x = 64) in;\n"
    "struct asked { vec4 origin, direction; uvec4 light; };\n"
    "layout(std430, binding = 10) readonly restrict buffer rays_block { asked rays[]; };\n"
    "layout(std430, binding = 11) restrict buffer spans_block { vec4 spans[]; };\n"
    "void main() {\n"
    "    asked ray = rays[gl_GlobalInvocationID.x];\n"
    "    int at = int(gl_GlobalInvocationID.x) * 401, count = 0;\n"
    "    vxs_light_constants light = vxs_light_at(ray.light.x);\n"
    "    vxs_walk w = vxs_walk_of(light, ray.origin.xyz, ray.direction.xyz, ray.origin.w, ray.direction.w);\n"
    "    vxs_span span;\n"
    "    while (count < 400 && vxs_walk_next(light.first_word, light, w, span) != 0) {\n"
    "        count++;\n"
    "        spans[at + count] = vec4(span.begin, span.end, float(span.state), float(span.coarse));\n"
    "    }\n"
    "    spans[at] = vec4(float(count));\n"
    "}\n";

typedef struct asker {
    gl_context *gl;
    vxs_gl     *shadows;
    GLuint      program, rays, spans;
    asked_ray   asked[RAYS];
    answer     *answers; /* [RAYS] */
} asker;

/* Compile a program for lights that are uploaded. */
static inline void asker_compile(asker *a)
{
    gl_context *gl   = a->gl;
    GLint       good = 0;
    char        log[4096];
    const char *texts[VXS_GL_TEXTS + 3];
    GLuint      shader;
    vxs_gl_texts(a->shadows, texts);
    texts[VXS_GL_TEXTS]     = vxs_volumes_text_vxs_depths_h.text;
    texts[VXS_GL_TEXTS + 1] = vxs_volumes_text_vxs_intervals_h.text;
    texts[VXS_GL_TEXTS + 2] = rays_text;
    shader                  = gl->CreateShader(GL_COMPUTE_SHADER);
    a->program              = gl->CreateProgram();
    gl->ShaderSource(shader, VXS_GL_TEXTS + 3, texts, NULL);
    gl->CompileShader(shader);
    ((PFNGLGETSHADERINFOLOGPROC)gl_choice_proc("glGetShaderInfoLog", NULL))(shader, sizeof log, NULL, log);
    if (log[0]) fail_msg("%s", log);
    gl->AttachShader(a->program, shader);
    gl->LinkProgram(a->program);
    gl->GetProgramiv(a->program, GL_LINK_STATUS, &good);
    assert_true(good);
    gl->DeleteShader(shader);
    gl->GenBuffers(1, &a->rays);
    gl->GenBuffers(1, &a->spans);
}

static inline void asker_close(asker *a)
{
    a->gl->DeleteBuffers(1, &a->rays);
    a->gl->DeleteBuffers(1, &a->spans);
    a->gl->DeleteProgram(a->program);
    vxs_gl_destroy(a->shadows);
    free(a->answers);
}

static inline void ask(asker *a)
{
    gl_context *gl = a->gl;
    gl->UseProgram(a->program);
    vxs_gl_bind(a->shadows);
    gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, a->rays);
    gl->BufferData(GL_SHADER_STORAGE_BUFFER, sizeof a->asked, a->asked, GL_STATIC_DRAW);
    gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, RAYS_AT, a->rays);
    gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, a->spans);
    gl->BufferData(GL_SHADER_STORAGE_BUFFER, RAYS * sizeof(answer), NULL, GL_STATIC_DRAW);
    gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, SPANS_AT, a->spans);
    ((PFNGLDISPATCHCOMPUTEPROC)gl_choice_proc("glDispatchCompute", NULL))(RAYS / 64, 1, 1);
    ((PFNGLMEMORYBARRIERPROC)gl_choice_proc("glMemoryBarrier", NULL))(GL_BUFFER_UPDATE_BARRIER_BIT);
    ((PFNGLGETBUFFERSUBDATAPROC)gl_choice_proc("glGetBufferSubData", NULL))(GL_SHADER_STORAGE_BUFFER, 0, RAYS * sizeof(answer),
                                                                            a->answers);
    assert_int_equal(gl->GetError(), GL_NO_ERROR);
}

/* One behind the other without gaps, each unlike the one before it, from begin to end. */
static inline void check_parts(const asked_ray *ray, const answer *found)
{
    uint32_t count = (uint32_t)found->count;
    assert_in_range(count, 1, SPANS);
    assert_true(found->span[0].begin == ray->begin);
    if (count < SPANS) assert_true(found->span[count - 1].end == ray->end);
    for (uint32_t n = 0; n < count; n++) {
        assert_true(found->span[n].begin < found->span[n].end);
        if (!n) continue;
        assert_true(found->span[n].begin == found->span[n - 1].end);
        assert_true(found->span[n].state != found->span[n - 1].state || found->span[n].coarse != found->span[n - 1].coarse);
    }
}

/* How much of a ray is reported as something else by intervals in double. */
static inline double difference(const vxs_baked_light *light, const asked_ray *ray, const answer *found)
{
    static vxs_interval list[8 * SPANS];
    vxs_lit_walk        walk;
    vxs_ray             in_double = {.t_begin = (double)ray->begin, .t_end = (double)ray->end};
    double              differs = 0, from = in_double.t_begin;
    for (int n = 0; n < 3; n++) {
        in_double.origin_ws[n]    = (double)ray->origin[n];
        in_double.direction_ws[n] = (double)ray->direction[n];
    }
    assert_int_equal(vxs_lit_begin(&walk, light, &in_double), VXS_OK);
    size_t count = vxs_lit_next(&walk, list, 8 * SPANS), n = 0;
    for (uint32_t at = 0; n < count && at < (uint32_t)found->count;) {
        double end = fmin(list[n].t_end, (double)found->span[at].end);
        if (list[n].state != (int)found->span[at].state || list[n].coarse != (int)found->span[at].coarse) differs += end - from;
        from = end;
        if (list[n].t_end <= end) n++;
        if ((double)found->span[at].end <= end) at++;
    }
    return differs / ((double)ray->end - (double)ray->begin);
}

/* A place in a map, or about it. */
static inline void random_place(rng *r, const vxs_light *light, double *ws)
{
    double side = ldexp(1, (int)light->levels), c[3];
    for (int axis = 0; axis < 3; axis++) c[axis] = uniform(r, -0.3, 1.3) * side;
    vxs_point(light, (int)rng_below(r, vxs_map_count(light)), c, ws);
}

static inline void random_rays(rng *r, asker *a, const vxs_baked_light *lights, uint32_t light_count)
{
    for (uint32_t n = 0; n < RAYS; n++) {
        uint32_t         which = rng_below(r, light_count);
        const vxs_light *light = &lights[which].light;
        double           from[3], to[3];
        asked_ray       *ray = &a->asked[n];
        *ray                 = (asked_ray){.end = 1, .light = which};
        random_place(r, light, from);
        random_place(r, light, to);
        if (n % 8 == 0) /* from the light, or to it */
            for (int i = 0; i < 3; i++) {
                double at = -light->ls_from_ws[i] * light->ls_from_ws[3] - light->ls_from_ws[4 + i] * light->ls_from_ws[7] -
                            light->ls_from_ws[8 + i] * light->ls_from_ws[11];
                if (light->kind != VXS_LIGHT_KIND_DIRECTIONAL) *(n % 16 ? &from[i] : &to[i]) = at;
            }
        if (n % 8 == 1) /* along an axis */
            for (int i = 0; i < 3; i++)
                if (i != (int)(n / 8 % 3)) to[i] = from[i];
        if (n % 8 == 2) ray->begin = -0.5F, ray->end = 2;
        for (int i = 0; i < 3; i++) {
            ray->origin[i]    = (float)from[i];
            ray->direction[i] = (float)(to[i] - from[i]);
        }
    }
}

/* Rays in all of the lights, against intervals in double. Floats may see a border on the other side of a ray that runs along it.
 * Returns how many spans are coarse. */
static inline uint32_t check_rays(rng *r, asker *a, const vxs_baked_light *lights, uint32_t light_count, const char *what)
{
    double   sum = 0;
    uint32_t far = 0, rays = 0, spans = 0, coarse = 0;
    for (uint32_t turn = 0; turn < repeats(2, 20); turn++) {
        random_rays(r, a, lights, light_count);
        ask(a);
        for (uint32_t n = 0; n < RAYS; n++) {
            const answer *found = &a->answers[n];
            check_parts(&a->asked[n], found);
            if (found->count == SPANS) continue;
            double differs = difference(&lights[a->asked[n].light], &a->asked[n], found);
            sum += differs;
            far += differs > 1e-3;
            rays++;
            spans += (uint32_t)found->count;
            for (uint32_t span = 0; span < (uint32_t)found->count; span++) coarse += found->span[span].coarse != 0;
        }
    }
    if (getenv("VXS_VERBOSE"))
        print_message("%s: %u rays, %u spans, %u coarse; differ by %.2g in the mean, %u by more than 1e-3\n", what, rays, spans,
                      coarse, sum / rays, far);
    assert_in_range(rays, RAYS / 2, UINT32_MAX);
    assert_in_range(spans, 2 * rays, UINT32_MAX);
    assert_true(sum < 2e-4 * rays);
    assert_in_range(far, 0, rays / 50);
    return coarse;
}

static inline gl_context *open_context(void)
{
    gl_context *gl = NULL;
    run_context m  = {0};
    if (gl_context_create(&gl, gl_choice(), 1, &m) != VXS_OK) {
        print_message("no OpenGL 4.5: %s\n", m.error);
        skip();
    }
    return gl;
}

#endif
