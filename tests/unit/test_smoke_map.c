/* What smoke leaves of lights that are baked: lookups in maps of curves against the integral along the light's rays, before what is
 * opaque and in the light of a sun, a spot and a point light; and the same in shaders.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/opengl/gl.h"

#include <math.h>

#include "baker/smoke/smoke_map.h"
#include "random_light.h"
#include "tests/volumes/smoke_scene.h"

/* last: cmocka's macro fail() hides the function of run_context.h, and it needs the four headers above */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "gl_taps.h"
#include "smoke_sample.h"
#include "volumes_scene.h"

enum { RESOLUTION = 64, SIDE = 32, TILES = SIDE / 8 * SIDE / 8, STEPS = 200 };

/* Over the ground of the scene, and in it. */
static const smoke_balls balls = {
    {{0, 2, 0}, {4, 4, 1}, {-3, 1, -4}, {-1, 6, 0.5}, {0.5, 0, 5}}, {3, 2.5, 2, 1, 2}, {0.35, 0.5, 1, 0.6, 0.9}, 5};
static const uint32_t sizes[3]   = {45, 33, 41};
static const double   axes[3][3] = {{0.4, 0.03, 0}, {-0.02, 0.3, 0}, {0, 0.02, 0.4}}, origin[3] = {-8.5, -1.2, -8};

enum { CAPSULES = 240 };

static volumes_scene s;
static smoke_grid    grid;
static vxs_capsule   capsules[CAPSULES];
static scene_smoke   cloud = {.origin_ws = {0.5, -0.25, 0.125}, .count = CAPSULES, .list = capsules};
static smoke_source  source; /* that tests bake: of grid and cloud, one or both */
static vxs_bytes     plain;  /* the scene's asset without smoke */

/* The scene's asset, with smoke by these settings. */
static vxs_asset *smoky_asset(const smoke_settings *settings, uint32_t threads, smoke_counts counts[SCENE_LIGHTS])
{
    run_context  m    = {0};
    bake_context ctx  = {.run = &m, .threads = threads};
    vxs_bytes    file = {.data = malloc(plain.size_bytes), .size_bytes = plain.size_bytes};
    vxs_asset   *asset;
    assert_non_null(file.data);
    memcpy(file.data, plain.data, plain.size_bytes);
    assert_int_equal(smoke_bake(&file, &source, settings, 3, counts, &ctx), VXS_OK);
    assert_int_equal(vxs_asset_open(&asset, file.data, file.size_bytes, NULL), VXS_OK);
    free(file.data);
    return asset;
}

static int make_scene(void **state)
{
    (void)state;
    rng            r = {7};
    vxs_bake_bytes file;
    scene_boxes(&s, &r);
    scene_bake_file(&s, RESOLUTION, &file);
    plain = (vxs_bytes){malloc(file.size_bytes), file.size_bytes, file.size_bytes};
    if (!plain.data) return 1;
    memcpy(plain.data, file.data, file.size_bytes);
    vxs_bake_bytes_free(&file);
    grid        = sample_grid(&balls, sizes, axes, origin);
    source.grid = &grid;
    smoke_make(SMOKE_COLUMNS, capsules, CAPSULES / 2, 5);
    smoke_make(SMOKE_LEAVES, capsules + CAPSULES / 2, CAPSULES / 2, 5);
    for (int n = CAPSULES / 2; n < CAPSULES; n++) capsules[n].radius_metres *= 4; /* wide enough for few texels to see */
    return 0;
}

static int free_scene(void **state)
{
    (void)state;
    free(plain.data);
    smoke_grid_free(&grid);
    return 0;
}

