/* Area lights of libvxs_volumes on llvmpipe: one VPL against a plain grid, grids apart from each other, points and filters, what
 * shaders gather against double; error by the number of VPLs, surfaces and light behind walls against exact visibility; the
 * context's state, misuse, and no NaN.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/opengl/gl.h"

#include <math.h>
#include <stdlib.h>

#include "random_light.h"
#include "repeats.h"

/* last: cmocka's macro fail() hides the function of run_context.h, and it needs the four headers above */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "runtime/volumes/area/area_state.h"
#include "volumes_scene.h"

#include "area_scene.h"

enum { GRID_WORDS = 4 * COLUMNS * ROWS };

static void read_grids(uint32_t count, uint32_t *words)
{
    read_buffer(sizeof light->vpls, (size_t)count * GRID_WORDS * sizeof *words, words);
}

/* tests ------------------------------------------------------------------------------------------------------------------------ */

/* One VPL with an exact map is a grid of that size: to all sides, and to one in what of the air is before it. */
static void test_one_vpl_is_a_grid(void **state)
{
    (void)state;
    static double             metres[PIXELS];
    static float              found[4 * PIXELS], wanted[4 * PIXELS];
    vxs_shadow_grid          *grid;
    vxs_shadow_grid_desc      size = {.columns = COLUMNS, .rows = ROWS, .bits = 128};
    vxs_shadow_depth_map     *map;
    vxs_shadow_depth_map_desc desc = {.baked_number = vxs_baked_number(SCENE_POINT)};
    vxs_volumes_light         l    = scene_light(SCENE_POINT);
    const vxs_air_light       air  = scene_air_light(&scene, &l);
    vxs_vpl                   of   = {.colour = {l.colour[0], l.colour[1], l.colour[2]}, .radius_metres = l.radius_metres};
    double                    most = 0, off = 0;
    assert_int_equal(vxs_shadow_grid_create(&grid, scene.volumes, &size), VXS_OK);
    assert_int_equal(vxs_shadow_depth_map_create(&map, scene.volumes, &desc), VXS_OK);
    while (vxs_shadow_depth_map_fill(map, 1 << 20)) continue;
    for (int i = 0; i < 3; i++) of.place[i] = (float)air.place[i];
    const vxs_shadow_depth_map *maps[]    = {map};
    vxs_light_constants         constants = vxs_gl_constants(scene.shadows)[SCENE_POINT];
    constants.range_metres                = 0; /* VPLs of an area have none */
    l.constants                           = &constants;
    for (int camera = 0; camera < CAMERAS; camera++) {
        volumes_camera    c     = camera_at(eyes[camera], look, 0.7);
        vxs_volumes_frame frame = scene_frame(&scene, &c, &haze, camera == 1 ? 2.5 : 1e30, 30, metres);
        assert_int_equal(vxs_area_light_set(light, &of, 1), VXS_OK);
        draw(&frame, &(vxs_area_look){.runs = 12, .is_sharp = 1, .maps = maps}, found);
        assert_int_equal(vxs_volumes_begin(scene.volumes, &frame), VXS_OK);
        assert_int_equal(vxs_volumes_grid(scene.volumes, &l, map, grid, 12), VXS_OK);
        scene_read(&scene, wanted);
        for (int n = 0; n < 4 * PIXELS; n++) {
            most = fmax(most, (double)wanted[n]);
            off  = fmax(off, fabs((double)found[n] - (double)wanted[n]));
        }
    }
    print_message("one VPL and a plain grid differ by %.1e of the brightest pixel\n", off / most);
    assert_true(most > 0 && off < 1e-5 * most);
    vxs_shadow_depth_map_destroy(map);
    vxs_shadow_grid_destroy(grid);
}

/* VPLs in turn have maps in which every other texel is near, and empty ones: of the empty ones no bit is set, and those of the
 * others are what they are alone. */
static void test_no_bit_leaks(void **state)
{
    (void)state;
    enum { COUNT = 16 };
    static uint32_t   words[2][COUNT * GRID_WORDS];
    static uint32_t   board[SIDE * SIDE], none[SIDE * SIDE];
    static float      pixels[4 * PIXELS];
    static double     metres[PIXELS];
    vxs_vpl           vpls[COUNT];
    volumes_camera    c     = camera_at(eyes[0], look, 0.7);
    vxs_volumes_frame frame = scene_frame(&scene, &c, &haze, 1e30, 30, metres);
    uint32_t          dark  = 0;
    screen_vpls(0, vpls, COUNT);
    assert_int_equal(vxs_area_light_set(light, vpls, COUNT), VXS_OK);
    cast(0, 0);
    for (int n = 0; n < SIDE * SIDE; n++) {
        board[n] = map_word(&light->vpls[0], (n + n / SIDE) % 2 ? 0.5F : 1e30F);
        none[n]  = map_word(&light->vpls[0], 1e30F);
    }
    for (uint32_t all = 0; all < 2; all++) {
        for (uint32_t n = 0; n < COUNT; n++)
            vxs_volumes_put(light->volumes, light->buffer, map_at(n, SIDE), sizeof board, n % 2 || all ? board : none);
        draw(&frame, &(vxs_area_look){0}, pixels);
        read_grids(COUNT, words[all]);
    }
    for (uint32_t n = 0; n < COUNT; n++)
        for (uint32_t k = 0; k < GRID_WORDS; k++) {
            uint32_t word = words[0][n * GRID_WORDS + k];
            if (n % 2 == 0) assert_int_equal(word, 0);
            if (n % 2) assert_int_equal(word, words[1][n * GRID_WORDS + k]);
            dark += vxs_popcount(word);
        }
    assert_true(dark > 10000);
}

