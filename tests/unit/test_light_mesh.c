/* The mesh about what a light reaches, of runtime/volumes/mesh/light_mesh.c, against shadow depth maps as they are defined.
 *
 * Whether it is closed is queried of its edges, exactly; where it is, of rays and of points, in double.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <math.h>
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

#include "mesh_walk.h"

static const float no_end = 1e30F;

/* lights and their maps -------------------------------------------------------------------------------------------------------- */

typedef enum shape_of_light { SUN = PUNCTUAL_SHAPES, BOUNDED_SUN, SHAPES_OF_LIGHTS } shape_of_light;

/* A light, and a map of its. */
typedef struct lit_map {
    vxs_light           light;
    vxs_light_constants constants;
    punctual            punctual; /* where it is one */
    int                 side, layers;
    float               far_metres;
    float              *first;
} lit_map;

static vxs_light random_sun(rng *r, int bounded)
{
    vxs_light light = {.kind = VXS_LIGHT_KIND_DIRECTIONAL, .flags = bounded ? VXS_LIGHT_BOUNDED : 0};
    double    axis[3][3], unit[3];
    light.levels       = 3 + rng_below(r, 6);
    light.texel_metres = uniform(r, 0.01, 1);
    light.voxel_metres = uniform(r, 0.01, 1);
    random_direction(r, axis[2]);
    random_direction(r, axis[1]);
    cross(axis[1], axis[2], axis[0]);
    make_unit(axis[0]);
    cross(axis[2], axis[0], axis[1]);
    for (int row = 0; row < 3; row++) {
        unit[row] = row < 2 ? light.texel_metres : light.voxel_metres;
        for (int n = 0; n < 3; n++) light.ls_from_ws[4 * row + n] = axis[row][n] / unit[row];
        light.ls_from_ws[4 * row + 3] = uniform(r, -100, 100);
    }
    memcpy(light.direction_ws, axis[2], sizeof axis[2]);
    return light;
}

/* Walls, slopes, gaps and noise, between 5 % and 60 % of what `most` is. */
static void fill_map(rng *r, lit_map *m, float most)
{
    int side = m->side;
    for (int n = 0; n < m->layers * side * side; n++) m->first[n] = rng_below(r, 4) ? no_end : 0.6F * most;
    for (int k = 0; k < 12 * m->layers; k++) {
        int   layer = rng_below(r, (uint32_t)m->layers), noise = !rng_below(r, 6);
        int   i0 = rng_below(r, (uint32_t)side), j0 = rng_below(r, (uint32_t)side);
        int   i1 = i0 + 1 + rng_below(r, (uint32_t)side), j1 = j0 + 1 + rng_below(r, (uint32_t)side);
        float depth = (float)uniform(r, 0.05, 0.6) * most, slope = rng_below(r, 2) ? (float)uniform(r, -0.5, 0.5) * depth : 0;
        if (!rng_below(r, 5)) depth = no_end;
        for (int j = j0; j < j1 && j < side; j++)
            for (int i = i0; i < i1 && i < side; i++)
                m->first[(layer * side + j) * side + i] =
                    noise ? (float)uniform(r, 0.05, 0.6) * most : depth + slope * (float)(i - i0) / (float)side;
    }
}

static lit_map random_map(rng *r, int shape, int side_most)
{
    lit_map m = {.far_metres = 100};
    if (shape < (int)PUNCTUAL_SHAPES) {
        m.punctual = random_punctual(r, (punctual_shape)shape);
        m.light    = m.punctual.light;
        if (rng_below(r, 2)) m.light.range_metres = uniform(r, 20, 100);
    } else
        m.light = random_sun(r, shape == (int)BOUNDED_SUN);
    m.constants = vxs_light_constants_of(&m.light, NULL, 0);
    m.layers    = (int)vxs_map_count(&m.light);
    m.side      = 1 << rng_below(r, m.light.levels + 1);
    while (m.side > side_most) m.side /= 2;
    m.first = malloc((size_t)(m.layers * m.side * m.side) * sizeof *m.first);
    assert_non_null(m.first);
    fill_map(r, &m, shape < (int)PUNCTUAL_SHAPES ? 20 : (float)(1 << m.light.levels));
    return m;
}

/* meshes ----------------------------------------------------------------------------------------------------------------------- */

