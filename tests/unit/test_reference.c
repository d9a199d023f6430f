/* The reference of light in the air (tests/volumes/): each oracle of visibility against formulas or brute force of its own,
 * airlight between lit ends against closed forms, and that nothing changes when it is queried twice as finely.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "mesh_sample.h"
#include "random_light.h"
#include "repeats.h"
#include "tests/volumes/map_parts.h"
#include "tests/volumes/mesh_parts.h"
#include "tests/volumes/reference.h"
#include "tests/volumes/sphere_parts.h"
#include "tests/volumes/traced_parts.h"

static eye_ray random_ray(rng *r, double size, double length)
{
    eye_ray ray = {.end = length};
    for (int n = 0; n < 3; n++) ray.eye[n] = uniform(r, -size, size);
    random_direction(r, ray.direction);
    return ray;
}

static void place_on(const eye_ray *ray, double x, double point[3])
{
    for (int n = 0; n < 3; n++) point[n] = ray->eye[n] + x * ray->direction[n];
}

static int in_parts(const lit_parts *parts, double x)
{
    for (size_t n = 0; n < parts->count; n++)
        if (x >= parts->at[n].begin && x <= parts->at[n].end) return 1;
    return 0;
}

/* Metres from x to the nearest end of a part. */
static double from_end(const lit_parts *parts, double x)
{
    double least = INFINITY;
    for (size_t n = 0; n < parts->count; n++) least = fmin(least, fmin(fabs(x - parts->at[n].begin), fabs(x - parts->at[n].end)));
    return least;
}

static void check_ordered(const lit_parts *parts, const eye_ray *ray)
{
    for (size_t n = 0; n < parts->count; n++) {
        assert_true(parts->at[n].begin >= ray->begin && parts->at[n].end <= ray->end);
        assert_true(parts->at[n].begin < parts->at[n].end);
        if (n) assert_true(parts->at[n].begin > parts->at[n - 1].end);
    }
}

/* T0: spheres --------------------------------------------------------------------------------------------------------- */

enum { SPHERES = 6 };

/* Whether the way from a place to the light is free: how near it passes each sphere. */
static int spheres_lit(const void *user, const double point[3])
{
    const lit_spheres *s = user;
    for (size_t n = 0; n < s->count; n++) {
        double way[3], to[3], nearest[3];
        for (int k = 0; k < 3; k++) {
            way[k] = s->light.kind == LIGHT_POINT ? s->light.position_ws[k] - point[k] : -1e3 * s->light.direction_ws[k];
            to[k]  = s->at[n].centre[k] - point[k];
        }
        double at = fmin(fmax(dot(to, way) / dot(way, way), 0), 1);
        for (int k = 0; k < 3; k++) nearest[k] = to[k] - at * way[k];
        if (dot(nearest, nearest) < s->at[n].radius * s->at[n].radius) return 0;
    }
    return 1;
}

/* at  [SPHERES] */
static lit_spheres random_spheres(rng *r, int is_punctual, sphere *at)
{
    lit_spheres s = {at, SPHERES, .light = {.kind = is_punctual ? LIGHT_POINT : LIGHT_DIRECTIONAL, .range_metres = INFINITY}};
    random_direction(r, s.light.direction_ws);
    for (int n = 0; n < 3; n++) s.light.position_ws[n] = is_punctual ? uniform(r, -3, 3) : 0;
    for (int n = 0; n < SPHERES; n++) {
        double away[3];
        do {
            for (int k = 0; k < 3; k++) {
                at[n].centre[k] = uniform(r, -5, 5);
                away[k]         = at[n].centre[k] - s.light.position_ws[k];
            }
            at[n].radius = uniform(r, 0.3, 1.5);
        } while (sqrt(dot(away, away)) < 1.2 * at[n].radius);
    }
    return s;
}

/* Turn a ray to a punctual light, or to the sun. */
static void look_into(eye_ray *ray, const light_shape *light)
{
    for (int k = 0; k < 3; k++)
        ray->direction[k] = light->kind == LIGHT_POINT ? light->position_ws[k] - ray->eye[k] : -light->direction_ws[k];
    make_unit(ray->direction);
}

