/* Exact lit intervals on a graphics processor, on llvmpipe, against those in double: whole pictures in fog, and the intervals of
 * any rays in any light, with words that are missing or damaged.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/opengl/gl.h"

#include <math.h>
#include <stdlib.h>

/* last: cmocka's macro fail() hides the function of run_context.h, and it needs the four headers above */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "intervals_rays.h"
#include "query_lights.h"
#include "volumes_scene.h"

/* pictures --------------------------------------------------------------------------------------------------------------------- */

enum { RESOLUTION = 1024, WIDE = 96, HIGH = 80, PIXELS = WIDE * HIGH };

/* Eight metres of the second let nothing through. */
static const vxs_medium haze = {{0.03, 0.035, 0.04}, {0.04, 0.045, 0.05}, 0.4}, murk = {{2, 2.2, 2.5}, {3, 3.2, 3.5}, 0.4};

/* Into the light, from afar, in a shadow, through the light. */
static const double eyes[][3]  = {{9, 3, 1}, {-4, 6, 9}, {0.4, 1.5, 0}, {-8, 0.5, -8}, {0.5, 2.5, 8}};
static const double looks[][3] = {{0, 2, 0}, {0, 1, 0}, {5, 1.6, 2}, {0.5, 2.5, -0.3}, {0.5, 2.5, -0.3}};
enum { CAMERAS = sizeof eyes / sizeof *eyes };

/* How much airlight in double changes where a ray turns by what floats may turn it. */
static double spread(const volumes_scene *s, const vxs_volumes_light *l, const vxs_medium *medium, double top, const double eye[3],
                     const double direction[3], double metres, const double is[3])
{
    double most = 0;
    for (int n = 0; n < 6; n++) {
        double moved[3], there[3] = {0};
        memcpy(moved, direction, sizeof moved);
        moved[n / 2] += n % 2 ? 0x1p-22 : -0x1p-22;
        scene_airlight(s, l, medium, top, eye, moved, metres, there);
        for (int i = 0; i < 3; i++) most = fmax(most, fabs(there[i] - is[i]));
    }
    return most;
}

/* A picture is that of intervals in double, to a part of the brightest pixel. A ray that touches a hard rim may be off by its
 * spread, too. */
static void check_picture(const volumes_scene *s, const vxs_volumes_light *l, const volumes_camera *c,
                          const vxs_volumes_frame *frame, const vxs_medium *medium, const double *metres, double part,
                          const char *what)
{
    static double wanted[3 * PIXELS];
    static float  pixels[4 * PIXELS];
    double        most = 0, error = 0, worst = 0, top = (double)frame->top_metres;
    uint32_t      spreads = 0;
    int           is_spot = vxs_asset_light(s->asset, l->baked_number - 1)->light.kind == VXS_LIGHT_KIND_SPOT;
    memset(wanted, 0, sizeof wanted);
    assert_int_equal(vxs_volumes_begin(s->volumes, frame), VXS_OK);
    assert_int_equal(vxs_volumes_intervals(s->volumes, l), VXS_OK);
    scene_read(s, pixels);
    for (uint32_t pass = 0; pass < 2; pass++) /* the brightest is known behind the first */
        for (uint32_t n = 0; n < PIXELS; n++) {
            double direction[3], *is = wanted + 3 * (size_t)n, off = 0;
            camera_ray(s, c, n % WIDE, n / WIDE, direction);
            if (!pass) scene_airlight(s, l, medium, top, c->eye, direction, metres[n], is);
            for (int i = 0; i < 3; i++) {
                double seen = (double)pixels[4 * n + (uint32_t)i];
                assert_true(isfinite(seen) && seen >= 0);
                most = fmax(most, is[i]);
                off  = fmax(off, fabs(seen - is[i]));
            }
            worst = fmax(worst, off);
            if (pass && is_spot && off > part * most) {
                off -= spread(s, l, medium, top, c->eye, direction, metres[n], is);
                spreads++;
            }
            if (pass) error = fmax(error, off);
        }
    if (getenv("VXS_VERBOSE"))
        print_message("%s: largest error %.2g of the brightest; %u pixels by their spread\n", what, worst / most, spreads);
    assert_in_range(spreads, 0, PIXELS / 1000);
    assert_true(error < part * most);
}