static vxs_light_mesh_desc desc_of(const lit_map *m, float error_texels)
{
    return (vxs_light_mesh_desc){.light        = &m->constants,
                                 .first        = m->first,
                                 .side_px      = (uint32_t)m->side,
                                 .far_metres   = m->far_metres,
                                 .error_texels = error_texels};
}

static mesh_lists mesh_of(const lit_map *m, float error_texels)
{
    vxs_light_mesh_desc desc = desc_of(m, error_texels);
    return mesh_make(&desc);
}

/* An edge by the places of its ends, the lesser first. */
typedef struct edge {
    float ends[2][3];
    int   way; /* 1, -1 */
} edge;

static int by_ends(const void *a, const void *b)
{
    const edge *p = a, *q = b;
    for (int n = 0; n < 6; n++)
        if (p->ends[n / 3][n % 3] != q->ends[n / 3][n % 3]) return p->ends[n / 3][n % 3] < q->ends[n / 3][n % 3] ? -1 : 1;
    return 0;
}

/* Edges that are walked more often one way than the other. */
static uint32_t open_edges(const mesh_lists *m)
{
    size_t   count = (size_t)m->size.triangle_count * 3, used = 0;
    edge    *edges = malloc(count * sizeof *edges);
    uint32_t open  = 0;
    for (size_t n = 0; n < count; n++) {
        const float *a = m->places + 3 * m->corners[n], *b = m->places + 3 * m->corners[n % 3 == 2 ? n - 2 : n + 1];
        int          less = 0;
        for (int k = 0; k < 3 && !less; k++) less = (a[k] > b[k]) - (a[k] < b[k]);
        if (!less) continue; /* no length */
        edge *e = &edges[used++];
        for (int k = 0; k < 3; k++) {
            e->ends[0][k] = (less < 0 ? a : b)[k] + 0.0F; /* zeros are alike */
            e->ends[1][k] = (less < 0 ? b : a)[k] + 0.0F;
        }
        e->way = less;
    }
    qsort(edges, used, sizeof *edges, by_ends);
    for (size_t n = 0, end; n < used; n = end) {
        int sum = 0;
        for (end = n; end < used && !by_ends(&edges[n], &edges[end]); end++) sum += edges[end].way;
        open += sum != 0;
    }
    free(edges);
    return open;
}

/* Where a ray leaves what is lit (+1) and enters it (-1), summed; and the metres, or units of light space, that are lit of its
 * first `length`. */
static int walk_ray(const mesh_lists *m, const double from[3], const double way[3], double length, double *lit)
{
    int sum = 0;
    *lit    = 0;
    for (uint32_t t = 0; t < m->size.triangle_count; t++) {
        double at;
        int    sign = crossing(m, t, from, way, &at);
        if (!sign) continue;
        sum += sign;
        *lit += sign * fmin(at, length);
    }
    return sum;
}

/* shadow depth maps as they are defined ----------------------------------------------------------------------------------------------- */

/* Whether a point of the world is lit, by the texel that it is in; and, where the texels about it do not agree, -1. */
static int lit_by_map(const lit_map *m, const double point_ws[3], const double ls[3])
{
    double baked = ldexp(1, (int)m->light.levels), per_texel = baked / m->side, u, v, z = ls[2];
    int    layer = 0, found = -1;
    if (m->light.kind == VXS_LIGHT_KIND_DIRECTIONAL) {
        u = ls[0] / per_texel;
        v = ls[1] / per_texel;
        if (m->light.flags & VXS_LIGHT_BOUNDED && z > baked) return 1;
        if (u < 0 || v < 0 || u > m->side || v > m->side) return 1;
    } else {
        double p[3], most = -1;
        for (int n = 0; n < map_count(&m->light); n++) {
            map_space(&m->punctual, n, point_ws, p);
            if (p[2] > most) layer = n;
            most = fmax(most, p[2]);
        }
        map_space(&m->punctual, layer, point_ws, p);
        z = p[2];
        u = m->side / 2.0 + p[0] / z / m->light.texel_metres / per_texel;
        v = m->side / 2.0 + p[1] / z / m->light.texel_metres / per_texel;
        if (z <= 0 || u < 0 || v < 0 || u > m->side || v > m->side) return 0;
    }
    for (int j = (int)floor(v - 1); j <= (int)floor(v + 1); j++)
        for (int i = (int)floor(u - 1); i <= (int)floor(u + 1); i++) {
            int at[2] = {i, j};
            for (int n = 0; n < 2; n++) at[n] = at[n] < 0 ? 0 : at[n] >= m->side ? m->side - 1 : at[n];
            int lit = z < (double)m->first[(layer * m->side + at[1]) * m->side + at[0]];
            if (found >= 0 && lit != found) return -1;
            found = lit;
        }
    if (m->layers == 6 && (fmin(u, v) < m->side / 2.0 - 1 / m->light.texel_metres / per_texel + 1.5 ||
                           fmax(u, v) > m->side / 2.0 + 1 / m->light.texel_metres / per_texel - 1.5))
        return -1; /* of the texels of another face, too */
    return found;
}

