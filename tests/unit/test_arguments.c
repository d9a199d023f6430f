/* What any argument of a lookup means, for all kinds of lights in both codings, against sums over single taps: filters of any
 * number, points on the borders of voxels, tiles, blocks, pages and maps, normals of any length, and numbers that are none.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <limits.h>
#include <math.h>

#include "blocks_sample.h"
#include "dag_sample.h"
#include "random_light.h"
#include "repeats.h"
#include "runtime/vxs.h"
#include "smooth_box.h"

/* last: cmocka's macro fail() hides the function of run_context.h, and it needs the four headers above */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

typedef enum shape { SUN, BOUNDED_SUN, ONE_MAP_SPOT, SIX_MAP_SPOT, ALL_AROUND, SHAPES } shape;

/* A light whose space is the world's: of a sun, a metre is a texel and a voxel; of a punctual light, the map is seen under 45
 * degrees to all sides, and its depth is from 1 m to 256. So what is exact in the map is in the world, too. */
typedef struct subject {
    shape           shape;
    int             maps;
    double          side;
    dag_sample      dag; /* of one coding, */
    vxs_asset      *asset;
    blocks_sample   blocks; /* or the other */
    vxs_baked_light baked;
} subject;

static const vxs_filter any_filter[] = {
    {1, 0},   {2, 0},          {3, 0},  {4, 0},       {5, 0},       {8, 0},        {9, 0}, {16, 0},      {17, 0},      {18, 0},
    {100, 0}, {255, 0},        {0, 1},  {1, 1},       {2, 1},       {4, 1},        {9, 1}, {16, 1},      {17, 1},      {18, 1},
    {255, 1}, {0x10000001, 2}, {-1, 0}, {INT_MIN, 0}, {INT_MIN, 1}, {-9, INT_MIN}, {0, 0}, {INT_MAX, 0}, {INT_MAX, -1}};
enum { FILTERS = sizeof any_filter / sizeof *any_filter };

static vxs_light light_of(shape s, uint32_t levels, uint32_t coding)
{
    double    side        = ldexp(1, (int)levels);
    int       is_punctual = s >= ONE_MAP_SPOT;
    vxs_light light       = {.kind         = !is_punctual      ? VXS_LIGHT_KIND_DIRECTIONAL
                                             : s == ALL_AROUND ? VXS_LIGHT_KIND_POINT
                                                               : VXS_LIGHT_KIND_SPOT,
                             .flags        = s == BOUNDED_SUN    ? VXS_LIGHT_BOUNDED
                                             : s >= SIX_MAP_SPOT ? VXS_LIGHT_CUBE
                                                                 : 0,
                             .levels       = levels,
                             .coding       = coding,
                             .ls_from_ws   = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0},
                             .direction_ws = {0, 0, 1},
                             .texel_metres = is_punctual ? 2 / side : 1,
                             .voxel_metres = is_punctual ? log(256) / side : 1,
                             .near_metres  = is_punctual ? 1 : 0,
                             .cos_outer    = s == ONE_MAP_SPOT ? 0.7 : 0};
    return light;
}

/* levels  of a DAG, 3 to 8; of blocks, 3 to 18 */
static subject subject_make(shape s, uint32_t coding, uint32_t levels, uint64_t seed)
{
    subject  of    = {.shape = s, .maps = s >= SIX_MAP_SPOT ? 6 : 1, .side = ldexp(1, (int)levels)};
    rng      r     = {seed};
    uint32_t words = 0;
    if (coding == VXS_CODING_DAG) {
        vxs_bytes       file = {0};
        vxs_write_light light;
        dag_sample_init(&of.dag, &r, levels, levels < 5 ? 12 : 150);
        light               = s < ONE_MAP_SPOT
                                  ? dag_sample_light(&of.dag, "light")
                                  : dag_sample_punctual(&of.dag, "light", s == ALL_AROUND ? VXS_LIGHT_KIND_POINT : VXS_LIGHT_KIND_SPOT,
                                          s == ONE_MAP_SPOT ? 0 : VXS_LIGHT_CUBE);
        vxs_write_desc desc = {.lights = &light, .light_count = 1, .zstd_level = 1};
        assert_int_equal(vxs_write(&file, &desc), VXS_OK);
        assert_int_equal(vxs_asset_open(&of.asset, file.data, file.size_bytes, NULL), VXS_OK);
        free(file.data);
        of.baked = *vxs_asset_light(of.asset, 0);
    } else {
        blocks_sample_init(&of.blocks, &r, levels, (uint32_t)of.maps, levels < 9 ? (uint32_t)of.maps : 12);
        words               = (uint32_t)of.blocks.word_count + BLOCKS_SPARE_WORDS;
        of.baked.words      = of.blocks.words;
        of.baked.word_count = words;
    }
    of.baked.light = light_of(s, levels, coding);
    return of;
}

