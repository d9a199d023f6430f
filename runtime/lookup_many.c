/* Lookups of many points; see vxs_query.h. Points are processed in chunks of 64: first all coordinates, then all places, then all
 * taps.
 * SPDX-License-Identifier: MIT */
#include <string.h>

#include "point_lanes.h"
#include "taps_many.h"
#include "vxs_desc.h"
#include "vxs_query.h"

enum { CHUNK = 64 };

/* Coordinates of a chunk of points or normals: all x, all y, all z. */
typedef struct coordinates {
    double at[3][CHUNK];
} coordinates;

/* Places of a chunk of points, as vxs_place; `within` is used by smooth filters only. */
typedef struct places {
    int32_t at[3][CHUNK], map[CHUNK];
    uint8_t within[2][CHUNK];
} places;

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

/* world to voxel -------------------------------------------------------------------------------------------------------------- */

/* Product of a matrix row with points (one = 1) or directions (one = 0), with the operation order of vxs_ls_coordinate. */
static inline vxs_lanes times_row(const double *m, const coordinates *c, int n, double one)
{
    return vxs_lanes_of(m[0]) * vxs_load(c->at[0] + n) + vxs_lanes_of(m[1]) * vxs_load(c->at[1] + n) +
           vxs_lanes_of(m[2]) * vxs_load(c->at[2] + n) + vxs_lanes_of(m[3] * one);
}

/* As vxs_between_taps. floors  of `at` */
static inline vxs_lanes between_taps(vxs_lanes at, vxs_lanes floors, vxs_filter filter)
{
    if (!filter.is_smooth) return at - floors - vxs_lanes_of(0.5);
    vxs_lanes first = at - vxs_lanes_of(0.5 * vxs_filter_width(filter));
    return first - vxs_small_floor(first) - vxs_lanes_of(0.5);
}

/* Points in the map of a directional light. Each step is a loop of its own over all points: that is faster than one loop with all
 * steps, because a processor can overlap more operations. */
typedef struct sun_points {
    double at[3][CHUNK], voxel[3][CHUNK]; /* as for vxs_biased_voxel; voxel: initially floor(at) */
    double normal[3][CHUNK];
    double missing[CHUNK], across[2][CHUNK]; /* steps across the map */
} sun_points;

static void step_across(sun_points *p, vxs_filter filter)
{
    const vxs_lanes zero = vxs_lanes_of(0), half = vxs_lanes_of(0.5);
    for (int n = 0; n < CHUNK; n += VXS_LANES) {
        vxs_lanes i = vxs_load(p->normal[0] + n), j = vxs_load(p->normal[1] + n), across = vxs_abs_lanes(i),
                  down   = vxs_abs_lanes(j);
        vxs_lanes most   = vxs_lanes_of(VXS_BIAS_ALONG * vxs_filter_width(filter)) * vxs_abs_lanes(vxs_load(p->normal[2] + n));
        vxs_lanes reach  = vxs_lanes_of(vxs_filter_reach(filter) + VXS_BIAS_SLACK) * (across + down);
        vxs_lanes beyond = reach - most;
        beyond           = vxs_keep(beyond > zero, beyond / (across * across + down * down));
        vxs_lanes u = vxs_small_floor(beyond * across + half), v = vxs_small_floor(beyond * down + half);
        vxs_lanes first  = between_taps(vxs_load(p->at[0] + n), vxs_load(p->voxel[0] + n), filter);
        vxs_lanes second = between_taps(vxs_load(p->at[1] + n), vxs_load(p->voxel[1] + n), filter);
        vxs_store(p->missing + n, reach + first * i + second * j - u * across - v * down);
        vxs_store(p->across[0] + n, u);
        vxs_store(p->across[1] + n, v);
    }
}

