/* Every technique of fog and every rival, each with the values of its knob; see volumes_bench.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "tests/bench/volumes_bench.h"

#include <stdlib.h>

#include "baker/lab/render/fog_pass.h"
#include "tests/volumes/rival_froxels.h"
#include "tests/volumes/rival_slices.h"

static vxs_result even_of_map(bench *b, void *state, uint32_t steps)
{
    (void)state;
    return vxs_volumes_march(b->volumes, &b->light, b->map, steps, VXS_STEPS_EVEN);
}

static vxs_result angles_of_map(bench *b, void *state, uint32_t steps)
{
    (void)state;
    return vxs_volumes_march(b->volumes, &b->light, b->map, steps, VXS_STEPS_EQUIANGULAR);
}

static vxs_result angles_of_asset(bench *b, void *state, uint32_t steps)
{
    (void)state;
    return vxs_volumes_march(b->volumes, &b->light, NULL, steps, VXS_STEPS_EQUIANGULAR);
}

static vxs_result intervals(bench *b, void *state, uint32_t value)
{
    (void)state;
    (void)value;
    return vxs_volumes_intervals(b->volumes, &b->light);
}

/* The same with a ray for 2 x 2 pixels. */
static vxs_result at_half(bench *b, technique_step *draw, uint32_t value)
{
    vxs_result r = vxs_volumes_begin_half(b->volumes);
    if (r == VXS_OK) r = draw(b, NULL, value);
    return r == VXS_OK ? vxs_volumes_end_half(b->volumes) : r;
}

static vxs_result half_angles_of_map(bench *b, void *state, uint32_t steps)
{
    (void)state;
    return at_half(b, angles_of_map, steps);
}

static vxs_result half_intervals(bench *b, void *state, uint32_t value)
{
    (void)state;
    return at_half(b, intervals, value);
}

/* A mesh of the shadow depth map, made once; quads are as large as so many texels' width of error lets them be. */
static vxs_result open_mesh(bench *b, void **state, uint32_t error_texels)
{
    const baked_mesh_options o = {.light = b->number, .far_metres = b->far_metres, .error_texels = error_texels};
    run_context              m = {0};
    return baked_mesh_make((vxs_light_mesh **)state, &o, b->gl, b->shadows, b->volumes, &m);
}

static vxs_result mesh(bench *b, void *mesh, uint32_t value)
{
    (void)value;
    return vxs_volumes_mesh(b->volumes, &b->light, mesh);
}

static void close_mesh(void *mesh)
{
    vxs_light_mesh_destroy(mesh);
}

/* A mesh that is made where it is drawn, of a map of so many texels a side. */
static vxs_result open_map(bench *b, void **state, uint32_t side_px)
{
    return volumes_open_map(b, b->number, side_px, (vxs_shadow_depth_map **)state);
}

static vxs_result mesh_of_map(bench *b, void *map, uint32_t value)
{
    (void)value;
    return vxs_volumes_mesh_map(b->volumes, &b->light, map);
}

static void close_map(void *map)
{
    vxs_shadow_depth_map_destroy(map);
}

/* A mesh that shaders make in each frame, of the map that the march reads, with quads as large as so many texels' width of error
 * lets them be. */
static vxs_result open_adaptive(bench *b, void **state, uint32_t error_texels)
{
    vxs_adaptive_mesh_desc desc = {.side_px = vxs_shadow_depth_map_side_px(b->map), .layers = vxs_shadow_depth_map_layers(b->map)};
    (void)error_texels;
    return vxs_adaptive_mesh_create((vxs_adaptive_mesh **)state, b->volumes, &desc);
}

static vxs_result adaptive_mesh(bench *b, void *mesh, uint32_t error_texels)
{
    return vxs_volumes_mesh_adaptive(b->volumes, &b->light, b->map, mesh, (float)error_texels);
}

static void close_adaptive(void *mesh)
{
    vxs_adaptive_mesh_destroy(mesh);
}

