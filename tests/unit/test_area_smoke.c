/* Smoke between the VPLs of an area light and what they light, on llvmpipe, against each VPL's own rays through the same capsules
 * in double: surfaces, air, VPLs that are far away; what is not queried again, misuse, and no number that is none.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/opengl/gl.h"

#include <math.h>
#include <stdlib.h>

#include "baker/smoke/smoke_map.h"
#include "random_light.h"
#include "repeats.h"

/* last: cmocka's macro fail() hides the function of run_context.h, and it needs the four headers above */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "runtime/volumes/area/area_state.h"
#include "tests/volumes/smoke_scene.h"
#include "volumes_scene.h"

#include "area_scene.h"

enum { RESOLUTION = 64, CAPSULES = 60, VPLS = 16 };

static vxs_capsule smoke[CAPSULES]; /* puffs and strands below the screen and before it */
static vxs_vpl     vpls[VPLS];
static double      metres[PIXELS];

static vxs_area_light *make_light(const volumes_scene *s, uint32_t side_px, uint32_t capsules)
{
    vxs_area_light           *made;
    const vxs_area_light_desc desc = {.vpls          = VPLS,
                                      .side_px       = 32,
                                      .columns       = COLUMNS,
                                      .rows          = ROWS,
                                      .takes_maps    = !capsules,
                                      .capsules      = capsules,
                                      .smoke_side_px = side_px};
    assert_int_equal(vxs_area_light_create(&made, s->volumes, &desc), VXS_OK);
    return made;
}

static int set_up(void **state)
{
    rng r = {9};
    (void)state;
    scene_open(&scene, RESOLUTION, WIDE, HIGH);
    light = make_light(&scene, 0, CAPSULES);
    scene.gl->CreateTextures(GL_TEXTURE_2D, 1, &normals);
    scene.gl->TextureStorage2D(normals, 1, GL_RGBA32F, WIDE, HIGH);
    screen_vpls(0, vpls, VPLS);
    for (int n = 0; n < CAPSULES; n++) {
        const double low[3] = {-4, 0, -3}, high[3] = {4, 5, 6}, thin = n % 3 ? 1 : 0.1;
        for (int i = 0; i < 3; i++) {
            smoke[n].begin[i] = (float)uniform(&r, low[i], high[i]);
            smoke[n].end[i]   = smoke[n].begin[i] + (n % 3 ? 0 : (float)uniform(&r, -1, 1));
        }
        smoke[n].radius_metres = (float)(thin * uniform(&r, 0.3, 1));
        smoke[n].extinction    = (float)(uniform(&r, 0.2, 1) / thin);
    }
    return 0;
}

/* What capsules leave between a VPL and a place. */
static double left_between(const vxs_vpl *l, const double at[3])
{
    smoke_part parts[CAPSULES];
    double     from[3], way[3];
    for (int i = 0; i < 3; i++) {
        from[i] = l->is_far ? at[i] - 100 * (double)l->normal[i] : (double)l->place[i];
        way[i]  = at[i] - from[i];
    }
    double far = sqrt(dot(way, way));
    make_unit(way);
    return smoke_left(parts, smoke_parts(smoke, CAPSULES, from, way, parts), far);
}

/* A place before each pixel, at random, no farther than so, and a surface there that faces up. */
static vxs_volumes_frame random_places(const volumes_camera *c, double far_metres, double places[PIXELS][3])
{
    static float      depths[PIXELS], normal[4 * PIXELS];
    vxs_volumes_frame frame = scene_frame(&scene, c, &haze, 1e30, 60, NULL);
    rng               r     = {5};
    for (uint32_t n = 0; n < PIXELS; n++) {
        double direction[3];
        camera_ray(&scene, c, n % WIDE, n / WIDE, direction);
        metres[n] = uniform(&r, 0.1 * far_metres, far_metres);
        for (int i = 0; i < 3; i++) places[n][i] = c->eye[i] + metres[n] * direction[i];
        depths[n]         = (float)(NEAR_METRES / (metres[n] * dot(direction, c->forward)));
        normal[4 * n + 1] = 1;
    }
    scene.gl->TextureSubImage2D(scene.depths, 0, 0, 0, WIDE, HIGH, GL_RED, GL_FLOAT, depths);
    scene.gl->TextureSubImage2D(normals, 0, 0, 0, WIDE, HIGH, GL_RGBA, GL_FLOAT, normal);
    return frame;
}

