/* Light meshes that shaders choose the quads of, on llvmpipe: against the mesh that C makes of the same map, which is tested by
 * itself, triangle by triangle; against the mesh of all quads; and the count of crossings in each pixel.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/opengl/gl.h"

#include <math.h>
#include <stdlib.h>

#include "random_light.h"
#include "repeats.h"
#include "runtime/volumes/mesh/light_mesh.h"

/* last: cmocka's macro fail() hides the function of run_context.h, and it needs the four headers above */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "mesh_walk.h"
#include "random_maps.h"
#include "volumes_scene.h"

enum { RESOLUTION = 256, WIDE = 32, HIGH = 24, PIXELS = WIDE * HIGH, SIDE_MOST = 64, FAR = 30 };

static const vxs_medium haze = {{0.03, 0.035, 0.04}, {0.04, 0.045, 0.05}, 0.4};

/* maps ------------------------------------------------------------------------------------------------------------------------- */

/* A light of the scene, and a map of it that may hold anything. */
typedef struct own_map {
    vxs_light_constants   constants;
    vxs_volumes_light     light;
    const vxs_light      *baked;
    vxs_shadow_depth_map *map;
    float                *texels;
    uint32_t              side, layers;
} own_map;

static own_map map_make(const volumes_scene *s, int light, uint32_t side)
{
    own_map m = {.constants = vxs_gl_constants(s->shadows)[light], .light = scene_light(light), .side = side};
    m.baked   = &vxs_asset_light(s->asset, (uint32_t)light)->light;
    m.layers  = vxs_map_count(m.baked);
    m.texels  = malloc(sizeof *m.texels * side * side * m.layers);
    assert_non_null(m.texels);
    return m;
}

/* Upload it, as a map of a light that is not baked. */
static void map_upload(own_map *m, const volumes_scene *s)
{
    vxs_shadow_depth_map_desc  desc = {.constants = &m->constants, .side_px = m->side};
    PFNGLTEXTURESUBIMAGE3DPROC put  = (PFNGLTEXTURESUBIMAGE3DPROC)gl_choice_function("glTextureSubImage3D");
    m->light.constants              = &m->constants;
    assert_int_equal(vxs_shadow_depth_map_create(&m->map, s->volumes, &desc), VXS_OK);
    assert_int_equal(vxs_shadow_depth_map_side_px(m->map), m->side);
    put(vxs_shadow_depth_map_texture(m->map), 0, 0, 0, 0, (GLsizei)m->side, (GLsizei)m->side, (GLsizei)m->layers, GL_RED, GL_FLOAT,
        m->texels);
}

/* What is baked of it. */
static void map_fill_baked(own_map *m, const volumes_scene *s)
{
    vxs_shadow_depth_map_desc desc = {.baked_number = m->light.baked_number, .side_px = m->side};
    vxs_shadow_depth_map     *baked;
    assert_int_equal(vxs_shadow_depth_map_create(&baked, s->volumes, &desc), VXS_OK);
    while (vxs_shadow_depth_map_fill(baked, UINT64_MAX)) continue;
    s->gl->GetTextureImage(vxs_shadow_depth_map_texture(baked), 0, GL_RED, GL_FLOAT,
                           (GLsizei)(sizeof *m->texels * m->side * m->side * m->layers), m->texels);
    vxs_shadow_depth_map_destroy(baked);
}

/* Of each layer anything that a field of depths may look like; its last depth is none. */
static void map_fill_random(own_map *m, rng *r)
{
    static float exits[SIDE_MOST * SIDE_MOST];
    float        most = m->constants.kind == VXS_LIGHT_KIND_DIRECTIONAL ? (float)(1U << m->constants.levels) : 20;
    for (uint32_t layer = 0; layer < m->layers; layer++) {
        float     *texels = m->texels + layer * m->side * m->side;
        depth_maps field  = {.side_px = m->side, .depth_vx = 256, .enter = texels, .exit = exits};
        fill_maps(&field, (map_kind)(m->side < 8 ? MAPS_NOISE : rng_below(r, MAP_KINDS)), r);
        for (uint32_t n = 0; n < m->side * m->side; n++) texels[n] = texels[n] < 1 ? texels[n] * most : 1e30F;
    }
}

