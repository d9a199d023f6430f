/* Damage is mended, and nothing else changes (baker/lab/mend/mesh_repair.h).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "tests/unit/mesh_sample.h"
#include "tests/unit/repeats.h"

#include "baker/lab/mend/mesh_repair.h"

static repair_report mend_with(sample *b, repair_options o)
{
    repair_report r;
    assert_int_equal(scene_repair(&b->s, &o, &r, &b->m), VXS_OK);
    assert_true(r.count <= r.component_count && r.closed_after <= r.component_count);
    sample_sort(b, CLOSED_AUTO);
    return r;
}

static repair_report mend(sample *b)
{
    return mend_with(b, (repair_options)REPAIR_DEFAULTS);
}

static void done(sample *b, repair_report *r)
{
    repair_report_free(r);
    sample_clear(b);
}

static double solid_volume(const sample *b)
{
    return b->c.solid_triangle_count ? sample_volume(b->c.positions_ws, b->c.indices, b->c.solid_triangle_count) : 0;
}

static void expect_solids(const sample *b, size_t solids, size_t sheets)
{
    size_t all = 0;
    for (int k = 0; k < COMPONENT_KINDS; k++) all += b->c.component_count[k];
    assert_int_equal(b->c.component_count[COMPONENT_SOLID], solids);
    assert_int_equal(all - solids, sheets);
}

static const double origin[3] = {0, 0, 0};

static void test_what_is_sound_is_left_alone(void **state)
{
    (void)state;
    sample b = {0};
    sample_ball(&b, origin, 0.2, 8);
    sample_box(&b, (double[3]){5, 0, 0}, (double[3]){6, 1, 1});
    sample_box(&b, (double[3]){6, 0, 1}, (double[3]){7, 1, 2}); /* with a common edge */
    sample_cube(&b, 20, 0, 0, 1);
    sample_turn(&b, b.s.triangle_count - 12, b.s.triangle_count); /* a room, seen from inside */
    size_t    count  = b.s.triangle_count;
    uint32_t *before = malloc(3 * count * sizeof *before);
    assert_non_null(before);
    memcpy(before, b.s.indices, 3 * count * sizeof *before);
    repair_report r = mend_with(&b, (repair_options){.hole_edges_max = 64, .hole_diameter_metres = 1});
    assert_int_equal(b.s.triangle_count, count);
    assert_memory_equal(b.s.indices, before, 3 * count * sizeof *before);
    assert_int_equal(r.count, 0);
    assert_int_equal(r.closed_before, 3);
    assert_int_equal(r.closed_after, 3);
    assert_int_equal(b.c.component_count[COMPONENT_SHEET_INWARD], 1);
    free(before);
    done(&b, &r);
}

static void test_small_holes_are_filled(void **state)
{
    (void)state;
    sample b = {0};
    sample_ball(&b, origin, 0.3, 16);
    sample_sort(&b, CLOSED_AUTO);
    double volume = solid_volume(&b);
    size_t count  = b.s.triangle_count;
    sample_remove(&b, 300);
    sample_remove(&b, 100);
    sample_remove(&b, 100); /* two beside each other are one hole */
    repair_report r = mend(&b);
    expect_solids(&b, 1, 0);
    assert_int_equal(r.count, 1);
    assert_int_equal(r.components[0].filled_holes, 2);
    assert_int_equal(r.components[0].added_triangles, 3);
    assert_true(!r.components[0].closed_before && r.components[0].closed_after);
    assert_int_equal(b.s.triangle_count, count);
    assert_float_equal(solid_volume(&b), volume, 0.01 * volume);
    done(&b, &r);
}

