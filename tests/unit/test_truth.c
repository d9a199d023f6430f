/* The ray-traced truth against answers by hand, analytic solids, and brute force in double; and the parallel loop.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/parallel.h"
#include "baker/base/random.h"
#include "baker/base/vec3.h"
#include "baker/lab/truth/truth.h"
#include "baker/scene/scene.h"

#include <cmocka.h> /* last: it makes a macro of fail */

/* -- scenes ---------------------------------------------------------------------------------------------- */

enum { VERTICES_MAX = 40000, TRIANGLES_MAX = 40000 };

/* Shapes are appended to one scene at a time; solids before sheets. */
static double   positions[3 * VERTICES_MAX];
static uint32_t indices[3 * TRIANGLES_MAX];
static casters  built;

static void start(void)
{
    built = (casters){.positions_ws = positions, .indices = indices};
}

static uint32_t vertex(double x, double y, double z)
{
    assert_true(built.vertex_count < VERTICES_MAX);
    double *p = &positions[3 * built.vertex_count];
    p[0] = x, p[1] = y, p[2] = z;
    return (uint32_t)built.vertex_count++;
}

static void triangle(uint32_t a, uint32_t b, uint32_t c)
{
    assert_true(built.triangle_count < TRIANGLES_MAX);
    uint32_t *corners = &indices[3 * built.triangle_count++];
    corners[0] = a, corners[1] = b, corners[2] = c;
}

static void solids_end_here(void)
{
    built.solid_triangle_count = built.triangle_count;
}

static void quad(uint32_t a, uint32_t b, uint32_t c, uint32_t d)
{
    triangle(a, b, c);
    triangle(a, c, d);
}

static void box(double x0, double y0, double z0, double x1, double y1, double z1)
{
    uint32_t v[8];
    for (int i = 0; i < 8; i++) v[i] = vertex(i & 1 ? x1 : x0, i & 2 ? y1 : y0, i & 4 ? z1 : z0);
    quad(v[0], v[4], v[6], v[2]);
    quad(v[1], v[3], v[7], v[5]);
    quad(v[0], v[1], v[5], v[4]);
    quad(v[2], v[6], v[7], v[3]);
    quad(v[0], v[2], v[3], v[1]);
    quad(v[4], v[5], v[7], v[6]);
}

/* Rings of latitude, poles along y. */
static void sphere(double x, double y, double z, double radius, int rings)
{
    const double pi  = 3.14159265358979323846;
    uint32_t     top = vertex(x, y + radius, z), bottom = vertex(x, y - radius, z);
    uint32_t     ring = (uint32_t)built.vertex_count;
    uint32_t     side = 2 * (uint32_t)rings;
    for (int i = 1; i < rings; i++)
        for (uint32_t k = 0; k < side; k++) {
            double across = radius * sin(pi * i / rings), turn = 2 * pi * k / side;
            vertex(x + across * cos(turn), y + radius * cos(pi * i / rings), z + across * sin(turn));
        }
    for (uint32_t k = 0; k < side; k++) {
        uint32_t next = (k + 1) % side, last = ring + side * (uint32_t)(rings - 2);
        triangle(top, ring + next, ring + k);
        triangle(bottom, last + k, last + next);
        for (uint32_t i = 0; i + 2 < (uint32_t)rings; i++)
            quad(ring + side * i + k, ring + side * i + next, ring + side * (i + 1) + next, ring + side * (i + 1) + k);
    }
}

/* The ground y = 0, a sheet, from -100 to 100. */
static void ground(void)
{
    quad(vertex(-100, 0, -100), vertex(-100, 0, 100), vertex(100, 0, 100), vertex(100, 0, -100));
}

static double uniform(rng *r)
{
    return rng_u32(r) * 0x1p-32;
}

static void random_point(rng *r, double size, double point[3])
{
    for (int i = 0; i < 3; i++) point[i] = size * (uniform(r) - 0.5);
}

static void random_direction(rng *r, double unit[3])
{
    double v[3];
    do random_point(r, 2, v);
    while (vec3_dot(v, v) > 1 || vec3_dot(v, v) < 0.01);
    vec3_unit(v, unit);
}

/* Triangles of many sizes in a cube of 100 m. */
static void random_triangles(rng *r, int count)
{
    for (int i = 0; i < count; i++) {
        double centre[3], size = pow(10, 1.5 - 3 * uniform(r));
        random_point(r, 100, centre);
        uint32_t corners[3];
        for (int k = 0; k < 3; k++) {
            double away[3];
            random_point(r, size, away);
            corners[k] = vertex(centre[0] + away[0], centre[1] + away[1], centre[2] + away[2]);
        }
        triangle(corners[0], corners[1], corners[2]);
    }
}

static void move_all(double x, double y, double z)
{
    for (size_t i = 0; i < built.vertex_count; i++) {
        positions[3 * i] += x;
        positions[3 * i + 1] += y;
        positions[3 * i + 2] += z;
    }
}

static void scale_all(double factor)
{
    for (size_t i = 0; i < 3 * built.vertex_count; i++) positions[i] *= factor;
}

static truth *make(void)
{
    run_context m = {0};
    truth      *t;
    assert_int_equal(truth_create(&t, &built, 2, &m), VXS_OK);
    assert_string_equal(m.error, "");
    return t;
}

static int lit(const truth *t, double x, double y, double z, const double direction[3])
{
    light_shape sun = {.kind = LIGHT_DIRECTIONAL, .direction_ws = {direction[0], direction[1], direction[2]}};
    return truth_lit(t, (const double[]){x, y, z}, &sun);
}

/* -- brute force ----------------------------------------------------------------------------------------- */

static const double *corner_of(size_t t, int k)
{
    return &positions[3 * (size_t)indices[3 * t + (size_t)k]];
}

/* Moeller and Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection", 1997, in double.
 * margin  [out] how clearly the ray hits (above 0) or misses (below 0), in metres
 * Returns the distance along the ray; 0 where it is parallel. */