/* Each pixel is that of intervals in double. */
static void test_pictures(void **state)
{
    (void)state;
    volumes_scene s;
    static double metres[PIXELS];
    scene_open(&s, RESOLUTION, WIDE, HIGH);
    for (int light = 0; light < SCENE_LIGHTS; light++)
        for (int camera = 0; camera < CAMERAS; camera++) {
            if (!scene_asks(light, camera)) continue;
            char              what[40];
            volumes_camera    c      = camera_at(eyes[camera], looks[camera], 0.8);
            vxs_volumes_light l      = scene_light(light);
            const vxs_medium *medium = camera == 1 ? &murk : &haze;
            vxs_volumes_frame frame  = scene_frame(&s, &c, medium, camera == 1 ? 2.5 : VXS_AIR_EVERYWHERE, 30, metres);
            snprintf(what, sizeof what, "light %d, camera %d", light, camera);
            check_picture(&s, &l, &c, &frame, medium, metres, 3e-5, what);
        }
    scene_close(&s);
}

/* An eye and where it looks: a sun is looked at from 2 m above a random surface, level; a punctual light from between
 * it and one. */
static volumes_camera random_camera(rng *r, const vxs_baked_light *baked, const vxs_air_light *air)
{
    int32_t depth, i, j, map, side = 1 << baked->light.levels;
    double  eye[3], angle = uniform(r, 0, 7), near = uniform(r, 0.1, 0.9);
    do {
        map   = (int32_t)rng_below(r, vxs_map_count(&baked->light));
        i     = (int32_t)rng_below(r, (uint32_t)side);
        j     = (int32_t)rng_below(r, (uint32_t)side);
        depth = vxs_first_shadow(baked, map, i, j, NULL);
    } while (depth == side || depth == 0);
    vxs_point(&baked->light, map, (double[]){i + 0.5, j + 0.5, depth}, eye);
    if (air->kind == VXS_LIGHT_KIND_DIRECTIONAL)
        eye[1] += 2;
    else
        for (int n = 0; n < 3; n++) eye[n] += near * (air->place[n] - eye[n]);
    return camera_at(eye, (double[]){eye[0] + cos(angle), eye[1], eye[2] + sin(angle)}, 0.6);
}

/* The same of all lights of baked files, whose names VXS_FILES has, separated by colons. */
static void test_files(void **state)
{
    (void)state;
    char         *names = getenv("VXS_FILES") ? strdup(getenv("VXS_FILES")) : NULL, *rest = names;
    static double metres[PIXELS];
    if (!names) skip();
    for (char *name = strtok_r(names, ":", &rest); name; name = strtok_r(NULL, ":", &rest)) {
        volumes_scene s     = {0};
        rng           r     = {5};
        vxs_asset    *asset = NULL;
        assert_int_equal(vxs_asset_open_file(&asset, name, NULL), VXS_OK);
        scene_open_asset(&s, asset, WIDE, HIGH);
        for (uint32_t n = 0; n < 8 * vxs_asset_light_count(asset); n++) {
            vxs_volumes_light l     = scene_light((int)(n / 8));
            vxs_air_light     air   = scene_air_light(&s, &l);
            volumes_camera    c     = random_camera(&r, vxs_asset_light(asset, n / 8), &air);
            vxs_volumes_frame frame = scene_frame(&s, &c, &haze, VXS_AIR_EVERYWHERE, 100, metres);
            vxs_gl_origin(s.shadows, c.eye); /* as far from the world's origin floats do not know where the eye is */
            for (int i = 0; i < 3; i++) frame.eye[i] = frame.view.point_from_depth[8 + i] = 0;
            check_picture(&s, &l, &c, &frame, &haze, metres, 1e-4, name);
        }
        scene_close(&s);
    }
    free(names);
}