static void map_free(own_map *m)
{
    vxs_shadow_depth_map_destroy(m->map);
    free(m->texels);
}

/* meshes ----------------------------------------------------------------------------------------------------------------------- */

static vxs_adaptive_mesh *mesh_room(const volumes_scene *s, uint32_t side, uint32_t layers, uint32_t triangles_most)
{
    vxs_adaptive_mesh     *mesh;
    vxs_adaptive_mesh_desc desc = {.side_px = side, .layers = layers, .triangles_most = triangles_most};
    assert_int_equal(vxs_adaptive_mesh_create(&mesh, s->volumes, &desc), VXS_OK);
    return mesh;
}

/* How C makes the mesh that is drawn from an eye: its light ends as far away as the view's does. */
static vxs_light_mesh_desc desc_of(const own_map *m, const double eye[3], double far_metres, float error_texels)
{
    double ls[3];
    vxs_ls_from_ws(m->baked, eye, 1, ls);
    for (int n = 0; n < 3 && m->constants.kind != VXS_LIGHT_KIND_DIRECTIONAL; n++) far_metres += fabs(ls[n]);
    return (vxs_light_mesh_desc){.light        = &m->constants,
                                 .first        = m->texels,
                                 .side_px      = m->side,
                                 .far_metres   = (float)far_metres,
                                 .error_texels = error_texels};
}

/* A triangle by the places of its corners, the least first. */
typedef struct triangle {
    float at[9];
} triangle;

static int by_places(const void *a, const void *b)
{
    const float *p = a, *q = b;
    for (int n = 0; n < 9; n++)
        if (p[n] != q[n]) return p[n] < q[n] ? -1 : 1;
    return 0;
}

static triangle triangle_of(const float *a, const float *b, const float *c)
{
    const float *corners[3] = {a, b, c};
    triangle     turned[3];
    for (int n = 0; n < 3; n++)
        for (int k = 0; k < 9; k++) turned[n].at[k] = corners[(n + k / 3) % 3][k % 3] + 0.0F; /* zeros are alike */
    qsort(turned, 3, sizeof *turned, by_places);
    return turned[0];
}

static triangle *sorted(triangle *list, uint32_t count)
{
    qsort(list, count, sizeof *list, by_places);
    return list;
}

static triangle *triangles_of_lists(const mesh_lists *m)
{
    triangle *list = malloc((size_t)m->size.triangle_count * sizeof *list);
    assert_non_null(list);
    for (uint32_t n = 0; n < m->size.triangle_count; n++) {
        const uint32_t *c = m->corners + 3 * (size_t)n;
        list[n]           = triangle_of(m->places + 3 * c[0], m->places + 3 * c[1], m->places + 3 * c[2]);
    }
    return sorted(list, m->size.triangle_count);
}

/* How many triangles the last mesh has, in room or not. */
static uint32_t triangle_count(const volumes_scene *s, const vxs_adaptive_mesh *mesh)
{
    uint32_t head[8];
    s->gl->GetNamedBufferSubData(vxs_adaptive_mesh_buffer(mesh), 0, sizeof head, head);
    return head[4];
}

/* Those that shaders listed, where the map has them. */
static triangle *triangles_of_shaders(const volumes_scene *s, const own_map *m, const vxs_adaptive_mesh *mesh,
                                      const vxs_mesh_shape *shape, uint32_t count)
{
    triangle *list  = malloc(count * sizeof *list);
    uint32_t *codes = malloc((size_t)3 * count * sizeof *codes);
    assert_true(list && codes);
    s->gl->GetNamedBufferSubData(vxs_adaptive_mesh_buffer(mesh), 32, (GLsizeiptr)(3 * count * sizeof *codes), codes);
    for (uint32_t n = 0; n < count; n++) {
        float at[3][3];
        for (int c = 0; c < 3; c++) {
            vxs_mesh_vertex v = vxs_mesh_vertex_from_code(codes[3 * n + (uint32_t)c]);
            vxs_int3        texel;
            vxs_real3       ls;
            double          depth = 0;
            if (v.layer >= 0) {
                vxs_mesh_texel(shape, v, texel);
                depth = (double)m->texels[((uint32_t)texel[2] * m->side + (uint32_t)texel[1]) * m->side + (uint32_t)texel[0]];
            }
            vxs_mesh_place(shape, v, depth, ls);
            for (int i = 0; i < 3; i++) at[c][i] = (float)ls[i];
        }
        list[n] = triangle_of(at[0], at[1], at[2]);
    }
    free(codes);
    return sorted(list, count);
}