/* Before all smoke, and in it. */
static volumes_camera camera_of(int n)
{
    static const double from[2][3] = {{7, 2, 7}, {-1, 1, 2}}, to[3] = {0, 2, 0};
    return camera_at(from[n], to, 0.6);
}

static void put_smoke(vxs_area_light *its, uint32_t count)
{
    assert_int_equal(vxs_area_light_smoke(its, &(vxs_capsules){.list = smoke, .count = count}), VXS_OK);
}

static void put_vpls(vxs_area_light *its, const vxs_vpl *of, uint32_t count)
{
    assert_int_equal(vxs_area_light_set(its, of, count), VXS_OK);
    assert_int_equal(vxs_area_light_cast(its, &(vxs_area_casters){0}), VXS_OK);
}

/* Air and surfaces. */
static void look_at(vxs_area_light *its, const vxs_volumes_frame *frame, uint32_t runs, float *air, float *surfaces)
{
    assert_int_equal(vxs_volumes_begin(scene.volumes, frame), VXS_OK);
    assert_int_equal(vxs_volumes_area(scene.volumes, its, &(vxs_area_look){.runs = runs, .normal_texture = normals}), VXS_OK);
    scene_read(&scene, air);
    scene.gl->GetTextureImage(vxs_area_light_irradiance(its), 0, GL_RGBA, GL_FLOAT, 4 * PIXELS * sizeof *surfaces, surfaces);
}

/* Irradiance of a VPL at a place that faces up, without smoke: one channel. */
static double shines(const vxs_vpl *l, const double at[3])
{
    double way[3], normal[3];
    for (int i = 0; i < 3; i++) {
        way[i]    = at[i] - (double)l->place[i];
        normal[i] = (double)l->normal[i];
    }
    if (l->is_far) return fmax(-normal[1], 0);
    double square = dot(way, way), cosines = fmax(-way[1], 0) * fmax(dot(way, normal), 0);
    return cosines / (square * square) * exp(-haze.extinction[0] * sqrt(square));
}

/* Of what reaches places without smoke, the part that does with it.   wanted  [out] < 0: nothing does */
static void parts_left(const vxs_vpl *of, uint32_t count, double places[PIXELS][3], double wanted[PIXELS])
{
    for (uint32_t n = 0; n < PIXELS; n++) {
        double all = 0, left = 0;
        for (uint32_t k = 0; k < count; k++) {
            double shone = shines(&of[k], places[n]);
            all += shone;
            if (shone > 0) left += shone * left_between(&of[k], places[n]);
        }
        wanted[n] = all > 0 ? left / all : -1;
    }
}

/* RMS of how far what shaders found is off. */
static double error_of(const float *with, const float *without, const double wanted[PIXELS], uint32_t *count)
{
    double square = 0;
    *count        = 0;
    for (uint32_t n = 0; n < PIXELS; n++) {
        if (wanted[n] < 0 || !(without[4 * n] > 0)) continue;
        square += pow((double)with[4 * n] / (double)without[4 * n] - wanted[n], 2);
        ++*count;
    }
    return sqrt(square / *count);
}

/* tests ------------------------------------------------------------------------------------------------------------------------ */

