/* A screen in the fog of volumes_scene.h: its VPLs, points of the boxes about it, and its light with exact visibility in double.
 * Included behind volumes_scene.h; `light`, `scene`, `points` and `normals` are there from area_set_up to area_tear_down.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef AREA_SCENE_H
#define AREA_SCENE_H

#include "baker/base/spread.h"
#include "runtime/volumes/vxs_area_grid.h"
#include "runtime/volumes/vxs_area_light.h"

/* Whether nothing is between two places: boxes, and the floor, by slabs. */
static inline int area_is_free(const volumes_scene *s, const double from[3], const double to[3])
{
    for (uint32_t box = 0; box <= SCENE_BOXES; box++) {
        const float *low = s->positions + 24 * box, *high = low + (box < SCENE_BOXES ? 21 : 9);
        double       begin = 1e-9, end = 1 - 1e-9;
        for (int i = 0; i < 3 && begin <= end; i++) {
            double a = (double)low[i] - from[i], b = (double)high[i] - from[i], way = to[i] - from[i];
            if (way == 0 && (a > 0 || b < 0)) begin = 2;
            if (way == 0) continue;
            begin = fmax(begin, fmin(a / way, b / way));
            end   = fmin(end, fmax(a / way, b / way));
        }
        if (begin <= end) return 0;
    }
    return 1;
}

/* A corner of a polygon: t of the way from a VPL to a place of an eye ray, and that times how far along the eye ray
 * the place is. */
typedef struct area_corner {
    double t, s;
} area_corner;

/* The part of a convex polygon where t * a + s * b <= c.   Returns how many corners it has */
static inline int area_clip(area_corner *at, int count, double a, double b, double c)
{
    area_corner kept[16];
    int         n = 0;
    for (int k = 0; k < count; k++) {
        area_corner p = at[k], q = at[(k + 1) % count];
        double      above = p.t * a + p.s * b - c, next = q.t * a + q.s * b - c;
        if (above <= 0) kept[n++] = p;
        if ((above < 0) != (next < 0) && above != next) {
            double part = above / (above - next);
            kept[n++]   = (area_corner){p.t + part * (q.t - p.t), p.s + part * (q.s - p.s)};
        }
    }
    memcpy(at, kept, sizeof *at * (size_t)n);
    return n;
}

/* Where a box keeps a VPL's light from an eye ray: exactly. A place x of the ray is in the dark if the way to it, from + t (eye + x
 * direction - from), is in the box for a t in [0, 1]: bounds that are linear in t and in t x.
 * part  [out];   Returns 0 where there is none */
static inline int area_shadow(const float *low, const float *high, const double from[3], const double eye[3],
                              const double direction[3], double end, double part[2])
{
    area_corner  at[16] = {{1e-9, 0}, {1, 0}, {1, end}, {1e-9, 1e-9 * end}};
    int          count  = 4;
    const double thin   = 1e-7; /* the floor, too, is a box */
    for (int i = 0; i < 3 && count; i++) {
        count = area_clip(at, count, eye[i] - from[i], direction[i], (double)high[i] + thin - from[i]);
        count = area_clip(at, count, from[i] - eye[i], -direction[i], from[i] - (double)low[i] + thin);
    }
    part[0] = end;
    part[1] = 0;
    for (int k = 0; k < count; k++) {
        part[0] = fmin(part[0], at[k].s / at[k].t);
        part[1] = fmax(part[1], at[k].s / at[k].t);
    }
    return part[1] > part[0];
}