/* The grid of n x 2n x n bits, filled of the map, or of the asset without one. */
static vxs_result open_grid(bench *b, void **state, uint32_t size)
{
    vxs_shadow_grid_desc desc = {.columns = size, .rows = 2 * size, .bits = size};
    return vxs_shadow_grid_create((vxs_shadow_grid **)state, b->volumes, &desc);
}

static vxs_result grid_of_map(bench *b, void *grid, uint32_t size)
{
    (void)size;
    return vxs_volumes_grid(b->volumes, &b->light, b->map, grid, 0);
}

static vxs_result grid_of_asset(bench *b, void *grid, uint32_t size)
{
    (void)size;
    return vxs_volumes_grid(b->volumes, &b->light, NULL, grid, 0);
}

/* Rays between two rows. */
static vxs_result open_rows(bench *b, void **state, uint32_t size)
{
    vxs_shadow_grid_desc desc = {.columns = size, .rows = 2 * size, .bits = size, .between_rows = 1};
    return vxs_shadow_grid_create((vxs_shadow_grid **)state, b->volumes, &desc);
}

static void close_grid(void *grid)
{
    vxs_shadow_grid_destroy(grid);
}

/* A grid of the scene's triangles, without map and asset. */
typedef struct cast_grid {
    bench           *b;
    vxs_shadow_grid *grid;
    vxs_casters      casters;
    GLuint           buffers[2];
} cast_grid;

/* Places count from the first camera, as the asset's do. */
static vxs_result upload_triangles(cast_grid *c)
{
    const gl_context *gl    = c->b->gl;
    const casters    *from  = &c->b->casting;
    size_t            count = 3 * from->vertex_count;
    float            *laid  = volumes_casters_from_eye(c->b);
    if (!laid) return VXS_E_MEMORY;
    gl->GenBuffers(2, c->buffers);
    gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, c->buffers[0]);
    gl->BufferData(GL_SHADER_STORAGE_BUFFER, (GLsizeiptr)(count * sizeof *laid), laid, GL_STATIC_DRAW);
    gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, c->buffers[1]);
    gl->BufferData(GL_SHADER_STORAGE_BUFFER, (GLsizeiptr)(3 * from->triangle_count * sizeof *from->indices), from->indices,
                   GL_STATIC_DRAW);
    free(laid);
    c->casters = (vxs_casters){.places           = c->buffers[0],
                               .corners          = c->buffers[1],
                               .triangle_count   = (uint32_t)from->triangle_count,
                               .point_from_place = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}};
    return VXS_OK;
}

static vxs_result open_cast(bench *b, void **state, uint32_t size)
{
    vxs_shadow_grid_desc desc = {.columns = size, .rows = 2 * size, .bits = size, .casts = 1};
    cast_grid           *c    = calloc(1, sizeof *c);
    if (!c) return VXS_E_MEMORY;
    *state       = c;
    c->b         = b;
    vxs_result r = upload_triangles(c);
    return r == VXS_OK ? vxs_shadow_grid_create(&c->grid, b->volumes, &desc) : r;
}

static vxs_result grid_of_triangles(bench *b, void *state, uint32_t size)
{
    const cast_grid  *c    = state;
    vxs_volumes_light bare = b->light;
    bare.constants         = &vxs_gl_constants(b->shadows)[b->number];
    (void)size;
    return vxs_volumes_grid_cast(b->volumes, &bare, NULL, c->grid, 0, &c->casters, 1);
}

static void close_cast(void *state)
{
    cast_grid *c = state;
    if (!c) return;
    vxs_shadow_grid_destroy(c->grid);
    c->b->gl->DeleteBuffers(2, c->buffers);
    free(c);
}

/* Columns of 8 x 8 pixels, as engines have it, and so many slices. */
static vxs_result open_froxels(bench *b, void **state, uint32_t deep)
{
    return rival_froxels_create((rival_froxels **)state, b->volumes, (b->width + 7) / 8, (b->height + 7) / 8, deep);
}

