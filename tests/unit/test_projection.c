/* The casters as one map of a light sees them: what is in the map is there, where it is, with its depth, and without a crack
 * (baker/light/projection.h).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "baker/light/light_fit.h"
#include "baker/light/projection.h" /* before cmocka, whose fail() is a macro */
#include "runtime/vxs.h"
#include "tests/unit/random_light.h"

#include <cmocka.h>

enum { STACKS = 8, SLICES = 12, SOLIDS = 3, SHEETS = 20 };

typedef struct mesh {
    double   positions[3 * (SOLIDS * (STACKS + 1) * SLICES + 3 * SHEETS)];
    uint32_t indices[3 * (SOLIDS * 2 * STACKS * SLICES + SHEETS)];
    casters  c;
} mesh;

static uint32_t add_vertex(mesh *k, const double at[3])
{
    memcpy(k->positions + 3 * k->c.vertex_count, at, 3 * sizeof *at);
    return (uint32_t)k->c.vertex_count++;
}

static void add_triangle(mesh *k, uint32_t a, uint32_t b, uint32_t c)
{
    uint32_t *to = k->indices + 3 * k->c.triangle_count++;
    to[0] = a, to[1] = b, to[2] = c;
}

static void add_ball(mesh *k, rng *r, const double centre[3], double radius)
{
    uint32_t at[STACKS + 1][SLICES];
    for (int a = 0; a <= STACKS; a++)
        for (int b = 0; b < SLICES; b++) {
            int    pole  = a == 0 || a == STACKS;
            double polar = acos(-1) * a / STACKS, round = 2 * acos(-1) * b / SLICES,
                   bump = radius * (pole ? 1 : uniform(r, 0.6, 1.4));
            double p[3] = {centre[0] + bump * sin(polar) * cos(round), centre[1] + bump * cos(polar),
                           centre[2] + bump * sin(polar) * sin(round)};
            at[a][b]    = pole && b ? at[a][0] : add_vertex(k, p);
        }
    for (int a = 0; a < STACKS; a++)
        for (int b = 0; b < SLICES; b++) {
            int next = (b + 1) % SLICES;
            if (a) add_triangle(k, at[a][b], at[a][next], at[a + 1][b]);
            if (a < STACKS - 1) add_triangle(k, at[a][next], at[a + 1][next], at[a + 1][b]);
        }
}

/* Balls and sheets in front of a light, about it and through it. */
static void make_mesh(mesh *k, rng *r, const punctual *l)
{
    memset(k, 0, sizeof *k);
    k->c.positions_ws = k->positions;
    k->c.indices      = k->indices;
    double scale      = l->light.near_metres * pow(10, uniform(r, 0, 3));
    for (int n = 0; n < SOLIDS; n++) {
        double way[3], centre[3];
        random_direction(r, way);
        for (int c = 0; c < 3; c++) centre[c] = l->at[c] + (n ? scale : 0) * (way[c] + 0.7 * l->axis[2][c]);
        add_ball(k, r, centre, scale * uniform(r, 0.3, 1.5));
    }
    k->c.solid_triangle_count = k->c.triangle_count;
    for (int n = 0; n < SHEETS; n++) {
        uint32_t corner[3];
        for (int c = 0; c < 3; c++) {
            double p[3];
            random_direction(r, p);
            for (int w = 0; w < 3; w++) p[w] = l->at[w] + p[w] * scale * pow(10, uniform(r, -2, 1));
            corner[c] = add_vertex(k, p);
        }
        add_triangle(k, corner[0], corner[1], corner[2]);
    }
}

static void project(projection *p, const casters *c, const punctual *l, int map)
{
    run_context m = {0};
    assert_int_equal(projection_init(p, c, &l->light, map, 2, &m), VXS_OK);
}

static void assert_bounds(const projection *p, const vxs_light *light)
{
    double side = ldexp(1, (int)light->levels), slack = 1e-6 * side;
    for (size_t n = 0; n < 3 * p->triangle_count; n++) {
        assert_true(p->indices[n] < p->vertex_count);
        const vertex_ls *v = &p->vertices[p->indices[n]];
        assert_true(v->u >= -side - slack && v->u <= 2 * side + slack && v->v >= -side - slack && v->v <= 2 * side + slack);
        assert_true(v->z > 0 && v->z < 1024.001);
    }
}