/* Airlight of VPLs along a ray, each by the exact parts of it that it reaches.   sum  [in, out] */
static inline void area_airlight(const volumes_scene *s, const vxs_vpl *vpls, uint32_t count, const vxs_medium *medium,
                                 const double eye[3], const double direction[3], double metres, double sum[3])
{
    for (uint32_t n = 0; n < count; n++) {
        vxs_air_light light = {.kind = VXS_LIGHT_KIND_POINT, .radius_metres = (double)vpls[n].radius_metres};
        double        dark[SCENE_BOXES + 2][2], lit[3];
        int           darks = 0;
        for (int i = 0; i < 3; i++) {
            light.place[i] = (double)vpls[n].place[i];
            light.axis[i]  = (double)vpls[n].normal[i];
        }
        vxs_air_path path =
            vxs_area_path(&light, vxs_air_dot(light.axis, light.axis) > 0, eye, direction, metres, VXS_AIR_EVERYWHERE);
        for (uint32_t box = 0; box <= SCENE_BOXES; box++) {
            const float *low = s->positions + 24 * box, *high = low + (box < SCENE_BOXES ? 21 : 9);
            darks += area_shadow(low, high, light.place, eye, direction, metres, dark[darks]);
        }
        qsort(dark, (size_t)darks, sizeof *dark, doubles_ascending);
        dark[darks][0] = path.end;
        double begin   = path.begin;
        for (int k = 0; k <= darks; k++) {
            vxs_air_lit(medium, &path, begin, dark[k][0], lit);
            for (int i = 0; i < 3; i++) sum[i] += (double)vpls[n].colour[i] * lit[i];
            if (k < darks) begin = fmax(begin, dark[k][1]);
        }
    }
}

/* Points of the boxes and the floor, in a buffer.   Returns its name */
static inline GLuint area_points(const volumes_scene *s, uint32_t count)
{
    vxs_area_point *points = malloc(count * sizeof *points);
    GLuint          buffer;
    assert_non_null(points);
    assert_true(vxs_area_scatter(s->positions, s->indices, SCENE_TRIANGLES, points, count) > 0);
    s->gl->GenBuffers(1, &buffer);
    s->gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, buffer);
    s->gl->BufferData(GL_SHADER_STORAGE_BUFFER, (GLsizeiptr)(count * sizeof *points), points, GL_STATIC_DRAW);
    free(points);
    return buffer;
}

/* The normal of the box or the floor that a place is on; 0: it is on none. */
static inline void area_normal(const volumes_scene *s, const double place[3], float normal[3])
{
    double nearest = 1e-3;
    normal[0] = normal[1] = normal[2] = 0;
    for (uint32_t box = 0; box <= SCENE_BOXES; box++)
        for (int side = 0; side < 6; side++) {
            const float *low = s->positions + 24 * box, *high = low + (box < SCENE_BOXES ? 21 : 9), *at = side % 2 ? high : low;
            int          axis = side / 2, within = 1;
            for (int i = 0; i < 3; i++) within &= i == axis || (place[i] >= (double)low[i] && place[i] <= (double)high[i]);
            double off = fabs(place[axis] - (double)at[axis]);
            if (!within || off > nearest) continue; /* the floor's sides are one: up */
            nearest = off;
            for (int i = 0; i < 3; i++) normal[i] = i == axis ? (side % 2 ? 1.0F : -1.0F) : 0;
        }
}

/* What VPLs send to a place of a surface, less what fog takes of it, where nothing is between them: one channel. */
static inline double area_irradiance(const volumes_scene *s, const vxs_vpl *vpls, uint32_t count, double extinction,
                                     const double place[3], const float normal[3])
{
    double sum = 0, above[3];
    for (int i = 0; i < 3; i++) above[i] = place[i] + 1e-4 * (double)normal[i];
    for (uint32_t n = 0; n < count; n++) {
        double way[3], from[3], here = 0, there = 0;
        for (int i = 0; i < 3; i++) {
            from[i] = (double)vpls[n].place[i];
            way[i]  = from[i] - place[i];
            here += way[i] * (double)normal[i];
            there -= way[i] * (double)vpls[n].normal[i];
        }
        double square = dot(way, way), metres = sqrt(square);
        if (here > 0 && there > 0 && area_is_free(s, from, above))
            sum += (double)vpls[n].colour[0] * here * there / (square * square) * exp(-extinction * metres);
    }
    return sum;
}

/* one scene, and a light of its own, for all tests of a program ---------------------------------------------------------------- */

enum { WIDE = 32, HIGH = 24, PIXELS = WIDE * HIGH, SIDE = 64, COLUMNS = 64, ROWS = 60, POINTS = 100000 };

static const vxs_medium haze = {{0.03, 0.035, 0.04}, {0.04, 0.045, 0.05}, 0.4};

/* The screen off the view, and, from beside, in it. */
static const double eyes[][3] = {{9, 3, 7}, {-8, 0.5, -8}, {6, 4, -2}};
static const double look[3]   = {0, 2, 0};
enum { CAMERAS = sizeof eyes / sizeof *eyes };

static volumes_scene   scene;
static vxs_area_light *light;
static GLuint          points, normals;