/* Optical depth along a ray: of the grid by midpoints, of capsules by where bisection finds their ends.   way  of length 1 */
static double thick_along(const double from[3], const double way[3], double metres)
{
    static smoke_part parts[CAPSULES];
    double            sum = 0, at[3];
    for (int k = 0; k < STEPS && source.grid; k++) {
        for (int n = 0; n < 3; n++) at[n] = from[n] + (k + 0.5) / STEPS * metres * way[n];
        sum += sampled(&grid, axes, origin, at) * metres / STEPS;
    }
    for (int n = 0; n < 3; n++) at[n] = from[n] - cloud.origin_ws[n];
    if (source.capsules) sum -= log(smoke_left(parts, smoke_parts(capsules, CAPSULES, at, way, parts), metres));
    return sum;
}

/* Of the light's way to a place: of a punctual light from it on, of a sun from before all smoke. */
static double thick_to(const vxs_light *light, const double ws[3])
{
    double from[3], way[3];
    for (int n = 0; n < 3; n++) {
        from[n] = ws[n] - 30 * light->direction_ws[n];
        if (light->kind == VXS_LIGHT_KIND_DIRECTIONAL) continue;
        from[n] = 0; /* rows of a punctual light's matrix are of length 1 */
        for (int row = 0; row < 3; row++) from[n] -= light->ls_from_ws[4 * row + n] * light->ls_from_ws[4 * row + 3];
    }
    for (int n = 0; n < 3; n++) way[n] = ws[n] - from[n];
    double metres = sqrt(dot(way, way));
    make_unit(way);
    return thick_along(from, way, metres);
}

/* Texels across and down, and voxels, of a place in a map; by names of axes. */
static void map_place(const vxs_light *light, int map, const double ws[3], double at[3])
{
    double ls[3], p[3], side = ldexp(1, (int)light->levels);
    for (int row = 0; row < 3; row++) ls[row] = dot(light->ls_from_ws + 4 * row, ws) + light->ls_from_ws[4 * row + 3];
    memcpy(at, ls, sizeof ls);
    if (light->kind == VXS_LIGHT_KIND_DIRECTIONAL) return;
    const char *names = map_axes[map_count(light) > 1 ? map : 4];
    for (int n = 0; n < 3; n++) p[n] = names[n] < 'a' ? -ls[names[n] - 'X'] : ls[names[n] - 'x'];
    at[0] = side / 2 + p[0] / p[2] / light->texel_metres;
    at[1] = side / 2 + p[1] / p[2] / light->texel_metres;
    at[2] = log(p[2] / light->near_metres) / light->voxel_metres;
}

/* What four texels' rays have left at the depth of a place, weighed: what a lookup would say if curves were exact.   Returns -1:
 * outside */
static double weighed(const vxs_light *light, uint32_t side, const double ws[3])
{
    double  texel = ldexp(1, (int)light->levels) / side, at[3], left = 0;
    int32_t voxel[3];
    int     map = vxs_voxel(light, ws, NULL, vxs_box(1), voxel);
    if (map < 0) return -1;
    map_place(light, map, ws, at);
    double u = at[0] / texel - 0.5, v = at[1] / texel - 0.5;
    for (int n = 0; n < 4; n++) {
        double x = fmin(fmax(floor(u) + (n & 1), 0), side - 1), y = fmin(fmax(floor(v) + (n >> 1), 0), side - 1), there[3];
        double weight = (n & 1 ? u - floor(u) : 1 - u + floor(u)) * (n > 1 ? v - floor(v) : 1 - v + floor(v));
        vxs_point(light, map, (const double[3]){(x + 0.5) * texel, (y + 0.5) * texel, at[2]}, there);
        left += weight * exp(-thick_to(light, there));
    }
    return left;
}

/* Somewhere in the scene where a light comes to. */
static int random_lit_place(rng *r, const vxs_baked_light *baked, double ws[3])
{
    ws[0] = uniform(r, -9, 9);
    ws[1] = uniform(r, 0, 9);
    ws[2] = uniform(r, -9, 9);
    return vxs_lookup(baked, ws, NULL, vxs_box(1)) == 1;
}

static double voxel_of(const vxs_light *light, double metres)
{
    return light->kind == VXS_LIGHT_KIND_DIRECTIONAL ? metres / light->voxel_metres
                                                     : log(metres / light->near_metres) / light->voxel_metres;
}