/* A point of light space, somewhere in a mesh's middle, and where it is in the world. */
static void random_point(rng *r, const lit_map *m, double ls[3], double ws[3])
{
    double baked = ldexp(1, (int)m->light.levels), at[3];
    for (int n = 0; n < 3; n++)
        ls[n] = m->light.kind == VXS_LIGHT_KIND_DIRECTIONAL ? uniform(r, -0.2, 1.2) * baked : uniform(r, -9, 9);
    for (int n = 0; n < 3; n++) at[n] = ls[n] - m->light.ls_from_ws[4 * n + 3];
    for (int n = 0; n < 3; n++) {
        double unit = m->light.kind != VXS_LIGHT_KIND_DIRECTIONAL ? 1 : n < 2 ? m->light.texel_metres : m->light.voxel_metres;
        at[n] *= unit * unit;
    }
    for (int n = 0; n < 3; n++) { /* rows are orthogonal */
        ws[n] = 0;
        for (int row = 0; row < 3; row++) ws[n] += m->light.ls_from_ws[4 * row + n] * at[row];
    }
}

/* tests ------------------------------------------------------------------------------------------------------------------------ */

static const float thresholds[] = {0, 1e-4F, 0.5F, 4, 1e9F};
enum { THRESHOLDS = sizeof thresholds / sizeof *thresholds };

/* Each edge is met as often one way as the other, whatever the map and the threshold, across the edges of a cube, too. */
static void test_closed(void **state)
{
    (void)state;
    rng      r       = {1};
    uint64_t largest = 0;
    for (uint32_t n = 0; n < repeats(100, 8000); n++) {
        lit_map m = random_map(&r, (int)(n % SHAPES_OF_LIGHTS), 32);
        for (int k = 0; k < THRESHOLDS; k++) {
            mesh_lists out = mesh_of(&m, thresholds[k]);
            assert_int_equal(open_edges(&out), 0);
            if (!k) largest = out.size.triangle_count;
            assert_true(out.size.triangle_count <= largest);
            mesh_free(&out);
        }
        free(m.first);
    }
}

/* From any point any ray leaves what is lit once more than it enters it, or as often: where the point is lit, as the map has it,
 * and else. */
static void test_rays(void **state)
{
    (void)state;
    rng      r      = {2};
    uint32_t lit[2] = {0};
    for (uint32_t n = 0; n < repeats(80, 4000); n++) {
        lit_map    m   = random_map(&r, (int)(n % SHAPES_OF_LIGHTS), 32);
        mesh_lists out = mesh_of(&m, n % 3 ? 0 : 1e-4F), loose = mesh_of(&m, 2);
        for (int k = 0; k < 20; k++) {
            double ls[3], ws[3], way[3], metres;
            random_point(&r, &m, ls, ws);
            int wanted = lit_by_map(&m, ws, ls), found = -1;
            for (int ray = 0; ray < 3; ray++) {
                random_direction(&r, way);
                int sum = walk_ray(&out, ls, way, 1, &metres);
                if (wanted >= 0) assert_int_equal(sum, wanted);
                if (found >= 0) assert_int_equal(sum, found);
                found = sum;
                assert_in_range(sum, 0, 1);
                assert_in_range(walk_ray(&loose, ls, way, 1, &metres), 0, 1);
            }
            if (wanted >= 0) lit[wanted]++;
        }
        mesh_free(&out);
        mesh_free(&loose);
        free(m.first);
    }
    print_message("%u points in light, %u in shadow\n", lit[1], lit[0]);
    assert_true(lit[0] > repeats(80, 4000) && lit[1] > repeats(80, 4000));
}