static double intersect(size_t t, const double origin[3], const double direction[3], double *margin)
{
    const double *a = corner_of(t, 0);
    double        ab[3], ac[3], from_a[3], p[3], q[3], normal[3];
    vec3_sub(corner_of(t, 1), a, ab);
    vec3_sub(corner_of(t, 2), a, ac);
    vec3_sub(origin, a, from_a);
    vec3_cross(direction, ac, p);
    vec3_cross(from_a, ab, q);
    vec3_cross(ab, ac, normal);
    double det = vec3_dot(ab, p);
    if (det == 0) {
        *margin = 0;
        return 0;
    }
    double u = vec3_dot(from_a, p) / det, v = vec3_dot(direction, q) / det, distance = vec3_dot(ac, q) / det;
    /* a barycentric margin becomes metres across the ray by the triangle's least height, as seen along the ray */
    double longest = fmax(vec3_dot(ab, ab), vec3_dot(ac, ac));
    double height  = fabs(det) / sqrt(longest);
    *margin        = fmin(fmin(fmin(u, v), 1 - u - v) * height, distance * fabs(det) / sqrt(vec3_dot(normal, normal)));
    return distance;
}

/* 1 hit, 0 no hit, -1 too close to tell; nearest distance and its triangle for hits. */
static int brute_first_hit(const double origin[3], const double direction[3], double slack, double *distance, size_t *hit)
{
    double doubtful = INFINITY;
    *distance       = INFINITY;
    for (size_t t = 0; t < built.triangle_count; t++) {
        double margin, here = intersect(t, origin, direction, &margin);
        if (margin > slack && here < *distance) *distance = here, *hit = t;
        if (fabs(margin) <= slack) doubtful = fmin(doubtful, here);
    }
    if (doubtful < *distance + slack) return -1;
    return *distance < INFINITY;
}

/* -- light ----------------------------------------------------------------------------------------------- */

static void a_box_on_the_ground_casts_the_shadow_drawn_by_hand(void **state)
{
    (void)state;
    const double slanted[3] = {0.6, -0.8, 0}; /* the box's shadow reaches 0.75 m along +x for every metre of height */
    const double down[3]    = {0, -1, 0};
    start();
    box(0, 0, 0, 2, 4, 2);
    solids_end_here();
    ground();
    truth *t = make();

    assert_int_equal(lit(t, 4.99, 0.001, 1, slanted), 0); /* x = 2 + 4 * 0.75 is the end of the shadow */
    assert_int_equal(lit(t, 5.01, 0.001, 1, slanted), 1);
    assert_int_equal(lit(t, 4, 0.001, 2.01, slanted), 1); /* beside it */
    assert_int_equal(lit(t, 4, 0.001, 1.99, slanted), 0);
    assert_int_equal(lit(t, -0.01, 2, 1, slanted), 1); /* the side to the sun */
    assert_int_equal(lit(t, 2.01, 2, 1, slanted), 0);  /* the side away */
    assert_int_equal(lit(t, 2.01, 3.999, 1, slanted), 1);
    assert_int_equal(lit(t, 1, 4.001, 1, slanted), 1); /* on top */
    assert_int_equal(lit(t, 1, 3.999, 1, slanted), 0); /* under the lid, inside */
    assert_int_equal(lit(t, 50, -1, 50, slanted), 0);  /* sheets have two sides */
    assert_int_equal(lit(t, 101, -1, 0, down), 1);
    assert_int_equal(lit(t, 50, 0, 50, down), 1); /* exactly on a level floor */
    assert_int_equal(lit(t, 50, 0, 50, slanted), 1);
    assert_int_equal(lit(t, 1, 1000, 1, down), 1);
    assert_int_equal(lit(t, 1, -1e12, 1, down), 0); /* from far away, outside the bounds */
    assert_int_equal(lit(t, 1e300, -1e300, 1e300, down), 1);
    truth_destroy(t);
}

/* Rays from everywhere, hit or not, against all triangles in double. */
static void compare_rays(double size, const double offset[3])
{
    rng r = {7};
    start();
    random_triangles(&r, 3000);
    scale_all(size / 100);
    move_all(offset[0], offset[1], offset[2]);
    truth *t     = make();
    double slack = 2 * truth_precision(t);

    int clear = 0, hits = 0;
    for (int i = 0; i < 3000; i++) {
        double origin[3], direction[3], distance, found, normal[3];
        size_t hit = 0;
        random_point(&r, 1.5 * size, origin);
        for (int k = 0; k < 3; k++) origin[k] += offset[k];
        random_direction(&r, direction);
        light_shape travels  = {.direction_ws = {-direction[0], -direction[1], -direction[2]}};
        int         expected = brute_first_hit(origin, direction, slack, &distance, &hit);
        if (expected < 0) continue;
        clear++;
        hits += expected;
        assert_int_equal(truth_lit(t, origin, &travels), !expected);
        uint32_t which;
        assert_int_equal(truth_first_hit(t, origin, direction, &found, normal, &which), expected);
        if (!expected) continue;
        assert_int_equal(which, hit);
        assert_true(fabs(found - distance) < 1e-3 * slack || fabs(vec3_dot(normal, direction)) < 2e-3);
        assert_true(fabs(vec3_dot(normal, normal) - 1) < 1e-12);
    }
    assert_true(clear > 2800 && hits > 500 && hits < 2500);
    truth_destroy(t);
}

static void rays_agree_with_brute_force(void **state)
{
    (void)state;
    compare_rays(100, (const double[]){0, 0, 0});
}

static void rays_agree_far_from_the_origin(void **state)
{
    (void)state;
    compare_rays(100, (const double[]){1e7, -2e7, 3e7});
}

static void rays_agree_at_any_size(void **state)
{
    (void)state;
    compare_rays(1e-9, (const double[]){0, 0, 0});
    compare_rays(1e12, (const double[]){0, 0, 0});
}