/* What reaches surfaces: nearer with more texels; and far nearer than what a single VPL in the middle of all would have left. */
static void test_surfaces(void **state)
{
    (void)state;
    static double     places[PIXELS][3], wanted[PIXELS];
    static float      air[4 * PIXELS], found[2][4 * PIXELS];
    double            errors[2], centre = 0;
    uint32_t          count  = 0;
    vxs_area_light   *of[2]  = {make_light(&scene, 32, CAPSULES), light};
    volumes_camera    c      = camera_of(0);
    vxs_volumes_frame frame  = random_places(&c, 16, places);
    vxs_vpl           middle = vpls[0];
    for (int i = 0; i < 3; i++) middle.place[i] = 0;
    for (int n = 0; n < 3 * VPLS; n++) middle.place[n % 3] += vpls[n / 3].place[n % 3] / VPLS;
    parts_left(vpls, VPLS, places, wanted);
    for (uint32_t n = 0; n < 2; n++) {
        put_vpls(of[n], vpls, VPLS);
        for (uint32_t with = 0; with < 2; with++) {
            put_smoke(of[n], with * CAPSULES);
            look_at(of[n], &frame, 0, air, found[with]);
        }
        errors[n] = error_of(found[1], found[0], wanted, &count);
    }
    vxs_area_light_destroy(of[0]);
    for (uint32_t n = 0; n < PIXELS; n++)
        if (wanted[n] >= 0 && found[0][4 * n] > 0) centre += pow(left_between(&middle, places[n]) - wanted[n], 2) / count;
    print_message("surfaces: RMS of what is left %.4f and %.4f with 32 and 64 texels, at %u places; of the middle's %.3f\n",
                  errors[0], errors[1], count, sqrt(centre));
    assert_true(count > 400 && errors[0] < 0.03 && errors[1] < 0.017);
    assert_true(errors[1] < 0.75 * errors[0] && errors[1] < 0.15 * sqrt(centre));
}

/* Airlight of VPLs by many places of each ray, each dimmed by itself, and that without smoke. */
static void airlight(const vxs_vpl *of, uint32_t count, const double eye[3], const double direction[3], double end, double sums[2])
{
    enum { STEPS = 48 };
    sums[0] = sums[1] = 0;
    for (uint32_t k = 0; k < count; k++) {
        vxs_air_light face = {.kind = VXS_LIGHT_KIND_POINT, .radius_metres = (double)of[k].radius_metres};
        for (int i = 0; i < 3; i++) {
            face.place[i] = (double)of[k].place[i];
            face.axis[i]  = (double)of[k].normal[i];
        }
        vxs_air_path path = vxs_area_path(&face, 1, eye, direction, end, VXS_AIR_EVERYWHERE);
        double       step = (path.end - path.begin) / STEPS, air[3], at[3];
        for (int n = 0; n < STEPS && step > 0; n++) {
            double x = path.begin + (n + 0.5) * step;
            for (int i = 0; i < 3; i++) at[i] = eye[i] + x * direction[i];
            vxs_air_at(&haze, &path, x, air);
            sums[0] += (double)of[k].colour[0] * step * air[0];
            sums[1] += (double)of[k].colour[0] * step * air[0] * left_between(&of[k], at);
        }
    }
}

