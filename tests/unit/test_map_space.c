/* The space of a light's maps, and what of a triangle lies in it, against points of random triangles (baker/light/map_space.h).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "baker/light/map_space.h" /* before cmocka, whose fail() is a macro */
#include "runtime/vxs.h"
#include "tests/unit/random_light.h"

#include "baker/base/box.h" /* after vxs_space.h, which has variables of that name */

#include <cmocka.h>

/* A light of any kind; of a directional one `punctual` holds no more than the light. */
static punctual random_light(rng *r, int kind)
{
    if (kind < PUNCTUAL_SHAPES) return random_punctual(r, (punctual_shape)kind);
    punctual l    = random_punctual(r, SPOT);
    double   unit = uniform(r, 0.01, 2), deep = uniform(r, 0.01, 2);
    l.light.kind      = VXS_LIGHT_KIND_DIRECTIONAL;
    l.light.cos_outer = l.light.near_metres = 0;
    for (int n = 0; n < 12; n++) l.light.ls_from_ws[n] /= n < 8 ? unit : deep;
    for (int row = 0; row < 3; row++) l.light.ls_from_ws[4 * row + 3] = uniform(r, -10, 10);
    l.light.texel_metres = unit;
    l.light.voxel_metres = deep;
    return l;
}

enum { KINDS = PUNCTUAL_SHAPES + 1 };

/* How far within the sides a point of map space is, in texels of the map that it is seen at: by division, where the code under test
 * multiplies. Below 0: outside. The light's own side counts in shares of the nearest distance that is kept. */
static double within_by(const vxs_light *light, const double p[3], double beyond_px)
{
    double half = ldexp(0.5, (int)light->levels), inside;
    if (light->kind == VXS_LIGHT_KIND_DIRECTIONAL) return fmin(half - fabs(p[0] - half), half - fabs(p[1] - half)) + beyond_px;
    if (!(p[2] > 0)) return p[2] < 0 ? -INFINITY : -1;
    inside = half + beyond_px - fmax(fabs(p[0]), fabs(p[1])) / p[2] / light->texel_metres;
    return fmin(inside, p[2] / light->near_metres * 1024 - 1);
}

/* A point of the map's space from texels and a distance; any of the three may be far out. */
static void random_corner(rng *r, const vxs_light *light, double out[3])
{
    double side = ldexp(1, (int)light->levels), reach = rng_below(r, 2) ? 3 : 0.6;
    double u = uniform(r, -reach, reach) * side, v = uniform(r, -reach, reach) * side;
    if (light->kind == VXS_LIGHT_KIND_DIRECTIONAL) {
        out[0] = side / 2 + u, out[1] = side / 2 + v, out[2] = uniform(r, -3, 3);
        return;
    }
    double z = light->near_metres * pow(10, uniform(r, -4, 3));
    if (!rng_below(r, 4)) z = -z;
    out[0] = u * light->texel_metres * fabs(z);
    out[1] = v * light->texel_metres * fabs(z);
    out[2] = z;
    if (!rng_below(r, 50)) out[rng_below(r, 3)] = 0;
}

static void map_space_is_that_of_lookups(void **state)
{
    (void)state;
    rng r = {1};
    for (int n = 0; n < 20000; n++) {
        punctual l    = random_light(&r, n % KINDS);
        int      maps = l.light.flags & VXS_LIGHT_CUBE ? 6 : 1, map = rng_between(&r, 0, maps - 1);
        double   side = ldexp(1, (int)l.light.levels), at[3], point[3], p[3], wanted[3];
        for (int c = 0; c < 3; c++) at[c] = uniform(&r, 0.01, side - 0.01);
        vxs_point(&l.light, map, at, point);
        map_frame frame = map_frame_of(&l.light, map);
        map_space_from_ws(&frame, point, p);
        if (n % KINDS < PUNCTUAL_SHAPES) {
            map_space(&l, map, point, wanted);
            for (int c = 0; c < 3; c++) assert_true(fabs(p[c] - wanted[c]) < 1e-9 * (1 + p[2]));
            assert_true(fabs(side / 2 + p[0] / p[2] / l.light.texel_metres - at[0]) < 1e-6 * side);
            assert_true(fabs(side / 2 + p[1] / p[2] / l.light.texel_metres - at[1]) < 1e-6 * side);
        } else {
            for (int c = 0; c < 2; c++) assert_true(fabs(p[c] - at[c]) < 1e-6 * side);
            assert_true(fabs(p[2] * side - at[2]) < 1e-6 * side);
        }
    }
}

