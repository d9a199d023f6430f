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
#include "scenes/generate.h"

#include <math.h>
#include <stdlib.h>

#include "baker/base/random.h"
#include "scenes/generate_parts.h"

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

/* As many octaves as the cells can represent: the wavelength of the last is at least three cells. */
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

/* Fractal heights, scaled to [0, height]. They are stored as floats before scaling: rounding is far below a millimetre. */
static void make_top(parts *p, const landscape_options *o, grid g)
{
    const double wavelengths = 3; /* mountains a side, about */
    int          octaves     = octaves_from_grid(g, wavelengths);
    double       low = INFINITY, high = -INFINITY;

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

static void make_skirts_and_bottom(parts *p, const landscape_options *o, grid g)
{
    uint32_t ring = 2 * (g.columns + g.rows), first = (g.columns + 1) * (g.rows + 1), middle = first + ring;
    double   bottom = -o->size_metres / 32;
    for (uint32_t k = 0; k < ring && !p->out_of_memory; k++) {
        const float *top = p->s->positions + 3 * (size_t)border_vertex(g, k);
        parts_vertex(p, top[0], bottom, top[2]);
    }
    parts_vertex(p, 0, bottom, 0);

    for (uint32_t k = 0; k < ring; k++) {
        uint32_t next = (k + 1) % ring, top = border_vertex(g, k), top_next = border_vertex(g, next);
        parts_triangle(p, top_next, top, first + k);
        parts_triangle(p, top_next, first + k, first + next);
        parts_triangle(p, first + next, first + k, middle);
    }
}

/* Interpolate as the triangles do: each cell is split from its lower left to its upper right, in (u, v). */
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
    grid  g = grid_from_triangles(o->triangles);
    parts p = parts_begin(s, "landscape");
    parts_mesh(&p, "landscape", 0);
    make_top(&p, o, g);
    make_skirts_and_bottom(&p, o, g);
    parts_sun(&p, o->sun);
    return parts_end(&p, m);
}