/* A point casts a shadow of each VPL, in its map and in no other, and beside it no hole is filled; depths are the point's, as near
 * as 15 bits of a float have them. Other points are at the first VPL, where no map has them. */
static void test_points_stay_in_their_map(void **state)
{
    (void)state;
    enum { COUNT = 9, MANY = 1 << 12 };
    static float          map[SIDE * SIDE];
    static vxs_area_point all[MANY];
    vxs_vpl               vpls[COUNT];
    vxs_area_point        one = {{0.3F, 1, 0.5F}, 0.1F};
    GLuint                buffer;
    screen_vpls(0, vpls, COUNT);
    assert_int_equal(vxs_area_light_set(light, vpls, COUNT), VXS_OK);
    for (uint32_t n = 0; n < MANY; n++) memcpy(all[n].place, vpls[0].place, sizeof all[n].place);
    all[MANY - 1] = one;
    scene.gl->GenBuffers(1, &buffer);
    scene.gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, buffer);
    scene.gl->BufferData(GL_SHADER_STORAGE_BUFFER, sizeof all, all, GL_STATIC_DRAW);
    for (uint32_t is_whole = 0; is_whole < 2; is_whole++) {
        assert_int_equal(vxs_area_light_cast(light, &(vxs_area_casters){buffer, MANY, is_whole}), VXS_OK);
        for (uint32_t n = 0; n < COUNT; n++) {
            uint32_t texels = 0;
            double   way[3], metres = 0;
            for (int i = 0; i < 3; i++) way[i] = (double)one.place[i] - (double)vpls[n].place[i];
            metres = sqrt(dot(way, way));
            read_map(n, SIDE, map);
            for (int k = 0; k < SIDE * SIDE; k++) {
                texels += map[k] < 1e30F;
                if (map[k] < 1e30F) assert_true(fabs((double)map[k] / metres - 1) < 0x1p-10);
            }
            assert_true(texels >= 1 && texels <= 16);
        }
    }
    scene.gl->DeleteBuffers(1, &buffer);
}

/* How many texels of a VPL's map have a depth, of how many whose middles see a patch of 4 x 4 metres at y = 1; and how far their
 * depths are from its plane, RMS of parts of them. */
static double texels_of_patch(uint32_t number, double *off)
{
    static float    map[SIDE * SIDE];
    const area_vpl *of     = &light->vpls[number];
    double          square = 0, texels = 0, wanted = 0, across[3], normal[3], up[3];
    for (int i = 0; i < 3; i++) {
        across[i] = (double)of->across[i];
        normal[i] = (double)of->normal[i];
    }
    cross(normal, across, up);
    read_map(number, SIDE, map);
    for (int k = 0; k < SIDE * SIDE; k++) {
        double x = (k % SIDE + 0.5) / (SIDE / 2) - 1, y = (k / SIDE + 0.5) / (SIDE / 2) - 1,
               cosine = (1 - x * x - y * y) / (1 + x * x + y * y), way[3];
        for (int i = 0; i < 3; i++) way[i] = (1 + cosine) * (x * across[i] + y * up[i]) + cosine * normal[i];
        double there = (1 - (double)of->place[1]) / way[1];
        int    sees  = cosine > 0 && there > 0 && fabs((double)of->place[0] + there * way[0]) < 2 &&
                   fabs((double)of->place[2] + there * way[2]) < 2;
        wanted += sees;
        if (!(map[k] < 1e30F)) continue;
        texels++;
        square += pow((double)map[k] / there - 1, 2);
    }
    *off = sqrt(square / texels);
    return texels / wanted;
}

