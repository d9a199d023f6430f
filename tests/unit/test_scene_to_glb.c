/* A written scene is read back unchanged (baker/scene/gltf/glb_write.h).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "baker/files/output_file.h" /* before cmocka, whose fail() is a macro */
#include "baker/scene/gltf/glb_write.h"

#include <cmocka.h>

static const double origin[3];

static scene written_and_read(const scene *s)
{
    char        path[] = "/tmp/test_scene_to_glb-XXXXXX.glb";
    output_file out    = {0};
    run_context m      = {0};
    glb_scene   glb;
    scene       loaded;
    int         file = mkstemps(path, 4);
    assert_true(file >= 0);
    close(file);
    assert_int_equal(glb_from_scene(&glb, s, origin, &m), VXS_OK);
    assert_int_equal(output_file_open(&out, path, &m), VXS_OK);
    assert_int_equal(glb_write(&glb, &out, &m), VXS_OK);
    assert_int_equal(output_file_commit(&out, &m), VXS_OK);
    glb_scene_free(&glb);
    if (scene_load_gltf(&loaded, path, NULL, &m) != VXS_OK) fail_msg("%s", m.error);
    unlink(path);
    run_free(&m);
    return loaded;
}

/* Ten vertices, and triangles of all materials, mixed. */
enum { VERTICES = 10, TRIANGLES = 9, MASKS = 3 };

static const uint8_t double_sided[TRIANGLES] = {0, 1, 1, 0, 0, 1, 0, 0, 1};
static const int     mask_of[TRIANGLES]      = {-1, 2, -1, 0, -1, 0, 1, -1, 2}; /* -1: none */
static double        positions[3 * VERTICES];
static uint32_t      indices[3 * TRIANGLES];
static uint8_t       flags[TRIANGLES];
static uint8_t       alpha[2][6]  = {{0, 255, 128, 127, 1, 254}, {255, 0, 9, 200, 100, 50}};
static alpha_image   images[2]    = {{3, 2, alpha[0]}, {2, 3, alpha[1]}};
static alpha_mask    masks[MASKS] = {
       {0, 0.5f, WRAP_REPEAT, WRAP_REPEAT, 0}, {1, 0.3f, WRAP_CLAMP, WRAP_MIRROR, 0}, {1, 0.7f, WRAP_REPEAT, WRAP_REPEAT, 1}};
static holed_triangle holed_triangles[TRIANGLES];
static scene_light    lights[] = {
       {.name = "a sun", .shape = {LIGHT_DIRECTIONAL, {0}, {0, -0.6, 0.8}, 0, INFINITY}, .colour = {1, 1, 1}},
       {.name   = "a lamp whose name is longer than the names of the meshes that vxs scene makes",
        .shape  = {LIGHT_SPOT, {1e7, 0.1, -3}, {0, 0, 1}, 0.7, 12.5},
        .colour = {20, 5, 0}},
       {.name = "\xc3\xa9", .shape = {LIGHT_POINT, {1, 2, 3}, {0}, 0, INFINITY}, .dark = "its intensity is 0"}};
static double cameras[] = {1, 2.1, 3, -4, 5, 6};

static scene sample_scene(void)
{
    scene s = {.name                = "a scene",
               .vertex_count        = VERTICES,
               .positions_ws        = positions,
               .triangle_count      = TRIANGLES,
               .indices             = indices,
               .triangle_flags      = flags,
               .image_count         = 2,
               .alpha_mask_count    = MASKS,
               .images              = images,
               .alpha_masks         = masks,
               .holed_triangles     = holed_triangles,
               .light_count         = 3,
               .lights              = lights,
               .camera_count        = 2,
               .camera_positions_ws = cameras};
    for (int i = 0; i < 3 * VERTICES; i++) positions[i] = 0.1 * i * i - 7;
    for (uint32_t t = 0; t < TRIANGLES; t++) {
        for (uint32_t i = 0; i < 3; i++) indices[3 * t + i] = (t * 7 + i * 3) % VERTICES;
        flags[t] = double_sided[t] ? TRIANGLE_DOUBLE_SIDED : 0;
        if (mask_of[t] < 0) continue;
        flags[t] |= TRIANGLE_ALPHA_MASK;
        holed_triangle *hole = &holed_triangles[s.holed_triangle_count++];
        *hole                = (holed_triangle){.triangle = t, .mask = (uint32_t)mask_of[t]};
        for (int i = 0; i < 6; i++) hole->uv[i / 2][i % 2] = (float)t + 0.1f * (float)i;
    }
    return s;
}

static const holed_triangle *hole_of(const scene *s, size_t triangle)
{
    for (size_t i = 0; i < s->holed_triangle_count; i++)
        if (s->holed_triangles[i].triangle == triangle) return &s->holed_triangles[i];
    return NULL;
}