/* rays ------------------------------------------------------------------------------------------------------------------------- */

/* Lights of the same words, or of words of their own, one behind the other.   has_tables  1: by their tables */
static void asker_open(asker *a, gl_context *gl, const vxs_baked_light *lights, uint32_t light_count, const size_t *word_counts,
                       int has_tables)
{
    const vxs_baked_light *whole[LIGHTS];
    vxs_gl_light           list[LIGHTS];
    uint32_t               words = 0;
    *a                           = (asker){.gl = gl, .answers = calloc(RAYS, sizeof(answer))};
    for (uint32_t n = 0; n < light_count; n++) {
        list[n]  = (vxs_gl_light){&lights[n].light, words};
        whole[n] = &lights[n];
        words += (uint32_t)word_counts[n] + BLOCKS_SPARE_WORDS;
    }
    vxs_gl_desc desc = {.struct_size      = sizeof desc,
                        .get_proc_address = gl_choice_proc,
                        .lights           = has_tables ? NULL : list,
                        .baked            = has_tables ? whole : NULL,
                        .light_count      = light_count,
                        .word_count       = words,
                        .storage          = VXS_GL_BUFFER};
    assert_int_equal(vxs_gl_create(&a->shadows, &desc), VXS_OK);
    assert_int_equal(vxs_gl_table_bytes(a->shadows) > 0, has_tables);
    for (uint32_t n = 0; n < light_count && !has_tables; n++)
        assert_int_equal(vxs_gl_put(a->shadows, lights[n].words, list[n].first_word, (uint32_t)word_counts[n]), VXS_OK);
    assert_int_equal(vxs_gl_upload(a->shadows, SIZE_MAX), 0);
    asker_compile(a);
}

static void check_lights(rng *r, gl_context *gl, const vxs_baked_light *lights, uint32_t light_count, const size_t *word_counts,
                         int has_tables, const char *what)
{
    asker a;
    asker_open(&a, gl, lights, light_count, word_counts, has_tables);
    check_rays(r, &a, lights, light_count, what);
    asker_close(&a);
}

static void test_blocks(void **state)
{
    (void)state;
    gl_context           *gl       = open_context();
    static const uint32_t levels[] = {3, 5, 8, 10};
    for (size_t n = 0; n < sizeof levels / sizeof *levels; n++) {
        blocks_sample   s;
        rng             r = {170 + n};
        vxs_baked_light lights[LIGHTS];
        size_t          counts[LIGHTS];
        blocks_sample_init(&s, &r, levels[n], levels[n] < 10 ? 6 : 1, 6);
        uint32_t count = s.map_count == 6 ? LIGHTS : 3;
        for (uint32_t kind = 0; kind < count; kind++) {
            lights[kind] = blocks_light(s.words, levels[n], (int)kind);
            counts[kind] = s.word_count;
            if (kind >= 2 && n % 2) lights[kind].light.range_metres = 6.5;
        }
        check_lights(&r, gl, lights, count, counts, 0, "blocks");
        for (uint32_t kind = 0; kind < count; kind++) lights[kind].word_count = (uint32_t)s.word_count;
        check_lights(&r, gl, lights, count, counts, 1, "tables");
        for (uint32_t page = 0; page < s.page_count; page += 2) s.words[8 + page] = 0;
        check_lights(&r, gl, lights, count, counts, 0, "blocks without every other page");
        blocks_sample_free(&s);
    }
    gl_context_destroy(gl);
}