/* A map shows all of a patch, and as a plane, from many points as from few, whether there are many VPLs or few. */
static void test_points_are_thinned(void **state)
{
    (void)state;
    static const float    patch[12]  = {-2, 1, -2, 2, 1, -2, 2, 1, 2, -2, 1, 2};
    static const uint32_t corners[6] = {0, 1, 2, 0, 2, 3}, counts[] = {1 << 10, 1 << 14, 1 << 18}, some[] = {1, 64};
    vxs_area_point       *of_patch = malloc((1 << 18) * sizeof *of_patch);
    vxs_vpl               vpls[64];
    GLuint                buffer;
    double                off;
    assert_non_null(of_patch);
    for (int n = 0; n < 6; n++) {
        assert_true(vxs_area_scatter(patch, corners, 2, of_patch, counts[n % 3]) > 0);
        scene.gl->GenBuffers(1, &buffer);
        scene.gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, buffer);
        scene.gl->BufferData(GL_SHADER_STORAGE_BUFFER, (GLsizeiptr)(counts[n % 3] * sizeof *of_patch), of_patch, GL_STATIC_DRAW);
        screen_vpls(0, vpls, some[n / 3]);
        assert_int_equal(vxs_area_light_set(light, vpls, some[n / 3]), VXS_OK);
        assert_int_equal(vxs_area_light_cast(light, &(vxs_area_casters){buffer, counts[n % 3], 0}), VXS_OK);
        double texels = texels_of_patch(some[n / 3] - 1, &off);
        print_message("%u points, %u VPLs: %.3f of the texels, off by %.4f\n", counts[n % 3], some[n / 3], texels, off);
        assert_true(fabs(texels - 1) < 0.08 && off < 1e-3);
        scene.gl->DeleteBuffers(1, &buffer);
    }
    free(of_patch);
}

/* What is the same everywhere stays so, however far away pixels are; and where all are as far away, nine with a ninth each are
 * their mean. */
static void test_filters(void **state)
{
    (void)state;
    static float               gathered[4 * PIXELS], pixels[4 * PIXELS];
    static double              metres[PIXELS];
    rng                        r   = {6};
    PFNGLTEXTURESUBIMAGE3DPROC put = (PFNGLTEXTURESUBIMAGE3DPROC)gl_choice_function("glTextureSubImage3D");
    for (int far = 0; far < 2; far++) {
        volumes_camera    c     = camera_at(eyes[0], look, 0.7);
        vxs_volumes_frame frame = scene_frame(&scene, &c, &haze, 1e30, 30, far ? NULL : metres);
        for (int which = 0; which <= VXS_AREA_QUARTER; which++) {
            uint32_t wide = which == VXS_AREA_QUARTER ? WIDE / 2 : WIDE, high = which == VXS_AREA_QUARTER ? HIGH / 2 : HIGH;
            assert_int_equal(vxs_volumes_begin(scene.volumes, &frame), VXS_OK);
            for (uint32_t n = 0; n < wide * high; n++) {
                uint32_t x = n % wide, y = n / wide;
                for (uint32_t i = 0; i < 3; i++)
                    gathered[4 * n + i] =
                        far && which == VXS_AREA_NINTHS ? (float)(9 * (x % 3 + y % 3 * 3)) : 0.25F * (float)(i + 1);
                gathered[4 * n + 3] =
                    (float)(far ? 30 : metres[which == VXS_AREA_QUARTER ? 2 * y * WIDE + 2 * x : n] * uniform(&r, 0.7, 1.4));
            }
            put(light->gathered, 0, 0, 0, 0, (GLsizei)wide, (GLsizei)high, 1, GL_RGBA, GL_FLOAT, gathered);
            vxs_area_light_show(light, (vxs_area_gather)which, 0, scene.volumes->airlight, 1);
            scene_read(&scene, pixels);
            for (int n = 0; n < PIXELS; n++)
                for (int i = 0; i < 3; i++) {
                    double wanted = far && which == VXS_AREA_NINTHS ? 36 : 0.25 * (i + 1);
                    assert_true(fabs((double)pixels[4 * n + i] / wanted - 1) < 1e-5);
                }
        }
    }
}

/* Airlight as words say, in double. */
static void test_gather(void **state)
{
    (void)state;
    enum { COUNT = 5 };
    static uint32_t words[COUNT * GRID_WORDS];
    static double   metres[PIXELS], wanted[3 * PIXELS];
    static float    pixels[4 * PIXELS];
    area_vpl        heads[COUNT];
    vxs_vpl         vpls[COUNT];
    double          most = 0;
    screen_vpls(0, vpls, COUNT);
    assert_int_equal(vxs_area_light_set(light, vpls, COUNT), VXS_OK);
    cast(POINTS, 0);
    for (int camera = 0; camera < CAMERAS; camera++) {
        volumes_camera    c     = camera_at(eyes[camera], look, 0.7);
        double            top   = camera == 1 ? 2.5 : VXS_AIR_EVERYWHERE;
        vxs_volumes_frame frame = scene_frame(&scene, &c, &haze, top, 30, metres);
        draw(&frame, &(vxs_area_look){0}, pixels);
        read_grids(COUNT, words);
        read_buffer(0, sizeof heads, heads);
        memset(wanted, 0, sizeof wanted);
        for (uint32_t n = 0; n < PIXELS * COUNT; n++) {
            const area_vpl *h     = &heads[n % COUNT];
            vxs_epipolar    space = {.away = (double)h->grid.away};
            vxs_air_light   air   = {.kind = VXS_LIGHT_KIND_POINT, .radius_metres = (double)h->radius_metres};
            double          direction[3], found[3];
            for (int i = 0; i < 3; i++) {
                space.axis[i]  = (double)h->grid.axis[i];
                space.ahead[i] = (double)h->grid.ahead[i];
                space.side[i]  = (double)h->grid.side[i];
                air.place[i]   = (double)h->place[i];
                air.axis[i]    = (double)h->normal[i];
            }
            for (int i = 0; i < 2; i++) {
                space.alpha[i] = (double)h->grid.alpha[i];
                space.theta[i] = (double)h->grid.theta[i];
                space.phi[i]   = (double)h->grid.phi[i];
            }
            vxs_grid_size size = {COLUMNS, ROWS, 128};
            camera_ray(&scene, &c, n / COUNT % WIDE, n / COUNT / WIDE, direction);
            vxs_air_path     path = vxs_area_path(&air, 1, c.eye, direction, metres[n / COUNT], top);
            vxs_epipolar_ray ray  = vxs_epipolar_eye(&space, direction);
            vxs_grid_rows    rows = vxs_grid_rows_about(&space, &size, ray.theta);
            vxs_grid_airlight_of(words + (size_t)(n % COUNT) * GRID_WORDS, &space, &size, &haze, &path, &ray, &rows,
                                 metres[n / COUNT], 8, h->grid.eye_lit, found);
            for (uint32_t i = 0; i < 3; i++) wanted[3 * (n / COUNT) + i] += found[i] * (double)h->colour[i];
        }
        most = fmax(most, relative_rms(pixels, wanted, 1));
    }
    print_message("airlight of shaders against double: RMS %.1e at most\n", most);
    assert_true(most < 1e-3); /* a ray between two columns takes either */
}

