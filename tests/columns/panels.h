/* Panels of 1 m that meet along their sides, and the columns through which light falls between them.
 *
 * Three strips of three panels, folded along the seams between strips' panels, or flat and like bricks; each panel is a grid of 1
 * to 4 by 1 to 4 quads of its own, so that most vertices on a side lie in the middle of the neighbour's edges. All of it is turned
 * and moved anyhow. Coordinates are floats: of all panels, or of each, which a node then turns and places.
 *
 * The panels face the light, with nothing behind them: a column that has no caster though its ray meets where panels are, is a
 * leak. A gap explains it where the ray passes a seam within that gap's width; what rounding makes of seams without a gap explains
 * nothing.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef PANELS_H
#define PANELS_H

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/box.h"
#include "baker/columns/sparse/sparse_columns.h"
#include "baker/columns/sparse/sparse_triangles.h"
#include "baker/lab/opengl/depth_gl.h"
#include "baker/light/light_fit.h"
#include "baker/light/map_space.h"
#include "tests/unit/random_light.h"

enum { PANELS_ACROSS = 3, PANELS = PANELS_ACROSS * PANELS_ACROSS, PANEL_PARTS_MAX = 4, PANEL_MAPS_MAX = 6 };

typedef struct panels {
    scene  s;
    double gap_metres;
    double corners[PANELS][4][3]; /* world space, without gaps, in order about each */
    double middle[3], normal[3];  /* of all; the side that light comes from */
} panels;

typedef struct leak_counts {
    uint64_t columns;
    uint64_t in_gaps;     /* a gap explains it */
    uint64_t beside_gaps; /* within two steps of the map's grid of what a gap explains: vertices are moved to it */
    uint64_t unexplained;
} leak_counts;

/* --- the panels -------------------------------------------------------------------------------------------------------- */

/* How a node places its mesh. */
typedef struct panel_frame {
    double axis[3][3], origin[3];
} panel_frame;

static inline void panel_place(const panel_frame *f, const double local[3], double out[3])
{
    for (int n = 0; n < 3; n++)
        out[n] = f->origin[n] + f->axis[0][n] * local[0] + f->axis[1][n] * local[1] + f->axis[2][n] * local[2];
}

static inline panel_frame panel_random_frame(rng *r)
{
    panel_frame f;
    random_direction(r, f.axis[0]);
    random_direction(r, f.axis[2]);
    cross(f.axis[2], f.axis[0], f.axis[1]);
    make_unit(f.axis[1]);
    cross(f.axis[0], f.axis[1], f.axis[2]);
    for (int n = 0; n < 3; n++) f.origin[n] = (double)(float)uniform(r, -5, 5);
    return f;
}

static inline double panel_between(const double q[4][3], double x, double y, int axis)
{
    return (1 - y) * ((1 - x) * q[0][axis] + x * q[1][axis]) + y * ((1 - x) * q[3][axis] + x * q[2][axis]);
}

/* A panel of parts[0] by parts[1] quads, with a margin of half a gap.
 * q  [4] its corners in the space of f, floats once they are stored */
static inline void panel_add(panels *p, rng *r, const double q[4][3], const panel_frame *f, double margin)
{
    scene   *s        = &p->s;
    uint32_t parts[2] = {1 + rng_below(r, PANEL_PARTS_MAX), 1 + rng_below(r, PANEL_PARTS_MAX)}, first = (uint32_t)s->vertex_count;
    scene_origin *from = &s->origins[s->origin_count++];
    *from              = (scene_origin){(uint32_t)s->triangle_count, {f->origin[0], f->origin[1], f->origin[2]}};
    for (uint32_t j = 0; j <= parts[1]; j++)
        for (uint32_t i = 0; i <= parts[0]; i++) {
            double x = (double)i / parts[0], y = (double)j / parts[1], local[3];
            for (int n = 0; n < 3; n++)
                local[n] = (double)(float)panel_between(q, margin + (1 - 2 * margin) * x, margin + (1 - 2 * margin) * y, n);
            panel_place(f, local, s->positions_ws + 3 * s->vertex_count++);
        }
    for (uint32_t j = 0; j < parts[1]; j++)
        for (uint32_t i = 0; i < parts[0]; i++) {
            uint32_t a = first + j * (parts[0] + 1) + i, b = a + 1, d = a + parts[0] + 1, c = d + 1;
            memcpy(s->indices + 3 * s->triangle_count++, (uint32_t[]){a, b, c}, 3 * sizeof a);
            memcpy(s->indices + 3 * s->triangle_count++, (uint32_t[]){a, c, d}, 3 * sizeof a);
        }
}