/* No point of a box is farther inside a side than is said of the box, and one of its corners is nearly as far. */
static void planes_bound_boxes(void **state)
{
    (void)state;
    rng r = {4};
    for (int n = 0; n < 20000; n++) {
        punctual  l     = random_light(&r, n % KINDS);
        int       maps  = l.light.flags & VXS_LIGHT_CUBE ? 6 : 1;
        map_frame frame = map_frame_of(&l.light, rng_between(&r, 0, maps - 1));
        map_sides s     = map_sides_of(&l.light, n % 3);
        box       b     = box_empty();
        for (int k = 0; k < 2; k++) {
            double at[3];
            for (int c = 0; c < 3; c++) at[c] = l.at[c] + uniform(&r, -1, 1) * pow(10, uniform(&r, -3, 3));
            box_add(&b, at);
        }
        for (int side = 0; side < MAP_SIDES; side++) {
            map_plane plane = map_plane_of(&frame, s.n[side]);
            double    most = map_plane_most(&plane, &b), found = -INFINITY, size = fabs(plane.n[3]);
            for (int k = 0; k < 3; k++) size += fabs(plane.n[k]) * fmax(fabs(b.min[k]), fabs(b.max[k]));
            for (int k = 0; k < 20; k++) {
                double point[3], at[3];
                for (int c = 0; c < 3; c++)
                    point[c] = k < 8 ? (k >> c & 1 ? b.max[c] : b.min[c]) : b.min[c] + uniform(&r, 0, 1) * (b.max[c] - b.min[c]);
                map_space_from_ws(&frame, point, at);
                found = fmax(found, map_side_at(s.n[side], at));
            }
            assert_true(most >= found && most <= found + 1e-9 * size);
        }
    }
}

/* Barycentric coordinates of a point of a triangle's plane. */
static void weights_of(const map_polygon *t, const double p[3], double w[3])
{
    double ab[3], ac[3], ap[3], normal[3], part[3];
    for (int n = 0; n < 3; n++) {
        ab[n] = t->corners[1].at[n] - t->corners[0].at[n];
        ac[n] = t->corners[2].at[n] - t->corners[0].at[n];
        ap[n] = p[n] - t->corners[0].at[n];
    }
    cross(ab, ac, normal);
    cross(ap, ac, part);
    w[1] = dot(part, normal) / dot(normal, normal);
    cross(ab, ap, part);
    w[2] = dot(part, normal) / dot(normal, normal);
    w[0] = 1 - w[1] - w[2];
}

/* How far inside a convex polygon of that plane a point is, in barycentric units; the polygon keeps the triangle's winding. */
static double inside_polygon(const map_polygon *t, const map_polygon *polygon, const double p[3])
{
    double inside = INFINITY, at[3];
    weights_of(t, p, at);
    for (int n = 0; n < polygon->count; n++) {
        double a[3], b[3];
        weights_of(t, polygon->corners[n].at, a);
        weights_of(t, polygon->corners[(n + 1) % polygon->count].at, b);
        double length = hypot(b[1] - a[1], b[2] - a[2]);
        if (length < 1e-9) continue;
        inside = fmin(inside, ((b[1] - a[1]) * (at[2] - a[2]) - (b[2] - a[2]) * (at[1] - a[1])) / length);
    }
    return inside;
}

