/* Lit intervals along rays: against every border that a ray may cross and single lookups between them, and against lookups anywhere
 * on it.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <math.h>

#include "baker/base/spread.h"
#include "query_lights.h"
#include "tests/unit/repeats.h"

/* last: cmocka's macro fail() hides the function of run_context.h, and it needs the four headers above */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

enum { INTERVALS_MAX = 20000, BORDERS_MAX = 20000 };

static double unit(rng *r)
{
    return rng_u32(r) / 4294967296.0;
}

static void point_of(const vxs_ray *ray, double t, double *out)
{
    for (int n = 0; n < 3; n++) out[n] = ray->origin_ws[n] + t * ray->direction_ws[n];
}

/* The answer of a single lookup, as the state of an interval. */
static int32_t state_at(const vxs_baked_light *l, const vxs_ray *ray, double t)
{
    double p[3];
    point_of(ray, t, p);
    float lit = vxs_lookup(l, p, NULL, vxs_box(1));
    return lit == VXS_OUTSIDE ? VXS_INTERVAL_OUTSIDE : lit == 1 ? VXS_INTERVAL_LIT : VXS_INTERVAL_SHADOW;
}

/* All intervals of a ray, requested some at a time: without gaps, each unlike the one before it. */
static size_t intervals_of(const vxs_baked_light *l, const vxs_ray *ray, size_t at_a_time, vxs_interval *out)
{
    vxs_lit_walk walk;
    size_t       count = 0, found;
    assert_int_equal(vxs_lit_begin(&walk, l, ray), VXS_OK);
    do {
        assert_in_range(count, 0, INTERVALS_MAX - at_a_time);
        found = vxs_lit_next(&walk, out + count, at_a_time);
        count += found;
    } while (found == at_a_time);
    assert_int_equal(vxs_lit_next(&walk, out + count, at_a_time), 0);
    for (size_t n = 0; n < count; n++) {
        assert_true(out[n].t_begin < out[n].t_end);
        assert_true(out[n].t_begin == (n ? out[n - 1].t_end : ray->t_begin));
        if (n) assert_true(out[n].state != out[n - 1].state || out[n].coarse != out[n - 1].coarse);
    }
    if (ray->t_end > ray->t_begin) assert_true(count > 0 && out[count - 1].t_end == ray->t_end);
    return count;
}

static const vxs_interval *interval_at(const vxs_interval *list, size_t count, double t)
{
    while (count > 1 && list[count - 1].t_begin > t) count--;
    return &list[count - 1];
}

/* How far rounding may move a point: of its position, and of what light space makes of it. */
static double slack_of(const vxs_baked_light *l, const vxs_ray *ray)
{
    double size = 1;
    for (int n = 0; n < 3; n++) {
        double reach = fabs(ray->origin_ws[n]) + fabs(ray->direction_ws[n]) * fmax(fabs(ray->t_begin), fabs(ray->t_end));
        size         = fmax(size, fmax(reach, fabs(l->light.ls_from_ws[4 * n + 3])));
    }
    return 1e-13 * size;
}

/* Whether a point that is so near is in a state, so that rounding decides. */
static int rounding_decides(const vxs_baked_light *l, const vxs_ray *ray, double t, double slack, int32_t state)
{
    for (int corner = 0; corner < 8; corner++) {
        vxs_ray moved = *ray;
        for (int n = 0; n < 3; n++) moved.origin_ws[n] += corner >> n & 1 ? slack : -slack;
        if (state_at(l, &moved, t) == state) return 1;
    }
    return 0;
}

