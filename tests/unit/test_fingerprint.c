/* Fingerprints of scenes: what changes one, and what changes none.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "baker/scene/fingerprint.h"

#include <cmocka.h> /* last: it makes a macro of fail */

/* A sheet of two triangles, one with holes; two punctual lights and a sun; two cameras. */
typedef struct world {
    double         positions[6][3];
    uint32_t       indices[9];
    uint8_t        flags[3], pixels[2][6];
    alpha_image    images[2];
    alpha_mask     masks[2];
    holed_triangle holed[2];
    scene_light    lights[3];
    double         cameras[2][3];
    scene          s;
} world;

enum { GEOMETRY = 1, ALPHA_MASKS = 2, CAMERAS = 4, LIGHTS = 8 };

/* padding  whatever lies between the members of structs */
static void make(world *w, int padding)
{
    static const double  positions[4][3] = {{0, 0, 0}, {1, 0, 0}, {1, 0, 1}, {0, 0.5, 1}};
    static const uint8_t pixels[6]       = {0, 50, 100, 150, 200, 250};
    memset(w, padding, sizeof *w);
    memcpy(w->positions, positions, sizeof positions);
    memcpy(w->indices, (uint32_t[6]){0, 1, 2, 0, 2, 3}, 6 * sizeof *w->indices);
    memcpy(w->flags, (uint8_t[2]){TRIANGLE_DOUBLE_SIDED, TRIANGLE_ALPHA_MASK}, 2);
    for (int n = 0; n < 2; n++) {
        memcpy(w->pixels[n], pixels, sizeof pixels);
        w->images[n].width_px  = 3;
        w->images[n].height_px = 2;
        w->images[n].alpha     = w->pixels[n];
        w->masks[n].image      = (uint32_t)n;
        w->masks[n].threshold  = 0.5f;
        w->masks[n].wrap_u     = WRAP_REPEAT;
        w->masks[n].wrap_v     = WRAP_CLAMP;
        w->masks[n].nearest    = 0;
    }
    w->holed[0].triangle = 1;
    w->holed[0].mask     = 0;
    memcpy(w->holed[0].uv, (float[3][2]){{0, 0}, {1, 1}, {0, 1}}, sizeof w->holed[0].uv);
    static char *const      names[3] = {"sun", "lamp", "bulb"};
    static const light_kind kinds[3] = {LIGHT_DIRECTIONAL, LIGHT_SPOT, LIGHT_POINT};
    for (int n = 0; n < 3; n++) {
        light_shape *l    = &w->lights[n].shape;
        w->lights[n].name = names[n];
        l->kind           = kinds[n];
        l->outer_rad      = 0.5;
        l->range_metres   = INFINITY;
        memcpy(l->position_ws, (double[3]){n, 5, 0}, sizeof l->position_ws);
        memcpy(l->direction_ws, (double[3]){0, -1, 0}, sizeof l->direction_ws);
    }
    memcpy(w->cameras, (double[2][3]){{3, 3, 3}, {4, 4, 4}}, sizeof w->cameras);
    w->s.name                = names[0];
    w->s.positions_ws        = w->positions[0];
    w->s.indices             = w->indices;
    w->s.triangle_flags      = w->flags;
    w->s.images              = w->images;
    w->s.alpha_masks         = w->masks;
    w->s.holed_triangles     = w->holed;
    w->s.lights              = w->lights;
    w->s.camera_positions_ws = w->cameras[0];
    w->s.vertex_count        = 4;
    w->s.triangle_count      = 2;
    w->s.image_count = w->s.alpha_mask_count = 1;
    w->s.holed_triangle_count                = 1;
    w->s.light_count                         = 3;
    w->s.camera_count                        = 2;
}

static scene_fingerprint fingerprint(const world *w)
{
    scene_fingerprint f;
    run_context       m = {0};
    assert_int_equal(scene_fingerprint_take(&f, &w->s, &m), VXS_OK);
    return f;
}