static void step_farther(sun_points *p, vxs_filter filter)
{
    const vxs_lanes one = vxs_lanes_of(1);
    for (int n = 0; n < CHUNK; n += VXS_LANES) {
        vxs_lanes i = vxs_load(p->normal[0] + n), j = vxs_load(p->normal[1] + n), across = vxs_abs_lanes(i),
                  down    = vxs_abs_lanes(j);
        vxs_lanes most    = vxs_lanes_of(VXS_BIAS_ALONG * vxs_filter_width(filter)) * vxs_abs_lanes(vxs_load(p->normal[2] + n));
        vxs_lanes missing = vxs_load(p->missing + n), u = vxs_load(p->across[0] + n), v = vxs_load(p->across[1] + n);
        for (int axis = 0; axis < 2; axis++) {
            vxs_lane_mask more = missing > most, first = axis ? across <= down : across > down;
            vxs_lanes     a = vxs_keep(more, vxs_keep(first, one)), b = vxs_keep(more, one) - a;
            u += a;
            v += b;
            missing -= a * across + b * down;
        }
        vxs_lane_mask some = across + down + vxs_abs_lanes(vxs_load(p->normal[2] + n)) > vxs_lanes_of(0);
        vxs_store(p->missing + n, missing);
        vxs_store(p->voxel[0] + n, vxs_load(p->voxel[0] + n) + vxs_keep(some, vxs_signed_as(u, i)));
        vxs_store(p->voxel[1] + n, vxs_load(p->voxel[1] + n) + vxs_keep(some, vxs_signed_as(v, j)));
    }
}

static void step_along(const vxs_light *light, sun_points *p)
{
    const vxs_lanes zero = vxs_lanes_of(0), one = vxs_lanes_of(1), depth = vxs_lanes_of(light->texel_metres / light->voxel_metres);
    for (int n = 0; n < CHUNK; n += VXS_LANES) {
        vxs_lanes     normal = vxs_load(p->normal[2] + n), along = vxs_abs_lanes(normal), at = vxs_load(p->at[2] + n);
        vxs_lanes     voxels = vxs_lanes_of(1 + VXS_BIAS_SLACK) * along + vxs_load(p->missing + n) * depth;
        vxs_lane_mask deep   = voxels > zero;
        voxels               = voxels / along;
        vxs_lanes towards = vxs_small_floor(at - voxels), away = -one - vxs_small_floor(-at - voxels);
        vxs_store(p->voxel[2] + n, vxs_pick(deep, vxs_pick(normal < zero, towards, away), vxs_load(p->voxel[2] + n)));
    }
}

/* Voxels of a chunk in a directional light, as vxs_sun_place. Returns 0 when a coordinate is NaN, or so large that vxs_sun_place
 * would clamp it; then `out` has no meaning.
 * normals  NULL: none */
static int find_voxels(const vxs_light *light, const coordinates *points, const coordinates *normals, vxs_filter filter,
                       places *out)
{
    const vxs_lanes limit = vxs_lanes_of(1 << 29), depth = vxs_lanes_of(light->voxel_metres / light->texel_metres);
    vxs_lane_mask   small = vxs_lanes_of(0) < limit; /* all ones */
    sun_points      p;
    for (int row = 0; row < 3; row++)
        for (int n = 0; n < CHUNK; n += VXS_LANES) {
            vxs_lanes at = times_row(light->ls_from_ws + 4 * row, points, n, 1), floors = vxs_small_floor(at);
            small &= vxs_abs_lanes(at) < limit;
            vxs_store(p.at[row] + n, at);
            vxs_store(p.voxel[row] + n, floors);
            if (row < 2 && filter.is_smooth) {
                /* as vxs_within */
                uint8_t *within = out->within[row] + n;
                double   part[VXS_LANES];
                vxs_store(part, vxs_lanes_of(256) * (at - floors));
                for (int k = 0; k < VXS_LANES; k++) within[k] = part[k] > 0 ? (uint8_t)(part[k] < 255 ? part[k] : 255) : 0;
            }
        }
    for (int row = 0; row < 3 && normals; row++)
        for (int n = 0; n < CHUNK; n += VXS_LANES) {
            vxs_lanes normal = times_row(light->ls_from_ws + 4 * row, normals, n, 0);
            vxs_store(p.normal[row] + n, row < 2 ? normal : normal * depth);
        }
    if (normals) {
        step_across(&p, filter);
        step_farther(&p, filter);
        step_along(light, &p);
    }
    for (int row = 0; row < 3; row++)
        for (int n = 0; n < CHUNK && normals; n += VXS_LANES) small &= vxs_abs_lanes(vxs_load(p.voxel[row] + n)) < limit;
    if (!vxs_all(small)) return 0;
    for (int row = 0; row < 3; row++)
        for (int n = 0; n < CHUNK; n++) out->at[row][n] = (int32_t)p.voxel[row][n];
    return 1;
}

