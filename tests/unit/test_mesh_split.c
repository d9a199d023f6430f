/* Borders that meet: afterwards they have the same vertices, and nothing else has changed.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/casters/mesh_edges.h" /* before cmocka, whose fail() is a macro */
#include "tests/columns/panels.h"
#include "tests/unit/mesh_sample.h"
#include "tests/unit/repeats.h"

static void add_quad(sample *b, const double a[3], const double p[3], const double c[3], const double d[3])
{
    sample_points(b, a, p, c);
    sample_points(b, a, c, d);
}

/* A rectangle in the plane z = 0. */
static void add_flat(sample *b, double x0, double y0, double x1, double y1)
{
    const double p[4][3] = {{x0, y0, 0}, {x1, y0, 0}, {x1, y1, 0}, {x0, y1, 0}};
    add_quad(b, p[0], p[1], p[2], p[3]);
}

/* All triangles from then on are counted from there. */
static void add_origin(sample *b, double x, double y, double z)
{
    b->s.origins                      = sample_grown(b->s.origins, (b->s.origin_count + 1) * sizeof *b->s.origins);
    b->s.origins[b->s.origin_count++] = (scene_origin){(uint32_t)b->s.triangle_count, {x, y, z}};
}

static void sort_for_maps(sample *b, closed_mode closed)
{
    casters_free(&b->c);
    assert_int_equal(casters_for_maps(&b->c, &b->s, closed, 2, &b->m), VXS_OK);
}

static void clear(sample *b)
{
    free(b->s.origins);
    sample_clear(b);
}

/* Open edges of casters, by half-edges. */
static size_t count_open(const casters *c, int (*counts)(const void *user, const double *a, const double *b), const void *user)
{
    uint32_t  edges  = (uint32_t)(3 * c->triangle_count);
    uint32_t *sorted = malloc(edges * sizeof *sorted);
    size_t    count  = 0;
    assert_non_null(sorted);
    assert_int_equal(mesh_sort_edges(sorted, c->indices, c->triangle_count, c->vertex_count, 1), VXS_OK);
    for (uint32_t begin = 0, end; begin < edges; begin = end) {
        uint32_t h = sorted[begin];
        end        = mesh_edge_run(c->indices, sorted, begin, edges);
        count += mesh_edge_balance(c->indices, sorted, begin, end) &&
                 (!counts || counts(user, c->positions_ws + 3 * (size_t)c->indices[h],
                                    c->positions_ws + 3 * (size_t)mesh_edge_end(c->indices, h)));
    }
    free(sorted);
    return count;
}

static double area_of(const casters *c)
{
    double sum = 0;
    for (size_t t = 0; t < c->triangle_count; t++) {
        double e[2][3], n[3];
        for (int k = 0; k < 2; k++)
            for (int axis = 0; axis < 3; axis++)
                e[k][axis] = c->positions_ws[3 * (size_t)c->indices[3 * t + 1 + (size_t)k] + (size_t)axis] -
                             c->positions_ws[3 * (size_t)c->indices[3 * t] + (size_t)axis];
        cross(e[0], e[1], n);
        sum += sqrt(dot(n, n)) / 2;
    }
    return sum;
}

static void expect_borders(const sample *b, size_t edges, size_t split, size_t added, size_t joined)
{
    const border_counts *n = &b->c.borders;
    assert_int_equal(n->edges, edges);
    assert_int_equal(n->split, split);
    assert_int_equal(n->added, added);
    assert_int_equal(n->joined, joined);
    assert_int_equal(n->left, 0);
    assert_int_equal(b->c.triangle_count, casters_whole_count(&b->c) + added);
}