/* A ray from inside a closed surface to its edges and corners must not slip through. */
static void surfaces_are_watertight(void **state)
{
    (void)state;
    rng r = {29};
    start();
    sphere(0, 0, 0, 1, 40);
    solids_end_here();
    truth *t = make();
    for (int i = 0; i < 200000; i++) {
        double        from[3], way[3], target[3];
        size_t        which = rng_below(&r, (uint32_t)built.triangle_count);
        double        along = i % 2 ? 0 : uniform(&r);
        const double *a = corner_of(which, 0), *b = corner_of(which, 1);
        random_point(&r, 1.1, from);
        for (int k = 0; k < 3; k++) target[k] = (1 - along) * a[k] + along * b[k];
        vec3_sub(from, target, way);
        vec3_unit(way, way);
        assert_int_equal(lit(t, from[0], from[1], from[2], way), 0);
    }
    truth_destroy(t);
}

static void equal_triangles_are_told_by_index(void **state)
{
    (void)state;
    start();
    for (int i = 0; i < 50; i++) ground();
    const double down[3] = {0, -1, 0};
    truth       *t       = make();
    uint32_t     which;
    double       distance, normal[3];
    assert_int_equal(truth_first_hit(t, (const double[]){-5, 3, 7}, down, &distance, normal, &which), 1);
    assert_int_equal(which, 0);
    assert_true(distance == 3 && normal[0] == 0 && normal[1] == 1 && normal[2] == 0);
    assert_int_equal(truth_first_hit(t, (const double[]){5, 3, -7}, down, NULL, NULL, &which), 1);
    assert_int_equal(which, 1);
    assert_int_equal(truth_first_hit(t, (const double[]){5, -3, -7}, down, NULL, NULL, NULL), 0);
    truth_destroy(t);
}

/* A lifted point is not shadowed by its own surface, however slanted the sun and however far the world's origin. */
static void lifted_points_leave_their_surface(void **state)
{
    (void)state;
    rng r = {3};
    start();
    box(0, 0, 0, 10, 10, 10);
    move_all(1e7, 2e7, 1e7);
    truth *t = make();
    for (int i = 0; i < 20000; i++) {
        const double u[3] = {uniform(&r), uniform(&r), uniform(&r)};
        double       point[3], normal[3], to_sun[3];
        assert_int_equal(truth_sample_surface(t, u, point, normal, NULL), 1);
        random_direction(&r, to_sun);
        truth_lift(t, point, normal, point);
        double slope = vec3_dot(to_sun, normal);
        if (fabs(slope) < 1e-3) continue;
        const double travels[3] = {-to_sun[0], -to_sun[1], -to_sun[2]};
        assert_int_equal(lit(t, point[0], point[1], point[2], travels),
                         slope > 0); /* a convex solid shades just its own far side */
    }
    truth_destroy(t);
}

/* -- spot and point lights ------------------------------------------------------------------------------- */

static int lit_by_punctual(const truth *t, double x, double y, double z, const double light_ws[3])
{
    light_shape punctual = {.kind = LIGHT_POINT, .position_ws = {light_ws[0], light_ws[1], light_ws[2]}, .range_metres = 0.5};
    return truth_lit(t, (const double[]){x, y, z}, &punctual);
}

static void a_punctual_in_a_room_casts_the_shadows_drawn_by_hand(void **state)
{
    (void)state;
    const double hung[3] = {0, 3, 0}, in_the_ceiling[3] = {1, 4, 1}, in_the_pillar[3] = {2, 1, 0}, above[3] = {0, 1e6, 0};
    start();
    quad(vertex(-5, 0, -5), vertex(-5, 0, 5), vertex(5, 0, 5), vertex(5, 0, -5)); /* floor and ceiling, sheets */
    quad(vertex(-5, 4, -5), vertex(5, 4, -5), vertex(5, 4, 5), vertex(-5, 4, 5));
    box(1.5, 0, -0.5, 2.5, 2, 0.5);
    truth *t = make();

    /* the light is a metre above the pillar's top, whose far edge is 2.5 away: the shadow ends at 7.5, beyond the floor */
    assert_int_equal(lit_by_punctual(t, 4.9, 0.001, 0, hung), 0);
    assert_int_equal(lit_by_punctual(t, 4.9, 1.03, 0, hung), 0); /* 3 - 4.9 / 2.5 = 1.04 */
    assert_int_equal(lit_by_punctual(t, 4.9, 1.05, 0, hung), 1);
    assert_int_equal(lit_by_punctual(t, 4.9, 1.03, 1.7, hung), 1); /* beside it */
    assert_int_equal(lit_by_punctual(t, -4.9, 0, 4, hung), 1);     /* on the floor, farther than the range, which is not queried */
    assert_int_equal(lit_by_punctual(t, 0, 3.999, 4, hung), 1);    /* behind the light's back: points have none */
    assert_int_equal(lit_by_punctual(t, 0, 4.001, 0, hung), 0);
    assert_int_equal(lit_by_punctual(t, 0, -0.001, 0, hung), 0);
    assert_int_equal(lit_by_punctual(t, 100, 100, 100, hung), 0);
    assert_int_equal(lit_by_punctual(t, 30, 3.001, 0, hung), 1); /* out through the open side */
    assert_int_equal(lit_by_punctual(t, 0, 3, 0, hung), 1);      /* the light itself */

    assert_int_equal(lit_by_punctual(t, -4, 0, -4, in_the_ceiling), 1);
    assert_int_equal(lit_by_punctual(t, 1, 5, 1, in_the_ceiling), 1); /* a punctual light in a sheet shines to both sides */
    assert_int_equal(lit_by_punctual(t, 2, 0.5, 0, in_the_pillar), 1);
    assert_int_equal(lit_by_punctual(t, 3, 1, 0, in_the_pillar), 0);
    assert_int_equal(lit_by_punctual(t, 4.9, 0, 4, in_the_pillar), 0);

    assert_int_equal(lit_by_punctual(t, 0, 4.001, 0, above), 1);
    assert_int_equal(lit_by_punctual(t, 0, 3.999, 0, above), 0);
    assert_int_equal(lit_by_punctual(t, 0, 2e6, 0, above), 1); /* the light is between the point and the room */
    assert_int_equal(lit_by_punctual(t, 0, -2e6, 0, above), 0);
    assert_int_equal(lit_by_punctual(t, 0, -2e6, 1e300, above), 1);
    truth_destroy(t);
}