/* Anywhere on the ray the intervals say the answer of a lookup. Returns how many points rounding decides for. */
static uint32_t check_points(rng *r, const vxs_baked_light *l, const vxs_ray *ray, const vxs_interval *list, size_t count,
                             double slack)
{
    uint32_t on_border = 0;
    for (int n = 0; n < 100; n++) {
        double  t     = ray->t_begin + unit(r) * (ray->t_end - ray->t_begin);
        int32_t found = interval_at(list, count, t)->state, wanted = state_at(l, ray, t);
        if (found == wanted) continue;
        on_border++;
        if (!rounding_decides(l, ray, t, slack, found))
            fail_msg("kind %u, ray from %.17g %.17g %.17g, way %.17g %.17g %.17g, at %.17g: %d, expected %d", l->light.kind,
                     ray->origin_ws[0], ray->origin_ws[1], ray->origin_ws[2], ray->direction_ws[0], ray->direction_ws[1],
                     ray->direction_ws[2], t, found, wanted);
    }
    return on_border;
}

/* brute force ------------------------------------------------------------------------------------------------------------------ */

static void put_border(double *t, size_t *count, const vxs_ray *ray, double value)
{
    if (value > ray->t_begin && value < ray->t_end) t[(*count)++] = value;
}

/* Where p . n + offset is 0, p = from + t along. */
static void border_at_plane(double *t, size_t *count, const vxs_ray *ray, const double *from, const double *along,
                            const double *normal, double offset)
{
    double a = offset, b = 0;
    for (int n = 0; n < 3; n++) {
        a += from[n] * normal[n];
        b += along[n] * normal[n];
    }
    if (b != 0) put_border(t, count, ray, -a / b);
}

/* Every border of texels and voxels, of all maps, and of what light reaches, that the ray crosses. */
static size_t borders_of(const vxs_baked_light *l, const vxs_ray *ray, double *t)
{
    const vxs_light *light = &l->light;
    int              side  = 1 << light->levels;
    double           from[3], along[3];
    size_t           count = 0;
    for (int row = 0; row < 3; row++) {
        const double *m = light->ls_from_ws + 4 * row;
        from[row]       = m[0] * ray->origin_ws[0] + m[1] * ray->origin_ws[1] + m[2] * ray->origin_ws[2] + m[3];
        along[row]      = m[0] * ray->direction_ws[0] + m[1] * ray->direction_ws[1] + m[2] * ray->direction_ws[2];
    }
    for (int axis = 0; axis < 3; axis++)
        for (int border = 0; border <= side; border++) {
            double normal[3] = {0};
            normal[axis]     = 1;
            if (light->kind == VXS_LIGHT_KIND_DIRECTIONAL) {
                border_at_plane(t, &count, ray, from, along, normal, -border);
                continue;
            }
            double z = light->near_metres * exp(border * light->voxel_metres), slope = (border - side / 2) * light->texel_metres;
            border_at_plane(t, &count, ray, from, along, normal, -z);
            border_at_plane(t, &count, ray, from, along, normal, z);
            for (int across = 0; across < 3; across++) {
                if (across == axis) continue;
                normal[across] = -slope;
                border_at_plane(t, &count, ray, from, along, normal, 0);
                normal[across] = slope;
                border_at_plane(t, &count, ray, from, along, normal, 0);
                normal[across] = 0;
            }
        }
    /* faces of a cube, cone and range: by halving, wherever a lookup changes from one part to the next to in or out */
    for (int a = 0; a < 3; a++)
        for (int sign = -1; sign < 2; sign += 2) {
            double normal[3]    = {0};
            normal[a]           = 1;
            normal[(a + 1) % 3] = sign;
            border_at_plane(t, &count, ray, from, along, normal, 0);
        }
    qsort(t, count, sizeof *t, doubles_ascending);
    size_t parts = count;
    for (size_t n = 0; n <= parts && light->kind != VXS_LIGHT_KIND_DIRECTIONAL; n++) {
        double low = n ? t[n - 1] : ray->t_begin, high = n < parts ? t[n] : ray->t_end;
        for (int piece = 0; piece < 8; piece++) { /* a cone may be entered and left between two borders */
            double first = low + (high - low) * piece / 8, last = low + (high - low) * (piece + 1) / 8;
            double margin = 1e-12 * (last - first), a = first + margin, b = last - margin;
            int    outside = state_at(l, ray, a) == VXS_INTERVAL_OUTSIDE;
            if (outside == (state_at(l, ray, b) == VXS_INTERVAL_OUTSIDE)) continue;
            for (int halving = 0; halving < 60; halving++) {
                double middle = 0.5 * (a + b);
                if ((state_at(l, ray, middle) == VXS_INTERVAL_OUTSIDE) == outside)
                    a = middle;
                else
                    b = middle;
            }
            t[count++] = a;
        }
    }
    qsort(t, count, sizeof *t, doubles_ascending);
    return count;
}

