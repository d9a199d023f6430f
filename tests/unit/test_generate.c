/* Procedural scenes: what scenes/README.md promises of them, looked up in the arrays themselves.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/base/random.h"
#include "scenes/generate.h"
#include "scenes/generate_parts.h"
#include "tests/unit/repeats.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* last: cmocka's macro fail() hides the function of run_context.h, and it needs the four headers above */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

static const city_options      city_default      = {8, 100000, 1, {-0.5, -1, -0.3}, 0};
static const landscape_options landscape_default = {100000, 1, 1024, 200, {-0.5, -1, -0.3}};

/* a few cities unlike each other: many and few triangles a block */
static const city_options cities[] = {{8, 100000, 1, {0, -1, 0}, 165},  {8, 100000, 2, {0, -1, 0}, 768},
                                      {3, 30000, 3, {0, -1, 0}, 1000},  {1, 40000, 4, {0, -1, 0}, 10000},
                                      {20, 20000, 5, {0, -1, 0}, 5000}, {64, 1000, 6, {0, -1, 0}, 9999},
                                      {5, 150000, 7, {0, -1, 0}, 1}};
enum { CITIES = sizeof cities / sizeof *cities };

static glb_scene make_city(city_options o)
{
    glb_scene   s;
    run_context m = {0};
    assert_int_equal(generate_city(&s, &o, &m), VXS_OK);
    return s;
}

static glb_scene make_landscape(landscape_options o)
{
    glb_scene   s;
    run_context m = {0};
    assert_int_equal(generate_landscape(&s, &o, &m), VXS_OK);
    return s;
}

/* Closed meshes. */

static int compare_edges(const void *a, const void *b)
{
    uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return x < y ? -1 : x > y;
}

/* Whether each directed edge occurs once and its reverse once. */
static int is_closed(const uint32_t *indices, size_t triangle_count)
{
    size_t    count = 3 * triangle_count;
    uint64_t *edges = malloc(2 * count * sizeof *edges), *reversed = edges + count;
    assert_non_null(edges);
    for (size_t t = 0; t < triangle_count; t++)
        for (size_t c = 0; c < 3; c++) {
            uint64_t from = indices[3 * t + c], to = indices[3 * t + (c + 1) % 3];
            edges[3 * t + c]    = from << 32 | to;
            reversed[3 * t + c] = to << 32 | from;
        }
    qsort(edges, count, sizeof *edges, compare_edges);
    qsort(reversed, count, sizeof *reversed, compare_edges);

    int closed = !memcmp(edges, reversed, count * sizeof *edges);
    for (size_t i = 0; i < count; i++)
        if (edges[i] >> 32 == (edges[i] & UINT32_MAX) || (i && edges[i] == edges[i - 1])) closed = 0;
    free(edges);
    return closed;
}

/* Positive when the triangles look outward. */
static double volume(const float *positions, const uint32_t *indices, size_t triangle_count)
{
    double sum = 0;
    for (size_t t = 0; t < triangle_count; t++) {
        const float *a = positions + 3 * (size_t)indices[3 * t], *b = positions + 3 * (size_t)indices[3 * t + 1],
                    *c = positions + 3 * (size_t)indices[3 * t + 2];
        double bc[3]   = {(double)b[1] * c[2] - (double)b[2] * c[1], (double)b[2] * c[0] - (double)b[0] * c[2],
                          (double)b[0] * c[1] - (double)b[1] * c[0]};
        sum += a[0] * bc[0] + a[1] * bc[1] + a[2] * bc[2];
    }
    return sum / 6;
}

/* Boxes, found again from their corners. */

typedef struct solid {
    const float *corners; /* [8][3] */
    double       low[3], high[3];
    double       axes[3][3];     /* unit */
    double       from[3], to[3]; /* extent along the axes */
} solid;

static double along(const double axis[3], const float p[3])
{
    return axis[0] * p[0] + axis[1] * p[1] + axis[2] * p[2];
}

static void extent(const solid *s, const double axis[3], double *from, double *to)
{
    *from = INFINITY;
    *to   = -INFINITY;
    for (int c = 0; c < 8; c++) {
        double d = along(axis, s->corners + 3 * c);
        *from    = fmin(*from, d);
        *to      = fmax(*to, d);
    }
}

