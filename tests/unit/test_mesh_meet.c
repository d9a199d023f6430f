/* Which solids meet (casters_find_meeting), against boxes of whole numbers, whose contacts are plain.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "tests/unit/mesh_sample.h"
#include "tests/unit/repeats.h"

#include "baker/casters/casters_cgal.h"

static void find_meeting(sample *b, closed_mode closed)
{
    sample_sort(b, closed);
    assert_int_equal(casters_find_meeting(&b->c, 2, &b->m), VXS_OK);
    assert_int_equal(b->c.meeting.solids, b->c.component_count[COMPONENT_SOLID]);

    /* a solid meets as a whole, and as many do as are counted */
    uint8_t *seen = calloc(b->c.meeting.solids + 1, 1);
    size_t   meet = 0;
    assert_non_null(seen);
    for (size_t t = 0; t < b->c.solid_triangle_count; t++) {
        uint32_t solid = b->c.component_of[t];
        assert_true(solid < b->c.meeting.solids);
        assert_int_equal(b->c.kind_of[solid], COMPONENT_SOLID);
        if (seen[solid]) assert_int_equal(seen[solid], 1 + b->c.solid_meets[t]);
        if (!seen[solid]) meet += b->c.solid_meets[t];
        seen[solid] = (uint8_t)(1 + b->c.solid_meets[t]);
    }
    assert_int_equal(meet, b->c.meeting.meet);
    assert_int_equal(b->c.meeting.assumed, 0);
    free(seen);
}

static void expect_and_clear(sample *b, closed_mode closed, size_t solids, size_t meet)
{
    find_meeting(b, closed);
    assert_int_equal(b->c.meeting.solids, solids);
    assert_int_equal(b->c.meeting.meet, meet);
    sample_clear(b);
}

static void test_pairs(void **state)
{
    (void)state;
    static const struct {
        double low[3], high[3];
        size_t meet;
    } cases[] = {
        {{5, 0, 0}, {6, 1, 1}, 0},         /* apart */
        {{4, 1, 1}, {6, 2, 2}, 2},         /* face on face */
        {{4, 4, 1}, {6, 6, 2}, 2},         /* edge on edge */
        {{4, 4, 4}, {6, 6, 6}, 2},         /* corner on corner */
        {{3, 1, 1}, {6, 2, 2}, 2},         /* through a face */
        {{-1, 1, 1}, {6, 2, 2}, 2},        /* right through */
        {{1, 1, 1}, {2, 2, 2}, 2},         /* inside */
        {{-1, -1, -1}, {5, 5, 5}, 2},      /* around */
        {{0, 1, 1}, {2, 2, 2}, 2},         /* inside, on a face */
        {{4.0000001, 1, 1}, {6, 2, 2}, 0}, /* almost */
    };
    sample b = {0};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        for (int order = 0; order < 2; order++) {
            for (int n = 0; n < 2; n++) {
                if (n == order) sample_box(&b, (double[3]){0, 0, 0}, (double[3]){4, 4, 4});
                if (n != order) sample_box(&b, cases[i].low, cases[i].high);
            }
            expect_and_clear(&b, CLOSED_ON, 2, cases[i].meet);
        }
}

static void test_counts(void **state)
{
    (void)state;
    sample b = {0};
    sample_cube(&b, 0, 0, 0, 1);
    sample_cube(&b, 1, 1, 1, 1); /* these two cross */
    sample_cube(&b, 9, 0, 0, 1); /* alone */
    sample_ball(&b, (double[3]){0, 20, 0}, 5, 8);
    sample_cube(&b, 4.5, 24.5, 4.5, 0.25); /* in the ball's box, not in the ball */
    find_meeting(&b, CLOSED_AUTO);
    assert_int_equal(b.c.meeting.solids, 5);
    assert_int_equal(b.c.meeting.meet, 2);
    assert_int_equal(b.c.meeting.apart_by_box, 1);
    for (size_t t = 0; t < b.c.solid_triangle_count; t++) assert_int_equal(b.c.solid_meets[t], t < 24);
    sample_clear(&b);

    /* sheets do not count */
    sample_cube(&b, 0, 0, 0, 1);
    sample_points(&b, (double[3]){0, 0, 0}, (double[3]){9, 0, 0}, (double[3]){0, 9, 0});
    expect_and_clear(&b, CLOSED_AUTO, 1, 0);
    sample_cube(&b, 0, 0, 0, 1);
    expect_and_clear(&b, CLOSED_OFF, 0, 0);
}