/* Without memory, s.positions_ws is NULL. Released with panels_free. */
static inline panels panels_make(uint64_t seed, double gap_metres)
{
    panels      p   = {.gap_metres = gap_metres};
    rng         r   = rng_split(seed, 77);
    panel_frame all = panel_random_frame(&r), none = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {0, 0, 0}};
    int         bricks = (int)rng_below(&r, 2), nodes = (int)rng_below(&r, 2);
    double      rise[4] = {0}, along[4] = {0};
    size_t      most   = (size_t)PANELS * PANEL_PARTS_MAX * PANEL_PARTS_MAX * 2;
    p.s.positions_ws   = calloc(3 * most, 3 * sizeof *p.s.positions_ws);
    p.s.indices        = calloc(most, 3 * sizeof *p.s.indices);
    p.s.triangle_flags = calloc(most, 1);
    p.s.origins        = calloc(PANELS, sizeof *p.s.origins);
    if (!p.s.positions_ws || !p.s.indices || !p.s.triangle_flags || !p.s.origins) {
        scene_free(&p.s);
        return p;
    }
    for (int i = 0; i < PANELS_ACROSS; i++) { /* 1 m each, at an angle to the one before */
        double turn  = bricks ? 0 : uniform(&r, -0.4, 0.4);
        along[i + 1] = along[i] + cos(turn);
        rise[i + 1]  = rise[i] + sin(turn);
    }
    for (int j = 0; j < PANELS_ACROSS; j++) {
        double shift = bricks ? uniform(&r, 0, 1) : 0;
        for (int i = 0; i < PANELS_ACROSS; i++) {
            double      local[4][3], own[4][3], length = hypot(along[i + 1] - along[i], rise[i + 1] - rise[i]);
            panel_frame f = none;
            for (int k = 0; k < 4; k++) {
                int x = k == 1 || k == 2, y = k >= 2;
                memcpy(local[k], (double[]){along[i + x] + shift, j + y, rise[i + x]}, sizeof local[k]);
                panel_place(&all, local[k], p.corners[j * PANELS_ACROSS + i][k]);
                memcpy(own[k], (double[]){length * x, y, 0}, sizeof own[k]);
            }
            if (nodes) { /* from its first corner, along its sides */
                const double(*c)[3] = (const double(*)[3])p.corners[j * PANELS_ACROSS + i];
                for (int n = 0; n < 3; n++) {
                    f.origin[n]  = c[0][n];
                    f.axis[0][n] = (c[1][n] - c[0][n]) / length;
                    f.axis[1][n] = c[3][n] - c[0][n];
                }
                cross(f.axis[0], f.axis[1], f.axis[2]);
            }
            panel_add(&p, &r, nodes ? (const double(*)[3])own : (const double(*)[3])p.corners[j * PANELS_ACROSS + i], &f,
                      gap_metres / 2);
        }
    }
    panel_place(&all, (double[]){along[3] / 2 + (bricks ? 0.5 : 0), 1.5, rise[3] / 2}, p.middle);
    memcpy(p.normal, all.axis[2], sizeof p.normal);
    return p;
}

static inline void panels_free(panels *p)
{
    scene_free(&p->s);
}

/* A light that sees all panels from their front. */
static inline light_shape panels_light(const panels *p, light_kind kind, uint64_t seed)
{
    rng         r     = rng_split(seed, 78);
    light_shape shape = {.kind = kind, .outer_rad = 0.85, .range_metres = INFINITY};
    double      aside[3], far = kind == LIGHT_POINT ? 1.8 : 3;
    random_direction(&r, aside);
    for (int n = 0; n < 3; n++) {
        shape.position_ws[n]  = p->middle[n] + far * p->normal[n] + 0.3 * aside[n];
        shape.direction_ws[n] = -p->normal[n] + 0.4 * aside[n] * (kind == LIGHT_DIRECTIONAL);
    }
    make_unit(shape.direction_ws);
    return shape;
}

