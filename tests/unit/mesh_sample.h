/* Scenes for tests, made triangle by triangle, and what is known about them without any of the code under test.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef MESH_SAMPLE_H
#define MESH_SAMPLE_H

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "baker/casters/casters.h" /* before cmocka, whose fail() is a macro */

#include <cmocka.h>

typedef struct sample {
    scene       s;
    casters     c;
    run_context m;
    size_t      room; /* triangles that s's arrays have room for */
} sample;

static inline void *sample_grown(void *p, size_t size)
{
    p = realloc(p, size);
    assert_non_null(p);
    return p;
}

static inline uint32_t sample_triangle(sample *b, const double p[3][3])
{
    scene *s = &b->s;
    size_t t = s->triangle_count++;
    if (t >= b->room) { /* twice as many: sanitizers copy at each step */
        b->room           = 2 * t + 16;
        s->positions_ws   = sample_grown(s->positions_ws, (s->vertex_count + 3 * (b->room - t)) * 3 * sizeof(double));
        s->indices        = sample_grown(s->indices, b->room * 3 * sizeof(uint32_t));
        s->triangle_flags = sample_grown(s->triangle_flags, b->room);
    }
    s->triangle_flags[t] = 0;
    for (size_t i = 0; i < 3; i++) {
        memcpy(&s->positions_ws[3 * s->vertex_count], p[i], 3 * sizeof(double));
        s->indices[3 * t + i] = (uint32_t)s->vertex_count++;
    }
    return (uint32_t)t;
}

static inline void sample_points(sample *b, const double *a, const double *p, const double *q)
{
    double corners[3][3];
    memcpy(corners[0], a, sizeof corners[0]);
    memcpy(corners[1], p, sizeof corners[1]);
    memcpy(corners[2], q, sizeof corners[2]);
    sample_triangle(b, (const double(*)[3])corners);
}

/* Corner n of a box: bit i of n chooses low or high along axis i. */
static const uint8_t sample_box_faces[12][3] = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                                                {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};

static inline void sample_box(sample *b, const double low[3], const double high[3])
{
    double p[8][3];
    for (int n = 0; n < 8; n++)
        for (int axis = 0; axis < 3; axis++) p[n][axis] = n >> axis & 1 ? high[axis] : low[axis];
    for (int f = 0; f < 12; f++) sample_points(b, p[sample_box_faces[f][0]], p[sample_box_faces[f][1]], p[sample_box_faces[f][2]]);
}

static inline void sample_cube(sample *b, double x, double y, double z, double half)
{
    sample_box(b, (double[3]){x - half, y - half, z - half}, (double[3]){x + half, y + half, z + half});
}

/* A closed surface around the z axis of the unit ball, `side` and 2 `side` parts; moved by `at`, scaled by `radius`. */
static inline void sample_ball(sample *b, const double at[3], double radius, int side)
{
    const double pi = acos(-1);
    for (int i = 0; i < side; i++)
        for (int j = 0; j < 2 * side; j++) {
            double p[4][3];
            for (int k = 0; k < 4; k++) {
                int    row = i + (k == 1 || k == 2), column = (j + (k >= 2)) % (2 * side);
                double ring = row == 0 || row == side ? 0 : sin(pi * row / side); /* poles are one point */
                p[k][0]     = at[0] + radius * ring * cos(pi * column / side);
                p[k][1]     = at[1] + radius * ring * sin(pi * column / side);
                p[k][2]     = at[2] + radius * (row == 0 ? 1 : row == side ? -1 : cos(pi * row / side));
            }
            if (i + 1 < side) sample_points(b, p[0], p[1], p[2]);
            if (i > 0) sample_points(b, p[0], p[2], p[3]);
        }
}

/* A strip of `parts` quads around a circle, glued after `turns` half turns: 1 is a Moebius band. */
static inline void sample_band(sample *b, int parts, int turns)
{
    const double pi    = acos(-1);
    double(*rim)[2][3] = calloc((size_t)parts + 1, sizeof *rim);
    assert_non_null(rim);
    for (int i = 0; i < parts; i++)
        for (int k = 0; k < 2; k++) {
            double a = 2 * pi * i / parts, tilt = pi * turns * i / parts, across = k ? 0.3 : -0.3;
            rim[i][k][0] = (1 + across * cos(tilt)) * cos(a);
            rim[i][k][1] = (1 + across * cos(tilt)) * sin(a);
            rim[i][k][2] = across * sin(tilt);
        }
    for (int k = 0; k < 2; k++) memcpy(rim[parts][k], rim[0][k ^ (turns & 1)], sizeof rim[0][0]);
    for (int i = 0; i < parts; i++) {
        sample_points(b, rim[i][0], rim[i + 1][0], rim[i + 1][1]);
        sample_points(b, rim[i][0], rim[i + 1][1], rim[i][1]);
    }
    free(rim);
}

