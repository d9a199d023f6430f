/* Sparse columns against brute force (tests/columns/brute.h): every texel of maps of random meshes, as small as they are nasty.
 *
 * The meshes lie in the space of the light, u and v in texels and z in voxels, or about a punctual light. Squares that are decided
 * as wholes must keep to what is there; texels of the other tiles must be what they are, but for exits behind the tile's last enter
 * depth, which may be early.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/base/cpu.h"
#include "baker/columns/sparse/sparse_columns.h" /* before cmocka, whose fail() is a macro */
#include "baker/columns/sparse/sparse_square.h"
#include "baker/columns/sparse/sparse_triangles.h"
#include "baker/light/light_fit.h"
#include "baker/light/projection.h"
#include "runtime/vxs.h"
#include "tests/columns/brute.h"
#include "tests/unit/mesh_sample.h"
#include "tests/unit/random_light.h"
#include "tests/unit/repeats.h"

enum { MAPS_MAX = 6 };

/* meshes: [0, side) in u, v and z ---------------------------------------------------------------------------------------------- */

static void random_point(rng *r, double low, double high, double out[3])
{
    for (int n = 0; n < 3; n++) out[n] = uniform(r, low, high);
}

/* Turn what was added since `first` by random angles about a point. */
static void turn_since(sample *b, rng *r, size_t first, const double about[3])
{
    double turn[3][3];
    random_direction(r, turn[0]);
    random_direction(r, turn[2]);
    cross(turn[2], turn[0], turn[1]);
    make_unit(turn[1]);
    cross(turn[0], turn[1], turn[2]);
    for (size_t n = 3 * first; n < 3 * b->s.triangle_count; n++) {
        double *p = b->s.positions_ws + 3 * (size_t)b->s.indices[n], from[3] = {p[0] - about[0], p[1] - about[1], p[2] - about[2]};
        for (int k = 0; k < 3; k++) p[k] = about[k] + dot(turn[k], from);
    }
}

static void add_boxes(sample *b, rng *r, double side, int count)
{
    for (int n = 0; n < count; n++) {
        double low[3], high[3];
        size_t first = b->s.triangle_count;
        random_point(r, 0, 0.8 * side, low);
        for (int k = 0; k < 3; k++) high[k] = low[k] + uniform(r, 0.02, 0.4) * side;
        sample_box(b, low, high);
        if (n % 3) turn_since(b, r, first, low);
    }
}

static void add_nested(sample *b, rng *r, double side, int count)
{
    double at[3];
    random_point(r, 0.3 * side, 0.6 * side, at);
    for (int n = 1; n <= count; n++) {
        size_t first = b->s.triangle_count;
        sample_cube(b, at[0], at[1], at[2], 0.3 * side * n / count);
        turn_since(b, r, first, at);
    }
}

static void add_balls(sample *b, rng *r, double side, int count)
{
    for (int n = 0; n < count; n++) {
        double at[3];
        random_point(r, 0, side, at);
        sample_ball(b, at, uniform(r, 0.01, 0.3) * side, 4 + (int)rng_below(r, 20));
    }
}

/* Tetrahedra whose corners are nearly on a line. */
static void add_needles(sample *b, rng *r, double side, int count)
{
    static const uint8_t faces[4][3] = {{0, 1, 2}, {0, 3, 1}, {0, 2, 3}, {1, 3, 2}};
    for (int n = 0; n < count; n++) {
        double from[3], to[3], p[4][3];
        random_point(r, 0, side, from);
        random_point(r, 0, side, to);
        for (int k = 0; k < 4; k++)
            for (int axis = 0; axis < 3; axis++)
                p[k][axis] = from[axis] + (k & 1) * (to[axis] - from[axis]) + uniform(r, -1, 1) * (n % 2 ? 0.01 : 1.5);
        for (int f = 0; f < 4; f++) sample_points(b, p[faces[f][0]], p[faces[f][1]], p[faces[f][2]]);
    }
}

/* Triangles that hang together nowhere. */
static void add_soup(sample *b, rng *r, double side, int count)
{
    for (int n = 0; n < count; n++) {
        double at[3], p[3][3], size = n % 4 ? 0.1 * side : 0.7 * side;
        random_point(r, 0, side, at);
        for (int k = 0; k < 3; k++)
            for (int axis = 0; axis < 3; axis++) p[k][axis] = at[axis] + uniform(r, -size, size);
        sample_points(b, p[0], p[1], p[2]);
    }
}

/* Boxes of whole half texels side by side and on top of each other: faces share planes, and edges pass centres of texels. */
static void add_bricks(sample *b, rng *r, double side)
{
    double cell = floor(side / 8);
    for (int n = 0; n < 60; n++) {
        double low[3], high[3];
        for (int k = 0; k < 3; k++) {
            low[k]  = cell * rng_below(r, 6) + 0.5 * rng_below(r, 3) - 0.5;
            high[k] = low[k] + cell * (1 + rng_below(r, 2));
        }
        sample_box(b, low, high);
    }
}

/* Wedges about one edge: several faces begin at it on the same side. */
static void add_wedges(sample *b, rng *r, double side, int count)
{
    double from[3], to[3];
    random_point(r, 0, side, from);
    random_point(r, 0, side, to);
    for (int n = 0; n < count; n++) {
        double p[2][3];
        for (int k = 0; k < 2; k++) random_point(r, 0, side, p[k]);
        sample_points(b, from, to, p[0]);
        sample_points(b, from, p[1], to);
        sample_points(b, from, p[0], p[1]);
        sample_points(b, to, p[1], p[0]);
    }
}