/* --- leaks ------------------------------------------------------------------------------------------------------------- */

/* The panels as a map sees them. */
typedef struct panel_map {
    const panels *p;
    int           seen[PANELS];
    double        sides[PANELS][4][3]; /* a u + b v + c texels inside a side */
    double        metre_px[PANELS];    /* how wide a metre is, at most */
    double        grid_px;             /* a step of the grid that vertices are moved to */
    box           bounds;              /* of all, texels */
} panel_map;

/* The sides of a panel of these corners. */
static inline void panel_sides(double sides[4][3], const double q[4][3])
{
    double area = 0;
    for (int k = 0; k < 4; k++) area += q[k][0] * q[(k + 1) % 4][1] - q[(k + 1) % 4][0] * q[k][1];
    for (int k = 0; k < 4; k++) {
        const double *a = q[k], *b = q[(k + 1) % 4];
        double        x = b[0] - a[0], y = b[1] - a[1], scale = (area < 0 ? -1 : 1) / hypot(x, y);
        sides[k][0] = -scale * y;
        sides[k][1] = scale * x;
        sides[k][2] = scale * (y * a[0] - x * a[1]);
    }
}

static inline panel_map panels_in_map(const panels *p, const vxs_light *light, int map, double grid_px)
{
    panel_map m     = {.p = p, .grid_px = grid_px, .bounds = box_empty()};
    map_frame frame = map_frame_of(light, map);
    double    side  = ldexp(1, (int)light->levels);
    int       sun   = light->kind == VXS_LIGHT_KIND_DIRECTIONAL;
    for (int n = 0; n < PANELS; n++) {
        double q[4][3];
        m.seen[n] = 1;
        for (int k = 0; k < 4; k++) {
            map_space_from_ws(&frame, p->corners[n][k], q[k]);
            double metre = 1 / (light->texel_metres * (sun ? 1 : q[k][2]));
            for (int axis = 0; axis < 2 && !sun; axis++) q[k][axis] = 0.5 * side + q[k][axis] * metre;
            if (!sun && !(q[k][2] > 0.05)) m.seen[n] = 0; /* beside the map, or behind it */
            m.metre_px[n] = fmax(m.metre_px[n], metre);
        }
        panel_sides(m.sides[n], (const double(*)[3])q);
        for (int k = 0; k < 4 && m.seen[n]; k++) box_add(&m.bounds, q[k]);
    }
    return m;
}

/* How far inside the panel of which it is most a point of the map is, texels; negative: outside of all. */
static inline double panels_inside(const panel_map *m, double u, double v, double *metre_px)
{
    double most = -INFINITY;
    for (int n = 0; n < PANELS; n++) {
        double least = m->seen[n] ? INFINITY : -INFINITY;
        for (int k = 0; k < 4; k++) least = fmin(least, m->sides[n][k][0] * u + m->sides[n][k][1] * v + m->sides[n][k][2]);
        if (least > most) most = least, *metre_px = m->metre_px[n];
    }
    return most;
}

typedef enum leak_kind { LEAK_NONE, LEAK_IN_GAP, LEAK_BESIDE_GAP, LEAK_UNEXPLAINED } leak_kind;

/* Whether a column without a caster is a leak. The rim of all panels, two texels and a millimetre
 * wide, is nobody's. */
static inline leak_kind panels_leak(const panel_map *m, double u, double v)
{
    static const double away[8][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}, {.7, .7}, {.7, -.7}, {-.7, .7}, {-.7, -.7}};
    double              metre_px = 1, other, inside = panels_inside(m, u, v, &metre_px), rim = 2 + 1e-3 * metre_px;
    if (inside < -1) return LEAK_NONE;
    for (int k = 0; k < 8; k++)
        if (panels_inside(m, u + rim * away[k][0], v + rim * away[k][1], &other) < 0) return LEAK_NONE;
    if (fabs(inside) <= m->p->gap_metres * metre_px) return LEAK_IN_GAP;
    return m->p->gap_metres > 0 && fabs(inside) <= m->p->gap_metres * metre_px + 2 * m->grid_px ? LEAK_BESIDE_GAP
                                                                                                : LEAK_UNEXPLAINED;
}

