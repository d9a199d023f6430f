/* What is said about the components of scenes whose faults are known (baker/lab/mend/mesh_health.h).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "tests/unit/mesh_sample.h"

#include "baker/lab/mend/mesh_health.h"

static mesh_health examine(sample *b, closed_mode closed)
{
    mesh_health h;
    sample_sort(b, closed);
    assert_int_equal(mesh_health_examine(&h, &b->c, NULL, &b->m), VXS_OK);
    uint32_t triangles = 0, solids = 0;
    for (size_t i = 0; i < h.count; i++) {
        triangles += h.components[i].triangles;
        solids += h.components[i].kind == COMPONENT_SOLID;
        /* what is a solid has no fault that keeps it from being one */
        if (h.components[i].kind == COMPONENT_SOLID) {
            assert_true(h.components[i].closed && h.components[i].oriented);
            assert_int_equal(h.components[i].boundary_edges + h.components[i].misoriented_edges, 0);
        }
    }
    assert_int_equal(triangles, b->c.triangle_count);
    assert_int_equal(h.total.triangles, triangles);
    assert_int_equal(solids, b->c.component_count[COMPONENT_SOLID]);
    assert_int_equal(h.gave_up, 0);
    return h;
}

static void done(sample *b, mesh_health *h)
{
    mesh_health_free(h);
    sample_clear(b);
}

static void test_sound_solids(void **state)
{
    (void)state;
    sample b = {0};
    sample_box(&b, (double[3]){0, 0, 0}, (double[3]){1, 2, 3});
    sample_ball(&b, (double[3]){9, 0, 0}, 2, 40);
    mesh_health h = examine(&b, CLOSED_AUTO);
    assert_int_equal(h.count, 2);
    for (int i = 0; i < 2; i++) assert_false(component_faults(&h.components[i]));
    assert_int_equal(h.components[0].vertices, 8);
    assert_int_equal(h.components[0].edges, 18);
    assert_float_equal(h.components[0].volume_m3, 6, 1e-12);
    assert_float_equal(h.components[1].volume_m3, 4.0 / 3 * acos(-1) * 8, 0.3);
    assert_float_equal(h.total.volume_m3, h.components[0].volume_m3 + h.components[1].volume_m3, 1e-9);
    assert_int_equal((int)h.components[1].vertices - (int)h.components[1].edges + (int)h.components[1].triangles, 2); /* Euler */
    assert_float_equal(h.total.box_ws.max[0], 11, 1e-9);
    done(&b, &h);
}

static void test_holes(void **state)
{
    (void)state;
    sample b = {0};
    sample_ball(&b, (double[3]){0, 0, 0}, 1, 10);
    sample_remove(&b, 150);
    sample_remove(&b, 149); /* one hole of two triangles */
    sample_remove(&b, 60);  /* and one of one */
    mesh_health h = examine(&b, CLOSED_AUTO);
    assert_int_equal(h.count, 1);
    assert_int_equal(h.components[0].boundary_edges, 4 + 3);
    assert_int_equal(h.components[0].holes, 2);
    assert_false(h.components[0].closed);
    assert_true(h.components[0].oriented && h.components[0].orientable);
    assert_int_equal(h.components[0].kind, COMPONENT_SHEET_OPEN);
    done(&b, &h);
}

static void test_winding(void **state)
{
    (void)state;
    sample b = {0};
    sample_cube(&b, 0, 0, 0, 1);
    sample_turn(&b, 3, 4);
    sample_cube(&b, 5, 0, 0, 1);
    sample_turn(&b, 12, 24);
    mesh_health h = examine(&b, CLOSED_AUTO);
    assert_int_equal(h.components[0].misoriented_edges, 3);
    assert_true(h.components[0].closed && h.components[0].orientable && !h.components[0].oriented);
    assert_true(h.components[1].closed && h.components[1].oriented);
    assert_float_equal(h.components[1].volume_m3, -8, 1e-12);
    assert_int_equal(h.components[1].kind, COMPONENT_SHEET_INWARD);
    assert_true(component_faults(&h.components[1]));
    done(&b, &h);
}

