/* Solids that meet become one, with the same inside (baker/mend/mesh_union.h).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "tests/unit/mesh_sample.h"

#include "baker/mend/mesh_health.h"
#include "baker/mend/mesh_union.h"

static double solid_volume(const casters *c)
{
    return sample_volume(c->positions_ws, c->indices, c->solid_triangle_count);
}

/* Whatever was united: counts agree, every solid is closed and outward, and nothing is lost of the rest. */
static void check(const sample *b, const union_report *r, size_t solids_before)
{
    const casters *c     = &b->c;
    size_t         total = 0, all = 0, left = 0;
    for (int k = 0; k < COMPONENT_KINDS; k++) {
        all += c->component_count[k];
        total += c->triangles_of_kind[k];
    }
    assert_int_equal(total, c->triangle_count);
    assert_int_equal(c->triangles_of_kind[COMPONENT_SOLID], c->solid_triangle_count);
    for (int i = 0; i < UNITE_OUTCOMES; i++) left += r->total.left[i];
    assert_int_equal(left, r->total.solids);
    assert_int_equal(r->solids_after, solids_before - r->total.left[UNITED] + r->total.results);
    assert_int_equal(r->solids_after, c->component_count[COMPONENT_SOLID]);
    for (size_t t = 0; t < c->triangle_count; t++) {
        assert_true(c->component_of[t] < all);
        assert_int_equal(c->kind_of[c->component_of[t]] == COMPONENT_SOLID, t < c->solid_triangle_count);
        assert_true(c->indices[3 * t] < c->vertex_count);
    }
    mesh_health h;
    message     m = {.quiet = 1};
    assert_int_equal(mesh_health_examine(&h, c, NULL, &m), VXS_OK);
    for (size_t i = 0; i < c->component_count[COMPONENT_SOLID]; i++) {
        assert_true(h.components[i].closed && h.components[i].oriented);
        assert_true(h.components[i].volume_m3 > 0);
    }
    mesh_health_free(&h);
}

static union_report unite(sample *b, closed_mode closed)
{
    union_report r;
    sample_sort(b, closed);
    size_t solids = b->c.component_count[COMPONENT_SOLID];
    assert_int_equal(casters_unite(&b->c, &r, &b->m), VXS_OK);
    check(b, &r, solids);
    assert_int_equal(r.gave_up, 0);
    return r;
}

static void done(sample *b, union_report *r)
{
    union_report_free(r);
    sample_clear(b);
}

static size_t count_meeting(sample *b)
{
    assert_int_equal(casters_find_meeting(&b->c, 2, &b->m), VXS_OK);
    return b->c.meeting.meet;
}