/* Between any two borders that are next to each other and not too near, there is one interval, of what a lookup in
 * the middle says. */
static void check_borders(const vxs_baked_light *l, const vxs_ray *ray, const vxs_interval *list, size_t count, double slack)
{
    static double t[BORDERS_MAX];
    size_t        borders = borders_of(l, ray, t);
    double        length  = 0;
    for (int n = 0; n < 3; n++) length = fmax(length, fabs(ray->direction_ws[n]));
    assert_in_range(borders, 0, BORDERS_MAX - 1);
    for (size_t n = 0; n <= borders; n++) {
        double low = n ? t[n - 1] : ray->t_begin, high = n < borders ? t[n] : ray->t_end, middle = 0.5 * (low + high);
        double off = 1e-9 + 1e3 * slack / fmax(length, 1e-9);
        if (high - low < 4 * off) continue;
        const vxs_interval *at     = interval_at(list, count, middle);
        int32_t             wanted = state_at(l, ray, middle);
        if (at->state == wanted && at->t_begin < low + off && at->t_end > high - off) continue;
        if (!rounding_decides(l, ray, middle, slack, at->state == wanted ? !wanted : at->state))
            fail_msg("kind %u, between borders %.17g and %.17g: %d from %.17g to %.17g, expected %d", l->light.kind, low, high,
                     at->state, at->t_begin, at->t_end, wanted);
    }
}

/* rays ------------------------------------------------------------------------------------------------------------------------- */

/* A point of a map, or about it; on borders of texels and voxels as often as not. */
static void random_place(rng *r, const vxs_light *light, double *ws)
{
    double side = ldexp(1, (int)light->levels), c[3];
    int    map  = (int)rng_below(r, vxs_map_count(light));
    for (int axis = 0; axis < 3; axis++) {
        c[axis] = (unit(r) * 1.6 - 0.3) * side;
        if (rng_below(r, 2)) c[axis] = floor(c[axis]);
    }
    vxs_point(light, map, c, ws);
}

/* Where a punctual light is, or a sun's corner: the samples' axes are those of the world. */
static void place_of_light(const vxs_light *light, double *ws)
{
    for (int axis = 0; axis < 3; axis++)
        for (int row = 0; row < 3; row++) {
            const double *m = light->ls_from_ws + 4 * row;
            if (m[axis] != 0) ws[axis] = -m[3] / m[axis];
        }
}

static vxs_ray random_ray(rng *r, const vxs_light *light)
{
    vxs_ray ray = {.t_begin = 0, .t_end = 1};
    double  to[3];
    random_place(r, light, ray.origin_ws);
    random_place(r, light, to);
    switch (rng_below(r, 8)) {
    case 0: place_of_light(light, ray.origin_ws); break;
    case 1: place_of_light(light, to); break;
    case 2: /* along one axis of the world, which those of the samples' lights are */
        for (int n = 0, axis = (int)rng_below(r, 3); n < 3; n++)
            if (n != axis) to[n] = ray.origin_ws[n];
        break;
    case 3: /* all but along it */
        for (int n = 0, axis = (int)rng_below(r, 3); n < 3; n++)
            if (n != axis) to[n] = ray.origin_ws[n] + (unit(r) - 0.5) * 1e-7;
        break;
    case 4: /* through corners of texels, a diagonal */
        for (int n = 0; n < 3; n++) to[n] = ray.origin_ws[n] + (rng_below(r, 2) ? 4 : -4);
        break;
    default: break;
    }
    for (int n = 0; n < 3; n++) ray.direction_ws[n] = to[n] - ray.origin_ws[n];
    if (rng_below(r, 2)) {
        ray.t_begin = -1 - unit(r);
        ray.t_end   = 2 + unit(r);
    }
    if (!rng_below(r, 40)) memset(ray.direction_ws, 0, sizeof ray.direction_ws);
    return ray;
}

