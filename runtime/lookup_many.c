/* Lookups of many points; see vxs_query.h. Points are taken 64 at a time: their coordinates side by side, then their voxels, then the taps.
 * SPDX-License-Identifier: MIT */
#include <string.h>

#include "point_lanes.h"
#include "taps_many.h"
#include "vxs_desc.h"
#include "vxs_query.h"

enum { CHUNK = 64 };

/* Coordinates of some points, or normals: all x, all y, all z. */
typedef struct coordinates {
    double at[3][CHUNK];
} coordinates;

/* Their voxels, as vxs_voxel has them. */
typedef struct voxels {
    int32_t at[3][CHUNK], map[CHUNK];
} voxels;

static void read_doubles(const char *bytes, size_t stride, size_t count, coordinates *out)
{
    for (size_t n = 0; n < count; n++, bytes += stride)
        for (size_t axis = 0; axis < 3; axis++) memcpy(&out->at[axis][n], bytes + axis * sizeof(double), sizeof(double));
}

static void read_floats(const char *bytes, size_t stride, size_t count, coordinates *out)
{
    for (size_t n = 0; n < count; n++, bytes += stride) {
        float point[3];
        memcpy(point, bytes, sizeof point);
        for (int axis = 0; axis < 3; axis++) out->at[axis][n] = point[axis];
    }
}

static void read_vectors(const vxs_vectors *v, size_t first, size_t count, coordinates *out)
{
    size_t size = v->type == VXS_F32 ? sizeof(float) : sizeof(double), stride = v->stride_bytes ? v->stride_bytes : 3 * size;
    (v->type == VXS_F32 ? read_floats : read_doubles)((const char *)v->data + first * stride, stride, count, out);
}

/* world to voxel ---------------------------------------------------------------------------------------------------------------- */

/* The voxel of one of them, as a lookup finds it. */
static void find_voxel(const vxs_light *light, const coordinates *points, const coordinates *normals, size_t n, int filter_px,
                       voxels *out)
{
    double  point[3], normal[3];
    int32_t voxel[3];
    for (int axis = 0; axis < 3; axis++) {
        point[axis]  = points->at[axis][n];
        normal[axis] = normals ? normals->at[axis][n] : 0;
    }
    out->map[n] = vxs_voxel_from_ws(light, point, normal, filter_px, voxel);
    for (int axis = 0; axis < 3; axis++) out->at[axis][n] = voxel[axis];
}

/* A row of the matrix and points, or directions (one = 0), in the order of vxs_ls_coordinate. */
static inline vxs_lanes times_row(const double *m, const coordinates *c, int n, double one)
{
    return vxs_lanes_of(m[0]) * vxs_load(c->at[0] + n) + vxs_lanes_of(m[1]) * vxs_load(c->at[1] + n) +
           vxs_lanes_of(m[2]) * vxs_load(c->at[2] + n) + vxs_lanes_of(m[3] * one);
}

/* Coordinate `row` of a directional light's voxels, as vxs_sun_coordinate has it. Returns 0 when some are so great that it would clamp
 * them, or are no numbers: then none of `out` counts. */
static int find_coordinates(const vxs_light *light, int row, const coordinates *points, const coordinates *normals, int filter_px,
                            int32_t *out)
{
    const vxs_lanes noise = vxs_lanes_of(VXS_STEP_NOISE), limit = vxs_lanes_of(1 << 29), half = vxs_lanes_of(0.5 * filter_px);
    const double   *m = light->ls_from_ws + 4 * row, texel = light->texel_metres;
    double          sum[CHUNK];
    vxs_lane_mask   small = noise < limit; /* all */
    for (int n = 0; n < CHUNK && !normals; n += VXS_LANES) {
        vxs_lanes at = times_row(m, points, n, 1);
        small &= vxs_abs_lanes(at) < limit;
        vxs_store(sum + n, vxs_small_floor(at));
    }
    for (int n = 0; n < CHUNK && normals; n += VXS_LANES) {
        vxs_lanes at = times_row(m, points, n, 1), step = times_row(m, normals, n, 0) * vxs_lanes_of(texel) * half;
        vxs_lanes steps = vxs_abs_lanes(step),
                  away  = -vxs_small_floor(noise - steps); /* from zero, in whole voxels; noise is none */
        small &= (vxs_abs_lanes(at) < limit) & (steps < limit);
        vxs_store(sum + n, vxs_small_floor(at) + vxs_signed_as(away, step));
    }
    if (!vxs_all(small)) return 0;
    for (int n = 0; n < CHUNK; n++) out[n] = (int32_t)sum[n];
    return 1;
}