/* Air, looked at from outside the smoke and from in it, of few runs and of many. */
static void test_air(void **state)
{
    (void)state;
    enum { COUNT = 4, EACH = 13 };
    static double places[PIXELS][3];
    static float  found[2][2][4 * PIXELS], surfaces[4 * PIXELS]; /* without and with, by few runs and many */
    put_vpls(light, vpls, COUNT);
    for (int camera = 0; camera < 2; camera++) {
        volumes_camera    c         = camera_of(camera);
        vxs_volumes_frame frame     = random_places(&c, 16, places);
        double            errors[2] = {0}, clear = 0, dimmed = 0, count = 0;
        for (uint32_t n = 0; n < 4; n++) {
            put_smoke(light, n / 2 * CAPSULES);
            look_at(light, &frame, n % 2 ? 32 : 8, found[n / 2][n % 2], surfaces);
        }
        for (uint32_t n = 0; n < PIXELS; n += repeats(EACH, 1)) {
            double direction[3], sums[2];
            camera_ray(&scene, &c, n % WIDE, n / WIDE, direction);
            airlight(vpls, COUNT, c.eye, direction, metres[n], sums);
            if (!(found[0][0][4 * n] > 0)) continue;
            clear += sums[0];
            dimmed += sums[1];
            for (int k = 0; k < 2; k++)
                errors[k] += pow((double)found[1][k][4 * n] / (double)found[0][k][4 * n] - sums[1] / sums[0], 2);
            count++;
        }
        for (int k = 0; k < 2; k++) errors[k] = sqrt(errors[k] / count);
        print_message("air, camera %d: smoke leaves %.2f; RMS of it %.4f with 8 runs, %.4f with 32\n", camera, dimmed / clear,
                      errors[0], errors[1]);
        assert_true(count > 30 && dimmed < 0.8 * clear && errors[0] < 0.02 && errors[1] < 0.015);
    }
}

/* Short rays away from a VPL, of which half a bit of its grid has all: they have steps of their own. */
static void test_away_from_a_vpl(void **state)
{
    (void)state;
    static double places[PIXELS][3];
    static float  found[2][4 * PIXELS], surfaces[4 * PIXELS];
    double        eye[3], to[3], clear = 0, dimmed = 0, most = 0;
    for (int i = 0; i < 3; i++) {
        eye[i] = (double)vpls[0].place[i] + 4 * (double)vpls[0].normal[i];
        to[i]  = (double)vpls[0].place[i] + 9 * (double)vpls[0].normal[i];
    }
    volumes_camera    c     = camera_at(eye, to, 0.002);
    vxs_volumes_frame frame = random_places(&c, 0.5, places);
    put_vpls(light, vpls, 1);
    for (uint32_t with = 0; with < 2; with++) {
        put_smoke(light, with * CAPSULES);
        look_at(light, &frame, 32, found[with], surfaces);
    }
    for (uint32_t n = 0; n < PIXELS; n += 13) {
        double direction[3], sums[2];
        camera_ray(&scene, &c, n % WIDE, n / WIDE, direction);
        airlight(vpls, 1, c.eye, direction, metres[n], sums);
        clear += sums[0];
        dimmed += sums[1];
        most = fmax(most, fabs((double)found[1][4 * n] / (double)found[0][4 * n] - sums[1] / sums[0]));
    }
    print_message("away from a VPL: smoke leaves %.2f, off by %.4f at most\n", dimmed / clear, most);
    assert_true(dimmed < 0.8 * clear && most < 0.04);
}

/* Strands that no ray through the middle of a texel need meet: all places about them are dimmed a little, and none as behind one
 * that is as wide as a texel. */
static void test_thin(void **state)
{
    (void)state;
    static double     places[PIXELS][3];
    static float      air[4 * PIXELS], found[2][4 * PIXELS];
    vxs_capsule       kept[CAPSULES];
    double            most  = 0;
    uint32_t          count = 0, dimmed = 0;
    volumes_camera    c     = camera_of(0);
    vxs_volumes_frame frame = random_places(&c, 16, places);
    memcpy(kept, smoke, sizeof kept);
    for (int n = 0; n < CAPSULES; n++) {
        memcpy(smoke[n].end, smoke[n].begin, sizeof smoke[n].end);
        smoke[n].end[n % 2 ? 0 : 2] += 2;
        smoke[n].radius_metres = 0.004F;
        smoke[n].extinction    = 100;
    }
    put_vpls(light, vpls, 1);
    for (uint32_t with = 0; with < 2; with++) {
        put_smoke(light, with * CAPSULES);
        look_at(light, &frame, 0, air, found[with]);
    }
    memcpy(smoke, kept, sizeof kept);
    for (uint32_t n = 0; n < PIXELS; n++) {
        if (!(found[0][4 * n] > 0)) continue;
        double taken = 1 - (double)found[1][4 * n] / (double)found[0][4 * n];
        most         = fmax(most, taken);
        dimmed += taken > 1e-3;
        count++;
    }
    print_message("strands dim %u of %u places, by %.2f at most\n", dimmed, count, most);
    assert_true(4 * dimmed > count && most < 0.4);
}