static solid solid_from_corners(const float *corners)
{
    static const double world[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    solid               s           = {.corners = corners};
    for (int i = 0; i < 3; i++) {
        const float *end    = corners + 3 * (1 << i);
        double       d[3]   = {(double)end[0] - corners[0], (double)end[1] - corners[1], (double)end[2] - corners[2]};
        double       length = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
        for (int k = 0; k < 3; k++) s.axes[i][k] = d[k] / length;
        extent(&s, s.axes[i], &s.from[i], &s.to[i]);
        extent(&s, world[i], &s.low[i], &s.high[i]);
    }
    return s;
}

static solid *solids_from_scene(const glb_scene *s)
{
    solid *solids = malloc(s->vertex_count / 8 * sizeof *solids);
    assert_non_null(solids);
    for (size_t i = 0; i < s->vertex_count / 8; i++) solids[i] = solid_from_corners(s->positions + 24 * i);
    return solids;
}

static int is_inside(const solid *a, const solid *b)
{
    const double slack = 1e-4; /* flush with a face counts as inside */
    for (int i = 0; i < 3; i++)
        if (a->low[i] < b->low[i] - slack || a->high[i] > b->high[i] + slack) return 0;
    for (int i = 0; i < 3; i++) {
        double from, to;
        extent(a, b->axes[i], &from, &to);
        if (from < b->from[i] - slack || to > b->to[i] + slack) return 0;
    }
    return 1;
}

static int is_apart(const solid *a, const solid *b)
{
    const double slack = 1e-4; /* contact is not apart */
    for (int i = 0; i < 3; i++) {
        double from, to;
        extent(a, b->axes[i], &from, &to);
        if (from > b->to[i] + slack || to < b->from[i] - slack) return 1;
    }
    return 0;
}

/* Upright boxes: the axes of their sides are all that can part them. */
static int do_touch(const solid *a, const solid *b)
{
    return !is_apart(a, b) && !is_apart(b, a);
}

static void check_boxes_are_closed_components(const glb_scene *s)
{
    size_t triangles = 0, vertices = 0;
    for (size_t i = 0; i < s->mesh_count; i++) {
        const glb_mesh *mesh = &s->meshes[i];
        assert_true(mesh->vertex_first == vertices && mesh->triangle_first == triangles && mesh->triangle_count > 0);
        assert_int_equal(mesh->triangle_count * 8, mesh->vertex_count * 12);
        for (size_t b = 0; b < mesh->triangle_count / 12; b++) {
            const uint32_t *indices = s->indices + 3 * (mesh->triangle_first + 12 * b);
            for (int k = 0; k < 36; k++) assert_int_equal(indices[k] / 8, b);
            assert_true(is_closed(indices, 12));
            solid  box       = solid_from_corners(s->positions + 3 * (mesh->vertex_first + 8 * b));
            double of_extent = (box.to[0] - box.from[0]) * (box.to[1] - box.from[1]) * (box.to[2] - box.from[2]);
            double of_mesh   = volume(s->positions + 3 * mesh->vertex_first, indices, 12);
            assert_true(of_mesh > 0);
            assert_true(fabs(of_mesh - of_extent) < 0.01 * of_extent + 1e-3); /* thin boxes far out are rounded askew */
        }
        triangles += mesh->triangle_count;
        vertices += mesh->vertex_count;
    }
    assert_true(triangles == s->triangle_count && vertices == s->vertex_count);
}

static void test_city_boxes_are_closed_outward_components(void **state)
{
    (void)state;
    for (int i = 0; i < CITIES; i++) {
        glb_scene s = make_city(cities[i]);
        check_boxes_are_closed_components(&s);
        glb_scene_free(&s);
    }
}

static void test_city_has_no_box_inside_another(void **state)
{
    (void)state;
    for (int i = 0; i < CITIES; i++) {
        glb_scene s      = make_city(cities[i]);
        solid    *solids = solids_from_scene(&s);
        size_t    count  = s.vertex_count / 8;
        for (size_t a = 0; a < count; a++)
            for (size_t b = 0; b < count; b++)
                if (a != b && is_inside(&solids[a], &solids[b])) fail_msg("city %d: box %zu lies inside box %zu", i, a, b);
        free(solids);
        glb_scene_free(&s);
    }
}

static void test_city_stands(void **state)
{
    (void)state;
    for (int i = 0; i < CITIES; i++) {
        glb_scene s      = make_city(cities[i]);
        solid    *solids = solids_from_scene(&s);
        for (size_t k = 1; k < s.mesh_count; k++) {
            size_t first = s.meshes[k].vertex_first / 8, end = first + s.meshes[k].vertex_count / 8;
            for (size_t a = first; a < end; a++) {
                int stands = do_touch(&solids[a], &solids[0]);
                for (size_t b = first; b < a && !stands; b++) stands = do_touch(&solids[a], &solids[b]);
                if (!stands) fail_msg("city %d: box %zu floats", i, a);
            }
        }
        free(solids);
        glb_scene_free(&s);
    }
}

static void check_same(const glb_scene *a, const glb_scene *b, int same)
{
    int equal = a->vertex_count == b->vertex_count && a->triangle_count == b->triangle_count &&
                !memcmp(a->positions, b->positions, 3 * a->vertex_count * sizeof *a->positions) &&
                !memcmp(a->indices, b->indices, 3 * a->triangle_count * sizeof *a->indices);
    assert_int_equal(equal, same);
}

/* Metres from a point to a box, along the box's axes: 0 inside. */
static double distance_to_solid(const solid *s, const double at[3])
{
    double most = 0;
    for (int i = 0; i < 3; i++) {
        double d = s->axes[i][0] * at[0] + s->axes[i][1] * at[1] + s->axes[i][2] * at[2];
        most     = fmax(most, fmax(s->from[i] - d, d - s->to[i]));
    }
    return most;
}

static void check_spot(const scene_light *light, size_t number)
{
    const double       degree = acos(-1) / 180;
    const light_shape *shape  = &light->shape;
    char               name[32];
    snprintf(name, sizeof name, "spot%04zu", number);
    assert_string_equal(light->name, name);
    assert_int_equal(shape->kind, LIGHT_SPOT);
    assert_true(shape->outer_rad > 19.99 * degree && shape->outer_rad < 60.01 * degree);
    assert_true(shape->range_metres >= 15 && shape->range_metres <= 40);
    const double *d = shape->direction_ws;
    assert_true(-d[1] > 0.6 * sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2])); /* down, more than sideways */
}

