/* Shadow grids of libvxs_volumes, made, and read back as doubles. Included behind cmocka.h and random_light.h, with
 * baker/lab/opengl/gl.h first of all.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef GRID_READ_H
#define GRID_READ_H

#include "shadow_grid.h"
#include "volumes_scene.h"

static const vxs_medium haze = {{0.03, 0.035, 0.04}, {0.04, 0.045, 0.05}, 0.4};

/* The point light off screen, in view, beside the eye, behind it; the same of the others. */
static const double eyes[][3]  = {{9, 3, 1}, {-4, 6, 9}, {0.4, 1.5, 0}, {-8, 0.5, -8}, {4, 2.6, 1}};
static const double looks[][3] = {{0, 2, 0}, {0, 1, 0}, {5, 1.6, 2}, {0.5, 2.5, -0.3}, {9, 2.5, 2.1}};
enum { CAMERAS = sizeof eyes / sizeof *eyes };

static inline void read_buffer(GLuint buffer, size_t start, size_t size, void *data)
{
    PFNGLGETNAMEDBUFFERSUBDATAPROC get = (PFNGLGETNAMEDBUFFERSUBDATAPROC)gl_choice_function("glGetNamedBufferSubData");
    get(buffer, (GLintptr)start, (GLsizeiptr)size, data);
}

static inline vxs_shadow_depth_map *filled_map(const volumes_scene *s, int light)
{
    vxs_shadow_depth_map     *map;
    vxs_shadow_depth_map_desc desc = {.baked_number = vxs_baked_number((uint32_t)light)};
    assert_int_equal(vxs_shadow_depth_map_create(&map, s->volumes, &desc), VXS_OK);
    while (vxs_shadow_depth_map_fill(map, 1 << 20)) continue;
    return map;
}

/* The same map in memory. */
static inline shadow_depth_map read_map(const volumes_scene *s, const vxs_shadow_depth_map *map, int light)
{
    shadow_depth_map m    = {.light  = vxs_asset_light(s->asset, (uint32_t)light)->light,
                             .side   = (int)vxs_shadow_depth_map_side_px(map),
                             .layers = (int)vxs_shadow_depth_map_layers(map)};
    size_t           size = sizeof(float) * (size_t)(m.side * m.side * m.layers);
    m.first               = malloc(size);
    assert_non_null(m.first);
    s->gl->GetTextureImage(vxs_shadow_depth_map_texture(map), 0, GL_RED, GL_FLOAT, (GLsizei)size, m.first);
    return m;
}

/* The grid of the last frame, as shaders had it.   eye_lit  [out] */
static inline shadow_grid read_grid(const vxs_shadow_grid *grid, const double *eye, int *eye_lit)
{
    struct {
        float   axis[4], ahead[4], side[4], alpha_theta[4], phi[4];
        int32_t size[4], eye[4], reserved[4];
    } head;
    read_buffer(vxs_shadow_grid_buffer(grid), 0, sizeof head, &head);
    shadow_grid g = {.size = {head.size[0], head.size[1], head.size[2]}};
    for (int i = 0; i < 3; i++) {
        g.space.axis[i]  = (double)head.axis[i];
        g.space.ahead[i] = (double)head.ahead[i];
        g.space.side[i]  = (double)head.side[i];
        g.eye[i]         = (double)(float)eye[i];
    }
    g.space.away = (double)head.axis[3];
    for (int i = 0; i < 2; i++) {
        g.space.alpha[i] = (double)head.alpha_theta[i];
        g.space.theta[i] = (double)head.alpha_theta[2 + i];
        g.space.phi[i]   = (double)head.phi[i];
    }
    *eye_lit = head.eye[0];
    g.words  = malloc((size_t)vxs_grid_words(&g.size) * sizeof *g.words);
    assert_non_null(g.words);
    read_buffer(vxs_shadow_grid_buffer(grid), sizeof head, (size_t)vxs_grid_words(&g.size) * sizeof *g.words, g.words);
    return g;
}

/* other_way  it is scanned in passes, and looked up between rows */
static inline vxs_shadow_grid *make_grid(const volumes_scene *s, uint32_t columns, uint32_t rows, uint32_t bits, int other_way)
{
    vxs_shadow_grid     *grid;
    vxs_shadow_grid_desc desc = {
        .columns = columns, .rows = rows, .bits = bits, .scan_in_passes = (uint32_t)other_way, .between_rows = (uint32_t)other_way};
    assert_int_equal(vxs_shadow_grid_create(&grid, s->volumes, &desc), VXS_OK);
    return grid;
}

/* In the words of a light ray, the first column in shadow: as many as are not. No column behind it is lit. */
static inline int first_column(const shadow_grid *g, int row, int bit)
{
    int first = g->size.columns;
    for (int column = g->size.columns - 1; column >= 0; column--) {
        int dark = (int)(g->words[vxs_grid_word_of(&g->size, column, row, bit)] >> (bit & 31) & 1);
        if (dark && first != column + 1) fail_msg("row %d, bit %d: light begins again behind column %d", row, bit, column);
        if (dark) first = column;
    }
    return first;
}

/* RMS of the difference over that of what is wanted.   pixels  RGBA;   wanted  RGB */
static inline double error_of(const float *pixels, const double *wanted, size_t count)
{
    double wrong = 0, size = 0;
    for (size_t n = 0; n < count; n++)
        for (size_t i = 0; i < 3; i++) {
            double w = wanted[3 * n + i], more = (double)pixels[4 * n + i] - w;
            assert_true(isfinite(pixels[4 * n + i]) && pixels[4 * n + i] >= 0);
            wrong += more * more;
            size += w * w;
        }
    return size > 0 ? sqrt(wrong / size) : wrong;
}

#endif