/* A Klein bottle (figure eight): closed, no boundary, not orientable, crosses itself. */
static inline void sample_klein_bottle(sample *b, int n)
{
    const double pi = acos(-1);
    double      *p  = calloc((size_t)(n * n) * 3, sizeof *p);
    assert_non_null(p);
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) {
            double  a = 2 * pi * i / n, v = 2 * pi * (j + 0.5) / n; /* v = 0 and v = pi are one line */
            double  r = 3 + cos(a / 2) * sin(v) - sin(a / 2) * sin(2 * v);
            double *q = &p[3 * (i * n + j)];
            q[0]      = r * cos(a);
            q[1]      = r * sin(a);
            q[2]      = sin(a / 2) * sin(v) + cos(a / 2) * sin(2 * v);
        }
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) {
            int           last = i + 1 == n, k = (j + 1) % n; /* after one turn v runs the other way */
            const double *q[4] = {&p[3 * (i * n + j)], &p[3 * ((i + 1) % n * n + (last ? n - 1 - j : j))],
                                  &p[3 * ((i + 1) % n * n + (last ? n - 1 - k : k))], &p[3 * (i * n + k)]};
            sample_points(b, q[0], q[1], q[2]);
            sample_points(b, q[0], q[2], q[3]);
        }
    free(p);
}

static inline void sample_turn(sample *b, size_t first, size_t end)
{
    for (size_t t = first; t < end; t++) {
        uint32_t swapped        = b->s.indices[3 * t];
        b->s.indices[3 * t]     = b->s.indices[3 * t + 1];
        b->s.indices[3 * t + 1] = swapped;
    }
}

static inline void sample_remove(sample *b, size_t t)
{
    size_t last = --b->s.triangle_count;
    memmove(&b->s.indices[3 * t], &b->s.indices[3 * t + 3], 3 * (last - t) * sizeof *b->s.indices);
    memmove(&b->s.triangle_flags[t], &b->s.triangle_flags[t + 1], last - t);
}

static inline void sample_map(sample *b, double scale, double offset)
{
    for (size_t i = 0; i < 3 * b->s.vertex_count; i++) b->s.positions_ws[i] = b->s.positions_ws[i] * scale + offset;
}

static inline void sample_sort(sample *b, closed_mode closed)
{
    casters_free(&b->c);
    assert_int_equal(casters_from_scene(&b->c, &b->s, closed, 2, &b->m), VXS_OK);
}

static inline void sample_clear(sample *b)
{
    casters_free(&b->c);
    run_free(&b->m);
    scene *s = &b->s;
    free(s->positions_ws);
    free(s->indices);
    free(s->triangle_flags);
    free(s->parts);
    free(s->alpha_masks);
    free(s->holed_triangles);
    free(s->camera_positions_ws);
    *b = (sample){0};
}

static inline uint32_t sample_random(uint32_t *seed, uint32_t below)
{
    *seed = *seed * 1664525u + 1013904223u;
    return (*seed >> 8) % below;
}

static inline double sample_uniform(uint32_t *seed)
{
    return sample_random(seed, 1u << 24) / (double)(1u << 24);
}

/* Another order of the triangles. Flags stay where they are. */
static inline void sample_shuffle(sample *b, uint32_t *seed)
{
    for (size_t t = b->s.triangle_count; t > 1; t--) {
        uint32_t swapped[3], *last = &b->s.indices[3 * (t - 1)],
                             *other = &b->s.indices[3 * (size_t)sample_random(seed, (uint32_t)t)];
        memcpy(swapped, last, sizeof swapped);
        memmove(last, other, sizeof swapped);
        memcpy(other, swapped, sizeof swapped);
    }
}

/* The winding number of a surface around a point as a sum of solid angles (van Oosterom and Strackee 1983). */
static inline double sample_winding(const double *positions, const uint32_t *indices, size_t triangle_count, const double at[3])
{
    double sum = 0;
    for (size_t t = 0; t < triangle_count; t++) {
        double e[3][3], length[3];
        for (int i = 0; i < 3; i++) {
            for (int axis = 0; axis < 3; axis++)
                e[i][axis] = positions[3 * (size_t)indices[3 * t + (size_t)i] + (size_t)axis] - at[axis];
            length[i] = sqrt(e[i][0] * e[i][0] + e[i][1] * e[i][1] + e[i][2] * e[i][2]);
        }
        double d[3];
        for (int i = 0; i < 3; i++) {
            const double *p = e[i], *q = e[(i + 1) % 3];
            d[i] = p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
        }
        double determinant = e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) + e[0][1] * (e[1][2] * e[2][0] - e[1][0] * e[2][2]) +
                             e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0]);
        sum += 2 * atan2(determinant, length[0] * length[1] * length[2] + d[0] * length[2] + d[1] * length[0] + d[2] * length[1]);
    }
    return sum / (4 * acos(-1));
}

static inline double sample_volume(const double *positions, const uint32_t *indices, size_t triangle_count)
{
    double        volume = 0;
    const double *o      = positions;
    for (size_t t = 0; t < triangle_count; t++) {
        double e[3][3];
        for (int i = 0; i < 3; i++)
            for (int axis = 0; axis < 3; axis++)
                e[i][axis] = positions[3 * (size_t)indices[3 * t + (size_t)i] + (size_t)axis] - o[axis];
        volume += (e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) + e[0][1] * (e[1][2] * e[2][0] - e[1][0] * e[2][2]) +
                   e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0])) /
                  6;
    }
    return volume;
}

#endif
