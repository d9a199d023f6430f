/* The bias of lookups with a normal (formats/vxs_space.h): taps lie before the plane of the surface, and not farther than they
 * must; baked planes do not shade themselves.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/truth/truth.h"
#include "baker/light/map_space.h"
#include "formats/vxs_space.h"
#include "random_light.h"
#include "repeats.h"
#include "tests/bench/bias_stage.h"

/* last: cmocka's macro fail() hides the function of run_context.h, and it needs the four headers above */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

static const vxs_filter filters[] = {{1, 0}, {3, 0}, {5, 0}, {9, 0}, {17, 0}, {1, 1}, {2, 1}, {9, 1}, {16, 1}, {17, 1}};
enum { FILTERS = sizeof filters / sizeof *filters };

/* A light, a point that it reaches, and a normal. */
typedef struct question {
    vxs_light  light;
    int        map;
    double     point[3], normal[3];
    double     at[3]; /* the point in the map */
    double     along; /* of the light's way there along the normal: below 0 where the surface faces the light */
    vxs_filter filter;
} question;

/* Voxels are as deep as texels are wide, or up to a hundred times deeper. */
static vxs_light random_sun(rng *r)
{
    vxs_light l = {.kind = VXS_LIGHT_KIND_DIRECTIONAL, .levels = 6 + rng_below(r, 9)};
    double    axis[3][3];
    bias_random_axes(r, axis);
    l.texel_metres = pow(10, uniform(r, -3, 1));
    l.voxel_metres = l.texel_metres * (rng_below(r, 2) ? 1 : pow(10, uniform(r, 0, 2)));
    for (int row = 0; row < 3; row++)
        for (int n = 0; n < 3; n++) l.ls_from_ws[4 * row + n] = axis[row][n] / (row < 2 ? l.texel_metres : l.voxel_metres);
    for (int row = 0; row < 3; row++) l.ls_from_ws[4 * row + 3] = uniform(r, 0, ldexp(1, (int)l.levels));
    memcpy(l.direction_ws, axis[2], sizeof axis[2]);
    return l;
}

/* Returns 0 where the light does not reach the point, or a punctual light's map has a border that is too narrow for every bias. */
static int ask(rng *r, question *q)
{
    double side, way[3], ahead[3];
    int    punctuals = (int)rng_below(r, 4);
    q->light         = punctuals < PUNCTUAL_SHAPES ? random_punctual(r, (punctual_shape)punctuals).light : random_sun(r);
    side             = ldexp(1, (int)q->light.levels);
    if (q->light.kind != VXS_LIGHT_KIND_DIRECTIONAL) q->light.voxel_metres = fmax(q->light.voxel_metres, q->light.texel_metres);
    int face = (int)rng_below(r, q->light.flags & VXS_LIGHT_CUBE ? 6 : 1);
    for (int n = 0; n < 3; n++) q->at[n] = uniform(r, 0, side);
    vxs_point(&q->light, face, q->at, q->point);
    vxs_point(&q->light, face, (double[3]){q->at[0], q->at[1], q->at[2] + 0.01}, ahead);
    for (int n = 0; n < 3; n++) way[n] = ahead[n] - q->point[n];
    make_unit(way);
    random_direction(r, q->normal);
    if (rng_below(r, 8) == 0) memcpy(q->normal, way, sizeof way); /* straight behind the light */
    q->along  = dot(q->normal, way);
    q->filter = filters[rng_below(r, FILTERS)];
    int32_t voxel[3];
    q->map = vxs_voxel(&q->light, q->point, NULL, vxs_box(1), voxel);
    return q->map == face && q->light.levels >= 8 && fabs(q->along) > 1e-3;
}

/* The depth at which the light's ray through texel coordinates meets the plane, or INFINITY: it does not. */
static double plane_depth(const question *q, double u, double v)
{
    double ends[2][3], way[3], to_plane[3], hit[3], found[3];
    for (int n = 0; n < 2; n++) vxs_point(&q->light, q->map, (double[3]){u, v, q->at[2] + n}, ends[n]);
    vec3_sub(ends[1], ends[0], way);
    vec3_sub(q->point, ends[0], to_plane);
    double sinks = dot(way, q->normal);
    if (sinks * q->along <= 0) return INFINITY;
    vec3_mad(ends[0], dot(to_plane, q->normal) / sinks, way, hit);
    baked_light_coordinates(&q->light, q->map, hit, found);
    return found[2];
}