static void edges_are_split_at_vertices(void **state)
{
    sample b = {0};
    (void)state;
    add_flat(&b, 0, 0, 2, 1);
    add_flat(&b, 0, 1, 0.5, 2);
    add_flat(&b, 0.5, 1, 2, 2);
    sort_for_maps(&b, CLOSED_AUTO);
    expect_borders(&b, 10, 1, 1, 0); /* the long edge, at 0.5 */
    assert_int_equal(count_open(&b.c, NULL, NULL), 7);
    sample_sort(&b, CLOSED_AUTO);
    expect_borders(&b, 0, 0, 0, 0);
    assert_int_equal(count_open(&b.c, NULL, NULL), 10);
    clear(&b);

    /* points on all three sides of a triangle, and several on each */
    const double corner[3][3] = {{0, 0, 0}, {8, 0, 0}, {0, 8, 0}};
    sample_points(&b, corner[0], corner[1], corner[2]);
    for (int n = 0; n < 4; n++) {
        add_flat(&b, 2 * n, -1, 2 * n + 2, 0);
        add_flat(&b, -1, 2 * n, 0, 2 * n + 2);
        double p[4][3] = {{2 * n, 8 - 2 * n, 0}, {2 * n + 2, 6 - 2 * n, 0}, {9, 9, 0}};
        sample_points(&b, p[0], p[1], p[2]);
    }
    sort_for_maps(&b, CLOSED_AUTO);
    expect_borders(&b, 3 + 2 * 10 + 6, 3, 9, 0);
    assert_int_equal(count_open(&b.c, NULL, NULL), 2 * 6 + 2);
    assert_true(fabs(area_of(&b.c) - (32 + 16 + 4 * (9 + 9 - 8))) < 1e-9);
    clear(&b);
}

/* Where an open edge lies on none of the outer sides of all panels. */
static int is_inner(const void *user, const double *a, const double *b)
{
    const panels *p = user;
    double        middle[3], away = 0;
    for (int n = 0; n < 3; n++) middle[n] = (a[n] + b[n]) / 2;
    for (int k = 0; k < 8; k++) { /* of points around, each is on some panel */
        double least = INFINITY, at[3];
        for (int n = 0; n < PANELS; n++) {
            const double(*q)[3] = p->corners[n];
            double x[3], y[3], z[3], d[3], angle = k * acos(-1) / 4;
            for (int i = 0; i < 3; i++) x[i] = q[1][i] - q[0][i], y[i] = q[3][i] - q[0][i];
            cross(x, y, z);
            for (int i = 0; i < 3; i++) at[i] = middle[i] + 0.01 * (cos(angle) * x[i] + sin(angle) * y[i]) - q[0][i], d[i] = at[i];
            double u = dot(d, x), v = dot(d, y), beyond = fmax(fmax(-u, u - 1), fmax(-v, v - 1));
            least = fmin(least, fmax(beyond, fabs(dot(d, z)) - 0.02));
        }
        away = fmax(away, least);
    }
    return away < 1e-3;
}

static void seams_of_panels_close(void **state)
{
    size_t         before = 0;
    const uint32_t seeds  = repeats(60, 200);
    (void)state;
    for (uint64_t seed = 0; seed < seeds; seed++) {
        panels      p = panels_make(seed, 0);
        casters     c;
        run_context m = {0};
        assert_non_null(p.s.positions_ws);
        assert_int_equal(casters_from_scene(&c, &p.s, CLOSED_AUTO, 2, &m), VXS_OK);
        before += count_open(&c, is_inner, &p);
        double area = area_of(&c);
        casters_free(&c);
        assert_int_equal(casters_for_maps(&c, &p.s, CLOSED_AUTO, 2, &m), VXS_OK);
        assert_int_equal(count_open(&c, is_inner, &p), 0);
        assert_true(fabs(area_of(&c) - area) < 1e-4);
        casters_free(&c);
        panels_free(&p);
    }
    assert_true(before > seeds * 40);
}

/* Two sheets at a distance across their seam; what becomes one of it, counted from that far. */
static size_t joined_at(double gap, double from)
{
    sample b = {0};
    add_origin(&b, -from, 0, 0);
    add_flat(&b, 0, 0, 1, 1);
    add_flat(&b, 0, 1 + gap, 1, 2);
    sort_for_maps(&b, CLOSED_AUTO);
    size_t joined = b.c.borders.joined;
    clear(&b);
    return joined;
}