static size_t check_ray(rng *r, const vxs_baked_light *l, const vxs_ray *ray, uint32_t *on_border)
{
    static vxs_interval list[INTERVALS_MAX], again[INTERVALS_MAX];
    double              slack = slack_of(l, ray);
    size_t              count = intervals_of(l, ray, 256, list);
    assert_int_equal(intervals_of(l, ray, 1 + rng_below(r, 3), again), count);
    assert_memory_equal(again, list, count * sizeof *list);
    *on_border += check_points(r, l, ray, list, count, slack);
    if (l->light.levels < 7) check_borders(l, ray, list, count, slack);
    return count;
}

static void check_light(rng *r, const vxs_baked_light *l)
{
    size_t   intervals = 0;
    uint32_t on_border = 0, rays = repeats(200, 4000);
    for (uint32_t n = 0; n < rays; n++) {
        vxs_ray ray = random_ray(r, &l->light);
        intervals += check_ray(r, l, &ray, &on_border);
    }
    assert_in_range(intervals, rays, UINT32_MAX);
    assert_in_range(on_border, 0, rays); /* of 100 points on each: those of rays that run within a border */
}

static void test_blocks(void **state)
{
    (void)state;
    static const uint32_t levels[] = {3, 5, 6, 9, 11};
    for (size_t n = 0; n < sizeof levels / sizeof *levels; n++) {
        blocks_sample s;
        rng           r = {70 + n};
        blocks_sample_init(&s, &r, levels[n], levels[n] < 10 ? 6 : 1, 6);
        for (int kind = 0; kind < (s.map_count == 6 ? LIGHTS : 3); kind++) {
            vxs_baked_light l = blocks_light(s.words, levels[n], kind);
            if (kind >= 2 && n % 2) l.light.range_metres = 6.5;
            if (kind == 3 && n) l.light.kind = VXS_LIGHT_KIND_SPOT; /* a wide one: of a cosine of 0, or more */
            if (kind == 3 && n) l.light.cos_outer = n == 1 ? 0 : 0.25;
            check_light(&r, &l);
        }
        blocks_sample_free(&s);
    }
}

static void test_dags(void **state)
{
    (void)state;
    for (uint32_t levels = 3; levels <= 7; levels++) {
        dag_sample s;
        rng        r = {80 + levels};
        dag_sample_init(&s, &r, levels, levels < 5 ? 20 : 200);
        vxs_asset *asset = dag_asset(&s);
        for (uint32_t kind = 0; kind < LIGHTS; kind++) check_light(&r, vxs_asset_light(asset, kind));
        vxs_asset_close(asset);
        dag_sample_free(&s);
    }
}

/* The same lights, ten thousand kilometres away. */
static void test_far_away(void **state)
{
    (void)state;
    blocks_sample s;
    rng           r         = {90};
    uint32_t      on_border = 0;
    blocks_sample_init(&s, &r, 5, 6, 6);
    for (int kind = 0; kind < LIGHTS; kind++) {
        vxs_baked_light l = blocks_light(s.words, 5, kind);
        for (int row = 0; row < 3; row++) /* all of the world is moved by 1e7 along each axis */
            for (int n = 0; n < 3; n++) l.light.ls_from_ws[4 * row + 3] -= 1e7 * l.light.ls_from_ws[4 * row + n];
        for (int n = 0; n < 300; n++) {
            vxs_ray ray = random_ray(&r, &l.light);
            check_ray(&r, &l, &ray, &on_border);
        }
    }
    assert_in_range(on_border, 0, 3000);
    blocks_sample_free(&s);
}