static void test_city_has_as_many_spots_as_asked_and_none_in_a_box(void **state)
{
    (void)state;
    for (int i = 0; i < CITIES; i++) {
        glb_scene s      = make_city(cities[i]);
        solid    *solids = solids_from_scene(&s);
        assert_int_equal(s.light_count, cities[i].spots + 1);
        assert_string_equal(s.lights[0].name, "sun");
        for (size_t k = 1; k < s.light_count; k++) {
            check_spot(&s.lights[k], k);
            const double *at = s.lights[k].shape.position_ws;
            for (size_t b = 0; b < s.vertex_count / 8; b++)
                if (distance_to_solid(&solids[b], at) < 0.09) fail_msg("city %d: %s is in box %zu", i, s.lights[k].name, b);
        }
        free(solids);
        glb_scene_free(&s);
    }
}

/* The arm of a punctual light is 6/64 m wide and 8/64 m high: nothing else is. */
static int is_under_an_arm(const solid *solids, size_t count, const double at[3])
{
    for (size_t b = 0; b < count; b++) {
        double x = solids[b].high[0] - solids[b].low[0], z = solids[b].high[2] - solids[b].low[2];
        if (fmin(x, z) > 7 / 64.0 || fabs(solids[b].high[1] - solids[b].low[1] - 8 / 64.0) > 0.01 || fmax(x, z) < 2) continue;
        if (fabs(distance_to_solid(&solids[b], at) - 8 / 64.0) < 0.001 && at[1] < solids[b].low[1]) return 1;
    }
    return 0;
}

static void test_city_spots_hang_under_punctuals_first(void **state)
{
    (void)state;
    const uint32_t counts[3] = {165, 768, 2000}, under_punctuals[3] = {165, 768, 768};
    for (int i = 0; i < 3; i++) {
        city_options o = city_default;
        o.spots        = counts[i];
        glb_scene s = make_city(o), without = make_city(city_default);
        solid    *solids = solids_from_scene(&s);
        size_t    under  = 0;
        for (size_t k = 1; k < s.light_count; k++)
            under += (size_t)is_under_an_arm(solids, s.vertex_count / 8, s.lights[k].shape.position_ws);
        assert_int_equal(under, under_punctuals[i]);
        check_same(&s, &without, 1);
        free(solids);
        glb_scene_free(&s);
        glb_scene_free(&without);
    }
}