static void test_dags(void **state)
{
    (void)state;
    gl_context *gl = open_context();
    for (uint32_t levels = 3; levels <= 7; levels += 2) {
        dag_sample      s;
        rng             r = {180 + levels};
        vxs_baked_light lights[LIGHTS];
        size_t          counts[LIGHTS];
        dag_sample_init(&s, &r, levels, levels < 5 ? 20 : 200);
        vxs_asset *asset = dag_asset(&s);
        for (uint32_t kind = 0; kind < LIGHTS; kind++) {
            lights[kind] = *vxs_asset_light(asset, kind);
            counts[kind] = lights[kind].word_count;
        }
        check_lights(&r, gl, lights, LIGHTS, counts, 0, "dag");
        vxs_asset_close(asset);
        dag_sample_free(&s);
    }
    gl_context_destroy(gl);
}

/* Suns in whose maps the world's origin lies far from the first texel, and rays of few voxels about it, which floats know to 1e-7
 * of a voxel, but the map's own coordinates to 3e-5. */
static void test_near_origin(void **state)
{
    (void)state;
    gl_context     *gl = open_context();
    blocks_sample   s;
    rng             r = {200};
    asker           a;
    vxs_baked_light suns[2];
    size_t          counts[2];
    double          sum   = 0;
    uint32_t        spans = 0;
    blocks_sample_init(&s, &r, 10, 1, 6);
    for (int kind = 0; kind < 2; kind++) {
        suns[kind]   = blocks_light(s.words, 10, kind);
        counts[kind] = s.word_count;
        for (int row = 0; row < 3; row++) suns[kind].light.ls_from_ws[4 * row + 3] = uniform(&r, 512, 1000);
    }
    asker_open(&a, gl, suns, 2, counts, 0);
    for (uint32_t n = 0; n < RAYS; n++) {
        asked_ray *ray = &a.asked[n];
        *ray           = (asked_ray){.end = 1, .light = n % 2};
        for (int i = 0; i < 3; i++) {
            ray->origin[i]    = (float)uniform(&r, -8, 8);
            ray->direction[i] = (float)uniform(&r, -8, 8);
        }
    }
    ask(&a);
    for (uint32_t n = 0; n < RAYS; n++) {
        check_parts(&a.asked[n], &a.answers[n]);
        sum += difference(&suns[n % 2], &a.asked[n], &a.answers[n]);
        spans += (uint32_t)a.answers[n].count;
    }
    if (getenv("VXS_VERBOSE")) print_message("near the origin: %u spans; differ by %.2g in the mean\n", spans, sum / RAYS);
    assert_in_range(spans, RAYS, UINT32_MAX);
    assert_true(sum < 2e-7 * RAYS);
    asker_close(&a);
    blocks_sample_free(&s);
    gl_context_destroy(gl);
}

/* Words of any kind: some partition of the ray, in little time. */
static void test_damage(void **state)
{
    (void)state;
    gl_context *gl = open_context();
    for (uint32_t turn = 0; turn < repeats(4, 40); turn++) {
        blocks_sample   s;
        rng             r = {190 + turn};
        vxs_baked_light lights[LIGHTS];
        size_t          counts[LIGHTS];
        asker           a;
        blocks_sample_init(&s, &r, 9, 6, 6);
        for (size_t n = 0; n < s.word_count; n += 1 + rng_below(&r, turn % 2 ? 3 : 40)) s.words[n] = rng_u32(&r);
        for (uint32_t kind = 0; kind < LIGHTS; kind++) {
            lights[kind] = blocks_light(s.words, 9, (int)kind);
            counts[kind] = s.word_count;
            if (turn % 4 == 3) lights[kind].light.coding = VXS_CODING_DAG;
        }
        asker_open(&a, gl, lights, LIGHTS, counts, 0);
        random_rays(&r, &a, lights, LIGHTS);
        ask(&a);
        for (uint32_t n = 0; n < RAYS; n++) check_parts(&a.asked[n], &a.answers[n]);
        asker_close(&a);
        blocks_sample_free(&s);
    }
    gl_context_destroy(gl);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_pictures), cmocka_unit_test(test_files),  cmocka_unit_test(test_blocks),
        cmocka_unit_test(test_dags),     cmocka_unit_test(test_damage), cmocka_unit_test(test_near_origin),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