/* The reference: what boxes keep from a ray, by their polygons, against places of it, by slabs. */
static void test_exact_shadows(void **state)
{
    (void)state;
    rng      r       = {2};
    uint32_t dark[2] = {0};
    for (int n = 0; n < 20000; n++) {
        double eye[3], from[3], direction[3], at[3], metres = uniform(&r, 0, 15);
        int    is_dark = 0, is_near = 0;
        random_direction(&r, direction);
        for (int i = 0; i < 3; i++) {
            eye[i]  = uniform(&r, -9, 9);
            from[i] = uniform(&r, -9, 9);
            at[i]   = eye[i] + metres * direction[i];
        }
        for (uint32_t box = 0; box <= SCENE_BOXES; box++) {
            const float *low = scene.positions + 24 * (size_t)box, *high = low + (box < SCENE_BOXES ? 21 : 9);
            double       part[2];
            int          some = area_shadow(low, high, from, eye, direction, 15, part);
            is_dark |= some && metres > part[0] && metres < part[1];
            is_near |= some && (fabs(metres - part[0]) < 1e-4 || fabs(metres - part[1]) < 1e-4);
        }
        if (!is_near) assert_int_equal(is_dark, !area_is_free(&scene, from, at));
        dark[is_dark]++;
    }
    assert_true(dark[0] > 2000 && dark[1] > 2000);
}

/* The more VPLs, the less error, to many of them with exact visibility. */
static void test_error_falls(void **state)
{
    (void)state;
    enum { MANY = 4, STEP = 2 };
    static double metres[PIXELS], wanted[3 * PIXELS];
    static float  pixels[4 * PIXELS];
    vxs_vpl       vpls[VXS_VPLS_MAX];
    for (uint32_t camera = 0; camera < repeats(2, CAMERAS); camera++) {
        volumes_camera    c     = camera_at(eyes[camera], look, 0.7);
        vxs_volumes_frame frame = scene_frame(&scene, &c, &haze, 1e30, 30, metres);
        memset(wanted, 0, sizeof wanted);
        for (uint32_t seed = 1; seed <= MANY; seed++) {
            screen_vpls(seed, vpls, VXS_VPLS_MAX);
            for (uint32_t n = 0; n < PIXELS; n++) {
                double direction[3];
                if (n % WIDE % STEP || n / WIDE % STEP) continue;
                camera_ray(&scene, &c, n % WIDE, n / WIDE, direction);
                area_airlight(&scene, vpls, VXS_VPLS_MAX, &haze, c.eye, direction, metres[n], wanted + 3 * (size_t)n);
            }
        }
        for (int n = 0; n < 3 * PIXELS; n++) wanted[n] /= MANY;
        double x = 0, y = 0, xx = 0, xy = 0, first = 0, last = 0;
        int    asked = 0;
        for (uint32_t count = 1; count <= 64; count *= 4, asked++) {
            screen_vpls(0, vpls, count);
            assert_int_equal(vxs_area_light_set(light, vpls, count), VXS_OK);
            cast(POINTS, 0);
            draw(&frame, &(vxs_area_look){0}, pixels);
            double error = relative_rms(pixels, wanted, STEP);
            print_message("%s%.4f of %u", asked ? ", " : "error ", error, count);
            x += log(count);
            y += log(error);
            xx += log(count) * log(count);
            xy += log(count) * log(error);
            first = asked ? first : error;
            last  = error;
        }
        double slope = (asked * xy - x * y) / (asked * xx - x * x);
        print_message(" VPLs: slope %.2f\n", slope);
        assert_true(slope < -0.4 && slope > -1);
        assert_true(last < 0.1 && last < first / 6);
    }
}

