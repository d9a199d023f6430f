/* Voxelized shadow volumes; see vxs_volumes.h. The grid is one storage buffer: a head (grid.glsl), then words as in
 * vxs_shadow_grid.h. For each light of each frame it is cleared, filled with a bit for each light ray, scanned along alpha, and
 * looked up.
 * SPDX-License-Identifier: MIT */
#include <math.h>

#include "grid_head.h"
#include "or_scan.h"
#include "voxelize.h"
#include "vxs_desc.h"

enum { COLUMNS = 512, ROWS = 2048, BITS = 512, SIDE_MAX = 16384, RUNS = 16, RUNS_SHARP = 32 };

/* Inside a punctual light's radius, airlight is that of a ray that passes it at its radius. From near the light, this airlight
 * comes from points at small angles. So an eye nearer than this part of the radius uses the grid of an eye moved out to that
 * distance, on the same light ray; the same casters shadow both. An eye practically at the light sees along light rays: all that
 * it sees is lit. */
#define EYE_NEAREST  0.25
#define EYE_IN_LIGHT 1e-3

struct vxs_shadow_grid {
    vxs_volumes  *volumes;
    vxs_grid_size size;
    gl_name       buffer;
    or_scan       scan;
    int           between_rows, casts;
};

static uint64_t bytes_of(const vxs_grid_size *size)
{
    uint64_t layers = ((uint64_t)size->bits + 127) / 128;
    return sizeof(grid_head) + 16 * layers * (uint64_t)size->columns * (uint64_t)size->rows;
}

static vxs_result make(vxs_shadow_grid *grid, const vxs_shadow_grid_desc *desc)
{
    vxs_volumes *v      = grid->volumes;
    vxs_result   result = vxs_or_scan_create(&grid->scan, v, desc->scan_in_passes ? bytes_of(&grid->size) : 0);
    if (result != VXS_OK) return result;
    grid->buffer = vxs_volumes_buffer(v, bytes_of(&grid->size));
    return grid->buffer ? VXS_OK : VXS_E_MEMORY;
}

vxs_result vxs_shadow_grid_create(vxs_shadow_grid **out, vxs_volumes *v, const vxs_shadow_grid_desc *desc)
{
    vxs_shadow_grid_desc known = {0};
    const size_t         first = offsetof(vxs_shadow_grid_desc, between_rows) + sizeof known.between_rows;
    int                  most  = 0;
    *out                       = NULL;
    if (vxs_desc_take(&known, sizeof known, first, desc) != VXS_OK) return VXS_E_ARGUMENT;
    if (known.columns > SIDE_MAX || known.rows > SIDE_MAX || known.bits > SIDE_MAX) return VXS_E_ARGUMENT;
    vxs_grid_size size = {known.columns ? (int)known.columns : COLUMNS, known.rows ? (int)known.rows : ROWS,
                          known.bits ? (int)known.bits : BITS};
    v->api.GetIntegerv(GL_MOST_STORAGE_BYTES, &most);
    if (bytes_of(&size) > (uint32_t)most || bytes_of(&size) > INT32_MAX)
        return vxs_volumes_fail(v, VXS_E_GL,
                                "a grid is larger than a storage buffer of this context: use fewer columns, rows or bits");
    vxs_shadow_grid *grid = vxs_volumes_alloc(v, sizeof *grid);
    if (!grid) return VXS_E_MEMORY;
    *grid = (vxs_shadow_grid){.volumes = v, .size = size, .between_rows = known.between_rows != 0, .casts = known.casts != 0};
    vxs_result result = make(grid, &known);
    if (result != VXS_OK) {
        vxs_shadow_grid_destroy(grid);
        return result;
    }
    *out = grid;
    return VXS_OK;
}

void vxs_shadow_grid_destroy(vxs_shadow_grid *grid)
{
    if (!grid) return;
    const vxs_volumes *v = grid->volumes;
    if (grid->buffer) v->api.DeleteBuffers(1, &grid->buffer);
    vxs_or_scan_destroy(&grid->scan);
    vxs_volumes_free(v, grid, sizeof *grid);
}

unsigned vxs_shadow_grid_buffer(const vxs_shadow_grid *grid)
{
    return grid->buffer;
}

uint32_t vxs_shadow_grid_cut(const vxs_shadow_grid *grid)
{
    grid_head head;
    grid->volumes->api.GetNamedBufferSubData(grid->buffer, 0, sizeof head, &head);
    return head.cut[0];
}

static vxs_epipolar space_of(const frame_block *f)
{
    int               is_sun = f->light.kind == VXS_LIGHT_KIND_DIRECTIONAL;
    double            to_light[3], axis[3];
    vxs_epipolar_view view = vxs_grid_view_of(f);
    for (int n = 0; n < 3; n++) {
        to_light[n] = (double)f->place[n] - (is_sun ? 0 : (double)f->eye[n]);
        axis[n]     = (double)f->axis[n];
    }
    if (is_sun) return vxs_epipolar_of_sun(to_light, &view);
    double range = (double)f->light.range_metres, away = sqrt(vxs_air_dot(to_light, to_light)), radius = (double)f->radius_metres;
    double out = away > EYE_IN_LIGHT * radius ? fmax(EYE_NEAREST * radius / away, 1) : 1;
    for (int n = 0; n < 3; n++) to_light[n] *= out;
    away *= out;
    if (range > 0 && away + range < view.far_metres) view.far_metres = away + range;
    vxs_epipolar space = vxs_epipolar_of_punctual(to_light, &view);
    if (f->light.kind != VXS_LIGHT_KIND_POINT) vxs_epipolar_in_cone(&space, axis, (double)f->light.cos_outer, space.phi);
    return space;
}