/* Hills of small triangles, `depth` of them below each other; closed below where it is a solid. */
static void add_hills(sample *b, rng *r, double side, int parts, int closed)
{
    double *z = calloc((size_t)(parts + 1) * (parts + 1), sizeof *z), wave = uniform(r, 2, 9), up = uniform(r, 0.05, 0.3) * side;
    double  base = uniform(r, 0.3, 0.6) * side;
    assert_non_null(z);
    for (int j = 0; j <= parts; j++)
        for (int i = 0; i <= parts; i++)
            z[j * (parts + 1) + i] = base + up * sin(wave * i / parts) * cos(wave * j / parts) + uniform(r, 0, 0.4) * side / parts;
    for (int below = 0; below <= closed; below++)
        for (int j = 0; j < parts; j++)
            for (int i = 0; i < parts; i++) {
                double p[4][3];
                for (int k = 0; k < 4; k++) {
                    int u = i + (k == 1 || k == 2), v = j + (k >= 2), rim = !u || !v || u == parts || v == parts;
                    p[k][0] = (0.05 + 0.9 * u / parts) * side;
                    p[k][1] = (0.05 + 0.9 * v / parts) * side;
                    p[k][2] = z[v * (parts + 1) + u] + (below && !rim ? 0.2 * side : 0);
                }
                sample_points(b, p[0], p[below ? 1 : 2], p[below ? 2 : 1]);
                sample_points(b, p[0], p[below ? 2 : 3], p[below ? 3 : 2]);
            }
    free(z);
}

static void add_bands(sample *b, double side)
{
    size_t first = b->s.vertex_count;
    sample_band(b, 20, 1);
    for (size_t n = 3 * first; n < 3 * b->s.vertex_count; n++) b->s.positions_ws[n] = (0.5 + 0.3 * b->s.positions_ws[n]) * side;
    first = b->s.vertex_count;
    sample_klein_bottle(b, 12);
    for (size_t n = 3 * first; n < 3 * b->s.vertex_count; n++) b->s.positions_ws[n] = (0.5 + 0.1 * b->s.positions_ws[n]) * side;
}

/* What a mesh is made of, by its number. */
static void add_mesh(sample *b, rng *r, double side, uint32_t kind)
{
    static const char *const all = "bnlNsBhHkswlBhWN";
    for (uint32_t n = 0; n < 1 + kind % 3; n++) switch (all[(kind + n * 5) % 16]) {
        case 'b': add_boxes(b, r, side, 14); break;
        case 'n': add_nested(b, r, side, 5); break;
        case 'l': add_balls(b, r, side, 6); break;
        case 'N': add_needles(b, r, side, 30); break;
        case 's': add_soup(b, r, side, 40); break;
        case 'B': add_bricks(b, r, side); break;
        case 'w': add_wedges(b, r, side, 2); break;
        case 'W': add_wedges(b, r, side, 12); break;
        case 'h': add_hills(b, r, side, 20, 0); break;
        case 'H': add_hills(b, r, side, 24, 1); break;
        default: add_bands(b, side); break;
        }
}

/* --- comparing ---------------------------------------------------------------------------------------------------------------- */

typedef struct counts {
    size_t texels;             /* with casters */
    size_t settled, looked_at; /* tiles */
    size_t early;              /* exits of the latter that are before their depths, behind the tile's last enter depth */
} counts;

static int is_uniform(const column_tile *t)
{
    for (int n = 1; n < 64; n++)
        if (t->e[n] != t->e[0] || t->x[n] != t->x[0]) return 0;
    return 1;
}

/* A tile against brute force; the tile's bounds hold. */
static void compare_tile(const brute *b, const column_tile *t, const column_bounds *bounds, uint32_t u0, uint32_t v0, counts *sum)
{
    int      uniform = is_uniform(t);
    uint32_t emax    = 0;
    for (int n = 0; n < 64; n++) emax = max_u32(emax, t->e[n]);
    for (uint32_t n = 0; n < 64; n++) {
        brute_column c   = brute_at(b, u0 + n % 8, v0 + n / 8);
        double       far = b->scale.depth_vx;
        sum->texels += c.e_most < far;
        if (!(t->e[n] >= floor(c.e_least) && t->e[n] <= t->x[n] && t->x[n] <= fmin(far, ceil(c.x_most))) ||
            !(bounds->emin <= t->e[n] && t->e[n] <= bounds->emax && bounds->xmin <= t->x[n] && t->x[n] <= bounds->xmax))
            fail_msg("texel %u, %u: %u and %u, by brute force %.9g and %.9g to %.9g", u0 + n % 8, v0 + n / 8, t->e[n], t->x[n],
                     c.e_least, c.x_least, c.x_most);
        if (uniform) continue;
        if (!(t->e[n] <= fmin(far, floor(c.e_most))) || min_u32(t->x[n], emax) < fmin(emax, ceil(c.x_least)))
            fail_msg("texel %u, %u: %u and %u, but by brute force %.9g and %.9g", u0 + n % 8, v0 + n / 8, t->e[n], t->x[n],
                     c.e_most, c.x_least);
        sum->early += t->x[n] < fmin(far, ceil(c.x_least));
    }
    sum->settled += uniform;
    sum->looked_at += !uniform;
}