/* Light on surfaces against exact visibility of the same VPLs; and the ways to gather less, against gathering all. */
static void test_surfaces_and_less(void **state)
{
    (void)state;
    enum { COUNT = 36, WAYS = VXS_AREA_QUARTER + 1 };
    static double metres[PIXELS], wanted[3 * PIXELS], every[3 * PIXELS];
    static float  normal[4 * PIXELS], pixels[4 * PIXELS];
    const double  low[3] = {0, 1, 0};
    vxs_vpl       vpls[COUNT];
    screen_vpls(0, vpls, COUNT);
    assert_int_equal(vxs_area_light_set(light, vpls, COUNT), VXS_OK);
    cast(POINTS, 0);
    for (int camera = 0; camera < CAMERAS; camera++) {
        volumes_camera    c     = camera_at(eyes[camera], low, 0.25);
        vxs_volumes_frame frame = scene_frame(&scene, &c, &haze, 1e30, 30, metres);
        double            errors[WAYS];
        uint32_t          seen = 0;
        for (uint32_t n = 0; n < PIXELS; n++) {
            double direction[3], place[3];
            camera_ray(&scene, &c, n % WIDE, n / WIDE, direction);
            for (int i = 0; i < 3; i++) place[i] = c.eye[i] + metres[n] * direction[i];
            area_normal(&scene, place, normal + 4 * (size_t)n);
            wanted[3 * n]     = area_irradiance(&scene, vpls, COUNT, haze.extinction[0], place, normal + 4 * (size_t)n);
            wanted[3 * n + 1] = wanted[3 * n + 2] = 0;
            seen += wanted[3 * n] > 0;
        }
        scene.gl->TextureSubImage2D(normals, 0, 0, 0, WIDE, HIGH, GL_RGBA, GL_FLOAT, normal);
        for (int which = 0; which < WAYS; which++) {
            draw(&frame, &(vxs_area_look){.gather = (vxs_area_gather)which, .normal_texture = normals}, pixels);
            for (int n = 0; n < 3 * PIXELS && !which; n++) every[n] = (double)pixels[n / 3 * 4 + n % 3];
            errors[which] = relative_rms(pixels, every, 1);
            scene.gl->GetTextureImage(vxs_area_light_irradiance(light), 0, GL_RGBA, GL_FLOAT, sizeof pixels, pixels);
            for (int n = 0; n < PIXELS; n++) pixels[4 * n + 1] = pixels[4 * n + 2] = 0;
            if (!which) errors[0] = relative_rms(pixels, wanted, 1);
        }
        print_message("surfaces: RMS %.3f of %u; air: a ninth of the VPLs %.3f, a quarter of the pixels %.3f\n", errors[0], seen,
                      errors[1], errors[2]);
        assert_true(seen > 100 && errors[0] < 0.05 && errors[1] < 0.2 && errors[2] < 0.15);
        assert_true(errors[1] > 0 && errors[2] > 0);
    }
}

/* Another view in the same context, with a light of its own. */
static volumes_scene large_view(uint32_t width_px, uint32_t height_px, vxs_area_light **its_light, GLuint *its_normals)
{
    volumes_scene             s     = scene;
    const vxs_area_light_desc small = {.vpls = 16, .side_px = SIDE, .columns = COLUMNS, .rows = ROWS};
    vxs_volumes_desc          desc  = {
                  .get_proc_address = gl_choice_proc, .shadows = s.shadows, .width_px = width_px, .height_px = height_px};
    s.width_px  = width_px;
    s.height_px = height_px;
    assert_int_equal(vxs_volumes_create(&s.volumes, &desc), VXS_OK);
    assert_int_equal(vxs_area_light_create(its_light, s.volumes, &small), VXS_OK);
    s.gl->CreateTextures(GL_TEXTURE_2D, 1, &s.depths);
    s.gl->TextureStorage2D(s.depths, 1, GL_R32F, (GLsizei)width_px, (GLsizei)height_px);
    s.gl->CreateTextures(GL_TEXTURE_2D, 1, its_normals);
    s.gl->TextureStorage2D(*its_normals, 1, GL_RGBA32F, (GLsizei)width_px, (GLsizei)height_px);
    return s;
}