/* 1 no triangle between a point and a punctual light, 0 there is one, -1 too close to tell. */
static int brute_lit(const double point[3], const double punctual[3], double slack)
{
    double way[3], unit[3] = {0, 0, 0};
    int    doubt = 0;
    vec3_sub(punctual, point, way);
    vec3_unit(way, unit);
    double length = sqrt(vec3_dot(way, way));
    for (size_t t = 0; t < built.triangle_count; t++) {
        double margin, from_punctual, back[3] = {-unit[0], -unit[1], -unit[2]};
        double along    = intersect(t, point, unit, &margin); /* margins are those of the end that is nearer to the plane */
        double to_light = intersect(t, punctual, back, &from_punctual);
        margin          = fmin(margin, from_punctual);
        if (margin > slack && fmin(along, to_light) > slack) return 0;
        doubt |= fmin(along, to_light) > -slack && along < length + slack && margin > -slack;
    }
    return doubt ? -1 : 1;
}

/* Punctual lights `spread` times as far as the scene is large, and points in and about it. */
static void compare_punctuals(double size, const double offset[3], double spread, int dark_at_least)
{
    rng r = {37};
    start();
    random_triangles(&r, 2000);
    scale_all(size / 100);
    move_all(offset[0], offset[1], offset[2]);
    truth *t     = make();
    double slack = 4 * truth_precision(t);

    int clear = 0, dark = 0;
    for (int i = 0; i < 2000; i++) {
        light_shape punctual = {.kind = i % 2 ? LIGHT_POINT : LIGHT_SPOT, .range_metres = INFINITY, .outer_rad = 0.5};
        double      point[3];
        random_point(&r, 1.5 * size, point);
        random_point(&r, spread * size, punctual.position_ws);
        random_direction(&r, punctual.direction_ws);
        for (int k = 0; k < 3; k++) point[k] += offset[k], punctual.position_ws[k] += offset[k];
        int expected = brute_lit(point, punctual.position_ws, slack);
        if (expected < 0) continue;
        clear++;
        dark += !expected;
        assert_int_equal(truth_lit(t, point, &punctual), expected);
    }
    assert_true(clear > 1900 && dark > dark_at_least && dark < 1700);
    truth_destroy(t);
}

static void punctuals_agree_with_brute_force(void **state)
{
    (void)state;
    const double zero[3] = {0, 0, 0}, far[3] = {1e7, -2e7, 3e7};
    compare_punctuals(100, zero, 1, 200);
    compare_punctuals(100, zero, 0.01, 200); /* close together, amidst the scene */
    compare_punctuals(100, zero, 10, 200);
    compare_punctuals(100, zero, 1e6, 200);
    compare_punctuals(100, far, 1, 200);
    compare_punctuals(100, far, 1e3, 200);
    compare_punctuals(1e-9, zero, 1, 200);
    compare_punctuals(1e-6, zero, 1e9, 200);
    compare_punctuals(1e12, zero, 2, 200);
}

static void a_punctual_reaches_its_cone_and_range(void **state)
{
    (void)state;
    const double far = 1e7, pi = 3.14159265358979323846;
    light_shape  sun  = {.kind = LIGHT_DIRECTIONAL, .direction_ws = {0, -1, 0}};
    light_shape  spot = {
         .kind = LIGHT_SPOT, .position_ws = {far, 5, -far}, .direction_ws = {0.6, -0.8, 0}, .outer_rad = pi / 6, .range_metres = 10};
    light_shape punctual = {.kind = LIGHT_POINT, .position_ws = {far, 5, -far}, .direction_ws = {0, 0, -1}, .range_metres = 10};
    assert_int_equal(light_reaches(&sun, (const double[]){1e30, 1e30, -1e30}), 1);
    for (int degrees = -179; degrees <= 180; degrees++)
        for (int metres = 1; metres < 20; metres += 2) {
            double turned  = atan2(-0.8, 0.6) + degrees * pi / 180;
            double here[3] = {far + metres * cos(turned), 5 + metres * sin(turned), -far};
            assert_int_equal(light_reaches(&punctual, here), metres < 10);
            if (abs(degrees) != 30) assert_int_equal(light_reaches(&spot, here), metres < 10 && abs(degrees) < 30);
            spot.outer_rad = pi / 2;
            if (abs(degrees) != 90) assert_int_equal(light_reaches(&spot, here), metres < 10 && abs(degrees) < 90);
            spot.outer_rad = pi / 6;
        }
    assert_int_equal(light_reaches(&spot, (const double[]){far + 6, -3, -far}), 1); /* the range's end belongs to it */
    assert_int_equal(light_reaches(&spot, (const double[]){far, 5, -far}), 1);
    punctual.range_metres = INFINITY;
    assert_int_equal(light_reaches(&punctual, (const double[]){1e30, -1e30, 1e30}), 1);

    /* half a degree to each side */
    spot.outer_rad    = pi / 360;
    spot.range_metres = INFINITY;
    assert_int_equal(light_reaches(&spot, (const double[]){far + 600, -795, -far + 8.7}), 1);
    assert_int_equal(light_reaches(&spot, (const double[]){far + 600, -795, -far + 8.8}), 0);
}

/* -- holes ----------------------------------------------------------------------------------------------- */

enum { MASKED_MAX = 4000 };

/* Two images: a chequer of 2 x 2 pixels, and one of 4 x 4 for bilinear sampling. */
static uint8_t           chequer[] = {255, 0, 0, 255};
static uint8_t           clouds[]  = {0, 255, 255, 0, 255, 90, 20, 200, 180, 255, 255, 90, 0, 30, 200, 255};
static const alpha_image images[]  = {{2, 2, chequer}, {4, 4, clouds}};
static alpha_mask        masks[]   = {{.image = 0, .threshold = 0.5f, .wrap_u = WRAP_REPEAT, .wrap_v = WRAP_REPEAT, .nearest = 1},
                                      {.image = 1, .threshold = 0.6f, .wrap_u = WRAP_MIRROR, .wrap_v = WRAP_CLAMP},
                                      {.image = 1, .threshold = 0.3f, .wrap_u = WRAP_REPEAT, .wrap_v = WRAP_MIRROR}};