static void test_city_meets_the_target_to_the_nearest_dozen(void **state)
{
    (void)state;
    const uint32_t targets[] = {1000, 1005, 1006, 1007, 99999, 500000};
    for (size_t i = 0; i < sizeof targets / sizeof *targets; i++) {
        city_options o = city_default;
        o.triangles    = targets[i];
        glb_scene s    = make_city(o);
        assert_in_range(s.triangle_count, targets[i] - 6, targets[i] + 6);
        glb_scene_free(&s);
    }
}

static void test_one_block_takes_the_most_triangles(void **state)
{
    (void)state;
    for (uint32_t seed = 0; seed < 3; seed++) {
        glb_scene s = make_city((city_options){1, GENERATE_TRIANGLES_MAX, seed, {0, -1, 0}, 0});
        assert_in_range(s.triangle_count, GENERATE_TRIANGLES_MAX - 6, GENERATE_TRIANGLES_MAX + 6);
        glb_scene_free(&s);
    }
}

/* Heights, turns and thin boxes are there; heights lie on the 1/64 m grid. */
static void test_city_looks_like_one(void **state)
{
    (void)state;
    glb_scene s      = make_city(city_default);
    solid    *solids = solids_from_scene(&s);
    size_t    count = s.vertex_count / 8, towers = 0, turned = 0, thin = 0;
    for (size_t i = 1; i < count; i++) {
        double width = fmin(solids[i].to[0] - solids[i].from[0], solids[i].to[2] - solids[i].from[2]);
        double tall  = solids[i].high[1] - solids[i].low[1];
        towers += solids[i].high[1] > 40 && width > 5;
        turned += fmax(fabs(solids[i].axes[0][0]), fabs(solids[i].axes[0][2])) < 0.99;
        thin += width < 0.2 && tall > 2;
        assert_true(solids[i].low[1] >= -1.5 && solids[i].high[1] <= 130);
        for (int c = 0; c < 8; c++) assert_true(fmod(64.0 * solids[i].corners[3 * c + 1], 1) == 0);
    }
    assert_in_range(towers, 50, 500);
    assert_in_range(turned, count / 20, count / 2);
    assert_in_range(thin, 64 * 12, count / 3);
    free(solids);
    glb_scene_free(&s);
}

static void test_seed_decides(void **state)
{
    (void)state;
    city_options      other_city      = city_default;
    landscape_options other_landscape = landscape_default;
    other_city.seed = other_landscape.seed = 2;
    glb_scene c[3]                         = {make_city(city_default), make_city(city_default), make_city(other_city)};
    glb_scene l[3] = {make_landscape(landscape_default), make_landscape(landscape_default), make_landscape(other_landscape)};
    check_same(&c[0], &c[1], 1);
    check_same(&c[0], &c[2], 0);
    check_same(&l[0], &l[1], 1);
    check_same(&l[0], &l[2], 0);
    for (int i = 0; i < 3; i++) {
        glb_scene_free(&c[i]);
        glb_scene_free(&l[i]);
    }
}

static void test_landscape_is_closed_and_outward(void **state)
{
    (void)state;
    const landscape_options options[] = {{100000, 1, 1024, 200, {0, -1, 0}},
                                         {1000, 2, 1, 0.25, {0, -1, 0}},
                                         {30011, 3, 100000, 10000, {0, -1, 0}},
                                         {4000, 4, 10, 0, {0, -1, 0}}};
    for (size_t i = 0; i < sizeof options / sizeof *options; i++) {
        const landscape_options *o = &options[i];
        glb_scene                s = make_landscape(*o);
        assert_true(fabs((double)s.triangle_count - o->triangles) <= 0.02 * o->triangles);
        assert_int_equal(s.mesh_count, 1);
        for (size_t k = 0; k < 3 * s.triangle_count; k++) assert_true(s.indices[k] < s.vertex_count);
        assert_true(is_closed(s.indices, s.triangle_count));
        assert_int_equal(s.triangle_count, 2 * s.vertex_count - 4); /* Euler: one sphere, no vertex unused */

        double base = o->size_metres * o->size_metres * o->size_metres / 32;
        double most = base + o->size_metres * o->size_metres * o->height_metres;
        double v    = volume(s.positions, s.indices, s.triangle_count);
        assert_true(v > base * 0.999 && v < most * 1.001);

        float low = INFINITY, high = -INFINITY;
        for (size_t k = 0; k < s.vertex_count; k++)
            low = fminf(low, s.positions[3 * k + 1]), high = fmaxf(high, s.positions[3 * k + 1]);
        assert_true(low == (float)(-o->size_metres / 32) && high == (float)o->height_metres);
        glb_scene_free(&s);
    }
}

