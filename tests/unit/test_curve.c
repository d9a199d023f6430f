/* Transmittance curves of runtime/volumes/vxs_curve.h against the product of what each segment lets through, in double, and in a
 * shader against C in float, to the bit but for exponentials.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/opengl/gl.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "random_light.h"
#include "repeats.h"

/* last: cmocka's macro fail() hides the function of run_context.h, and it needs the four headers above */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "runtime/volumes/vxs_curve.h"

static const int node_counts[] = {4, 8, 12, 16};
enum { NODE_COUNTS = sizeof node_counts / sizeof *node_counts };

typedef struct segment {
    double entry, exit, through;
} segment;

/* The light that even smoke in a segment leaves at a depth; a step lets it through behind it. */
static double left_by(const segment *s, double depth)
{
    if (depth >= s->exit) return s->through;
    if (depth <= s->entry) return 1;
    return pow(s->through, (depth - s->entry) / (s->exit - s->entry));
}

static double left_by_all(const segment *s, int count, double depth)
{
    double left = 1;
    for (int n = 0; n < count; n++) left *= left_by(&s[n], depth);
    return left;
}

static int by_depth(const void *a, const void *b)
{
    double x = ((const segment *)a)->entry, y = ((const segment *)b)->entry;
    return (x > y) - (x < y);
}

static void shuffle(rng *r, segment *s, int count)
{
    for (int n = count - 1; n > 0; n--) {
        uint32_t k    = rng_below(r, (uint32_t)n + 1);
        segment  swap = s[n];
        s[n]          = s[k];
        s[k]          = swap;
    }
}

/* Puffs of smoke in three clusters, and a tenth of them hairs. */
static void clusters(rng *r, segment *s, int count)
{
    double middles[3] = {uniform(r, 5, 25), uniform(r, 35, 60), uniform(r, 70, 95)};
    for (int n = 0; n < count; n++) {
        int    hair   = !rng_below(r, 10);
        double middle = middles[rng_below(r, 3)] + uniform(r, -5, 5), length = hair ? 0.02 : uniform(r, 0.5, 4);
        s[n] =
            (segment){middle - length / 2, middle + length / 2, hair ? uniform(r, 0.5, 0.9) : exp(-length * uniform(r, 0, 0.04))};
    }
}

/* Whatever may meet: depths on a lattice, so that nodes fall together; steps; what is opaque, and what is hardly there. */
static void anything(rng *r, segment *s, int count)
{
    for (int n = 0; n < count; n++) {
        double entry   = rng_below(r, 2) ? rng_between(r, -8, 8) : uniform(r, -1e3, 1e3) * exp(uniform(r, -20, 20));
        double length  = rng_below(r, 3) ? rng_between(r, 0, 3) : exp(uniform(r, -30, 5));
        double through = rng_below(r, 50) ? exp(-exp(uniform(r, -20, 2))) : rng_below(r, 2);
        s[n]           = (segment){entry, entry + length, through};
    }
}

static vxs_curve curve_of(const segment *s, int count, int nodes)
{
    vxs_curve c = vxs_curve_empty();
    for (int n = 0; n < count; n++) vxs_curve_insert(&c, nodes, s[n].entry, s[n].exit, s[n].through);
    return c;
}

static void check_curve(const vxs_curve *c, int nodes)
{
    assert_in_range(c->count, 0, nodes);
    for (int n = 0; n < c->count; n++) {
        assert_true(isfinite(c->depth[n]) && c->left[n] >= 0 && c->left[n] <= 1);
        if (n) assert_true(c->depth[n] >= c->depth[n - 1] && c->left[n] <= c->left[n - 1]);
    }
}

/* tests ------------------------------------------------------------------------------------------------------------------------ */