static void test_solids_that_meet_themselves(void **state)
{
    (void)state;
    /* two boxes with a common edge are one solid, whose nearest back face is its exit */
    sample b = {0};
    sample_box(&b, (double[3]){0, 0, 0}, (double[3]){1, 1, 1});
    sample_box(&b, (double[3]){1, 0, 1}, (double[3]){2, 1, 2});
    expect_and_clear(&b, CLOSED_AUTO, 1, 0);

    /* with a common face it is not: the ray goes on */
    sample_box(&b, (double[3]){0, 0, 0}, (double[3]){1, 1, 1});
    sample_box(&b, (double[3]){1, 0, 0}, (double[3]){2, 1, 1});
    expect_and_clear(&b, CLOSED_AUTO, 1, 1);

    /* an octahedron, one corner of which is pulled through the opposite sides, or not so far */
    for (int through = 0; through < 2; through++) {
        double p[6][3] = {{1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
        if (through) p[5][0] = 3, p[5][2] = 0.5;
        for (int i = 0; i < 4; i++) {
            sample_points(&b, p[i], p[(i + 1) % 4], p[4]);
            sample_points(&b, p[(i + 1) % 4], p[i], p[5]);
        }
        expect_and_clear(&b, CLOSED_ON, 1, (size_t)through);
    }
}

/* Boxes of whole numbers meet where their ranges have a number in common along each axis. */
static void test_random_boxes(void **state)
{
    (void)state;
    enum { BOXES = 12 };
    const uint32_t trials = repeats(100, 400);
    uint32_t       seed   = 7;
    size_t         tried = 0, met = 0, nested = 0;
    for (uint32_t trial = 0; trial < trials; trial++) {
        int    low[BOXES][3], high[BOXES][3], meets[BOXES] = {0};
        sample b = {0};
        for (int i = 0; i < BOXES; i++) {
            for (int axis = 0; axis < 3; axis++) {
                low[i][axis]  = (int)sample_random(&seed, 20);
                high[i][axis] = low[i][axis] + 1 + (int)sample_random(&seed, i ? 3 : 16);
            }
            sample_box(&b, (double[3]){low[i][0], low[i][1], low[i][2]}, (double[3]){high[i][0], high[i][1], high[i][2]});
        }
        for (int i = 0; i < BOXES; i++)
            for (int j = 0; j < i; j++) {
                int common = 1, within = 1;
                for (int axis = 0; axis < 3; axis++) {
                    common &= low[i][axis] <= high[j][axis] && low[j][axis] <= high[i][axis];
                    within &= low[j][axis] < low[i][axis] && high[i][axis] < high[j][axis];
                }
                meets[i] |= common;
                meets[j] |= common;
                nested += (size_t)within;
            }
        if (trial % 2) sample_map(&b, 0.01, 1e7); /* whole centimetres are no longer exact, but order is kept */
        find_meeting(&b, CLOSED_ON);
        if (b.c.meeting.solids == BOXES) {
            for (size_t t = 0; t < b.c.solid_triangle_count; t++) assert_int_equal(b.c.solid_meets[t], meets[t / 12]);
            tried++;
            met += b.c.meeting.meet;
        } /* else a common edge has made one of two */
        sample_clear(&b);
    }
    assert_true(tried > trials / 4 && met > tried && met < (BOXES - 2) * tried && nested > trials / 40);
}

/* Enough triangles for several slabs, with boxes that reach through them. No two corners have the same place. */
static void test_many_boxes(void **state)
{
    (void)state;
    enum { BOXES = 3000 };
    double(*low)[3] = malloc(BOXES * sizeof *low), (*high)[3] = malloc(BOXES * sizeof *high);
    uint8_t *meets = calloc(BOXES, 1);
    uint32_t seed  = 3;
    size_t   met   = 0;
    sample   b     = {0};
    for (int i = 0; i < BOXES; i++) {
        for (int axis = 0; axis < 3; axis++) {
            low[i][axis]  = sample_random(&seed, axis ? 20 : 12000) + i / 4096.0;
            high[i][axis] = low[i][axis] + 1 + sample_random(&seed, axis ? 3 : i % 100 ? 3 : 3000);
        }
        sample_box(&b, low[i], high[i]);
        for (int j = 0; j < i; j++) {
            int common = 1;
            for (int axis = 0; axis < 3; axis++) common &= low[i][axis] <= high[j][axis] && low[j][axis] <= high[i][axis];
            meets[i] |= common;
            meets[j] |= common;
        }
    }
    sample_sort(&b, CLOSED_ON);
    for (uint32_t threads = 1; threads <= 8; threads += 7) {
        assert_int_equal(casters_find_meeting(&b.c, threads, &b.m), VXS_OK);
        assert_int_equal(b.c.meeting.solids, BOXES);
        for (size_t t = 0; t < b.c.solid_triangle_count; t++) assert_int_equal(b.c.solid_meets[t], meets[t / 12]);
    }
    for (int i = 0; i < BOXES; i++) met += meets[i];
    assert_in_range(met, BOXES / 10, BOXES - BOXES / 10);
    sample_clear(&b);
    free(low);
    free(high);
    free(meets);
}

static void test_nested_and_crossing_cubes(void **state)
{
    (void)state;
    sample b = {0};
    for (int i = 0; i < 100; i++) sample_cube(&b, 0, 0, 0, 100 - i);
    expect_and_clear(&b, CLOSED_ON, 100, 100);
    for (int i = 0; i < 100; i++) sample_cube(&b, 0, 0, 0, 100 - i);
    expect_and_clear(&b, CLOSED_AUTO, 1, 0); /* the innermost; whatever holds another is a sheet */
    for (int i = 0; i < 100; i++) sample_cube(&b, 0.01 * i, 0.02 * i, 0.03 * i, 4);
    expect_and_clear(&b, CLOSED_AUTO, 100, 100);
}

static void test_sizes(void **state)
{
    (void)state;
    static const double scales[][2] = {{0.01, 1e7}, {1e-6, 0}, {1e-6, 1}, {1e9, 0}};
    sample              b           = {0};
    for (size_t i = 0; i < sizeof scales / sizeof *scales; i++) {
        for (int gap = 0; gap < 2; gap++) {
            sample_cube(&b, 0, 0, 0, 64);
            sample_cube(&b, 128 + 16 * gap, 32, 32, 64); /* on the first, or beside it */
            sample_map(&b, scales[i][0], scales[i][1]);
            expect_and_clear(&b, CLOSED_AUTO, 2, gap ? 0 : 2);
        }
    }
}

/* --- triangles -------------------------------------------------------------------------------------------------------- */

typedef struct pairs {
    uint32_t a[64], b[64];
    size_t   count, most;
} pairs;

static int all(void *user, uint32_t a, uint32_t b)
{
    (void)user;
    assert_int_not_equal(a, b);
    return 1;
}

static int keep(void *user, uint32_t a, uint32_t b)
{
    pairs *p = user;
    assert_true(p->count < 64);
    p->a[p->count]   = a;
    p->b[p->count++] = b;
    return p->count == p->most;
}

/* Triangles by corner numbers, of 13; how many pairs there are. */
static size_t count_pairs(const double *positions, const uint32_t *indices, size_t triangles)
{
    size_t counts[2];
    for (int mirrored = 0; mirrored < 2; mirrored++) { /* whichever of two comes first */
        double p[39];
        for (int i = 0; i < 39; i++) p[i] = mirrored ? -positions[i] : positions[i];
        pairs       found  = {.most = 0};
        mesh_soup   soup   = {p, indices, triangles};
        mesh_search search = {.wanted = all, .found = keep, .user = &found, .overlaps_max = 1000, .tests_max = 1000};
        assert_int_equal(mesh_find_intersections(&soup, &search), VXS_OK);
        assert_int_equal(search.gave_up, 0);
        counts[mirrored] = found.count;
    }
    assert_int_equal(counts[0], counts[1]);
    return counts[0];
}

static void test_triangles_with_common_corners(void **state)
{
    (void)state;
    const double p[] = {0,  0, 0, 4, 0, 0, 0, 4,  0,  4, 4,  0,  1, 1, 0, 1, 1, 5, 1, 1,
                        -5, 2, 0, 0, 8, 0, 0, -1, -1, 0, -1, -2, 3, 3, 3, 9, 3, 3, -9};
    assert_int_equal(count_pairs(p, (uint32_t[]){0, 1, 2, 1, 3, 2}, 2), 0); /* a quad */
    assert_int_equal(count_pairs(p, (uint32_t[]){0, 1, 2, 0, 1, 4}, 2), 1); /* folded onto itself */
    assert_int_equal(count_pairs(p, (uint32_t[]){0, 1, 2, 0, 1, 5}, 2), 0); /* an edge of a solid */
    assert_int_equal(count_pairs(p, (uint32_t[]){0, 1, 2, 2, 1, 0}, 2), 1); /* both sides of one */
    assert_int_equal(count_pairs(p, (uint32_t[]){0, 1, 2, 0, 5, 6}, 2), 1); /* from a corner through the middle */
    assert_int_equal(count_pairs(p, (uint32_t[]){0, 5, 6, 0, 1, 2}, 2), 1);
    assert_int_equal(count_pairs(p, (uint32_t[]){0, 1, 2, 0, 11, 12}, 2), 1);
    assert_int_equal(count_pairs(p, (uint32_t[]){0, 1, 2, 0, 9, 10}, 2), 0); /* a corner on a corner */
    assert_int_equal(count_pairs(p, (uint32_t[]){0, 1, 2, 9, 5, 6}, 2), 1);  /* no common corner */
    assert_int_equal(count_pairs(p, (uint32_t[]){0, 1, 2, 3, 5, 6}, 2), 1);
    assert_int_equal(count_pairs(p, (uint32_t[]){0, 1, 8, 1, 2, 3}, 2), 0); /* no area: a line has no surface */
    mesh_soup soup = {p, (uint32_t[]){0, 7, 8, 0, 7, 4}, 2};
    assert_true(mesh_is_flat(&soup, 0));
    assert_false(mesh_is_flat(&soup, 1));
}

static int count(void *user, uint32_t a, uint32_t b)
{
    (void)a, (void)b;
    ++*(size_t *)user;
    return 0;
}

/* Pairs that cross, far apart, and so long that most reach through several slabs: each is found once. */
static void test_each_pair_once(void **state)
{
    (void)state;
    enum { PAIRS = 12500 };
    double   *p       = malloc(18 * PAIRS * sizeof *p);
    uint32_t *corners = malloc(6 * PAIRS * sizeof *corners), seed = 5;
    for (size_t i = 0; i < PAIRS; i++) {
        double x = sample_random(&seed, 1000000), length = 100 + sample_random(&seed, 300000), y = 2.0 * (double)i;
        memcpy(&p[18 * i],
               (double[18]){x, y, 0, x + length, y, 0, x, y + 1, 0, /* and through its middle */
                            x + length / 4, y + 0.25, -1, x + length / 4, y + 0.25, 1, x + length, y + 0.25, 0},
               18 * sizeof *p);
    }
    for (uint32_t k = 0; k < 6 * PAIRS; k++) corners[k] = k;
    mesh_soup soup = {p, corners, 2 * PAIRS};
    for (uint32_t threads = 1; threads <= 8; threads += 7) {
        size_t      found  = 0;
        mesh_search search = {
            .wanted = all, .found = count, .user = &found, .threads = threads, .overlaps_max = PAIRS, .tests_max = PAIRS};
        assert_int_equal(mesh_find_intersections(&soup, &search), VXS_OK);
        assert_int_equal(search.gave_up, 0);
        assert_int_equal(found, PAIRS);
    }
    free(p);
    free(corners);
}

static void test_limits(void **state)
{
    (void)state;
    sample b = {0};
    for (int i = 0; i < 4; i++) sample_cube(&b, 0, 0, 0.1 * i, 1);
    sample_sort(&b, CLOSED_OFF);
    mesh_soup   soup   = {b.c.positions_ws, b.c.indices, b.c.triangle_count};
    pairs       found  = {.most = 5};
    mesh_search search = {.wanted = all, .found = keep, .user = &found, .overlaps_max = 10000, .tests_max = 10000};
    assert_int_equal(mesh_find_intersections(&soup, &search), VXS_OK);
    assert_int_equal(found.count, 5); /* queried to end there */
    assert_int_equal(search.gave_up, 0);

    search.tests_max = 10;
    found            = (pairs){.most = 0};
    assert_int_equal(mesh_find_intersections(&soup, &search), VXS_OK);
    assert_int_equal(search.gave_up, 1);
    search.tests_max    = 10000;
    search.overlaps_max = 10;
    found               = (pairs){.most = 0};
    assert_int_equal(mesh_find_intersections(&soup, &search), VXS_OK);
    assert_int_equal(search.gave_up, 1);
    sample_clear(&b);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_pairs),
        cmocka_unit_test(test_counts),
        cmocka_unit_test(test_solids_that_meet_themselves),
        cmocka_unit_test(test_random_boxes),
        cmocka_unit_test(test_many_boxes),
        cmocka_unit_test(test_nested_and_crossing_cubes),
        cmocka_unit_test(test_sizes),
        cmocka_unit_test(test_triangles_with_common_corners),
        cmocka_unit_test(test_each_pair_once),
        cmocka_unit_test(test_limits),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
