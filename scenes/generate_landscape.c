/* Ground: a landscape, and a forest.
 *
 * Landscape: fractal terrain as one closed mesh.
 *
 * Heights are a sum of octaves of value noise (random values on a lattice, smoothly interpolated), each turned by a 3-4-5
 * triangle against the one before so that no lattice shows, folded into ridges and damped in the valleys (after the ridged
 * multifractal of Musgrave, "Texturing and Modeling", chapter 16).
 *
 *        top     (columns + 1) x (rows + 1) vertices, 2 columns rows triangles
 *       /  \
 *      |    |    skirts from the top's border to a ring at the bottom: 4 (columns + rows) triangles
 *      +-.-+     bottom: a fan from its middle to the ring: 2 (columns + rows) triangles
 *
 * Forest: trees on hilly ground, their leaves cut out of cards by the alpha of an image.
 *
 *         \ | /        cards    squares about the crown's middle, turned any way, each with the whole image of leaves
 *        -- * --       branches closed tubes grown into the trunk
 *         / | \        trunk    a closed surface of revolution, half a metre deep in the ground
 *     ______|______
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "scenes/generate.h"

#include <math.h>
#include <stdlib.h>

#include "baker/base/random.h"
#include "scenes/generate_parts.h"

/* landscape -------------------------------------------------------------------------------------------------------------------- */

enum { OCTAVES_MAX = 12 };

typedef struct grid {
    uint32_t columns, rows; /* cells along X and Z */
} grid;

/* The nearly square grid whose number of triangles, 2 cr + 6 (c + r) = 2 (c + 3)(r + 3) - 18, is nearest to the target. */
static grid grid_from_triangles(uint32_t triangles)
{
    int64_t target = triangles / 2 + 9;
    int64_t root   = (int64_t)sqrt((double)target);
    int64_t best   = INT64_MAX;
    grid    g      = {0, 0};
    for (int64_t c = root - 4; c <= root + 4; c++) {
        int64_t r = (target + c / 2) / c, miss = llabs(target - c * r);
        if (miss >= best) continue;
        best = miss;
        g    = (grid){(uint32_t)(c - 3), (uint32_t)(r - 3)};
    }
    return g;
}

/* In [-1, 1). */
static double lattice_value(uint64_t seed, int64_t x, int64_t z)
{
    rng r = rng_split(seed, ((uint64_t)x << 32) ^ ((uint64_t)z & UINT32_MAX));
    return rng_u32(&r) / 2147483648.0 - 1;
}

/* Rises from 0 to 1, with first and second derivatives 0 at both ends. */
static double fade(double t)
{
    return t * t * t * (t * (t * 6 - 15) + 10);
}

static double noise(uint64_t seed, double x, double z)
{
    int64_t xi = (int64_t)x - (x < (double)(int64_t)x); /* floor */
    int64_t zi = (int64_t)z - (z < (double)(int64_t)z);
    double  u = fade(x - (double)xi), v = fade(z - (double)zi);

    double near_z = lattice_value(seed, xi, zi), far_z = lattice_value(seed, xi, zi + 1);
    near_z += u * (lattice_value(seed, xi + 1, zi) - near_z);
    far_z += u * (lattice_value(seed, xi + 1, zi + 1) - far_z);
    return near_z + v * (far_z - near_z);
}

/* x, z in wavelengths of the first octave. */
static double fractal(uint32_t seed, int octaves, double x, double z)
{
    double sum = 0, amplitude = 1, weight = 1;
    for (int i = 0; i < octaves; i++) {
        double n     = noise(rng_split(seed, (uint64_t)i).state, x, z);
        double ridge = 1 - (n < 0 ? -n : n);
        ridge *= ridge * weight;
        sum += ridge * amplitude;
        weight    = ridge * 1.5 < 1 ? ridge * 1.5 : 1;
        amplitude = amplitude / 2;

        double turned_x = 2 * (4 * x + 3 * z) / 5, turned_z = 2 * (4 * z - 3 * x) / 5;
        x = turned_x;
        z = turned_z;
    }
    return sum;
}