/* Of VPLs that are far away, each along its own way; beside the sphere about what casts nothing dims. */
static void test_far_vpls(void **state)
{
    (void)state;
    enum { COUNT = 3 };
    static double     places[PIXELS][3], wanted[PIXELS];
    static float      air[4 * PIXELS], found[2][4 * PIXELS];
    vxs_vpl           far[COUNT];
    volumes_camera    c     = camera_of(0);
    vxs_volumes_frame frame = random_places(&c, 16, places);
    for (int narrow = 0; narrow < 2; narrow++) {
        uint32_t count = narrow ? 1 : COUNT, compared, beside = 0;
        for (uint32_t n = 0; n < count; n++) {
            double normal[3] = {0.4 * n - 0.3, -1, 0.3 * n};
            make_unit(normal);
            far[n] = (vxs_vpl){.place = {0, 2, 1}, .colour = {1, 1, 1}, .radius_metres = narrow ? 2 : 12, .is_far = 1};
            for (int i = 0; i < 3; i++) far[n].normal[i] = (float)normal[i];
        }
        put_vpls(light, far, count);
        parts_left(far, count, places, wanted);
        for (uint32_t with = 0; with < 2; with++) {
            put_smoke(light, with * CAPSULES);
            look_at(light, &frame, 0, air, found[with]);
        }
        for (uint32_t n = 0; n < PIXELS && narrow; n++) {
            double way[3], along[3], across[3];
            for (int i = 0; i < 3; i++) {
                way[i]   = places[n][i] - (double)far->place[i];
                along[i] = (double)far->normal[i];
            }
            cross(way, along, across);
            if (dot(across, across) < 8.1) continue; /* of a square that is 4 m wide */
            assert_true(found[1][4 * n] == found[0][4 * n]);
            beside += wanted[n] < 0.9;
        }
        double error = error_of(found[1], found[0], wanted, &compared);
        if (!narrow) print_message("VPLs far away: RMS %.4f at %u places\n", error, compared);
        assert_true(narrow ? beside > 20 : compared > 700 && error < 0.04);
    }
}

/* The scene's asset with the same smoke baked for its lights. */
static vxs_asset *smoky_asset(void)
{
    const scene_smoke    cloud    = {.count = CAPSULES, .list = smoke};
    const smoke_source   source   = {.capsules = &cloud};
    const smoke_settings settings = {.side_px = RESOLUTION, .nodes = 16, .error = 0.001};
    smoke_counts         counts[SCENE_LIGHTS];
    run_context          m   = {0};
    bake_context         ctx = {.run = &m, .threads = 1};
    vxs_bake_bytes       plain;
    vxs_asset           *asset;
    scene_bake_file(&scene, RESOLUTION, &plain);
    vxs_bytes file = {malloc(plain.size_bytes), plain.size_bytes, plain.size_bytes};
    assert_non_null(file.data);
    memcpy(file.data, plain.data, plain.size_bytes);
    vxs_bake_bytes_free(&plain);
    assert_int_equal(smoke_bake(&file, &source, &settings, SCENE_LIGHTS, counts, &ctx), VXS_OK);
    assert_int_equal(vxs_asset_open(&asset, file.data, file.size_bytes, NULL), VXS_OK);
    free(file.data);
    return asset;
}

