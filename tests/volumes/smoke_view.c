/* A sun over smoke; see smoke_view.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "tests/volumes/smoke_view.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/random.h"

#define MAP_METRES  26.0
#define NEAR_METRES 0.1

enum { LEVELS = 10 };

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

smoke_sun smoke_sun_over(const vxs_capsule *capsules, uint32_t count)
{
    static const double middle[3] = {0, 6, 0};
    smoke_sun s = {.axes = {{0.8, 0, -0.6}, {0.48, -0.6, 0.64}, {-0.36, -0.8, -0.48}}, .nearest = INFINITY, .farthest = -INFINITY};
    double    texel = MAP_METRES / (1 << LEVELS);
    s.constants     = (vxs_light_constants){
            .texel_metres = (float)texel, .voxel_metres = (float)texel, .kind = VXS_LIGHT_KIND_DIRECTIONAL, .levels = LEVELS};
    for (int n = 0; n < 3; n++) s.corner[n] = middle[n] - 0.5 * MAP_METRES * (s.axes[0][n] + s.axes[1][n] + s.axes[2][n]);
    for (int row = 0; row < 3; row++) {
        for (int n = 0; n < 3; n++) s.constants.ls_from_ws[4 * row + n] = (float)(s.axes[row][n] / texel);
        s.constants.ls_from_ws[4 * row + 3] = (float)(-dot(s.axes[row], s.corner) / texel);
    }
    for (uint32_t n = 0; n < 2 * count; n++) {
        const vxs_capsule *c  = &capsules[n / 2];
        const float       *at = n % 2 ? c->end : c->begin;
        double             to[3];
        for (int i = 0; i < 3; i++) to[i] = (double)at[i] - s.corner[i];
        s.nearest  = fmin(s.nearest, dot(s.axes[2], to) - (double)c->radius_metres);
        s.farthest = fmax(s.farthest, dot(s.axes[2], to) + (double)c->radius_metres);
    }
    return s;
}

/* The eye looks along -z. */
vxs_volumes_frame smoke_frame(uint32_t width_px, uint32_t height_px, float *depths, double (*places)[3])
{
    const double      eye[3] = {0, 6, 20}, half[2] = {0.36, 0.3};
    vxs_volumes_frame f = {.far_metres = 100, .top_metres = 1e30F, .view = {width_px, height_px, {0}, 0, {1, 0}}};
    float            *m = f.view.point_from_depth;
    rng               r = {1};
    m[0]                = (float)(2 * half[0] * NEAR_METRES);
    m[5]                = (float)(2 * half[1] * NEAR_METRES);
    m[11]               = 1;
    for (int n = 0; n < 3; n++) {
        f.eye[n] = (float)eye[n];
        m[8 + n] = (float)eye[n];
    }
    m[12] = (float)(-half[0] * NEAR_METRES);
    m[13] = (float)(-half[1] * NEAR_METRES);
    m[14] = (float)-NEAR_METRES;
    for (uint32_t n = 0; n < width_px * height_px; n++) {
        double z = 12 + 16 * rng_unit(&r), x = (2 * (n % width_px + 0.5) / width_px - 1) * half[0],
               y     = (2 * (n / width_px + 0.5) / height_px - 1) * half[1];
        depths[n]    = (float)(NEAR_METRES / z);
        z            = NEAR_METRES / (double)depths[n];
        places[n][0] = eye[0] + x * z;
        places[n][1] = eye[1] + y * z;
        places[n][2] = eye[2] - z;
    }
    return f;
}

/* The parts of a texel's ray; found when they are first requested. */
typedef struct texel_parts {
    smoke_part *parts;
    size_t      count;
} texel_parts;

static void *taken(size_t count, size_t size)
{
    void *memory = calloc(count, size);
    if (!memory) abort();
    return memory;
}

static const texel_parts *parts_of(const smoke_sun *sun, uint32_t side_px, const vxs_capsule *capsules, uint32_t count, uint32_t x,
                                   uint32_t y, texel_parts *all, smoke_part *room)
{
    texel_parts *t = &all[(size_t)y * side_px + x];
    double       u = (x + 0.5) * MAP_METRES / side_px, v = (y + 0.5) * MAP_METRES / side_px, from[3];
    if (t->parts) return t;
    for (int n = 0; n < 3; n++) from[n] = sun->corner[n] + u * sun->axes[0][n] + v * sun->axes[1][n];
    t->count = smoke_parts(capsules, count, from, sun->axes[2], room);
    t->parts = taken(t->count + 1, sizeof *t->parts);
    memcpy(t->parts, room, t->count * sizeof *room);
    return t;
}

void smoke_truth(const smoke_sun *sun, uint32_t side_px, const vxs_capsule *capsules, uint32_t capsule_count,
                 const double (*places)[3], size_t count, double *left)
{
    texel_parts *all  = taken((size_t)side_px * side_px, sizeof *all);
    smoke_part  *room = taken(capsule_count, sizeof *room);
    for (size_t k = 0; k < count; k++) {
        double to[3], at[3];
        for (int n = 0; n < 3; n++) to[n] = places[k][n] - sun->corner[n];
        for (int n = 0; n < 3; n++) at[n] = dot(sun->axes[n], to);
        double u = at[0] / MAP_METRES * side_px - 0.5, v = at[1] / MAP_METRES * side_px - 0.5;
        left[k] = 0;
        for (int n = 0; n < 4; n++) {
            double             x = floor(u) + (n & 1), y = floor(v) + (n >> 1);
            uint32_t           i = (uint32_t)fmin(fmax(x, 0), side_px - 1), j = (uint32_t)fmin(fmax(y, 0), side_px - 1);
            const texel_parts *t = parts_of(sun, side_px, capsules, capsule_count, i, j, all, room);
            left[k] += (1 - fabs(u - x)) * (1 - fabs(v - y)) * smoke_left(t->parts, t->count, at[2]);
        }
    }
    for (size_t n = 0; n < (size_t)side_px * side_px; n++) free(all[n].parts);
    free(all);
    free(room);
}