/* At (u, v) of triangle t: *z, and how far inside it is, in texels; -INFINITY for one without area. */
static double inside_triangle(const projection *p, size_t t, double u, double v, double *z)
{
    const vertex_ls *c[3];
    for (int n = 0; n < 3; n++) c[n] = &p->vertices[p->indices[3 * t + (size_t)n]];
    double area = (c[1]->u - c[0]->u) * (c[2]->v - c[0]->v) - (c[1]->v - c[0]->v) * (c[2]->u - c[0]->u), inside = INFINITY;
    if (fabs(area) < 1e-9) return -INFINITY;
    *z = 0;
    for (int n = 0; n < 3; n++) {
        const vertex_ls *a = c[(n + 1) % 3], *b = c[(n + 2) % 3];
        double           w = ((b->u - a->u) * (v - a->v) - (b->v - a->v) * (u - a->u)) / area;
        *z += w * c[n]->z;
        inside = fmin(inside, w * fabs(area) / hypot(b->u - a->u, b->v - a->v));
    }
    return inside;
}

/* The cube of a wide spot has maps that look there; what lies there wholly is left out of them. */
static int behind_spot(const punctual *l, const double point_ws[3])
{
    double from[3];
    for (int w = 0; w < 3; w++) from[w] = point_ws[w] - l->at[w];
    return l->light.kind == VXS_LIGHT_KIND_SPOT && dot(l->axis[2], from) < 0;
}

/* Points of casters that the map sees are in some triangle of the projection, at their own depth; and no triangle is where there is
 * no caster. */
static void points_of_casters(const projection *p, const mesh *k, const punctual *l, int map, rng *r, int *asked)
{
    double side = ldexp(1, (int)l->light.levels);
    for (int n = 0; n < 150; n++) {
        size_t        t = rng_below(r, (uint32_t)k->c.triangle_count);
        double        a = uniform(r, 0, 1), b = uniform(r, 0, 1), point[3], seen[3];
        const double *c[3];
        if (a + b > 1) a = 1 - a, b = 1 - b;
        for (int m = 0; m < 3; m++) c[m] = k->positions + 3 * (size_t)k->indices[3 * t + (size_t)m];
        for (int w = 0; w < 3; w++) point[w] = c[0][w] + a * (c[1][w] - c[0][w]) + b * (c[2][w] - c[0][w]);
        map_space(l, map, point, seen);
        if (seen[2] < l->light.near_metres / 1023 || behind_spot(l, point)) continue;
        double u = side / 2 + seen[0] / seen[2] / l->light.texel_metres, v = side / 2 + seen[1] / seen[2] / l->light.texel_metres;
        if (u < 0 || v < 0 || u > side || v > side) continue;
        double wanted = l->light.near_metres / seen[2], nearest = INFINITY;
        for (size_t m = 0; m < p->triangle_count; m++) {
            double z = 0, inside = inside_triangle(p, m, u, v, &z);
            if (inside < -1e-6 * side) continue;
            nearest = fmin(nearest, fabs(z - wanted) / wanted);
        }
        double ab[3], ac[3], normal[3], from[3];
        for (int w = 0; w < 3; w++) ab[w] = c[1][w] - c[0][w], ac[w] = c[2][w] - c[0][w], from[w] = point[w] - l->at[w];
        cross(ab, ac, normal);
        if (fabs(dot(normal, from)) < 1e-3 * sqrt(dot(normal, normal) * dot(from, from))) continue; /* edge-on: no width here */
        if (nearest > 1e-4) fail_msg("at %g %g depth %g is off by %g", u, v, wanted, nearest);
        ++*asked;
    }
}

typedef struct edge {
    vertex_ls from, to;
} edge;

static int compare_edges(const void *a, const void *b)
{
    return memcmp(a, b, sizeof(edge));
}

/* On a bound of the map, all along. */
static int on_a_bound(const edge *e, double side)
{
    double slack = 1e-7 * side;
    if (e->from.z > 1023.9 && e->to.z > 1023.9) return 1;
    for (int n = 0; n < 2; n++) {
        double bound = n ? 2 * side : -side;
        if (fabs(e->from.u - bound) < slack && fabs(e->to.u - bound) < slack) return 1;
        if (fabs(e->from.v - bound) < slack && fabs(e->to.v - bound) < slack) return 1;
    }
    return 0;
}