static void taps_lie_before_the_plane(void **state)
{
    (void)state;
    rng r      = {41};
    int fronts = 0, backs = 0, held = 0;
    for (uint32_t n = 0; n < repeats(100000, 1000000); n++) {
        question q;
        if (!ask(&r, &q)) continue;
        filter_taps taps = filter_taps_of(&q.light, q.point, q.normal, q.filter);
        int32_t     side = (int32_t)1 << q.light.levels, voxel[3];
        if (vxs_voxel(&q.light, q.point, q.normal, q.filter, voxel) != q.map) continue;
        if (q.light.kind != VXS_LIGHT_KIND_DIRECTIONAL &&
            (voxel[0] <= 0 || voxel[1] <= 0 || voxel[0] >= side - 1 || voxel[1] >= side - 1)) {
            held++;
            continue;
        }
        double nearest = INFINITY, farthest = -INFINITY, rounding = 1e-9 * fmax(1, fabs(q.at[2]));
        for (int tap = 0; tap < taps.count[0] * taps.count[1]; tap++) {
            double depth = plane_depth(&q, taps.first[0] + tap % taps.count[0] + 0.5, taps.first[1] + tap / taps.count[0] + 0.5);
            nearest      = fmin(nearest, depth);
            farthest     = fmax(farthest, isinf(depth) ? -INFINITY : depth);
        }
        /* a texel of which a smooth filter covers less than 1/256 counts for the bias, and is no tap */
        int sliver = 0;
        for (int axis = 0; axis < 2; axis++) sliver |= q.filter.is_smooth && 2 * q.at[axis] - floor(2 * q.at[axis]) < 2 / 256.0;
        double own   = floor(q.at[2]),
               slack = 3 * VXS_BIAS_SLACK * (1 + q.light.texel_metres / q.light.voxel_metres * fabs(1 / q.along));
        if (q.along < 0) { /* far sides before the plane; not more than a voxel too near, but for the slack */
            assert_true(voxel[2] + 1 <= nearest + rounding);
            assert_true(voxel[2] == own || voxel[2] + 2 + slack > nearest || sliver);
            fronts++;
        } else {
            assert_true(isinf(farthest) || voxel[2] >= farthest - fmax(rounding, 1e-2 * q.light.texel_metres));
            backs++;
        }
    }
    assert_true(fronts > 20000 && backs > 20000 && held < fronts / 10);
}

/* A step along the light is at most the share of the filter's width that vxs_space.h says, and two voxels; one across at most what
 * the corner of a filter needs. */
static void steps_are_short(void **state)
{
    (void)state;
    rng r     = {42};
    int asked = 0;
    for (uint32_t n = 0; n < repeats(100000, 1000000); n++) {
        question q;
        if (!ask(&r, &q)) continue;
        vxs_place place = vxs_place_from_ws(&q.light, q.point, q.normal, q.filter);
        double    ratio = q.light.texel_metres / q.light.voxel_metres, reach = vxs_filter_reach(q.filter) + 0.5 + VXS_BIAS_SLACK;
        double    most = VXS_BIAS_ALONG * vxs_filter_width(q.filter) * ratio + 2 + VXS_BIAS_SLACK;
        if (place.map < 0) continue;
        assert_true(fabs(place.voxel[2] - floor(q.at[2])) <= most + 1e-6);
        for (int axis = 0; axis < 2; axis++) assert_true(fabs(place.voxel[axis] - floor(q.at[axis])) <= 1.2072 * reach + 1.5);
        asked++;
    }
    assert_true(asked > 40000);
}

/* What faces the light is moved by a voxel and nothing else; a normal's length does not matter, and one that is
 * none moves nothing. */