/* Which fingerprints two scenes do not share. */
static int differences(const world *a, const world *b)
{
    scene_fingerprint f = fingerprint(a), g = fingerprint(b);
    return (strcmp(f.geometry, g.geometry) ? GEOMETRY : 0) | (strcmp(f.alpha_masks, g.alpha_masks) ? ALPHA_MASKS : 0) |
           (strcmp(f.cameras, g.cameras) ? CAMERAS : 0) | (strcmp(f.lights, g.lights) ? LIGHTS : 0);
}

/* Make a scene, change it by a statement, and hold it against the scene as it was. */
#define CHANGED(expected, statement)                                                                                               \
    do {                                                                                                                           \
        world was, w;                                                                                                              \
        make(&was, 0);                                                                                                             \
        make(&w, 0);                                                                                                               \
        statement;                                                                                                                 \
        assert_int_equal(differences(&was, &w), expected);                                                                         \
    } while (0)

static void every_field_changes_its_own_fingerprint(void **state)
{
    (void)state;
    for (int vertex = 0; vertex < 4; vertex++)
        for (int axis = 0; axis < 3; axis++) CHANGED(GEOMETRY, w.positions[vertex][axis] = nextafter(w.positions[vertex][axis], 9));
    CHANGED(GEOMETRY, memcpy(w.indices, ((uint32_t[3]){0, 2, 1}), 3 * sizeof *w.indices)); /* another winding */
    CHANGED(GEOMETRY, memcpy(w.indices, ((uint32_t[3]){0, 1, 3}), 3 * sizeof *w.indices));
    CHANGED(GEOMETRY, w.flags[0] = 0);
    CHANGED(GEOMETRY, w.flags[1] |= TRIANGLE_DOUBLE_SIDED);
    CHANGED(GEOMETRY, w.flags[0] = TRIANGLE_ALPHA_MASK; w.flags[1] = TRIANGLE_DOUBLE_SIDED); /* the other has the holes */
    CHANGED(GEOMETRY, w.s.triangle_count = 1);

    for (int pixel = 0; pixel < 6; pixel++) CHANGED(ALPHA_MASKS, w.pixels[0][pixel] ^= 1);
    CHANGED(ALPHA_MASKS, w.images[0].width_px = 2; w.images[0].height_px = 3);
    CHANGED(ALPHA_MASKS, w.masks[0].threshold = 0.25f);
    CHANGED(ALPHA_MASKS, w.masks[0].wrap_u = WRAP_MIRROR);
    CHANGED(ALPHA_MASKS, w.masks[0].wrap_v = WRAP_MIRROR);
    CHANGED(ALPHA_MASKS, w.masks[0].nearest = 1);
    for (int corner = 0; corner < 6; corner++) CHANGED(ALPHA_MASKS, w.holed[0].uv[corner / 2][corner % 2] += 0.25f);

    for (int axis = 0; axis < 3; axis++) CHANGED(CAMERAS, w.cameras[1][axis] += 1e-9);
    CHANGED(CAMERAS, w.s.camera_count = 1);

    for (int axis = 0; axis < 3; axis++) CHANGED(LIGHTS, w.lights[2].shape.position_ws[axis] += 1e-9);
    CHANGED(LIGHTS, w.lights[0].name = "moon");
    CHANGED(LIGHTS, w.s.light_count = 2);
    CHANGED(LIGHTS, w.lights[0].shape.kind = LIGHT_POINT);
}

static void what_casts_no_shadow_changes_none(void **state)
{
    (void)state;
    CHANGED(0, w.s.name = "another");
    CHANGED(0, w.lights[0].shape.position_ws[1] = 99); /* sunlight comes from nowhere */
    CHANGED(0, w.lights[1].shape.direction_ws[0] = 1); /* nor does a punctual light's cone make a place */
    CHANGED(0, w.lights[1].shape.outer_rad = 1);
    CHANGED(0, w.lights[2].shape.range_metres = 1);
}

static void bytes_between_members_do_not_count(void **state)
{
    (void)state;
    world zeros, ones;
    make(&zeros, 0);
    make(&ones, 0xff);
    assert_int_equal(differences(&zeros, &ones), 0);
}