/* Fractal heights, scaled to [0, height]. They are stored as floats before scaling: rounding is far below a millimetre. */
static void make_top(parts *p, const landscape_options *o, grid g)
{
    const double wavelengths = 3; /* mountains a side, about */
    double       low = INFINITY, high = -INFINITY;

    /* as many octaves as the cells can represent: the wavelength of the last is at least three cells */
    int octaves = 1;
    for (double cells = (g.columns < g.rows ? g.columns : g.rows) / wavelengths; octaves < OCTAVES_MAX && cells >= 6; cells /= 2)
        octaves++;

    for (uint32_t j = 0; j <= g.rows; j++)
        for (uint32_t i = 0; i <= g.columns; i++) {
            double u = (double)i / g.columns, v = (double)j / g.rows;
            float  y = (float)fractal(o->seed, octaves, u * wavelengths, v * wavelengths);
            parts_vertex(p, (u - 0.5) * o->size_metres, y, (v - 0.5) * o->size_metres);
            if (y < low) low = y;
            if (y > high) high = y;
        }

    for (size_t i = 0; i < p->s->vertex_count; i++) {
        float *y = &p->s->positions[3 * i + 1];
        *y       = (float)(high > low ? (*y - low) / (high - low) * o->height_metres : 0);
    }

    for (uint32_t j = 0; j < g.rows; j++)
        for (uint32_t i = 0; i < g.columns; i++) {
            uint32_t a = j * (g.columns + 1) + i, b = a + g.columns + 1;
            parts_triangle(p, a, b, a + 1);
            parts_triangle(p, a + 1, b, b + 1);
        }
}

/* The k-th vertex of the top's border, in the order of the top's triangles: down X = 0, along the last row, up the last column,
 * back along the first row. */
static uint32_t border_vertex(grid g, uint32_t k)
{
    uint32_t stride = g.columns + 1;
    if (k < g.rows) return k * stride;
    k -= g.rows;
    if (k < g.columns) return g.rows * stride + k;
    k -= g.columns;
    if (k < g.rows) return (g.rows - k) * stride + g.columns;
    k -= g.rows;
    return g.columns - k;
}

/* Interpolate as the triangles do: each cell is split from its lower left to its upper right, in (u, v). */
static double terrain_height(const glb_scene *s, const landscape_options *o, double x, double z)
{
    grid   g = grid_from_triangles(o->triangles);
    double u = (x / o->size_metres + 0.5) * (double)g.columns, v = (z / o->size_metres + 0.5) * (double)g.rows;
    size_t i = (size_t)u, j = (size_t)v, a = j * (g.columns + 1) + i, b = a + g.columns + 1;
    double su = u - (double)i, sv = v - (double)j;

    const float *y          = s->positions + 1;
    double       far_corner = su + sv < 1 ? y[3 * a] : y[3 * (b + 1)];
    double       du = su + sv < 1 ? su : 1 - su, dv = su + sv < 1 ? sv : 1 - sv;
    double       beside = su + sv < 1 ? y[3 * (a + 1)] : y[3 * b], above = su + sv < 1 ? y[3 * b] : y[3 * (a + 1)];
    return far_corner + du * (beside - far_corner) + dv * (above - far_corner);
}

vxs_result generate_landscape(glb_scene *s, const landscape_options *o, run_context *m)
{
    grid  g = grid_from_triangles(o->triangles);
    parts p = parts_begin(s, "landscape");
    parts_mesh(&p, "landscape", 0);
    make_top(&p, o, g);

    uint32_t ring = 2 * (g.columns + g.rows), first = (g.columns + 1) * (g.rows + 1), middle = first + ring;
    double   bottom = -o->size_metres / 32;
    for (uint32_t k = 0; k < ring && !p.out_of_memory; k++) {
        const float *top = p.s->positions + 3 * (size_t)border_vertex(g, k);
        parts_vertex(&p, top[0], bottom, top[2]);
    }
    parts_vertex(&p, 0, bottom, 0);

    for (uint32_t k = 0; k < ring; k++) {
        uint32_t next = (k + 1) % ring, top = border_vertex(g, k), top_next = border_vertex(g, next);
        parts_triangle(&p, top_next, top, first + k);
        parts_triangle(&p, top_next, first + k, first + next);
        parts_triangle(&p, first + next, first + k, middle);
    }

    parts_sun(&p, o->sun);
    return parts_end(&p, m);
}

/* forest ----------------------------------------------------------------------------------------------------------------------- */