static void test_one_sided(void **state)
{
    (void)state;
    sample b = {0};
    sample_band(&b, 40, 1);
    mesh_health h = examine(&b, CLOSED_AUTO);
    assert_int_equal(h.count, 1);
    assert_false(h.components[0].orientable);
    assert_int_equal(h.components[0].holes, 1); /* it has one rim */
    assert_int_equal(h.components[0].boundary_edges, 80);
    done(&b, &h);

    sample_band(&b, 40, 2);
    h = examine(&b, CLOSED_AUTO);
    assert_true(h.components[0].orientable);
    assert_int_equal(h.components[0].holes, 2);
    assert_int_equal(h.components[0].self_intersections, 0);
    done(&b, &h);

    sample_klein_bottle(&b, 24);
    h = examine(&b, CLOSED_AUTO);
    assert_int_equal(h.count, 1);
    assert_true(h.components[0].closed && !h.components[0].orientable && !h.components[0].oriented);
    assert_int_equal(h.components[0].boundary_edges + h.components[0].nonmanifold_edges, 0);
    assert_int_equal((int)h.components[0].vertices - (int)h.components[0].edges + (int)h.components[0].triangles, 0);
    assert_true(h.components[0].self_intersections >= 24);
    assert_int_equal(h.components[0].kind, COMPONENT_SHEET_OPEN);
    done(&b, &h);
}

/* Turning triangles makes no other surface, nor does their order. */
static void test_sides_of_mixed_winding(void **state)
{
    (void)state;
    uint32_t seed = 3;
    for (int trial = 0; trial < 40; trial++) {
        sample b = {0};
        if (trial % 2) sample_ball(&b, (double[3]){0, 0, 0}, 1, 12);
        if (!(trial % 2)) sample_klein_bottle(&b, 12);
        for (size_t t = 0; t < b.s.triangle_count; t++)
            if (sample_random(&seed, 2)) sample_turn(&b, t, t + 1);
        sample_shuffle(&b, &seed);
        mesh_health h = examine(&b, CLOSED_AUTO);
        assert_int_equal(h.count, 1);
        assert_int_equal(h.components[0].orientable, trial % 2);
        assert_true(h.components[0].closed && !h.components[0].oriented);
        done(&b, &h);
    }
}

static void test_contacts(void **state)
{
    (void)state;
    /* two boxes with a common edge: its four triangles balance */
    sample b = {0};
    sample_box(&b, (double[3]){0, 0, 0}, (double[3]){1, 1, 1});
    sample_box(&b, (double[3]){1, 0, 1}, (double[3]){2, 1, 2});
    mesh_health h = examine(&b, CLOSED_AUTO);
    assert_int_equal(h.count, 1);
    assert_int_equal(h.components[0].nonmanifold_edges, 1);
    assert_int_equal(h.components[0].nonmanifold_vertices, 0);
    assert_true(h.components[0].closed && h.components[0].oriented);
    done(&b, &h);

    /* two triangles of a fan with a common corner alone: a third joins them elsewhere */
    double p[6][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {-1, 1, 0}, {-1, 0, 0}, {0, 3, 0}};
    sample_points(&b, p[0], p[1], p[2]);
    sample_points(&b, p[0], p[3], p[4]);
    sample_points(&b, p[1], p[5], p[2]);
    sample_points(&b, p[4], p[3], p[5]);
    double q[3] = {0, 4, 0};
    sample_points(&b, p[5], p[2], q);
    sample_points(&b, p[5], q, p[3]);
    h = examine(&b, CLOSED_AUTO);
    assert_int_equal(h.count, 1);
    assert_int_equal(h.components[0].nonmanifold_vertices, 1);
    assert_int_equal(h.components[0].vertices, 7);
    assert_int_equal(h.components[0].nonmanifold_edges, 0);
    done(&b, &h);
}