/* Vertices of their own for each triangle, masks and images that are there twice. */
static void sharing_does_not_count(void **state)
{
    (void)state;
    CHANGED(0, memcpy(w.positions[4], w.positions[0], sizeof w.positions[0]); w.indices[3] = 4; w.s.vertex_count = 5);
    CHANGED(0, w.s.image_count = w.s.alpha_mask_count = 2; w.holed[0].mask = 1);
    CHANGED(0, w.s.vertex_count = 6); /* unused */
}

/* Another triangle before those with holes is no other mask. */
static void geometry_alone_says_which_triangles_have_holes(void **state)
{
    (void)state;
    CHANGED(GEOMETRY, memcpy(w.indices, ((uint32_t[9]){3, 1, 0, 0, 1, 2, 0, 2, 3}), sizeof w.indices);
            memcpy(w.flags, ((uint8_t[3]){0, TRIANGLE_DOUBLE_SIDED, TRIANGLE_ALPHA_MASK}), 3); w.s.triangle_count = 3;
            w.holed[0].triangle                                                                                   = 2);
}

static void zeros_are_equal_and_so_is_what_is_no_number(void **state)
{
    (void)state;
    world a, b;
    CHANGED(0, w.positions[0][0] = -0.0);
    CHANGED(0, w.holed[0].uv[0][0] = -0.0f);
    make(&a, 0);
    make(&b, 0);
    a.cameras[0][0] = NAN;
    b.cameras[0][0] = -(double)NAN;
    assert_int_equal(differences(&a, &b), 0);
    b.cameras[0][0] = INFINITY;
    assert_int_equal(differences(&a, &b), CAMERAS);
}

/* More words than are collected at a time. */
static void every_one_of_many_counts(void **state)
{
    (void)state;
    enum { MANY = 3000 };
    static double   positions[3 * MANY];
    static uint32_t indices[3 * MANY];
    static uint8_t  flags[MANY];
    world           a, b;
    make(&a, 0);
    for (uint32_t n = 0; n < 3 * MANY; n++) positions[n] = n, indices[n] = n % MANY;
    a.s.positions_ws   = positions;
    a.s.indices        = indices;
    a.s.triangle_flags = flags;
    a.s.vertex_count = a.s.triangle_count = MANY;
    b                                     = a;
    scene_fingerprint before              = fingerprint(&a);
    for (int n = 0; n < MANY; n += 7) {
        flags[n] ^= TRIANGLE_DOUBLE_SIDED;
        assert_string_not_equal(fingerprint(&b).geometry, before.geometry);
        flags[n] ^= TRIANGLE_DOUBLE_SIDED;
    }
    assert_string_equal(fingerprint(&b).geometry, before.geometry);
}

/* XXH3-128 of the words in little-endian order, computed by other means: a file of today is known tomorrow, and
 * on another machine. */
static void it_stays_what_it_is(void **state)
{
    (void)state;
    world w;
    make(&w, 0);
    scene_fingerprint f = fingerprint(&w);
    assert_string_equal(f.geometry, "cfbb528e4e10eaffcab4da3e2cecc7a1");
    assert_string_equal(f.alpha_masks, "1f96f54daaf9f4f216dc9d07e7bf7448");
    assert_string_equal(f.cameras, "a9fd7f865087bb20f8aa94055cfb4045");
    assert_string_equal(f.lights, "ca330a2b40ed63f3067e75904d53326d");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_field_changes_its_own_fingerprint),
        cmocka_unit_test(what_casts_no_shadow_changes_none),
        cmocka_unit_test(bytes_between_members_do_not_count),
        cmocka_unit_test(sharing_does_not_count),
        cmocka_unit_test(geometry_alone_says_which_triangles_have_holes),
        cmocka_unit_test(zeros_are_equal_and_so_is_what_is_no_number),
        cmocka_unit_test(every_one_of_many_counts),
        cmocka_unit_test(it_stays_what_it_is),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