static void test_larger_holes_are_left(void **state)
{
    (void)state;
    for (int small_too = 0; small_too < 2; small_too++) {
        sample b = {0};
        sample_ball(&b, origin, 3, 16); /* triangles are half a metre */
        sample_remove(&b, 100);
        if (small_too) {
            const double p[3] = {0.001, 0.001, 3}, q[3] = {0.002, 0.001, 3};
            sample_points(&b, &b.s.positions_ws[0], p, q); /* dangles at the pole by a corner: a component of its own */
        }
        size_t        count = b.s.triangle_count;
        repair_report r     = mend(&b);
        expect_solids(&b, 0, 1 + (size_t)small_too);
        assert_int_equal(r.total.left_holes, 1 + small_too);
        assert_int_equal(r.total.filled_holes, 0);
        assert_int_equal(b.s.triangle_count, count);
        done(&b, &r);
    }
    /* unless they are requested, by size and by number of edges */
    for (int edges = 2; edges <= 3; edges++) {
        sample b = {0};
        sample_ball(&b, origin, 3, 16);
        sample_remove(&b, 100);
        repair_report r = mend_with(&b, (repair_options){.hole_edges_max = (uint32_t)edges, .hole_diameter_metres = 1});
        expect_solids(&b, edges == 3, edges != 3);
        done(&b, &r);
    }
}

static void test_openings_are_no_holes(void **state)
{
    (void)state;
    /* a small cup, a leaf, a tube: whatever the size that is requested */
    sample b = {0};
    sample_ball(&b, origin, 0.02, 8);
    for (size_t t = b.s.triangle_count; t-- > 0;)
        if (b.s.positions_ws[3 * (size_t)b.s.indices[3 * t] + 2] > 0.001) sample_remove(&b, t);
    sample_points(&b, (double[3]){1, 0, 0}, (double[3]){1.01, 0, 0}, (double[3]){1, 0.01, 0});
    repair_report r = mend_with(&b, (repair_options){.hole_edges_max = 1000, .hole_diameter_metres = 100});
    expect_solids(&b, 0, 2);
    assert_int_equal(r.total.filled_holes, 0);
    done(&b, &r);
}

static void test_cracks_of_any_length_are_filled(void **state)
{
    (void)state;
    /* a box, one side of which has a vertex in the middle of an edge that its neighbour does not have */
    sample b = {0};
    sample_cube(&b, 0, 0, 0, 50);
    double a[3], p[3], q[3], middle[3];
    for (size_t i = 0; i < 3; i++) {
        a[i]      = b.s.positions_ws[i];
        p[i]      = b.s.positions_ws[3 + i];
        q[i]      = b.s.positions_ws[6 + i];
        middle[i] = (a[i] + p[i]) / 2;
    }
    sample_remove(&b, 0);
    sample_points(&b, a, middle, q);
    sample_points(&b, middle, p, q);
    repair_report r = mend(&b);
    expect_solids(&b, 1, 0);
    assert_int_equal(r.total.filled_holes, 1);
    assert_float_equal(solid_volume(&b), 1e6, 1e-3);
    done(&b, &r);
}

static void test_triangles_are_turned(void **state)
{
    (void)state;
    uint32_t seed = 5;
    for (int share = 0; share < 4; share++) { /* sixteenths that look inward */
        static const uint32_t wrong[4] = {3, 8, 10, 14};
        sample                b        = {0};
        sample_ball(&b, (double[3]){100, 0, 0}, 3, 20);
        for (size_t t = 0; t < b.s.triangle_count; t++)
            if (sample_random(&seed, 16) < wrong[share]) sample_turn(&b, t, t + 1);
        sample_shuffle(&b, &seed);
        repair_report r = mend(&b);
        /* a clear majority is right, even when it looks inward; else outward is */
        expect_solids(&b, share < 3, share == 3);
        if (share == 3) assert_int_equal(b.c.component_count[COMPONENT_SHEET_INWARD], 1);
        if (share < 3) assert_true(solid_volume(&b) > 100);
        assert_true(r.total.turned_triangles > 50);
        assert_int_equal(r.closed_after, 1);
        done(&b, &r);
    }
}

static void test_one_sided_surfaces_are_left_alone(void **state)
{
    (void)state;
    sample b = {0};
    sample_band(&b, 40, 1);
    sample_klein_bottle(&b, 20);
    sample_map(&b, 0.001, 0);
    size_t        count = b.s.triangle_count;
    repair_report r     = mend_with(&b, (repair_options){.hole_edges_max = 1000, .hole_diameter_metres = 100});
    expect_solids(&b, 0, 2);
    assert_int_equal(r.total.turned_triangles, 0);
    assert_int_equal(b.s.triangle_count, count);
    done(&b, &r);
}