/* Rays without end, and from far outside: as those that end far behind all there is. */
static void test_without_end(void **state)
{
    (void)state;
    static vxs_interval list[INTERVALS_MAX], again[INTERVALS_MAX];
    blocks_sample       s;
    rng                 r         = {91};
    uint32_t            on_border = 0;
    blocks_sample_init(&s, &r, 5, 6, 6);
    for (int kind = 0; kind < LIGHTS; kind++) {
        vxs_baked_light l = blocks_light(s.words, 5, kind);
        for (int n = 0; n < 300; n++) {
            vxs_ray ray = random_ray(&r, &l.light), from_far = ray;
            ray.t_end    = 1e4;
            size_t count = intervals_of(&l, &ray, 99, list);
            check_points(&r, &l, &ray, list, count, slack_of(&l, &ray));
            ray.t_end    = 1e15;
            count        = intervals_of(&l, &ray, 99, list);
            ray.t_end    = INFINITY;
            size_t found = intervals_of(&l, &ray, 99, again);
            while (again[found - 1].t_begin >= 1e15) found--; /* of rays that are all but parallel to a side of the volume */
            assert_int_equal(found, count);
            again[count - 1].t_end = 1e15;
            assert_memory_equal(again, list, count * sizeof *list);
            for (int axis = 0; axis < 3; axis++) from_far.origin_ws[axis] -= 1e5 * from_far.direction_ws[axis];
            from_far.t_begin += 1e5 - 3;
            from_far.t_end += 1e5;
            check_ray(&r, &l, &from_far, &on_border);
        }
    }
    blocks_sample_free(&s);
}

static void test_extremes(void **state)
{
    (void)state;
    static vxs_interval list[INTERVALS_MAX];
    blocks_sample       s;
    rng                 r = {92};
    vxs_lit_walk        walk;
    blocks_sample_init(&s, &r, 5, 6, 6);
    for (int kind = 0; kind < LIGHTS; kind++) {
        vxs_baked_light l     = blocks_light(s.words, 5, kind);
        const vxs_ray   good  = {.origin_ws = {0, 5, 3}, .direction_ws = {1, 2, -1}, .t_end = 1};
        const double    bad[] = {NAN, INFINITY, -INFINITY, 1e51, 1e300};
        for (int n = 0; n < 5; n++)
            for (int field = 0; field < 7; field++) {
                vxs_ray ray                                                                                    = good;
                *(field < 3 ? &ray.origin_ws[field] : field < 6 ? &ray.direction_ws[field - 3] : &ray.t_begin) = bad[n];
                assert_int_equal(vxs_lit_begin(&walk, &l, &ray), VXS_E_ARGUMENT);
                assert_int_equal(vxs_lit_next(&walk, list, INTERVALS_MAX), 0);
            }
        vxs_ray ray = good;
        ray.t_end   = NAN;
        assert_int_equal(vxs_lit_begin(&walk, &l, &ray), VXS_E_ARGUMENT);
        ray.t_end = -1;
        assert_int_equal(vxs_lit_begin(&walk, &l, &ray), VXS_E_ARGUMENT);
        ray.t_end = 0;
        assert_int_equal(intervals_of(&l, &ray, 9, list), 0);
        ray = good;
        assert_int_equal(vxs_lit_begin(&walk, &l, &ray), VXS_OK);
        assert_int_equal(vxs_lit_next(&walk, NULL, 0), 0);
        assert_in_range(vxs_lit_next(&walk, list, INTERVALS_MAX), 1, INTERVALS_MAX);

        for (int n = 0; n < 3000; n++) { /* numbers of all sizes: some partition of the ray, in little time */
            for (int field = 0; field < 6; field++) {
                static const double sizes[] = {0, 1e-300, 1e-30, 1e-3, 1, 10, 1e7, 1e30, 1e50};
                double              value   = sizes[rng_below(&r, 9)] * (unit(&r) * 2 - 1);
                *(field < 3 ? &ray.origin_ws[field] : &ray.direction_ws[field - 3]) = value;
            }
            ray.t_end = rng_below(&r, 3) ? sqrt(unit(&r)) * 10 : rng_below(&r, 2) ? INFINITY : 1e300;
            assert_in_range(intervals_of(&l, &ray, 500, list), 1, 1000);
        }
    }
    blocks_sample_free(&s);
}

