/* Epipolar slices; see rival_slices.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "tests/volumes/rival_slices.h"

#include <math.h>
#include <stdlib.h>

#include "baker/base/vec3.h"
#include "tests/volumes/rival_pass.h"

EMBEDDED(moments_glsl)
EMBEDDED(rival_slices_glsl)

enum { FILL, TREE, SAMPLE, SHOW, SUM, SHOW_MOMENTS, PROGRAMS };

static const char *const names[PROGRAMS] = {"#define FILL\n", "#define TREE\n", "#define SAMPLE\n",
                                            "#define SHOW\n", "#define SUM\n",  "#define SHOW_MOMENTS\n"};

/* As the shader has it, std140. */
typedef struct slices_block {
    float axis[4], up[4],
        across
            [4]; /* of the slices' frame: toward the light, theta = 0, theta = pi / 2; axis[3]: metres to the light; up[3]: parts of
                      a ray that query moments; across[3]: 1 where there is no tree */
    float theta, theta_range, alpha, alpha_range;
    float bin_range, slices, bins, samples; /* the first: of phi, or metres; from 0 on */
    float depth_from_point[16];             /* of the view, by columns */
} slices_block;

struct rival_slices {
    vxs_volumes *v;
    slices_block block;
    gl_name      tree, airlight, moments, buffer, programs[PROGRAMS];
};

vxs_result rival_slices_create(rival_slices **out, vxs_volumes *v, uint32_t slices, uint32_t bins, uint32_t samples)
{
    rival_slices *s      = calloc(1, sizeof *s);
    vxs_result    result = VXS_OK;
    *out                 = NULL;
    if (!s) return VXS_E_MEMORY;
    s->v             = v;
    s->block.slices  = (float)slices;
    s->block.bins    = (float)bins;
    s->block.samples = (float)samples;
    s->tree          = vxs_volumes_texture(v, RIVAL_FORMAT_RG32F, 2 * bins, slices, 1);
    s->airlight      = vxs_volumes_texture(v, GL_FORMAT_RGBA32F, samples ? samples : 1, slices, 1);
    if (!s->tree || !s->airlight) result = VXS_E_MEMORY;
    v->api.CreateBuffers(1, &s->buffer);
    v->api.NamedBufferStorage(s->buffer, sizeof s->block, NULL, GL_STORAGE_DYNAMIC);
    for (int n = 0; n < SUM && result == VXS_OK; n++)
        if (!(s->programs[n] = rival_program(v, names[n], NULL, (const embedded[]){moments_glsl, rival_slices_glsl}, 2)))
            result = VXS_E_GL;
    if (result == VXS_OK)
        *out = s;
    else
        rival_slices_destroy(s);
    return result;
}

void rival_slices_destroy(rival_slices *s)
{
    if (!s) return;
    if (s->tree) s->v->api.DeleteTextures(1, &s->tree);
    if (s->airlight) s->v->api.DeleteTextures(1, &s->airlight);
    if (s->moments) s->v->api.DeleteTextures(1, &s->moments);
    if (s->buffer) s->v->api.DeleteBuffers(1, &s->buffer);
    for (int n = 0; n < PROGRAMS; n++)
        if (s->programs[n]) s->v->api.DeleteProgram(s->programs[n]);
    free(s);
}

/* The direction of a place of the view, [0, 1] each. */
static void direction_of(const frame_block *f, double x, double y, double direction[3])
{
    double       p[4];
    const float *m = f->point_from_depth;
    for (int n = 0; n < 4; n++) p[n] = (double)m[n] * x + (double)m[4 + n] * y + (double)m[8 + n] * 0.5 + (double)m[12 + n];
    for (int n = 0; n < 3; n++) direction[n] = p[n] / p[3] - (double)f->eye[n];
    vec3_unit(direction, direction);
}

/* By Gauss and Jordan, the largest pivot first.   Returns 0 where there is none */
static int invert(const float in[16], float out[16])
{
    double m[4][8] = {{0}};
    for (int r = 0; r < 4; r++)
        for (int c = 0; c < 4; c++) {
            m[r][c]     = (double)in[4 * c + r];
            m[r][4 + c] = r == c;
        }
    for (int c = 0; c < 4; c++) {
        int best = c;
        for (int r = c; r < 4; r++)
            if (fabs(m[r][c]) > fabs(m[best][c])) best = r;
        if (m[best][c] == 0) return 0;
        for (int k = 0; k < 8; k++) {
            double kept = m[c][k];
            m[c][k]     = m[best][k];
            m[best][k]  = kept;
        }
        for (int r = 0; r < 4; r++) {
            double times = m[r][c] / m[c][c];
            for (int k = 0; k < 8 && r != c; k++) m[r][k] -= times * m[c][k];
        }
    }
    for (int r = 0; r < 4; r++)
        for (int c = 0; c < 4; c++) out[4 * c + r] = (float)(m[r][4 + c] / m[r][r]);
    return 1;
}

static void store(float to[4], const double from[3])
{
    for (int n = 0; n < 3; n++) to[n] = (float)from[n];
}

/* The slices' frame: the axis, and two ways across it. */
static void set_axis(slices_block *b, const frame_block *f, double axis[3], double up[3], double across[3])
{
    int is_sun = f->light.kind == VXS_LIGHT_KIND_DIRECTIONAL, least = 0;
    for (int n = 0; n < 3; n++) axis[n] = (double)f->place[n] - (is_sun ? 0 : (double)f->eye[n]);
    b->axis[3] = (float)fmax(1e-6, sqrt(vec3_dot(axis, axis)));
    if (!vec3_unit(axis, axis)) axis[0] = 1; /* the eye is at the light */
    for (int n = 1; n < 3; n++)
        if (fabs(axis[n]) < fabs(axis[least])) least = n;
    double other[3] = {least == 0, least == 1, least == 2};
    vec3_cross(axis, other, up);
    vec3_unit(up, up);
    vec3_cross(axis, up, across);
}