static void subject_free(subject *s)
{
    vxs_asset_close(s->asset);
    if (s->asset) dag_sample_free(&s->dag);
    if (!s->asset) blocks_sample_free(&s->blocks);
}

/* 1 when a texel is in shadow; those beside the map are lit. */
static uint32_t tap(const subject *s, int map, int64_t x, int64_t y, uint32_t k)
{
    int64_t side = (int64_t)s->side;
    if (x < 0 || y < 0 || x >= side || y >= side) return 0;
    return s->asset ? dag_sample_shadow(&s->dag, (uint32_t)x, (uint32_t)y, k)
                    : blocks_sample_shadow(&s->blocks, (uint32_t)map, (uint32_t)x, (uint32_t)y, k);
}

/* The width that a filter counts as, as in formats/vxs_file.h. */
static int meaning(vxs_filter filter)
{
    int64_t width = filter.width_px;
    if (width < 1) return 1;
    if (width > VXS_FILTER_MAX) return VXS_FILTER_MAX;
    return (int)(!filter.is_smooth && width % 2 == 0 ? width + 1 : width);
}

/* In 1/256, rounded down. A part that is next to 1 may have been rounded to it. */
static uint32_t part_of(double part)
{
    return (uint32_t)fmin(255, floor(256 * part));
}

/* The lit fraction about a place of a map, by single taps.
 * voxel  whole numbers;   part  how far into the texel the place is: [0, 1) */
static float sum_of_taps(const subject *s, int map, const double voxel[3], const double part[2], vxs_filter filter)
{
    int     smooth = filter.is_smooth != 0, width = meaning(filter), reach = width / 2 + 1;
    int64_t i = (int64_t)voxel[0], j = (int64_t)voxel[1];
    if (voxel[2] < 0) return 1;
    uint32_t k = (uint32_t)fmin(voxel[2], s->side - 1), dark = 0, all = 65536 * (uint32_t)(width * width);
    uint32_t across = smooth ? part_of(part[0]) : 128, down = smooth ? part_of(part[1]) : 128;
    for (int64_t y = j - reach; y <= j + reach; y++)
        for (int64_t x = i - reach; x <= i + reach; x++)
            dark += smooth_overlap(x, i, across, width) * smooth_overlap(y, j, down, width) * tap(s, map, x, y, k);
    return (float)((double)(all - dark) / (double)all);
}

/* The same about (u, v) at a depth. */
static float sum_at(const subject *s, int map, double u, double v, double depth, vxs_filter filter)
{
    double voxel[3] = {floor(u), floor(v), floor(depth)};
    return sum_of_taps(s, map, voxel, (double[2]){u - voxel[0], v - voxel[1]}, filter);
}

/* places ----------------------------------------------------------------------------------------------------------------------- */

/* A coordinate on a border of voxels, tiles, blocks, pages or the map, beside one, or anywhere.   step  the least that it may be
 * beside */
static double tricky_coordinate(rng *r, double side, double step)
{
    static const int sizes[] = {1, 8, 32, 256};
    int              size    = sizes[rng_below(r, 4)];
    double           at      = (double)size * rng_between(r, 0, (int32_t)side / size);
    switch (rng_below(r, 5)) {
    case 0: return at + step;
    case 1: return at - step;
    case 2: return floor(uniform(r, 0, side)) + rng_below(r, 256) / 256.0;
    case 3: return rng_below(r, 2) ? side : -0.0;
    default: return at;
    }
}

/* A place of a map, and the point in the world that is exactly there. Punctual lights: before the map's middle, where no other map
 * is nearer. */
static void tricky_place(const subject *s, rng *r, int map, double at[3], double point[3])
{
    if (s->shape < ONE_MAP_SPOT) {
        for (int c = 0; c < 3; c++) {
            at[c] = tricky_coordinate(r, s->side, 1 / 256.0);
            if (!rng_below(r, 4)) at[c] = nextafter(at[c], rng_below(r, 2) ? -1e9 : 1e9);
        }
        memcpy(point, at, 3 * sizeof *at);
        return;
    }
    const char *axes = map_axes[s->maps > 1 ? map : 4];
    double      z    = ldexp(1, rng_between(r, -1, 9));
    for (int c = 0; c < 2; c++) {
        do at[c] = tricky_coordinate(r, s->side, 1 / 256.0);
        while (!(at[c] > 0 && at[c] < s->side));
    }
    at[2]                 = log(z) / s->baked.light.voxel_metres;
    double from_middle[3] = {(2 * at[0] / s->side - 1) * z, (2 * at[1] / s->side - 1) * z, z};
    for (int c = 0; c < 3; c++) {
        int axis    = axes[c] < 'a' ? axes[c] - 'X' : axes[c] - 'x';
        point[axis] = axes[c] < 'a' ? -from_middle[c] : from_middle[c];
    }
}