static void compare_square(const brute *b, const column_square *q, counts *sum)
{
    for (uint32_t j = 0; j < q->side_px / 8; j++)
        for (uint32_t i = 0; i < q->side_px / 8; i++) {
            column_tile   tile;
            column_bounds bounds;
            assert_int_equal(q->tile(q->data, i, j, &tile), VXS_OK);
            for (uint32_t level = 0; 8u << level <= q->side_px; level++) {
                assert_int_equal(q->bounds(q->data, level, i >> level, j >> level, &bounds), VXS_OK);
                if (level)
                    for (int n = 0; n < 64; n++)
                        assert_true(bounds.emin <= tile.e[n] && tile.e[n] <= bounds.emax && bounds.xmin <= tile.x[n] &&
                                    tile.x[n] <= bounds.xmax);
                else
                    compare_tile(b, &tile, &bounds, q->u_px + 8 * i, q->v_px + 8 * j, sum);
            }
        }
}

/* What light leaves by, as sparse_columns has it. */
typedef struct ways {
    int    nearest_back, free_behind;
    double thickness_metres;
} ways;

/* Some of them, by number: a third of them with nothing more free. */
static ways some_ways(uint32_t n)
{
    static const double metres[] = {0.3, 3, 40};
    return (ways){n % 5 == 4, n % 6 == 1 || n % 6 == 3, n % 6 >= 2 && n % 6 <= 4 ? metres[n / 6 % 3] : 0};
}

/* One square of a map, of the triangles alone that may touch it: of a projection, which is used up. */
static void compare_window(const sparse_columns *own, projection *p, const brute *b, uint32_t i, uint32_t j, bake_context *ctx)
{
    uint32_t      side = min_u32(32, b->side_px), cells = b->side_px / side;
    uint8_t      *kept = malloc(p->triangle_count + 1);
    column_map    columns;
    column_square square;
    counts        sum = {0};
    i %= cells;
    j %= cells;
    assert_non_null(kept);
    for (size_t t = 0; t < p->triangle_count; t++) {
        texel_box box = texel_box_of(p, t);
        kept[t]       = (uint8_t)texel_box_touches(&box, (int32_t)(i * side), (int32_t)(j * side), (int32_t)side);
    }
    assert_int_equal(projection_keep(p, kept), VXS_OK);
    assert_int_equal(sparse_columns_open(own, p, &columns, ctx), VXS_OK);
    assert_int_equal(columns.fetch(columns.data, square_level(side), i, j, &square, NULL), VXS_OK);
    compare_square(b, &square, &sum);
    columns.release(columns.data, &square);
    columns.close(columns.data);
    free(kept);
}

/* All maps of a light, fetched in squares of `fetch_px`, and a window of each. */
static counts compare_light(const casters *c, const vxs_light *light, const ways *w, uint32_t fetch_px, uint32_t threads)
{
    run_context    m      = {0};
    bake_context   ctx    = {.run = &m, .threads = threads};
    sparse_columns own    = {.casters          = c,
                             .light            = light,
                             .nearest_back     = w->nearest_back,
                             .free_behind      = w->free_behind,
                             .thickness_metres = w->thickness_metres,
                             .fetch_px         = fetch_px};
    column_source  source = sparse_columns_source(&own);
    int            sun    = light->kind == VXS_LIGHT_KIND_DIRECTIONAL;
    counts         sum    = {0};
    for (uint32_t map = 0; map < source.map_count; map++) {
        column_map    columns;
        column_square square;
        column_bounds known;
        projection    p, some;
        brute         b;
        assert_int_equal(source.open(source.data, map, &columns, &ctx), VXS_OK);
        assert_int_equal(projection_init(&p, c, light, (int)map, 1, &m), VXS_OK);
        assert_true(
            brute_init(&b, &p, columns.side_px, 1 << sparse_grid(columns.side_px), sun ? 0 : light->voxel_metres, w->nearest_back));
        b.free_behind   = w->free_behind;
        b.thickness     = w->thickness_metres / (sun ? light->voxel_metres : light->near_metres);
        uint32_t across = columns.side_px / columns.fetch_px, level = square_level(columns.fetch_px);
        for (uint32_t n = 0; n < across * across; n++) {
            size_t before = sum.texels;
            assert_int_equal(columns.bounds(columns.data, level, n % across, n / across, &known), VXS_OK);
            assert_int_equal(columns.fetch(columns.data, level, n % across, n / across, &square, &ctx), VXS_OK);
            assert_true(square.side_px == columns.fetch_px && square.depth_vx == columns.depth_vx);
            compare_square(&b, &square, &sum);
            columns.release(columns.data, &square);
            assert_true(known.emin < known.emax || sum.texels == before); /* where nothing was said to be, nothing is */
        }
        columns.close(columns.data);
        assert_int_equal(projection_init(&some, c, light, (int)map, 1, &m), VXS_OK);
        compare_window(&own, &some, &b, map + fetch_px / 32, map + (uint32_t)c->triangle_count, &ctx);
        projection_free(&some);
        brute_free(&b);
        projection_free(&p);
    }
    return sum;
}

static vxs_light identity_light(uint32_t side)
{
    vxs_light l     = {.kind = VXS_LIGHT_KIND_DIRECTIONAL, .levels = log2_u32(side), .texel_metres = 1, .voxel_metres = 1};
    l.ls_from_ws[0] = l.ls_from_ws[5] = l.ls_from_ws[10] = 1;
    l.direction_ws[2]                                    = 1;
    return l;
}

/* tests ------------------------------------------------------------------------------------------------------------------------ */

/* parts ------------------------------------------------------------------------------------------------------------------------ */