static void test_repeated_and_flat_triangles_are_removed(void **state)
{
    (void)state;
    sample b = {0};
    sample_cube(&b, 0, 0, 0, 1);
    for (size_t t = 3; t < 6; t++) {
        double p[3][3];
        for (size_t i = 0; i < 3; i++) memcpy(p[i], &b.s.positions_ws[3 * (size_t)b.s.indices[3 * t + i]], sizeof p[i]);
        sample_points(&b, p[1], p[2], p[0]);
        if (t == 4) sample_points(&b, p[2], p[0], p[1]); /* twice */
        if (t == 5) sample_points(&b, p[0], p[2], p[1]); /* and once the other way: two of three look outward */
    }
    double p[3], q[3], middle[3];
    for (size_t i = 0; i < 3; i++) {
        p[i]      = b.s.positions_ws[i];
        q[i]      = b.s.positions_ws[3 + i];
        middle[i] = (p[i] + q[i]) / 2;
    }
    sample_points(&b, p, middle, q);
    repair_report r = mend(&b);
    expect_solids(&b, 1, 0);
    assert_int_equal(r.total.removed_repeated, 5);
    assert_int_equal(r.total.removed_zero_area, 1);
    assert_int_equal(b.s.triangle_count, 12);
    assert_float_equal(solid_volume(&b), 8, 1e-12);
    done(&b, &r);
}

static void test_masks_stay_right(void **state)
{
    (void)state;
    sample b = {0};
    sample_cube(&b, 0, 0, 0, 1);
    for (int i = 0; i < 2; i++) { /* repeated ones before and between the leaves, which are repeated too, but alone */
        double p[3][3];
        for (size_t k = 0; k < 3; k++) memcpy(p[k], &b.s.positions_ws[3 * k], sizeof p[k]);
        sample_triangle(&b, (const double(*)[3])p);
        double leaf[3][3] = {{9, i, 0}, {9, i, 1}, {9, i + 1, 0}};
        for (int n = 0; n < 2; n++) {
            holed_triangle hole = {.triangle = sample_triangle(&b, (const double(*)[3])leaf), .mask = (uint32_t)i};
            hole.uv[0][0]       = (float)(2 * i + n);
            b.s.holed_triangles = sample_grown(b.s.holed_triangles, (b.s.holed_triangle_count + 1) * sizeof hole);
            b.s.holed_triangles[b.s.holed_triangle_count++] = hole;
        }
    }
    b.s.alpha_mask_count = 2;
    b.s.alpha_masks      = calloc(2, sizeof *b.s.alpha_masks);
    assert_non_null(b.s.alpha_masks);
    repair_report r = mend_with(&b, (repair_options){.hole_edges_max = 64, .hole_diameter_metres = 100});
    expect_solids(&b, 1, 2);
    assert_int_equal(r.total.removed_repeated, 2);
    assert_int_equal(r.count, 1);
    assert_int_equal(b.s.triangle_count, 16);
    for (uint32_t i = 0; i < 4; i++) {
        const holed_triangle *hole = &b.s.holed_triangles[i];
        assert_int_equal(hole->triangle, 12 + i);
        const double *p = &b.s.positions_ws[3 * (size_t)b.s.indices[3 * (size_t)hole->triangle]];
        assert_true(p[0] == 9 && p[1] == i / 2 && hole->mask == i / 2 && hole->uv[0][0] == (float)i);
    }
    assert_int_equal(b.c.holed_first, 12);
    assert_int_equal(b.c.triangle_count, 16);
    done(&b, &r);
}

/* Many kinds of damage at once. What comes out as solid holds what the undamaged balls held, and nothing else. */
/* The triangles from here on are of another part. */
static void begin_part(sample *b)
{
    scene *s     = &b->s;
    s->parts     = sample_grown(s->parts, (s->part_count + 1) * sizeof *s->parts);
    uint32_t at  = (uint32_t)s->part_count++;
    s->parts[at] = (scene_part){.triangle_first = (uint32_t)s->triangle_count, .node = at};
}