/* 0 when some triangle with this edge's start was left out since it is beside the map: then its neighbours have open edges there,
 * which the map does not see. */
static int seen_by_map(const edge *e, double side)
{
    return fmax(e->from.u, e->to.u) >= -1 && fmin(e->from.u, e->to.u) <= side + 1 && fmax(e->from.v, e->to.v) >= -1 &&
           fmin(e->from.v, e->to.v) <= side + 1;
}

static size_t assert_closed(const projection *p, double side)
{
    size_t count = 0, asked = 0;
    edge  *edges = calloc(3 * p->solid_triangle_count + 1, sizeof *edges);
    assert_non_null(edges);
    for (size_t t = 0; t < p->solid_triangle_count; t++)
        for (int n = 0; n < 3; n++) {
            edges[count].from = p->vertices[p->indices[3 * t + (size_t)n]];
            edges[count].to   = p->vertices[p->indices[3 * t + (size_t)(n + 1) % 3]];
            count += memcmp(&edges[count].from, &edges[count].to, sizeof(vertex_ls)) != 0;
        }
    qsort(edges, count, sizeof *edges, compare_edges);
    for (size_t n = 0; n < count; n++) {
        edge back = {edges[n].to, edges[n].from};
        if (on_a_bound(&edges[n], side) || !seen_by_map(&edges[n], side)) continue;
        if (!bsearch(&back, edges, count, sizeof *edges, compare_edges)) fail_msg("a crack at edge %zu of %zu", n, count);
        asked++;
    }
    free(edges);
    return asked;
}

static void assert_same_projection(const projection *p, const projection *q)
{
    assert_int_equal(p->vertex_count, q->vertex_count);
    assert_int_equal(p->triangle_count, q->triangle_count);
    assert_int_equal(p->solid_triangle_count, q->solid_triangle_count);
    if (p->triangle_count) assert_memory_equal(p->vertices, q->vertices, p->vertex_count * sizeof *p->vertices);
    if (p->triangle_count) assert_memory_equal(p->indices, q->indices, 3 * p->triangle_count * sizeof *p->indices);
}

/* Runs of casters whose boxes are outside a map change neither its fit nor what it sees. */
static void runs_change_nothing(void **state)
{
    (void)state;
    rng   r = {9};
    mesh *k = malloc(sizeof *k);
    assert_non_null(k);
    for (int n = 0; n < 600; n++) {
        punctual       l     = random_punctual(&r, (punctual_shape)(n % PUNCTUAL_SHAPES));
        light_shape    shape = {.kind         = l.light.kind == VXS_LIGHT_KIND_SPOT ? LIGHT_SPOT : LIGHT_POINT,
                                .outer_rad    = l.cone_rad,
                                .range_metres = n % 2 ? INFINITY : l.light.near_metres * pow(10, uniform(&r, -1, 3))};
        light_fit_desc fit   = {.name = "lamp", .shape = &shape, .resolution = 256};
        vxs_light      fitted[2];
        run_context    m = {0};
        make_mesh(k, &r, &l);
        casters with = k->c;
        double  back = n % 4 < 2 ? l.light.near_metres * pow(10, uniform(&r, 0, 4)) : 0;
        for (int c = 0; c < 3; c++) shape.position_ws[c] = l.at[c] - back * l.axis[2][c];
        memcpy(shape.direction_ws, l.axis[2], sizeof shape.direction_ws);
        assert_int_equal(casters_find_runs(&with, &m), VXS_OK);
        vxs_result wanted = light_fit(&fitted[0], &k->c, &fit, &m);
        assert_int_equal(light_fit(&fitted[1], &with, &fit, &m), wanted);
        if (wanted == VXS_OK) assert_memory_equal(&fitted[0], &fitted[1], sizeof *fitted);
        for (int map = 0; map < map_count(&l.light); map++) {
            projection p, q;
            project(&p, &k->c, &l, map);
            project(&q, &with, &l, map);
            assert_same_projection(&p, &q);
            projection_free(&p);
            projection_free(&q);
        }
        free(with.runs);
    }
    free(k);
}