static void test_traced_spheres(void **state)
{
    (void)state;
    rng       r   = {1};
    lit_parts lit = {0}, wanted = {0};
    uint32_t  ends = 0;
    for (uint32_t n = 0; n < repeats(100, 2000); n++) {
        sphere       at[SPHERES];
        lit_spheres  s     = random_spheres(&r, n & 1, at);
        eye_ray      ray   = random_ray(&r, 5, 20);
        traced_light light = {spheres_lit, &s, s.light, TRACED_SAMPLES};
        if (n % 10 < 2) look_into(&ray, &s.light);
        sphere_parts(&s, &ray, &wanted);
        traced_parts(&light, &ray, &lit);
        check_ordered(&lit, &ray);
        check_ordered(&wanted, &ray);
        int thin = 0; /* what is dark between two samples */
        for (size_t k = 0; k < wanted.count; k++) {
            double next = k + 1 < wanted.count ? wanted.at[k + 1].begin : ray.end;
            if (wanted.at[k].end - wanted.at[k].begin < 0.05 || (next > wanted.at[k].end && next - wanted.at[k].end < 0.05))
                thin = 1;
        }
        if (wanted.count && wanted.at[0].begin > 0 && wanted.at[0].begin < 0.05) thin = 1;
        if (thin) continue;
        assert_int_equal(lit.count, wanted.count);
        for (size_t k = 0; k < lit.count; k++, ends += 2) {
            assert_float_equal(lit.at[k].begin, wanted.at[k].begin, 1e-6);
            assert_float_equal(lit.at[k].end, wanted.at[k].end, 1e-6);
        }
    }
    assert_true(ends > repeats(100, 2000));
    lit_parts_free(&lit);
    lit_parts_free(&wanted);
}

/* T0: Embree ---------------------------------------------------------------------------------------------------------- */

typedef struct brute {
    const scene *s;
    light_shape  light;
} brute;

/* Whether any triangle lies between a place and the light, one by one, in double. */
static int brute_lit(const void *user, const double point[3])
{
    const brute *b = user;
    double       way[3];
    for (int n = 0; n < 3; n++)
        way[n] = b->light.kind == LIGHT_POINT ? b->light.position_ws[n] - point[n] : -1e3 * b->light.direction_ws[n];
    for (size_t t = 0; t < b->s->triangle_count; t++) {
        const double *v[3];
        double        e[3], f[3], o[3], p[3], q[3];
        for (int c = 0; c < 3; c++) v[c] = b->s->positions_ws + 3 * (size_t)b->s->indices[3 * t + (size_t)c];
        for (int n = 0; n < 3; n++) {
            e[n] = v[1][n] - v[0][n];
            f[n] = v[2][n] - v[0][n];
            o[n] = point[n] - v[0][n];
        }
        cross(way, f, p);
        cross(o, e, q);
        double size = dot(e, p), u = dot(o, p) / size, w = dot(way, q) / size, at = dot(f, q) / size;
        if (u >= 0 && w >= 0 && u + w <= 1 && at > 0 && at < 1) return 0;
    }
    return 1;
}

static void test_traced_scene(void **state)
{
    (void)state;
    rng       r      = {2};
    sample    b      = {0};
    truth    *traced = NULL;
    lit_parts lit = {0}, wanted = {0};
    uint32_t  changes = 0;
    for (int n = 0; n < 12; n++) sample_cube(&b, uniform(&r, -8, 8), uniform(&r, -8, 8), uniform(&r, -8, 8), uniform(&r, 0.3, 1));
    sample_ball(&b, (double[3]){1, 2, 3}, 1.5, 8);
    assert_int_equal(casters_from_scene(&b.c, &b.s, CLOSED_AUTO, 1, &b.m), VXS_OK);
    assert_int_equal(truth_create(&traced, &b.c, 1, &b.m), VXS_OK);
    for (uint32_t n = 0; n < repeats(20, 400); n++) {
        light_shape shape = {
            .kind = n & 1 ? LIGHT_POINT : LIGHT_DIRECTIONAL, .position_ws = {0.1, 0.2, -9}, .range_metres = INFINITY};
        eye_ray      ray    = random_ray(&r, 8, 15);
        traced_scene embree = {traced, &shape};
        random_direction(&r, shape.direction_ws);
        brute        all        = {&b.s, shape};
        traced_light by_truth   = {traced_scene_lit, &embree, shape, 1024};
        traced_light one_by_one = {brute_lit, &all, shape, 1024};
        traced_parts(&by_truth, &ray, &lit);
        traced_parts(&one_by_one, &ray, &wanted);
        changes += (uint32_t)wanted.count;
        for (int k = 0; k < 200; k++) {
            double x = uniform(&r, 0, 15);
            if (from_end(&wanted, x) > 1e-3) assert_int_equal(in_parts(&lit, x), in_parts(&wanted, x));
        }
        assert_float_equal(lit_parts_length(&lit), lit_parts_length(&wanted), 1e-3);
    }
    assert_true(changes > repeats(20, 400));
    lit_parts_free(&lit);
    lit_parts_free(&wanted);
    truth_destroy(traced);
    sample_clear(&b);
}