/* Of no segments and of any, after each of them; between nodes, too. */
static void test_t_never_rises(void **state)
{
    (void)state;
    rng r = {1};
    for (uint32_t k = 0; k < repeats(300, 5000); k++) {
        enum { SEGMENTS = 60 };
        segment   s[SEGMENTS];
        int       nodes = node_counts[k % NODE_COUNTS];
        vxs_curve c     = vxs_curve_empty();
        anything(&r, s, SEGMENTS);
        for (int n = 0; n < SEGMENTS; n++) {
            check_curve(&c, nodes);
            vxs_curve_insert(&c, nodes, s[n].entry, s[n].exit, s[n].through);
        }
        check_curve(&c, nodes);
        for (int exponential = 0; exponential < 2; exponential++) {
            double before = 1;
            for (double depth = -10; depth < 12; depth += 0.0625) {
                double left = vxs_curve_at(&c, depth, exponential);
                assert_true(left >= 0 && left <= before);
                before = left;
            }
        }
    }
}

/* Behind all of them, in whatever order they come. */
static void test_t_last_is_the_product_in_any_order(void **state)
{
    (void)state;
    rng r = {2};
    for (uint32_t k = 0; k < repeats(300, 5000); k++) {
        enum { SEGMENTS = 40 };
        segment s[SEGMENTS];
        if (k & 1)
            clusters(&r, s, SEGMENTS);
        else
            anything(&r, s, SEGMENTS);
        double wanted = left_by_all(s, SEGMENTS, INFINITY);
        for (int order = 0; order < 4; order++) {
            vxs_curve c = curve_of(s, SEGMENTS, node_counts[k % NODE_COUNTS]);
            assert_true(fabs(c.left[c.count - 1] - wanted) < 1e-12);
            shuffle(&r, s, SEGMENTS);
        }
    }
}

/* Thin segments that do not meet, with two nodes for each: the truth at each node, and a line or an exponential between. */
static void test_disjoint_segments_are_exact(void **state)
{
    (void)state;
    rng r = {3};
    for (uint32_t k = 0; k < repeats(300, 5000); k++) {
        int     nodes = node_counts[k % NODE_COUNTS], count = nodes / 2;
        segment s[VXS_CURVE_MOST / 2];
        double  depth = uniform(&r, -10, 10);
        for (int n = 0; n < count; n++) {
            double entry = depth + uniform(&r, 0.1, 3);
            depth        = entry + uniform(&r, 0.1, 3);
            s[n]         = (segment){entry, depth, uniform(&r, 0.75, 1)};
        }
        shuffle(&r, s, count);
        vxs_curve c = curve_of(s, count, nodes);
        assert_int_equal(c.count, nodes);
        for (int n = 0; n < nodes; n++) assert_true(fabs(c.left[n] - left_by_all(s, count, c.depth[n])) < 1e-12);
        for (double at = -12; at < 70; at += 0.37) assert_true(fabs(vxs_curve_at(&c, at, 1) - left_by_all(s, count, at)) < 1e-12);
        for (int n = 0; n < nodes; n += 2) {
            double middle = (c.depth[n] + c.depth[n + 1]) / 2, line = (c.left[n] + c.left[n + 1]) / 2;
            assert_true(fabs(vxs_curve_at(&c, middle, 0) - line) < 1e-12);
        }
    }
}