/* normals  NULL: none */
static void find_voxels(const vxs_light *light, const coordinates *points, const coordinates *normals, size_t count, int filter_px,
                        voxels *out)
{
    int     alike = light->kind == VXS_LIGHT_KIND_DIRECTIONAL, bounded = (light->flags & VXS_LIGHT_BOUNDED) != 0;
    int32_t side = 1 << light->levels;
    for (int row = 0; row < 3 && alike; row++) alike = find_coordinates(light, row, points, normals, filter_px, out->at[row]);
    for (size_t n = 0; n < count && !alike; n++) find_voxel(light, points, normals, n, filter_px, out);
    for (size_t n = 0; n < count && alike; n++) {
        int inside  = (uint32_t)out->at[0][n] < (uint32_t)side && (uint32_t)out->at[1][n] < (uint32_t)side;
        out->map[n] = inside && (!bounded || (uint32_t)out->at[2][n] < (uint32_t)side) ? 0 : -1;
    }
}

/* lookups ------------------------------------------------------------------------------------------------------------------------ */

/* The lit fraction at a voxel, as vxs_lit has it. */
static float lit_at(vxs_taps *taps, const voxels *v, size_t n, int filter_px)
{
    int32_t last = (1 << taps->baked->light.levels) - 1, k = v->at[2][n];
    if (v->map[n] < 0) return VXS_OUTSIDE;
    if (k < 0) return 1;
    uint32_t all  = (uint32_t)(filter_px * filter_px);
    uint32_t dark = vxs_taps_at(taps, v->map[n], v->at[0][n], v->at[1][n], (uint32_t)(k < last ? k : last), filter_px);
    return (float)((double)(all - dark) / (double)all);
}

/* At any address. */
static void put(char *to, float lit)
{
    memcpy(to, &lit, sizeof lit);
}

static void look_up(const vxs_baked_light *baked, const vxs_batch *b, size_t stride, char *lit)
{
    vxs_taps           taps;
    coordinates        points = {0}, normals;
    voxels             v;
    const coordinates *some = b->normals_ws.data ? &normals : NULL;
    vxs_taps_init(&taps, baked);
    memset(&normals, 0, some ? sizeof normals : 0);
    for (size_t first = 0; first < b->count; first += CHUNK) {
        size_t count = b->count - first < CHUNK ? b->count - first : CHUNK;
        read_vectors(&b->points_ws, first, count, &points);
        if (some) read_vectors(&b->normals_ws, first, count, &normals);
        find_voxels(&baked->light, &points, some, count, b->filter_px, &v);
        for (size_t n = 0; n < count; n++, lit += stride) put(lit, lit_at(&taps, &v, n, b->filter_px));
    }
}

/* Smooth filters, of which nothing is kept. */
static void look_up_smooth(const vxs_baked_light *baked, const vxs_batch *b, size_t stride, char *lit)
{
    for (size_t n = 0; n < b->count; n++, lit += stride) {
        coordinates c[2];
        read_vectors(&b->points_ws, n, 1, &c[0]);
        if (b->normals_ws.data) read_vectors(&b->normals_ws, n, 1, &c[1]);
        const double point[3]  = {c[0].at[0][0], c[0].at[1][0], c[0].at[2][0]};
        const double normal[3] = {c[1].at[0][0], c[1].at[1][0], c[1].at[2][0]};
        put(lit, vxs_lookup(baked, point, b->normals_ws.data ? normal : NULL, b->filter_px));
    }
}

vxs_result vxs_lookup_batch(const vxs_baked_light *lights, uint32_t light_count, const vxs_batch *batch)
{
    vxs_batch b = {0};
    if (vxs_desc_take(&b, sizeof b, sizeof b, batch) != VXS_OK) return VXS_E_ARGUMENT;
    if (b.points_ws.type > VXS_F32 || b.normals_ws.type > VXS_F32) return VXS_E_ARGUMENT;
    if (!b.count || !light_count) return VXS_OK;
    if (!lights || !b.lit || !b.points_ws.data) return VXS_E_ARGUMENT;
    size_t stride = b.lit_stride_bytes ? b.lit_stride_bytes : sizeof(float);
    size_t light  = b.light_stride_bytes ? b.light_stride_bytes : b.count * stride;
    int    box    = b.filter_px < VXS_SMOOTH;
    if (box) b.filter_px = vxs_filter_width(b.filter_px); /* any number stands for one */
    for (uint32_t n = 0; n < light_count; n++) (box ? look_up : look_up_smooth)(&lights[n], &b, stride, (char *)b.lit + n * light);
    return VXS_OK;
}