/* Points of random triangles are in what remains exactly when they are inside all sides. */
static void clipping_keeps_what_is_inside(void **state)
{
    (void)state;
    rng r  = {2};
    int in = 0, out = 0, whole = 0, cut = 0, missed = 0;
    for (int n = 0; n < 40000; n++) {
        punctual    l    = random_light(&r, n % KINDS);
        double      side = ldexp(1, (int)l.light.levels), beyond = n % 3 ? uniform(&r, 0, side) : (double)(n % 2);
        map_sides   s = map_sides_of(&l.light, beyond);
        map_polygon t = {.count = 3}, kept = {.count = 0};
        for (int k = 0; k < 3; k++) random_corner(&r, &l.light, t.corners[k].at);
        int touches = map_sides_touch(&s, &t), clipped = map_sides_clip(&s, &t, &kept);
        assert_in_range(kept.count, 0, MAP_CORNERS_MAX);
        if (!clipped) assert_true(kept.count == 3 && !memcmp(kept.corners, t.corners, 3 * sizeof *t.corners));
        for (int k = 0; k < kept.count; k++) assert_true(within_by(&l.light, kept.corners[k].at, beyond) > -1e-6 * side);
        whole += !clipped;
        cut += clipped && kept.count >= 3;
        missed += !touches;
        for (int k = 0; k < 20; k++) {
            double a = uniform(&r, 0, 1), b = uniform(&r, 0, 1), p[3];
            if (a + b > 1) a = 1 - a, b = 1 - b;
            for (int c = 0; c < 3; c++)
                p[c] = t.corners[0].at[c] + a * (t.corners[1].at[c] - t.corners[0].at[c]) +
                       b * (t.corners[2].at[c] - t.corners[0].at[c]);
            double by = within_by(&l.light, p, beyond);
            if (fabs(by) < 1e-6 * side) continue;
            if (by > 0) assert_true(touches);
            if (by > 0 && kept.count < 3) fail_msg("light %d: a point is %g inside, and nothing remains", n, by);
            double found = kept.count < 3 ? -1 : inside_polygon(&t, &kept, p);
            if (fabs(found) < 1e-6) continue;
            assert_true((found > 0) == (by > 0));
            in += by > 0;
            out += by < 0;
        }
    }
    assert_true(in > 10000 && out > 100000 && whole > 500 && cut > 10000 && missed > 3000);
}

/* Corners on a side, on several, on the plane of the light and at the light: no corner beyond the array, none that is
 * not a number. */
static void degenerate_triangles(void **state)
{
    (void)state;
    rng r = {3};
    for (int n = 0; n < 200000; n++) {
        punctual    l    = random_light(&r, n % KINDS);
        double      side = ldexp(1, (int)l.light.levels);
        map_sides   s    = map_sides_of(&l.light, n % 2 ? side : 0);
        map_polygon t    = {.count = 3}, kept;
        double      edge = (n % 2 ? 1.5 : 0.5) * side * l.light.texel_metres;
        for (int k = 0; k < 3; k++) {
            double *at = t.corners[k].at, z = rng_below(&r, 4) ? l.light.near_metres : l.light.near_metres / 1024;
            random_corner(&r, &l.light, at);
            if (rng_below(&r, 2))
                at[0] = rng_between(&r, -2, 2) * edge, at[1] = rng_between(&r, -2, 2) * edge, at[2] = rng_between(&r, -1, 2);
            if (!rng_below(&r, 4)) at[0] = rng_between(&r, -1, 1) * edge * z, at[2] = z;
            if (k && !rng_below(&r, 8)) t.corners[k] = t.corners[k - 1];
        }
        map_sides_touch(&s, &t);
        map_sides_clip(&s, &t, &kept);
        assert_in_range(kept.count, 0, MAP_CORNERS_MAX - 1);
        for (int k = 0; k < kept.count; k++)
            for (int c = 0; c < 3; c++) assert_true(isfinite(kept.corners[k].at[c]));
    }
}

/* --- watertight stays watertight: every edge that is not on a side is there in both directions, to the bit */

typedef struct edge {
    double from[3], to[3];
} edge;

static int compare_edges(const void *a, const void *b)
{
    return memcmp(a, b, sizeof(edge));
}

/* -0 and 0 are one place. */
static void put_place(double *to, const double *from)
{
    for (int n = 0; n < 3; n++) to[n] = from[n] == 0 ? 0 : from[n];
}