/* Depths, metres along a map's axis, between which the ray through a place of the map loses light, as far as the light comes.
 * Returns 0: nowhere */
static int depths_with_smoke(const vxs_baked_light *baked, const vxs_baked_smoke *smoke, int map, const double at[2],
                             double depths[2])
{
    enum { DEPTHS = 100 };
    const vxs_light *light = &baked->light;
    double           left[DEPTHS + 1];
    float            units[2];
    int32_t          shadow = vxs_first_shadow(baked, map, (int32_t)at[0], (int32_t)at[1], NULL);
    int              first = 0, last = 0;
    memcpy(units, smoke->words + 1, sizeof units);
    for (int n = 0; n <= DEPTHS; n++) {
        double depth = (double)units[0] + 65535.0 * (double)units[1] * n / DEPTHS,
               voxel = depth > 0 || !light->near_metres ? voxel_of(light, depth) : -1e9, ws[3];
        if (shadow >= 0 && voxel > shadow) break;
        vxs_point(light, map, (const double[3]){at[0], at[1], voxel}, ws);
        left[n] = exp(-thick_to(light, ws));
        if (left[n] > 1 - 1e-9) first = n;
        last = n;
    }
    while (last > first && left[last - 1] < left[last] + 1e-7) last--;
    for (int n = 0; n < 2; n++) depths[n] = (double)units[0] + 65535.0 * (double)units[1] * (n ? last : first) / DEPTHS;
    return last > first;
}

/* What a bake says of lookups between rays, against places of our own: half of them in the smoke, half where it or
 * the light ends. */
static void check_lookups(const smoke_lookups *told, const vxs_baked_light *baked, const vxs_baked_smoke *smoke)
{
    const vxs_light *light = &baked->light;
    double           texel = ldexp(1, (int)light->levels) / SIDE, square = 0, most = 0;
    uint32_t         asked = 0;
    rng              r     = {17};
    for (int tries = 0; asked < repeats(300, 3000) && tries < 400000; tries++) {
        int      map = (int)rng_below(&r, (uint32_t)map_count(light)), x = (int)rng_below(&r, SIDE), y = (int)rng_below(&r, SIDE);
        uint32_t tile         = smoke->words[3 + TILES * map + y / 8 * (SIDE / 8) + x / 8];
        const uint16_t *ends  = (const uint16_t *)(smoke->words + tile) + x % 8 + 8 * (y % 8);
        double          at[3] = {(x + uniform(&r, 0, 1)) * texel, (y + uniform(&r, 0, 1)) * texel}, depths[2], ws[3];
        if (!tile || *ends == (x % 8 + y % 8 ? ends[-1] : 0) || !depths_with_smoke(baked, smoke, map, at, depths)) continue;
        at[2] = voxel_of(light, depths[0] + fmin(uniform(&r, 0, 2), 1) * (depths[1] - depths[0]));
        vxs_point(light, map, at, ws);
        if (vxs_lookup(baked, ws, NULL, vxs_box(1)) != 1) continue;
        double off = fabs((double)vxs_smoke_lookup(light, smoke, ws) - exp(-thick_to(light, ws)));
        square += off * off;
        most = fmax(most, off);
        asked++;
    }
    print_message("  between rays: an RMS of %.4f, %.4f at most at %u places; the bake says %.4f, %.4f at %u\n",
                  sqrt(square / asked), most, asked, told->rms, told->largest, told->places);
    assert_true(asked >= repeats(300, 3000) && told->places > 300);
    double apart = source.capsules ? 1.7 : 1.3; /* few places beside hard edges make most of it */
    assert_true(told->rms > sqrt(square / asked) / apart && told->rms < sqrt(square / asked) * apart && told->largest > most / 1.7);
}

/* rms  that lookups may differ from the ray to the place itself, which lies between those of texels: little in a grid, much beside
 * hard edges */
