/* Keys of squares of the sparse source (baker/columns/sparse/sparse_columns.c): of two scenes that differ in one thing, squares
 * with equal keys have equal columns, each one of them, and most squares far from the difference have equal keys.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/base/random.h" /* before cmocka, whose fail() is a macro */
#include "baker/columns/sparse/sparse_columns.h"
#include "baker/light/light_fit.h"
#include "tests/unit/mesh_sample.h"

enum { SIDE = 1024, FETCH = 256, SQUARES = (SIDE / FETCH) * (SIDE / FETCH), IMAGE_PX = 4, MAPS_MAX = 6 };

/* What one scene may have that the other has not. */
typedef enum difference {
    DIFFERENCE_NONE,
    DIFFERENCE_MOVED,       /* a ball is elsewhere */
    DIFFERENCE_MOVED_DEPTH, /* a ball is nearer */
    DIFFERENCE_FIRST,       /* a triangle comes first in the file: all numbers are others */
    DIFFERENCE_NEIGHBOUR,   /* a triangle shares an edge with the hills: a patch ends there, that did not */
    DIFFERENCE_MASK,        /* a pixel of the image of a mask */
    DIFFERENCE_THRESHOLD,
    DIFFERENCE_UV,
    DIFFERENCE_SHEETS, /* a solid becomes a sheet: a face of a box is missing */
    DIFFERENCES
} difference;

static void add_holed(sample *b, double u, double v, double size, uint32_t mask, float shift)
{
    const double       z            = 300;
    const double       corner[4][3] = {{u, v, z}, {u + size, v, z}, {u + size, v + size, z + 40}, {u, v + size, z}};
    static const int   of[2][3]     = {{0, 1, 2}, {0, 2, 3}};
    static const float uv[4][2]     = {{0, 0}, {3, 0}, {3, 3}, {0, 3}};
    for (int t = 0; t < 2; t++) {
        holed_triangle h = {.mask = mask};
        h.triangle       = (uint32_t)b->s.triangle_count;
        sample_points(b, corner[of[t][0]], corner[of[t][1]], corner[of[t][2]]);
        for (int k = 0; k < 3; k++)
            for (int n = 0; n < 2; n++) h.uv[k][n] = uv[of[t][k]][n] + shift;
        b->s.triangle_flags[h.triangle] |= TRIANGLE_ALPHA_MASK;
        b->s.holed_triangles = sample_grown(b->s.holed_triangles, (b->s.holed_triangle_count + 1) * sizeof h);
        b->s.holed_triangles[b->s.holed_triangle_count++] = h;
    }
}

/* A grid of hills over all of the map, one patch or two; each corner is moved by so little that no two triangles are
 * on one plane. */
static void hill_corner(int i, int j, int parts, double out[3])
{
    rng r  = rng_split((uint64_t)(i * 1000 + j), 77);
    out[0] = SIDE * (0.02 + 0.96 * i / parts);
    out[1] = SIDE * (0.02 + 0.96 * j / parts);
    out[2] = 700 + 60 * sin(0.7 * i) * cos(0.9 * j) + 5 * (double)rng_below(&r, 100) / 100;
}

static void add_hills(sample *b, int parts)
{
    for (int j = 0; j < parts; j++)
        for (int i = 0; i < parts; i++) {
            double p[4][3];
            for (int k = 0; k < 4; k++) hill_corner(i + (k == 1 || k == 2), j + (k >= 2), parts, p[k]);
            sample_points(b, p[0], p[2], p[1]);
            sample_points(b, p[0], p[3], p[2]);
        }
}