static void draw_adaptive(const volumes_scene *s, const own_map *m, vxs_adaptive_mesh *mesh, const vxs_volumes_frame *f,
                          float error_texels, float *pixels)
{
    assert_int_equal(vxs_volumes_begin(s->volumes, f), VXS_OK);
    assert_int_equal(vxs_volumes_mesh_adaptive(s->volumes, &m->light, m->map, mesh, error_texels), VXS_OK);
    scene_read(s, pixels);
}

static void draw_static(const volumes_scene *s, const own_map *m, const vxs_volumes_frame *f, float *pixels)
{
    assert_int_equal(vxs_volumes_begin(s->volumes, f), VXS_OK);
    assert_int_equal(vxs_volumes_mesh_map(s->volumes, &m->light, m->map), VXS_OK);
    scene_read(s, pixels);
}

/* Relative RMS of a picture, and the largest difference as a part of the brightest. */
static double error_of(const float *pixels, const float *wanted, double *most)
{
    double wrong = 0, size = 0, largest = 0, brightest = 0;
    for (size_t n = 0; n < (size_t)4 * PIXELS; n++) {
        double apart = (double)pixels[n] - (double)wanted[n];
        if (n % 4 == 3) continue;
        wrong += apart * apart;
        size += (double)wanted[n] * (double)wanted[n];
        largest   = fmax(largest, fabs(apart));
        brightest = fmax(brightest, (double)wanted[n]);
    }
    *most = largest / brightest;
    return sqrt(wrong / size);
}

/* tests ------------------------------------------------------------------------------------------------------------------------ */

static const float thresholds[] = {0, 0.03F, 0.37F, 3.1F, 29, 1e9F};
enum { THRESHOLDS = sizeof thresholds / sizeof *thresholds };

/* Shaders list the triangles that C does, whatever the map: of suns, bounded or not, of punctual lights, with a range or not, of
 * maps of one texel and more. */
static void test_triangles(void **state)
{
    (void)state;
    volumes_scene s;
    static float  pixels[4 * PIXELS];
    rng           r   = {1};
    uint64_t      all = 0, sum = 0;
    scene_open(&s, RESOLUTION, WIDE, HIGH);
    vxs_adaptive_mesh *mesh = mesh_room(&s, SIDE_MOST, 6, 0);
    for (uint32_t n = 0; n < repeats(30, 2000); n++) {
        int     light = (int)(n % SCENE_LIGHTS);
        own_map m     = map_make(&s, light, (uint32_t)SIDE_MOST >> rng_below(&r, rng_below(&r, 4) ? 3 : 7));
        if (light == SCENE_SUN && rng_below(&r, 2)) m.constants.flags |= VXS_LIGHT_BOUNDED;
        if (light != SCENE_SUN && rng_below(&r, 2)) m.constants.range_metres = rng_below(&r, 2) ? 0 : 12;
        map_fill_random(&m, &r);
        map_upload(&m, &s);
        volumes_camera      c    = camera_at((const double[3]){1, 2, 3}, (const double[3]){0.5, 2.5, -0.3}, 1);
        vxs_volumes_frame   f    = scene_frame(&s, &c, &haze, VXS_AIR_EVERYWHERE, FAR, NULL);
        float               off  = thresholds[rng_below(&r, THRESHOLDS)];
        vxs_light_mesh_desc desc = desc_of(&m, c.eye, FAR, off);
        mesh_lists          made = mesh_make(&desc);
        draw_adaptive(&s, &m, mesh, &f, off, pixels);
        uint32_t       found = triangle_count(&s, mesh);
        vxs_mesh_shape shape = vxs_light_mesh_shape(&m.constants, m.side, (double)desc.far_metres, NULL);
        if (found != made.size.triangle_count)
            fail_msg("map %u, light %d, %u texels, error %g: %u triangles, not %u", n, light, m.side, (double)off, found,
                     made.size.triangle_count);
        triangle *wanted = triangles_of_lists(&made), *is = triangles_of_shaders(&s, &m, mesh, &shape, found);
        for (uint32_t k = 0; k < found; k++)
            if (by_places(&wanted[k], &is[k])) fail_msg("map %u, light %d: another triangle", n, light);
        all += (uint64_t)vxs_mesh_triangles(&shape);
        sum += found;
        free(wanted);
        free(is);
        mesh_free(&made);
        map_free(&m);
    }
    print_message("%llu of %llu triangles\n", (unsigned long long)sum, (unsigned long long)all);
    assert_true(sum > all / 10 && sum < all - all / 10);
    vxs_adaptive_mesh_destroy(mesh);
    scene_close(&s);
}

