/* Maps of transmittance curves on llvmpipe, read back, and each texel's ray through the same capsules in double. Included behind
 * cmocka.h and random_light.h, with baker/lab/opengl/gl.h first of all.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef TRANSMITTANCE_MAPS_H
#define TRANSMITTANCE_MAPS_H

#include "fog_scene.h"
#include "runtime/volumes/vxs_curve.h"
#include "tests/volumes/smoke_scene.h"
#include "volumes_scene.h"

enum { RESOLUTION = 64, WIDE = 48, HIGH = 40, PIXELS = WIDE * HIGH, SIDE = 24, CAPSULES = 240, DEPTHS = 24, ROOM = 1 << 17 };

/* How curves are built. */
typedef enum way_to_build { SORTED, UNSORTED, CROWDED, STREAMED, WAYS } way_to_build;
static const char *const way_names[WAYS] = {"sorted lists", "unsorted lists", "lists with room for 500", "tiles"};

/* Which of them a light is queried with; between them, each way and each light with lists and tiles. */
static inline int asks(int light, int how)
{
    static const uint32_t ways[SCENE_LIGHTS] = {1 << UNSORTED | 1 << STREAMED, 1 << SORTED | 1 << CROWDED,
                                                1 << CROWDED | 1 << STREAMED};
    return (int)(repeats(ways[light], UINT32_MAX) >> how & 1);
}

/* Smoke, and hair as wide as texels are here. */
static inline void make_smoke(vxs_capsule *smoke)
{
    smoke_make(SMOKE_HAIR, smoke, CAPSULES, 1);
    for (int n = CAPSULES / 2; n < CAPSULES; n++) {
        smoke[n].extinction *= smoke[n].radius_metres / 0.5F;
        smoke[n].radius_metres = 0.5F;
    }
}

static inline vxs_transmittance_desc desc_of(int light, way_to_build how, uint32_t nodes)
{
    return (vxs_transmittance_desc){.baked_number = vxs_baked_number((uint32_t)light),
                                    .side_px      = SIDE,
                                    .nodes        = nodes,
                                    .capsules     = CAPSULES,
                                    .segments     = how == STREAMED  ? 0
                                                    : how == CROWDED ? 500
                                                                     : ROOM,
                                    .unsorted     = how == UNSORTED};
}

/* One scene for all tests, and its maps of 8 nodes, made when they are first requested: programs take longer to compile than to run
 * here. */
static volumes_scene          s;
static vxs_transmittance_map *maps[SCENE_LIGHTS][WAYS];
enum { NODES = 8 };

static inline vxs_transmittance_map *map_make(int light, way_to_build how, uint32_t nodes)
{
    vxs_transmittance_map *map;
    vxs_transmittance_desc desc = desc_of(light, how, nodes);
    assert_int_equal(vxs_transmittance_map_create(&map, s.volumes, &desc), VXS_OK);
    return map;
}

static inline vxs_transmittance_map *map_of(int light, int how)
{
    if (!maps[light][how]) maps[light][how] = map_make(light, (way_to_build)how, NODES);
    return maps[light][how];
}

static inline int open_scene(void **state)
{
    (void)state;
    scene_open(&s, RESOLUTION, WIDE, HIGH);
    return 0;
}

static inline int close_scene(void **state)
{
    (void)state;
    for (int n = 0; n < SCENE_LIGHTS * WAYS; n++) vxs_transmittance_map_destroy(maps[n / WAYS][n % WAYS]);
    scene_close(&s);
    return 0;
}

static inline vxs_shadow_depth_map *opaque_map(int light)
{
    vxs_shadow_depth_map     *map;
    vxs_shadow_depth_map_desc desc = {.baked_number = vxs_baked_number((uint32_t)light), .side_px = 32};
    assert_int_equal(vxs_shadow_depth_map_create(&map, s.volumes, &desc), VXS_OK);
    vxs_shadow_depth_map_fill(map, UINT64_MAX);
    return map;
}

/* The texels of a light, with the ray of each. Depths are metres along the map's axis. */
typedef struct texels {
    shadow_depth_map map;
    size_t           count, nodes;
    float           *curves; /* [count][nodes][2] */
} texels;

typedef struct texel_ray {
    double     from[3], way[3], begin, metres; /* where the ray is at depth 0, along itself, and what a metre of depth adds */
    smoke_part parts[CAPSULES];
    size_t     count;
} texel_ray;