static void test_flat_and_repeated(void **state)
{
    (void)state;
    sample b    = {0};
    double p[3] = {0, 0, 0}, q[3] = {1, 1, 1}, r[3] = {3, 3, 3}, o[3] = {1, 0, 0};
    sample_points(&b, p, q, r);
    sample_points(&b, p, q, o);
    sample_points(&b, o, p, q);
    sample_points(&b, q, p, o);                                                               /* the other way round counts too */
    sample_points(&b, p, p, o);                                                               /* collapses: in no component */
    sample_points(&b, (double[3]){0, 0, 9}, (double[3]){1, 0, 9}, (double[3]){0.5, 1e-9, 9}); /* a needle has an area */
    mesh_health h = examine(&b, CLOSED_AUTO);
    assert_int_equal(h.count, 2);
    assert_int_equal(h.collapsed_triangles, 1);
    assert_int_equal(h.total.zero_area_triangles, 1);
    assert_int_equal(h.components[0].repeated_triangles, 2);
    assert_int_equal(h.components[0].self_intersections, 0);
    done(&b, &h);
}

static void test_who_meets_whom(void **state)
{
    (void)state;
    sample b = {0};
    for (int i = 0; i < 5; i++) sample_cube(&b, 1.5 * i, 0.01 * i, 0.02 * i, 1); /* a chain */
    sample_cube(&b, 3, 50, 0, 1);
    sample_points(&b, (double[3]){0, 0, 0}, (double[3]){9, 0, 0}, (double[3]){0, 9, 0}); /* sheets do not count */
    mesh_health h = examine(&b, CLOSED_AUTO);
    assert_int_equal(h.total.meets, 8);
    for (uint32_t i = 0; i < 5; i++) {
        const component_health *k = &h.components[i];
        assert_int_equal(k->meets, i == 0 || i == 4 ? 1 : 2);
        assert_int_equal(component_faults(k), 0); /* that is none */
        assert_int_equal(h.met[k->meets_first], i ? i - 1 : 1);
        if (i && i < 4) assert_int_equal(h.met[k->meets_first + 1], i + 1);
        assert_int_equal(k->self_intersections, 0);
    }
    assert_int_equal(h.components[5].meets, 0);
    done(&b, &h);

    for (int i = 0; i < 100; i++) sample_cube(&b, 0.01 * i, 0.02 * i, 0.03 * i, 4);
    h = examine(&b, CLOSED_AUTO);
    assert_int_equal(h.total.meets, 100 * 99);
    done(&b, &h);
}

static void test_sizes(void **state)
{
    (void)state;
    static const double scales[][2] = {{0.01, 1e7}, {1e-6, 0}, {1e9, 0}};
    for (size_t i = 0; i < sizeof scales / sizeof *scales; i++) {
        sample b = {0};
        sample_cube(&b, 0, 0, 0, 64);
        sample_cube(&b, 0, 0, 100, 64);
        sample_klein_bottle(&b, 16);
        sample_map(&b, scales[i][0], scales[i][1]);
        mesh_health h = examine(&b, CLOSED_ON);
        assert_int_equal(h.total.meets, 2);
        assert_float_equal(h.components[0].volume_m3, pow(128 * scales[i][0], 3), 1e-3 * pow(128 * scales[i][0], 3));
        assert_false(h.total.orientable);
        done(&b, &h);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_sound_solids),   cmocka_unit_test(test_holes),    cmocka_unit_test(test_winding),
        cmocka_unit_test(test_one_sided),      cmocka_unit_test(test_contacts), cmocka_unit_test(test_flat_and_repeated),
        cmocka_unit_test(test_who_meets_whom), cmocka_unit_test(test_sizes),    cmocka_unit_test(test_sides_of_mixed_winding),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