/* The patches of a few triangles, all edges that are ends counted. */
static size_t patches_of(sample *b, uint32_t patch_of[8], int8_t facing)
{
    projection p;
    vxs_light  light = identity_light(64);
    int8_t     facings[8];
    uint8_t    ends[8];
    size_t     count = 0;
    sample_sort(b, CLOSED_OFF);
    assert_int_equal(projection_init(&p, &b->c, &light, 0, 1, &b->m), VXS_OK);
    assert_true(p.triangle_count <= 8);
    memset(facings, facing, sizeof facings);
    assert_int_equal(patches_find(patch_of, ends, facings, &p, 2), VXS_OK);
    for (size_t t = 0; t < p.triangle_count; t++) count += (size_t)__builtin_popcount(ends[t]);
    projection_free(&p);
    sample_clear(b);
    return count;
}

static void patches_end_where_surfaces_do(void **state)
{
    const double corner[4][3] = {{0, 0, 5}, {9, 0, 5}, {9, 9, 5}, {0, 9, 7}};
    const double spine[2][3] = {{0, 0, 5}, {0, 9, 5}}, page[4][3] = {{9, 4, 1}, {9, 4, 2}, {9, 4, 3}, {9, 4, 4}};
    uint32_t     patch_of[8];
    sample       b = {0};
    (void)state;
    for (int turned = 0; turned < 2; turned++) {
        sample_points(&b, corner[0], corner[1], corner[2]);
        sample_points(&b, corner[0], corner[turned ? 3 : 2], corner[turned ? 2 : 3]);
        assert_int_equal(patches_of(&b, patch_of, 1), turned ? 6 : 4); /* one that is turned over faces the other way */
        assert_int_equal(patch_of[1], turned);
    }
    /* four pages of a book on the same side, two of them up: each ends at the spine, though windings cancel there */
    for (int n = 0; n < 4; n++) sample_points(&b, spine[n / 2], spine[1 - n / 2], page[n]);
    assert_int_equal(patches_of(&b, patch_of, 1), 12);
    sample_points(&b, corner[0], corner[1], corner[2]);
    sample_points(&b, corner[0], corner[2], corner[3]);
    assert_int_equal(patches_of(&b, patch_of, 0), 6); /* seen from their edges */
}

/* x, y  subtexels */
static double plane_depth(const sparse_triangle *t, double x, double y)
{
    double z = t->zmin + t->gy * (y - t->y[0]) + t->gx * (x - t->x[0]);
    z        = z > t->zmin ? z : t->zmin;
    return z < t->zmax ? z : t->zmax;
}

/* A map of single triangles. */
typedef struct soup {
    vertex_ls v[3 * 32];
    uint32_t  indices[3 * 32];
    size_t    no_masks[1];
    casters   none;
} soup;

static projection projection_of(soup *o, size_t count)
{
    for (uint32_t n = 0; n < 3 * count; n++) o->indices[n] = n;
    o->no_masks[0] = count;
    o->none        = (casters){0};
    return (projection){.casters          = &o->none,
                        .vertex_count     = 3 * count,
                        .vertices         = o->v,
                        .triangle_count   = count,
                        .holed_first      = count,
                        .indices          = o->indices,
                        .alpha_mask_first = o->no_masks};
}

/* Depths in a square of random triangles, steep and narrow ones among them, as they are computed and as they are, lie between what
 * a list says. */
static void depths_stay_within_their_lists(void **state)
{
    enum { SIDE = 16384 };
    const uint32_t rounds = repeats(300, 2000);
    rng            r      = rng_split(1, 3);
    size_t         asked  = 0;
    uint32_t       id     = 0;
    (void)state;
    for (uint32_t n = 0; n < rounds; n++) {
        soup             o;
        sparse_triangles s;
        square_list      l = {0};
        double width = n % 3 ? SIDE : ldexp(1, (int)rng_below(&r, 14) - 4), u = uniform(&r, 0, SIDE), w = uniform(&r, 0, SIDE);
        for (int k = 0; k < 3; k++)
            o.v[k] = (vertex_ls){u + (k == 2 ? SIDE : 1) * uniform(&r, -0.1, 0.1) * width / SIDE * (n % 2 ? 1 : 4),
                                 w + uniform(&r, -1, 1) * width, rng_unit(&r)};
        projection p = projection_of(&o, 1);
        assert_int_equal(sparse_triangles_init(&s, &p, SIDE, 1), VXS_OK);
        const double px = ldexp(1, (int)s.grid);
        for (int k = 0; k < 20 && s.count; k++) {
            const sparse_triangle *t = &s.all[0];
            double                 a = rng_unit(&r), b = rng_unit(&r) * (1 - a);
            double                 x = (t->x[0] + a * ((double)t->x[1] - t->x[0]) + b * ((double)t->x[2] - t->x[0])) / px;
            double                 y = (t->y[0] + a * ((double)t->y[1] - t->y[0]) + b * ((double)t->y[2] - t->y[0])) / px;
            if (!(x >= 0 && x < SIDE && y >= 0 && y < SIDE)) continue;
            uint32_t     side = 8u << rng_below(&r, 4);
            texel_square q    = {(uint32_t)x / side * side, (uint32_t)y / side * side, side};
            brute        check;
            brute_hit    hit;
            assert_true(brute_init(&check, &p, SIDE, (int64_t)px, 0, 0));
            assert_true(sparse_levels[n % (cpu_level_of_machine() + 1)].gather(&l, &s, &id, 1, q));
            for (uint32_t m = 0; m < side * side; m++) {
                uint32_t pu = q.u + m % side, pv = q.v + m / side;
                if (!brute_meet(&check, 0, pu, pv, &hit)) continue;
                double z = plane_depth(t, (pu + 0.5) * px, (pv + 0.5) * px);
                assert_int_equal(l.count, 1);
                assert_true(l.lo[0] <= z && z <= l.hi[0]);
                assert_true(l.lo[0] <= hit.depth / SIDE && hit.depth / SIDE <= l.hi[0]);
                asked++;
            }
            brute_free(&check);
        }
        free(l.lo);
        sparse_triangles_free(&s);
    }
    assert_true(asked > 5 * rounds);
}

