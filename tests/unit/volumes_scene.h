/* A small scene in fog: boxes on a floor, baked for a sun, a spot and a point light; views of it, with depths by brute force;
 * libvxs_volumes on them. Included behind cmocka.h and random_light.h, with baker/lab/opengl/gl.h first of all.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef VOLUMES_SCENE_H
#define VOLUMES_SCENE_H

#include "baker/vxs_bake.h"
#include "runtime/gl/vxs_gl.h"
#include "runtime/volumes/vxs_air_path.h"
#include "runtime/volumes/vxs_transmittance.h"
#include "runtime/volumes/vxs_volumes.h"
#include "runtime/vxs.h"
#include "runtime/vxs_query.h"
#include "tests/gl_choice.h"

#include "repeats.h"

enum { SCENE_SUN, SCENE_SPOT, SCENE_POINT, SCENE_LIGHTS, SCENE_BOXES = 12, SCENE_TRIANGLES = 12 * SCENE_BOXES + 2 };

#define EMPTY_DEPTH 0.0F
#define NEAR_METRES 0.1

typedef struct volumes_scene {
    gl_context  *gl;
    float        positions[3 * (8 * SCENE_BOXES + 4)];
    uint32_t     indices[3 * SCENE_TRIANGLES];
    vxs_asset   *asset;
    vxs_gl      *shadows;
    vxs_volumes *volumes;
    uint32_t     width_px, height_px;
    GLuint       depths;
} volumes_scene;

typedef struct volumes_camera {
    double eye[3], right[3], up[3], forward[3], tangent; /* of half the view, across and up */
} volumes_camera;

static char scene_said[1024];

static inline void scene_log(vxs_severity severity, const char *text, void *user)
{
    (void)user;
    assert_int_equal(severity, VXS_SEVERITY_ERROR);
    snprintf(scene_said, sizeof scene_said, "%s", text);
    print_message("%s\n", text);
}

/* The last line of the log, which is forgotten, has a word. */
static inline void assert_said(const char *word)
{
    if (!strstr(scene_said, word)) fail_msg("'%s', expected '%s'", scene_said, word);
    *scene_said = 0;
}

/* Boxes of 20 x 20 metres of ground; no light is in one. */
static inline void scene_boxes(volumes_scene *s, rng *r)
{
    static const uint32_t corners[36] = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                                         2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
    float                *p           = s->positions;
    uint32_t             *i           = s->indices;
    for (uint32_t n = 0; n < SCENE_BOXES; n++) {
        double angle = 2 * M_PI * n / SCENE_BOXES, from = uniform(r, 3, 7), x = from * cos(angle), z = from * sin(angle);
        double half = uniform(r, 0.3, 1), low = uniform(r, 0, 3), high = low + uniform(r, 0.5, 3);
        for (uint32_t c = 0; c < 8; c++, p += 3) {
            p[0] = (float)(x + (c & 1 ? half : -half));
            p[1] = (float)(c & 2 ? high : low);
            p[2] = (float)(z + (c & 4 ? half : -half));
        }
        for (uint32_t c = 0; c < 36; c++) *i++ = 8 * n + corners[c];
    }
    const float floor_at[12] = {-10, -0.01F, -10, -10, -0.01F, 10, 10, -0.01F, -10, 10, -0.01F, 10};
    memcpy(p, floor_at, sizeof floor_at);
    for (uint32_t c = 0; c < 6; c++) *i++ = 8 * SCENE_BOXES + (uint32_t[]){0, 1, 2, 2, 1, 3}[c];
}