/* A map so thin that a ray passes all of it between two numbers: its depth goes from one clamped end to the other. */
static void test_steep_depths(void **state)
{
    (void)state;
    static vxs_interval list[INTERVALS_MAX];
    blocks_sample       s;
    rng                 r = {93};
    blocks_sample_init(&s, &r, 5, 6, 6);
    for (int n = 0; n < 1600; n++) {
        static const double steep[] = {1e154, -1e154, 1e60, -1e30};
        vxs_baked_light     l       = blocks_light(s.words, 5, n % 2);
        vxs_ray             ray     = random_ray(&r, &l.light);
        l.light.ls_from_ws[9]       = steep[n / 2 % 4];
        l.light.ls_from_ws[11]      = 0;
        ray.origin_ws[1] -= 4 - 2 * unit(&r); /* about where the map is */
        size_t count = intervals_of(&l, &ray, 99, list);
        for (int k = 0; k < 40; k++) {
            double  t     = ray.t_begin + unit(&r) * (ray.t_end - ray.t_begin);
            int32_t found = interval_at(list, count, t)->state, wanted = state_at(&l, &ray, t);
            if (found != wanted && !rounding_decides(&l, &ray, t, 1e-12, found))
                fail_msg("ray %d, at %.17g: %d, expected %d", n, t, found, wanted);
        }
    }
    blocks_sample_free(&s);
}

/* Without pages intervals are as lookups are without them, and those that are not coarse are as they are with them. */
static void test_missing_pages(void **state)
{
    (void)state;
    static vxs_interval list[INTERVALS_MAX];
    blocks_sample       s;
    rng                 r         = {93};
    uint32_t            on_border = 0, coarse = 0;
    blocks_sample_init(&s, &r, 10, 1, 14);
    vxs_baked_light l = blocks_light(s.words, 10, 0), whole = l;
    uint32_t       *words = blocks_alloc(s.word_count + BLOCKS_SPARE_WORDS, sizeof *words);
    memcpy(words, s.words, s.word_count * sizeof *words);
    whole.words = words;
    for (uint32_t page = 0; page < s.page_count; page += 2) s.words[8 + page] = 0;
    for (int n = 0; n < 500; n++) {
        vxs_ray ray = random_ray(&r, &l.light);
        check_ray(&r, &l, &ray, &on_border);
        size_t count = intervals_of(&l, &ray, 100, list);
        for (size_t at = 0; at < count; at++) {
            double middle = 0.5 * (list[at].t_begin + list[at].t_end);
            coarse += list[at].coarse == 1;
            if (list[at].coarse || list[at].t_end - list[at].t_begin < 1e-9) continue;
            if (state_at(&whole, &ray, middle) != list[at].state)
                assert_true(rounding_decides(&whole, &ray, middle, slack_of(&l, &ray), list[at].state));
        }
    }
    assert_in_range(coarse, 100, UINT32_MAX);
    free(words);
    blocks_sample_free(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_blocks),        cmocka_unit_test(test_dags),     cmocka_unit_test(test_far_away),
        cmocka_unit_test(test_without_end),   cmocka_unit_test(test_extremes), cmocka_unit_test(test_steep_depths),
        cmocka_unit_test(test_missing_pages),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