/* Which angles the view has, by its border: where that goes around the axis or its other end, all theta, alpha from 0 or to pi. */
static void set_range(slices_block *b, const frame_block *f, const double axis[3], const double up[3], const double across[3])
{
    enum { STEPS = 256 };
    static const double corners[5][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0, 0}};
    double              theta = 0, first = 0, low = 0, high = 0, least = M_PI, most = 0, middle[3];
    for (int n = 0; n <= 4 * STEPS; n++) {
        int    side  = n / STEPS < 4 ? n / STEPS : 3;
        double share = (double)(n - side * STEPS) / STEPS, direction[3];
        double x     = corners[side][0] + share * (corners[side + 1][0] - corners[side][0]);
        double y     = corners[side][1] + share * (corners[side + 1][1] - corners[side][1]);
        direction_of(f, x, y, direction);
        double u = vec3_dot(direction, up), v = vec3_dot(direction, across);
        double alpha = atan2(hypot(u, v), vec3_dot(direction, axis)), next = atan2(v, u);
        least = fmin(least, alpha);
        most  = fmax(most, alpha);
        if (n == 0) first = theta = low = high = next;
        theta += remainder(next - theta, 2 * M_PI);
        low  = fmin(low, theta);
        high = fmax(high, theta);
    }
    direction_of(f, 0.5, 0.5, middle);
    if (fabs(theta - first) > M_PI) { /* around */
        low  = -M_PI;
        high = M_PI;
        if (vec3_dot(middle, axis) > 0) least = 0;
        if (vec3_dot(middle, axis) < 0) most = M_PI;
    }
    b->theta       = (float)low;
    b->theta_range = (float)fmax(1e-6, high - low);
    b->alpha       = (float)least;
    b->alpha_range = (float)fmax(1e-6, most - least);
    b->bin_range   = (float)(M_PI - least);
    if (f->light.kind == VXS_LIGHT_KIND_DIRECTIONAL)
        b->bin_range = (float)((double)f->far_metres * (least < M_PI / 2 && most > M_PI / 2 ? 1 : fmax(sin(least), sin(most))));
}

void rival_slices_set_flat(rival_slices *s, int flat)
{
    s->block.across[3] = flat ? 1 : 0;
}

vxs_result rival_slices_set_moments(rival_slices *s, uint32_t parts)
{
    s->block.up[3] = (float)parts;
    if (!parts || s->moments) return VXS_OK;
    for (int n = SUM; n < PROGRAMS; n++)
        if (!s->programs[n] &&
            !(s->programs[n] = rival_program(s->v, names[n], NULL, (const embedded[]){moments_glsl, rival_slices_glsl}, 2)))
            return VXS_E_GL;
    s->moments = vxs_volumes_texture(s->v, GL_FORMAT_RGBA32F, (uint32_t)s->block.bins + 1, (uint32_t)s->block.slices, 1);
    return s->moments ? VXS_OK : VXS_E_MEMORY;
}

static void run(rival_slices *s, int program, const vxs_shadow_depth_map *map, gl_name image, uint32_t x, uint32_t y)
{
    s->v->api.BindBufferBase(GL_TARGET_UNIFORM_BUFFER, RIVAL_BLOCK, s->buffer);
    s->v->api.BindImageTexture(RIVAL_IMAGE + 1, program >= SUM ? s->moments : s->airlight, 0, 1, 0, GL_ACCESS_READ_WRITE,
                               GL_FORMAT_RGBA32F);
    rival_run(s->v, s->programs[program], map, image, RIVAL_FORMAT_RG32F, x, y, 1);
}

vxs_result rival_slices_add(rival_slices *s, const vxs_volumes_light *light, const vxs_shadow_depth_map *map)
{
    vxs_volumes  *v = s->v;
    slices_block *b = &s->block;
    double        axis[3], up[3], across[3];
    vxs_result    result = vxs_volumes_set_light(v, light, map);
    if (result != VXS_OK) return result;
    if (!invert(v->frame.point_from_depth, b->depth_from_point)) return VXS_E_ARGUMENT;
    set_axis(b, &v->frame, axis, up, across);
    store(b->axis, axis);
    store(b->up, up);
    store(b->across, across);
    set_range(b, &v->frame, axis, up, across);
    v->api.NamedBufferSubData(s->buffer, 0, sizeof *b, b);

    uint32_t slices = (uint32_t)b->slices, wide = (uint32_t)v->frame.wide_px, high = (uint32_t)v->frame.high_px;
    run(s, FILL, map, s->tree, rival_groups((uint32_t)b->bins, 64), slices);
    if (b->up[3] > 0) {
        run(s, SUM, map, s->tree, rival_groups(slices, 64), 1);
        run(s, SHOW_MOMENTS, map, s->tree, rival_groups(wide, 64), high);
        return VXS_OK;
    }
    run(s, TREE, map, s->tree, 1, slices);
    if (b->samples > 0) run(s, SAMPLE, map, s->tree, rival_groups((uint32_t)b->samples, 64), slices);
    run(s, SHOW, map, s->tree, rival_groups(wide, 64), high);
    return VXS_OK;
}
