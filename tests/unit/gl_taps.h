/* Questions to the words of lights, texel by texel: what shaders of libvxs_gl answer, and C. Included behind cmocka.h, with
 * baker/lab/opengl/gl.h first of all.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef GL_TAPS_H
#define GL_TAPS_H

#include "baker/base/random.h"
#include "formats/vxs_space.h"
#include "runtime/gl/vxs_gl.h"

#include "gl_points.h"

/* A filter as one number, which shaders take apart. */
static inline float filter_code(vxs_filter filter)
{
    return (float)(filter.width_px + 256 * filter.is_smooth);
}

static inline vxs_filter filter_of_code(float code)
{
    return (vxs_filter){(int32_t)code & 255, (int32_t)code >> 8};
}

/* Position: texels and depth; normal: light, map, filter code. A smooth box lies in its texel as that one's place says. `last`
 * makes an answer of `dark`. */
#define TAPS_BODY(last)                                                                                                            \
    "in vec3 position_ws;\n"                                                                                                       \
    "in vec3 normal_ws;\n"                                                                                                         \
    "out float answer;\n"                                                                                                          \
    "void main() {\n"                                                                                                              \
    "    vxs_light_constants light = vxs_light_at(uint(normal_ws.x));\n"                                                           \
    "    vxs_place place;\n"                                                                                                       \
    "    place.map = int(normal_ws.y);\n"                                                                                          \
    "    place.voxel = ivec3(position_ws);\n"                                                                                      \
    "    place.across = uint(7 * place.voxel.x) & 255u;\n"                                                                         \
    "    place.down = uint(5 * place.voxel.y) & 255u;\n"                                                                           \
    "    int code = int(normal_ws.z);\n"                                                                                           \
    "    vxs_filter pcf = vxs_filter(code & 255, code >> 8);\n"                                                                    \
    "    uint k = uint(place.voxel.z), dark;\n"                                                                                    \
    "    if (pcf.is_smooth == 0)\n"                                                                                                \
    "        dark = vxs_shadow_taps(light.first_word, light, place.map, place.voxel.x, place.voxel.y, k, pcf.width_px);\n"         \
    "    else\n"                                                                                                                   \
    "        dark = vxs_shadow_part(light.first_word, light, place, k, pcf.width_px) % 16777213u;\n"                               \
    "    " last "\n"                                                                                                               \
    "}\n"

/* What smoke leaves at a position; normal: light. */
#define SMOKE_LEFT_BODY                                                                                                            \
    "in vec3 position_ws;\n"                                                                                                       \
    "in vec3 normal_ws;\n"                                                                                                         \
    "out float answer;\n"                                                                                                          \
    "void main() { answer = vxs_smoke_left_by(uint(normal_ws.x), position_ws); }\n"

static inline void use_body(drawing *d, const vxs_gl *gl, const char *name, const char *body)
{
    const char *texts[VXS_GL_TEXTS + 1];
    char        version[32];
    vxs_gl_texts(gl, texts);
    texts[VXS_GL_TEXTS] = body;
    snprintf(version, sizeof version, "%.*s", (int)strcspn(texts[0], "\n"), texts[0]);
    assert_string_equal(version, name);
    use_texts(d, name, version, texts, VXS_GL_TEXTS + 1);
    vxs_gl_link(gl, d->program);
}

typedef struct subject {
    const vxs_light *light;
    const uint32_t  *words;
} subject;

static inline query random_taps(rng *r, const subject *subjects, uint32_t count)
{
    uint32_t   n      = rng_below(r, count);
    vxs_filter filter = vxs_box(1 + 2 * (int32_t)rng_below(r, VXS_FILTER_MAX / 2 + 1));
    if (rng_below(r, 2)) filter = vxs_smooth(1 + (int32_t)rng_below(r, VXS_FILTER_MAX));
    int32_t side = 1 << subjects[n].light->levels, out = filter.is_smooth || filter.width_px > 1 ? 12 : 0;
    query   q = {{0}, {(float)n, (float)rng_below(r, vxs_map_count(subjects[n].light)), filter_code(filter)}};
    for (int k = 0; k < 2; k++) q.position[k] = (float)rng_between(r, -out, side - 1 + out);
    q.position[2] = (float)rng_between(r, 0, side - 1);
    return q;
}

/* Where the texel of a question goes dark, or a voxel before or behind. */
static inline void put_near_surface(rng *r, const subject *s, query *q)
{
    int32_t side = 1 << s->light->levels, i = (int32_t)q->position[0], j = (int32_t)q->position[1], low = 0, high = side;
    i = i < 0 ? 0 : i < side ? i : side - 1;
    j = j < 0 ? 0 : j < side ? j : side - 1;
    while (low < high) {
        int32_t k = (low + high) / 2;
        if (vxs_shadow_taps(s->words, s->light, (int32_t)q->normal[1], i, j, (uint32_t)k, 1))
            high = k;
        else
            low = k + 1;
    }
    low += rng_between(r, -1, 1);
    q->position[2] = (float)(low < 0 ? 0 : low < side ? low : side - 1);
}

/* The same in C.   partly  [in, out] counts those that are neither lit nor dark */
static inline uint32_t taps_in_c(const subject *s, const query *q, uint32_t *partly)
{
    int32_t    x = (int32_t)q->position[0], y = (int32_t)q->position[1];
    vxs_filter filter = filter_of_code(q->normal[2]);
    uint32_t   k = (uint32_t)q->position[2], width = (uint32_t)filter.width_px, dark, all = width * width;
    vxs_place  place = {(int32_t)q->normal[1], {x, y, (int32_t)k}, (uint32_t)(7 * x) & 255, (uint32_t)(5 * y) & 255};
    if (!filter.is_smooth) {
        dark = vxs_shadow_taps(s->words, s->light, place.map, x, y, k, filter.width_px);
    } else {
        dark = vxs_shadow_part(s->words, s->light, place, k, (int32_t)width);
        all *= 65536;
    }
    *partly += dark > 0 && dark < all;
    return dark % 16777213u;
}

#endif