/* Edges over a whole map, which are too long for 32 bits: the texels of a tile that one of them crosses. */
static void long_edges_end_where_short_ones_do(void **state)
{
    enum { SIDE = 16384 };
    const uint32_t rounds  = repeats(300, 3000);
    rng            r       = rng_split(1, 5);
    leaf_scratch   scratch = {0};
    square_list    l       = {0};
    size_t         partly  = 0;
    (void)state;
    for (uint32_t n = 0; n < rounds; n++) {
        soup             o;
        brute            check;
        brute_hit        hit;
        sparse_triangles s;
        column_tile      tile;
        column_bounds    bounds;
        uint32_t         id      = 0;
        square_bound     nothing = {.enter_most = 1, .left_out = INFINITY, .exit_least = INFINITY};
        leaf_desc        d       = {.triangles = &s, .scale = {SIDE, 0}, .every_texel = 1};
        for (int k = 0; k < 3; k++) o.v[k] = (vertex_ls){uniform(&r, -SIDE, 2 * SIDE), uniform(&r, -SIDE, 2 * SIDE), 0.5};
        projection   p     = projection_of(&o, 1);
        const double along = rng_unit(&r), u = o.v[0].u + along * (o.v[1].u - o.v[0].u),
                     v = o.v[0].v + along * (o.v[1].v - o.v[0].v);
        if (!(u >= 0 && u < SIDE && v >= 0 && v < SIDE)) continue;
        texel_square at = {(uint32_t)u & ~7u, (uint32_t)v & ~7u, 8};
        assert_int_equal(sparse_triangles_init(&s, &p, SIDE, 1), VXS_OK);
        assert_true(brute_init(&check, &p, SIDE, (int64_t)1 << s.grid, 0, 0));
        assert_true(sparse_levels[n % (cpu_level_of_machine() + 1)].gather(&l, &s, &id, 1, at));
        assert_true(sparse_levels[n % (cpu_level_of_machine() + 1)].leaf(&scratch, &d, &l, &nothing, at, &tile, &bounds));
        partly += bounds.emin < bounds.emax;
        for (uint32_t m = 0; m < 64; m++) {
            int met = brute_meet(&check, 0, at.u + m % 8, at.v + m / 8, &hit);
            if ((tile.e[m] == SIDE / 2) != met) fail_msg("texel %u of round %u: %u", m, n, tile.e[m]);
        }
        brute_free(&check);
        sparse_triangles_free(&s);
    }
    assert_true(partly > rounds / 10);
    free(l.lo);
    free(scratch.room);
}

static void assert_same_list(const square_list *a, const square_list *b)
{
    assert_int_equal(a->count, b->count);
    if (!a->count) return;
    assert_memory_equal(a->lo, b->lo, a->count * sizeof *a->lo);
    assert_memory_equal(a->hi, b->hi, a->count * sizeof *a->hi);
    assert_memory_equal(a->items, b->items, a->count * sizeof *a->items);
    assert_memory_equal(a->tags, b->tags, a->count * sizeof *a->tags);
}

/* The quarters of a list are what is gathered for them, at all levels, for any number of triangles. */
static void lists_are_split_as_they_are_gathered(void **state)
{
    enum { SIDE = 256, MOST = 32 };
    const uint32_t rounds = repeats(300, 3000);
    rng            r      = rng_split(1, 6);
    square_list    all = {0}, quarter[4] = {{0}}, alone = {0};
    (void)state;
    for (uint32_t n = 0; n < rounds; n++) {
        soup             o;
        sparse_triangles s;
        size_t           count = rng_below(&r, MOST + 1);
        uint32_t         ids[MOST], half = 8u << rng_below(&r, 4);
        const double     size = ldexp(1, (int)rng_below(&r, 9));
        for (size_t k = 0; k < count; k++) {
            const double u = uniform(&r, 0, SIDE), v = uniform(&r, 0, SIDE);
            for (int c = 0; c < 3; c++)
                o.v[3 * k + (size_t)c] = (vertex_ls){u + uniform(&r, -size, size), v + uniform(&r, -size, size), rng_unit(&r)};
        }
        projection   p  = projection_of(&o, count);
        texel_square at = {(uint32_t)rng_below(&r, SIDE / (2 * half)) * 2 * half,
                           (uint32_t)rng_below(&r, SIDE / (2 * half)) * 2 * half, 2 * half};
        assert_int_equal(sparse_triangles_init(&s, &p, SIDE, 1), VXS_OK);
        for (uint32_t k = 0; k < s.count; k++) ids[k] = k;
        for (int level = 0; level <= cpu_level_of_machine(); level++) {
            assert_true(sparse_levels[level].gather(&all, &s, ids, s.count, at));
            assert_true(sparse_levels[level].split(quarter, &s, &all, at));
            for (uint32_t q = 0; q < 4; q++) {
                const texel_square part = {at.u + (q & 1) * half, at.v + (q >> 1) * half, half};
                assert_true(sparse_levels[0].gather(&alone, &s, ids, s.count, part));
                assert_same_list(&quarter[q], &alone);
            }
        }
        sparse_triangles_free(&s);
    }
    free(all.lo);
    free(alone.lo);
    for (int q = 0; q < 4; q++) free(quarter[q].lo);
}

