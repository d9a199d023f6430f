/* Depth maps for engines; see export_depth.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/command/export_depth.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/portable_math.h"
#include "baker/files/json_file.h"
#include "baker/files/png_rows.h"
#include "baker/light/map_space.h"
#include "runtime/vxs_query.h"

void export_turn(double *rows, int row_count, export_axes axes)
{
    for (double *row = rows; row < rows + 4 * row_count; row += 4) {
        double x = row[0], y = row[1], z = row[2];
        if (axes == EXPORT_UNITY) row[0] = -x;
        if (axes == EXPORT_UNREAL) row[0] = 0.01 * x, row[1] = 0.01 * z, row[2] = 0.01 * y;
    }
}

json_t *export_numbers(const double *numbers, int count)
{
    json_t *array = json_array();
    for (int n = 0; n < count; n++) json_append(&array, json_real(numbers[n]));
    return array;
}

/* matrices --------------------------------------------------------------------------------------------------------------------- */

/* Depth of a perspective map at z metres along its axis: a + b / z. Zero for a directional light. */
typedef struct perspective {
    double near, far, a, b;
} perspective;

static int is_perspective(const vxs_light *l)
{
    return l->kind != VXS_LIGHT_KIND_DIRECTIONAL;
}

static perspective perspective_of(const vxs_light *l)
{
    if (!is_perspective(l)) return (perspective){0};
    perspective p = {.near = l->near_metres, .far = l->near_metres * portable_exp(ldexp(l->voxel_metres, (int)l->levels))};
    p.a           = p.far / (p.far - p.near);
    p.b           = -p.near * p.a;
    return p;
}

/* out = x a + y b */
static void add_rows(double out[4], double x, const double a[4], double y, const double b[4])
{
    for (int n = 0; n < 4; n++) out[n] = x * a[n] + y * b[n];
}

/* From glTF's world to u, v and depth in [0, 1], homogeneous: u along a row of the map, v from its first row to its last. */
static void uvd_from_ws(double rows[16], const vxs_light *l, int map)
{
    static const double one[4] = {0, 0, 0, 1};
    const map_frame     f      = map_frame_of(l, map);
    double              side   = ldexp(1, (int)l->levels), along[4];
    add_rows(along, f.unit, f.rows[2], 0, one);
    if (!is_perspective(l)) {
        add_rows(rows, 1 / side, f.rows[0], 0, one);
        add_rows(rows + 4, 1 / side, f.rows[1], 0, one);
        memcpy(rows + 8, along, sizeof along);
        memcpy(rows + 12, one, sizeof one);
        return;
    }
    perspective p = perspective_of(l);
    add_rows(rows, 1 / (side * l->texel_metres), f.rows[0], 0.5, along);
    add_rows(rows + 4, 1 / (side * l->texel_metres), f.rows[1], 0.5, along);
    add_rows(rows + 8, p.a, along, p.b, one);
    memcpy(rows + 12, along, sizeof along);
}

/* The matrix to u, v, depth, and those to clip space: x and y from -1 to 1, and z from -1 or 0 to 1. NULL without memory. */
static json_t *matrices_json(const vxs_light *l, int map, export_axes axes)
{
    double uvd[16], clip[16];
    uvd_from_ws(uvd, l, map);
    export_turn(uvd, 4, axes);
    const double *u = uvd, *v = uvd + 4, *d = uvd + 8, *w = uvd + 12;
    json_t       *json = json_object();
    json_set(&json, "uvd", export_numbers(uvd, 16));

    memcpy(clip, uvd, sizeof clip);
    add_rows(clip, 2, u, -1, w);
    add_rows(clip + 4, 2, v, -1, w);
    json_set(&json, "vulkan", export_numbers(clip, 16));
    add_rows(clip + 4, -2, v, 1, w);
    json_set(&json, "d3d", export_numbers(clip, 16));
    add_rows(clip + 4, 2, v, -1, w);
    add_rows(clip + 8, 2, d, -1, w);
    json_set(&json, "opengl", export_numbers(clip, 16));
    return json;
}

/* depths ----------------------------------------------------------------------------------------------------------------------- */

enum { BAND_TEXELS = 1 << 20 };