/* Light at places behind a wall, which hides all VPLs from them, of what they would have without it. */
static void test_leaks(void **state)
{
    (void)state;
    enum { COUNT = 16, POINTS_OF_WALL = 20000, PLACES_WIDE = 128, PLACES_HIGH = 80, PLACES = PLACES_WIDE * PLACES_HIGH };
    static const float       wall[12]   = {-4, -4, 1.5F, 4, -4, 1.5F, 4, 4, 1.5F, -4, 4, 1.5F};
    static const uint32_t    corners[6] = {0, 1, 2, 0, 2, 3};
    static const double      eye[3] = {7, 1, 14}, to[3] = {0, 0, 5};
    const vxs_area_rectangle screen = {{-1, -0.5F, 0}, {2, 0, 0}, {0, 1, 0}, {1, 1, 1}, NULL, 0, 0};
    static vxs_area_point    of_wall[POINTS_OF_WALL];
    static float             depths[PLACES], normal[4 * PLACES], found[2][4 * PLACES];
    vxs_area_light          *its;
    vxs_vpl                  vpls[COUNT];
    rng                      r = {3};
    GLuint                   buffer, to_normals;
    double                   leaked = 0;
    uint32_t                 asked = 0, leaks = 0;
    volumes_scene            s = large_view(PLACES_WIDE, PLACES_HIGH, &its, &to_normals);
    assert_int_equal(vxs_area_sample(&screen, VXS_AREA_HALTON, 0, vpls, COUNT), VXS_OK);
    assert_int_equal(vxs_area_light_set(its, vpls, COUNT), VXS_OK);
    assert_true(vxs_area_scatter(wall, corners, 2, of_wall, POINTS_OF_WALL) > 63);
    s.gl->GenBuffers(1, &buffer);
    s.gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, buffer);
    s.gl->BufferData(GL_SHADER_STORAGE_BUFFER, sizeof of_wall, of_wall, GL_STATIC_DRAW);
    volumes_camera    c     = camera_at(eye, to, 0.5);
    vxs_volumes_frame frame = scene_frame(&s, &c, &haze, 1e30, 60, NULL);
    while (asked < repeats(10000, 1000000)) {
        for (uint32_t n = 0; n < PLACES; n++) {
            double direction[3], at[3], metres;
            camera_ray(&s, &c, n % PLACES_WIDE, n / PLACES_WIDE, direction);
            do { /* behind the wall, and in the shadow of each VPL */
                metres = uniform(&r, 1, 16);
                for (int i = 0; i < 3; i++) at[i] = eye[i] + metres * direction[i];
            } while (at[2] < 3 || at[2] > 13 || fabs(at[0]) > 2 * at[2] - 1 || fabs(at[1]) > 2 * at[2] - 1);
            depths[n]         = (float)(NEAR_METRES / (metres * dot(direction, c.forward)));
            normal[4 * n + 2] = -1;
        }
        s.gl->TextureSubImage2D(s.depths, 0, 0, 0, PLACES_WIDE, PLACES_HIGH, GL_RED, GL_FLOAT, depths);
        s.gl->TextureSubImage2D(to_normals, 0, 0, 0, PLACES_WIDE, PLACES_HIGH, GL_RGBA, GL_FLOAT, normal);
        for (uint32_t there = 0; there < 2; there++) {
            assert_int_equal(vxs_area_light_cast(its, &(vxs_area_casters){buffer, there * POINTS_OF_WALL, 0}), VXS_OK);
            assert_int_equal(vxs_volumes_begin(s.volumes, &frame), VXS_OK);
            assert_int_equal(vxs_volumes_area(s.volumes, its, &(vxs_area_look){.normal_texture = to_normals}), VXS_OK);
            s.gl->GetTextureImage(vxs_area_light_irradiance(its), 0, GL_RGBA, GL_FLOAT, sizeof *found, found[there]);
        }
        for (uint32_t n = 0; n < PLACES; n++) {
            assert_true(found[0][4 * n] > 0);
            double part = (double)found[1][4 * n] / (double)found[0][4 * n];
            leaked += part;
            leaks += part > 0.01;
            asked++;
        }
    }
    print_message("%u places behind a wall: %.2f %% of the light, 1 %% of it and more at %u places\n", asked, 100 * leaked / asked,
                  leaks);
    assert_true(leaked < 1e-4 * asked && leaks < asked / 1000);
    vxs_area_light_destroy(its);
    vxs_volumes_destroy(s.volumes);
}