static void what_a_map_sees_is_there(void **state)
{
    (void)state;
    rng    r     = {1};
    int    asked = 0;
    size_t edges = 0;
    mesh  *k     = malloc(sizeof *k);
    assert_non_null(k);
    for (int n = 0; n < 400; n++) {
        punctual l    = random_punctual(&r, (punctual_shape)(n % PUNCTUAL_SHAPES));
        int      maps = l.light.flags & VXS_LIGHT_CUBE ? 6 : 1;
        double   side = ldexp(1, (int)l.light.levels);
        make_mesh(k, &r, &l);
        for (int map = 0; map < maps; map++) {
            projection p, solids;
            casters    only_solids = k->c;
            project(&p, &k->c, &l, map);
            assert_int_equal(p.reversed, 1);
            assert_bounds(&p, &l.light);
            points_of_casters(&p, k, &l, map, &r, &asked);
            if (maps == 1 || l.light.kind == VXS_LIGHT_KIND_POINT) edges += assert_closed(&p, side);
            /* solids come first, as they are without sheets */
            only_solids.triangle_count = only_solids.solid_triangle_count;
            project(&solids, &only_solids, &l, map);
            assert_int_equal(p.solid_triangle_count, solids.triangle_count);
            assert_int_equal(solids.solid_triangle_count, solids.triangle_count);
            for (size_t m = 0; m < 3 * solids.triangle_count; m++)
                assert_memory_equal(&p.vertices[p.indices[m]], &solids.vertices[solids.indices[m]], sizeof *p.vertices);
            projection_free(&solids);
            projection_free(&p);
        }
    }
    assert_true(asked > 20000 && edges > 50000);
    free(k);
}

/* The winding that the map sees is that of the world: fronts stay fronts, in all maps. */
static void windings_stay(void **state)
{
    (void)state;
    rng r     = {2};
    int asked = 0;
    for (int n = 0; n < 3000; n++) {
        punctual l = random_punctual(&r, (punctual_shape)(n % PUNCTUAL_SHAPES));
        mesh     k;
        uint32_t corner[3];
        double   side = ldexp(1, (int)l.light.levels), p[3][3], ab[3], ac[3], normal[3], from[3];
        int      maps = l.light.flags & VXS_LIGHT_CUBE ? 6 : 1, map = rng_between(&r, 0, maps - 1);
        memset(&k.c, 0, sizeof k.c);
        k.c.positions_ws = k.positions;
        k.c.indices      = k.indices;
        for (int c = 0; c < 3; c++) {
            double at[3] = {uniform(&r, 0, side), uniform(&r, 0, side), uniform(&r, 0, side)};
            vxs_point(&l.light, map, at, p[c]);
            corner[c] = add_vertex(&k, p[c]);
        }
        if (behind_spot(&l, p[0]) && behind_spot(&l, p[1]) && behind_spot(&l, p[2])) continue;
        add_triangle(&k, corner[0], corner[1], corner[2]);
        for (int c = 0; c < 3; c++) ab[c] = p[1][c] - p[0][c], ac[c] = p[2][c] - p[0][c], from[c] = p[0][c] - l.at[c];
        cross(ab, ac, normal);
        double facing = dot(normal, from) / sqrt(dot(normal, normal) * dot(from, from));
        if (fabs(facing) < 1e-3) continue;
        projection seen;
        project(&seen, &k.c, &l, map);
        assert_int_equal(seen.triangle_count, 1);
        const vertex_ls *v = seen.vertices;
        assert_int_equal(seen.indices[0], 0);
        double area = (v[1].u - v[0].u) * (v[2].v - v[0].v) - (v[1].v - v[0].v) * (v[2].u - v[0].u);
        assert_true((area > 0) == (facing > 0)); /* the map is right-handed and looks away from the light */
        projection_free(&seen);
        asked++;
    }
    assert_true(asked > 1500);
}

static void nothing_to_see(void **state)
{
    (void)state;
    rng        r    = {3};
    punctual   l    = random_punctual(&r, SPOT);
    casters    none = {0};
    projection p;
    project(&p, &none, &l, 0);
    assert_int_equal(p.triangle_count, 0);
    projection_free(&p);
    projection_free(&p);
    mesh k;
    memset(&k, 0, sizeof k);
    k.c.positions_ws = k.positions;
    k.c.indices      = k.indices;
    double at[3];
    for (int c = 0; c < 3; c++) at[c] = l.at[c] - 10 * l.axis[2][c]; /* behind */
    add_ball(&k, &r, at, 3);
    k.c.solid_triangle_count = k.c.triangle_count;
    project(&p, &k.c, &l, 0);
    assert_int_equal(p.triangle_count, 0);
    assert_int_equal(p.solid_triangle_count, 0);
    projection_free(&p);
}