/* T1: texels ---------------------------------------------------------------------------------------------------------- */

/* A map of random depths, some without end; of a sun or of a punctual light. */
typedef struct random_map {
    punctual         l;
    shadow_depth_map map;
    float           *first;
} random_map;

static random_map map_of(rng *r, int kind)
{
    random_map m     = {.l = random_punctual(r, kind == 0 ? SPOT : kind == 1 ? WIDE_SPOT : POINT)};
    uint32_t   shift = rng_below(r, 2);
    m.l.light.levels = 4;
    if (kind < 3) m.l.light.texel_metres = (kind == 0 ? tan(m.l.cone_rad) : 1) / 6.5;
    if (kind == 3) { /* a sun: light space is texels and voxels */
        m.l.light.kind  = VXS_LIGHT_KIND_DIRECTIONAL;
        m.l.light.flags = rng_below(r, 2) ? VXS_LIGHT_BOUNDED : 0;
        for (int row = 0; row < 3; row++) m.l.light.ls_from_ws[4 * row + 3] += 8;
    }
    m.map        = (shadow_depth_map){&m.l.light, 16U >> shift, kind == 1 || kind == 2 ? 6 : 1, NULL};
    size_t count = (size_t)m.map.layers * m.map.side * m.map.side;
    m.first      = malloc(count * sizeof *m.first);
    assert_non_null(m.first);
    for (size_t n = 0; n < count; n++) m.first[n] = rng_below(r, 4) ? (float)uniform(r, 0.5, 12) : 1e30F;
    return m;
}

/* Whether a place is lit, with axes by their names (random_light.h), and no function of vxs_space.h. */
static int lit_by_names(const random_map *m, const double point[3])
{
    double   p[3] = {0}, side = m->map.side, baked = 16, u, v;
    uint32_t layer = 0;
    if (m->l.light.kind == VXS_LIGHT_KIND_DIRECTIONAL) {
        map_space(&m->l, 4, point, p);
        for (int n = 0; n < 3; n++) p[n] += 8;
        u = p[0] * side / baked;
        v = p[1] * side / baked;
        if (m->l.light.flags & VXS_LIGHT_BOUNDED && (p[2] < 0 || p[2] >= baked)) return 1;
    } else {
        for (int map = 0; map < (int)m->map.layers; map++) { /* the one that it lies before */
            map_space(&m->l, map, point, p);
            layer = (uint32_t)map;
            if (p[2] > fabs(p[0]) && p[2] > fabs(p[1])) break;
        }
        if (p[2] <= 0) return 1;
        u = side / 2 + p[0] / p[2] / m->l.light.texel_metres * side / baked;
        v = side / 2 + p[1] / p[2] / m->l.light.texel_metres * side / baked;
    }
    if (u < 0 || v < 0 || u >= side || v >= side) return 1;
    return p[2] < (double)m->first[(layer * m->map.side + (uint32_t)v) * m->map.side + (uint32_t)u];
}