/* Cameras, VPLs, points and media at random: nothing that is drawn is no number, or negative. */
static void test_any_numbers(void **state)
{
    (void)state;
    enum { COUNT = 3 };
    static double metres[PIXELS];
    static float  pixels[2][4 * PIXELS];
    rng           r = {11};
    for (uint32_t n = 0; n < repeats(40, 1000); n++) {
        double     eye[3], to[3], tangent = exp(uniform(&r, -7, 1.5));
        vxs_medium medium = {.anisotropy = uniform(&r, -0.99, 0.99)};
        vxs_vpl    vpls[COUNT];
        for (int i = 0; i < 3; i++) {
            medium.extinction[i] = exp(uniform(&r, log(1e-8), log(1e4)));
            medium.scattering[i] = medium.extinction[i] * uniform(&r, 0, 1);
            eye[i]               = uniform(&r, -12, 12);
            to[i]                = uniform(&r, -5, 5);
        }
        for (int k = 0; k < COUNT; k++) {
            double normal[3];
            random_direction(&r, normal);
            vpls[k] = (vxs_vpl){.radius_metres = (float)exp(uniform(&r, log(1e-4), 0)), .colour = {40, 0, 1}};
            for (int i = 0; i < 3; i++) {
                vpls[k].place[i]  = (float)uniform(&r, -5, 5);
                vpls[k].normal[i] = (float)normal[i];
                if (!rng_below(&r, 3)) vpls[k].normal[i] = (float)(i == (int)n % 3);
            }
            float square = vpls[k].normal[0] * vpls[k].normal[0] + vpls[k].normal[1] * vpls[k].normal[1] +
                           vpls[k].normal[2] * vpls[k].normal[2];
            if (!(fabsf(square - 1) < 1e-4F)) memcpy(vpls[k].normal, (float[3]){0, -1, 0}, sizeof vpls[k].normal);
        }
        for (int i = 0; i < 3; i++) {
            if (n % 5 == 0) to[i] = (double)vpls[0].place[i];                              /* toward a VPL */
            if (n % 5 == 1) to[i] = 2 * eye[i] - (double)vpls[0].place[i];                 /* or away from it */
            if (n % 7 == 2) eye[i] = (double)vpls[1].place[i] + 1e-3 * uniform(&r, -1, 1); /* or in one */
        }
        volumes_camera    c = camera_at(eye, to, tangent);
        vxs_volumes_frame frame =
            scene_frame(&scene, &c, &medium, rng_below(&r, 3) ? 1e30 : uniform(&r, -1, 5), exp(uniform(&r, -5, 12)), metres);
        assert_int_equal(vxs_area_light_set(light, vpls, COUNT), VXS_OK);
        cast(rng_below(&r, 3) ? 2000 : 0, rng_below(&r, 2));
        draw(&frame,
             &(vxs_area_look){.gather         = (vxs_area_gather)rng_below(&r, 3),
                              .runs           = rng_below(&r, 20),
                              .is_sharp       = rng_below(&r, 2),
                              .normal_texture = normals},
             pixels[0]);
        scene.gl->GetTextureImage(vxs_area_light_irradiance(light), 0, GL_RGBA, GL_FLOAT, sizeof *pixels, pixels[1]);
        for (size_t k = 0; k < 8 * PIXELS; k++) {
            float value = pixels[k / (4 * PIXELS)][k % (4 * PIXELS)];
            if (!(isfinite(value) && value >= 0)) fail_msg("frame %u, value %zu: %g", n, k, (double)value);
        }
    }
}

/* Storage buffers and textures are bound as they were. */
static void test_state(void **state)
{
    (void)state;
    static const GLenum asked[]  = {GL_SHADER_STORAGE_BUFFER_BINDING, GL_CURRENT_PROGRAM, GL_ACTIVE_TEXTURE, GL_TEXTURE_BINDING_2D};
    PFNGLGETINTEGERI_VPROC get_i = (PFNGLGETINTEGERI_VPROC)gl_choice_function("glGetIntegeri_v");
    PFNGLGETINTEGERVPROC   get   = (PFNGLGETINTEGERVPROC)gl_choice_function("glGetIntegerv");
    static double          metres[PIXELS];
    static float           pixels[4 * PIXELS];
    GLint                  before[8], after[8];
    vxs_vpl                vpls[4];
    volumes_camera         c     = camera_at(eyes[0], look, 0.7);
    vxs_volumes_frame      frame = scene_frame(&scene, &c, &haze, 1e30, 30, metres);
    screen_vpls(0, vpls, 4);
    assert_int_equal(vxs_area_light_set(light, vpls, 4), VXS_OK);
    light->volumes->api.ActiveTexture(GL_TEXTURE0 + 10); /* where normals are bound */
    scene.gl->BindTextureUnit(10, scene.depths);
    for (GLuint n = 6; n < 8; n++) scene.gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, n, points);
    for (int turn = 0; turn < 2; turn++) {
        GLint *to = turn ? after : before;
        if (turn) {
            cast(100, 1);
            draw(&frame, &(vxs_area_look){.normal_texture = normals}, pixels);
        }
        for (int n = 0; n < 4; n++) get(asked[n], to + n);
        for (GLuint n = 0; n < 2; n++) get_i(GL_SHADER_STORAGE_BUFFER_BINDING, 6 + n, to + 4 + n);
        get_i(GL_IMAGE_BINDING_NAME, 0, to + 6);
        get_i(GL_UNIFORM_BUFFER_BINDING, 0, to + 7);
    }
    assert_memory_equal(before, after, sizeof before);
    assert_int_equal(before[3], scene.depths);
    scene.gl->BindTextureUnit(10, 0);
    light->volumes->api.ActiveTexture(GL_TEXTURE0);
}

static vxs_result make_light(const vxs_area_light_desc *desc)
{
    vxs_area_light *made;
    vxs_result      result = vxs_area_light_create(&made, scene.volumes, desc);
    vxs_area_light_destroy(made);
    return result;
}

