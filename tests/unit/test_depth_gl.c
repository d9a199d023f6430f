/* Rendered enter and exit depths against a brute-force reference in double: every triangle through every texel centre,
 * sorted and counted (baker/lab/opengl/depth_gl.h; what e and x are stands in depth_gl.c).
 *
 * The scenes are written in the light's space, u and v in texels and z in voxels, so that the light's matrix is the
 * identity. Rasterizers snap vertices to 1/256 texel and interpolate in float: texels whose centre is within 1/128 of an
 * edge are not queried, and depths may differ by a tolerance that grows with a triangle's slope. Faces within it of each other
 * may swap places; then x has a range instead of a value. SPDX-License-Identifier: GPL-3.0-or-later */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/random.h"
#include "baker/base/vec3.h"
#include "baker/lab/opengl/depth_gl.h"
#include "baker/light/light_fit.h"
#include "runtime/vxs.h"
#include "tests/gl_choice.h"

#include <cmocka.h>

static gl_context *gl;

static int open_gl(void **state)
{
    run_context m = {0};
    (void)state;
    if (gl_context_create(&gl, gl_choice(), 2, &m) == VXS_OK) return 0;
    fprintf(stderr, "%s\n", m.error);
    return -1;
}

static int close_gl(void **state)
{
    (void)state;
    gl_context_destroy(gl);
    return 0;
}

/* scenes: solids are added before sheets --------------------------------------------------------------------------------------- */

typedef struct mesh {
    casters c;
    double  turn[3][3]; /* rotation of what is added, about `pivot` */
    double  pivot[3];
    int     reversed; /* turn what is added inside out */
} mesh;

static void mesh_init(mesh *k)
{
    memset(k, 0, sizeof *k);
    for (int n = 0; n < 3; n++) k->turn[n][n] = 1;
}

static double unit(rng *r)
{
    return rng_u32(r) / 4294967296.0;
}

/* What follows is turned by random angles about a point. */
static void turn_randomly(mesh *k, rng *r, double u, double v, double z)
{
    double a[3] = {unit(r) - 0.5, unit(r) - 0.5, unit(r) - 0.5}, b[3] = {unit(r) - 0.5, unit(r) - 0.5, unit(r) + 0.5};
    double side[3];
    vec3_cross(a, b, side);
    assert_true(vec3_unit(a, k->turn[0]) && vec3_unit(side, k->turn[1]));
    vec3_cross(k->turn[0], k->turn[1], k->turn[2]);
    k->pivot[0] = u;
    k->pivot[1] = v;
    k->pivot[2] = z;
}

static void add_triangle(mesh *k, const double a[3], const double b[3], const double c[3])
{
    casters      *m         = &k->c;
    const double *corner[3] = {a, k->reversed ? c : b, k->reversed ? b : c};
    m->positions_ws         = realloc(m->positions_ws, (m->vertex_count + 3) * 3 * sizeof *m->positions_ws);
    m->indices              = realloc(m->indices, (m->triangle_count + 1) * 3 * sizeof *m->indices);
    assert_non_null(m->positions_ws);
    assert_non_null(m->indices);
    for (int n = 0; n < 3; n++) {
        double from[3];
        vec3_sub(corner[n], k->pivot, from);
        double *to = m->positions_ws + 3 * m->vertex_count;
        for (int row = 0; row < 3; row++)
            to[row] = k->pivot[row] + k->turn[row][0] * from[0] + k->turn[row][1] * from[1] + k->turn[row][2] * from[2];
        m->indices[3 * m->triangle_count + (size_t)n] = (uint32_t)m->vertex_count++;
    }
    m->triangle_count++;
}

static void add_quad(mesh *k, const double a[3], const double b[3], const double c[3], const double d[3])
{
    add_triangle(k, a, b, c);
    add_triangle(k, a, c, d);
}