static int on_one_side(const map_sides *s, const edge *e)
{
    for (int n = 0; n < MAP_SIDES; n++) {
        const double *side = s->n[n];
        double        a = dot(side, e->from) + side[3], b = dot(side, e->to) + side[3];
        double        scale = 1e-9 * (fabs(side[3]) + sqrt(dot(e->from, e->from)) + sqrt(dot(e->to, e->to)));
        if (fabs(a) < scale && fabs(b) < scale) return 1;
    }
    return 0;
}

static void closed_meshes_stay_closed(void **state)
{
    enum { STACKS = 9, SLICES = 12, EDGES_MAX = 2 * STACKS * SLICES * MAP_CORNERS_MAX };
    (void)state;
    rng   r     = {4};
    edge *edges = malloc(2 * EDGES_MAX * sizeof *edges);
    assert_non_null(edges);
    size_t asked = 0;
    for (int n = 0; n < 600; n++) {
        punctual  l    = random_light(&r, n % KINDS);
        double    side = ldexp(1, (int)l.light.levels), centre[3], place_of[STACKS + 1][SLICES][3];
        map_sides s    = map_sides_of(&l.light, n % 2 ? side : 1);
        random_corner(&r, &l.light, centre);
        double radius = (n % KINDS == PUNCTUAL_SHAPES ? side : l.light.near_metres * 50) * uniform(&r, 0.1, 2);
        for (int a = 0; a <= STACKS; a++)
            for (int b = 0; b < SLICES; b++) {
                double polar = acos(-1) * a / STACKS, round = 2 * acos(-1) * b / SLICES,
                       bump       = a == 0 || a == STACKS ? 1 : uniform(&r, 0.5, 1.5);
                int pole          = a == 0 || a == STACKS;
                place_of[a][b][0] = centre[0] + bump * radius * (pole ? 0 : sin(polar) * cos(round));
                place_of[a][b][1] = centre[1] + bump * radius * (pole ? 0 : sin(polar) * sin(round));
                place_of[a][b][2] = centre[2] + bump * radius * cos(polar);
            }
        size_t count = 0;
        for (int a = 0; a < STACKS; a++)
            for (int b = 0; b < SLICES; b++)
                for (int half = 0; half < 2; half++) {
                    int           b1   = (b + 1) % SLICES;
                    const double *c[3] = {place_of[a][b], half ? place_of[a + 1][b1] : place_of[a + 1][b],
                                          half ? place_of[a][b1] : place_of[a + 1][b1]};
                    map_polygon t = {.count = 3}, kept;
                    if ((!half && a == STACKS - 1) || (half && a == 0)) continue;
                    for (int k = 0; k < 3; k++) memcpy(t.corners[k].at, c[k], sizeof t.corners[k].at);
                    map_sides_clip(&s, &t, &kept);
                    for (int k = 0; k < kept.count; k++) {
                        put_place(edges[count].from, kept.corners[k].at);
                        put_place(edges[count].to, kept.corners[(k + 1) % kept.count].at);
                        if (!memcmp(edges[count].from, edges[count].to, sizeof edges->from)) continue;
                        count++;
                        assert_true(count < EDGES_MAX);
                    }
                }
        qsort(edges, count, sizeof *edges, compare_edges);
        for (size_t k = 0; k < count; k++) {
            edge back;
            memcpy(back.from, edges[k].to, sizeof back.from);
            memcpy(back.to, edges[k].from, sizeof back.to);
            if (on_one_side(&s, &edges[k])) continue;
            if (!bsearch(&back, edges, count, sizeof *edges, compare_edges))
                fail_msg("mesh %d has a crack at edge %zu of %zu", n, k, count);
            asked++;
        }
    }
    assert_true(asked > 20000);
    free(edges);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(map_space_is_that_of_lookups),  cmocka_unit_test(planes_bound_boxes),
        cmocka_unit_test(clipping_keeps_what_is_inside), cmocka_unit_test(degenerate_triangles),
        cmocka_unit_test(closed_meshes_stay_closed),
    };
    return cmocka_run_group_tests_name("map_space", tests, NULL, NULL);
}