static void test_map_parts(void **state)
{
    (void)state;
    rng       r       = {3};
    lit_parts lit     = {0};
    uint32_t  dark[4] = {0}, asked = 0;
    for (uint32_t n = 0; n < repeats(200, 4000); n++) {
        random_map m   = map_of(&r, n % 4);
        eye_ray    ray = random_ray(&r, 10, 30);
        m.map.light    = &m.l.light;
        m.map.first    = m.first;
        if (n % 8 > 3) memset(ray.direction, 0, sizeof ray.direction); /* along an axis of the light, or of a map */
        if (n % 8 > 3) memcpy(ray.direction, m.l.axis[n / 8 % 3], sizeof ray.direction);
        for (int k = 0; k < 3; k++) ray.eye[k] += m.l.at[k];
        map_parts(&m.map, &ray, &lit);
        check_ordered(&lit, &ray);
        for (int k = 0; k < 300; k++) {
            double x = uniform(&r, 0, 30), point[3];
            place_on(&ray, x, point);
            if (from_end(&lit, x) < 1e-6) continue;
            int is = in_parts(&lit, x);
            if (is != lit_by_names(&m, point)) fail_msg("ray %u, kind %u: %d at %g", n, n % 4, is, x);
            assert_int_equal(is, map_lit(&m.map, point));
            dark[n % 4] += !is;
            asked++;
        }
        free(m.first);
    }
    for (int kind = 0; kind < 4; kind++) assert_true(dark[kind] > asked / 100);
    lit_parts_free(&lit);
}

/* T2: meshes ---------------------------------------------------------------------------------------------------------- */

static void add_quad(double (*triangles)[3][3], size_t *count, const double corners[4][3])
{
    static const int order[2][3] = {{0, 1, 2}, {0, 2, 3}};
    for (int t = 0; t < 2; t++, (*count)++)
        for (int c = 0; c < 3; c++) memcpy(triangles[*count][c], corners[order[t][c]], sizeof corners[0]);
}