/* Upload the head, with the eye lit, and clear all bits. */
static void put_head(const vxs_shadow_grid *grid, const vxs_epipolar *space, uint32_t runs)
{
    const vxs_volumes *v    = grid->volumes;
    grid_head          head = vxs_grid_head_of(space, &grid->size, runs);
    head.between_rows       = grid->between_rows;
    head.eye_lit            = head.away > 0 && head.away <= (float)EYE_IN_LIGHT * v->frame.radius_metres ? 2 : 1;
    vxs_volumes_put(v, grid->buffer, 0, sizeof head, &head);
    v->api.ClearNamedBufferSubData(grid->buffer, GL_FORMAT_R32UI, sizeof head, (gl_bytes)(bytes_of(&grid->size) - sizeof head),
                                   GL_FORMAT_RED_INTEGER, GL_TYPE_UNSIGNED_INT, NULL);
}

/* Whether the middle of a run does not represent what the run scatters: with a sharp phase function, or a sharp rim of a cone. */
static int is_sharp(const frame_block *f)
{
    return f->anisotropy >= 0.7F || (f->light.kind == VXS_LIGHT_KIND_SPOT && f->cos_inner - f->light.cos_outer < 0.05F);
}

static uint32_t groups(uint32_t count, uint32_t each)
{
    return (count + each - 1) / each;
}

/* map  a texture; 0: looks the asset up */
static void fill(const vxs_shadow_grid *grid, gl_name map)
{
    enum { BITS_ACROSS = 32, ROWS_DOWN = 4 };
    const char *names = map ? NULL : "#define VXS_ASK_ASSET\n";
    gl_name     program =
        vxs_volumes_light_program(grid->volumes, &(program_texts){.names = names, .body = &vxs_volumes_text_grid_fill_glsl});
    vxs_volumes_use_storage(grid->volumes, grid->buffer, 0);
    vxs_volumes_run(grid->volumes, program, map, 0, groups((uint32_t)grid->size.bits, BITS_ACROSS),
                    groups((uint32_t)grid->size.rows, ROWS_DOWN));
}

/* Solid casters come first, because they change bits. The part of them between the light and the first column is not visible in
 * the grid; light rays find it. */
static void cast(const vxs_shadow_grid *grid, const vxs_epipolar *space, const vxs_casters *casters, uint32_t count)
{
    vxs_volumes *v   = grid->volumes;
    uint32_t     all = (uint32_t)grid->size.columns;
    vxs_voxelize(v, grid->buffer, space, casters, count, VXS_VOXELS_SOLID, VXS_VOXELS_SOLID, all);
    vxs_voxelize(v, grid->buffer, space, casters, count, VXS_VOXELS_SOLID, VXS_VOXELS_RAYS, 1);
    vxs_voxelize(v, grid->buffer, space, casters, count, VXS_VOXELS_RAYS, VXS_VOXELS_RAYS, all);
    vxs_voxelize(v, grid->buffer, space, casters, count, VXS_VOXELS_COVERED, VXS_VOXELS_COVERED, all);
}

/* with_map  1: static shadow comes from `map`, or, if that is 0, from the asset */
static void make_grid(vxs_shadow_grid *grid, int with_map, gl_name map, uint32_t runs, const vxs_casters *casters, uint32_t count)
{
    vxs_epipolar space = space_of(&grid->volumes->frame);
    uint32_t     rows = (uint32_t)grid->size.rows, layers = groups((uint32_t)grid->size.bits, 128);
    put_head(grid, &space, runs);
    if (count) cast(grid, &space, casters, count);
    if (with_map) fill(grid, map);
    vxs_or_scan_run(&grid->scan, grid->buffer, HEAD_TEXELS, (uint32_t)grid->size.columns, rows * layers);
}

void vxs_shadow_grid_make(vxs_shadow_grid *grid, gl_name map, uint32_t runs)
{
    make_grid(grid, 1, map, runs, NULL, 0);
}

vxs_result vxs_volumes_grid_cast(vxs_volumes *v, const vxs_volumes_light *light, const vxs_shadow_depth_map *map,
                                 vxs_shadow_grid *grid, uint32_t runs, const vxs_casters *casters, uint32_t count)
{
    int is_alone = !map && light->constants;
    if (light->smoke || runs > SIDE_MAX || (is_alone && !count) || (count && !grid->casts)) return VXS_E_ARGUMENT;
    if (!vxs_are_casters(casters, count, &grid->size)) return VXS_E_ARGUMENT;
    vxs_result result = vxs_volumes_set_light(v, light, map);
    if (result != VXS_OK) return result;
    if (!map) v->frame.map_side_px = 1U << v->frame.light.levels; /* the asset is looked up like a map with its own texels */
    if (!runs) runs = is_sharp(&v->frame) ? RUNS_SHARP : RUNS;
    if (vxs_volumes_find_cull_result(v, &v->frame.pixels) != VXS_NOT_CULLED) return VXS_OK;
    saved_storage saved = vxs_volumes_save_storage(v);
    make_grid(grid, !is_alone, map ? vxs_shadow_depth_map_texture(map) : 0, runs, casters, count);
    vxs_volumes_use_storage(v, grid->buffer, 0);
    gl_name look_up = vxs_volumes_light_program(
        v, &(program_texts){.names = "#define VXS_GRID_ACCESS readonly\n", .body = &vxs_volumes_text_grid_light_glsl});
    vxs_volumes_add(v, look_up, 0);
    vxs_volumes_restore_storage(v, &saved);
    return vxs_volumes_done(v);
}

vxs_result vxs_volumes_grid(vxs_volumes *v, const vxs_volumes_light *light, const vxs_shadow_depth_map *map, vxs_shadow_grid *grid,
                            uint32_t runs)
{
    return vxs_volumes_grid_cast(v, light, map, grid, runs, NULL, 0);
}