static void test_landscape_meets_every_target(void **state)
{
    (void)state;
    for (uint32_t t = GENERATE_TRIANGLES_MIN; t < 300000; t += 1 + t / repeats(10, 40)) {
        landscape_options o = landscape_default;
        o.triangles         = t;
        glb_scene s         = make_landscape(o);
        assert_true(fabs((double)s.triangle_count - t) <= 0.02 * t);
        glb_scene_free(&s);
    }
}

/* What generators build scenes of. */

static void test_turns_go_round_the_unit_circle(void **state)
{
    (void)state;
    for (uint32_t n = 4; n <= 256; n *= 2) {
        double area = 0, c0, s0, c1, s1;
        for (uint32_t k = 0; k < n; k++) {
            parts_turn(k, n, &c0, &s0);
            parts_turn((k + 1) % n, n, &c1, &s1);
            assert_true(fabs(c0 * c0 + s0 * s0 - 1) < 1e-15);
            assert_true(c0 * s1 - s0 * c1 > 0); /* on, by less than half a turn */
            area += (c0 * s1 - s0 * c1) / 2;
        }
        assert_true(area < acos(-1) && area > acos(-1) * (1 - 9.0 / n / n)); /* once round: evenly spaced corners miss 6.6 / n^2 */
    }
}

static void check_part(glb_scene *s, double least_volume, double most_volume)
{
    assert_true(is_closed(s->indices, s->triangle_count));
    double v = volume(s->positions, s->indices, s->triangle_count);
    if (!(v > least_volume && v < most_volume)) fail_msg("volume %g, expected %g to %g", v, least_volume, most_volume);
    glb_scene_free(s);
}

static void test_parts_are_closed_and_outward(void **state)
{
    (void)state;
    const double ball[5][2] = {{0, 1}, {0.6, 0.8}, {1, 0}, {0.6, -0.8}, {0, -1}}, low[3] = {1, 2, 3}, high[3] = {2, 4, 6};
    const double at[3] = {5, 6, 7}, top[3] = {6, 9, 8};
    run_context  m = {0};
    glb_scene    s;

    parts p = parts_begin(&s, "box");
    parts_mesh(&p, "box", 0);
    parts_box(&p, (parts_frame){{1, 2, 3}, 0.6, 0.8}, low, high);
    assert_int_equal(parts_end(&p, &m), VXS_OK);
    assert_int_equal(s.triangle_count, 12);
    check_part(&s, 5.9999, 6.0001);

    p = parts_begin(&s, "inside out");
    parts_mesh(&p, "box", 0);
    parts_box(&p, parts_upright, (double[3]){2, 2, 3}, (double[3]){1, 4, 6});
    assert_int_equal(parts_end(&p, &m), VXS_OK);
    check_part(&s, -6.0001, -5.9999);

    p = parts_begin(&s, "lathe");
    parts_mesh(&p, "lathe", 0);
    parts_lathe(&p, at, ball, 5, 64);
    assert_int_equal(parts_end(&p, &m), VXS_OK);
    assert_int_equal(s.triangle_count, 2 * 64 * 4 - 2 * 64);
    check_part(&s, 3.2, 3.6); /* two cones of 0.2 and two frustums of 0.8: 3.586 */

    p = parts_begin(&s, "tube");
    parts_mesh(&p, "tube", 0);
    parts_tube(&p, at, 1, top, 0.5, 64);
    assert_int_equal(parts_end(&p, &m), VXS_OK);
    assert_int_equal(s.triangle_count, 4 * 64 - 4);
    check_part(&s, 5.4, 5.4978); /* pi (1 + 0.5 + 0.25) 3 / 3 */
}