static size_t            alpha_mask_first[4];
static float             hole_uvs[6 * MASKED_MAX];

/* Triangles from here on are masked, by all three masks in turn; masks_end_here gives them their shares. */
static void masks_begin_here(void)
{
    built.holed_first      = built.triangle_count;
    built.alpha_mask_first = alpha_mask_first;
    built.alpha_masks      = masks;
    built.hole_uvs         = hole_uvs;
    built.images           = images;
}

static void masks_end_here(size_t of_first, size_t of_second)
{
    built.alpha_mask_count = 3;
    alpha_mask_first[0]    = built.holed_first;
    alpha_mask_first[1]    = alpha_mask_first[0] + of_first;
    alpha_mask_first[2]    = alpha_mask_first[1] + of_second;
    alpha_mask_first[3]    = built.triangle_count;
}

static void uvs_of_last(double ua, double va, double ub, double vb, double uc, double vc)
{
    assert_true(built.triangle_count - built.holed_first <= MASKED_MAX);
    float       *uv    = &hole_uvs[6 * (built.triangle_count - 1 - built.holed_first)];
    const double of[6] = {ua, va, ub, vb, uc, vc};
    for (int i = 0; i < 6; i++) uv[i] = (float)of[i];
}

/* The square [0, 4] x [0, 4] at height y, its image twice along x and once along z. */
static void chequered_square(double y)
{
    uint32_t v[4] = {vertex(0, y, 0), vertex(0, y, 4), vertex(4, y, 4), vertex(4, y, 0)};
    triangle(v[0], v[1], v[2]);
    uvs_of_last(0, 0, 0, 1, 2, 1);
    triangle(v[0], v[2], v[3]);
    uvs_of_last(0, 0, 2, 1, 2, 0);
}

/*    z   0     2     4
 *  x 0   # # # . . .
 *    1   . . . # # #      a cell is 1 by 2 metres
 *    2   # # # . . .
 *    3   . . . # # #  */
static void light_passes_holes_drawn_by_hand(void **state)
{
    (void)state;
    const double down[3] = {0, -1, 0}, up[3] = {0, 1, 0};
    start();
    ground();
    masks_begin_here();
    chequered_square(3);
    masks_end_here(2, 0);
    truth *t = make();
    for (int x = 0; x < 4; x++)
        for (int z = 0; z < 4; z++) {
            int      hole = (x + z / 2) % 2;
            uint32_t which;
            double   distance, normal[3];
            assert_int_equal(lit(t, x + 0.49, 1, z + 0.52, down), hole);
            assert_int_equal(lit_by_punctual(t, x + 0.49, 1, z + 0.52, (const double[]){x + 0.49, 50, z + 0.52}), hole);
            assert_int_equal(lit_by_punctual(t, x + 0.49, 1, z + 0.52, (const double[]){x + 0.49, 2.9, z + 0.52}), 1);
            assert_int_equal(truth_first_hit(t, (const double[]){x + 0.49, 5, z + 0.52}, down, &distance, normal, &which), 1);
            assert_true(distance == (hole ? 5 : 2) && normal[1] == 1 && (which < 2) == hole);
            assert_int_equal(truth_first_hit(t, (const double[]){x + 0.49, 1, z + 0.52}, up, NULL, NULL, NULL), !hole);
        }
    truth_destroy(t);
}

/* Whether a masked triangle has a surface at weights of its second and third corner: -1 where a small step decides. */
static int brute_opaque(size_t t, double second, double third, double step)
{
    const float *uv   = &hole_uvs[6 * (t - built.holed_first)];
    int          mask = t >= alpha_mask_first[2] ? 2 : t >= alpha_mask_first[1] ? 1 : 0, sum = 0;
    for (int i = 0; i < 9; i++) {
        double b = second + step * (i % 3 - 1), c = third + step * (i / 3 - 1), a = 1 - b - c;
        double u = a * (double)uv[0] + b * (double)uv[2] + c * (double)uv[4];
        double v = a * (double)uv[1] + b * (double)uv[3] + c * (double)uv[5];
        sum += alpha_mask_opaque(&masks[mask], &images[masks[mask].image], u, v);
    }
    return sum == 0 ? 0 : sum == 9 ? 1 : -1;
}

/* The nearest surface along a ray, in double. Returns 1, 0, or -1 where that is too close to tell. */
static int brute_first_opaque(const double origin[3], const double direction[3], double slack, size_t *hit)
{
    double nearest = INFINITY, doubtful = INFINITY;
    for (size_t t = 0; t < built.triangle_count; t++) {
        double margin, here = intersect(t, origin, direction, &margin), from_corner[3], ab[3], ac[3], n[3], c[3];
        int    opaque = 1;
        if (margin < -slack) continue;
        vec3_sub(corner_of(t, 1), corner_of(t, 0), ab);
        vec3_sub(corner_of(t, 2), corner_of(t, 0), ac);
        vec3_cross(ab, ac, n);
        for (int i = 0; i < 3; i++) from_corner[i] = origin[i] + here * direction[i] - corner_of(t, 0)[i];
        if (t >= built.holed_first) {
            vec3_cross(from_corner, ac, c);
            double second = vec3_dot(c, n) / vec3_dot(n, n);
            vec3_cross(ab, from_corner, c);
            double third   = vec3_dot(c, n) / vec3_dot(n, n);
            double steep   = fabs(vec3_dot(n, direction)) / sqrt(vec3_dot(n, n));
            double longest = sqrt(fmax(vec3_dot(ab, ab), vec3_dot(ac, ac)));
            opaque         = brute_opaque(t, second, third, slack / steep * longest / sqrt(vec3_dot(n, n)));
        }
        if (opaque < 0 || (margin <= slack && opaque)) doubtful = fmin(doubtful, here);
        if (opaque == 1 && margin > slack && here < nearest) nearest = here, *hit = t;
    }
    if (doubtful < nearest + slack) return -1;
    return nearest < INFINITY;
}