/* file  [out] released with vxs_bake_bytes_free */
static inline void scene_bake_file(const volumes_scene *s, uint32_t resolution, vxs_bake_bytes *file)
{
    vxs_bake_mesh    mesh     = {s->positions, s->indices, 8 * SCENE_BOXES + 4, SCENE_TRIANGLES, {0, 0, 0}, 0};
    vxs_bake_light   lights[] = {{"sun", VXS_BAKE_DIRECTIONAL, {0, 0, 0}, {0.4, -1, 0.3}, 0, 0},
                                 {"spot", VXS_BAKE_SPOT, {-1, 8, 0.5}, {0.1, -1, 0}, 0.764842187284488, 0},
                                 {"point", VXS_BAKE_POINT, {0.5, 2.5, -0.3}, {0, 0, 0}, 0, 15}};
    vxs_bake_arrays  arrays   = {.meshes = &mesh, .mesh_count = 1, .lights = lights, .light_count = SCENE_LIGHTS};
    vxs_bake_options options  = vxs_bake_defaults();
    options.arrays            = &arrays;
    options.resolution        = resolution;
    options.threads           = 1;
    assert_int_equal(vxs_bake(&options, file), VXS_OK);
}

static inline void scene_bake(volumes_scene *s, uint32_t resolution)
{
    vxs_bake_bytes file;
    scene_bake_file(s, resolution, &file);
    assert_int_equal(vxs_asset_open(&s->asset, file.data, file.size_bytes, NULL), VXS_OK);
    vxs_bake_bytes_free(&file);
}

/* Of an asset. Skips the test where there is no OpenGL. */
static inline void scene_open_asset(volumes_scene *s, vxs_asset *asset, uint32_t width_px, uint32_t height_px)
{
    run_context m = {0};
    s->asset      = asset;
    s->width_px   = width_px;
    s->height_px  = height_px;
    if (gl_context_create(&s->gl, gl_choice(), 1, &m) != VXS_OK) {
        print_message("no OpenGL 4.5: %s\n", m.error);
        skip();
    }
    vxs_gl_desc desc = {.get_proc_address = gl_choice_proc, .asset = s->asset};
    assert_int_equal(vxs_gl_create(&s->shadows, &desc), VXS_OK);
    assert_int_equal(vxs_gl_upload(s->shadows, SIZE_MAX), 0);
    vxs_volumes_desc of = {.struct_size      = sizeof of,
                           .get_proc_address = gl_choice_proc,
                           .shadows          = s->shadows,
                           .width_px         = width_px,
                           .height_px        = height_px,
                           .log              = scene_log,
                           .has_half         = 1};
    assert_int_equal(vxs_volumes_create(&s->volumes, &of), VXS_OK);
    s->gl->CreateTextures(GL_TEXTURE_2D, 1, &s->depths);
    s->gl->TextureStorage2D(s->depths, 1, GL_R32F, (GLsizei)width_px, (GLsizei)height_px);
}

static inline void scene_open(volumes_scene *s, uint32_t resolution, uint32_t width_px, uint32_t height_px)
{
    rng r = {7};
    *s    = (volumes_scene){0};
    scene_boxes(s, &r);
    scene_bake(s, resolution);
    scene_open_asset(s, s->asset, width_px, height_px);
}

static inline void scene_close(volumes_scene *s)
{
    vxs_volumes_destroy(s->volumes);
    vxs_gl_destroy(s->shadows);
    vxs_asset_close(s->asset);
    gl_context_destroy(s->gl);
}

/* Whether a test that may query all lights of all cameras queries a light of a camera. The part: each light and each camera, fog
 * with a top (camera 1) of the sun and of a punctual light, and the point light in view of camera 3. */
static inline int scene_asks(int light, int camera)
{
    static const uint32_t cameras[SCENE_LIGHTS] = {1 << 0 | 1 << 1, 1 << 1 | 1 << 2, 1 << 3 | 1 << 4};
    return (int)(repeats(cameras[light], UINT32_MAX) >> camera & 1);
}

/* The lights as they are requested, each bright enough to be seen. */
/* Test `call` with each struct_size of `given`: none, that of the first version, of this one, of a newer one whose new field is 0
 * or set; and sizes that no version has.   last  the last field of the first version */