/* Mean airlight of the point light: as a VPL with its map, and by a march of many steps. */
static void air_of_point(volumes_scene *s, double means[2])
{
    static float                pixels[4 * PIXELS];
    volumes_camera              c       = camera_of(1);
    vxs_volumes_frame           frame   = scene_frame(s, &c, &haze, 1e30, 8, metres); /* within the light's range */
    vxs_volumes_light           l       = scene_light(SCENE_POINT);
    const vxs_air_light         air     = scene_air_light(s, &l);
    vxs_vpl                     shining = {.colour = {l.colour[0], l.colour[1], l.colour[2]}, .radius_metres = l.radius_metres};
    vxs_area_light             *its     = make_light(s, 0, 0);
    vxs_shadow_depth_map       *map;
    const vxs_shadow_depth_map *maps[1];
    for (int i = 0; i < 3; i++) shining.place[i] = (float)air.place[i];
    assert_int_equal(
        vxs_shadow_depth_map_create(&map, s->volumes, &(vxs_shadow_depth_map_desc){.baked_number = vxs_baked_number(SCENE_POINT)}),
        VXS_OK);
    while (vxs_shadow_depth_map_fill(map, 1 << 20)) continue;
    maps[0] = map;
    assert_int_equal(vxs_area_light_set(its, &shining, 1), VXS_OK);
    for (int march = 0; march < 2; march++) {
        assert_int_equal(vxs_volumes_begin(s->volumes, &frame), VXS_OK);
        if (march) assert_int_equal(vxs_volumes_march(s->volumes, &l, map, 200, VXS_STEPS_EQUIANGULAR), VXS_OK);
        if (!march) assert_int_equal(vxs_volumes_area(s->volumes, its, &(vxs_area_look){.runs = 32, .maps = maps}), VXS_OK);
        scene_read(s, pixels);
        means[march] = 0;
        for (int n = 0; n < PIXELS; n++) means[march] += (double)pixels[4 * n] / PIXELS;
    }
    vxs_shadow_depth_map_destroy(map);
    vxs_area_light_destroy(its);
}

/* A VPL with the map of a baked light is dimmed by that light's baked smoke, as marches are. */
static void test_baked_smoke(void **state)
{
    (void)state;
    double           means[2][2];
    volumes_scene    smoky = scene;
    vxs_gl_desc      words = {.get_proc_address = gl_choice_proc, .asset = smoky.asset = smoky_asset()};
    vxs_volumes_desc desc  = {.get_proc_address = gl_choice_proc, .width_px = WIDE, .height_px = HIGH, .log = scene_log};
    assert_int_equal(vxs_gl_create(&smoky.shadows, &words), VXS_OK);
    assert_int_equal(vxs_gl_upload(smoky.shadows, SIZE_MAX), 0);
    desc.shadows = smoky.shadows;
    assert_int_equal(vxs_volumes_create(&smoky.volumes, &desc), VXS_OK);
    air_of_point(&scene, means[0]);
    air_of_point(&smoky, means[1]);
    vxs_volumes_destroy(smoky.volumes);
    vxs_gl_destroy(smoky.shadows);
    vxs_asset_close(smoky.asset);
    print_message("a baked light's air: as a VPL %.4f, baked smoke leaves %.4f; by marches %.4f, %.4f\n", means[0][0],
                  means[1][0] / means[0][0], means[0][1], means[1][1] / means[0][1]);
    assert_true(fabs(means[0][0] / means[0][1] - 1) < 0.02);
    assert_true(means[1][1] < 0.95 * means[0][1] && fabs(means[1][0] / means[0][0] - means[1][1] / means[0][1]) < 0.01);
}

/* Curves stay where only colours change; where VPLs move, they have to be made again, or left out. Without smoke all is as it would
 * be in a light that takes none. */