/* entry == exit is a step; steps at one depth are one; and segments that begin or end at a node multiply there. */
static void test_coincident_nodes(void **state)
{
    (void)state;
    const segment steps[]  = {{5, 5, 0.5}, {5, 5, 0.5}, {5, 5, 0.8}, {5, 5, 0.9}};
    const segment joined[] = {{2, 4, 0.5}, {4, 6, 0.5}, {2, 6, 0.25}, {4, 4, 0.5}};
    const segment behind[] = {{3, 4, 0.9}, {5, 5, 0.5}, {5, 7, 0.5}, {4.5, 5, 0.8}};
    for (int exponential = 0; exponential < 2; exponential++) {
        vxs_curve c = curve_of(behind, 4, 16); /* what begins or ends at a step leaves it upright */
        assert_float_equal(vxs_curve_at(&c, 4.5, exponential), 0.9, 1e-12);
        assert_float_equal(vxs_curve_at(&c, 5 - 1e-12, exponential), 0.9 * 0.8, 1e-9);
        assert_float_equal(vxs_curve_at(&c, 5, exponential), 0.9 * 0.8 * 0.5, 1e-12);
        c = curve_of(steps, 4, 4);
        assert_float_equal(vxs_curve_at(&c, 5 - 1e-9, exponential), 1, 1e-12);
        assert_float_equal(vxs_curve_at(&c, 5, exponential), 0.5 * 0.5 * 0.8 * 0.9, 1e-12);
        c = curve_of(joined, 4, 16);
        assert_float_equal(vxs_curve_at(&c, 2, exponential), 1, 1e-12);
        assert_float_equal(vxs_curve_at(&c, 4 - 1e-12, exponential), 0.5 * 0.5, 1e-3); /* the third is an exponential, nearly */
        assert_float_equal(vxs_curve_at(&c, 4, exponential), 0.5 * 0.5 * 0.5, 1e-3);
        assert_float_equal(vxs_curve_at(&c, 6, exponential), 0.25 * 0.25 * 0.5, 1e-12);
    }
}

/* Behind what is opaque there is no light, before it there is, and no exponential of it is a number that is none. */
static void test_t_is_0(void **state)
{
    (void)state;
    const segment s[] = {{1, 3, 0.5}, {8, 8, 0}, {4, 6, 0.5}, {9, 12, 0.5}, {7, 9, 0}};
    for (int exponential = 0; exponential < 2; exponential++) {
        vxs_curve c = curve_of(s, 5, 16), alone = curve_of(s + 4, 1, 4);
        assert_true(vxs_curve_at(&c, 8, exponential) == 0 && vxs_curve_at(&c, 1e9, exponential) == 0);
        assert_float_equal(vxs_curve_at(&c, 6.5, exponential), 0.25, 1e-12);
        assert_true(vxs_curve_at(&alone, 7, exponential) > 0.99 &&
                    vxs_curve_at(&alone, 8, exponential) < 1e-3); /* opaque from its entry on */
        for (double at = 0; at < 14; at += 0.01) assert_true(isfinite(vxs_curve_at(&c, at, exponential)));
    }
}

/* What is no segment changes nothing. */
static void test_empty_segments(void **state)
{
    (void)state;
    const segment none[] = {{1, 2, 1},   {1, 2, 1.5},        {2, 1, 0.5},         {NAN, 2, 0.5},          {1, NAN, 0.5},
                            {1, 2, NAN}, {1, INFINITY, 0.5}, {-INFINITY, 1, 0.5}, {1, VXS_CURVE_FAR, 0.5}};
    const segment one    = {3, 4, 0.5};
    vxs_curve     c      = curve_of(none, sizeof none / sizeof *none, 8);
    assert_int_equal(c.count, 0);
    assert_true(vxs_curve_at(&c, 5, 0) == 1 && vxs_curve_at(&c, 5, 1) == 1);
    c         = curve_of(&one, 1, 8);
    int count = c.count;
    for (size_t n = 0; n < sizeof none / sizeof *none; n++) vxs_curve_insert(&c, 8, none[n].entry, none[n].exit, none[n].through);
    assert_int_equal(c.count, count);
    vxs_curve_insert(&c, 8, 5, 6, -1); /* no less than nothing */
    assert_true(vxs_curve_at(&c, 6, 0) == 0);
}

/* RMS and the largest error of a curve, at depths along all of it. */
static void errors_of(const vxs_curve *c, const segment *s, int count, double begin, double end, double *square, double *most)
{
    enum { DEPTHS = 400 };
    for (int n = 0; n < DEPTHS; n++) {
        double at = begin + (end - begin) * (n + 0.5) / DEPTHS, error = fabs(vxs_curve_at(c, at, 0) - left_by_all(s, count, at));
        *square += error * error / DEPTHS;
        *most = fmax(*most, error);
    }
}