/* What the volume of a light holds, as in runtime/vxs.h. */
static int is_inside(const subject *s, const double at[3], const double point[3])
{
    const vxs_light *l = &s->baked.light;
    if (s->shape >= ONE_MAP_SPOT) return s->shape == ALL_AROUND || point[2] >= l->cos_outer * sqrt(dot(point, point));
    if (at[0] < 0 || at[1] < 0 || at[0] >= s->side || at[1] >= s->side) return 0;
    return s->shape == SUN || (at[2] >= 0 && at[2] < s->side);
}

/* All kinds of lights, both codings, and maps from one that filters are wider than to one of several pages. */
static void for_all_subjects(void (*check)(subject *s, rng *r))
{
    static const uint32_t levels[2][3] = {{3, 5, 8}, {3, 8, 10}};
    rng                   r            = {1};
    for (int shape_of = 0; shape_of < SHAPES; shape_of++)
        for (int blocks = 0; blocks < 2; blocks++)
            for (int n = 0; n < 3; n++) {
                subject s = subject_make((shape)shape_of, blocks ? VXS_CODING_BLOCKS : VXS_CODING_DAG, levels[blocks][n],
                                         (uint64_t)(10 * shape_of + n));
                check(&s, &r);
                subject_free(&s);
            }
}

/* tests ------------------------------------------------------------------------------------------------------------------------ */

static int asked, outside, partly;

static void check_places(subject *s, rng *r)
{
    for (int map = 0; map < s->maps; map++) {
        if (s->asset) dag_sample_show(&s->dag, (uint32_t)map);
        for (int n = 0; n < (int)repeats(3000, 9000) / s->maps; n++) {
            vxs_filter filter = n % 3 ? any_filter[n % FILTERS] : (vxs_filter){(int)rng_u32(r), (int)rng_below(r, 2)};
            double     at[3], point[3];
            tricky_place(s, r, map, at, point);
            float wanted = is_inside(s, at, point) ? sum_at(s, map, at[0], at[1], at[2], filter) : VXS_OUTSIDE;
            float found  = vxs_lookup(&s->baked, point, NULL, filter);
            if (found != wanted)
                fail_msg("shape %d, coding %u, map %d at (%.17g, %.17g, %.17g), filter %d, smooth %d: %.9g, expected %.9g",
                         (int)s->shape, s->baked.light.coding, map, at[0], at[1], at[2], filter.width_px, filter.is_smooth,
                         (double)found, (double)wanted);
            asked++;
            outside += wanted < 0;
            partly += wanted > 0 && wanted < 1;
        }
    }
}

static void test_filters_and_borders(void **state)
{
    (void)state;
    asked = outside = partly = 0;
    for_all_subjects(check_places);
    assert_in_range(asked, repeats(83000, 250000), repeats(90000, 270000));
    assert_in_range(outside, repeats(3300, 10000), 100000);
    assert_in_range(partly, repeats(13000, 40000), 250000);
}

static void check_normals(subject *s, rng *r)
{
    static const double lengths[] = {0, -0.0, 1e-300, 1e-6, 0.2, 1, 5, 100, 1e30, 1e300};
    for (int n = 0; n < (int)repeats(1000, 3000); n++) {
        vxs_filter filter = any_filter[rng_below(r, FILTERS)];
        int        map    = 0;
        double     at[3], point[3], normal[3], none[3] = {0.6, 0, 0.8}, length = lengths[rng_below(r, 10)];
        if (s->asset) dag_sample_show(&s->dag, 0);
        tricky_place(s, r, map, at, point);
        random_direction(r, normal);
        for (int c = 0; c < 3; c++) normal[c] *= length;
        none[n % 3]      = (double)NAN;
        float in_the_air = vxs_lookup(&s->baked, point, NULL, filter), found = vxs_lookup(&s->baked, point, normal, filter);
        assert_true(vxs_lookup(&s->baked, point, none, filter) == in_the_air);
        assert_true(vxs_lookup(&s->baked, point, (double[3]){0, 0, 0}, filter) == in_the_air);
        assert_true(found == VXS_OUTSIDE || (found >= 0 && found <= 1));
        none[n % 3]   = n % 2 ? (double)INFINITY : -(double)INFINITY;
        float endless = vxs_lookup(&s->baked, point, none, filter);
        assert_true(endless == VXS_OUTSIDE || (endless >= 0 && endless <= 1));
        if (s->shape >= ONE_MAP_SPOT) {
            assert_true((found == VXS_OUTSIDE) == (in_the_air == VXS_OUTSIDE)); /* held in the map */
            continue;
        }
        int32_t moved[3]; /* how far, is queried in test_bias.c */
        double  voxel[3];
        float   wanted = VXS_OUTSIDE;
        map            = vxs_voxel(&s->baked.light, point, normal, filter, moved);
        for (int c = 0; c < 3; c++) voxel[c] = moved[c];
        assert_int_equal(map >= 0, is_inside(s, voxel, point));
        if (map >= 0) wanted = sum_of_taps(s, map, voxel, (double[2]){at[0] - floor(at[0]), at[1] - floor(at[1])}, filter);
        assert_true(found == wanted);
        asked++;
    }
}