/* Edges through the centres of the outermost texels of tiles: half of them do not own those. */
static void sheets_end_on_centres(void **state)
{
    vxs_light light = identity_light(64);
    (void)state;
    for (int n = 0; n < 162; n++) {
        double u0 = 8 + 0.5 * (n % 3 - 1), v0 = 8 + 0.5 * (n / 3 % 3 - 1), u1 = 32 + 0.5 * (n / 9 % 3 - 1),
               v1      = 24 + 0.5 * (n / 27 % 3 - 1);
        double p[4][3] = {{u0, v0, 10}, {u1, v0, 11}, {u1, v1, 12}, {u0, v1, 11}};
        sample b       = {0};
        sample_points(&b, p[0], p[n < 81 ? 1 : 2], p[n < 81 ? 2 : 1]);
        sample_points(&b, p[0], p[n < 81 ? 2 : 3], p[n < 81 ? 3 : 2]);
        sample_sort(&b, CLOSED_AUTO);
        assert_true(compare_light(&b.c, &light, &(ways){.free_behind = n % 2}, 64, 1).texels >= 23 * 15);
        sample_clear(&b);
    }
}

/* what is free besides the insides of solids ----------------------------------------------------------------------------------- */

/* A sheet across the map, and somewhat more across than others: it has corners of its own. */
static void add_sheet(sample *b, double z, char kind)
{
    double  more = 8 + (double)b->s.triangle_count, low = -more, high = 64 + more;
    double  p[4][3] = {{low, low, z}, {high, low, z}, {high, high, z}, {low, high, z}};
    uint8_t flags   = kind == 'd' ? TRIANGLE_DOUBLE_SIDED : 0;
    sample_points(b, p[0], p[kind == 'b' ? 1 : 2], p[kind == 'b' ? 2 : 1]);
    b->s.triangle_flags[b->s.triangle_count - 1] = flags;
    sample_points(b, p[0], p[kind == 'b' ? 2 : 3], p[kind == 'b' ? 3 : 2]);
    b->s.triangle_flags[b->s.triangle_count - 1] = flags;
}

/* Sheets that face the light, f, or not, b, or are seen from both sides, d; and solids 10 deep, s. Then where they begin. */
static void add_layers(sample *b, const char *kinds, const double *z)
{
    for (int n = 0; kinds[n]; n++) {
        const double low[3] = {-9 - n, -9 - n, z[n]}, high[3] = {73 + n, 73 + n, z[n] + 10};
        if (kinds[n] == 's')
            sample_box(b, low, high);
        else
            add_sheet(b, z[n], kinds[n]);
    }
    sample_sort(b, CLOSED_AUTO);
}

/* A texel of a map, by its leaf at all levels, and the bound of the square of 32 around it. */
static void assert_column(const sample *b, const vxs_light *light, const ways *w, uint32_t e, uint32_t x, uint32_t square_x,
                          const char *what)
{
    const int        sun     = light->kind == VXS_LIGHT_KIND_DIRECTIONAL;
    run_context      m       = {0};
    uint32_t        *ids     = NULL;
    square_list      list    = {0};
    leaf_scratch     scratch = {0};
    projection       p;
    sparse_triangles s;
    column_bounds    bounds;
    column_tile      tile;
    leaf_desc        d = {.triangles    = &s,
                          .scale        = {64, sun ? 0 : light->voxel_metres},
                          .nearest_back = w->nearest_back,
                          .every_texel  = 1,
                          .dont_care    = dont_care_rules_of(light, w->free_behind, w->thickness_metres)};
    assert_int_equal(projection_init(&p, &b->c, light, 0, 1, &m), VXS_OK);
    assert_int_equal(sparse_triangles_init(&s, &p, 64, 1), VXS_OK);
    ids = calloc(s.count, sizeof *ids);
    assert_non_null(ids);
    for (uint32_t n = 0; n < s.count; n++) ids[n] = n;
    for (int level = 0; level <= (int)cpu_level_of_machine(); level++) {
        square_bound bound = {.enter_most = depth_none(d.scale), .left_out = INFINITY, .exit_least = INFINITY};
        assert_true(sparse_levels[level].gather(&list, &s, ids, s.count, (texel_square){32, 32, 8}));
        assert_true(sparse_levels[level].leaf(&scratch, &d, &list, &bound, (texel_square){32, 32, 8}, &tile, &bounds));
        if (tile.e[9] != e || tile.x[9] != x) fail_msg("%s: %u and %u, expected %u and %u", what, tile.e[9], tile.x[9], e, x);
        assert_true(sparse_levels[level].gather(&list, &s, ids, s.count, (texel_square){32, 32, 32}));
        square_bound_tighten(&bound, &list, &d.dont_care);
        uint32_t least_x = depth_up(d.scale, depth_clamped(d.scale, bound.exit_least));
        if (least_x != square_x) fail_msg("%s: a square says %u, expected %u", what, least_x, square_x);
    }
    free(ids);
    free(list.lo);
    free(scratch.room);
    sparse_triangles_free(&s);
    projection_free(&p);
}