/* Slopes that meet, before which boxes stand, and where light does not end: as a city is. */
static void fill_city(rng *r, lit_map *m)
{
    int side = m->side;
    for (int layer = 0; layer < m->layers; layer++)
        for (int j = 0; j < side; j++)
            for (int i = 0; i < side; i++) {
                float u = ((float)i + 0.5F) / (float)side - 0.5F, v = ((float)j + 0.5F) / (float)side - 0.5F;
                m->first[(layer * side + j) * side + i] = v < 0 ? 10 / (1 + u + 0.3F * v) : u > 0.3F ? no_end : 8 / (1 - 0.5F * v);
            }
    for (int k = 0; k < 20 * m->layers; k++) {
        int   layer = rng_below(r, (uint32_t)m->layers), wide = 2 + (int)rng_below(r, (uint32_t)side / 6);
        int   i0 = rng_below(r, (uint32_t)(side - wide)), j0 = rng_below(r, (uint32_t)(side - wide));
        float depth = (float)uniform(r, 2, 6);
        for (int j = j0; j < j0 + wide; j++)
            for (int i = i0; i < i0 + wide; i++) m->first[(layer * side + j) * side + i] = depth;
    }
}

/* What rays see of the light with quads of several texels, against a quad for each: next to nothing is lost where next to nothing
 * is allowed, and more, with fewer triangles, where more is. */
static void test_threshold(void **state)
{
    (void)state;
    enum { RAYS = 600 };
    const int          rays = (int)repeats(300, RAYS);
    double             from[RAYS][3], way[RAYS][3], one[RAYS];
    static const float allowed[] = {1e-6F, 0.1F, 1, 10, 100};
    rng                r         = {3};
    for (int shape = SPOT; shape < (int)PUNCTUAL_SHAPES; shape += POINT - SPOT) {
        lit_map m            = {.side = 64, .far_metres = 30};
        double  last         = -1;
        m.punctual           = random_punctual(&r, (punctual_shape)shape);
        m.light              = m.punctual.light;
        m.light.levels       = 6;
        m.light.texel_metres = shape == SPOT ? 0.02 : 1 / 29.0;
        m.constants          = vxs_light_constants_of(&m.light, NULL, 0);
        m.layers             = (int)vxs_map_count(&m.light);
        m.first              = malloc((size_t)(m.layers * m.side * m.side) * sizeof *m.first);
        fill_city(&r, &m);
        mesh_lists all       = mesh_of(&m, 0);
        uint32_t   triangles = all.size.triangle_count;
        double     square    = 0;
        for (int n = 0; n < rays; n++) {
            for (int i = 0; i < 3; i++) from[n][i] = uniform(&r, -8, 8);
            random_direction(&r, way[n]);
            walk_ray(&all, from[n], way[n], 10, &one[n]);
            square += one[n] * one[n];
        }
        for (size_t k = 0; k < sizeof allowed / sizeof *allowed; k++) {
            mesh_lists some  = mesh_of(&m, allowed[k]);
            double     error = 0;
            for (int n = 0; n < rays; n++) {
                double other;
                walk_ray(&some, from[n], way[n], 10, &other);
                error += (one[n] - other) * (one[n] - other);
            }
            error = sqrt(error / square);
            print_message("%d maps of %d^2, error_texels %g: %u of %u triangles, relative RMS of lit lengths %.1e\n", m.layers,
                          m.side, (double)allowed[k], some.size.triangle_count, all.size.triangle_count, error);
            if (!k) assert_true(error < 1e-5);
            assert_true(error >= last && some.size.triangle_count < triangles);
            last      = error;
            triangles = some.size.triangle_count;
            mesh_free(&some);
        }
        assert_true(last > 1e-3);
        mesh_free(&all);
        free(m.first);
    }
}