/* In every pixel the ray leaves what is lit once more than it enters where the eye is in light, and as often else. */
static void test_counts(void **state)
{
    (void)state;
    volumes_scene s;
    static float  pixels[4 * PIXELS];
    static double metres[PIXELS];
    uint32_t      lit = 0, asked = 0, views = repeats(6, 500);
    rng           r = {2};
    scene_open(&s, RESOLUTION, WIDE, HIGH);
    vxs_adaptive_mesh *mesh = mesh_room(&s, SIDE_MOST, 6, 0);
    for (int light = 0; light < SCENE_LIGHTS; light++) {
        own_map m = map_make(&s, light, SIDE_MOST);
        map_fill_baked(&m, &s);
        map_upload(&m, &s);
        for (uint32_t n = 0; n < views; n++) {
            float               off  = (float)exp(uniform(&r, log(0.1), log(30)));
            volumes_camera      c    = scene_random_camera(&r);
            vxs_volumes_frame   f    = scene_frame(&s, &c, &haze, VXS_AIR_EVERYWHERE, FAR, metres);
            vxs_light_mesh_desc desc = desc_of(&m, c.eye, FAR, off);
            mesh_lists          made = mesh_make(&desc);
            int                 is   = mesh_is_lit(&made, m.baked, c.eye);
            vxs_pixels          seen;
            draw_adaptive(&s, &m, mesh, &f, off, pixels);
            vxs_volumes_cull(s.volumes, &m.light, &seen);
            for (uint32_t k = 0; k < PIXELS; k++) {
                if (k % WIDE - seen.x >= seen.wide_px || k / WIDE - seen.y >= seen.high_px) continue; /* none of its light */
                if (pixels[4 * k + 3] != (float)is)
                    fail_msg("light %d, view %u, error %g, pixel %u: %g", light, n, (double)off, k, (double)pixels[4 * k + 3]);
                asked++;
            }
            lit += (uint32_t)is;
            mesh_free(&made);
        }
        map_free(&m);
    }
    print_message("%u pixels, %u of %u eyes in light\n", asked, lit, views * SCENE_LIGHTS);
    assert_true(asked > PIXELS * views && lit > views / 2 && lit < views * SCENE_LIGHTS - views / 2);
    vxs_adaptive_mesh_destroy(mesh);
    scene_close(&s);
}

/* Without error it is the mesh of all quads; with more, there are fewer triangles, and the picture is farther off. */
static void test_error_rises(void **state)
{
    (void)state;
    static const float allowed[] = {0, 0.5F, 4, 16};
    static float       wanted[4 * PIXELS], pixels[4 * PIXELS];
    static double      metres[PIXELS];
    volumes_scene      s;
    scene_open(&s, RESOLUTION, WIDE, HIGH);
    vxs_adaptive_mesh *mesh = mesh_room(&s, SIDE_MOST, 6, 0);
    for (int light = 0; light < SCENE_LIGHTS; light++) {
        own_map           m         = map_make(&s, light, SIDE_MOST);
        volumes_camera    c         = camera_at((const double[3]){9, 3, 1}, (const double[3]){0, 2, 0}, 0.8);
        vxs_volumes_frame f         = scene_frame(&s, &c, &haze, VXS_AIR_EVERYWHERE, FAR, metres);
        double            last      = 0, most;
        uint32_t          triangles = UINT32_MAX;
        map_fill_baked(&m, &s);
        map_upload(&m, &s);
        draw_static(&s, &m, &f, wanted);
        for (size_t k = 0; k < sizeof allowed / sizeof *allowed; k++) {
            draw_adaptive(&s, &m, mesh, &f, allowed[k], pixels);
            double   error = error_of(pixels, wanted, &most);
            uint32_t count = triangle_count(&s, mesh);
            print_message("light %d, error_texels %g: %u triangles, relative RMS %.1e, at most %.1e of the brightest\n", light,
                          (double)allowed[k], count, error, most);
            if (!k)
                assert_true(most < 1e-5);
            else
                assert_true(count < triangles && error > last - 1e-7); /* less is rounding */
            triangles = count;
            last      = error;
        }
        assert_true(last > 1e-3);
        map_free(&m);
    }
    vxs_adaptive_mesh_destroy(mesh);
    scene_close(&s);
}