static void more_is_free_where_it_is_asked_for(void **state)
{
    static const struct {
        const char *kinds;
        double      z[3];
        int         behind;
        double      thickness;
        uint32_t    e, x;
        uint32_t    square_x; /* what a square knows, where that is less; 0: it is not */
    } cases[] = {
        {"f", {20.25}, 0, 0, 20, 21, 0},
        {"f", {20.25}, 1, 0, 20, 64, 0},
        {"f", {20.25}, 0, 5, 20, 26, 0},
        {"f", {20.25}, 0, 100, 20, 64, 0}, /* beyond the map */
        {"f", {20.25}, 1, 5, 20, 64, 0},
        {"ff", {20.25, 22.5}, 1, 0, 20, 21, 0},
        {"ff", {20.25, 22.5}, 0, 5, 20, 23, 0}, /* no farther than the next surface */
        {"ff", {20.25, 22.5}, 1, 5, 20, 23, 0},
        {"ff", {20.25, 20.25}, 0, 5, 20, 21, 0},  /* in one plane: the next is there */
        {"ff", {20.25, 20.25}, 1, 0, 20, 64, 21}, /* and so is the last */
        {"fs", {20.25, 40.5}, 1, 0, 20, 21, 0},
        {"fs", {20.25, 40.5}, 0, 30, 20, 41, 0},
        {"d", {20.25}, 0, 5, 20, 21, 0}, /* both sides are seen */
        {"d", {20.25}, 1, 5, 20, 64, 0},
        {"fd", {20.25, 20.25}, 0, 5, 20, 21, 0},
        {"b", {20.25}, 0, 5, 20, 21, 0}, /* the side that is not seen faces the light */
        {"b", {20.25}, 1, 0, 20, 64, 0},
        {"s", {20.25}, 0, 5, 20, 31, 0}, /* of a solid the inside is free already */
        {"s", {20.25}, 1, 0, 20, 64, 0},
        {"sf", {20.25, 40}, 1, 5, 20, 31, 0},
        {"fdb", {20.25, 24, 30}, 0, 100, 20, 24, 0},
    };
    (void)state;
    for (size_t n = 0; n < sizeof cases / sizeof *cases; n++) {
        vxs_light light = identity_light(64);
        sample    b     = {0};
        char      what[64];
        snprintf(what, sizeof what, "%s, behind %d, thickness %g", cases[n].kinds, cases[n].behind, cases[n].thickness);
        add_layers(&b, cases[n].kinds, cases[n].z);
        assert_column(&b, &light, &(ways){0, cases[n].behind, cases[n].thickness}, cases[n].e, cases[n].x,
                      cases[n].square_x ? cases[n].square_x : cases[n].x, what);
        sample_clear(&b);
    }
}

/* A ramp that winds about a point on the diagonal, from one angle to another: it lies over itself, and faces one way. */
static void add_ramp(sample *b, double about, double from, double to, double rise)
{
    enum { PARTS = 90 };
    for (int n = 0; n < PARTS; n++) {
        double p[4][3];
        for (int k = 0; k < 4; k++) {
            double angle = from + (to - from) * (n + (k == 1 || k == 2)) / PARTS, radius = k < 2 ? 3 : 75;
            p[k][0] = about + radius * cos(angle);
            p[k][1] = about + radius * sin(angle);
            p[k][2] = 5 + rise * (angle - from);
        }
        sample_points(b, p[0], p[1], p[2]);
        sample_points(b, p[0], p[2], p[3]);
    }
}

/* What covers the middle of a square once may cover other texels twice, by itself. */
static void sheets_over_themselves(void **state)
{
    static const double turns[][2] = {{0, 1.1}, {0.05, 1.1}, {0.5, 2.6}, {0.2, 1.4}, {-0.12, 1.02}};
    size_t              texels     = 0;
    (void)state;
    for (uint32_t n = 0; n < 40; n++) {
        vxs_light  light = identity_light(64);
        sample     b     = {0};
        const ways w     = {0, n / 5 % 2, n / 10 % 2 ? 12 : 0};
        add_ramp(&b, n % 2 ? 32 : 20, 6.2831853 * turns[n % 5][0], 6.2831853 * turns[n % 5][1], n < 20 ? 1.5 : 3);
        sample_sort(&b, CLOSED_AUTO);
        texels += compare_light(&b.c, &light, &w, 64, 1).texels;
        sample_clear(&b);
    }
    assert_true(texels > 100000);
}

/* Solids 10 deep: light leaves where none is open, which may be behind more back faces than are kept in order. */
static void light_leaves_where_no_solid_is_open(void **state)
{
    static const struct {
        const char *kinds;
        double      z[5];
        uint32_t    x, square_x;
    } cases[] = {
        {"ss", {20, 31}, 30, 30},           {"ss", {20, 30}, 40, 30}, /* they touch */
        {"ss", {20, 25}, 35, 30},           {"ss", {20, 20.5}, 31, 30},
        {"sss", {20, 25, 31}, 41, 30},      {"sss", {20, 25, 36}, 35, 30},
        {"sss", {20, 30, 40}, 50, 30},      {"ssss", {10, 15, 24, 34}, 44, 20},
        {"ssss", {10, 15, 24, 35}, 34, 20}, {"sssss", {5, 6, 7, 15, 25}, 35, 15},
    };
    (void)state;
    for (size_t n = 0; n < sizeof cases / sizeof *cases; n++) {
        vxs_light light = identity_light(64);
        sample    b     = {0};
        char      what[64];
        snprintf(what, sizeof what, "solids, case %zu", n);
        add_layers(&b, cases[n].kinds, cases[n].z);
        assert_column(&b, &light, &(ways){0}, (uint32_t)cases[n].z[0], cases[n].x, cases[n].square_x, what);
        assert_column(&b, &light, &(ways){.nearest_back = 1}, (uint32_t)cases[n].z[0], cases[n].square_x, cases[n].square_x, what);
        sample_clear(&b);
    }
}