/* The box of a texel's light ray, from the sun's near plane to where shadow begins, turned outward. */
static void add_column(double (*triangles)[3][3], size_t *count, double x, double y, double depth)
{
    double corners[8][3];
    for (int c = 0; c < 8; c++) {
        corners[c][0] = x + (c & 1);
        corners[c][1] = y + (c >> 1 & 1);
        corners[c][2] = c & 4 ? depth : 0;
    }
    static const int faces[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
    for (int f = 0; f < 6; f++) {
        double q[4][3];
        for (int c = 0; c < 4; c++) memcpy(q[c], corners[faces[f][c]], sizeof q[c]);
        add_quad(triangles, count, (const double(*)[3])q);
    }
}

/* Columns of light as boxes are a mesh of the map that is exact: both oracles agree. Faces between neighbours are there twice and
 * cancel; some rays run along them, and through corners. */
static void test_mesh_is_map(void **state)
{
    (void)state;
    enum { SIDE = 8, TRIANGLES = 12 * SIDE * SIDE };
    static double triangles[TRIANGLES][3][3];
    rng           r      = {4};
    lit_parts     meshed = {0}, mapped = {0};
    vxs_light     light = {.kind = VXS_LIGHT_KIND_DIRECTIONAL, .flags = VXS_LIGHT_BOUNDED, .levels = 3};
    for (int n = 0; n < 3; n++) light.ls_from_ws[5 * n] = 1;
    for (uint32_t map_count = 0; map_count < repeats(10, 100); map_count++) {
        float  first[SIDE * SIDE];
        size_t count = 0;
        for (int n = 0; n < SIDE * SIDE; n++) {
            first[n] = (float)(1 + rng_below(&r, 7));
            add_column(triangles, &count, n % SIDE, n / SIDE, (double)first[n]);
        }
        assert_int_equal(count, TRIANGLES);
        lit_mesh        *mesh = lit_mesh_create((const double(*)[3][3])triangles, count);
        shadow_depth_map map  = {&light, SIDE, 1, first};
        assert_non_null(mesh);
        for (int n = 0; n < 200; n++) {
            eye_ray ray = {.end = 20};
            double  to[3];
            for (int k = 0; k < 3; k++) { /* every other one from a corner of the grid to another */
                ray.eye[k]       = n & 1 ? (double)rng_below(&r, 7) + 1 : uniform(&r, 0.1, 7.9);
                to[k]            = n & 1 ? (double)rng_below(&r, 9) + 0.5 * (k == 2) : uniform(&r, 0, 8);
                ray.direction[k] = to[k] - ray.eye[k];
            }
            if (dot(ray.direction, ray.direction) == 0) continue;
            make_unit(ray.direction);
            mesh_parts(mesh, &ray, &meshed);
            check_ordered(&meshed, &ray);
            for (int k = 0; k < 50 && !(n & 1); k++) {
                double x = uniform(&r, 0, 10), point[3];
                place_on(&ray, x, point);
                int inside = 1;
                for (int i = 0; i < 3; i++) inside &= point[i] > 0 && point[i] < 8;
                map_parts(&map, &ray, &mapped);
                if (from_end(&meshed, x) < 1e-9 || from_end(&mapped, x) < 1e-9) continue;
                assert_int_equal(in_parts(&meshed, x), inside && in_parts(&mapped, x));
            }
        }
        lit_mesh_destroy(mesh);
    }
    lit_parts_free(&meshed);
    lit_parts_free(&mapped);
}

/* A ball of triangles about the eye: whichever way it looks, and at edges and corners of all, it is inside once; and outside not at
 * all. */
static void test_mesh_is_tight(void **state)
{
    (void)state;
    enum { RINGS = 16 };
    rng    r = {5};
    sample b = {0};
    sample_ball(&b, (double[3]){0.3, -0.2, 0.1}, 2, RINGS);
    double(*triangles)[3][3] = malloc(b.s.triangle_count * sizeof *triangles);
    assert_non_null(triangles);
    for (size_t t = 0; t < b.s.triangle_count; t++)
        for (size_t c = 0; c < 3; c++)
            memcpy(triangles[t][c], b.s.positions_ws + 3 * (size_t)b.s.indices[3 * t + c], sizeof triangles[t][c]);
    lit_mesh *mesh = lit_mesh_create((const double(*)[3][3])triangles, b.s.triangle_count);
    assert_non_null(mesh);
    for (uint32_t n = 0; n < repeats(20000, 400000); n++) {
        size_t  t     = rng_below(&r, (uint32_t)b.s.triangle_count);
        double  share = n % 3 ? uniform(&r, 0, 1) : 0, far = n & 1 ? 0.5 : 5;
        eye_ray ray = {.end = 30};
        random_direction(&r, ray.eye);
        for (int k = 0; k < 3; k++) {
            ray.eye[k]       = far * ray.eye[k];
            ray.direction[k] = triangles[t][0][k] + share * (triangles[t][1][k] - triangles[t][0][k]) - ray.eye[k];
        }
        make_unit(ray.direction);
        if (n % 3 == 1) random_direction(&r, ray.direction);
        assert_int_equal(mesh_winding(mesh, &ray), n & 1);
    }
    lit_mesh_destroy(mesh);
    free(triangles);
    sample_clear(&b);
}

/* airlight ------------------------------------------------------------------------------------------------------------ */

static void all_lit(const void *nobody, const eye_ray *ray, lit_parts *parts)
{
    (void)nobody;
    lit_parts_clear(parts);
    lit_parts_add(parts, ray->begin, ray->end);
}

static reference_light random_light(rng *r, int kind)
{
    reference_light l = {.oracle = all_lit, .colour = {3, 2, 1}};
    l.light.kind      = (vxs_u32)kind;
    random_direction(r, l.light.axis);
    random_direction(r, l.light.place);
    if (kind != VXS_LIGHT_KIND_DIRECTIONAL)
        for (int n = 0; n < 3; n++) l.light.place[n] = uniform(r, -8, 8);
    l.light.cos_outer     = cos(uniform(r, 0.3, 1.4));
    l.light.cos_inner     = l.light.cos_outer + uniform(r, 0.1, 0.9) * (1 - l.light.cos_outer);
    l.light.radius_metres = 0.05;
    l.light.range_metres  = rng_below(r, 2) ? uniform(r, 2, 10) : 0;
    return l;
}

static vxs_medium random_medium(rng *r)
{
    vxs_medium m = {.anisotropy = uniform(r, -0.8, 0.8)};
    for (int n = 0; n < 3; n++) {
        m.extinction[n] = uniform(r, 0, 0.3);
        m.scattering[n] = m.extinction[n] * uniform(r, 0, 1);
    }
    return m;
}

/* Without shadows it is what the library's closed forms say, of which range, cone and fog are cut in other ways; a light that is
 * lit in two parts has their sum. */
static void test_airlight(void **state)
{
    (void)state;
    rng r = {6};
    for (uint32_t n = 0; n < repeats(400, 8000); n++) {
        static const int kinds[] = {VXS_LIGHT_KIND_DIRECTIONAL, VXS_LIGHT_KIND_SPOT, VXS_LIGHT_KIND_POINT};
        reference_light  l       = random_light(&r, kinds[n % 3]);
        vxs_medium       m       = random_medium(&r);
        eye_ray          ray     = random_ray(&r, 8, uniform(&r, 1, 20));
        double           top     = rng_below(&r, 2) ? uniform(&r, -5, 5) : VXS_AIR_EVERYWHERE, found[3], wanted[3], in_fog[2];
        vxs_air_path     path    = vxs_air_path_of(&l.light, ray.eye, ray.direction, ray.end, top, in_fog);
        reference_airlight(&m, top, &l, &ray, found);
        vxs_air_lit(&m, &path, 0, ray.end, wanted);
        for (int i = 0; i < 3; i++) {
            double whole = fmax(wanted[i] * l.colour[i], 1e-7);
            if (!(fabs(found[i] - wanted[i] * l.colour[i]) < 2e-3 * whole))
                fail_msg("ray %u: %g, not %g", n, found[i], wanted[i] * l.colour[i]);
        }
        double  halves[3] = {0}, cut = uniform(&r, 0, ray.end);
        eye_ray half[2] = {ray, ray};
        half[0].end = half[1].begin = cut;
        for (int k = 0; k < 2; k++) {
            double part[3];
            reference_airlight(&m, top, &l, &half[k], part);
            for (int i = 0; i < 3; i++) halves[i] += part[i];
        }
        for (int i = 0; i < 3; i++) assert_true(fabs(halves[i] - found[i]) <= 1e-6 * found[i]);
    }
}

/* Twice as many samples change nothing, and the formula of the shadows' ends neither. */
static void test_converged(void **state)
{
    (void)state;
    rng      r    = {7};
    double   most = 0, largest = 0;
    uint32_t shadowed = 0;
    for (uint32_t n = 0; n < repeats(100, 2000); n++) {
        sphere          at[SPHERES];
        lit_spheres     s    = random_spheres(&r, n & 1, at);
        eye_ray         ray  = random_ray(&r, 5, 20);
        vxs_medium      m    = random_medium(&r);
        reference_light l    = random_light(&r, n & 1 ? VXS_LIGHT_KIND_POINT : VXS_LIGHT_KIND_DIRECTIONAL);
        traced_light    once = {spheres_lit, &s, s.light, TRACED_SAMPLES}, twice = once;
        double          a[3], b[3], c[3], d[3];
        twice.samples = 2 * TRACED_SAMPLES;
        for (int k = 0; k < 3; k++) l.light.place[k] = n & 1 ? s.light.position_ws[k] : -s.light.direction_ws[k];
        reference_airlight(&m, VXS_AIR_EVERYWHERE, &l, &ray, d);
        l.oracle  = traced_parts;
        l.subject = &once;
        reference_airlight(&m, VXS_AIR_EVERYWHERE, &l, &ray, a);
        l.subject = &twice;
        reference_airlight(&m, VXS_AIR_EVERYWHERE, &l, &ray, b);
        l.oracle  = sphere_parts;
        l.subject = &s;
        reference_airlight(&m, VXS_AIR_EVERYWHERE, &l, &ray, c);
        for (int i = 0; i < 3; i++) {
            most    = fmax(most, fmax(fabs(a[i] - b[i]), fabs(a[i] - c[i])));
            largest = fmax(largest, c[i]);
        }
        shadowed += c[0] < 0.9 * d[0];
    }
    print_message("of the largest airlight, most change: %.1e; %u rays in shadow\n", most / largest, shadowed);
    assert_true(most < 1e-6 * largest);
    assert_true(shadowed > repeats(10, 200));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_traced_spheres), cmocka_unit_test(test_traced_scene),  cmocka_unit_test(test_map_parts),
        cmocka_unit_test(test_mesh_is_map),    cmocka_unit_test(test_mesh_is_tight), cmocka_unit_test(test_airlight),
        cmocka_unit_test(test_converged),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