static vxs_result froxels_of_map(bench *b, void *froxels, uint32_t deep)
{
    (void)deep;
    return rival_froxels_add(froxels, &b->light, b->map);
}

static void close_froxels(void *froxels)
{
    rival_froxels_destroy(froxels);
}

/* Twice as many bins as slices, and as many samples. */
static vxs_result open_slices(bench *b, void **state, uint32_t slices)
{
    return rival_slices_create((rival_slices **)state, b->volumes, slices, 2 * slices, slices);
}

/* At 256 slices, so many questions a ray. */
static vxs_result open_moments(bench *b, void **state, uint32_t parts)
{
    vxs_result r = open_slices(b, state, 256);
    return r == VXS_OK ? rival_slices_set_moments(*state, parts) : r;
}

static vxs_result slices_of_map(bench *b, void *slices, uint32_t count)
{
    (void)count;
    return rival_slices_add(slices, &b->light, b->map);
}

static void close_slices(void *slices)
{
    rival_slices_destroy(slices);
}

#define SHADOW_DEPTH_MAP "the shadow depth map, traversed exactly"
#define ASSET            "exact lit intervals of the asset"

/* clang-format off */
static const technique techniques[] = {
    {"march", "steps", SHADOW_DEPTH_MAP, 0, {8, 16, 32, 64, 128, 256, 512}, NULL, even_of_map, .close = NULL},
    {"angles", "steps", SHADOW_DEPTH_MAP, 0, {8, 16, 32, 64, 128, 256, 512}, NULL, angles_of_map, .close = NULL},
    {"angles, asset", "steps", ASSET, 0, {16, 64, 256}, NULL, angles_of_asset, .close = NULL},
    {"intervals", "-", "floats", 0, {1}, NULL, intervals, .close = NULL},
    {"angles, half", "steps", "rays of 2 x 2 pixels", 0, {16, 64, 256}, NULL, half_angles_of_map, .close = NULL},
    {"intervals, half", "-", "rays of 2 x 2 pixels", 0, {1}, NULL, half_intervals, .close = NULL},
    {"mesh", "texels of error", "the map's surface, whose steps are slopes of a texel", 0, {16, 4, 1}, open_mesh, mesh, .close = close_mesh},
    {"mesh of the map", "texels a side", "the same surface", 0, {64, 256, 1024}, open_map, mesh_of_map, .close = close_map},
    {"adaptive mesh", "texels of error", "the same surface", 0, {16, 4, 1}, open_adaptive, adaptive_mesh, .close = close_adaptive},
    {"grid", "bits a side", SHADOW_DEPTH_MAP, 0, {64, 128, 256, 512}, open_grid, grid_of_map, .close = close_grid},
    {"grid, two rows", "bits a side", SHADOW_DEPTH_MAP, 0, {64, 128, 256, 512}, open_rows, grid_of_map, .close = close_grid},
    {"grid, asset", "bits a side", ASSET, 0, {64, 128, 256}, open_grid, grid_of_asset, .close = close_grid},
    {"grid, triangles", "bits a side", "the triangles, exactly", 0, {64, 128, 256, 512}, open_cast, grid_of_triangles, .close = close_cast},
    {"froxels", "slices", "columns of 8 x 8 pixels", 1, {16, 64, 256, 1024}, open_froxels, froxels_of_map, .close = close_froxels},
    {"moments", "parts a ray", "256 slices of 512 bins", 1, {1, 4, 16, 64}, open_moments, slices_of_map, .close = close_slices},
    {"min-max slices", "slices", SHADOW_DEPTH_MAP, 1, {64, 128, 256, 512}, open_slices, slices_of_map, .close = close_slices},
};
/* clang-format on */

void volumes_use_techniques(bench *b)
{
    b->techniques      = techniques;
    b->technique_count = sizeof techniques / sizeof *techniques;
}