#define HOLD_SIZES(type, last, value, call)                                                                                        \
    do {                                                                                                                           \
        struct {                                                                                                                   \
            type     known;                                                                                                        \
            uint64_t newer;                                                                                                        \
        } sized                    = {value, 0};                                                                                   \
        const type  *given         = &sized.known;                                                                                 \
        const size_t first_bytes   = offsetof(type, last) + sizeof given->last;                                                    \
        const size_t known_sizes[] = {0, first_bytes, sizeof(type), sizeof sized}, no_sizes[] = {3, first_bytes - 1, SIZE_MAX};    \
        for (size_t at = 0; at < 4; at++) {                                                                                        \
            sized.known.struct_size = known_sizes[at];                                                                             \
            assert_int_equal(call, VXS_OK);                                                                                        \
        }                                                                                                                          \
        sized.newer = 1;                                                                                                           \
        assert_int_equal(call, VXS_E_ARGUMENT);                                                                                    \
        sized.newer = 0;                                                                                                           \
        for (size_t at = 0; at < 3; at++) {                                                                                        \
            sized.known.struct_size = no_sizes[at];                                                                                \
            assert_int_equal(call, VXS_E_ARGUMENT);                                                                                \
        }                                                                                                                          \
    } while (0)

static inline vxs_volumes_light scene_light(int light)
{
    vxs_volumes_light l = {.baked_number = vxs_baked_number((uint32_t)light), .colour = {3, 2, 1}, .radius_metres = 0.1F};
    if (light != SCENE_SUN) l.colour[0] = l.colour[1] = l.colour[2] = 40;
    return l;
}

static inline volumes_camera camera_at(const double eye[3], const double to[3], double tangent)
{
    volumes_camera c     = {.tangent = tangent};
    const double   up[3] = {0, 1, 0};
    for (int n = 0; n < 3; n++) {
        c.eye[n]     = eye[n];
        c.forward[n] = to[n] - eye[n];
    }
    make_unit(c.forward);
    cross(c.forward, up, c.right);
    make_unit(c.right);
    cross(c.right, c.forward, c.up);
    return c;
}

/* Anywhere among the boxes and about them, high and low, looking anywhere. */
static inline volumes_camera scene_random_camera(rng *r)
{
    double eye[3] = {uniform(r, -9, 9), uniform(r, 0.2, 9), uniform(r, -9, 9)}, to[3];
    for (int n = 0; n < 3; n++) to[n] = eye[n] + uniform(r, -1, 1);
    return camera_at(eye, to, uniform(r, 0.3, 2));
}

/* Direction of the ray through a pixel. */
static inline void camera_ray(const volumes_scene *s, const volumes_camera *c, uint32_t x, uint32_t y, double direction[3])
{
    double across = c->tangent * (2 * (x + 0.5) / s->width_px - 1), up = c->tangent * (2 * (y + 0.5) / s->height_px - 1);
    for (int n = 0; n < 3; n++) direction[n] = c->forward[n] + across * c->right[n] + up * c->up[n];
    make_unit(direction);
}

/* Metres to the first triangle, INFINITY: none.   way  of any length, which metres are then counted in */
static inline double triangles_hit(const float *vertices, const uint32_t *corners, uint32_t count, const double from[3],
                                   const double way[3])
{
    double nearest = INFINITY;
    for (uint32_t t = 0; t < count; t++) {
        double       a[3], b[3], o[3], p[3], q[3];
        const float *v[3];
        for (int k = 0; k < 3; k++) v[k] = vertices + (size_t)3 * corners[3 * t + (uint32_t)k];
        for (int n = 0; n < 3; n++) {
            a[n] = (double)v[1][n] - (double)v[0][n];
            b[n] = (double)v[2][n] - (double)v[0][n];
            o[n] = from[n] - (double)v[0][n];
        }
        cross(way, b, p);
        cross(o, a, q);
        double size = dot(a, p), u = dot(o, p) / size, w = dot(way, q) / size, at = dot(b, q) / size;
        if (u >= 0 && w >= 0 && u + w <= 1 && at > 1e-9 && at < nearest) nearest = at;
    }
    return nearest;
}