/* Faces outward: counter-clockwise seen from outside. */
static void add_box(mesh *k, double u0, double v0, double z0, double u1, double v1, double z1)
{
    double p[8][3];
    for (int n = 0; n < 8; n++) {
        p[n][0] = n & 1 ? u1 : u0;
        p[n][1] = n & 2 ? v1 : v0;
        p[n][2] = n & 4 ? z1 : z0;
    }
    static const uint8_t faces[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
    for (int f = 0; f < 6; f++) add_quad(k, p[faces[f][0]], p[faces[f][1]], p[faces[f][2]], p[faces[f][3]]);
}

static void add_sphere(mesh *k, double u, double v, double z, double radius)
{
    enum { STACKS = 10, SLICES = 16 };
    const double pi = acos(-1);
    double       p[STACKS + 1][SLICES + 1][3];
    for (int s = 0; s <= STACKS; s++)
        for (int t = 0; t <= SLICES; t++) {
            double a = pi * s / STACKS, b = 2 * pi * (t % SLICES) / SLICES;
            p[s][t][0] = u + radius * (s == STACKS ? 0 : sin(a)) * cos(b);
            p[s][t][1] = v + radius * (s == STACKS ? 0 : sin(a)) * sin(b);
            p[s][t][2] = z + radius * cos(a);
        }
    for (int s = 0; s < STACKS; s++)
        for (int t = 0; t < SLICES; t++) {
            if (s) add_triangle(k, p[s][t], p[s + 1][t], p[s][t + 1]);
            if (s + 1 < STACKS) add_triangle(k, p[s][t + 1], p[s + 1][t], p[s + 1][t + 1]);
        }
}

static void add_sheet(mesh *k, double u0, double v0, double u1, double v1, double z, double slope)
{
    double a[3] = {u0, v0, z}, b[3] = {u1, v0, z + slope}, c[3] = {u1, v1, z + slope}, d[3] = {u0, v1, z};
    add_quad(k, a, b, c, d);
}

static void solids_end(mesh *k)
{
    k->c.solid_triangle_count = k->c.triangle_count;
}

/* the reference ---------------------------------------------------------------------------------------------------------------- */

typedef struct hit {
    double depth, tolerance;
    int    front, solid;
} hit;

enum { HITS_MAX = 64 };

typedef struct texel_hits {
    hit hits[HITS_MAX];
    int count;
    int unsure; /* an edge passes too near */
} texel_hits;

static double segment_distance(const double p[2], const double a[2], const double b[2])
{
    double d[2] = {b[0] - a[0], b[1] - a[1]}, length2 = d[0] * d[0] + d[1] * d[1];
    double t = length2 > 0 ? ((p[0] - a[0]) * d[0] + (p[1] - a[1]) * d[1]) / length2 : 0;
    t        = fmin(fmax(t, 0), 1);
    return hypot(p[0] - a[0] - t * d[0], p[1] - a[1] - t * d[1]);
}

static double area2(const double a[2], const double b[2], const double c[2])
{
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

/* corners: u and v as they are for coverage, and snapped for the plane of depths. */
static void hit_texel(texel_hits *t, const double p[2], double flat[3][2], double snapped[3][2], const double z[3], int solid,
                      uint32_t side)
{
    for (int n = 0; n < 3; n++) t->unsure |= segment_distance(p, flat[n], flat[(n + 1) % 3]) < 1.0 / 128;
    double w[3] = {area2(flat[1], flat[2], p), area2(flat[2], flat[0], p), area2(flat[0], flat[1], p)};
    int    in   = (w[0] > 0 && w[1] > 0 && w[2] > 0) || (w[0] < 0 && w[1] < 0 && w[2] < 0);
    double area = area2(snapped[0], snapped[1], snapped[2]);
    if (!in || t->unsure || area == 0) return;

    /* depth as a plane over the first corner, and how steep it is */
    double du = ((z[1] - z[0]) * (snapped[2][1] - snapped[0][1]) - (z[2] - z[0]) * (snapped[1][1] - snapped[0][1])) / area;
    double dv = ((z[2] - z[0]) * (snapped[1][0] - snapped[0][0]) - (z[1] - z[0]) * (snapped[2][0] - snapped[0][0])) / area;
    assert_true(t->count < HITS_MAX);
    t->hits[t->count++] = (hit){.depth     = z[0] + du * (p[0] - snapped[0][0]) + dv * (p[1] - snapped[0][1]),
                                .tolerance = 3e-7 + (fabs(du) + fabs(dv)) * (side < 512 ? side : 512) * 3e-7,
                                .front     = area < 0, /* the normal points to the light */
                                .solid     = solid};
}

/* Of the texels [u0, u0 + side) x [v0, v0 + side) of a map of map_side texels. */
static texel_hits *cast_rays(const casters *c, uint32_t u0, uint32_t v0, uint32_t side, uint32_t map_side)
{
    texel_hits *all = calloc((size_t)side * side, sizeof *all);
    assert_non_null(all);
    for (size_t n = 0; n < c->triangle_count; n++) {
        double flat[3][2], snapped[3][2], z[3], low[2] = {1e30, 1e30}, high[2] = {-1e30, -1e30};
        for (int corner = 0; corner < 3; corner++) {
            const double *p = c->positions_ws + 3 * (size_t)c->indices[3 * n + (size_t)corner];
            for (int axis = 0; axis < 2; axis++) {
                flat[corner][axis]    = p[axis];
                snapped[corner][axis] = rint(p[axis] * 256) / 256;
                low[axis]             = fmin(low[axis], p[axis] - (axis ? v0 : u0));
                high[axis]            = fmax(high[axis], p[axis] - (axis ? v0 : u0));
            }
            z[corner] = p[2] / map_side;
        }
        for (int64_t v = (int64_t)fmax(floor(low[1] - 1), 0); v < side && (double)v < high[1] + 1; v++)
            for (int64_t u = (int64_t)fmax(floor(low[0] - 1), 0); u < side && (double)u < high[0] + 1; u++) {
                double p[2] = {(double)u + u0 + 0.5, (double)v + v0 + 0.5};
                hit_texel(&all[v * side + u], p, flat, snapped, z, n < c->solid_triangle_count, map_side);
            }
    }
    return all;
}

typedef struct range {
    double low, high;
} range;

static range nearest(const texel_hits *t, int solid, double far)
{
    range r = {far, far};
    for (int n = 0; n < t->count; n++) {
        if (t->hits[n].solid != solid) continue;
        r.low  = fmin(r.low, t->hits[n].depth - t->hits[n].tolerance);
        r.high = fmin(r.high, t->hits[n].depth + t->hits[n].tolerance);
    }
    return r;
}

/* Where a ray leaves the union of solids: at the first back face at or before which there are no more front faces than back
 * faces. low: the first that may be it, however depths are rounded. high: the first that is it when faces within the
 * tolerance are taken together, since the last of them to be peeled has all others behind it. */
static range first_exit(const texel_hits *t)
{
    range r = {2, 2};
    for (int n = 0; n < t->count; n++) {
        const hit *b = &t->hits[n];
        if (!b->solid || b->front) continue;
        int    least = 0, most = 0;
        double last = b->depth + b->tolerance;
        for (int k = 0; k < t->count; k++) {
            const hit *o     = &t->hits[k];
            double     slack = o->tolerance + b->tolerance;
            if (!o->solid) continue;
            least += o->front ? o->depth < b->depth - slack : -(o->depth <= b->depth + slack);
            most += o->front ? o->depth <= b->depth + 3 * slack : -(o->depth <= b->depth + slack);
            if (!o->front && o->depth <= b->depth + slack) last = fmax(last, o->depth + o->tolerance);
        }
        if (least <= 0) r.low = fmin(r.low, b->depth - b->tolerance);
        if (most <= 0) r.high = fmin(r.high, last);
    }
    return r;
}

static range first_back(const texel_hits *t)
{
    range r = {2, 2};
    for (int n = 0; n < t->count; n++) {
        const hit *b = &t->hits[n];
        if (!b->solid || b->front) continue;
        r.low  = fmin(r.low, b->depth - b->tolerance);
        r.high = fmin(r.high, b->depth + b->tolerance);
    }
    return r;
}

/* rendering and comparing ------------------------------------------------------------------------------------------------------ */

static vxs_light identity_light(uint32_t side)
{
    vxs_light l;
    memset(&l, 0, sizeof l);
    while (1u << l.levels < side) l.levels++;
    l.kind          = VXS_LIGHT_KIND_DIRECTIONAL;
    l.ls_from_ws[0] = l.ls_from_ws[5] = l.ls_from_ws[10] = 1;
    l.texel_metres = l.voxel_metres = 1;
    l.direction_ws[2]               = 1;
    return l;
}

/* The square (i, j) of tile_px texels of a map. */
static depth_stats render_light(const casters *c, const vxs_light *light, exit_mode mode, uint32_t threads, uint32_t tile_px,
                                uint32_t i, uint32_t j, depth_maps *maps)
{
    depth_renderer *r;
    run_context     m = {0};
    assert_int_equal(depth_renderer_create(&r, gl, c, light, 0, mode, threads, &m), VXS_OK);
    assert_int_equal(depth_maps_init(maps, tile_px, 1u << light->levels, 0, c->solid_triangle_count != 0, &m), VXS_OK);
    assert_int_equal(depth_renderer_tile(r, maps, i, j, &m), VXS_OK);
    depth_stats stats = depth_renderer_stats(r);
    depth_renderer_destroy(r);
    return stats;
}

static depth_stats render(const casters *c, uint32_t side, exit_mode mode, depth_maps *maps)
{
    vxs_light light = identity_light(side);
    return render_light(c, &light, mode, 2, side, 0, 0, maps);
}

typedef struct compared {
    size_t asked, sure; /* texels with casters; of them, those whose exit has one value */
    size_t early;       /* those that left the union before its farthest possible exit: right, but for a smaller free range */
    double worst;       /* farthest e from the reference, in tolerances */
} compared;

static compared compare_maps(const texel_hits *all, const depth_maps *maps, exit_mode mode)
{
    compared result = {0};
    double   far    = maps->voxel_log == 0 ? 1 : 0; /* depth_maps.h: where there is no caster */
    for (size_t n = 0; n < (size_t)maps->side_px * maps->side_px; n++) {
        const texel_hits *t = &all[n];
        double            e = maps->enter[n], x = maps->exit[n];
        assert_true(far - 1 <= e && e <= x && x <= far);
        if (t->unsure) continue;
        range s = nearest(t, 1, far), h = nearest(t, 0, far);
        range exit = mode == EXIT_BACK ? first_back(t) : first_exit(t);
        assert_true(e >= fmin(s.low, h.low) && e <= fmin(s.high, h.high));
        int sheet_first = h.low <= s.high, solid_first = s.low <= h.high; /* both: too near to tell */
        int right = (sheet_first && x == e) || (solid_first && x >= fmin(exit.low, far) && x <= exit.high);
        if (!right)
            print_error("texel %zu: e %.9g, x %.9g, expected s %.9g..%.9g h %.9g..%.9g x %.9g..%.9g\n", n, e, x, s.low, s.high,
                        h.low, h.high, exit.low, exit.high);
        assert_true(right);
        result.asked += t->count > 0;
        result.sure += t->count > 0 && solid_first && !sheet_first && exit.high - exit.low < 1e-3;
        result.early += solid_first && !sheet_first && x < exit.high - 1e-3;
        if (t->count)
            result.worst = fmax(result.worst, fabs(2 * e - fmin(s.low, h.low) - fmin(s.high, h.high)) /
                                                  (fmin(s.high, h.high) - fmin(s.low, h.low)));
    }
    return result;
}

/* Peeled and nearest-back exits of a scene in a map of `side` texels. */
static depth_stats check_scene(mesh *k, uint32_t side)
{
    depth_maps  peel, back;
    depth_stats stats = render(&k->c, side, EXIT_PEEL, &peel);
    render(&k->c, side, EXIT_BACK, &back);
    texel_hits *all = cast_rays(&k->c, 0, 0, side, side);
    compared    c   = compare_maps(all, &peel, EXIT_PEEL);
    compare_maps(all, &back, EXIT_BACK);
    for (size_t n = 0; n < (size_t)side * side; n++) {
        assert_true(back.enter[n] == peel.enter[n]);
        assert_true(back.exit[n] <= peel.exit[n]); /* never behind it */
    }
    if (getenv("DEPTH_VERBOSE"))
        print_message("%u: %zu triangles, %zu texels, %zu sure, %zu early, worst %.2f, %u passes\n", side, k->c.triangle_count,
                      c.asked, c.sure, c.early, c.worst, stats.peel_passes_max);
    if (side >= 64) assert_true(c.asked > (size_t)side * side / 100);
    free(all);
    depth_maps_free(&peel);
    depth_maps_free(&back);
    casters_free(&k->c);
    return stats;
}

/* solids ----------------------------------------------------------------------------------------------------------------------- */

static void boxes_that_intersect(void **state)
{
    (void)state;
    for (uint32_t side = 8; side <= 256; side *= 2)
        for (uint64_t seed = 0; seed < (side < 256 ? 10 : 4); seed++) {
            rng    r = rng_split(seed, side);
            mesh   k;
            double s = side;
            mesh_init(&k);
            for (int n = 0; n < 30; n++) {
                double u = s * (0.2 + 0.6 * unit(&r)), v = s * (0.2 + 0.6 * unit(&r)), z = s * (0.2 + 0.6 * unit(&r));
                double a = s * 0.1 * (0.1 + unit(&r)), b = s * 0.1 * (0.1 + unit(&r)), c = s * 0.1 * (0.1 + unit(&r));
                turn_randomly(&k, &r, u, v, z);
                add_box(&k, u - a, v - b, z - c, u + a, v + b, z + c);
            }
            solids_end(&k);
            check_scene(&k, side);
        }
}

static void boxes_inside_boxes(void **state)
{
    (void)state;
    for (uint64_t seed = 0; seed < 4; seed++) {
        rng  r = rng_split(seed, 1);
        mesh k;
        mesh_init(&k);
        turn_randomly(&k, &r, 128, 128, 128);
        for (int n = 1; n <= 6; n++)
            add_box(&k, 128 - 10.3 * n, 128 - 9.7 * n, 128 - 8.1 * n, 128 + 9 * n, 128 + 10 * n, 128 + 11 * n);
        solids_end(&k);
        depth_stats stats = check_scene(&k, 256);
        assert_true(stats.peel_passes_max > 1);
        assert_int_equal(stats.blocks_rendered, 1);
    }
}

static void spheres(void **state)
{
    (void)state;
    for (uint64_t seed = 0; seed < 4; seed++) {
        rng  r = rng_split(seed, 2);
        mesh k;
        mesh_init(&k);
        for (int n = 0; n < 8; n++)
            add_sphere(&k, 64 + 128 * unit(&r), 64 + 128 * unit(&r), 64 + 128 * unit(&r), 10 + 40 * unit(&r));
        solids_end(&k);
        check_scene(&k, 256);
    }
}

/* Walls that share a face exactly, boxes that are there twice, stacks along the light: one face ends where another starts.
 */
static void boxes_that_share_faces(void **state)
{
    (void)state;
    for (uint64_t seed = 0; seed < 6; seed++) {
        rng  r = rng_split(seed, 3);
        mesh k;
        mesh_init(&k);
        if (seed) turn_randomly(&k, &r, 128, 128, 128);
        double z = 70;
        for (int n = 0; n < 5; n++) { /* a stack */
            double more = 5 + 15 * unit(&r);
            add_box(&k, 70.3, 80.1, z, 120.7, 130.9, z + more);
            z += more;
        }
        for (int n = 0; n < 4; n++) add_box(&k, 130.5 + 10 * n, 90.2, 100, 140.5 + 10 * n, 150.3, 140); /* side by side */
        for (int n = 0; n < 3; n++) add_box(&k, 90.4, 140.6, 90, 110.8, 170.2, 120);                    /* the same box again */
        add_box(&k, 90.4, 140.6, 120, 110.8, 170.2, 130);                                               /* on all three */
        add_box(&k, 160.2, 160.7, 80, 180.4, 175.1, 160);
        add_box(&k, 165.2, 162.7, 80, 175.4, 173.1, 160); /* both ends in common */
        solids_end(&k);
        check_scene(&k, 256);
    }
}

/* Faces across the light have depths that float holds: here the exit must be exact, not merely in a range. */
static void stacks_along_the_light_are_exact(void **state)
{
    (void)state;
    mesh k;
    mesh_init(&k);
    for (int n = 0; n < 8; n++) add_box(&k, 4, 4, 8 + 4 * n, 28, 28, 12 + 4 * n); /* 8 .. 40 in eight */
    for (int n = 0; n < 3; n++) add_box(&k, 36, 4, 16, 60, 28, 24);               /* 16 .. 24 thrice */
    add_box(&k, 4, 36, 8, 28, 60, 20), add_box(&k, 4, 36, 12, 28, 60, 20);        /* ends together */
    add_box(&k, 4, 36, 20, 28, 60, 44), add_box(&k, 4, 36, 48, 28, 60, 56);       /* goes on; then a gap */
    add_box(&k, 36, 36, 8, 60, 60, 16), add_box(&k, 36, 36, 8, 60, 60, 32);       /* starts together */
    solids_end(&k);
    const double expected[4][2] = {{8, 40}, {16, 24}, {8, 44}, {8, 32}};
    depth_maps   maps;
    render(&k.c, 64, EXIT_PEEL, &maps);
    for (uint32_t v = 0; v < 64; v++)
        for (uint32_t u = 0; u < 64; u++) {
            int    inside = u % 32 >= 4 && u % 32 < 28 && v % 32 >= 4 && v % 32 < 28;
            size_t which  = u / 32 + 2 * (v / 32);
            assert_true(maps.enter[v * 64 + u] * 64 == (inside ? expected[which][0] : 64));
            assert_true(maps.exit[v * 64 + u] * 64 == (inside ? expected[which][1] : 64));
        }
    depth_maps_free(&maps);
    casters_free(&k.c);
}

/* A surface that turns itself inside out: lobes whose faces point inward, apart from solids, within one, and across its
 * wall. */
static void inverted_lobes(void **state)
{
    (void)state;
    for (uint64_t seed = 0; seed < 6; seed++) {
        rng  r = rng_split(seed, 4);
        mesh k;
        mesh_init(&k);
        turn_randomly(&k, &r, 128, 128, 128);
        add_box(&k, 80, 80, 80, 150, 150, 150);
        k.reversed = 1;
        add_box(&k, 60.3, 100.7, 90.1, 90.2, 120.3, 200.9);
        add_box(&k, 100.1, 100.2, 100.3, 120.1, 120.2, 120.3);
        add_sphere(&k, 150, 120, 130, 25);
        add_box(&k, 155, 155, 100, 180, 180, 120);
        solids_end(&k);
        check_scene(&k, 256);
    }
}

/* sheets ----------------------------------------------------------------------------------------------------------------------- */

static void sheets_among_solids(void **state)
{
    (void)state;
    for (uint64_t seed = 0; seed < 6; seed++) {
        rng  r = rng_split(seed, 5);
        mesh k;
        mesh_init(&k);
        turn_randomly(&k, &r, 128, 128, 128);
        for (int n = 0; n < 6; n++) {
            double u = 70 + 80 * unit(&r), v = 70 + 80 * unit(&r), z = 70 + 80 * unit(&r);
            add_box(&k, u, v, z, u + 10 + 30 * unit(&r), v + 10 + 30 * unit(&r), z + 10 + 30 * unit(&r));
        }
        solids_end(&k);
        for (int n = 0; n < 12; n++) {
            turn_randomly(&k, &r, 128, 128, 128);
            double u = 70 + 80 * unit(&r), v = 70 + 80 * unit(&r);
            add_sheet(&k, u, v, u + 10 + 30 * unit(&r), v + 10 + 30 * unit(&r), 60 + 130 * unit(&r), 20 * unit(&r));
        }
        check_scene(&k, 256);
    }
}

/* In front of a solid, on its front, inside, on its back, behind it; and nothing but a sheet. */
static void a_sheet_first_has_no_inside(void **state)
{
    (void)state;
    mesh k;
    mesh_init(&k);
    add_box(&k, 0, 0, 16, 64, 32, 48);
    solids_end(&k);
    const double depths[5]      = {8, 16, 32, 48, 56};
    const double expected[5][2] = {{8, 8}, {16, 16}, {16, 48}, {16, 48}, {16, 48}};
    for (int n = 0; n < 5; n++) add_sheet(&k, 12 * n, 0, 12 * n + 12, 64, depths[n], 0);
    depth_maps maps;
    render(&k.c, 64, EXIT_PEEL, &maps);
    for (uint32_t v = 0; v < 64; v++)
        for (uint32_t u = 0; u < 60; u++) {
            assert_true(maps.enter[v * 64 + u] * 64 == (v < 32 ? expected[u / 12][0] : depths[u / 12]));
            assert_true(maps.exit[v * 64 + u] * 64 == (v < 32 ? expected[u / 12][1] : depths[u / 12]));
        }
    depth_maps_free(&maps);
    casters_free(&k.c);
}

/* Boxes apart from each other, and in one corner of the map one that holds another. */
static void only_blocks_with_solids_that_meet_are_peeled(void **state)
{
    (void)state;
    enum { SIDE = 1024, CELL = 128 };
    rng  r = {11};
    mesh k;
    mesh_init(&k);
    for (int n = 0; n < SIDE / CELL * SIDE / CELL; n++) {
        double u = n % (SIDE / CELL) * CELL + CELL / 2, v = n / (SIDE / CELL) * CELL + CELL / 2, z = 200 + 600 * unit(&r);
        turn_randomly(&k, &r, u, v, z);
        add_box(&k, u - 30, v - 30, z - 30, u + 30, v + 30, z + 30);
    }
    add_box(&k, CELL * 7.5 - 10, CELL * 7.5 - 10, k.pivot[2] - 10, CELL * 7.5 + 10, CELL * 7.5 + 10, k.pivot[2] + 10);
    size_t triangles         = k.c.triangle_count;
    k.c.solid_triangle_count = triangles;
    k.c.solid_meets          = calloc(triangles, 1);
    assert_non_null(k.c.solid_meets);
    for (size_t t = triangles - 24; t < triangles; t++) k.c.solid_meets[t] = 1;

    depth_maps  by_need, all;
    depth_stats need = render(&k.c, SIDE, EXIT_AUTO, &by_need), each = render(&k.c, SIDE, EXIT_PEEL, &all);
    assert_int_equal(need.blocks_peeled, 1);
    assert_int_equal(need.blocks_not_peeled, 3);
    assert_int_equal(each.blocks_peeled, 4);
    assert_int_equal(each.blocks_not_peeled, 0);
    assert_true(need.peel_passes > 0 && need.peel_passes < each.peel_passes);
    assert_memory_equal(by_need.enter, all.enter, sizeof(float) * SIDE * SIDE);
    assert_memory_equal(by_need.exit, all.exit, sizeof(float) * SIDE * SIDE);
    depth_maps_free(&by_need);
    depth_maps_free(&all);
    casters_free(&k.c);
}

static void sheets_alone_share_one_map(void **state)
{
    (void)state;
    rng  r = {6};
    mesh k;
    mesh_init(&k);
    for (int n = 0; n < 40; n++) {
        turn_randomly(&k, &r, 128, 128, 128);
        double u = 60 + 80 * unit(&r), v = 60 + 80 * unit(&r);
        add_sheet(&k, u, v, u + 60 * unit(&r), v + 60 * unit(&r), 60 + 130 * unit(&r), 20 * unit(&r));
    }
    depth_maps  maps;
    depth_stats stats = render(&k.c, 256, EXIT_AUTO, &maps);
    texel_hits *all   = cast_rays(&k.c, 0, 0, 256, 256);
    assert_ptr_equal(maps.enter, maps.exit);
    assert_int_equal(stats.peel_passes, 0);
    compare_maps(all, &maps, EXIT_PEEL);
    free(all);
    depth_maps_free(&maps);
    casters_free(&k.c);
}

/* triangles that rasterizers have trouble with --------------------------------------------------------------------------------- */

static void assert_depths_within(const depth_maps *maps, double low, double high)
{
    const double slack = 2e-6;
    for (size_t n = 0; n < (size_t)maps->side_px * maps->side_px; n++) {
        double e = maps->enter[n], x = maps->exit[n];
        assert_true(e <= x);
        assert_true(e == 1 || (e >= low - slack && e <= high + slack));
        assert_true(x == 1 ? e == 1 : x >= low - slack && x <= high + slack);
    }
}

/* Walls along the light, and off it by less than any texel: no depth may run off the walls' ends. */
static void walls_along_the_light(void **state)
{
    static const double leans[] = {0, 1e-12, 1e-9, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1};
    (void)state;
    for (size_t lean = 0; lean < sizeof leans / sizeof *leans; lean++)
        for (int solid = 0; solid < 2; solid++) {
            rng  r = rng_split(lean, 7);
            mesh k;
            mesh_init(&k);
            k.turn[0][2] = leans[lean];
            k.turn[1][2] = -leans[lean] / 3;
            for (int n = 0; n < 40; n++) {
                /* on texel centres, on their edges, and anywhere */
                double u = 20 + rng_below(&r, 400) * 0.5, v = 20 + rng_below(&r, 400) * 0.5, thin = n % 3 ? 2.5 : 0.01;
                if (n % 2) u += unit(&r), v += unit(&r);
                add_box(&k, u, v, 64, u + thin, v + 20 * unit(&r), 128);
            }
            if (solid) solids_end(&k);
            depth_maps maps;
            render(&k.c, 256, EXIT_PEEL, &maps);
            assert_depths_within(&maps, 64 / 256.0, 128 / 256.0);
            depth_maps_free(&maps);
            casters_free(&k.c);
        }
}

static void needles(void **state)
{
    (void)state;
    for (uint64_t seed = 0; seed < 20; seed++) {
        rng    r = rng_split(seed, 8);
        mesh   k;
        double width = pow(10, -6 + 0.3 * (double)seed);
        mesh_init(&k);
        for (int n = 0; n < 300; n++) {
            double a[3] = {256 * unit(&r), 256 * unit(&r), 64 + 64 * unit(&r)};
            double b[3] = {256 * unit(&r), 256 * unit(&r), 64 + 64 * unit(&r)};
            double t    = unit(&r), c[3];
            for (int axis = 0; axis < 3; axis++)
                c[axis] = a[axis] + t * (b[axis] - a[axis]) + (axis < 2 ? width * (unit(&r) - 0.5) : 0);
            c[2] = 64 + 64 * unit(&r); /* as steep as it can be */
            add_triangle(&k, a, b, c);
        }
        if (seed % 2) solids_end(&k); /* not closed: still no depth out of range */
        depth_maps maps;
        render(&k.c, 256, EXIT_PEEL, &maps);
        assert_depths_within(&maps, 64 / 256.0, 128 / 256.0);
        depth_maps_free(&maps);
        casters_free(&k.c);
    }
}

/* Casters that reach out of the map: before it they count at depth 0, beside it and behind it not at all. */
static void casters_beyond_the_map(void **state)
{
    (void)state;
    mesh k;
    mesh_init(&k);
    add_box(&k, -1e6, 8, -1e6, 32, 24, 16); /* out at the left and in front */
    add_box(&k, 40, 8, -100, 60, 24, -50);  /* wholly in front */
    add_box(&k, 8, 40, 32, 24, 60, 1e6);    /* out at the back */
    add_box(&k, 40, 40, 65, 60, 60, 80);    /* wholly behind */
    add_box(&k, 1e5, 1e5, 8, 1e6, 1e6, 9);  /* wholly beside */
    solids_end(&k);
    depth_maps maps;
    render(&k.c, 64, EXIT_PEEL, &maps);
    for (uint32_t v = 0; v < 64; v++)
        for (uint32_t u = 0; u < 64; u++) {
            float e = maps.enter[v * 64 + u] * 64, x = maps.exit[v * 64 + u] * 64;
            if (v >= 8 && v < 24 && u < 32)
                assert_true(e == 0 && x == 16);
            else if (v >= 8 && v < 24 && u >= 40 && u < 60)
                assert_true(e == 0 && x == 0);
            else if (v >= 40 && v < 60 && u >= 8 && u < 24)
                assert_true(e == 32 && x >= e);
            else
                assert_true(e == 64 && x == 64);
        }
    depth_maps_free(&maps);
    casters_free(&k.c);
}

/* tiles, blocks, threads, lights ----------------------------------------------------------------------------------------------- */

static mesh city(uint64_t seed, uint32_t side)
{
    rng    r = rng_split(seed, 9);
    mesh   k;
    double s = side;
    mesh_init(&k);
    for (int n = 0; n < 60; n++) {
        double u = s * 0.9 * unit(&r), v = s * 0.9 * unit(&r), z = s * (0.2 + 0.5 * unit(&r));
        turn_randomly(&k, &r, u, v, z);
        add_box(&k, u, v, z, u + s * 0.1 * unit(&r), v + s * 0.1 * unit(&r), z + s * 0.2 * unit(&r));
    }
    solids_end(&k);
    return k;
}

static void tiles_make_up_the_map(void **state)
{
    (void)state;
    enum { SIDE = 2048, TILE = 512 };
    mesh            k     = city(1, SIDE);
    vxs_light       light = identity_light(SIDE);
    depth_maps      whole;
    depth_renderer *r;
    run_context     m = {0};
    render_light(&k.c, &light, EXIT_PEEL, 2, SIDE, 0, 0, &whole);
    assert_int_equal(depth_renderer_create(&r, gl, &k.c, &light, 0, EXIT_PEEL, 2, &m), VXS_OK);
    depth_maps tile;
    assert_int_equal(depth_maps_init(&tile, TILE, SIDE, 0, 1, &m), VXS_OK);
    for (uint32_t j = 0; j < SIDE / TILE; j++)
        for (uint32_t i = 0; i < SIDE / TILE; i++) {
            int any = 0;
            assert_int_equal(depth_renderer_tile(r, &tile, i, j, &m), VXS_OK);
            for (uint32_t row = 0; row < TILE; row++) {
                size_t at = (size_t)(j * TILE + row) * SIDE + i * TILE;
                assert_memory_equal(tile.enter + (size_t)row * TILE, whole.enter + at, TILE * sizeof *tile.enter);
                assert_memory_equal(tile.exit + (size_t)row * TILE, whole.exit + at, TILE * sizeof *tile.exit);
                for (uint32_t n = 0; n < TILE; n++) any |= whole.enter[at + n] < 1;
            }
            if (any) assert_true(depth_renderer_has_casters(r, TILE, i, j));
        }
    assert_true(depth_renderer_has_casters(r, SIDE, 0, 0));
    depth_renderer_destroy(r);

    /* across the corner of four blocks, against the reference */
    texel_hits *all = cast_rays(&k.c, 960, 960, 128, SIDE);
    depth_maps  part;
    assert_int_equal(depth_maps_init(&part, 128, SIDE, 0, 1, &m), VXS_OK);
    for (size_t row = 0; row < 128; row++) {
        memcpy(part.enter + row * 128, whole.enter + (960 + row) * SIDE + 960, 128 * sizeof *part.enter);
        memcpy(part.exit + row * 128, whole.exit + (960 + row) * SIDE + 960, 128 * sizeof *part.exit);
    }
    compare_maps(all, &part, EXIT_PEEL);
    free(all);
    depth_maps_free(&part);
    depth_maps_free(&tile);
    depth_maps_free(&whole);
    casters_free(&k.c);
}

static void empty_squares_have_no_casters(void **state)
{
    (void)state;
    mesh k;
    mesh_init(&k);
    add_box(&k, 70, 70, 10, 120, 120, 20); /* in the square (1, 1) of 64 texels */
    solids_end(&k);
    vxs_light       light = identity_light(256);
    depth_renderer *r;
    run_context     m = {0};
    assert_int_equal(depth_renderer_create(&r, gl, &k.c, &light, 0, EXIT_AUTO, 1, &m), VXS_OK);
    for (uint32_t j = 0; j < 4; j++)
        for (uint32_t i = 0; i < 4; i++) assert_int_equal(depth_renderer_has_casters(r, 64, i, j), i == 1 && j == 1);
    depth_renderer_destroy(r);
    depth_renderer_destroy(NULL);
    casters_free(&k.c);
}

static void threads_change_nothing(void **state)
{
    (void)state;
    mesh       k     = city(2, 1024);
    vxs_light  light = identity_light(1024);
    depth_maps one, many;
    render_light(&k.c, &light, EXIT_PEEL, 1, 1024, 0, 0, &one);
    render_light(&k.c, &light, EXIT_PEEL, 8, 1024, 0, 0, &many);
    assert_memory_equal(one.enter, many.enter, (size_t)1024 * 1024 * sizeof *one.enter);
    assert_memory_equal(one.exit, many.exit, (size_t)1024 * 1024 * sizeof *one.exit);
    depth_maps_free(&one);
    depth_maps_free(&many);
    casters_free(&k.c);
}

/* World space to the light's and back through a fitted light: the same scene, seen from anywhere, far from the origin. */
static void fitted_lights(void **state)
{
    (void)state;
    for (uint64_t seed = 0; seed < 6; seed++) {
        rng         r    = rng_split(seed, 10);
        mesh        k    = city(seed, 256);
        double      v[3] = {unit(&r) - 0.5, unit(&r) - 0.5, unit(&r) - 0.5};
        vxs_light   light;
        run_context m     = {0};
        light_shape shape = {.kind = LIGHT_DIRECTIONAL};
        assert_true(vec3_unit(v, shape.direction_ws));
        for (size_t n = 0; n < 3 * k.c.vertex_count; n++) k.c.positions_ws[n] += seed % 2 ? 1e5 : 0;
        light_fit_desc fit = {.name = "sun", .shape = &shape, .resolution = 256};
        assert_int_equal(light_fit(&light, &k.c, &fit, &m), VXS_OK);
        depth_maps maps;
        render_light(&k.c, &light, EXIT_PEEL, 2, 256, 0, 0, &maps);

        mesh seen           = k; /* the same triangles in the light's space */
        seen.c.positions_ws = malloc(3 * k.c.vertex_count * sizeof(double));
        assert_non_null(seen.c.positions_ws);
        for (size_t n = 0; n < k.c.vertex_count; n++)
            for (size_t row = 0; row < 3; row++) {
                const double *a = light.ls_from_ws + 4 * row, *p = k.c.positions_ws + 3 * n;
                seen.c.positions_ws[3 * n + row] = a[0] * p[0] + a[1] * p[1] + a[2] * p[2] + a[3];
            }
        texel_hits *all = cast_rays(&seen.c, 0, 0, 256, 256);
        compared    c   = compare_maps(all, &maps, EXIT_PEEL);
        assert_true(c.asked > 1000);
        free(all);
        free(seen.c.positions_ws);
        depth_maps_free(&maps);
        casters_free(&k.c);
    }
}

/* spot and point lights: rays from the light through texel centres, in the space of the map and in double ---------------------- */

static const double nearest_share = 1.0 / 1024; /* what is nearer than this of the near side is cut off (map_space.c) */

/* A corner of a cube's map by the names of vxs.md section 2, as tests/unit/random_light.h has them. */
static void to_map(const vxs_light *l, int map, const double *ws, double out[3])
{
    static const char *const names[6] = {"yzx", "zyX", "zxy", "xzY", "xyz", "yxZ"};
    const char              *axes     = names[l->flags & VXS_LIGHT_CUBE ? map : 4];
    for (int n = 0; n < 3; n++) {
        const double *m = l->ls_from_ws + 4 * (axes[n] < 'a' ? axes[n] - 'X' : axes[n] - 'x');
        out[n]          = (m[0] * ws[0] + m[1] * ws[1] + m[2] * ws[2] + m[3]) * (axes[n] < 'a' ? -1 : 1);
    }
}

/* Where an edge is seen, in texels; 0 when it is not in front of the light. */
static int see_edge(const vxs_light *l, const double a[3], const double b[3], double flat[2][2])
{
    double tip = l->near_metres * nearest_share, half = ldexp(0.5, (int)l->levels);
    if (a[2] < tip && b[2] < tip) return 0;
    for (int end = 0; end < 2; end++) {
        const double *from = end ? b : a, *to = end ? a : b;
        double        t = from[2] < tip ? (tip - from[2]) / (to[2] - from[2]) : 0, z = from[2] + t * (to[2] - from[2]);
        for (int n = 0; n < 2; n++) flat[end][n] = half + (from[n] + t * (to[n] - from[n])) / z / l->texel_metres;
    }
    return 1;
}

static void hit_punctual_texel(texel_hits *t, const vxs_light *l, const double p[2], double corner[3][3], const double normal[3],
                               int solid)
{
    double half = ldexp(0.5, (int)l->levels), plane = vec3_dot(normal, corner[0]), w[3], part[3];
    double ray[3] = {(p[0] - half) * l->texel_metres, (p[1] - half) * l->texel_metres, 1};
    for (int n = 0; n < 3; n++) {
        vec3_cross(corner[n], corner[(n + 1) % 3], part);
        w[n] = vec3_dot(ray, part);
    }
    double share = l->near_metres * vec3_dot(normal, ray) / plane; /* near / distance: linear in the texels */
    int    in    = (w[0] > 0 && w[1] > 0 && w[2] > 0) || (w[0] < 0 && w[1] < 0 && w[2] < 0);
    if (!in || !(share > 0)) return;
    if (share > 0.9 / nearest_share) {
        t->unsure |= share < 1.1 / nearest_share;
        return;
    }
    double steep = l->near_metres * l->texel_metres * (fabs(normal[0]) + fabs(normal[1])) / fabs(plane);
    assert_true(t->count < HITS_MAX);
    /* corners are snapped to 1/256 texel, and numbers are floats: of the depth's own size, and of what the slope makes
     * of a block */
    t->hits[t->count++] = (hit){.depth     = fmax(-share, -1),
                                .tolerance = 1e-6 * fmin(share, 1) + steep * (1.01 / 512 + 512 * 3e-7),
                                .front     = plane < 0,
                                .solid     = solid};
}

/* Behind a spot light, where a cube's map may look but no cone does: casters that lie there wholly are left out. */
static int behind_spot(const vxs_light *l, int map, const double p[2])
{
    double at[3], way[3];
    vxs_point(l, map, (const double[]){p[0], p[1], 0}, at);
    for (int n = 0; n < 3; n++) way[n] = l->ls_from_ws[8 + n] * at[n];
    return l->kind == VXS_LIGHT_KIND_SPOT && way[0] + way[1] + way[2] + l->ls_from_ws[11] < 0;
}

/* Texels [u0, u0 + side) x [v0, v0 + side) of a map. */
static texel_hits *cast_punctual_rays(const casters *c, const vxs_light *l, int map, uint32_t u0, uint32_t v0, uint32_t side)
{
    texel_hits *all = calloc((size_t)side * side, sizeof *all);
    assert_non_null(all);
    for (size_t n = 0; n < c->triangle_count; n++) {
        double corner[3][3], ab[3], ac[3], normal[3], flat[3][2][2], low[2] = {1e30, 1e30}, high[2] = {-1e30, -1e30};
        int    seen[3], cut = 0;
        for (int k = 0; k < 3; k++) to_map(l, map, c->positions_ws + 3 * (size_t)c->indices[3 * n + (size_t)k], corner[k]);
        for (int k = 0; k < 3; k++) cut |= corner[k][2] < 2 * l->near_metres * nearest_share;
        vec3_sub(corner[1], corner[0], ab);
        vec3_sub(corner[2], corner[0], ac);
        vec3_cross(ab, ac, normal);
        for (int k = 0; k < 3; k++)
            if ((seen[k] = see_edge(l, corner[k], corner[(k + 1) % 3], flat[k])))
                for (int axis = 0; axis < 2; axis++) {
                    double from = axis ? v0 : u0;
                    low[axis]   = cut ? 0 : fmin(low[axis], fmin(flat[k][0][axis], flat[k][1][axis]) - from);
                    high[axis]  = cut ? side : fmax(high[axis], fmax(flat[k][0][axis], flat[k][1][axis]) - from);
                }
        if (!seen[0] && !seen[1] && !seen[2]) continue;
        for (int64_t v = (int64_t)fmax(floor(low[1] - 1), 0); v < side && (double)v < high[1] + 1; v++)
            for (int64_t u = (int64_t)fmax(floor(low[0] - 1), 0); u < side && (double)u < high[0] + 1; u++) {
                double      p[2] = {(double)u + u0 + 0.5, (double)v + v0 + 0.5};
                texel_hits *t    = &all[v * side + u];
                for (int k = 0; k < 3; k++) t->unsure |= seen[k] && segment_distance(p, flat[k][0], flat[k][1]) < 1.0 / 128;
                t->unsure |= behind_spot(l, map, p);
                if (!t->unsure) hit_punctual_texel(t, l, p, corner, normal, n < c->solid_triangle_count);
            }
    }
    return all;
}

static void render_punctual(const casters *c, const vxs_light *light, int map, exit_mode mode, uint32_t threads, depth_maps *maps)
{
    depth_renderer *r;
    run_context     m    = {0};
    uint32_t        side = 1u << light->levels;
    assert_int_equal(depth_renderer_create(&r, gl, c, light, map, mode, threads, &m), VXS_OK);
    assert_int_equal(depth_maps_init(maps, side, side, light->voxel_metres, c->solid_triangle_count != 0, &m), VXS_OK);
    assert_int_equal(depth_renderer_tile(r, maps, 0, 0, &m), VXS_OK);
    depth_renderer_destroy(r);
}

/* All maps of a light, peeled and with nearest backs; returns texels with casters that were queried. */
static size_t check_punctual(const mesh *k, const light_shape *shape, uint32_t side)
{
    vxs_light      light;
    run_context    m     = {0};
    size_t         asked = 0, sure = 0;
    light_fit_desc fit   = {.name = "lamp", .shape = shape, .resolution = side};
    vxs_result     found = light_fit(&light, &k->c, &fit, &m);
    if (found == VXS_E_NO_CASTER) return 0;
    assert_int_equal(found, VXS_OK);
    for (int map = 0; map < (light.flags & VXS_LIGHT_CUBE ? 6 : 1); map++) {
        depth_maps  peel, back;
        texel_hits *all = cast_punctual_rays(&k->c, &light, map, 0, 0, side);
        render_punctual(&k->c, &light, map, EXIT_PEEL, 2, &peel);
        render_punctual(&k->c, &light, map, EXIT_BACK, 2, &back);
        compared c = compare_maps(all, &peel, EXIT_PEEL);
        compare_maps(all, &back, EXIT_BACK);
        for (size_t n = 0; n < (size_t)side * side; n++) {
            assert_true(back.enter[n] == peel.enter[n]);
            assert_true(back.exit[n] <= peel.exit[n]);
        }
        asked += c.asked;
        sure += c.sure;
        free(all);
        depth_maps_free(&peel);
        depth_maps_free(&back);
    }
    if (getenv("DEPTH_VERBOSE")) print_message("%u: %zu texels, %zu sure\n", side, asked, sure);
    return asked;
}

/* Somewhere in or about a scene of 256 metres. */
static light_shape random_shape(rng *r, int inside)
{
    light_shape s = {
        .kind = rng_below(r, 2) ? LIGHT_SPOT : LIGHT_POINT, .outer_rad = 0.1 + 1.4 * unit(r), .range_metres = INFINITY};
    double to[3];
    for (int n = 0; n < 3; n++)
        s.position_ws[n] = inside ? 60 + 140 * unit(r) : rng_below(r, 2) ? -40 * unit(r) : 256 + 40 * unit(r);
    for (int n = 0; n < 3; n++) to[n] = 70 + 110 * unit(r) - s.position_ws[n];
    assert_true(vec3_unit(to, s.direction_ws));
    return s;
}

static void punctuals_on_solids_and_sheets(void **state)
{
    (void)state;
    size_t asked = 0;
    for (uint64_t seed = 0; seed < 40; seed++) {
        rng  r = rng_split(seed, 20);
        mesh k;
        mesh_init(&k);
        if (seed % 4 != 3) {
            for (int n = 0; n < 12; n++) {
                double u = 60 + 120 * unit(&r), v = 60 + 120 * unit(&r), z = 60 + 120 * unit(&r);
                turn_randomly(&k, &r, u, v, z);
                add_box(&k, u, v, z, u + 3 + 30 * unit(&r), v + 3 + 30 * unit(&r), z + 3 + 30 * unit(&r));
            }
            for (int n = 1; n < 4; n++)
                add_box(&k, 128 - 10.3 * n, 128 - 9.7 * n, 128 - 8.1 * n, 128 + 9 * n, 128 + 10 * n, 128 + 11 * n); /* nested */
            for (int n = 0; n < 2; n++)
                add_sphere(&k, 60 + 120 * unit(&r), 60 + 120 * unit(&r), 60 + 120 * unit(&r), 5 + 30 * unit(&r));
            solids_end(&k);
        }
        for (int n = 0; n < 10 && seed % 4; n++) {
            turn_randomly(&k, &r, 128, 128, 128);
            double u = 40 + 140 * unit(&r), v = 40 + 140 * unit(&r);
            add_sheet(&k, u, v, u + 10 + 60 * unit(&r), v + 10 + 60 * unit(&r), 40 + 170 * unit(&r), 40 * unit(&r));
        }
        light_shape shape = random_shape(&r, seed % 3 != 0);
        asked += check_punctual(&k, &shape, 8u << seed % 5);
        casters_free(&k.c);
    }
    assert_true(asked > 50000);
}

/* A light close above a floor, between two walls, and in the open end of a corner. */
static void punctuals_near_surfaces(void **state)
{
    (void)state;
    for (int n = 0; n < 12; n++) {
        mesh        k;
        light_shape shape = {.kind         = n % 2 ? LIGHT_SPOT : LIGHT_POINT,
                             .position_ws  = {100, 100, 64 - pow(10, -n / 2.0)},
                             .direction_ws = {0.6, 0, 0.8},
                             .outer_rad    = 1.0,
                             .range_metres = INFINITY};
        mesh_init(&k);
        add_box(&k, 0, 0, 64, 256, 256, 80);
        add_box(&k, 100.01, 60, 20, 110, 140, 64);
        add_box(&k, 30, 40, 40, 60, 160, 60);
        solids_end(&k);
        add_sheet(&k, 20, 20, 200, 40, 50, 5);
        assert_true(check_punctual(&k, &shape, 128) > 1000);
        casters_free(&k.c);
    }
}

/* Things from a millimetre to a kilometre: near and far a million apart, and depths right in shares of themselves. */
static void punctuals_see_near_and_far(void **state)
{
    (void)state;
    for (int kind = 0; kind < 2; kind++) {
        mesh        k;
        vxs_light   light;
        run_context m     = {0};
        light_shape shape = {
            .kind = kind ? LIGHT_SPOT : LIGHT_POINT, .direction_ws = {0, 0, 1}, .outer_rad = 1.0, .range_metres = INFINITY};
        mesh_init(&k);
        for (int n = 0; n < 7; n++) {
            double d = 0.001 * pow(10, n), at = (n - 3) * 0.25 * d;
            add_box(&k, at, -0.1 * d, d, at + 0.2 * d, 0.1 * d, 1.3 * d);
        }
        solids_end(&k);
        add_sheet(&k, -3e3, -3e3, 3e3, 3e3, 1500, 0);
        light_fit_desc fit = {.name = "lamp", .shape = &shape, .resolution = 256};
        assert_int_equal(light_fit(&light, &k.c, &fit, &m), VXS_OK);
        double near = light.near_metres * exp(light.voxel_metres), far = light.near_metres * exp(254 * light.voxel_metres);
        assert_true(far / near > 1e6);
        assert_true(check_punctual(&k, &shape, 256) > 20000);
        casters_free(&k.c);
    }
}

static void punctuals_and_threads(void **state)
{
    (void)state;
    for (uint64_t seed = 0; seed < 1; seed++) {
        rng            r     = rng_split(seed, 21);
        mesh           k     = city(seed, 256);
        light_shape    shape = random_shape(&r, 1);
        light_fit_desc fit   = {.name = "lamp", .shape = &shape, .resolution = 1024};
        vxs_light      light;
        run_context    m = {0};
        assert_int_equal(light_fit(&light, &k.c, &fit, &m), VXS_OK);
        for (int map = 0; map < (light.flags & VXS_LIGHT_CUBE ? 6 : 1); map++) {
            depth_maps one, many;
            render_punctual(&k.c, &light, map, EXIT_PEEL, 1, &one);
            render_punctual(&k.c, &light, map, EXIT_PEEL, 8, &many);
            assert_memory_equal(one.enter, many.enter, (size_t)1024 * 1024 * sizeof *one.enter);
            assert_memory_equal(one.exit, many.exit, (size_t)1024 * 1024 * sizeof *one.exit);
            depth_maps_free(&one);
            depth_maps_free(&many);
        }
        casters_free(&k.c);
    }
}

/* Tiles of a punctual light's map are the map; squares far from the corner of a large one are right where they are. */
static void tiles_of_punctuals(void **state)
{
    (void)state;
    enum { SIDE = 1024, TILE = 512, LARGE = 16384, PART = 64 };
    mesh           k     = city(5, 256);
    light_shape    shape = {.kind = LIGHT_POINT, .position_ws = {128, 128, 120}, .range_metres = INFINITY};
    light_fit_desc fit   = {.name = "lamp", .shape = &shape, .resolution = SIDE};
    vxs_light      light;
    run_context    m     = {0};
    size_t         asked = 0;
    assert_int_equal(light_fit(&light, &k.c, &fit, &m), VXS_OK);
    for (int map = 0; map < 6; map += 3) {
        depth_maps      whole, tile;
        depth_renderer *r;
        render_punctual(&k.c, &light, map, EXIT_PEEL, 2, &whole);
        assert_int_equal(depth_renderer_create(&r, gl, &k.c, &light, map, EXIT_PEEL, 2, &m), VXS_OK);
        assert_int_equal(depth_maps_init(&tile, TILE, SIDE, light.voxel_metres, 1, &m), VXS_OK);
        for (uint32_t j = 0; j < SIDE / TILE; j++)
            for (uint32_t i = 0; i < SIDE / TILE; i++) {
                int any = 0;
                assert_int_equal(depth_renderer_tile(r, &tile, i, j, &m), VXS_OK);
                for (uint32_t row = 0; row < TILE; row++) {
                    size_t at = (size_t)(j * TILE + row) * SIDE + i * TILE;
                    assert_memory_equal(tile.enter + (size_t)row * TILE, whole.enter + at, TILE * sizeof *tile.enter);
                    assert_memory_equal(tile.exit + (size_t)row * TILE, whole.exit + at, TILE * sizeof *tile.exit);
                    for (uint32_t n = 0; n < TILE; n++) any |= whole.enter[at + n] < 0;
                }
                if (any) assert_true(depth_renderer_has_casters(r, TILE, i, j));
            }
        depth_renderer_destroy(r);
        depth_maps_free(&tile);
        depth_maps_free(&whole);
    }
    fit.resolution = LARGE;
    assert_int_equal(light_fit(&light, &k.c, &fit, &m), VXS_OK);
    for (int map = 0; map < 6; map++) {
        depth_maps      tile, part;
        depth_renderer *r;
        assert_int_equal(depth_renderer_create(&r, gl, &k.c, &light, map, EXIT_PEEL, 2, &m), VXS_OK);
        assert_int_equal(depth_maps_init(&tile, TILE, LARGE, light.voxel_metres, 1, &m), VXS_OK);
        assert_int_equal(depth_maps_init(&part, PART, LARGE, light.voxel_metres, 1, &m), VXS_OK);
        for (uint32_t n = 0; n < 4; n++) {
            uint32_t i = n % 2 ? 21 : 30, j = n / 2 ? 18 : 11, u = TILE - PART - 40 * n, v = 70 * n;
            assert_int_equal(depth_renderer_tile(r, &tile, i, j, &m), VXS_OK);
            for (size_t row = 0; row < PART; row++) {
                memcpy(part.enter + row * PART, tile.enter + (v + row) * TILE + u, PART * sizeof *part.enter);
                memcpy(part.exit + row * PART, tile.exit + (v + row) * TILE + u, PART * sizeof *part.exit);
            }
            texel_hits *all = cast_punctual_rays(&k.c, &light, map, i * TILE + u, j * TILE + v, PART);
            asked += compare_maps(all, &part, EXIT_PEEL).asked;
            free(all);
        }
        depth_renderer_destroy(r);
        depth_maps_free(&tile);
        depth_maps_free(&part);
    }
    assert_true(asked > 10000);
    casters_free(&k.c);
}

/* All columns of a fetched square, side_px^2 tiles of (e, x). */
static column_tile *columns_of(const column_square *square)
{
    uint32_t     across = square->side_px / 8;
    column_tile *tiles  = malloc((size_t)across * across * sizeof *tiles);
    assert_non_null(tiles);
    for (uint32_t n = 0; n < across * across; n++)
        assert_int_equal(square->tile(square->data, n % across, n / across, &tiles[n]), VXS_OK);
    return tiles;
}

static column_tile *fetch_columns(column_map *open, bake_context *ctx)
{
    column_square square;
    assert_int_equal(open->fetch(open->data, square_level(open->fetch_px), 0, 0, &square, ctx), VXS_OK);
    column_tile *tiles = columns_of(&square);
    open->release(open->data, &square);
    return tiles;
}

/* Maps of a sun and of all faces of a punctual light, open at once and fetched in turn, are what each is alone: renderers share a
 * context, but depths grow in one and shrink in the others. */
static void several_maps_are_open(void **state)
{
    (void)state;
    enum { SIDE = 512, MAPS = 7 };
    mesh             k         = city(3, 256);
    light_shape      shapes[2] = {{.kind = LIGHT_DIRECTIONAL, .direction_ws = {0.3, 0.4, -0.866}, .range_metres = INFINITY},
                                  {.kind = LIGHT_POINT, .position_ws = {128, 128, 120}, .range_metres = INFINITY}};
    run_context      m         = {0};
    bake_context     ctx       = {.run = &m, .threads = 2};
    vxs_light        lights[2];
    rendered_columns rendered[2];
    column_source    sources[2];
    for (int n = 0; n < 2; n++) {
        light_fit_desc fit = {.name = "light", .shape = &shapes[n], .resolution = SIDE};
        assert_int_equal(light_fit(&lights[n], &k.c, &fit, &m), VXS_OK);
        rendered[n] = (rendered_columns){
            .device = gl, .casters = &k.c, .light = &lights[n], .exit = EXIT_PEEL, .has_exit_map = 1, .tile_px = SIDE};
        sources[n] = opengl_columns_source(&rendered[n]);
    }
    assert_int_equal(sources[0].map_count + sources[1].map_count, MAPS);

    column_map   maps[MAPS];
    column_tile *alone[MAPS];
    for (int n = 0; n < MAPS; n++) {
        column_source *source = &sources[n > 0];
        assert_int_equal(source->open(source->data, n ? (uint32_t)n - 1 : 0, &maps[n], &ctx), VXS_OK);
        alone[n] = fetch_columns(&maps[n], &ctx);
        maps[n].close(maps[n].data);
    }
    for (int n = 0; n < MAPS; n++) {
        column_source *source = &sources[n > 0];
        assert_int_equal(source->open(source->data, n ? (uint32_t)n - 1 : 0, &maps[n], &ctx), VXS_OK);
    }
    size_t seen = 0, tiles = (size_t)(SIDE / 8) * (SIDE / 8);
    for (int turn = 0; turn < 2 * MAPS; turn++) {
        int          n     = turn * 3 % MAPS;
        column_tile *among = fetch_columns(&maps[n], &ctx);
        assert_memory_equal(among, alone[n], tiles * sizeof *among);
        for (size_t t = 0; t < tiles; t++) seen += among[t].e[0] < SIDE;
        free(among);
    }
    assert_true(seen > 5000);
    for (int n = 0; n < MAPS; n++) {
        maps[n].close(maps[n].data);
        free(alone[n]);
    }
    for (int n = 0; n < 2; n++) opengl_columns_free(&rendered[n]);
    casters_free(&k.c);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(boxes_that_intersect),
        cmocka_unit_test(boxes_inside_boxes),
        cmocka_unit_test(spheres),
        cmocka_unit_test(boxes_that_share_faces),
        cmocka_unit_test(stacks_along_the_light_are_exact),
        cmocka_unit_test(inverted_lobes),
        cmocka_unit_test(sheets_among_solids),
        cmocka_unit_test(a_sheet_first_has_no_inside),
        cmocka_unit_test(only_blocks_with_solids_that_meet_are_peeled),
        cmocka_unit_test(sheets_alone_share_one_map),
        cmocka_unit_test(walls_along_the_light),
        cmocka_unit_test(needles),
        cmocka_unit_test(casters_beyond_the_map),
        cmocka_unit_test(tiles_make_up_the_map),
        cmocka_unit_test(empty_squares_have_no_casters),
        cmocka_unit_test(threads_change_nothing),
        cmocka_unit_test(fitted_lights),
        cmocka_unit_test(punctuals_on_solids_and_sheets),
        cmocka_unit_test(punctuals_near_surfaces),
        cmocka_unit_test(punctuals_see_near_and_far),
        cmocka_unit_test(punctuals_and_threads),
        cmocka_unit_test(tiles_of_punctuals),
        cmocka_unit_test(several_maps_are_open),
    };
    return cmocka_run_group_tests_name("depth_gl", tests, open_gl, close_gl);
}