static void make(sample *b, alpha_image images[2], uint8_t pixels[2][IMAGE_PX * IMAGE_PX], difference d)
{
    double low[3] = {100, 780, 200}, high[3] = {330, 990, 420}, a[3], c[3];
    *b = (sample){0};
    if (d == DIFFERENCE_FIRST) sample_points(b, (double[]){5, 5, 9}, (double[]){9, 5, 9}, (double[]){5, 9, 9});
    add_hills(b, 24);
    if (d == DIFFERENCE_NEIGHBOUR) {
        hill_corner(3, 3, 24, a);
        hill_corner(4, 4, 24, c);
        sample_points(b, a, c, (double[]){a[0], c[1], 400});
    }
    for (int n = 0; n < 9; n++) sample_ball(b, (double[]){150.0 + 360 * (n % 3), 140.0 + 350 * (n / 3), 400.0 + 10 * n}, 60, 6 + n);
    double x = d == DIFFERENCE_MOVED ? 866 : 860, z = d == DIFFERENCE_MOVED_DEPTH ? 119 : 120;
    sample_ball(b, (double[]){x, 130, z}, 50, 9);
    sample_box(b, low, high);
    if (d == DIFFERENCE_SHEETS) sample_remove(b, b->s.triangle_count - 1);
    for (int n = 0; n < 2; n++) {
        for (int k = 0; k < IMAGE_PX * IMAGE_PX; k++) pixels[n][k] = (uint8_t)(n ? 13 * k : 255 * (k * k % 3 == 1));
        images[n] = (alpha_image){IMAGE_PX, IMAGE_PX, pixels[n]};
    }
    if (d == DIFFERENCE_MASK) pixels[1][9] ^= 255;
    b->s.images      = images;
    b->s.image_count = b->s.alpha_mask_count = 2;
    b->s.alpha_masks                         = sample_grown(NULL, 2 * sizeof *b->s.alpha_masks);
    for (uint32_t n = 0; n < 2; n++) b->s.alpha_masks[n] = (alpha_mask){.image = n, .threshold = 0.5f, .nearest = n == 0};
    if (d == DIFFERENCE_THRESHOLD) b->s.alpha_masks[1].threshold = 0.4f;
    add_holed(b, 60, 500, 90, 0, 0);
    add_holed(b, 820, 820, 100, 1, d == DIFFERENCE_UV ? 0.25f : 0);
    sample_sort(b, CLOSED_AUTO);
}

typedef struct known_square {
    column_key    key;
    column_bounds bounds;
    column_tile   tiles[(FETCH / 8) * (FETCH / 8)];
} known_square;

/* Keys and columns of all squares.   nearest_back  as sparse_columns */
static uint32_t find_keys(const casters *c, const vxs_light *light, int nearest_back, known_square *out)
{
    run_context    m      = {0};
    bake_context   ctx    = {.run = &m, .threads = 2};
    sparse_columns own    = {.casters = c, .light = light, .nearest_back = nearest_back, .fetch_px = FETCH};
    column_source  source = sparse_columns_source(&own);
    uint32_t       across = SIDE / FETCH, tiles = FETCH / 8;
    for (uint32_t n = 0; n < source.map_count * SQUARES; n++, out++) {
        column_map    map;
        column_square square;
        uint32_t      i = n % SQUARES % across, j = n % SQUARES / across, level = square_level(FETCH);
        assert_int_equal(source.open(source.data, n / SQUARES, &map, &ctx), VXS_OK);
        assert_int_equal(map.key(map.data, level, i, j, &out->key), VXS_OK);
        assert_int_equal(map.fetch(map.data, level, i, j, &square, &ctx), VXS_OK);
        assert_int_equal(square.bounds(square.data, level, 0, 0, &out->bounds), VXS_OK);
        for (uint32_t t = 0; t < tiles * tiles; t++)
            assert_int_equal(square.tile(square.data, t % tiles, t / tiles, &out->tiles[t]), VXS_OK);
        map.release(map.data, &square);
        map.close(map.data);
    }
    return source.map_count * SQUARES;
}

static int same_key(const known_square *a, const known_square *b)
{
    return a->key.low == b->key.low && a->key.high == b->key.high;
}

static int same_columns(const known_square *a, const known_square *b)
{
    return !memcmp(&a->bounds, &b->bounds, sizeof a->bounds) && !memcmp(a->tiles, b->tiles, sizeof a->tiles);
}