/* The leaks of one tile, at texel (u, v). */
static inline void panels_count_tile(leak_counts *sum, const panel_map *m, const column_tile *t, uint32_t depth_vx, double u,
                                     double v)
{
    int near = u + 8 > m->bounds.min[0] && u < m->bounds.max[0] && v + 8 > m->bounds.min[1] && v < m->bounds.max[1];
    for (uint32_t i = 0; i < 64; i++) {
        leak_kind leak = near && t->e[i] == depth_vx ? panels_leak(m, u + i % 8 + 0.5, v + i / 8 + 0.5) : LEAK_NONE;
        sum->columns += t->e[i] < depth_vx || leak;
        sum->in_gaps += leak == LEAK_IN_GAP;
        sum->beside_gaps += leak == LEAK_BESIDE_GAP;
        sum->unexplained += leak == LEAK_UNEXPLAINED;
    }
}

/* Count all columns of a light's maps that have casters, and leaks.
 * grid_px  a step of the source's grid
 * Returns VXS_OK or what the source returns. */
static inline vxs_result panels_count(leak_counts *sum, const panels *p, const vxs_light *light, const column_source *source,
                                      double grid_px, bake_context *ctx)
{
    vxs_result r = VXS_OK;
    for (uint32_t map = 0; map < source->map_count && r == VXS_OK; map++) {
        column_map columns;
        panel_map  m = panels_in_map(p, light, (int)map, grid_px);
        if ((r = source->open(source->data, map, &columns, ctx)) != VXS_OK) return r;
        uint32_t across = columns.side_px / columns.fetch_px, level = square_level(columns.fetch_px);
        for (uint32_t n = 0; n < across * across && r == VXS_OK; n++) {
            column_square q;
            column_tile   t;
            if ((r = columns.fetch(columns.data, level, n % across, n / across, &q, ctx)) != VXS_OK) break;
            for (uint32_t k = 0, tiles = q.side_px / 8; k < tiles * tiles && r == VXS_OK; k++) {
                r = q.tile(q.data, k % tiles, k / tiles, &t);
                if (r == VXS_OK) panels_count_tile(sum, &m, &t, q.depth_vx, q.u_px + 8 * (k % tiles), q.v_px + 8 * (k / tiles));
            }
            columns.release(columns.data, &q);
        }
        columns.close(columns.data);
    }
    return r;
}

typedef vxs_result casters_maker(casters *c, const scene *s, closed_mode closed, uint32_t threads, run_context *m);

/* Count columns and leaks of the panels that a seed makes, in a light of some kind.
 * gl    NULL: straight from triangles, else rendered
 * make  what makes casters of them */
static inline vxs_result panels_leaks(leak_counts *sum, gl_context *gl, uint64_t seed, double gap_metres, light_kind kind,
                                      casters_maker *make, uint32_t side_px, bake_context *ctx)
{
    panels         p     = panels_make(seed, gap_metres);
    light_shape    shape = panels_light(&p, kind, seed);
    light_fit_desc fit   = {.name = "light", .shape = &shape, .resolution = side_px};
    casters        c     = {0};
    vxs_light      light;
    vxs_result     r;
    if (!p.s.positions_ws) return fail(ctx->run, VXS_E_MEMORY, "out of memory");
    if ((r = make(&c, &p.s, CLOSED_AUTO, ctx->threads, ctx->run)) == VXS_OK &&
        (r = light_fit(&light, &c, &fit, ctx->run)) == VXS_OK) {
        uint32_t         fetch    = min_u32(side_px, TILE_MAX_PX);
        rendered_columns rendered = {.device = gl, .casters = &c, .light = &light, .tile_px = fetch};
        sparse_columns   sparse   = {.casters = &c, .light = &light, .fetch_px = fetch};
        column_source    source   = gl ? opengl_columns_source(&rendered) : sparse_columns_source(&sparse);
        r                         = panels_count(sum, &p, &light, &source, ldexp(1, gl ? -8 : -(int)sparse_grid(side_px)), ctx);
        opengl_columns_free(&rendered);
    }
    casters_free(&c);
    panels_free(&p);
    return r;
}

#endif