static inline int area_set_up(void **state)
{
    (void)state;
    const vxs_area_light_desc desc = {.side_px = SIDE, .columns = COLUMNS, .rows = ROWS, .takes_maps = 1};
    scene_open(&scene, 64, WIDE, HIGH);
    assert_int_equal(vxs_area_light_create(&light, scene.volumes, &desc), VXS_OK);
    points = area_points(&scene, POINTS);
    scene.gl->CreateTextures(GL_TEXTURE_2D, 1, &normals);
    scene.gl->TextureStorage2D(normals, 1, GL_RGBA32F, WIDE, HIGH);
    return 0;
}

static inline int area_tear_down(void **state)
{
    (void)state;
    if (!scene.gl) return 0; /* the tests were skipped */
    assert_int_equal(scene.gl->GetError(), GL_NO_ERROR);
    vxs_area_light_destroy(light);
    scene_close(&scene);
    return 0;
}

/* A screen that hangs over the boxes, tilted. */
static inline void screen_vpls(uint32_t seed, vxs_vpl *vpls, uint32_t count)
{
    const vxs_area_rectangle screen = {{-1.5F, 4.5F, -1}, {3, 0, 0}, {0, -0.6F, 1.8F}, {10, 8, 6}, NULL, 0, 0};
    assert_int_equal(vxs_area_sample(&screen, VXS_AREA_HALTON, seed, vpls, count), VXS_OK);
}

static inline void draw(const vxs_volumes_frame *frame, const vxs_area_look *asked, float *pixels)
{
    assert_int_equal(vxs_volumes_begin(scene.volumes, frame), VXS_OK);
    assert_int_equal(vxs_volumes_area(scene.volumes, light, asked), VXS_OK);
    scene_read(&scene, pixels);
}

static inline void cast(uint32_t count, uint32_t is_whole)
{
    const vxs_area_casters casters = {points, count, is_whole};
    assert_int_equal(vxs_area_light_cast(light, &casters), VXS_OK);
}

static inline void read_buffer(size_t start, size_t size, void *data)
{
    scene.gl->GetNamedBufferSubData(light->buffer, (GLintptr)start, (GLsizeiptr)size, data);
}

static inline size_t map_at(uint32_t number, uint32_t side)
{
    return sizeof light->vpls + 4 * (vxs_area_shadow_depth_maps(light) + (size_t)number * ((4 * side * side - 1) / 3));
}

/* A word of a VPL's imperfect shadow map, as area_map.glsl has them: 15 bits of a float of the depth in radii of the VPL; a level
 * surface. 1e30: nothing is there. */
static inline uint32_t map_word(const area_vpl *of, float depth)
{
    float    part = depth / of->radius_metres + (of->kind == AREA_FAR);
    uint32_t bits;
    memcpy(&bits, &part, sizeof bits);
    return depth < 1e30F ? (bits - 0x3f800000U + 0x1000U) >> 13 << 17 : UINT32_MAX;
}

static inline float map_depth(const area_vpl *of, uint32_t word)
{
    uint32_t bits = (word >> 17 << 13) + 0x3f800000U;
    float    part;
    memcpy(&part, &bits, sizeof part);
    return word == UINT32_MAX ? 1e30F : (part - (of->kind == AREA_FAR)) * of->radius_metres;
}

/* The depths of a VPL's imperfect shadow map; 1e30: nothing is there.
 * side  of a map;   depths  [out] [side * side] */
static inline void read_map(uint32_t number, uint32_t side, float *depths)
{
    read_buffer(map_at(number, side), 4UL * side * side, depths);
    for (uint32_t n = 0; n < side * side; n++) {
        uint32_t word;
        memcpy(&word, &depths[n], sizeof word);
        depths[n] = map_depth(&light->vpls[number], word);
    }
}

static inline double relative_rms(const float *pixels, const double *wanted, uint32_t step)
{
    double wrong = 0, size = 0;
    for (uint32_t n = 0; n < PIXELS; n++)
        for (uint32_t i = 0; i < 3 && n % WIDE % step == 0 && n / WIDE % step == 0; i++) {
            double w = wanted[3 * n + i], more = (double)pixels[4 * n + i] - w;
            wrong += more * more;
            size += w * w;
        }
    return sqrt(wrong / size);
}

#endif