/* The triangles that are kept, with all that belongs to them, whether the arrays are the projection's own or the casters'. */
static void what_is_kept(void **state)
{
    enum { ALL = 60, SOLIDS_END = 20, HOLED = 35, MASKS = 3 };
    static const size_t first[MASKS + 1] = {HOLED, 41, 41, ALL};
    (void)state;
    for (uint32_t n = 0; n < 40; n++) {
        casters    c = {.alpha_mask_count = MASKS};
        projection p = {.casters = &c, .triangle_count = ALL, .solid_triangle_count = SOLIDS_END, .holed_first = HOLED};
        uint32_t   indices[3 * ALL];
        uint8_t    meets[ALL], sides[ALL], kept[ALL];
        size_t     to = 0, solids = 0, holed = 0, mask = 0;
        rng        r       = rng_split(n, 7);
        p.uvq              = malloc((ALL - HOLED) * sizeof *p.uvq);
        p.alpha_mask_first = malloc(sizeof first);
        assert_true(p.uvq && p.alpha_mask_first);
        memcpy(p.alpha_mask_first, first, sizeof first);
        for (uint32_t t = 0; t < ALL; t++) {
            kept[t]  = n ? rng_below(&r, 3) > n % 3 : 0;
            meets[t] = (uint8_t)rng_below(&r, 2);
            sides[t] = (uint8_t)rng_below(&r, 2);
            for (uint32_t k = 0; k < 3; k++) indices[3 * t + k] = 3 * t + k;
            for (uint32_t k = 0; k < 3 && t >= HOLED; k++) p.uvq[t - HOLED][k] = (hole_uvq){(float)t, (float)k, 1};
        }
        if (n % 2) {
            p.own_indices = malloc(sizeof indices);
            p.own_meets   = malloc(sizeof meets);
            assert_true(p.own_indices && p.own_meets);
            memcpy(p.own_indices, indices, sizeof indices);
            memcpy(p.own_meets, meets, sizeof meets);
        }
        p.indices      = n % 2 ? p.own_indices : indices;
        p.meets        = n % 2 ? p.own_meets : n % 4 ? meets : NULL;
        p.double_sided = n % 8 < 4 ? sides : NULL;
        assert_int_equal(projection_keep(&p, kept), VXS_OK);
        for (uint32_t t = 0; t < ALL; t++) {
            if (t >= HOLED && t == first[mask]) assert_int_equal(p.alpha_mask_first[mask++], to);
            if (mask && t == first[mask]) assert_int_equal(p.alpha_mask_first[mask++], to); /* one without triangles */
            if (!kept[t]) continue;
            assert_memory_equal(p.indices + 3 * to, indices + 3 * t, 3 * sizeof *indices);
            if (p.meets && t < SOLIDS_END) assert_int_equal(p.meets[to], meets[t]);
            if (p.double_sided) assert_int_equal(p.double_sided[to], sides[t]);
            for (uint32_t k = 0; k < 3 && t >= HOLED; k++)
                assert_true(p.uvq[to - p.holed_first][k].u == (float)t && p.uvq[to - p.holed_first][k].v == (float)k);
            to++;
            solids += t < SOLIDS_END;
            holed += t < HOLED;
        }
        assert_int_equal(mask, MASKS);
        assert_int_equal(p.alpha_mask_first[MASKS], to);
        assert_true(p.triangle_count == to && p.solid_triangle_count == solids && p.holed_first == holed);
        assert_true((p.meets != NULL) == (n % 2 || n % 4) && (p.double_sided != NULL) == (n % 8 < 4));
        projection_free(&p);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_a_map_sees_is_there), cmocka_unit_test(runs_change_nothing), cmocka_unit_test(windings_stay),
        cmocka_unit_test(nothing_to_see),           cmocka_unit_test(what_is_kept),
    };
    return cmocka_run_group_tests_name("projection", tests, NULL, NULL);
}
