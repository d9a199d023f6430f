/* A whole voxelized shadow volume in double, one bit after the other: what the passes of runtime/volumes/ are held to. Behind
 * fog_scene.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SHADOW_GRID_H
#define SHADOW_GRID_H

#include "fog_scene.h"
#include "runtime/volumes/vxs_shadow_grid.h"

typedef struct shadow_grid {
    vxs_epipolar  space;
    vxs_grid_size size;
    double        eye[3];
    uint32_t     *words;
} shadow_grid;

static inline vxs_epipolar_view epipolar_view_of(const fog_view *v)
{
    vxs_epipolar_view view = {.far_metres = v->far_metres};
    for (int n = 0; n < 4; n++) view_direction(v, n == 1 || n == 2 ? 1 : -1, n >= 2 ? 1 : -1, view.corners[n]);
    return view;
}

/* Where shadow begins on a light ray: metres from its begin; INFINITY: nowhere.   begin  from the eye */
static inline double ray_shadow(const shadow_depth_map *m, const double *eye, const double *begin, const double *direction)
{
    int    is_sun = m->light.kind == VXS_LIGHT_KIND_DIRECTIONAL;
    double ws[3], depth;
    size_t texel;
    for (int i = 0; i < 3; i++) ws[i] = eye[i] + begin[i] + (is_sun ? 0 : direction[i]);
    if (!shadow_depth_map_texel(m, ws, &texel, &depth) || m->first[texel] >= 1e30F) return INFINITY;
    return is_sun ? ((double)m->first[texel] - depth) * m->light.voxel_metres : (double)m->first[texel] / depth;
}

/* One bit a light ray: the column in which shadow begins on it. */
static inline void grid_fill(shadow_grid *g, const shadow_depth_map *m)
{
    memset(g->words, 0, (size_t)vxs_grid_words(&g->size) * sizeof *g->words);
    for (int row = 0; row < g->size.rows; row++)
        for (int bit = 0; bit < g->size.bits; bit++) {
            double across[3], begin[3], direction[3], turned[2], metres;
            vxs_epipolar_across(&g->space, vxs_grid_middle(g->space.theta, row, g->size.rows), across);
            vxs_epipolar_turn_of(&g->space, vxs_grid_middle(g->space.phi, bit, g->size.bits), turned);
            vxs_epipolar_light_ray(&g->space, across, turned, begin, direction);
            metres = ray_shadow(m, g->eye, begin, direction);
            if (metres == INFINITY) continue;
            int column = vxs_grid_column(&g->space, &g->size, vxs_epipolar_alpha_at(&g->space, turned, metres));
            if (column < g->size.columns) g->words[vxs_grid_word_of(&g->size, column, row, bit)] |= 1U << (bit & 31);
        }
}

/* Along rows of texels, each with what is before it. */
static inline void grid_scan(uint32_t *words, const vxs_grid_size *size)
{
    size_t rows = (size_t)vxs_grid_words(size) / (4 * (size_t)size->columns);
    for (size_t row = 0; row < rows; row++)
        for (size_t n = 4; n < 4 * (size_t)size->columns; n++) {
            uint32_t *at = words + row * 4 * (size_t)size->columns + n;
            *at |= at[-4];
        }
}

static inline shadow_grid grid_make(const shadow_depth_map *m, const fog_view *v, int columns, int rows, int bits)
{
    shadow_grid       g    = {.size = {columns, rows, bits}};
    vxs_epipolar_view view = epipolar_view_of(v);
    int               sun  = m->light.kind == VXS_LIGHT_KIND_DIRECTIONAL;
    double            to_light[3];
    memcpy(g.eye, v->eye, sizeof g.eye);
    for (int i = 0; i < 3; i++) { /* the light: what lies at 0 of light space, whose rows are of length 1 */
        to_light[i] = sun ? -m->light.direction_ws[i] : -v->eye[i];
        for (int row = 0; !sun && row < 3; row++)
            to_light[i] -= m->light.ls_from_ws[4 * row + i] * m->light.ls_from_ws[4 * row + 3];
    }
    g.space = sun ? vxs_epipolar_of_sun(to_light, &view) : vxs_epipolar_of_punctual(to_light, &view);
    if (m->light.kind == VXS_LIGHT_KIND_SPOT)
        vxs_epipolar_in_cone(&g.space, m->light.direction_ws, m->light.cos_outer, g.space.phi);
    g.words = malloc((size_t)vxs_grid_words(&g.size) * sizeof *g.words);
    assert_non_null(g.words);
    grid_fill(&g, m);
    grid_scan(g.words, &g.size);
    return g;
}

#endif