static void rays_through_holes_agree_with_brute_force(void **state)
{
    (void)state;
    rng r = {41};
    start();
    random_triangles(&r, 200);
    masks_begin_here();
    for (int i = 0; i < 2000; i++) {
        random_triangles(&r, 1);
        double uv[6];
        for (int k = 0; k < 6; k++) uv[k] = 4 * uniform(&r) - 1.5;
        uvs_of_last(uv[0], uv[1], uv[2], uv[3], uv[4], uv[5]);
    }
    masks_end_here(700, 600);
    move_all(1e5, 0, -1e5);
    truth *t     = make();
    double slack = 2 * truth_precision(t);

    int clear = 0, hits = 0, masked_hits = 0;
    for (int i = 0; i < 3000; i++) {
        double origin[3], direction[3];
        size_t hit = 0;
        random_point(&r, 150, origin);
        origin[0] += 1e5, origin[2] -= 1e5;
        random_direction(&r, direction);
        int expected = brute_first_opaque(origin, direction, slack, &hit);
        if (expected < 0) continue;
        uint32_t which;
        clear++;
        hits += expected;
        assert_int_equal(lit(t, origin[0], origin[1], origin[2], (const double[]){-direction[0], -direction[1], -direction[2]}),
                         !expected);
        assert_int_equal(truth_first_hit(t, origin, direction, NULL, NULL, &which), expected);
        if (!expected) continue;
        assert_int_equal(which, hit);
        masked_hits += hit >= built.holed_first;
    }
    assert_true(clear > 2800 && hits > 400 && hits < 2000 && masked_hits > 300);
    truth_destroy(t);
}

static void surface_points_are_not_in_holes(void **state)
{
    (void)state;
    enum { SAMPLES = 40000 };
    rng r = {43};
    start();
    quad(vertex(10, 0, 0), vertex(10, 0, 4), vertex(14, 0, 4), vertex(14, 0, 0)); /* as large, without holes */
    masks_begin_here();
    chequered_square(3);
    masks_end_here(2, 0);
    truth *t    = make();
    int    full = 0, cells[4][2] = {0};
    for (int i = 0; i < SAMPLES; i++) {
        const double u[3] = {uniform(&r), uniform(&r), uniform(&r)};
        double       p[3];
        uint32_t     which;
        assert_int_equal(truth_sample_surface(t, u, p, NULL, &which), 1);
        assert_true((which < 2) == (p[1] == 0));
        if (which < 2)
            full++;
        else
            cells[(int)p[0]][(int)(p[2] / 2)]++;
    }
    /* two thirds without holes, one third in four of the eight cells */
    assert_true(fabs(full - SAMPLES * 2 / 3.0) < 6 * sqrt(SAMPLES * 2 / 9.0));
    for (int i = 0; i < 8; i++) {
        int found = cells[i / 2][i % 2];
        assert_true((i / 2 + i) % 2 ? found == 0 : fabs(found - SAMPLES / 12.0) < 6 * sqrt(SAMPLES / 12.0));
    }
    truth_destroy(t);
}

static void a_surface_of_holes_has_no_points(void **state)
{
    (void)state;
    uint8_t           full[] = {255}, nothing[] = {0};
    const alpha_image empty[] = {{1, 1, full}, {1, 1, nothing}}; /* the first mask has no triangle */
    start();
    masks_begin_here();
    built.images = empty;
    chequered_square(3);
    masks_end_here(0, 1);
    truth *t = make();
    double p[3];
    assert_int_equal(truth_sample_surface(t, (const double[]){0.5, 0.5, 0.5}, p, NULL, NULL), 0);
    assert_int_equal(lit(t, 1, 0, 1, (const double[]){0, -1, 0}), 1);
    truth_destroy(t);
}

/* -- inside ---------------------------------------------------------------------------------------------- */

static int in_box(const double p[3], const double b[6])
{
    for (int i = 0; i < 3; i++)
        if (p[i] < b[i] || p[i] > b[i + 3]) return 0;
    return 1;
}

static void inside_agrees_with_analytic_solids(void **state)
{
    (void)state;
    /* apart, nested, intersecting, and touching along a face */
    static const double boxes[5][6] = {
        {-9, -9, -9, -5, -5, -5}, {-8, -8, -8, -6, -6, -6}, {0, 0, 0, 4, 4, 4}, {2, 2, 2, 6, 6, 6}, {6, 2, 2, 8, 6, 6}};
    static const double balls[3][4] = {{-5, 5, 5, 3}, {-5, 5, 5, 1}, {-3, 5, 5, 2}};
    const double        offset[3]   = {1e7, 0, -1e7};
    rng                 r           = {11};

    start();
    for (int i = 0; i < 5; i++) box(boxes[i][0], boxes[i][1], boxes[i][2], boxes[i][3], boxes[i][4], boxes[i][5]);
    for (int i = 0; i < 3; i++) sphere(balls[i][0], balls[i][1], balls[i][2], balls[i][3], 48);
    solids_end_here();
    sphere(5, -5, -5, 3, 20); /* a closed sheet has no inside */
    ground();
    move_all(offset[0], offset[1], offset[2]);
    truth *t = make();

    int    inside = 0, asked = 0;
    double slack = 4 * truth_precision(t);
    for (int i = 0; i < 40000; i++) {
        double p[3];
        random_point(&r, 20, p);
        int expected = 0, near = 0;
        for (int b = 0; b < 5; b++) {
            double larger[6], smaller[6];
            for (int k = 0; k < 6; k++) {
                larger[k]  = boxes[b][k] + (k < 3 ? -slack : slack);
                smaller[k] = boxes[b][k] + (k < 3 ? slack : -slack);
            }
            expected |= in_box(p, boxes[b]);
            near |= in_box(p, larger) && !in_box(p, smaller);
        }
        for (int b = 0; b < 3; b++) {
            double d[3];
            vec3_sub(p, balls[b], d);
            double distance = sqrt(vec3_dot(d, d));
            expected |= distance < balls[b][3];
            near |=
                distance < balls[b][3] + slack && distance > 0.99 * balls[b][3]; /* the mesh is a little smaller than its sphere */
        }
        if (near) continue;
        asked++;
        for (int k = 0; k < 3; k++) p[k] += offset[k];
        assert_int_equal(truth_inside_solid(t, p), expected);
        inside += expected;
    }
    assert_true(asked > 38000 && inside > 1500);
    assert_int_equal(truth_inside_solid(t, (const double[]){1e9, 0, 0}), 0);
    truth_destroy(t);
}