/* Where there is no room, all quads are drawn; where there is just enough, those of the list. */
static void test_room(void **state)
{
    (void)state;
    static float  wanted[2][4 * PIXELS], pixels[4 * PIXELS];
    static double metres[PIXELS];
    volumes_scene s;
    scene_open(&s, RESOLUTION, WIDE, HIGH);
    for (int light = 0; light < SCENE_LIGHTS; light++) {
        own_map           m = map_make(&s, light, SIDE_MOST);
        volumes_camera    c = camera_at((const double[3]){9, 3, 1}, (const double[3]){0, 2, 0}, 0.8);
        vxs_volumes_frame f = scene_frame(&s, &c, &haze, VXS_AIR_EVERYWHERE, FAR, metres);
        map_fill_baked(&m, &s);
        map_upload(&m, &s);
        vxs_adaptive_mesh *mesh = mesh_room(&s, SIDE_MOST, m.layers, 0);
        draw_static(&s, &m, &f, wanted[0]);
        draw_adaptive(&s, &m, mesh, &f, 32, wanted[1]);
        uint32_t count = triangle_count(&s, mesh);
        vxs_adaptive_mesh_destroy(mesh);
        for (int lacks = 0; lacks < 2; lacks++) {
            double most;
            mesh = mesh_room(&s, SIDE_MOST, m.layers, count - (uint32_t)lacks);
            draw_adaptive(&s, &m, mesh, &f, 32, pixels);
            assert_int_equal(triangle_count(&s, mesh), count);
            assert_true(error_of(pixels, wanted[!lacks], &most) < 1e-6);
            assert_true(error_of(pixels, wanted[lacks], &most) > 1e-5);
            vxs_adaptive_mesh_destroy(mesh);
        }
        map_free(&m);
    }
    scene_close(&s);
}

/* Numbers, whatever the map, the medium, the view and the error that is allowed. */
static void test_any_numbers(void **state)
{
    (void)state;
    static const float odd[] = {0, -1, 1e38F, -1e38F, INFINITY, -INFINITY, NAN, 1e-38F, 3, 1e30F};
    static float       pixels[4 * PIXELS];
    static double      metres[PIXELS];
    volumes_scene      s;
    rng                r = {3};
    scene_open(&s, RESOLUTION, WIDE, HIGH);
    vxs_adaptive_mesh *mesh = mesh_room(&s, 16, 6, 0);
    for (uint32_t n = 0; n < repeats(36, 3000); n++) {
        own_map    m      = map_make(&s, (int)(n % SCENE_LIGHTS), 16);
        vxs_medium medium = {.anisotropy = uniform(&r, -0.99, 0.99)};
        int        is_odd = !rng_below(&r, 3);
        for (int i = 0; i < 3; i++) {
            medium.extinction[i] = exp(uniform(&r, log(1e-8), log(1e4)));
            medium.scattering[i] = medium.extinction[i] * uniform(&r, 0, 1);
        }
        map_fill_random(&m, &r);
        for (uint32_t k = 0; is_odd && k < m.side * m.side * m.layers; k++) m.texels[k] = odd[rng_below(&r, 10)];
        map_upload(&m, &s);
        volumes_camera    c = scene_random_camera(&r);
        vxs_volumes_frame f = scene_frame(&s, &c, &medium, rng_below(&r, 2) ? VXS_AIR_EVERYWHERE : uniform(&r, -1, 8),
                                          exp(uniform(&r, log(1e-3), log(1e18))), metres);
        draw_adaptive(&s, &m, mesh, &f, rng_below(&r, 4) ? (float)exp(uniform(&r, log(1e-9), log(1e9))) : INFINITY, pixels);
        for (size_t k = 0; k < (size_t)4 * PIXELS; k++)
            if (!isfinite(pixels[k])) fail_msg("map %u, pixel %zu: %g", n, k / 4, (double)pixels[k]);
        map_free(&m);
    }
    vxs_adaptive_mesh_destroy(mesh);
    scene_close(&s);
}