static void ask_places(double rms)
{
    const smoke_settings settings = {.side_px = SIDE, .nodes = 16, .error = 0.001};
    smoke_counts         counts[SCENE_LIGHTS];
    vxs_asset           *asset = smoky_asset(&settings, 1, counts);
    rng                  r     = {1};
    for (uint32_t light = 0; light < SCENE_LIGHTS; light++) {
        const vxs_baked_light *baked  = vxs_asset_light(asset, light);
        double                 square = 0, most = 0;
        uint32_t               asked = 0, dimmed = 0;
        assert_in_range(counts[light].curves, 50, 6 * SIDE * SIDE);
        for (int n = 0; n < (int)repeats(6000, 200000); n++) {
            double ws[3];
            if (!random_lit_place(&r, baked, ws)) continue;
            double found = (double)vxs_smoke_lookup(&baked->light, vxs_asset_smoke(asset, light), ws);
            if (found > 0.99 ? n % 64 : n % 4) continue; /* most of it would tell nothing new */
            double exact = weighed(&baked->light, SIDE, ws);
            double truth = exp(-thick_to(&baked->light, ws));
            assert_true(fabs(found - exact) < counts[light].largest_error + 0.003); /* and quadrature's */
            square += (found - truth) * (found - truth);
            most = fmax(most, fabs(found - truth));
            dimmed += truth < 0.95;
            asked++;
        }
        print_message("light %u: RMS %.4f, largest %.4f at %u lit places, %u of them in shadow of smoke; curves within %.4f\n",
                      light, sqrt(square / asked), most, asked, dimmed, counts[light].largest_error);
        assert_in_range(dimmed, 60, asked);
        assert_true(counts[light].largest_error < 0.03);
        assert_true(sqrt(square / asked) < rms && most < 8 * rms);
        check_lookups(&counts[light].lookups, baked, vxs_asset_smoke(asset, light));
    }
    vxs_asset_close(asset);
}

static void test_lookups_are_near_the_integral(void **state)
{
    (void)state;
    ask_places(0.04);
}

static void test_capsules_are_met(void **state)
{
    (void)state;
    source = (smoke_source){.capsules = &cloud};
    ask_places(0.4);
    source.grid = &grid;
    ask_places(0.4);
    source.capsules = NULL;
}

/* Along a ray, from the light on, less and less is left. */
static void test_light_falls_along_rays(void **state)
{
    (void)state;
    const smoke_settings settings = {.side_px = SIDE, .nodes = 6, .error = 0.005};
    smoke_counts         counts[SCENE_LIGHTS];
    vxs_asset           *asset = smoky_asset(&settings, 1, counts);
    rng                  r     = {2};
    for (int n = 0; n < 900; n++) {
        uint32_t         number = (uint32_t)n % SCENE_LIGHTS;
        const vxs_light *light  = &vxs_asset_light(asset, number)->light;
        double           side = ldexp(1, (int)light->levels), at[3] = {uniform(&r, 0, side), uniform(&r, 0, side), 0}, before = 1;
        int              map = (int)rng_below(&r, vxs_map_count(light));
        for (at[2] = -0.5; at[2] < side; at[2] += side / 40) {
            double ws[3];
            vxs_point(light, map, at, ws);
            double left = (double)vxs_smoke_lookup(light, vxs_asset_smoke(asset, number), ws);
            if (vxs_voxel(light, ws, NULL, vxs_box(1), (int32_t[3]){0}) != map) continue; /* beyond a cone, or a face of a cube */
            assert_true(left <= before + 1e-6);
            before = left;
        }
    }
    vxs_asset_close(asset);
}

/* A curve ends where light does within a texel about it: nodes lie before that; and without what is opaque there are
 * more of them. */
