/* Fractal terrain as one closed mesh.
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
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/generate/generate.h"

#include <math.h>
#include <stdlib.h>

#include "baker/base/random.h"
#include "baker/generate/generate_parts.h"
#include "baker/generate/generate_terrain.h"

enum { OCTAVES_MAX = 12 };

typedef struct grid {
    size_t columns, rows; /* cells along X and Z */
} grid;

/* The nearly square grid whose triangles, 2 cr + 6 (c + r) = 2 (c + 3)(r + 3) - 18, come nearest to the target. */
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
        g    = (grid){(size_t)(c - 3), (size_t)(r - 3)};
    }
    return g;
}

/* In [-1, 1). */
static double lattice_value(uint64_t seed, int64_t x, int64_t z)
{
    rng r = rng_split(seed, ((uint64_t)x << 32) ^ ((uint64_t)z & UINT32_MAX));
    return rng_u32(&r) / 2147483648.0 - 1;
}

/* 0 to 1 with first and second derivatives 0 at both ends. */
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

/* As many octaves as the cells can show: the last is at least three of them long. */
static int octaves_from_grid(grid g, double wavelengths)
{
    double cells   = (double)(g.columns < g.rows ? g.columns : g.rows) / wavelengths;
    int    octaves = 1;
    while (octaves < OCTAVES_MAX && cells >= 6) {
        cells /= 2;
        octaves++;
    }
    return octaves;
}

static void put_vertex(glb_scene *s, size_t index, double x, double y, double z)
{
    float *p = s->positions + 3 * index;
    p[0]     = (float)x;
    p[1]     = (float)y;
    p[2]     = (float)z;
}

static void append_triangle(glb_scene *s, size_t a, size_t b, size_t c)
{
    uint32_t *t = s->indices + 3 * s->triangle_count++;
    t[0]        = (uint32_t)a;
    t[1]        = (uint32_t)b;
    t[2]        = (uint32_t)c;
}

/* Fractal heights, stretched to [0, height]. They are kept as floats until then: the rounding is far below a millimetre. */
static void make_top(glb_scene *s, const landscape_options *o, grid g)
{
    const double wavelengths = 3; /* mountains a side, about */
    int          octaves     = octaves_from_grid(g, wavelengths);
    double       low = INFINITY, high = -INFINITY;

    for (size_t j = 0; j <= g.rows; j++)
        for (size_t i = 0; i <= g.columns; i++) {
            double u = (double)i / (double)g.columns, v = (double)j / (double)g.rows;
            float  y = (float)fractal(o->seed, octaves, u * wavelengths, v * wavelengths);
            put_vertex(s, j * (g.columns + 1) + i, (u - 0.5) * o->size_metres, y, (v - 0.5) * o->size_metres);
            if (y < low) low = y;
            if (y > high) high = y;
        }

    size_t top_count = (g.columns + 1) * (g.rows + 1);
    for (size_t i = 0; i < top_count; i++) {
        float *y = &s->positions[3 * i + 1];
        *y       = (float)(high > low ? (*y - low) / (high - low) * o->height_metres : 0);
    }

    for (size_t j = 0; j < g.rows; j++)
        for (size_t i = 0; i < g.columns; i++) {
            size_t a = j * (g.columns + 1) + i, b = a + g.columns + 1;
            append_triangle(s, a, b, a + 1);
            append_triangle(s, a + 1, b, b + 1);
        }
}

/* The k-th vertex of the top's border, in the order in which the top's triangles pass it: down X = 0, along the last row,
 * up the last column, back along the first row. */
static size_t border_vertex(grid g, size_t k)
{
    size_t stride = g.columns + 1;
    if (k < g.rows) return k * stride;
    k -= g.rows;
    if (k < g.columns) return g.rows * stride + k;
    k -= g.columns;
    if (k < g.rows) return (g.rows - k) * stride + g.columns;
    k -= g.rows;
    return g.columns - k;
}

static void make_skirts_and_bottom(glb_scene *s, const landscape_options *o, grid g)
{
    size_t top_count = (g.columns + 1) * (g.rows + 1), ring = 2 * (g.columns + g.rows), middle = top_count + ring;
    double bottom = -o->size_metres / 32;

    for (size_t k = 0; k < ring; k++) {
        const float *top = s->positions + 3 * border_vertex(g, k);
        put_vertex(s, top_count + k, top[0], bottom, top[2]);
    }
    put_vertex(s, middle, 0, bottom, 0);

    for (size_t k = 0; k < ring; k++) {
        size_t next = (k + 1) % ring;
        size_t top = border_vertex(g, k), top_next = border_vertex(g, next);
        append_triangle(s, top_next, top, top_count + k);
        append_triangle(s, top_next, top_count + k, top_count + next);
        append_triangle(s, top_count + next, top_count + k, middle);
    }
}

/* As its triangles have it: each cell is parted from its lower left to its upper right, in (u, v). */
double terrain_height(const glb_scene *s, const landscape_options *o, double x, double z)
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

vxs_result generate_landscape(glb_scene *s, const landscape_options *o, message *m)
{
    grid   g         = grid_from_triangles(o->triangles);
    size_t border    = 2 * (g.columns + g.rows);
    size_t triangles = 2 * g.columns * g.rows + 3 * border;

    *s              = (glb_scene){.name = "landscape"};
    s->vertex_count = (g.columns + 1) * (g.rows + 1) + border + 1;
    s->positions    = malloc(s->vertex_count * 3 * sizeof *s->positions);
    s->indices      = malloc(triangles * 3 * sizeof *s->indices);
    s->meshes       = calloc(1, sizeof *s->meshes);
    if (!s->positions || !s->indices || !s->meshes) {
        glb_scene_free(s);
        return fail(m, VXS_E_MEMORY, "out of memory for a landscape of %zu triangles", triangles);
    }

    make_top(s, o, g);
    make_skirts_and_bottom(s, o, g);
    s->mesh_count = 1;
    s->meshes[0]  = (glb_mesh){"landscape", 0, s->vertex_count, 0, s->triangle_count, 0, {0}};
    parts p       = parts_continue(s);
    parts_sun(&p, o->sun);
    return parts_end(&p, m);
}