static void test_arguments(void **state)
{
    (void)state;
    static const vxs_adaptive_mesh_desc bad[] = {{0, 0, 1, 0}, {0, 3, 1, 0}, {0, 16384, 1, 0},
                                                 {0, 8, 0, 0}, {0, 8, 5, 0}, {0, 8192, 6, 0}};
    static float                        pixels[4 * PIXELS];
    volumes_scene                       s;
    vxs_adaptive_mesh                  *mesh;
    scene_open(&s, RESOLUTION, WIDE, HIGH);
    for (size_t n = 0; n < sizeof bad / sizeof *bad; n++) {
        assert_int_equal(vxs_adaptive_mesh_create(&mesh, s.volumes, &bad[n]), VXS_E_ARGUMENT);
        assert_null(mesh);
    }
    const vxs_adaptive_mesh_desc large = {
        .side_px = 4096, .layers = 1, .triangles_most = 33000000}; /* 378 MiB, where llvmpipe's storage buffers have 128 */
    int storage_bytes;
    ((PFNGLGETINTEGERVPROC)gl_choice_function("glGetIntegerv"))(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &storage_bytes);
    if (storage_bytes < 378 << 20) {
        assert_int_equal(vxs_adaptive_mesh_create(&mesh, s.volumes, &large), VXS_E_GL);
        assert_null(mesh);
    }
    vxs_adaptive_mesh_destroy(NULL);
    own_map m = map_make(&s, SCENE_POINT, 16);
    map_fill_baked(&m, &s);
    map_upload(&m, &s);
    vxs_adaptive_mesh *few = mesh_room(&s, 16, 1, 0), *small = mesh_room(&s, 8, 6, 0), *good = mesh_room(&s, 32, 6, 0);
    assert_int_equal(vxs_volumes_mesh_adaptive(s.volumes, &m.light, m.map, good, 1), VXS_E_ARGUMENT); /* no frame */
    volumes_camera    c = camera_at((const double[3]){9, 3, 1}, (const double[3]){0, 2, 0}, 0.8);
    vxs_volumes_frame f = scene_frame(&s, &c, &haze, VXS_AIR_EVERYWHERE, FAR, NULL);
    draw_adaptive(&s, &m, good, &f, 1, pixels);
    assert_int_equal(vxs_volumes_mesh_adaptive(s.volumes, &m.light, m.map, few, 1), VXS_E_ARGUMENT);
    assert_int_equal(vxs_volumes_mesh_adaptive(s.volumes, &m.light, m.map, small, 1), VXS_E_ARGUMENT);
    assert_int_equal(vxs_volumes_mesh_adaptive(s.volumes, &m.light, NULL, good, 1), VXS_E_ARGUMENT);
    assert_int_equal(vxs_volumes_mesh_adaptive(s.volumes, &m.light, m.map, NULL, 1), VXS_E_ARGUMENT);
    assert_int_equal(vxs_volumes_mesh_adaptive(s.volumes, &m.light, m.map, good, -1), VXS_E_ARGUMENT);
    assert_int_equal(vxs_volumes_mesh_adaptive(s.volumes, &m.light, m.map, good, NAN), VXS_E_ARGUMENT);
    vxs_adaptive_mesh_destroy(few);
    vxs_adaptive_mesh_destroy(small);
    vxs_adaptive_mesh_destroy(good);
    map_free(&m);
    scene_close(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_triangles), cmocka_unit_test(test_counts),      cmocka_unit_test(test_error_rises),
        cmocka_unit_test(test_room),      cmocka_unit_test(test_any_numbers), cmocka_unit_test(test_arguments),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