enum {
    GROUND_SHARE     = 5, /* one of this many triangles is for the ground */
    TRUNK_SIDES      = 8,
    TRUNK_TRIANGLES  = 2 * TRUNK_SIDES * 4, /* five rows; both ends are points */
    BRANCHES         = 4,
    BRANCH_SIDES     = 4,
    BRANCH_TRIANGLES = 4 * BRANCH_SIDES - 4,
    WOOD_TRIANGLES   = TRUNK_TRIANGLES + BRANCHES * BRANCH_TRIANGLES,
    CARDS            = 80, /* a tree, about */
    IMAGE_PX         = 128,
    LEAVES           = 56
};

static const double leaf_cutoff = 0.5;

typedef struct tree {
    double x, ground, z;
    double height, radius, crown;
    rng    branches, leaves;
} tree;

static double between(rng *r, double low, double high)
{
    return low + (high - low) * rng_between(r, 0, 4096) / 4096;
}

/* ---- the image ---- */

/* One leaf: its length is along (c, s), its sides are two parabolas. */
typedef struct leaf {
    double x, y, c, s, half_length, half_width;
    int    shade;
} leaf;

/* 255 inside, 0 outside, and a value between in the pixel of the edge. */
static int leaf_alpha(const leaf *l, double x, double y)
{
    double along = ((x - l->x) * l->c + (y - l->y) * l->s) / l->half_length, across = (y - l->y) * l->c - (x - l->x) * l->s;
    double inside = l->half_width * (1 - along * along) - (across < 0 ? -across : across) + 0.5;
    if (along * along >= 1 || inside <= 0) return 0;
    return inside >= 1 ? 255 : (int)(255 * inside + 0.5);
}

static uint8_t *make_image(rng r)
{
    uint8_t *rgba = malloc((size_t)IMAGE_PX * IMAGE_PX * 4);
    leaf     leaves[LEAVES];
    for (int i = 0; i < LEAVES; i++) {
        leaf l       = {.half_length = between(&r, 13, 20)};
        l.half_width = l.half_length * between(&r, 0.36, 0.5);
        l.x          = between(&r, l.half_length + 1, IMAGE_PX - l.half_length - 1);
        l.y          = between(&r, l.half_length + 1, IMAGE_PX - l.half_length - 1);
        l.shade      = rng_between(&r, -30, 30);
        parts_turn(rng_below(&r, 32), 32, &l.c, &l.s);
        leaves[i] = l;
    }
    for (int n = 0; rgba && n < IMAGE_PX * IMAGE_PX; n++) {
        int alpha = 0, shade = 0;
        for (int i = 0; i < LEAVES; i++) {
            int a = leaf_alpha(&leaves[i], n % IMAGE_PX + 0.5, n / IMAGE_PX + 0.5);
            if (a > alpha) alpha = a, shade = leaves[i].shade;
        }
        rgba[4 * n]     = (uint8_t)(70 + shade);
        rgba[4 * n + 1] = (uint8_t)(130 + shade);
        rgba[4 * n + 2] = (uint8_t)(50 + shade / 2);
        rgba[4 * n + 3] = (uint8_t)alpha;
    }
    return rgba;
}

/* ---- a tree ---- */

/* One tree in a cell of a square lattice. */
static tree plan_tree(const glb_scene *s, const landscape_options *ground, uint32_t index, uint32_t side)
{
    rng    r    = rng_split(rng_split(ground->seed, 7).state, index);
    double cell = ground->size_metres * 0.94 / side, corner = ground->size_metres * -0.47;
    tree   t   = {.height = between(&r, 5, 12)};
    t.x        = corner + cell * (index % side + between(&r, 0.1, 0.9));
    t.z        = corner + cell * (index / side + between(&r, 0.1, 0.9));
    t.ground   = terrain_height(s, ground, t.x, t.z);
    t.radius   = t.height * between(&r, 0.02, 0.035);
    t.crown    = t.height * between(&r, 0.25, 0.35);
    t.branches = rng_split(r.state, 1);
    t.leaves   = rng_split(r.state, 2);
    return t;
}

/* A random vector in the unit ball, not near its middle. Returns the length. */
static double random_in_ball(rng *r, double v[3])
{
    double square;
    do {
        for (int i = 0; i < 3; i++) v[i] = between(r, -1, 1);
        square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    } while (square > 1 || square < 0.01);
    return sqrt(square);
}