static void test_when(void **state)
{
    (void)state;
    enum { COUNT = 4 };
    static double     places[PIXELS][3];
    static float      air[4][4 * PIXELS], surfaces[4][4 * PIXELS];
    vxs_area_light   *plain = make_light(&scene, 0, 0);
    vxs_vpl           moved[COUNT];
    volumes_camera    c     = camera_of(0);
    vxs_volumes_frame frame = random_places(&c, 16, places);
    memcpy(moved, vpls, sizeof moved);
    put_vpls(plain, vpls, COUNT);
    put_vpls(light, vpls, COUNT);
    put_smoke(light, CAPSULES);
    look_at(light, &frame, 0, air[0], surfaces[0]);
    assert_int_equal(vxs_area_light_set(light, moved, COUNT), VXS_OK);
    look_at(light, &frame, 0, air[1], surfaces[1]);
    assert_memory_equal(air[0], air[1], sizeof *air);
    put_smoke(light, 0);
    look_at(light, &frame, 0, air[2], surfaces[2]);
    look_at(plain, &frame, 0, air[3], surfaces[3]);
    assert_memory_equal(air[2], air[3], sizeof *air);
    assert_memory_equal(surfaces[2], surfaces[3], sizeof *surfaces);
    assert_memory_not_equal(air[0], air[2], sizeof *air);
    put_smoke(light, CAPSULES);
    moved[3].place[0] += 0.5F;
    put_vpls(light, moved, COUNT);
    assert_int_equal(vxs_volumes_begin(scene.volumes, &frame), VXS_OK);
    assert_int_equal(vxs_volumes_area(scene.volumes, light, &(vxs_area_look){0}), VXS_E_ARGUMENT); /* curves of where VPLs were */
    put_smoke(light, CAPSULES);
    assert_int_equal(vxs_volumes_area(scene.volumes, light, &(vxs_area_look){0}), VXS_OK);
    vxs_area_light_destroy(plain);
}

/* Storage buffers are bound as they were. */
static void test_state(void **state)
{
    (void)state;
    static double          places[PIXELS][3];
    static float           air[4 * PIXELS], surfaces[4 * PIXELS];
    PFNGLGETINTEGERI_VPROC get   = (PFNGLGETINTEGERI_VPROC)gl_choice_proc("glGetIntegeri_v", NULL);
    volumes_camera         c     = camera_of(0);
    vxs_volumes_frame      frame = random_places(&c, 16, places);
    GLuint                 buffers[3];
    scene.gl->GenBuffers(3, buffers);
    for (GLuint n = 0; n < 3; n++) scene.gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, 5 + n, buffers[n]);
    put_vpls(light, vpls, 2);
    put_smoke(light, CAPSULES);
    look_at(light, &frame, 0, air, surfaces);
    for (GLuint n = 0; n < 3; n++) {
        GLint bound = 0;
        get(GL_SHADER_STORAGE_BUFFER_BINDING, 5 + n, &bound);
        assert_int_equal(bound, buffers[n]);
    }
    scene.gl->DeleteBuffers(3, buffers);
}

static void test_misuse(void **state)
{
    (void)state;
    const vxs_capsules all = {.list = smoke, .count = CAPSULES}, more = {.list = smoke, .count = CAPSULES + 1}, none = {.count = 1};
    static const vxs_area_light_desc bad[] = {
        {.capsules = 1, .smoke_nodes = 5}, {.capsules = 1, .smoke_side_px = 8193}, {.capsules = 1U << 25}};
    vxs_area_light *other = make_light(&scene, 0, 0);
    vxs_vpl         round = vpls[0];
    put_vpls(light, vpls, 1);
    assert_int_equal(vxs_area_light_smoke(light, &more), VXS_E_ARGUMENT);
    assert_int_equal(vxs_area_light_smoke(light, &none), VXS_E_ARGUMENT); /* neither a list nor a buffer */
    put_vpls(other, vpls, 1);
    assert_int_equal(vxs_area_light_smoke(other, &all), VXS_E_ARGUMENT); /* it takes none */
    memset(round.normal, 0, sizeof round.normal);
    assert_int_equal(vxs_area_light_set(light, &round, 1), VXS_OK);
    assert_int_equal(vxs_area_light_smoke(light, &all), VXS_E_ARGUMENT); /* it has no half of all directions */
    vxs_area_light_destroy(other);
    for (size_t n = 0; n < sizeof bad / sizeof *bad; n++) {
        assert_int_equal(vxs_area_light_create(&other, scene.volumes, &bad[n]), VXS_E_ARGUMENT);
        assert_null(other);
    }
    const vxs_area_light_desc large = {.capsules = 1, .smoke_side_px = 8192};
    assert_int_equal(vxs_area_light_create(&other, scene.volumes, &large), VXS_E_GL);
    assert_null(other);
}