static void simple_steps(void **state)
{
    (void)state;
    vxs_light l    = {.kind         = VXS_LIGHT_KIND_DIRECTIONAL,
                      .levels       = 6,
                      .texel_metres = 0.5,
                      .voxel_metres = 1,
                      .direction_ws = {0, -1, 0},
                      .ls_from_ws   = {2, 0, 0, 0, 0, 0, 2, 0, 0, -1, 0, 40}};
    double    p[3] = {10.2, 9.5, 10.2}; /* (20.4, 20.4, 30.5) */
    struct {
        double  normal[3];
        int32_t width_px, voxel[3];
    } cases[] = {
        {{0, 1, 0}, 1, {20, 20, 29}},           {{0, 1, 0}, 17, {20, 20, 29}},
        {{0, -1, 0}, 9, {20, 20, 31}}, /* the floor, the ceiling */
        {{1, 0, 0}, 1, {20, 20, 30}},           {{1, 0, 0}, 9, {24, 20, 30}},
        {{-1, 0, 0}, 9, {15, 20, 30}}, /* walls along the light */
        {{0, 0, -1}, 17, {20, 11, 30}},         {{0, 1e-3, 0}, 9, {20, 20, 29}},
        {{1e30, 0, 0}, 9, {24, 20, 30}},        {{0, 0, 0}, 9, {20, 20, 30}},
        {{(double)NAN, 1, 0}, 9, {20, 20, 30}},
    };
    for (size_t n = 0; n < sizeof cases / sizeof *cases; n++) {
        int32_t voxel[3];
        assert_int_equal(vxs_voxel(&l, p, cases[n].normal, vxs_box(cases[n].width_px), voxel), 0);
        for (int axis = 0; axis < 3; axis++)
            if (voxel[axis] != cases[n].voxel[axis])
                fail_msg("case %zu, axis %d: %d, expected %d", n, axis, voxel[axis], cases[n].voxel[axis]);
    }
}

/* Baked, with and without a fixture near the light: no point of a plane that nothing shades is dark, and little light leaks to its
 * back. */
static void planes_do_not_shade_themselves(void **state)
{
    static const double others_metres[] = {0, 0.03, 0.005};
    (void)state;
    int    asked  = 0;
    double leaked = 0;
    for (int kind = 0; kind < 3; kind++)
        for (int other = 0; other < 3; other++)
            for (uint32_t stage = 0; stage < repeats(4, 40); stage++) {
                bias_setup o = {.kind                = (vxs_bake_light_kind)kind,
                                .side_px             = stage % 2 ? 256 : 2048,
                                .other_caster_metres = others_metres[other],
                                .coding              = stage / 2 % 2 ? VXS_BAKE_DAG : VXS_BAKE_BLOCKS};
                if (kind == VXS_BAKE_DIRECTIONAL) o.other_caster_metres *= 2e4;
                bias_stage             s     = bias_stage_make(&o, stage);
                vxs_asset             *asset = bias_stage_bake(&s, &o);
                const vxs_baked_light *baked = vxs_asset_light(asset, 0);
                const double          *up = s.axes_ws[2], down[3] = {-up[0], -up[1], -up[2]};
                rng                    r = {stage};
                for (int n = 0; n < 1000; n++) {
                    double     p[3];
                    vxs_filter filter = filters[n % FILTERS];
                    bias_draw_point(&s, &o, &r, p);
                    float front = vxs_lookup(baked, p, up, filter), back = vxs_lookup(baked, p, down, filter);
                    if (front == VXS_OUTSIDE) continue;
                    if (front < 1 &&
                        !(kind == VXS_BAKE_SPOT && other)) /* a spot's fixture is in its cone: it may be under the filter */
                        fail_msg("kind %d, other caster %g m, stage %u, filter %d, smooth %d: %g", kind, o.other_caster_metres,
                                 stage, filter.width_px, filter.is_smooth, (double)front);
                    leaked += back > 0 ? (double)back : 0;
                    asked++;
                }
                vxs_asset_close(asset);
            }
    assert_true(asked > 20000 && leaked / asked < 0.01);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(taps_lie_before_the_plane),
        cmocka_unit_test(steps_are_short),
        cmocka_unit_test(simple_steps),
        cmocka_unit_test(planes_do_not_shade_themselves),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