static void test_what_lies_behind_is_dropped(void **state)
{
    (void)state;
    const smoke_settings settings = {.side_px = SIDE, .nodes = 16, .error = 0.001};
    smoke_counts         counts[SCENE_LIGHTS];
    vxs_asset           *asset = smoky_asset(&settings, 1, counts);
    uint32_t             cut   = 0;
    for (uint32_t number = 0; number < SCENE_LIGHTS; number++) {
        const vxs_baked_light *baked = vxs_asset_light(asset, number);
        const vxs_baked_smoke *smoke = vxs_asset_smoke(asset, number);
        const vxs_light       *light = &baked->light;
        int32_t                texel = RESOLUTION / SIDE, side = 1 << light->levels;
        float                  units[2];
        memcpy(units, smoke->words + 1, sizeof units);
        for (uint32_t n = 0; n < SIDE * SIDE * vxs_map_count(light); n++) {
            uint32_t x = n % SIDE, y = n / SIDE % SIDE, map = n / (SIDE * SIDE),
                     tile        = smoke->words[3 + TILES * map + y / 8 * (SIDE / 8) + x / 8];
            const uint16_t *ends = (const uint16_t *)(smoke->words + tile), *end = ends + x % 8 + 8 * (y % 8);
            uint32_t        count = tile ? *end - (x % 8 + y % 8 ? end[-1] : 0u) : 0;
            int32_t         last  = 0;
            for (int32_t j = (int32_t)y * texel - texel / 2; j < (int32_t)(y + 1) * texel + texel / 2; j++)
                for (int32_t i = (int32_t)x * texel - texel / 2; i < (int32_t)(x + 1) * texel + texel / 2; i++) {
                    int32_t first = vxs_first_shadow(baked, (int)map, i, j, NULL);
                    last          = first < 0 ? side : first > last ? first : last;
                }
            if (!count || last == side) continue;
            double depth = (double)units[0] + (smoke->words[tile + 32 + *end - 1] & 0xffff) * (double)units[1], voxel;
            voxel        = light->kind == VXS_LIGHT_KIND_DIRECTIONAL ? depth / light->voxel_metres
                                                                     : log(depth / light->near_metres) / light->voxel_metres;
            assert_true(voxel < last + 1.05);
            cut += voxel > last + 0.9;
        }
    }
    assert_true(cut >= 20); /* smoke that goes on behind */
    vxs_asset_close(asset);
}

static void test_threads_make_no_difference(void **state)
{
    (void)state;
    const smoke_settings settings = {.side_px = 32, .nodes = 8, .error = 0.005};
    smoke_counts         one[SCENE_LIGHTS], many[SCENE_LIGHTS];
    vxs_asset           *a = smoky_asset(&settings, 1, one), *b = smoky_asset(&settings, 7, many);
    for (uint32_t n = 0; n < SCENE_LIGHTS; n++) {
        const vxs_baked_smoke *x = vxs_asset_smoke(a, n), *y = vxs_asset_smoke(b, n);
        assert_int_equal(x->word_count, y->word_count);
        assert_memory_equal(x->words, y->words, x->word_count * sizeof *x->words);
        assert_true(one[n].largest_error == many[n].largest_error && one[n].memory_bytes == 4 * x->word_count);
        assert_memory_equal(&one[n].lookups, &many[n].lookups, sizeof one[n].lookups);
    }
    vxs_asset_close(a);
    vxs_asset_close(b);
}

/* Smoke that no light meets is in no file; nor is more than the map of a light has texels. */
static void test_what_is_not_needed_is_not_there(void **state)
{
    (void)state;
    const smoke_settings settings  = {.side_px = 1024, .nodes = 8, .error = 0.005};
    const double         beside[3] = {400, 0, 0};
    smoke_grid           was       = grid;
    smoke_counts         counts[SCENE_LIGHTS];
    grid             = sample_grid(&balls, sizes, axes, origin);
    vxs_asset *asset = smoky_asset(&settings, 2, counts);
    for (uint32_t n = 0; n < SCENE_LIGHTS; n++) assert_int_equal(vxs_asset_smoke(asset, n)->side_px, RESOLUTION);
    vxs_asset_close(asset);
    asset = smoky_asset(&(smoke_settings){.nodes = 8, .error = 0.005}, 2,
                        counts); /* samples are 0.3 m apart, and the sun's map is 20 m wide */
    for (uint32_t n = 0; n < SCENE_LIGHTS; n++) assert_int_equal(vxs_asset_smoke(asset, n)->side_px, RESOLUTION);
    vxs_asset_close(asset);
    assert_int_equal(smoke_grid_place(&grid, axes, beside), 1);
    asset = smoky_asset(&settings, 2, counts);
    for (uint32_t n = 0; n < SCENE_LIGHTS; n++) {
        assert_null(vxs_asset_smoke(asset, n));
        assert_int_equal(counts[n].curves, 0);
    }
    vxs_asset_close(asset);
    smoke_grid_free(&grid);
    grid = was;
}