static void test_normals(void **state)
{
    (void)state;
    asked = 0;
    for_all_subjects(check_normals);
    assert_in_range(asked, repeats(3300, 10000), 100000);
}

static void check_points(subject *s, rng *r)
{
    static const double none[] = {(double)NAN, (double)INFINITY, -(double)INFINITY};
    double              half   = s->side / 2;
    (void)r;
    for (int f = 0; f < FILTERS; f++) {
        vxs_filter filter = any_filter[f];
        for (int n = 0; n < 9; n++) {
            double point[3] = {1, 2, 8}, normal[3] = {0, 0, -1};
            point[n / 3] = none[n % 3];
            assert_true(vxs_lookup(&s->baked, point, NULL, filter) == VXS_OUTSIDE);
            assert_true(vxs_lookup(&s->baked, point, normal, filter) == VXS_OUTSIDE);
        }
        if (s->asset) dag_sample_show(&s->dag, s->maps > 1 ? 4 : 0);
        if (s->shape >= ONE_MAP_SPOT) {
            int map = s->maps > 1 ? 4 : 0;
            assert_true(vxs_lookup(&s->baked, (double[3]){0, 0, 0}, NULL, filter) == 1);
            assert_true(vxs_lookup(&s->baked, (double[3]){0, 0, 1e-300}, NULL, filter) == 1);
            assert_true(vxs_lookup(&s->baked, (double[3]){0, 0, 0.999}, NULL, filter) == 1);
            assert_true(vxs_lookup(&s->baked, (double[3]){0, 0, 1}, NULL, filter) == sum_at(s, map, half, half, 0, filter));
            assert_true(vxs_lookup(&s->baked, (double[3]){0, 0, 1e30}, NULL, filter) ==
                        sum_at(s, map, half, half, s->side, filter));
            assert_true(vxs_lookup(&s->baked, (double[3]){0, 0, 1e200}, NULL, filter) == VXS_OUTSIDE);
            assert_true((vxs_lookup(&s->baked, (double[3]){0, 0, -8}, NULL, filter) == VXS_OUTSIDE) == (s->shape != ALL_AROUND));
            assert_true((vxs_lookup(&s->baked, (double[3]){0, 9, 8}, NULL, filter) == VXS_OUTSIDE) == (s->shape == ONE_MAP_SPOT));
            s->baked.light.range_metres = 64;
            assert_true(vxs_lookup(&s->baked, (double[3]){0, 0, 64}, NULL, filter) != VXS_OUTSIDE);
            assert_true(vxs_lookup(&s->baked, (double[3]){0, 0, nextafter(64, 65)}, NULL, filter) == VXS_OUTSIDE);
            s->baked.light.range_metres = 0;
            continue;
        }
        float front = s->shape == SUN ? 1 : VXS_OUTSIDE, behind = front;
        if (s->shape == SUN) behind = sum_at(s, 0, half, half, s->side - 1, filter);
        assert_true(vxs_lookup(&s->baked, (double[3]){half, half, -1e30}, NULL, filter) == front);
        assert_true(vxs_lookup(&s->baked, (double[3]){half, half, 1e30}, NULL, filter) == behind);
        assert_true(vxs_lookup(&s->baked, (double[3]){half, half, 1.7e308}, NULL, filter) == behind);
        for (int n = 0; n < 4; n++) {
            double point[3] = {half, half, half};
            point[n / 2]    = n % 2 ? 1e30 : -1e30;
            assert_true(vxs_lookup(&s->baked, point, NULL, filter) == VXS_OUTSIDE);
        }
    }
}

static void test_points(void **state)
{
    (void)state;
    for_all_subjects(check_points);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_filters_and_borders),
        cmocka_unit_test(test_normals),
        cmocka_unit_test(test_points),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