typedef struct depth_writer {
    const vxs_baked_light *baked;
    int                    map;
    uint32_t               side_px, shift;
    float                 *depth_of; /* [2^levels + 1] by the first voxel in shadow */
    uint32_t              *voxels;   /* [BAND_TEXELS, or side_px where that is more] */
    float                 *depths;   /* the same */
    output_file            out;
    png_rows              *png; /* NULL: raw */
} depth_writer;

/* Depths at the near side of each voxel; of a texel without shadow, which has the last, it is 1. */
static void fill_depths(depth_writer *w)
{
    const vxs_light *l      = &w->baked->light;
    uint32_t         voxels = 1u << l->levels;
    perspective      p      = perspective_of(l);
    for (uint32_t k = 0; k < voxels; k++)
        w->depth_of[k] = (float)(is_perspective(l) ? p.a + p.b / (p.near * portable_exp(k * l->voxel_metres)) : (double)k / voxels);
    w->depth_of[voxels] = 1;
}

static vxs_result write_band(depth_writer *w, uint32_t row, uint32_t rows, run_context *m)
{
    size_t             count = (size_t)rows * w->side_px;
    vxs_depth_map_desc desc  = {.struct_size = sizeof desc,
                                .map         = w->map,
                                .j           = (int32_t)(row << w->shift),
                                .wide_px     = w->side_px,
                                .high_px     = rows,
                                .shift       = w->shift,
                                .which       = VXS_DEPTH_CENTRE,
                                .voxels      = w->voxels};
    vxs_depth_map(w->baked, &desc, NULL);
    for (size_t n = 0; n < count; n++) w->depths[n] = w->depth_of[w->voxels[n]];
    return w->png ? png_rows_write(w->png, w->depths, rows, m) : output_file_write(&w->out, w->depths, 4 * count, m);
}

static vxs_result write_map(depth_writer *w, const char *folder, const char *name, export_format format, run_context *m)
{
    size_t   texels = (size_t)w->side_px > BAND_TEXELS ? w->side_px : BAND_TEXELS;
    uint32_t band   = (uint32_t)(texels / w->side_px);
    w->depth_of     = malloc((((size_t)1 << w->baked->light.levels) + 1) * sizeof *w->depth_of);
    w->voxels       = malloc(texels * sizeof *w->voxels);
    w->depths       = malloc(texels * sizeof *w->depths);
    if (!w->depth_of || !w->voxels || !w->depths) return fail(m, VXS_E_MEMORY, "out of memory for %s", name);
    fill_depths(w);
    vxs_result r = output_file_open_in_folder(&w->out, "-o", folder, name, m);
    if (r == VXS_OK && format == EXPORT_PNG) r = png_rows_open(&w->png, &w->out, w->side_px, w->side_px, m);
    for (uint32_t row = 0; row < w->side_px && r == VXS_OK; row += band)
        r = write_band(w, row, band < w->side_px - row ? band : w->side_px - row, m);
    if (r == VXS_OK && w->png) r = png_rows_end(w->png, m);
    return r == VXS_OK ? output_file_commit(&w->out, m) : r;
}

vxs_result export_depth_map(json_t **entry, const char *folder, const vxs_baked_light *baked, uint32_t number, int map,
                            const export_depth *depth, export_axes axes, run_context *m)
{
    const vxs_light *l = &baked->light;
    char             name[64];
    depth_writer     w = {.baked = baked, .map = map, .side_px = 1u << l->levels};
    for (; w.side_px > depth->resolution_px; w.side_px /= 2) w.shift++;
    snprintf(name, sizeof name, "depth-%u-%d.%s", number, map, depth->format == EXPORT_PNG ? "png" : "f32");
    vxs_result r = write_map(&w, folder, name, depth->format, m);
    png_rows_free(w.png);
    output_file_abort(&w.out);
    free(w.depth_of);
    free(w.voxels);
    free(w.depths);
    if (r != VXS_OK) return r;

    *entry = json_object();
    json_set(entry, "file", json_string(name));
    json_set(entry, "resolution_px", json_integer((json_int_t)w.side_px));
    json_set(entry, "texel_m", json_real(ldexp(l->texel_metres, (int)w.shift)));
    json_set(entry, "matrices", matrices_json(l, map, axes));
    return *entry ? VXS_OK : fail(m, VXS_E_MEMORY, "out of memory for the description of %s", name);
}