/* VPLs in smoke, smoke of any size and place, and what is no capsule: light is dimmed, and is a number. */
static void test_any_numbers(void **state)
{
    (void)state;
    enum { COUNT = 3 };
    static double places[PIXELS][3];
    static float  found[2][2][4 * PIXELS];
    vxs_capsule   kept[CAPSULES];
    rng           r = {12};
    memcpy(kept, smoke, sizeof kept);
    for (uint32_t n = 0; n < repeats(9, 1000); n++) {
        vxs_vpl           some[COUNT];
        volumes_camera    c     = scene_random_camera(&r);
        vxs_volumes_frame frame = random_places(&c, 16, places);
        for (int k = 0; k < COUNT; k++) {
            some[k]        = vpls[rng_below(&r, VPLS)];
            some[k].is_far = rng_below(&r, 2);
        }
        for (int k = 0; k < CAPSULES; k++) {
            for (int i = 0; i < 3; i++) smoke[k].begin[i] = smoke[k].end[i] = (float)uniform(&r, -8, 8);
            if (k % 4 == 0) memcpy(smoke[k].begin, some[0].place, sizeof some->place); /* from a VPL */
            if (k % 4 == 1) smoke[k].end[k % 3] += (float)exp(uniform(&r, -15, 8));
            smoke[k].radius_metres = (float)exp(uniform(&r, -15, k % 8 ? 0 : 8));
            smoke[k].extinction    = (float)exp(uniform(&r, -15, 15));
        }
        smoke[n % CAPSULES].begin[n % 3] = (float[]){NAN, INFINITY, -1e30F, 1e13F}[n % 4];
        smoke[n % 7].radius_metres       = (float[]){NAN, -1, 0, INFINITY}[n % 4];
        smoke[n % 11].extinction         = (float[]){NAN, -1, 0, INFINITY}[(n + 1) % 4];
        put_vpls(light, some, COUNT);
        for (uint32_t with = 0; with < 2; with++) {
            put_smoke(light, with * CAPSULES);
            look_at(light, &frame, 1 + n % 9, found[with][0], found[with][1]);
        }
        for (int k = 0; k < 8 * PIXELS; k++) {
            float clear = found[0][k / (4 * PIXELS)][k % (4 * PIXELS)], dimmed = found[1][k / (4 * PIXELS)][k % (4 * PIXELS)];
            if (!(dimmed >= 0 && dimmed <= clear * 1.0001F))
                fail_msg("frame %u, value %d: %g of %g", n, k, (double)dimmed, (double)clear);
        }
    }
    memcpy(smoke, kept, sizeof kept);
}
int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_surfaces),    cmocka_unit_test(test_air),      cmocka_unit_test(test_away_from_a_vpl),
        cmocka_unit_test(test_thin),        cmocka_unit_test(test_far_vpls), cmocka_unit_test(test_baked_smoke),
        cmocka_unit_test(test_when),        cmocka_unit_test(test_state),    cmocka_unit_test(test_misuse),
        cmocka_unit_test(test_any_numbers),
    };
    return cmocka_run_group_tests(tests, set_up, area_tear_down);
}