static vxs_light light_of(int is_punctual, const casters *c)
{
    vxs_light      l     = {.kind = VXS_LIGHT_KIND_DIRECTIONAL, .levels = log2_u32(SIDE), .texel_metres = 1, .voxel_metres = 1};
    light_shape    shape = {.kind = LIGHT_SPOT, .outer_rad = 0.6, .range_metres = INFINITY, .direction_ws = {0, 0, 1}};
    light_fit_desc fit   = {.name = "lamp", .shape = &shape, .resolution = SIDE};
    run_context    m     = {0};
    l.ls_from_ws[0] = l.ls_from_ws[5] = l.ls_from_ws[10] = 1;
    l.direction_ws[2]                                    = 1;
    if (!is_punctual) return l;
    shape.position_ws[0] = shape.position_ws[1] = 500;
    shape.position_ws[2]                        = -900;
    assert_int_equal(light_fit(&l, c, &fit, &m), VXS_OK);
    return l;
}

static void equal_keys_have_equal_columns(void **state)
{
    static const uint32_t most[DIFFERENCES] = {0, 4, 4, 4, 4, 4, 4, 4, 8}; /* keys that may be others */
    known_square         *one = calloc(MAPS_MAX * SQUARES, sizeof *one), *other = calloc(MAPS_MAX * SQUARES, sizeof *other);
    (void)state;
    assert_true(one && other);
    for (int is_punctual = 0; is_punctual < 2; is_punctual++) {
        sample      a;
        alpha_image images[4];
        uint8_t     pixels[4][IMAGE_PX * IMAGE_PX];
        make(&a, images, pixels, DIFFERENCE_NONE);
        vxs_light light = light_of(is_punctual, &a.c); /* as it is fitted to the first scene */
        uint32_t  count = find_keys(&a.c, &light, 0, one);
        for (difference d = 0; d < DIFFERENCES; d++) {
            sample   b;
            uint32_t other_keys = 0, other_columns = 0;
            make(&b, images + 2, pixels + 2, d);
            assert_int_equal(find_keys(&b.c, &light, 0, other), count);
            for (uint32_t n = 0; n < count; n++) {
                other_keys += !same_key(&one[n], &other[n]);
                other_columns += !same_columns(&one[n], &other[n]);
                if (same_key(&one[n], &other[n])) assert_true(same_columns(&one[n], &other[n]));
            }
            printf("lamp %d, difference %d: %u of %u keys, %u squares of columns\n", is_punctual, (int)d, other_keys, count,
                   other_columns);
            assert_true(other_keys <= most[d]);
            assert_true(d == DIFFERENCE_NONE || d == DIFFERENCE_FIRST || d == DIFFERENCE_NEIGHBOUR || other_columns);
            sample_clear(&b);
        }
        uint32_t other_keys = 0;
        find_keys(&a.c, &light, 1, other);
        for (uint32_t n = 0; n < count; n++) other_keys += !same_key(&one[n], &other[n]);
        assert_int_equal(other_keys, count); /* the nearest back face is another source */
        sample_clear(&a);
    }
    free(one);
    free(other);
}

/* Equal squares in other places have other keys: what becomes of them says where it is. */
static void keys_tell_squares_apart(void **state)
{
    known_square *all = calloc(SQUARES, sizeof *all);
    sample        b   = {0};
    (void)state;
    assert_non_null(all);
    sample_points(&b, (double[]){-4000, -4000, 9}, (double[]){4000, -4000, 9}, (double[]){0, 9000, 9});
    sample_sort(&b, CLOSED_AUTO);
    vxs_light light = light_of(0, &b.c);
    find_keys(&b.c, &light, 0, all);
    for (uint32_t n = 0; n < SQUARES; n++)
        for (uint32_t k = 0; k < n; k++) assert_false(same_key(&all[n], &all[k]));
    sample_clear(&b);
    free(all);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(equal_keys_have_equal_columns), cmocka_unit_test(keys_tell_squares_apart)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