static void test_empty_meshes_are_left_out(void **state)
{
    (void)state;
    run_context m = {0};
    glb_scene   s;
    parts       p = parts_begin(&s, "a");
    parts_mesh(&p, "empty", 0);
    parts_mesh(&p, "full", 0);
    parts_box(&p, parts_upright, (double[3]){0, 0, 0}, (double[3]){1, 1, 1});
    parts_mesh(&p, "empty too", 0);
    assert_int_equal(parts_end(&p, &m), VXS_OK);
    assert_int_equal(s.mesh_count, 1);
    assert_string_equal(s.meshes[0].name, "full");
    glb_scene_free(&s);
}

/* Written data equals the data that is read. */

static scene reread(glb_scene *s)
{
    char        path[] = "/tmp/test_generate-XXXXXX.glb";
    output_file out    = {0};
    run_context m      = {0};
    scene       loaded;
    int         file = mkstemps(path, 4);
    assert_true(file >= 0);
    close(file);
    assert_int_equal(output_file_open(&out, path, &m), VXS_OK);
    assert_int_equal(glb_write(s, &out, &m), VXS_OK);
    assert_int_equal(output_file_commit(&out, &m), VXS_OK);
    if (scene_load_gltf(&loaded, path, NULL, &m) != VXS_OK) fail_msg("%s", m.error);
    unlink(path);
    run_free(&m);
    glb_scene_free(s);
    return loaded;
}

static void check_light(const scene_light *light, const char *name, light_shape expected)
{
    const double *d = expected.direction_ws, length = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    assert_string_equal(light->name, name);
    assert_int_equal(light->shape.kind, expected.kind);
    if (expected.kind != LIGHT_POINT)
        for (int i = 0; i < 3; i++) assert_true(fabs(light->shape.direction_ws[i] - d[i] / length) < 1e-15);
    if (expected.kind == LIGHT_DIRECTIONAL) return;
    assert_memory_equal(light->shape.position_ws, expected.position_ws, sizeof expected.position_ws);
    assert_true(light->shape.range_metres == expected.range_metres);
    if (expected.kind == LIGHT_SPOT) assert_true(light->shape.outer_rad == expected.outer_rad);
}

static void test_lights_are_read_as_they_were_meant(void **state)
{
    (void)state;
    const light_shape shapes[] = {{LIGHT_DIRECTIONAL, {0}, {1, -2, 3}, 0, INFINITY},
                                  {LIGHT_SPOT, {1e7, 0.1, -3}, {0, 0, 1}, 0.7, 12.5},
                                  {LIGHT_SPOT, {0, 0, 0}, {-1, -1e-9, 0}, 90 * (3.14159265358979323846 / 180), INFINITY},
                                  {LIGHT_POINT, {1e-7, 2, 3}, {0}, 0, 0.1},
                                  {LIGHT_POINT, {4, 5, 6}, {0}, 0, INFINITY}};
    enum { SHAPES = sizeof shapes / sizeof *shapes };
    run_context m = {0};
    glb_scene   s;
    parts       p = parts_begin(&s, "lights");
    for (int i = 0; i < SHAPES; i++) parts_light(&p, (const char *[]){"a", "b", "c", "d", "e"}[i], shapes[i]);
    assert_int_equal(parts_end(&p, &m), VXS_OK);
    scene loaded = reread(&s);
    assert_int_equal(loaded.light_count, SHAPES);
    assert_int_equal(loaded.triangle_count, 0);
    for (int i = 0; i < SHAPES; i++) check_light(&loaded.lights[i], (const char *[]){"a", "b", "c", "d", "e"}[i], shapes[i]);
    scene_free(&loaded);
}

static void test_meshes_are_read_where_they_were_put(void **state)
{
    (void)state;
    run_context m = {0};
    glb_scene   s;
    parts       p     = parts_begin(&s, "far");
    uint32_t    cloth = parts_material(&p, (glb_material){.name = "cloth", .double_sided = 1});
    parts_mesh(&p, "here", cloth);
    parts_quad(&p, (double[3]){0, 0, 0}, (double[3]){0, 0, 1}, (double[3]){1, 0, 1}, (double[3]){1, 0, 0});
    parts_mesh(&p, "there", 0);
    parts_box(&p, parts_upright, (double[3]){0, 0, 0}, (double[3]){1, 1, 0.25});
    for (int i = 0; i < 3; i++) s.meshes[1].translation[i] = (double[3]){1e7, -0.1, 1e-9}[i];
    assert_int_equal(parts_end(&p, &m), VXS_OK);
    scene loaded = reread(&s);
    assert_int_equal(loaded.triangle_count, 14);
    for (int t = 0; t < 14; t++) assert_int_equal(loaded.triangle_flags[t], t < 2 ? TRIANGLE_DOUBLE_SIDED : 0);
    const double *corner = &loaded.positions_ws[3 * loaded.indices[3 * 3 + 1]]; /* the box's second triangle, its corner 6 */
    assert_true(corner[0] == 1e7 && corner[1] == 1 + -0.1 && corner[2] == 0.25 + 1e-9);
    scene_free(&loaded);
}