/* Without shadow, light fills the cube of its range, or the pyramid. */
static void test_empty(void **state)
{
    (void)state;
    rng r = {5};
    for (uint32_t n = 0; n < repeats(60, 600); n++) {
        lit_map m = random_map(&r, (int)(n % SHAPES_OF_LIGHTS), 16);
        for (int k = 0; k < m.layers * m.side * m.side; k++) m.first[k] = no_end;
        mesh_lists out = mesh_of(&m, 0), few = mesh_of(&m, 1e-3F);
        double     reach = m.light.range_metres > 0 ? m.light.range_metres : (double)m.far_metres;
        for (int k = 0; k < 10; k++) {
            double ls[3] = {0}, way[3], lit, lit_too, wanted;
            random_direction(&r, way);
            if (m.layers == 6)
                wanted = reach / fmax(fabs(way[0]), fmax(fabs(way[1]), fabs(way[2])));
            else if (m.light.kind == VXS_LIGHT_KIND_DIRECTIONAL) {
                for (int i = 0; i < 3; i++) ls[i] = uniform(&r, 0, 1) * ldexp(1, (int)m.light.levels);
                wanted = 10; /* no unit of light space is longer than a metre */
            } else {
                ls[2]  = uniform(&r, 0.01, 1) * reach;
                ls[0]  = 1e-5 * ls[2]; /* beside a diagonal */
                way[0] = way[1] = 0;
                way[2]          = 1;
                wanted          = reach - ls[2];
            }
            walk_ray(&out, ls, way, wanted * (m.light.kind == VXS_LIGHT_KIND_DIRECTIONAL ? 1 : 2), &lit);
            walk_ray(&few, ls, way, wanted * (m.light.kind == VXS_LIGHT_KIND_DIRECTIONAL ? 1 : 2), &lit_too);
            /* vertices are floats, as far away as the reach */
            double off = 1e-5 * wanted + (m.light.kind == VXS_LIGHT_KIND_DIRECTIONAL ? 0 : 2e-7 * reach);
            assert_float_equal(lit, wanted, off);
            assert_float_equal(lit_too, wanted, off);
        }
        if (m.light.kind != VXS_LIGHT_KIND_DIRECTIONAL && m.side > 4)
            assert_true(few.size.triangle_count < out.size.triangle_count);
        mesh_free(&out);
        mesh_free(&few);
        free(m.first);
    }
}

/* Maps may hold anything. */
static void test_any_depths(void **state)
{
    (void)state;
    static const float odd[] = {0, -1, 1e38F, -1e38F, INFINITY, -INFINITY, NAN, 1e-38F, 3, 1e30F};
    rng                r     = {6};
    for (uint32_t n = 0; n < repeats(60, 600); n++) {
        lit_map m = random_map(&r, (int)(n % SHAPES_OF_LIGHTS), 16);
        for (int k = 0; k < m.layers * m.side * m.side; k++) m.first[k] = odd[rng_below(&r, sizeof odd / sizeof *odd)];
        for (int k = 0; k < THRESHOLDS; k++) {
            mesh_lists out = mesh_of(&m, thresholds[k]);
            assert_int_equal(open_edges(&out), 0);
            mesh_free(&out);
        }
        free(m.first);
    }
}

static void test_arguments(void **state)
{
    (void)state;
    rng                 r    = {7};
    lit_map             m    = random_map(&r, SPOT, 8);
    vxs_light_mesh_size size = {7, 7};
    uint32_t            room[4];
    vxs_light_mesh_desc bad[9];
    for (int n = 0; n < 9; n++) bad[n] = desc_of(&m, 1);
    assert_true(vxs_light_mesh_room(&bad[0]) > 0);
    vxs_light_constants flat = m.constants;
    flat.texel_metres        = 0;
    bad[0].light             = NULL;
    bad[1].first             = NULL;
    bad[2].side_px           = 3;
    bad[3].side_px           = 1U << (m.light.levels + 1);
    bad[4].far_metres        = 0;
    bad[5].far_metres        = INFINITY;
    bad[6].error_texels      = NAN;
    bad[7].light             = &flat;
    bad[8].struct_size       = 3;
    for (int n = 0; n < 9; n++) {
        assert_int_equal(vxs_light_mesh_room(&bad[n]), 0);
        assert_int_equal(vxs_light_mesh_plan(&bad[n], room, &size), VXS_E_ARGUMENT);
    }
    assert_int_equal(size.vertex_count, 7);
    free(m.first);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_closed), cmocka_unit_test(test_rays),       cmocka_unit_test(test_threshold),
        cmocka_unit_test(test_empty),  cmocka_unit_test(test_any_depths), cmocka_unit_test(test_arguments),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
