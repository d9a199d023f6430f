/* A scene whose triangles are cast into shadow grids, lights without their assets, and grids that cast. Included behind cmocka.h
 * and random_light.h, with baker/lab/opengl/gl.h first of all.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CASTING_H
#define CASTING_H

#include "grid_read.h"

enum { WIDE = 32, HIGH = 24, PIXELS = WIDE * HIGH, BOX_TRIANGLES = 12 * SCENE_BOXES };

static const float identity[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

static inline vxs_shadow_grid *casting_grid(const volumes_scene *s, uint32_t columns, uint32_t rows, uint32_t bits)
{
    vxs_shadow_grid     *grid;
    vxs_shadow_grid_desc desc = {.columns = columns, .rows = rows, .bits = bits, .casts = 1};
    assert_int_equal(vxs_shadow_grid_create(&grid, s->volumes, &desc), VXS_OK);
    return grid;
}

/* One scene and grid for all tests, opened by the first. */
static volumes_scene    scene;
static vxs_shadow_grid *shared_grid;

static inline const volumes_scene *opened(void)
{
    if (scene.volumes) return &scene;
    scene_open(&scene, 64, WIDE, HIGH);
    shared_grid = casting_grid(&scene, 64, 48, 130);
    return &scene;
}

static inline int close_scene(void **state)
{
    (void)state;
    vxs_shadow_grid_destroy(shared_grid);
    if (scene.volumes) scene_close(&scene);
    return 0;
}

static inline GLuint buffer_of(const volumes_scene *s, const void *data, size_t size)
{
    GLuint buffer;
    s->gl->GenBuffers(1, &buffer);
    s->gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, buffer);
    s->gl->BufferData(GL_SHADER_STORAGE_BUFFER, (GLsizeiptr)size, data, GL_STATIC_DRAW);
    return buffer;
}

/* Triangles in memory. */
typedef struct triangles {
    const float    *places;
    uint32_t        place_count;
    const uint32_t *corners;
    uint32_t        count;
} triangles;

/* The scene's own; its boxes alone are closed. */
static inline triangles scene_triangles(uint32_t count)
{
    return (triangles){scene.positions, 8 * SCENE_BOXES + 4, scene.indices, count};
}

/* Places lie apart in their buffer, and not at its begin. */
static inline vxs_casters casters_of(const volumes_scene *s, triangles t, vxs_voxels kind)
{
    enum { FIRST = 2, WORDS = 5 };
    size_t      size = sizeof(float) * (FIRST + WORDS * t.place_count);
    float      *laid = calloc(1, size);
    vxs_casters c    = {.first_word = FIRST, .place_words = WORDS, .triangle_count = t.count, .kind = kind};
    assert_non_null(laid);
    for (uint32_t n = 0; n < t.place_count; n++) memcpy(laid + FIRST + WORDS * n, t.places + 3 * n, 3 * sizeof *laid);
    c.places  = buffer_of(s, laid, size);
    c.corners = buffer_of(s, t.corners, 3 * t.count * sizeof *t.corners);
    free(laid);
    memcpy(c.point_from_place, identity, sizeof identity);
    return c;
}

/* A light without its asset: triangles alone. */
static inline vxs_volumes_light bare_light(const volumes_scene *s, int light)
{
    vxs_volumes_light l = scene_light(light);
    l.constants         = &vxs_gl_constants(s->shadows)[light];
    return l;
}

#endif