/* Metres of thickness are those along the axis of a punctual light's map. */
static void sheets_are_as_thick_for_a_punctual(void **state)
{
    light_shape shape = {
        .kind = LIGHT_SPOT, .position_ws = {32, 32, -10}, .direction_ws = {0, 0, 1}, .outer_rad = 0.5, .range_metres = 90};
    light_fit_desc fit = {.name = "lamp", .shape = &shape, .resolution = 64};
    vxs_light      light;
    sample         b    = {0};
    const double   z[3] = {20.25, 50};
    (void)state;
    add_layers(&b, "ff", z);
    assert_int_equal(light_fit(&light, &b.c, &fit, &b.m), VXS_OK);
    const double e = log(30.25 / light.near_metres) / light.voxel_metres, x = log(37.5 / light.near_metres) / light.voxel_metres;
    assert_true(ceil(x) > ceil(e) + 1);
    assert_column(&b, &light, &(ways){.thickness_metres = 7.25}, (uint32_t)(e - 1e-9), (uint32_t)ceil(x), (uint32_t)ceil(x),
                  "a lamp");
    sample_clear(&b);
}

enum { MESHES = 72 };

static void suns(void **state)
{
    counts sum = {0};
    (void)state;
    for (uint32_t n = 0; n < MESHES; n++) {
        static const closed_mode closed[] = {CLOSED_ON, CLOSED_AUTO, CLOSED_OFF};
        uint32_t                 side     = n % 16 == 15 ? 512 : 64u << n % 2;
        rng                      r        = rng_split(n, 1);
        vxs_light                light    = identity_light(side);
        sample                   b        = {0};
        ways                     w        = some_ways(n / 2);
        add_mesh(&b, &r, side, n / 2);
        sample_sort(&b, closed[n / 3 % 3]);
        counts c = compare_light(&b.c, &light, &w, n % 4 ? side : 32, 1 + n % 2);
        sum.texels += c.texels;
        sum.settled += c.settled;
        sum.looked_at += c.looked_at;
        sum.early += c.early;
        sample_clear(&b);
    }
    printf("suns: %zu texels, %zu tiles settled, %zu looked at, %zu early exits\n", sum.texels, sum.settled, sum.looked_at,
           sum.early);
}

/* More faces over each other than are counted for each layer. */
static void piles(void **state)
{
    (void)state;
    for (uint32_t n = 0; n < 3; n++) {
        rng       r     = rng_split(n, 4);
        vxs_light light = identity_light(32);
        sample    b     = {0};
        if (n == 0) add_nested(&b, &r, 32, 40);
        if (n == 1) add_nested(&b, &r, 32, 300);
        for (int k = 0; n == 2 && k < 200; k++) sample_cube(&b, 16 + 0.01 * (k % 7), 16, 16, 9);
        sample_sort(&b, CLOSED_ON);
        for (int nearest_back = 0; nearest_back < 2; nearest_back++)
            assert_true(compare_light(&b.c, &light, &(ways){.nearest_back = nearest_back, .free_behind = n % 2}, 32, 1).texels >
                        100);
        sample_clear(&b);
    }
}

static void punctuals(void **state)
{
    counts sum = {0};
    (void)state;
    for (uint32_t n = 0; n < 48; n++) {
        static const closed_mode closed[] = {CLOSED_ON, CLOSED_AUTO, CLOSED_OFF};
        uint32_t                 side     = 64u << n % 2;
        rng                      r        = rng_split(n, 2);
        light_shape              shape    = {
                            .kind = n % 2 ? LIGHT_SPOT : LIGHT_POINT, .outer_rad = uniform(&r, 0.1, 1.5), .range_metres = INFINITY};
        light_fit_desc fit = {.name = "lamp", .shape = &shape, .resolution = side};
        vxs_light      light;
        sample         b = {0};
        ways           w = some_ways(n / 2);
        random_point(&r, n % 3 ? 0 : -40, n % 3 ? 100 : 0, shape.position_ws);
        random_direction(&r, shape.direction_ws);
        add_mesh(&b, &r, 100, n / 2);
        sample_sort(&b, closed[n % 3]);
        if (light_fit(&light, &b.c, &fit, &b.m) == VXS_OK) {
            counts c = compare_light(&b.c, &light, &w, side, 2);
            sum.texels += c.texels;
            sum.settled += c.settled;
            sum.looked_at += c.looked_at;
        }
        sample_clear(&b);
    }
    printf("lamps: %zu texels, %zu tiles settled, %zu looked at\n", sum.texels, sum.settled, sum.looked_at);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(patches_end_where_surfaces_do),
        cmocka_unit_test(depths_stay_within_their_lists),
        cmocka_unit_test(long_edges_end_where_short_ones_do),
        cmocka_unit_test(lists_are_split_as_they_are_gathered),
        cmocka_unit_test(sheets_end_on_centres),
        cmocka_unit_test(light_leaves_where_no_solid_is_open),
        cmocka_unit_test(more_is_free_where_it_is_asked_for),
        cmocka_unit_test(sheets_are_as_thick_for_a_punctual),
        cmocka_unit_test(sheets_over_themselves),
        cmocka_unit_test(suns),
        cmocka_unit_test(piles),
        cmocka_unit_test(punctuals),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