static void test_misuse(void **state)
{
    (void)state;
    static double                    metres[PIXELS];
    static const vxs_area_light_desc bad[] = {{.vpls = 257},    {.side_px = 48},  {.side_px = 16},
                                              {.side_px = 512}, {.columns = 257}, {.rows = 257}};
    const vxs_area_light_desc        large = {.side_px = 256, .columns = 256, .rows = 256},
                              small        = {.vpls = 1, .side_px = 32, .columns = 1, .rows = 1};
    vxs_area_light   *other;
    int               storage_bytes;
    vxs_vpl           vpls[2], wrong;
    volumes_camera    c     = camera_at(eyes[0], look, 0.7);
    vxs_volumes_frame frame = scene_frame(&scene, &c, &haze, 1e30, 30, metres);
    for (size_t n = 0; n < sizeof bad / sizeof *bad; n++) {
        assert_int_equal(vxs_area_light_create(&other, scene.volumes, &bad[n]), VXS_E_ARGUMENT);
        assert_null(other);
    }
    scene.volumes->api.GetIntegerv(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &storage_bytes);
    if (storage_bytes < 336 << 20) {
        assert_int_equal(vxs_area_light_create(&other, scene.volumes, &large), VXS_E_GL); /* 336 MiB */
        assert_null(other);
    }
    vxs_area_light_destroy(NULL);
    assert_int_equal(vxs_area_light_create(&other, scene.volumes, &small), VXS_OK);
    screen_vpls(0, vpls, 2);
    assert_int_equal(vxs_volumes_begin(scene.volumes, &frame), VXS_OK);
    assert_int_equal(vxs_volumes_area(scene.volumes, other, &(vxs_area_look){0}), VXS_E_ARGUMENT); /* no VPLs */
    assert_int_equal(vxs_area_light_cast(other, &(vxs_area_casters){0}), VXS_E_ARGUMENT);
    assert_int_equal(vxs_area_light_set(other, vpls, 2), VXS_E_ARGUMENT);
    assert_int_equal(vxs_area_light_set(other, vpls, 0), VXS_E_ARGUMENT);
    for (int n = 0; n < 5; n++) {
        wrong = vpls[0];
        if (n == 0) wrong.place[1] = NAN;
        if (n == 1) wrong.normal[0] = 1;
        if (n == 2) wrong.colour[2] = -1;
        if (n == 3) wrong.radius_metres = 0;
        if (n == 4) wrong.radius_metres = INFINITY;
        assert_int_equal(vxs_area_light_set(other, &wrong, 1), VXS_E_ARGUMENT);
    }
    assert_int_equal(vxs_area_light_set(other, vpls, 1), VXS_OK);
    assert_int_equal(vxs_volumes_area(scene.volumes, other, &(vxs_area_look){0}), VXS_E_ARGUMENT); /* no shadow maps */
    assert_int_equal(vxs_area_light_cast(other, &(vxs_area_casters){.count = 1}), VXS_E_ARGUMENT);
    assert_int_equal(vxs_area_light_cast(other, &(vxs_area_casters){0}), VXS_OK);
    assert_int_equal(vxs_volumes_area(scene.volumes, other, &(vxs_area_look){.runs = 129}), VXS_E_ARGUMENT);
    assert_int_equal(vxs_volumes_area(scene.volumes, other, &(vxs_area_look){.gather = (vxs_area_gather)3}), VXS_E_ARGUMENT);
    assert_int_equal(vxs_volumes_area(scene.volumes, other, &(vxs_area_look){.maps = (const vxs_shadow_depth_map *[1]){NULL}}),
                     VXS_E_ARGUMENT);
    assert_int_equal(vxs_volumes_area(scene.volumes, other, &(vxs_area_look){0}), VXS_OK); /* one column and one row are a grid */
    const vxs_area_look whole = {.runs = 4};
    HOLD_SIZES(vxs_area_light_desc, smoke_nodes, small, make_light(given));
    HOLD_SIZES(vxs_area_look, maps, whole, vxs_volumes_area(scene.volumes, other, given));
    memset(vpls[0].normal, 0, sizeof vpls[0].normal);
    assert_int_equal(vxs_area_light_set(other, vpls, 1), VXS_OK);
    assert_int_equal(vxs_area_light_cast(other, &(vxs_area_casters){0}), VXS_E_ARGUMENT); /* it has no half of all directions */
    vxs_area_light_destroy(other);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_one_vpl_is_a_grid),
        cmocka_unit_test(test_no_bit_leaks),
        cmocka_unit_test(test_points_stay_in_their_map),
        cmocka_unit_test(test_points_are_thinned),
        cmocka_unit_test(test_filters),
        cmocka_unit_test(test_gather),
        cmocka_unit_test(test_exact_shadows),
        cmocka_unit_test(test_error_falls),
        cmocka_unit_test(test_surfaces_and_less),
        cmocka_unit_test(test_leaks),
        cmocka_unit_test(test_any_numbers),
        cmocka_unit_test(test_state),
        cmocka_unit_test(test_misuse),
    };
    return cmocka_run_group_tests(tests, area_set_up, area_tear_down);
}