/* normals  NULL: none */
static void find_places(const vxs_light *light, const coordinates *points, const coordinates *normals, size_t count,
                        vxs_filter filter, places *out)
{
    int     sun = light->kind == VXS_LIGHT_KIND_DIRECTIONAL, bounded = (light->flags & VXS_LIGHT_BOUNDED) != 0;
    int32_t side  = 1 << light->levels;
    int     alike = sun && find_voxels(light, points, normals, filter, out);
    for (size_t n = 0; n < count && !alike; n++) {
        /* as for a single lookup */
        double point[3], normal[3];
        for (int axis = 0; axis < 3; axis++) {
            point[axis]  = points->at[axis][n];
            normal[axis] = normals ? normals->at[axis][n] : 0;
        }
        vxs_place place = vxs_place_of(light, point, normal, filter);
        for (int axis = 0; axis < 3; axis++) out->at[axis][n] = place.voxel[axis];
        out->map[n]       = place.map;
        out->within[0][n] = (uint8_t)place.across;
        out->within[1][n] = (uint8_t)place.down;
    }
    for (size_t n = 0; n < count && alike; n++) {
        int inside  = (uint32_t)out->at[0][n] < (uint32_t)side && (uint32_t)out->at[1][n] < (uint32_t)side;
        out->map[n] = inside && (!bounded || (uint32_t)out->at[2][n] < (uint32_t)side) ? 0 : -1;
    }
}

/* lookups --------------------------------------------------------------------------------------------------------------------- */

/* Lit fraction at a place, as vxs_lit. */
static float lit_at(vxs_taps *taps, const places *p, size_t n, vxs_filter filter)
{
    int32_t last = (1 << taps->baked->light.levels) - 1, width = vxs_filter_width(filter);
    if (p->map[n] < 0) return VXS_OUTSIDE;
    if (p->at[2][n] < 0) return 1;
    uint32_t k = (uint32_t)(p->at[2][n] < last ? p->at[2][n] : last), all = (uint32_t)(width * width), dark;
    if (!filter.is_smooth) {
        dark = vxs_taps_at(taps, p->map[n], p->at[0][n], p->at[1][n], k, width);
    } else {
        vxs_place place = {p->map[n], {p->at[0][n], p->at[1][n], p->at[2][n]}, p->within[0][n], p->within[1][n]};
        dark            = vxs_taps_part(taps, place, k, width);
        all *= 65536;
    }
    return (float)((double)(all - dark) / (double)all);
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
    for (uint32_t n = 0; n < light_count; n++) {
        char              *lit = (char *)b.lit + n * light;
        vxs_taps           taps;
        coordinates        points = {0}, normals;
        places             p;
        const coordinates *some = b.normals_ws.data ? &normals : NULL;
        vxs_taps_init(&taps, &lights[n]);
        memset(&normals, 0, some ? sizeof normals : 0);
        for (size_t first = 0; first < b.count; first += CHUNK) {
            size_t count = b.count - first < CHUNK ? b.count - first : CHUNK;
            read_vectors(&b.points_ws, first, count, &points);
            if (some) read_vectors(&b.normals_ws, first, count, &normals);
            find_places(&lights[n].light, &points, some, count, b.filter, &p);
            for (size_t k = 0; k < count; k++, lit += stride) {
                float found = lit_at(&taps, &p, k, b.filter);
                memcpy(lit, &found, sizeof found); /* to an address of any alignment */
            }
        }
    }
    return VXS_OK;
}