/* One thick segment, many thin ones at one place, and thick ones that overlap: nodes are where the curve is steep, and errors fall
 * with their number. */
static void test_thick_segments(void **state)
{
    (void)state;
    enum { SEGMENTS = 500, KINDS = 3 };
    static const char *const kinds[KINDS]            = {"a thick one", "500 at one place", "thick ones that overlap"};
    static const double      rms[KINDS][NODE_COUNTS] = {
             {0.06, 0.015, 0.01, 0.01}, {0.12, 0.035, 0.012, 0.01}, {0.07, 0.015, 0.006, 0.005}};
    for (int kind = 0; kind < KINDS; kind++)
        for (int k = 0; k < NODE_COUNTS; k++) {
            rng      r      = {9};
            double   square = 0, most = 0;
            uint32_t curves = repeats(20, 200);
            for (uint32_t n = 0; n < curves; n++) {
                static segment s[SEGMENTS];
                int            count = kind == 0 ? 1 : kind == 1 ? SEGMENTS : 2 + (int)rng_below(&r, 4);
                double         depth = uniform(&r, 2, kind == 1 ? 20 : 30), end = 0;
                for (int i = 0; i < count; i++) {
                    double entry = kind == 2 ? uniform(&r, 0, 60) : 10, exit = entry + (kind == 2 ? uniform(&r, 1, 20) : 20);
                    s[i] = (segment){entry, exit, exp(kind == 2 ? -uniform(&r, 0.5, 8) : -depth / count)};
                    end  = fmax(end, exit);
                }
                vxs_curve c = curve_of(s, count, node_counts[k]);
                check_curve(&c, node_counts[k]);
                assert_true(fabs(c.left[c.count - 1] - left_by_all(s, count, INFINITY)) < 1e-12);
                errors_of(&c, s, count, 0, end, &square, &most);
            }
            print_message("%s, %2d nodes: an RMS of %.4f, %.3f at most\n", kinds[kind], node_counts[k], sqrt(square / curves),
                          most);
            assert_true(sqrt(square / curves) < rms[kind][k]);
        }
}

static void test_10000_segments_in_a_texel(void **state)
{
    (void)state;
    enum { SEGMENTS = 10000 };
    segment *s = malloc(SEGMENTS * sizeof *s);
    rng      r = {4};
    assert_non_null(s);
    for (int n = 0; n < SEGMENTS; n++) {
        double entry = uniform(&r, 0, 100);
        s[n]         = (segment){entry, entry + uniform(&r, 0, 1), exp(-uniform(&r, 0, 4e-4))};
    }
    for (int sorted = 0; sorted < 2; sorted++) {
        double square = 0;
        if (sorted) qsort(s, SEGMENTS, sizeof *s, by_depth);
        vxs_curve c = curve_of(s, SEGMENTS, 8);
        check_curve(&c, 8);
        for (int n = 0; n <= 100; n++) {
            double error = vxs_curve_at(&c, n, 0) - left_by_all(s, SEGMENTS, n);
            square += error * error / 101;
        }
        assert_true(fabs(c.left[c.count - 1] - left_by_all(s, SEGMENTS, INFINITY)) < 1e-12);
        print_message("10000 segments, %s: an RMS of %.4f\n", sorted ? "sorted" : "unsorted", sqrt(square));
        assert_true(sqrt(square) < 0.015);
    }
    free(s);
}