static void rounding_is_joined_and_gaps_are_not(void **state)
{
    double step = ldexp(1, -23);
    (void)state;
    assert_int_equal(joined_at(7 * step, 0.5), 2); /* edges that end between 1 and 2 m from there */
    assert_int_equal(joined_at(17 * step, 0.5), 0);
    assert_int_equal(joined_at(17 * step, 1000), 2);
    assert_int_equal(joined_at(1e-3, 1000), 0);
    assert_int_equal(joined_at(1e-3, 1e5), 2);

    /* what came from no file is a double; and a scene far from everything is as fine as what its nodes are counted from */
    sample b = {0};
    for (int n = 0; n < 2; n++) {
        if (n) add_origin(&b, 1e7, 0, 0);
        add_flat(&b, 1e7, 0, 1e7 + 1, 1);
        add_flat(&b, 1e7, 1 + 1e-5, 1e7 + 1, 2);
        sort_for_maps(&b, CLOSED_AUTO);
        expect_borders(&b, 8, 0, 0, 0);
        clear(&b);
    }
}

/* Triangles smaller than rounding keep their corners. */
static void no_triangle_collapses(void **state)
{
    rng    r = rng_split(3, 3);
    sample b = {0};
    (void)state;
    add_origin(&b, -1e4, 0, 0); /* eight steps are 8 mm there */
    for (int n = 0; n < 3000; n++) {
        double p[3][3];
        for (int k = 0; k < 9; k++) p[k / 3][k % 3] = uniform(&r, 0, n % 2 ? 0.1 : 0.004);
        sample_points(&b, p[0], p[1], p[2]);
    }
    sort_for_maps(&b, CLOSED_AUTO);
    assert_int_equal(b.c.collapsed_count, 0);
    assert_int_equal(casters_whole_count(&b.c), 3000);
    for (size_t t = 0; t < b.c.triangle_count; t++) {
        const uint32_t *v = b.c.indices + 3 * t;
        assert_true(v[0] != v[1] && v[1] != v[2] && v[2] != v[0]);
    }
    assert_true(b.c.borders.joined > 100);
    clear(&b);
}

static void holes_stay_where_they_are(void **state)
{
    (void)state;
    for (int first = 0; first < 4; first++) { /* the numbers of the edge that is split rise or fall */
        static const double p[4][3] = {{0, 0, 0}, {3, 0, 0}, {3, 1, 0}, {0, 1, 0}};
        sample              b       = {0};
        add_quad(&b, p[first], p[(first + 1) % 4], p[(first + 2) % 4], p[(first + 3) % 4]);
        for (int n = 0; n < 3; n++) add_flat(&b, n, 1, n + 1, 2);
        b.s.alpha_mask_count     = 2;
        b.s.alpha_masks          = calloc(2, sizeof *b.s.alpha_masks);
        b.s.holed_triangle_count = 4;
        b.s.holed_triangles      = calloc(4, sizeof *b.s.holed_triangles);
        for (uint32_t n = 0; n < 4; n++) {
            holed_triangle *hole = &b.s.holed_triangles[n];
            *hole                = (holed_triangle){.triangle = 2 * (n / 2) + n % 2, .mask = 1 - n / 2};
            for (int k = 0; k < 3; k++) {
                const double *at = b.s.positions_ws + 3 * (size_t)b.s.indices[3 * hole->triangle + (uint32_t)k];
                hole->uv[k][0]   = (float)(0.25 * at[0] + 0.125 * at[1]);
                hole->uv[k][1]   = (float)(1 - 0.5 * at[1]);
            }
        }
        sort_for_maps(&b, CLOSED_AUTO);
        const casters *c = &b.c;
        expect_borders(&b, 16 - 4, 1, 2, 0); /* the three share two edges already */
        assert_int_equal(c->triangle_count - c->holed_first, 6);
        assert_int_equal(c->alpha_mask_first[1] - c->alpha_mask_first[0], 2);
        assert_int_equal(c->alpha_mask_first[2] - c->alpha_mask_first[1], 4); /* of mask 1 one was split in three */
        for (size_t n = 0; n < 3 * (c->triangle_count - c->holed_first); n++) {
            const double *at = c->positions_ws + 3 * (size_t)c->indices[3 * c->holed_first + n];
            assert_true(fabs(c->hole_uvs[2 * n] - (0.25 * at[0] + 0.125 * at[1])) < 1e-6);
            assert_true(fabs(c->hole_uvs[2 * n + 1] - (1 - 0.5 * at[1])) < 1e-6);
        }
        clear(&b);
    }
}