static inline double scene_trace(const volumes_scene *s, const double from[3], const double way[3])
{
    return triangles_hit(s->positions, s->indices, SCENE_TRIANGLES, from, way);
}

/* A frame of a camera: depths are NEAR_METRES over the distance along the camera's axis.
 * metres  [out] [height_px * width_px] as a shader has them; rays that meet nothing have far_metres. NULL: none of them does */
static inline vxs_volumes_frame scene_frame(const volumes_scene *s, const volumes_camera *c, const vxs_medium *medium, double top,
                                            double far_metres, double *metres)
{
    vxs_volumes_frame f      = {.anisotropy    = (float)medium->anisotropy,
                                .top_metres    = (float)top,
                                .far_metres    = (float)far_metres,
                                .depth_texture = s->depths,
                                .view          = {s->width_px, s->height_px, {0}, EMPTY_DEPTH, {1, 0}}};
    float            *depths = malloc(sizeof *depths * s->width_px * s->height_px), *m = f.view.point_from_depth;
    assert_non_null(depths);
    for (int n = 0; n < 3; n++) {
        f.scattering[n] = (float)medium->scattering[n];
        f.extinction[n] = (float)medium->extinction[n];
        f.eye[n]        = (float)c->eye[n];
        m[n]            = (float)(2 * c->tangent * c->right[n] * NEAR_METRES);
        m[4 + n]        = (float)(2 * c->tangent * c->up[n] * NEAR_METRES);
        m[8 + n]        = (float)c->eye[n];
        m[12 + n]       = (float)((c->forward[n] - c->tangent * (c->right[n] + c->up[n])) * NEAR_METRES);
    }
    m[11] = 1;
    for (uint32_t y = 0; y < s->height_px; y++)
        for (uint32_t x = 0; x < s->width_px; x++) {
            double direction[3];
            size_t at = (size_t)y * s->width_px + x;
            camera_ray(s, c, x, y, direction);
            double met = metres ? scene_trace(s, c->eye, direction) : INFINITY;
            depths[at] = met < INFINITY ? (float)(NEAR_METRES / (met * dot(direction, c->forward))) : EMPTY_DEPTH;
            if (metres) metres[at] = met < far_metres ? met : far_metres;
        }
    s->gl->TextureSubImage2D(s->depths, 0, 0, 0, (GLsizei)s->width_px, (GLsizei)s->height_px, GL_RED, GL_FLOAT, depths);
    free(depths);
    return f;
}

/* What a shader takes a scene's light for, in double. */
static inline vxs_air_light scene_air_light(const volumes_scene *s, const vxs_volumes_light *light)
{
    const vxs_light *l   = &vxs_asset_light(s->asset, light->baked_number - 1)->light;
    vxs_air_light    air = {.kind          = l->kind,
                            .cos_inner     = fmax((double)light->cos_inner, l->cos_outer),
                            .cos_outer     = l->cos_outer,
                            .radius_metres = (double)light->radius_metres,
                            .range_metres  = l->range_metres};
    for (int n = 0; n < 3; n++) {
        const double *m = l->ls_from_ws;
        air.place[n]    = -m[n] * m[3] - m[4 + n] * m[7] - m[8 + n] * m[11]; /* of a punctual light: where light space begins */
        if (l->kind == VXS_LIGHT_KIND_DIRECTIONAL) air.place[n] = -l->direction_ws[n];
        air.axis[n] = l->direction_ws[n];
    }
    return air;
}