/* The first directions that truth_inside_solid queries along. */
static const double asked_along[2][3] = {{0.270598050073, 0.900968867902, 0.339164873902},
                                         {-0.629320391050, 0.611507863021, -0.479585031072}};

/* One direction queried along meets edges and corners of two intersecting balls: the others have to put it right. */
static void inside_survives_a_direction_through_edges(void **state)
{
    (void)state;
    rng r = {5};
    start();
    sphere(0, 0, 0, 1, 24);
    sphere(0.3, 0, 0, 1, 24);
    solids_end_here();
    truth *t = make();
    for (int i = 0; i < 20000; i++) {
        size_t which = rng_below(&r, (uint32_t)built.triangle_count);
        double along = i % 3 ? uniform(&r) : 0, back = 3 * uniform(&r), p[3];
        for (int k = 0; k < 3; k++)
            p[k] = (1 - along) * corner_of(which, 0)[k] + along * corner_of(which, 1)[k] - back * asked_along[0][k];
        double from_first = sqrt(vec3_dot(p, p)), from_second = sqrt((p[0] - 0.3) * (p[0] - 0.3) + p[1] * p[1] + p[2] * p[2]);
        double nearer = fmin(from_first, from_second);
        if (nearer > 0.98 && nearer < 1.001) continue;
        assert_int_equal(truth_inside_solid(t, p), nearer < 1);
    }
    truth_destroy(t);
}

/* A tetrahedron that a ray from 0 along `way` enters through one edge and leaves through the opposite one. */
static void tetrahedron_on_edge(rng *r, const double way[3])
{
    uint32_t v[4];
    double   across[2][3], any[3];
    random_direction(r, any);
    vec3_cross(way, any, across[0]);
    vec3_cross(way, across[0], across[1]);
    for (int i = 0; i < 4; i++) {
        double from_axis = (i % 2 ? -1 : 1) * (0.2 + uniform(r)), p[3];
        for (int k = 0; k < 3; k++) p[k] = (2 + i / 2) * way[k] + from_axis * across[i / 2][k];
        v[i] = vertex(p[0], p[1], p[2]);
    }
    triangle(v[0], v[2], v[1]);
    triangle(v[0], v[1], v[3]);
    triangle(v[0], v[3], v[2]);
    triangle(v[1], v[2], v[3]);
}

/* Two directions that miscount would outvote the others: both must be noticed. */
static void inside_survives_two_directions_through_edges(void **state)
{
    (void)state;
    const double zero[3] = {0, 0, 0};
    rng          r       = {31};
    for (int i = 0; i < 300; i++) {
        start();
        for (int k = 0; k < 2; k++) {
            double way[3] = {0};
            vec3_unit(asked_along[k], way);
            tetrahedron_on_edge(&r, way);
        }
        solids_end_here();
        truth *t = make();
        assert_int_equal(truth_inside_solid(t, zero), 0);
        truth_destroy(t);
    }
}

/* -- surface points -------------------------------------------------------------------------------------- */

static void surface_points_are_uniform_by_area(void **state)
{
    (void)state;
    enum { SAMPLES = 200000, CELLS = 10 };
    rng r = {17};
    start();
    triangle(vertex(0, 0, 0), vertex(0, 0, 0), vertex(0, 0, 0)); /* no area: never chosen */
    quad(vertex(0, 0, 0), vertex(0, 0, 10), vertex(10, 0, 10), vertex(10, 0, 0));
    quad(vertex(0, 5, 0), vertex(0, 5, 2), vertex(1, 5, 2), vertex(1, 5, 0)); /* 2 of 102 square metres */
    triangle(0, 1, 2);
    truth *t = make();

    int cells[CELLS][CELLS] = {0}, small = 0;
    for (int i = 0; i < SAMPLES; i++) {
        const double u[3] = {uniform(&r), uniform(&r), uniform(&r)};
        double       p[3], normal[3];
        uint32_t     which;
        assert_int_equal(truth_sample_surface(t, u, p, normal, &which), 1);
        assert_true(normal[0] == 0 && normal[1] == 1 && normal[2] == 0);
        assert_true(which >= 1 && which <= 4);
        assert_true(p[1] == (which < 3 ? 0 : 5));
        if (which < 3)
            cells[(int)p[2]][(int)p[0]]++;
        else
            small++;
    }

    /* chi-square of 99 degrees of freedom: mean 99, deviation 14 */
    double expected = SAMPLES / 102.0, chi2 = 0;
    for (int i = 0; i < CELLS * CELLS; i++) {
        double excess = cells[i / CELLS][i % CELLS] - expected;
        chi2 += excess * excess / expected;
    }
    assert_true(chi2 > 40 && chi2 < 180);
    assert_true(fabs(small - 2 * expected) < 6 * sqrt(2 * expected));

    double   p[3];
    uint32_t which;
    assert_int_equal(truth_sample_surface(t, (const double[]){0, 0, 0}, p, NULL, &which), 1);
    assert_int_equal(which, 1);
    assert_int_equal(truth_sample_surface(t, (const double[]){nextafter(1, 0), 0, 0}, p, NULL, &which), 1);
    assert_int_equal(which, 4);
    truth_destroy(t);
}