static void test_pairs(void **state)
{
    (void)state;
    static const struct {
        double low[3], high[3], volume;
        size_t solids;
    } cases[] = {
        {{3, 1, 1}, {6, 2, 2}, 64 + 2, 1},                                         /* through a face */
        {{-1, 1, 1}, {6, 2, 2}, 64 + 3, 1},                                        /* right through */
        {{2, 2, 2}, {6, 6, 6}, 64 + 64 - 8, 1}, {{4, 1, 1}, {6, 2, 2}, 64 + 2, 1}, /* face on face */
        {{4, 1, 1}, {6, 3, 4}, 64 + 12, 1}, /* face on face, with a part of an edge in common */
        {{1, 1, 1}, {2, 2, 2}, 64, 1},      /* inside */
        {{-1, -1, -1}, {5, 5, 5}, 216, 1},  /* around */
        {{0, 1, 1}, {2, 2, 2}, 64, 1},      /* inside, on a face */
        {{5, 0, 0}, {6, 1, 1}, 64 + 1, 2},  /* apart: no cluster */
        {{4, 4, 1}, {6, 6, 2}, 64 + 4, 2},  /* edge on edge: their union is not a manifold */
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        for (int order = 0; order < 2; order++) {
            sample b = {0};
            for (int n = 0; n < 2; n++) {
                if (n == order) sample_box(&b, (double[3]){0, 0, 0}, (double[3]){4, 4, 4});
                if (n != order) sample_box(&b, cases[i].low, cases[i].high);
            }
            union_report r = unite(&b, CLOSED_ON);
            assert_float_equal(solid_volume(&b.c), cases[i].volume, 1e-9);
            assert_int_equal(r.solids_after, cases[i].solids);
            assert_int_equal(r.count, i == 8 ? 0 : 1);
            if (i == 9) assert_int_equal(r.clusters[0].left[UNITE_FAILED], 2);
            if (i < 9) assert_int_equal(count_meeting(&b), 0);
            done(&b, &r);
        }
}

static void test_what_is_left(void **state)
{
    (void)state;
    /* a solid that crosses itself stays, the two others of its cluster become one; sheets and masks are as before */
    sample        b          = {0};
    double        p[6][3]    = {{1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}, {0, 0, 1}, {3, 0, 0.5}};
    double        leaf[3][3] = {{9, 0, 0}, {9, 0, 1}, {9, 1, 0}};
    mask_triangle hole       = {.triangle = sample_triangle(&b, (const double(*)[3])leaf)};
    sample_points(&b, (double[3]){0, 0, 0}, (double[3]){9, 0, 0}, (double[3]){0, 9, 0});
    for (int i = 0; i < 4; i++) {
        sample_points(&b, p[i], p[(i + 1) % 4], p[4]);
        sample_points(&b, p[(i + 1) % 4], p[i], p[5]);
    }
    sample_cube(&b, 0, 0, -0.5, 0.75);
    sample_cube(&b, 0.25, 0.25, -1, 0.75);
    sample_cube(&b, 50, 0, 0, 1);
    b.s.mask_count = b.s.mask_triangle_count = 1;
    b.s.masks                                = calloc(1, sizeof *b.s.masks);
    b.s.mask_triangles                       = calloc(1, sizeof *b.s.mask_triangles);
    assert_non_null(b.s.masks);
    assert_non_null(b.s.mask_triangles);
    b.s.mask_triangles[0] = hole;
    union_report r        = unite(&b, CLOSED_ON);
    assert_int_equal(r.count, 1);
    assert_int_equal(r.clusters[0].solids, 3);
    assert_int_equal(r.clusters[0].left[UNITE_CROSSES_ITSELF], 1);
    assert_int_equal(r.clusters[0].left[UNITED], 2);
    assert_int_equal(r.solids_after, 3);
    const casters *c = &b.c;
    assert_int_equal(c->triangle_count - c->solid_triangle_count, 2);
    assert_int_equal(c->masked_first, c->triangle_count - 1);
    assert_int_equal(c->mask_first[0], c->masked_first);
    assert_int_equal(c->mask_first[1], c->triangle_count);
    for (int i = 0; i < 3; i++)
        assert_memory_equal(&c->positions_ws[3 * (size_t)c->indices[3 * c->masked_first + (size_t)i]], leaf[i], sizeof leaf[i]);
    assert_int_equal(c->kind_of[c->component_of[c->masked_first]], COMPONENT_SHEET_ALPHA_MASK);
    done(&b, &r);

    /* two boxes with a common edge, which are one solid, and a third */
    sample_box(&b, (double[3]){0, 0, 0}, (double[3]){1, 1, 1});
    sample_box(&b, (double[3]){1, 0, 1}, (double[3]){2, 1, 2});
    sample_cube(&b, 0.5, 0.5, 0, 0.25);
    r = unite(&b, CLOSED_ON);
    assert_int_equal(r.clusters[0].left[UNITE_NOT_MANIFOLD], 1);
    assert_int_equal(r.clusters[0].left[UNITE_FAILED], 1); /* nobody is left to unite it with */
    assert_int_equal(r.solids_after, 2);
    done(&b, &r);

    /* no solids at all */
    sample_points(&b, p[0], p[1], p[2]);
    r = unite(&b, CLOSED_AUTO);
    assert_int_equal(r.count, 0);
    done(&b, &r);
}

static void test_cavity(void **state)
{
    (void)state;
    /* six slabs around an empty room: the surface is in two parts, and one solid */
    sample b = {0};
    for (int axis = 0; axis < 3; axis++)
        for (int upper = 0; upper < 2; upper++) {
            double low[3] = {0, 0, 0}, high[3] = {10, 10, 10};
            low[axis]  = upper ? 9 : 0;
            high[axis] = upper ? 10 : 1;
            for (int other = 0; other < axis; other++) low[other] += 0.5, high[other] -= 0.5; /* so that few edges coincide */
            sample_box(&b, low, high);
        }
    sample_sort(&b, CLOSED_AUTO);
    assert_int_equal(b.c.component_count[COMPONENT_SOLID], 6);
    union_report r = unite(&b, CLOSED_AUTO);
    assert_int_equal(r.solids_after, 1);
    assert_int_equal(count_meeting(&b), 0);
    for (int n = 0; n < 2; n++) {
        double at[3] = {5, 5, n ? 0.75 : 5};
        assert_float_equal(sample_winding(b.c.positions_ws, b.c.indices, b.c.solid_triangle_count, at), n, 1e-6);
    }
    done(&b, &r);
}

/* Whole boxes: the volume of their union is the number of cells that any of them holds. */
static void test_random_boxes(void **state)
{
    (void)state;
    enum { BOXES = 8, SIDE = 12 };
    uint32_t seed   = 2;
    size_t   united = 0, solids = 0;
    for (int trial = 0; trial < 60; trial++) {
        static uint8_t cells[SIDE][SIDE][SIDE];
        sample         b    = {0};
        double         both = 0, cell_count = 0;
        memset(cells, 0, sizeof cells);
        for (int i = 0; i < BOXES; i++) {
            int low[3], high[3];
            for (int axis = 0; axis < 3; axis++) {
                low[axis] = (int)sample_random(&seed, SIDE - 1);
                high[axis] =
                    low[axis] + 1 + (int)sample_random(&seed, (uint32_t)(SIDE - 1 - low[axis] < 5 ? SIDE - 1 - low[axis] : 5));
            }
            sample_box(&b, (double[3]){low[0], low[1], low[2]}, (double[3]){high[0], high[1], high[2]});
            for (int x = low[0]; x < high[0]; x++)
                for (int y = low[1]; y < high[1]; y++)
                    for (int z = low[2]; z < high[2]; z++) cells[x][y][z]++;
        }
        for (int i = 0; i < SIDE * SIDE * SIDE; i++) {
            cell_count += (&cells[0][0][0])[i] > 0;
            both += (&cells[0][0][0])[i];
        }
        union_report r     = unite(&b, CLOSED_ON);
        size_t       whole = r.total.left[UNITED] == r.total.solids && r.total.results == r.count;
        if (whole) assert_float_equal(solid_volume(&b.c), cell_count, 1e-9);
        if (!whole) assert_true(solid_volume(&b.c) >= cell_count - 1e-9 && solid_volume(&b.c) <= both + 1e-9);
        united += r.total.left[UNITED];
        solids += r.total.solids;
        /* in the middle of each cell, one or more solids are there exactly when a box is */
        for (int n = 0; n < 100; n++) {
            uint32_t x = sample_random(&seed, SIDE), y = sample_random(&seed, SIDE), z = sample_random(&seed, SIDE);
            double   at[3] = {x + 0.4, y + 0.5, z + 0.6};
            double   w     = sample_winding(b.c.positions_ws, b.c.indices, b.c.solid_triangle_count, at);
            assert_true(fabs(w - round(w)) < 1e-6);
            assert_int_equal(w > 0.5, cells[x][y][z] > 0);
            if (whole) assert_true(w < 1.5);
        }
        done(&b, &r);
    }
    assert_true(united > solids / 2);
}

/* Balls, whose crossings are at positions that no double holds. */
static void test_random_balls(void **state)
{
    (void)state;
    static const double scales[][2] = {{1, 0}, {0.01, 1e7}, {1e-6, 0}, {1e-6, 1}};
    uint32_t            seed        = 4;
    for (int trial = 0; trial < 16; trial++) {
        const double *scale = scales[trial % 4];
        sample        b     = {0};
        double        at[6][3];
        for (int i = 0; i < 6; i++) {
            for (int axis = 0; axis < 3; axis++) at[i][axis] = 2.5 * sample_uniform(&seed);
            sample_ball(&b, at[i], 1, 6 + i);
        }
        sample_map(&b, scale[0], scale[1]);
        sample_sort(&b, CLOSED_AUTO);
        casters before = b.c;
        b.c            = (casters){0};
        union_report r = unite(&b, CLOSED_AUTO);
        assert_int_equal(r.total.left[UNITED], r.total.solids);
        assert_int_equal(r.total.results, r.count);
        for (int n = 0; n < 500; n++) {
            double p[3];
            for (int axis = 0; axis < 3; axis++) p[axis] = (-1 + 4.5 * sample_uniform(&seed)) * scale[0] + scale[1];
            double was = sample_winding(before.positions_ws, before.indices, before.solid_triangle_count, p);
            double is  = sample_winding(b.c.positions_ws, b.c.indices, b.c.solid_triangle_count, p);
            if (fabs(was - round(was)) > 1e-6) continue; /* on a surface, as nearly as solid angles tell */
            assert_true(fabs(is - (was > 0.5)) < 1e-3);
        }
        if (trial % 4 == 0) assert_int_equal(count_meeting(&b), 0);
        casters_free(&before);
        done(&b, &r);
    }
}

static void test_nested_and_crossing_cubes(void **state)
{
    (void)state;
    sample b = {0};
    for (int i = 0; i < 100; i++) sample_cube(&b, 0, 0, 0, 100 - i);
    union_report r = unite(&b, CLOSED_ON);
    assert_int_equal(r.solids_after, 1);
    assert_int_equal(r.triangles_after, 12);
    assert_float_equal(solid_volume(&b.c), 8e6, 1e-6);
    done(&b, &r);

    double volume = 0;
    for (int i = 0; i < 100; i++) {
        sample_cube(&b, i, 2 * i, 3 * i, 400);
        volume += i ? 800.0 * 800 * 800 - 799.0 * 798 * 797 : 800.0 * 800 * 800; /* what each adds to the one before */
    }
    r = unite(&b, CLOSED_AUTO);
    assert_int_equal(r.solids_after, 1);
    assert_float_equal(solid_volume(&b.c), volume, 1e-3);
    assert_int_equal(count_meeting(&b), 0);
    done(&b, &r);
}

static void test_large_clusters_are_left(void **state)
{
    (void)state;
    sample b = {0};
    sample_ball(&b, (double[3]){0, 0, 0}, 1, 80);
    sample_ball(&b, (double[3]){0.5, 0.25, 0.125}, 1, 80);
    sample_cube(&b, 10, 0, 0, 1);
    sample_cube(&b, 11, 0.5, 0.25, 1);
    union_report r = unite(&b, CLOSED_AUTO);
    assert_int_equal(r.count, 2);
    assert_true(r.clusters[0].triangles > UNION_TRIANGLES_MAX);
    assert_int_equal(r.clusters[0].left[UNITE_TOO_LARGE], 2);
    assert_int_equal(r.clusters[1].left[UNITED], 2);
    assert_int_equal(r.solids_after, 3);
    done(&b, &r);
}

static void test_names(void **state)
{
    (void)state;
    for (int i = 0; i < UNITE_OUTCOMES; i++)
        for (int j = 0; j < i; j++)
            assert_string_not_equal(unite_outcome_name((unite_outcome)i), unite_outcome_name((unite_outcome)j));
    assert_string_equal(unite_outcome_name(UNITED), "united");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_pairs),
        cmocka_unit_test(test_what_is_left),
        cmocka_unit_test(test_cavity),
        cmocka_unit_test(test_random_boxes),
        cmocka_unit_test(test_random_balls),
        cmocka_unit_test(test_nested_and_crossing_cubes),
        cmocka_unit_test(test_large_clusters_are_left),
        cmocka_unit_test(test_names),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