/* A forest's cards have the one mask, with the image's own alpha; nothing else has. */
static void test_cards_are_read_with_their_mask(void **state)
{
    (void)state;
    run_context    m = {0};
    forest_options o = {2000, 1, 30, {0, -1, 0}};
    glb_scene      s;
    assert_int_equal(generate_forest(&s, &o, &m), VXS_OK);
    size_t   cards = s.meshes[2].triangle_count, first = s.meshes[2].triangle_first, pixels = 128 * 128;
    uint8_t *alpha = malloc(pixels);
    assert_non_null(alpha);
    for (size_t i = 0; i < pixels; i++) alpha[i] = s.images[0].rgba[4 * i + 3];

    scene loaded = reread(&s);
    if (!loaded.alpha_mask_count) { /* masks are not read yet */
        free(alpha);
        scene_free(&loaded);
        skip();
    }
    assert_int_equal(loaded.alpha_mask_count, 1);
    assert_int_equal(loaded.image_count, 1);
    assert_true(loaded.alpha_masks[0].threshold == 0.5F && loaded.images[0].width_px == 128 && loaded.images[0].height_px == 128);
    assert_memory_equal(loaded.images[0].alpha, alpha, pixels);
    assert_int_equal(loaded.holed_triangle_count, cards);
    for (size_t t = 0; t < loaded.triangle_count; t++)
        assert_int_equal(loaded.triangle_flags[t], t < first ? 0 : TRIANGLE_DOUBLE_SIDED | TRIANGLE_ALPHA_MASK);
    free(alpha);
    scene_free(&loaded);
}

/* SplitMix64's first numbers from state 0 are 0xe220a8397b1dcdaf, 0x6e789e6aa1b965f4. */
static void test_random_numbers_are_splitmix64(void **state)
{
    (void)state;
    rng r = {0};
    assert_int_equal(rng_u32(&r), 0xe220a839);
    assert_int_equal(rng_u32(&r), 0x6e789e6a);
}

static void test_random_numbers_are_even(void **state)
{
    (void)state;
    rng    r        = rng_split(1, 2);
    size_t seen[10] = {0};
    for (int i = 0; i < 100000; i++) seen[rng_between(&r, -3, 6) + 3]++;
    for (int i = 0; i < 10; i++) assert_in_range(seen[i], 9600, 10400);
    for (int i = 0; i < 1000; i++) assert_true(rng_below(&r, 0x80000001u) <= 0x80000000u);
    assert_int_equal(rng_below(&r, 1), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_city_boxes_are_closed_outward_components),
        cmocka_unit_test(test_city_has_no_box_inside_another),
        cmocka_unit_test(test_city_stands),
        cmocka_unit_test(test_city_has_as_many_spots_as_asked_and_none_in_a_box),
        cmocka_unit_test(test_city_spots_hang_under_punctuals_first),
        cmocka_unit_test(test_city_meets_the_target_to_the_nearest_dozen),
        cmocka_unit_test(test_one_block_takes_the_most_triangles),
        cmocka_unit_test(test_city_looks_like_one),
        cmocka_unit_test(test_seed_decides),
        cmocka_unit_test(test_landscape_is_closed_and_outward),
        cmocka_unit_test(test_landscape_meets_every_target),
        cmocka_unit_test(test_turns_go_round_the_unit_circle),
        cmocka_unit_test(test_parts_are_closed_and_outward),
        cmocka_unit_test(test_empty_meshes_are_left_out),
        cmocka_unit_test(test_lights_are_read_as_they_were_meant),
        cmocka_unit_test(test_meshes_are_read_where_they_were_put),
        cmocka_unit_test(test_cards_are_read_with_their_mask),
        cmocka_unit_test(test_random_numbers_are_splitmix64),
        cmocka_unit_test(test_random_numbers_are_even),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