/* As far as a float's place in the light differs, which is a thousandth of a texel of curves here. */
static void test_shaders_answer_as_c_does(void **state)
{
    (void)state;
    const smoke_settings settings = {.side_px = SIDE, .nodes = 8, .error = 0.002};
    smoke_counts         counts[SCENE_LIGHTS];
    vxs_asset           *smoky = smoky_asset(&settings, 1, counts), *without;
    drawing              d     = drawing_make();
    rng                  r     = {3};
    static query         queries[QUERIES];
    static float         answers[QUERIES];
    assert_int_equal(vxs_asset_open(&without, plain.data, plain.size_bytes, NULL), VXS_OK);
    for (int n = 0; n < 4; n++) {
        static const char *const versions[] = {"#version 430 core", "#version 330 core"};
        const vxs_asset         *asset      = n < 2 ? smoky : without;
        vxs_gl_desc desc = {.get_proc_address = gl_choice_proc, .asset = asset, .storage = n & 1 ? VXS_GL_TEXTURE : VXS_GL_BUFFER};
        vxs_gl     *gl;
        uint32_t    dimmed = 0;
        double      most   = 0;
        assert_int_equal(vxs_gl_create(&gl, &desc), VXS_OK);
        while (vxs_gl_upload(gl, 5000)) continue;
        use_body(&d, gl, versions[n & 1], SMOKE_LEFT_BODY);
        for (query *q = queries; q < queries + QUERIES; q++)
            *q = (query){{(float)uniform(&r, -12, 12), (float)uniform(&r, -1, 10), (float)uniform(&r, -12, 12)},
                         {(float)rng_below(&r, 5)}};
        vxs_gl_bind(gl);
        draw(&d, queries, answers);
        for (uint32_t k = 0; k < QUERIES; k++) {
            uint32_t     light = (uint32_t)queries[k].normal[0] < SCENE_LIGHTS ? (uint32_t)queries[k].normal[0] : SCENE_LIGHTS - 1;
            const float *p     = queries[k].position;
            const double ws[3] = {(double)p[0], (double)p[1], (double)p[2]};
            double       in_c  = (double)vxs_smoke_lookup(&vxs_asset_light(asset, light)->light, vxs_asset_smoke(asset, light), ws);
            most               = fmax(most, fabs(in_c - (double)answers[k]));
            dimmed += in_c < 0.9;
        }
        print_message("%s: shaders differ by %.2g at most, %u places in shadow of smoke\n", versions[n & 1], most, dimmed);
        assert_true(most < (n < 2 ? 2e-6 : 1e-30));
        assert_true(n < 2 ? dimmed > 1000 : !dimmed);
        vxs_gl_destroy(gl);
    }
    vxs_asset_close(smoky);
    vxs_asset_close(without);
    if (d.program) d.gl->DeleteProgram(d.program);
    gl_context_destroy(d.gl);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_lookups_are_near_the_integral), cmocka_unit_test(test_capsules_are_met),
        cmocka_unit_test(test_light_falls_along_rays),        cmocka_unit_test(test_what_lies_behind_is_dropped),
        cmocka_unit_test(test_threads_make_no_difference),    cmocka_unit_test(test_what_is_not_needed_is_not_there),
        cmocka_unit_test(test_shaders_answer_as_c_does),
    };
    return cmocka_run_group_tests(tests, make_scene, free_scene);
}