/* Stored and read again: the same, at nodes, between them and beyond, with any number of nodes used; and all of it finite. */
static void test_sentinel_depths_are_finite(void **state)
{
    (void)state;
    rng r = {5};
    for (uint32_t k = 0; k < repeats(400, 5000); k++) {
        segment s[12];
        float   stored[2 * VXS_CURVE_MOST];
        int     nodes = node_counts[k % NODE_COUNTS], count = (int)rng_below(&r, 13);
        anything(&r, s, count);
        vxs_curve c = curve_of(s, count, nodes);
        vxs_curve_pad(&c, nodes);
        for (int n = 0; n < nodes; n++) {
            stored[2 * n]     = (float)c.depth[n];
            stored[2 * n + 1] = (float)c.left[n];
            assert_true(isfinite(stored[2 * n]));
            c.depth[n] = (double)stored[2 * n]; /* as floats have it */
            c.left[n]  = (double)stored[2 * n + 1];
        }
        for (int n = 0; n < 100; n++) {
            double at = n < 60 ? uniform(&r, -10, 12) : n < 99 ? c.depth[rng_below(&r, (uint32_t)nodes)] : 1e29;
            for (int exponential = 0; exponential < 2; exponential++) {
                double found = vxs_curve_read(stored, 0, nodes, at, exponential);
                assert_true(isfinite(found));
                if (at < VXS_CURVE_FAR) assert_true(found == vxs_curve_at(&c, at, exponential));
            }
        }
    }
}

/* Errors fall with nodes; sorted by depth they are less; with few nodes the order matters. Figures of docs/measurements.md. */
static void test_errors_by_nodes(void **state)
{
    (void)state;
    enum { SEGMENTS = 64, DEPTHS = 256 };
    static const double most[NODE_COUNTS] = {0.06, 0.02, 0.009, 0.005};
    for (int k = 0; k < NODE_COUNTS; k++) {
        rng      r       = {6};
        uint32_t curves  = repeats(150, 1000);
        double   sums[2] = {0}, change = 0;
        for (uint32_t n = 0; n < curves; n++) {
            segment   s[SEGMENTS];
            vxs_curve made[3]; /* unsorted, unsorted from behind, sorted */
            clusters(&r, s, SEGMENTS);
            made[0] = curve_of(s, SEGMENTS, node_counts[k]);
            for (int i = 0; i < SEGMENTS / 2; i++) {
                segment swap        = s[i];
                s[i]                = s[SEGMENTS - 1 - i];
                s[SEGMENTS - 1 - i] = swap;
            }
            made[1] = curve_of(s, SEGMENTS, node_counts[k]);
            qsort(s, SEGMENTS, sizeof *s, by_depth);
            made[2]       = curve_of(s, SEGMENTS, node_counts[k]);
            double differ = 0;
            for (int i = 0; i < DEPTHS; i++) {
                double at = 100 * (i + 0.5) / DEPTHS, wanted = left_by_all(s, SEGMENTS, at),
                       unsorted = vxs_curve_at(&made[0], at, 0);
                sums[0] += pow(unsorted - wanted, 2);
                sums[1] += pow(vxs_curve_at(&made[2], at, 0) - wanted, 2);
                differ = fmax(differ, fabs(unsorted - vxs_curve_at(&made[1], at, 0)));
            }
            change += differ / curves;
        }
        double unsorted = sqrt(sums[0] / curves / DEPTHS), sorted = sqrt(sums[1] / curves / DEPTHS);
        print_message("%2d nodes: RMS sorted %.4f, unsorted %.4f; reversed differs by %.3f\n", node_counts[k], sorted, unsorted,
                      change);
        assert_true(sorted < most[k] && sorted < unsorted && unsorted < 1.5 * sorted);
        assert_true(change > 5 * sorted * (k > 0 ? 1 : 0.1));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_t_never_rises),
        cmocka_unit_test(test_t_last_is_the_product_in_any_order),
        cmocka_unit_test(test_disjoint_segments_are_exact),
        cmocka_unit_test(test_coincident_nodes),
        cmocka_unit_test(test_t_is_0),
        cmocka_unit_test(test_empty_segments),
        cmocka_unit_test(test_thick_segments),
        cmocka_unit_test(test_10000_segments_in_a_texel),
        cmocka_unit_test(test_sentinel_depths_are_finite),
        cmocka_unit_test(test_errors_by_nodes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