static void casters_without_area_have_no_surface_points(void **state)
{
    (void)state;
    start();
    triangle(vertex(1, 0, 0), vertex(2, 0, 0), vertex(3, 0, 0));
    truth *t = make();
    double p[3];
    assert_int_equal(truth_sample_surface(t, (const double[]){0.5, 0.5, 0.5}, p, NULL, NULL), 0);
    truth_destroy(t);
}

/* -- creation -------------------------------------------------------------------------------------------- */

static void hopeless_casters_are_refused(void **state)
{
    (void)state;
    run_context none = {0}, infinite = {0};
    truth      *t;
    start();
    assert_int_equal(truth_create(&t, &built, 1, &none), VXS_E_NO_CASTER);
    assert_null(t);
    triangle(vertex(0, 0, 0), vertex(1, 0, 0), vertex(0, INFINITY, 0));
    assert_int_equal(truth_create(&t, &built, 1, &infinite), VXS_E_SCENE);
    assert_string_equal(infinite.error, "triangle 0 has a position that is not finite");
    assert_null(t);
    truth_destroy(NULL);
}

/* -- the parallel loop ----------------------------------------------------------------------------------- */

enum { ITEMS = 1000 };

typedef struct visits {
    atomic_int seen[ITEMS];
    atomic_int busy[PARALLEL_THREADS_MAX];
    atomic_int wrong;
    uint32_t   threads;
    size_t     grain;
} visits;

static void visit(void *user, size_t begin, size_t end, uint32_t worker)
{
    visits *v = user;
    if (worker >= v->threads || atomic_fetch_add(&v->busy[worker], 1) || begin % v->grain || end - begin > v->grain || begin >= end)
        v->wrong++;
    for (size_t i = begin; i < end; i++) v->seen[i]++;
    atomic_fetch_sub(&v->busy[worker], 1);
}

static void every_item_is_visited_once(void **state)
{
    (void)state;
    static visits  v;
    const uint32_t threads[] = {1, 2, 3, 16, PARALLEL_THREADS_MAX};
    const size_t   grains[] = {1, 7, 250, 999, 1000, 5000}, counts[] = {0, 1, 7, 8, 999, 1000};
    for (size_t a = 0; a < 5; a++)
        for (size_t b = 0; b < 6; b++)
            for (size_t c = 0; c < 6; c++) {
                memset(&v, 0, sizeof v);
                v.threads = threads[a];
                v.grain   = grains[b];
                parallel_for(threads[a], counts[c], grains[b], visit, &v);
                assert_int_equal(v.wrong, 0);
                for (size_t i = 0; i < ITEMS; i++) assert_int_equal(v.seen[i], i < counts[c]);
            }
    memset(&v, 0, sizeof v);
    v.threads = 1;
    v.grain   = 1;
    parallel_for(0, 10, 0, visit, &v); /* no threads and no grain mean one of each */
    assert_true(v.wrong == 0 && v.seen[9] == 1 && v.seen[10] == 0);
    assert_in_range(parallel_default_threads(), 1, PARALLEL_THREADS_MAX);
}

typedef struct questions {
    const truth *truth;
    double       points[ITEMS][3];
    double       answers[ITEMS][3];
} questions;

static void answer(void *user, size_t begin, size_t end, uint32_t worker)
{
    questions *q = user;
    (void)worker;
    for (size_t i = begin; i < end; i++) {
        light_shape down = {.kind = LIGHT_DIRECTIONAL, .direction_ws = {0, -1, 0}};
        q->answers[i][0] = truth_lit(q->truth, q->points[i], &down);
        q->answers[i][1] = truth_inside_solid(q->truth, q->points[i]);
        if (!truth_first_hit(q->truth, q->points[i], down.direction_ws, &q->answers[i][2], NULL, NULL)) q->answers[i][2] = -1;
    }
}

static void threads_change_no_answer(void **state)
{
    (void)state;
    static questions one, many;
    rng              r = {23};
    start();
    sphere(0, 0, 0, 20, 60);
    solids_end_here();
    random_triangles(&r, 2000);
    for (int i = 0; i < ITEMS; i++) random_point(&r, 100, one.points[i]);
    memcpy(many.points, one.points, sizeof one.points);

    run_context m = {0};
    truth      *alone;
    assert_int_equal(truth_create(&alone, &built, 1, &m), VXS_OK);
    one.truth = alone;
    parallel_for(1, ITEMS, 10, answer, &one);
    truth *shared = make();
    many.truth    = shared;
    parallel_for(8, ITEMS, 10, answer, &many);
    assert_memory_equal(one.answers, many.answers, sizeof one.answers);
    truth_destroy(alone);
    truth_destroy(shared);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_box_on_the_ground_casts_the_shadow_drawn_by_hand),
        cmocka_unit_test(rays_agree_with_brute_force),
        cmocka_unit_test(rays_agree_far_from_the_origin),
        cmocka_unit_test(rays_agree_at_any_size),
        cmocka_unit_test(surfaces_are_watertight),
        cmocka_unit_test(equal_triangles_are_told_by_index),
        cmocka_unit_test(lifted_points_leave_their_surface),
        cmocka_unit_test(a_punctual_in_a_room_casts_the_shadows_drawn_by_hand),
        cmocka_unit_test(punctuals_agree_with_brute_force),
        cmocka_unit_test(a_punctual_reaches_its_cone_and_range),
        cmocka_unit_test(light_passes_holes_drawn_by_hand),
        cmocka_unit_test(rays_through_holes_agree_with_brute_force),
        cmocka_unit_test(surface_points_are_not_in_holes),
        cmocka_unit_test(a_surface_of_holes_has_no_points),
        cmocka_unit_test(inside_agrees_with_analytic_solids),
        cmocka_unit_test(inside_survives_a_direction_through_edges),
        cmocka_unit_test(inside_survives_two_directions_through_edges),
        cmocka_unit_test(surface_points_are_uniform_by_area),
        cmocka_unit_test(casters_without_area_have_no_surface_points),
        cmocka_unit_test(hopeless_casters_are_refused),
        cmocka_unit_test(every_item_is_visited_once),
        cmocka_unit_test(threads_change_no_answer),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