/* A box beside which a sheet ends, one with a T-junction of its own, and two sheets that make one. */
static void solids_are_told_before(void **state)
{
    const double low[3] = {0, 0, 0}, high[3] = {1, 1, 1}, right[3] = {1, 0, 1}, middle[3] = {1, 0.5, 1}, far[3] = {1, 1, 1},
                 left[3] = {0, 0, 1}, back[3] = {0, 1, 1}, up[3] = {1, 0.5, 2};
    sample b = {0};
    (void)state;
    sample_box(&b, low, high);
    sample_points(&b, right, back, up); /* has two of its corners, across its top */
    const double side[4][3] = {{1, 0.25, 1}, {1, 0.75, 1}, {2, 0.75, 1}, {2, 0.25, 1}};
    add_quad(&b, side[0], side[1], side[2], side[3]);
    sort_for_maps(&b, CLOSED_AUTO);
    assert_int_equal(b.c.component_count[COMPONENT_SOLID], 1);
    assert_int_equal(b.c.solid_triangle_count, 12);
    clear(&b);

    for (int f = 0; f < 12; f++) {
        double p[3][3];
        if (f == 2 || f == 3) continue; /* its top is in three parts, whose vertex on the right the side lacks */
        for (int k = 0; k < 3; k++)
            for (int axis = 0; axis < 3; axis++) p[k][axis] = sample_box_faces[f][k] >> axis & 1;
        sample_points(&b, p[0], p[1], p[2]);
    }
    sample_points(&b, left, right, middle);
    sample_points(&b, left, middle, far);
    sample_points(&b, left, far, back);
    sort_for_maps(&b, CLOSED_AUTO);
    assert_int_equal(b.c.component_count[COMPONENT_SOLID], 0);
    assert_int_equal(b.c.component_count[COMPONENT_SHEET_OPEN], 1);
    expect_borders(&b, 3, 1, 1, 0);
    assert_int_equal(count_open(&b.c, NULL, NULL), 0);
    clear(&b);
}

/* The same triangles in another order, with other first corners. */
static void order_does_not_matter(void **state)
{
    uint32_t seed = 5;
    (void)state;
    for (uint64_t n = 0; n < 20; n++) {
        panels p = panels_make(n, n % 3 ? 0 : 3e-7);
        double sums[2][4];
        for (int turn = 0; turn < 2; turn++) {
            casters     c;
            run_context m    = {0};
            p.s.origin_count = 1; /* or the order would decide what is counted from where */
            assert_int_equal(casters_for_maps(&c, &p.s, CLOSED_AUTO, 2, &m), VXS_OK);
            memset(sums[turn], 0, sizeof sums[turn]);
            for (size_t t = 0; t < c.triangle_count; t++) { /* of whole numbers, whose order does not matter either */
                uint64_t hash = 0;
                for (int k = 0; k < 9; k++) {
                    uint64_t bits;
                    memcpy(&bits, &c.positions_ws[3 * (size_t)c.indices[3 * t + (size_t)k / 3] + (size_t)k % 3], sizeof bits);
                    hash = rng_mix(hash ^ bits);
                }
                sums[turn][0]++;
                sums[turn][1 + hash % 3] += (double)(hash >> 40);
            }
            casters_free(&c);
            sample shuffled = {.s = p.s};
            sample_shuffle(&shuffled, &seed);
            for (size_t t = 0; t < p.s.triangle_count; t++) {
                uint32_t *v = p.s.indices + 3 * t, first = v[0];
                v[0] = v[1], v[1] = v[2], v[2] = first;
            }
        }
        assert_memory_equal(sums[0], sums[1], sizeof sums[0]);
        panels_free(&p);
    }
}