/* The image's origin is at any of the square's corners. */
static void add_card(parts *p, tree *t)
{
    double   at[3], u[3], v[3], half = t->crown * between(&t->leaves, 0.18, 0.3);
    uint32_t first = 0, turn = rng_below(&t->leaves, 4);
    random_in_ball(&t->leaves, at);

    /* two sides of a square, half as long as the square's */
    double a[3], length_u = random_in_ball(&t->leaves, u), length_v = 0;
    do {
        random_in_ball(&t->leaves, a);
        v[0]     = u[1] * a[2] - u[2] * a[1];
        v[1]     = u[2] * a[0] - u[0] * a[2];
        v[2]     = u[0] * a[1] - u[1] * a[0];
        length_v = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    } while (length_v < 0.001);
    for (int i = 0; i < 3; i++) u[i] *= half / length_u, v[i] *= half / length_v;

    const double middle[3] = {t->x + at[0] * t->crown, t->ground + t->height * 0.75 + at[1] * t->height * 0.3,
                              t->z + at[2] * t->crown};
    for (uint32_t i = 0; i < 4; i++) {
        double s = i == 1 || i == 2 ? 1 : -1, w = i >= 2 ? 1 : -1, corner[3];
        for (int k = 0; k < 3; k++) corner[k] = middle[k] + (s * u[k] + w * v[k]);
        uint32_t from = (i + turn) % 4, vertex = parts_vertex_uv(p, corner, from == 1 || from == 2, from >= 2);
        if (!i) first = vertex;
    }
    parts_triangle(p, first, first + 1, first + 2);
    parts_triangle(p, first, first + 2, first + 3);
}

/* ---- the forest ---- */

static void add_trees(parts *p, const landscape_options *ground, uint32_t triangles)
{
    uint32_t trees = triangles / (WOOD_TRIANGLES + 2 * CARDS), side;
    if (!trees) trees = 1;
    side           = (uint32_t)sqrt((double)trees);
    side           = side * side < trees ? side + 1 : side;
    uint64_t cards = (triangles - trees * WOOD_TRIANGLES) / 2;

    parts_mesh(p, "wood", 0);
    for (uint32_t i = 0; i < trees; i++) {
        tree t = plan_tree(p->s, ground, i, side);

        const double profile[6][2] = {{0, t.height},   {t.radius * 0.3, t.height * 0.9}, {t.radius * 0.7, t.height * 0.5},
                                      {t.radius, 0.1}, {t.radius * 1.3, -0.4},           {0, -0.5}};
        parts_lathe(p, (double[3]){t.x, t.ground, t.z}, profile, 6, TRUNK_SIDES);
        for (uint32_t n = 0; n < BRANCHES; n++) {
            double c, s, from = t.height * between(&t.branches, 0.35, 0.7), up = t.crown * between(&t.branches, 0.3, 0.6);
            double out = t.crown * between(&t.branches, 0.6, 0.9), thick = t.radius * 0.4;
            parts_turn((4 * n + rng_below(&t.branches, 4)) % 16, 16, &c, &s);
            parts_tube(p, (double[3]){t.x, t.ground + from, t.z}, thick,
                       (double[3]){t.x + c * out, t.ground + from + up, t.z + s * out}, thick * 0.3, BRANCH_SIDES);
        }
    }
    uint32_t image = parts_image(p, IMAGE_PX, IMAGE_PX, make_image(rng_split(ground->seed, 8)));
    parts_mesh(p, "leaves",
               parts_material(p, (glb_material){.name = "leaves", .double_sided = 1, .alpha_cutoff = leaf_cutoff, .image = image}));
    for (uint32_t i = 0; i < trees; i++) {
        tree t = plan_tree(p->s, ground, i, side);
        for (uint64_t k = cards * i / trees; k < cards * (i + 1) / trees; k++) add_card(p, &t);
    }
}

vxs_result generate_forest(glb_scene *s, const forest_options *o, run_context *m)
{
    landscape_options ground = {
        o->triangles / GROUND_SHARE, o->seed, o->size_metres, o->size_metres / 12, {o->sun[0], o->sun[1], o->sun[2]}};
    vxs_result r = generate_landscape(s, &ground, m);
    if (r != VXS_OK) return r;
    s->name = "forest";
    parts p = parts_continue(s);
    add_trees(&p, &ground, o->triangles - (uint32_t)s->triangle_count);
    return parts_end(&p, m);
}