/* A triangle of one scene, and one of another. */
static int same_triangle(const scene *a, size_t t, const scene *b, size_t u)
{
    for (size_t i = 0; i < 9; i++) {
        double p = a->positions_ws[3 * (size_t)a->indices[3 * t + i / 3] + i % 3],
               q = b->positions_ws[3 * (size_t)b->indices[3 * u + i / 3] + i % 3];
        if ((float)p != (float)q) return 0;
    }
    return 1;
}

static void expect_same_mask(const scene *a, const holed_triangle *p, const scene *b, const holed_triangle *q)
{
    assert_true((p == NULL) == (q == NULL));
    if (!p) return;
    const alpha_mask  *v = &a->alpha_masks[p->mask], *w = &b->alpha_masks[q->mask];
    const alpha_image *i = &a->images[v->image], *j = &b->images[w->image];
    assert_memory_equal(p->uv, q->uv, sizeof p->uv);
    assert_true(v->threshold == w->threshold && v->wrap_u == w->wrap_u && v->wrap_v == w->wrap_v && v->nearest == w->nearest);
    assert_true(i->width_px == j->width_px && i->height_px == j->height_px);
    assert_memory_equal(i->alpha, j->alpha, (size_t)i->width_px * i->height_px);
}

static void test_triangles_and_masks(void **state)
{
    (void)state;
    scene s = sample_scene(), r = written_and_read(&s);
    int   used[TRIANGLES] = {0};
    assert_string_equal(r.name, "a scene");
    assert_int_equal(r.triangle_count, TRIANGLES);
    assert_int_equal(r.image_count, 2);
    for (size_t t = 0; t < TRIANGLES; t++) {
        size_t u = 0;
        while (u < TRIANGLES && (used[u] || !same_triangle(&s, t, &r, u) || s.triangle_flags[t] != r.triangle_flags[u])) u++;
        assert_true(u < TRIANGLES);
        used[u] = 1;
        expect_same_mask(&s, hole_of(&s, t), &r, hole_of(&r, u));
    }
    scene_free(&r);
}

/* Triangles of one material stay in their order. */
static void test_order(void **state)
{
    (void)state;
    scene s                = sample_scene();
    s.holed_triangle_count = 0;
    for (size_t t = 0; t < TRIANGLES; t++) flags[t] &= TRIANGLE_DOUBLE_SIDED;
    scene  r = written_and_read(&s);
    size_t u = 0;
    for (int sided = 0; sided < 2; sided++)
        for (size_t t = 0; t < TRIANGLES; t++)
            if (double_sided[t] == sided) assert_true(same_triangle(&s, t, &r, u++));
    assert_int_equal(r.holed_triangle_count, 0);
    scene_free(&r);
}

static void test_lights_and_cameras(void **state)
{
    (void)state;
    scene s = sample_scene(), r = written_and_read(&s);
    assert_int_equal(r.light_count, 3);
    for (size_t i = 0; i < 3; i++) {
        const light_shape *p = &s.lights[i].shape, *q = &r.lights[i].shape;
        assert_string_equal(r.lights[i].name, s.lights[i].name);
        assert_true(!r.lights[i].dark == !s.lights[i].dark);
        for (int k = 0; k < 3; k++) assert_true(fabs(r.lights[i].colour[k] - s.lights[i].colour[k]) < 1e-9);
        assert_int_equal(p->kind, q->kind);
        for (int axis = 0; axis < 3; axis++) {
            if (p->kind != LIGHT_DIRECTIONAL) assert_true(p->position_ws[axis] == q->position_ws[axis]);
            if (p->kind != LIGHT_POINT) assert_true(fabs(p->direction_ws[axis] - q->direction_ws[axis]) < 1e-15);
        }
        if (p->kind == LIGHT_SPOT) assert_true(p->outer_rad == q->outer_rad);
        if (p->kind != LIGHT_DIRECTIONAL) assert_true(p->range_metres == q->range_metres);
    }
    assert_int_equal(r.camera_count, 2);
    assert_memory_equal(r.camera_positions_ws, cameras, sizeof cameras);
    scene_free(&r);
}

static void test_nothing_and_too_far(void **state)
{
    (void)state;
    scene       empty = {.name = ""}, r = written_and_read(&empty), far = sample_scene();
    run_context m = {0};
    assert_int_equal(r.triangle_count + r.light_count + r.camera_count, 0);
    scene_free(&r);
    assert_int_equal(glb_round_positions(&far, origin, &m), VXS_OK);
    assert_true(positions[3] == (float)(0.1 * 9 - 7) && positions[3] != 0.1 * 9 - 7);
    positions[4] = 1e39;
    assert_int_equal(glb_round_positions(&far, origin, &m), VXS_E_SCENE);
    assert_non_null(strstr(m.error, "1e+39"));
    assert_true(isfinite(positions[4]));
    run_free(&m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_triangles_and_masks),
        cmocka_unit_test(test_order),
        cmocka_unit_test(test_lights_and_cameras),
        cmocka_unit_test(test_nothing_and_too_far),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
