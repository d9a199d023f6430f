/* What is seen, and the airlight that is wanted there, in double: that between exact lit intervals of the asset, or of rays among
 * spheres, or another; see volumes_bench.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "tests/bench/volumes_bench.h"

#include <math.h>
#include <stdlib.h>

#include "baker/base/parallel.h"
#include "baker/files/json_value.h"
#include "baker/lab/opengl/gl.h"
#include "baker/lab/picture/fog.h"
#include "baker/light/map_space.h"
#include "tests/volumes/sphere_fog.h"

#define NEAR_METRES 0.01

/* Depths are NEAR_METRES over metres along the axis, 0 where nothing is. Places count from the first camera. */
static void set_view(vxs_volumes_frame *f, const camera_view *v, const double eye[3], uint32_t width, uint32_t height)
{
    float *m = f->view.point_from_depth;
    f->view  = (vxs_view){.width_px = width, .height_px = height};
    for (int n = 0; n < 3; n++) {
        m[n]      = (float)(2 * v->right[n] * NEAR_METRES);
        m[4 + n]  = (float)(2 * v->up[n] * NEAR_METRES);
        m[8 + n]  = (float)eye[n];
        m[12 + n] = (float)((v->forward[n] - v->right[n] - v->up[n]) * NEAR_METRES);
        f->eye[n] = (float)eye[n];
    }
    m[11] = 1;
}

/* b->light, in double */
static fog_light fog_light_of(const bench *b)
{
    const vxs_baked_light *baked = vxs_asset_light(b->asset, b->number);
    fog_light              light = {baked, baked_light_shape(&baked->light), {1, 1, 1}, 1, b->radius_metres};
    light.cos_inner              = fmax(cos(light.shape.outer_rad), -1); /* no rim */
    return light;
}

void volumes_airlight_wanted(const bench *b, const double eye_ws[3], const double direction[3], double metres, size_t ray,
                             double to[3])
{
    fog_light light = fog_light_of(b);
    (void)ray;
    if (b->is_of_spheres)
        sphere_fog_add_airlight(&b->medium, &light, &b->spheres, eye_ws, direction, metres, to);
    else
        fog_add_airlight(&b->medium, &light, 1, eye_ws, direction, metres, to);
}

typedef struct seen {
    bench             *b;
    const camera_view *view;
    double             eye_ws[3];
    uint32_t           camera;
    wanted_of_ray     *wanted;
    light_shape        light;
    float             *depths;
} seen;

static void see_pixels(void *user, size_t begin, size_t end, uint32_t worker)
{
    seen  *s = user;
    bench *b = s->b;
    (void)worker;
    for (size_t n = begin; n < end; n++) {
        size_t x = n % b->width, y  = n / b->width;
        double direction[3], metres = INFINITY, *to = b->wanted + 3 * ((size_t)s->camera * b->pixels + n);
        camera_direction(s->view, (double)(x + 0.5) / b->width, 1 - (double)(y + 0.5) / b->height, direction);
        int    hit   = truth_first_hit(b->truth, s->eye_ws, direction, &metres, NULL, NULL);
        double along = 0;
        for (int k = 0; k < 3; k++) along += direction[k] * s->view->forward[k];
        s->depths[n] = hit ? (float)(NEAR_METRES / (metres * along)) : 0;
        metres       = s->depths[n] > 0 ? NEAR_METRES / ((double)s->depths[n] * along) : b->far_metres; /* as a float has it */
        to[0] = to[1] = to[2] = 0;
        metres                = fmin(metres, b->far_metres);
        s->wanted(b, s->eye_ws, direction, metres, n, to);
        if (s->camera == 0 && b->classes)
            b->classes[n] = s->light.kind == LIGHT_DIRECTIONAL
                                ? PIXELS_ELSEWHERE
                                : (uint8_t)pixel_class_of(s->eye_ws, direction, s->light.position_ws, b->radius_metres);
    }
}

/* The light's own texels, where the camera looks, are what shadows flicker by. */
static double texel_metres(const bench *b)
{
    const vxs_light  *l      = &vxs_asset_light(b->asset, b->number)->light;
    const light_shape shape  = baked_light_shape(l);
    double            square = 0;
    if (shape.kind == LIGHT_DIRECTIONAL) return l->texel_metres;
    for (int n = 0; n < 3; n++) square += pow(shape.position_ws[n] - b->pose.target_ws[n], 2);
    return l->texel_metres * sqrt(square);
}

vxs_result volumes_see(bench *b, uint32_t camera, wanted_of_ray *wanted, run_context *m)
{
    camera_view        view  = camera_view_of(&b->pose, (double)b->width / b->height);
    vxs_volumes_frame *f     = &b->frames[camera];
    double             aside = texel_metres(b) * camera / CAMERAS, length = 0, eye[3];
    GLuint             texture;
    seen               s = {.b      = b,
                            .view   = &view,
                            .camera = camera,
                            .wanted = wanted,
                            .light  = baked_light_shape(&vxs_asset_light(b->asset, b->number)->light)};
    s.depths             = malloc(b->pixels * sizeof *s.depths);
    if (!s.depths) return fail(m, VXS_E_MEMORY, "out of memory for a picture");
    for (int n = 0; n < 3; n++) length += view.right[n] * view.right[n];
    for (int n = 0; n < 3; n++) {
        eye[n]      = aside * view.right[n] / sqrt(length);
        s.eye_ws[n] = b->pose.eye_ws[n] + eye[n];
    }
    set_view(f, &view, eye, b->width, b->height);
    parallel_for(b->threads, b->pixels, b->width, see_pixels, &s);
    b->gl->CreateTextures(GL_TEXTURE_2D, 1, &texture);
    b->gl->TextureStorage2D(texture, 1, GL_R32F, (GLsizei)b->width, (GLsizei)b->height);
    b->gl->TextureSubImage2D(texture, 0, 0, 0, (GLsizei)b->width, (GLsizei)b->height, GL_RED, GL_FLOAT, s.depths);
    free(s.depths);
    f->depth_texture = texture;
    f->far_metres    = (float)b->far_metres;
    f->anisotropy    = (float)b->medium.anisotropy;
    f->top_metres    = (float)fmin(b->medium.top_ws - b->pose.eye_ws[1], 1e30);
    for (int n = 0; n < 3; n++) {
        f->scattering[n] = (float)b->medium.scattering[n];
        f->extinction[n] = (float)b->medium.extinction[n];
    }
    return VXS_OK;
}

void volumes_describe_view(const bench *b, json_t **o)
{
    json_set(o, "scene", json_text(b->scene_path));
    if (b->asset_path) json_set(o, "file", json_text(b->asset_path));
    json_set(o, "eye", json_vector(b->pose.eye_ws));
    json_set(o, "target", json_vector(b->pose.target_ws));
    json_set(o, "extinction_per_metre", json_vector(b->medium.extinction));
    json_set(o, "scattering_per_metre", json_vector(b->medium.scattering));
    json_set(o, "anisotropy", json_real(b->medium.anisotropy));
}