static inline texels texels_of(int light, size_t nodes)
{
    texels t     = {.nodes = nodes, .map = {.light = vxs_asset_light(s.asset, (uint32_t)light)->light, .side = SIDE}};
    t.map.layers = t.map.light.flags & VXS_LIGHT_CUBE ? 6 : 1;
    t.count      = (size_t)(t.map.layers * SIDE * SIDE);
    t.curves     = malloc(t.count * 2 * nodes * sizeof *t.curves);
    assert_non_null(t.curves);
    return t;
}

static inline void read_curves(const vxs_transmittance_map *map, texels *t)
{
    s.gl->GetNamedBufferSubData(vxs_transmittance_map_buffer(map), 16, (GLsizeiptr)(t->count * 2 * t->nodes * sizeof *t->curves),
                                t->curves);
    for (size_t n = 0; n < t->count; n++)
        for (size_t k = 0; k < t->nodes; k++) {
            const float *node = t->curves + 2 * (n * t->nodes + k);
            assert_true(isfinite(node[0]) && node[1] >= 0 && node[1] <= 1);
            if (k) assert_true(node[0] >= node[-2] && node[1] <= node[-1]);
        }
}

static inline void build(vxs_transmittance_map *map, const vxs_capsule *list, uint32_t count, const vxs_shadow_depth_map *opaque,
                         texels *t)
{
    vxs_capsules capsules = {.list = list, .count = count};
    assert_int_equal(vxs_transmittance_map_build(map, &capsules, opaque), VXS_OK);
    if (t) read_curves(map, t);
}

static inline double curve_at(const texels *t, size_t texel, double depth, int exponential)
{
    return vxs_curve_read(t->curves, (int)(2 * texel * t->nodes), (int)t->nodes, depth, exponential);
}

static inline double curve_end(const texels *t, size_t texel)
{
    return (double)t->curves[2 * (texel + 1) * t->nodes - 1];
}

static inline void trace(const texels *t, size_t texel, const vxs_capsule *capsules, uint32_t count, texel_ray *ray)
{
    int x = (int)texel % SIDE, y = (int)texel / SIDE % SIDE, face = (int)texel / (SIDE * SIDE),
        is_sun    = t->map.light.kind == VXS_LIGHT_KIND_DIRECTIONAL;
    double metres = shadow_depth_map_ray(&t->map, face, x, y, ray->from, ray->way);
    ray->begin    = is_sun ? 100 : 0; /* a sun's light comes from before its map */
    ray->metres   = is_sun ? 1 : metres;
    for (int i = 0; i < 3; i++) ray->from[i] -= ray->begin * ray->way[i];
    ray->count = smoke_parts(capsules, count, ray->from, ray->way, ray->parts);
}

static inline double left_at(const texel_ray *ray, double depth)
{
    return smoke_left(ray->parts, ray->count, ray->begin + depth * ray->metres);
}

/* A depth at which something happens, or any. */
static inline double depth_of(const texel_ray *ray, rng *r)
{
    double at = uniform(r, 0, 20);
    if (!ray->count) return at;
    const smoke_part *p = &ray->parts[rng_below(r, (uint32_t)ray->count)];
    return (uniform(r, p->entry - 0.1, p->exit + 0.1) - ray->begin) / ray->metres;
}

/* What four curves say of a place, weighed, in double. */
static inline double look_up(const texels *t, const double ws[3], int exponential)
{
    double edge = ldexp(1, (int)t->map.light.levels), scale = t->map.light.texel_metres * edge / SIDE, place[3], u, v, depth,
           sum   = 0;
    size_t texel = 0;
    if (!shadow_depth_map_texel(&t->map, ws, &texel, &depth)) return 1;
    size_t layer = texel / (SIDE * SIDE);
    face_from_ws(&t->map, (int)layer, ws, 1, place);
    int is_sun = t->map.light.kind == VXS_LIGHT_KIND_DIRECTIONAL;
    u          = is_sun ? place[0] * SIDE / edge : SIDE / 2.0 + place[0] / place[2] / scale;
    v          = is_sun ? place[1] * SIDE / edge : SIDE / 2.0 + place[1] / place[2] / scale;
    if (is_sun) depth *= t->map.light.voxel_metres;
    for (int n = 0; n < 4; n++) {
        double x = floor(u - 0.5) + (n & 1), y = floor(v - 0.5) + (n >> 1),
               weight = (1 - fabs(u - 0.5 - x)) * (1 - fabs(v - 0.5 - y));
        size_t at     = (layer * SIDE + (size_t)fmin(fmax(y, 0), SIDE - 1)) * SIDE + (size_t)fmin(fmax(x, 0), SIDE - 1);
        sum += weight * curve_at(t, at, depth, exponential);
    }
    return sum;
}

#endif