enum { MANY = 100000 };

/* Work follows the size: a vertex on many edges, many vertices on an edge, long edges through a crowd. */
static void crowds_are_no_trouble(void **state)
{
    sample b = {0};
    rng    r = rng_split(1, 9);
    (void)state;
    for (int n = 0; n < MANY; n++) { /* a fan that is cut into its triangles, all about one vertex */
        double a[3] = {0, 0, 0}, p[2][3];
        for (int k = 0; k < 2; k++)
            memcpy(p[k], (double[]){cos((2 * n + k) * 3.14 / MANY), sin((2 * n + k) * 3.14 / MANY), n % 2}, sizeof p[k]);
        sample_points(&b, a, p[0], p[1]);
    }
    sort_for_maps(&b, CLOSED_AUTO);
    assert_int_equal(b.c.borders.left, 0);
    clear(&b);

    add_flat(&b, 0, -1, MANY, 0); /* a street, and as many houses */
    for (int n = 0; n < MANY; n++) add_flat(&b, n, 0, n + 0.5, 1);
    sort_for_maps(&b, CLOSED_AUTO);
    assert_int_equal(b.c.borders.left, 0);
    assert_int_equal(b.c.borders.split, 1);
    assert_int_equal(b.c.borders.added, 2 * MANY - 1);
    clear(&b);

    for (int n = 0; n < MANY; n++) { /* a crowd, and wires through it */
        double p[3][3], at[3];
        for (int k = 0; k < 3; k++) at[k] = uniform(&r, 0, 1000);
        for (int k = 0; k < 9; k++) p[k / 3][k % 3] = at[k % 3] + uniform(&r, -1, 1);
        if (n % 100 == 0)
            for (int k = 0; k < 3; k++) p[0][k] = uniform(&r, 0, 1000), p[1][k] = p[0][k] + 0.1, p[2][k] = 1000 - p[0][k];
        sample_points(&b, p[0], p[1], p[2]);
    }
    sort_for_maps(&b, CLOSED_AUTO);
    assert_int_equal(b.c.borders.left, 0);
    clear(&b);
}

/* Edges all in one line, each of which ends on most of the others: their pairs are not gone through, and a warning is given. */
static void endless_work_is_given_up(void **state)
{
    enum { FLAGS = 20000 };
    sample b = {0};
    rng    r = rng_split(1, 10);
    (void)state;
    for (int n = 0; n < FLAGS; n++) {
        double p[3][3] = {{uniform(&r, 0, 1), 0, 0}, {uniform(&r, 2, 3), 0, 0}, {1.5, cos(n), sin(n)}};
        sample_points(&b, p[0], p[1], p[2]);
    }
    sort_for_maps(&b, CLOSED_AUTO);
    assert_true(b.c.borders.left > 0 && b.c.borders.left < 3 * FLAGS);
    assert_true(b.c.triangle_count < 20 * FLAGS);
    assert_int_equal(b.m.warning_count, 1);
    assert_non_null(strstr(b.m.warnings[0], "edges are left as they are"));
    clear(&b);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(edges_are_split_at_vertices),
        cmocka_unit_test(seams_of_panels_close),
        cmocka_unit_test(rounding_is_joined_and_gaps_are_not),
        cmocka_unit_test(no_triangle_collapses),
        cmocka_unit_test(holes_stay_where_they_are),
        cmocka_unit_test(solids_are_told_before),
        cmocka_unit_test(order_does_not_matter),
        cmocka_unit_test(crowds_are_no_trouble),
        cmocka_unit_test(endless_work_is_given_up),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