/* Triangles that are taken out, a part of nothing else, and triangles that are added far from those beside them. */
static void test_parts_stay_right(void **state)
{
    (void)state;
    static const double places[] = {0, 10, 20, 20, 30}; /* along x, by part */
    sample              b        = {0};
    for (int i = 0; i < 5; i++) {
        double at[3] = {places[i], 0, 0};
        begin_part(&b);
        if (i == 1 || i == 2) sample_cube(&b, at[0], 0, 0, 1);
        if (i == 3) sample_points(&b, (double[3]){19, -1, -1}, (double[3]){19, 1, -1}, (double[3]){21, 1, -1}); /* of the cube */
        if (i == 0 || i == 4) sample_ball(&b, at, 0.2, 8);
    }
    sample_remove(&b, b.s.parts[4].triangle_first + 100);
    sample_remove(&b, 100);
    for (int i = 1; i < 5; i++) b.s.parts[i].triangle_first--;
    repair_report r = mend_with(&b, (repair_options){.hole_edges_max = 64, .hole_diameter_metres = 1});
    assert_true(r.total.filled_holes == 2 && r.total.removed_repeated == 1 && r.count == 3);
    uint32_t part = 0;
    for (size_t t = 0; t < b.s.triangle_count; t++) {
        part     = scene_part_at(&b.s, part, t);
        double x = b.s.positions_ws[3 * (size_t)b.s.indices[3 * t]];
        assert_true(fabs(x - places[b.s.parts[part].node]) < 2 && b.s.parts[part].node != 3);
    }
    static const uint32_t firsts[] = {0, 2, 4}, counts[] = {1, 2, 1};
    for (size_t i = 0; i < r.count; i++)
        assert_true(r.components[i].parts.first == firsts[i] && r.components[i].parts.count == counts[i]);
    done(&b, &r);
}

static void test_random_damage(void **state)
{
    (void)state;
    enum { BALLS = 5 };
    uint32_t seed   = 11;
    size_t   mended = 0, total = 0;
    for (uint32_t trial = 0; trial < repeats(20, 60); trial++) {
        sample sound = {0}, b = {0};
        for (int i = 0; i < BALLS; i++) {
            sample_ball(&sound, (double[3]){3 * i, 0, 0}, 1, 8 + i);
            sample_ball(&b, (double[3]){3 * i, 0, 0}, 1, 8 + i);
        }
        for (size_t i = 0; i < 3 * b.s.vertex_count; i++) /* so that the middle of a side is on it */
            b.s.positions_ws[i] = sound.s.positions_ws[i] = round(b.s.positions_ws[i] * 0x1p20) * 0x1p-20;
        for (int i = 0; i < 6; i++) sample_remove(&b, sample_random(&seed, (uint32_t)b.s.triangle_count));
        for (int i = 0; i < 20; i++) {
            size_t t = sample_random(&seed, (uint32_t)b.s.triangle_count);
            sample_turn(&b, t, t + 1);
        }
        for (int i = 0; i < 6; i++) {
            uint32_t t = sample_random(&seed, (uint32_t)b.s.triangle_count);
            double   p[3][3];
            for (size_t k = 0; k < 3; k++) memcpy(p[k], &b.s.positions_ws[3 * (size_t)b.s.indices[3 * (size_t)t + k]], sizeof p[k]);
            if (i % 3 == 0) memcpy(p[1], p[0], sizeof p[1]);
            if (i % 3 == 1)
                for (int axis = 0; axis < 3; axis++) p[2][axis] = (p[0][axis] + p[1][axis]) / 2;
            sample_triangle(&b, (const double(*)[3])p);
        }
        sample_shuffle(&b, &seed);
        repair_report r = mend_with(&b, (repair_options){.hole_edges_max = 100, .hole_diameter_metres = 1});
        sample_sort(&sound, CLOSED_AUTO);
        mended += b.c.component_count[COMPONENT_SOLID];
        total += BALLS;
        for (int n = 0; n < 200; n++) {
            double at[3] = {-1.2 + 14.4 * sample_uniform(&seed), -1.2 + 2.4 * sample_uniform(&seed),
                            -1.2 + 2.4 * sample_uniform(&seed)};
            double is    = sample_winding(b.c.positions_ws, b.c.indices, b.c.solid_triangle_count, at);
            double was   = sample_winding(sound.c.positions_ws, sound.c.indices, sound.c.solid_triangle_count, at);
            assert_true(fabs(is - round(is)) < 1e-6);
            assert_true(round(is) == 0 || round(is) == 1);
            if (round(is) == 1)
                assert_true(round(was) == 1 || fabs(hypot(hypot(fmod(at[0] + 1.5, 3) - 1.5, at[1]), at[2]) - 1) < 0.2);
        }
        sample_clear(&sound);
        done(&b, &r);
    }
    print_message("%zu of %zu mended\n", mended, total);
    assert_true(mended > total * 9 / 10);
}