/* Airlight along a ray by exact lit intervals of the asset.   sum  [in, out] */
static inline void scene_airlight(const volumes_scene *s, const vxs_volumes_light *light, const vxs_medium *medium, double top,
                                  const double eye[3], const double direction[3], double metres, double sum[3])
{
    enum { SOME = 64 };
    const vxs_baked_light *baked = vxs_asset_light(s->asset, light->baked_number - 1);
    vxs_air_light          air   = scene_air_light(s, light);
    double                 in_fog[2], lit[3];
    vxs_air_path           path = vxs_air_path_of(&air, eye, direction, metres, top, in_fog);
    vxs_ray                ray  = {.t_begin = path.begin, .t_end = fmax(path.begin, path.end)};
    vxs_lit_walk           walk;
    vxs_interval           found[SOME];
    size_t                 count = SOME;
    memcpy(ray.origin_ws, eye, sizeof ray.origin_ws);
    memcpy(ray.direction_ws, direction, sizeof ray.direction_ws);
    assert_int_equal(vxs_lit_begin(&walk, baked, &ray), VXS_OK);
    while (count == SOME) {
        count = vxs_lit_next(&walk, found, SOME);
        for (size_t n = 0; n < count; n++) {
            int outside_is_lit = air.kind == VXS_LIGHT_KIND_DIRECTIONAL;
            if (found[n].state == VXS_INTERVAL_SHADOW || (found[n].state == VXS_INTERVAL_OUTSIDE && !outside_is_lit)) continue;
            vxs_air_lit(medium, &path, found[n].t_begin, found[n].t_end, lit);
            for (int i = 0; i < 3; i++) sum[i] += (double)light->colour[i] * lit[i];
        }
    }
}

/* Every call of a map of transmittance curves, with lists and without, in the frame that has begun. */
static inline void scene_smoke_map(const volumes_scene *s, int light)
{
    const vxs_capsule  one     = {{0, 1, 0}, 1, {0, 2, 0}, 1};
    const vxs_capsules smoke   = {.list = &one, .count = 1};
    vxs_volumes_light  shining = scene_light(light);
    GLuint             texture, buffers[2];
    s->gl->GenBuffers(2, buffers);
    for (int n = 0; n < 2; n++) {
        s->gl->BindBuffer(GL_COPY_WRITE_BUFFER, buffers[n]);
        s->gl->BufferData(GL_COPY_WRITE_BUFFER, 4 * sizeof(float), NULL, GL_STATIC_DRAW);
    }
    s->gl->CreateTextures(GL_TEXTURE_2D, 1, &texture);
    s->gl->TextureStorage2D(texture, 1, GL_R32F, (GLsizei)s->width_px, (GLsizei)s->height_px);
    for (uint32_t segments = 0; segments < 2000; segments += 1000) {
        vxs_transmittance_map *map;
        vxs_transmittance_desc desc = {
            .baked_number = vxs_baked_number((uint32_t)light), .side_px = 16, .capsules = 1, .segments = segments};
        assert_int_equal(vxs_transmittance_map_create(&map, s->volumes, &desc), VXS_OK);
        assert_int_equal(vxs_transmittance_map_build(map, &smoke, NULL), VXS_OK);
        assert_int_equal(vxs_volumes_transmittance(s->volumes, map, texture, VXS_CURVE_LINES), VXS_OK);
        assert_int_equal(vxs_volumes_transmittance_at(s->volumes, map, buffers[0], 1, buffers[1], 0, VXS_CURVE_LINES), VXS_OK);
        shining.smoke = map;
        assert_int_equal(vxs_volumes_march(s->volumes, &shining, NULL, 2, VXS_STEPS_EVEN), VXS_OK);
        vxs_transmittance_map_destroy(map);
    }
    s->gl->DeleteBuffers(2, buffers);
}

/* The airlight of the frame.   pixels  [out] [height_px * width_px * 4] */
static inline void scene_read(const volumes_scene *s, float *pixels)
{
    size_t size = sizeof(float) * 4 * s->width_px * s->height_px;
    s->gl->GetTextureImage(vxs_volumes_airlight(s->volumes), 0, GL_RGBA, GL_FLOAT, (GLsizei)size, pixels);
    assert_int_equal(s->gl->GetError(), GL_NO_ERROR);
}

#endif