static void test_stress(void **state)
{
    (void)state;
    static const double scales[][2] = {{1, 0}, {0.01, 1e7}, {1e-6, 0}};
    for (size_t i = 0; i < sizeof scales / sizeof *scales; i++) {
        sample   b    = {0};
        uint32_t seed = 1;
        for (int n = 0; n < 100; n++) sample_cube(&b, 0, 0, 0, 100 - n);              /* nested */
        for (int n = 0; n < 100; n++) sample_cube(&b, 300 + 0.1 * n, 0.07 * n, 0, 4); /* crossing */
        for (int n = 0; n < 50; n++) {
            double x = 600 + 3 * n, y = sample_uniform(&seed);
            sample_points(&b, (double[3]){x, 0, 0}, (double[3]){x + 1, y, 0}, (double[3]){x + 1, y + 1e-9, 0}); /* needles */
            sample_points(&b, (double[3]){x, 5, 0}, (double[3]){x + 1, 5, 0}, (double[3]){x + 2, 5, 0});        /* lines */
            for (int k = 0; k < 2; k++)                                                                         /* coplanar ones */
                sample_points(&b, (double[3]){x, 9, 0}, (double[3]){x + 1, 9, 0}, (double[3]){x, 9, 1 + y * k});
        }
        /* very many around one corner, and around one edge */
        for (int n = 0; n < 20000; n++)
            sample_points(&b, (double[3]){0, 500, 0}, (double[3]){1 + n, 501, 0}, (double[3]){1 + n, 501, 1});
        for (int n = 0; n < 20000; n++) sample_points(&b, (double[3]){0, 700, 0}, (double[3]){0, 701, 0}, (double[3]){1, 700.5, n});
        sample_map(&b, scales[i][0], scales[i][1]);
        repair_report r = mend_with(&b, (repair_options){.hole_edges_max = 1000, .hole_diameter_metres = 1e9});
        assert_true(b.c.component_count[COMPONENT_SOLID] >= 100);
        done(&b, &r);
    }
    sample        b = {0};
    repair_report r;
    assert_int_equal(scene_repair(&b.s, &(repair_options)REPAIR_DEFAULTS, &r, &b.m), VXS_OK); /* an empty scene */
    repair_report_free(&r);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_what_is_sound_is_left_alone),
        cmocka_unit_test(test_small_holes_are_filled),
        cmocka_unit_test(test_larger_holes_are_left),
        cmocka_unit_test(test_openings_are_no_holes),
        cmocka_unit_test(test_cracks_of_any_length_are_filled),
        cmocka_unit_test(test_triangles_are_turned),
        cmocka_unit_test(test_one_sided_surfaces_are_left_alone),
        cmocka_unit_test(test_repeated_and_flat_triangles_are_removed),
        cmocka_unit_test(test_masks_stay_right),
        cmocka_unit_test(test_parts_stay_right),
        cmocka_unit_test(test_random_damage),
        cmocka_unit_test(test_stress),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
