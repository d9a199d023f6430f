/* Area lights, for pictures: two triangles of one primitive that form a parallelogram, with an emissive material: emissiveFactor,
 * times the strength of KHR_materials_emissive_strength, times emissiveTexture (3.9.3). The texture is resampled along the sides of
 * the parallelogram.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/scene/gltf/gltf_loader.h"

#include "baker/base/array.h"
#include "baker/base/srgb.h"
#include "baker/base/vec3.h"

namespace gltf
{

static constexpr double GREY       = 0.45; /* value of a texture that is not read, as for base colours */
static constexpr double TEXELS_MAX = 2048; /* maximum side of a resampled texture */

void read_radiance(const json &object, material &m)
{
    const json *stronger = extension(object, "KHR_materials_emissive_strength");
    double      strength = stronger ? number_or(*stronger, "emissiveStrength", 1, 1e30) : 1, factor[3];
    numbers_or(object, "emissiveFactor", 0, factor);
    for (int n = 0; n < 3; n++) m.radiance[n] = (float)(strength * factor[n]);
}

/* The corners of a parallelogram in order, counter-clockwise seen from the front, with texture coordinates. */
struct quad {
    uint32_t element[4]; /* numbers in the placement's accessors */
    double   corner[4][3];
    double   uv[4][2];
};

/* Find the common edge of the two triangles: it is the diagonal between corners 1 and 3. Corner 0 is the other corner of the first
 * triangle, corner 2 that of the second. Returns false when there is no common edge. */
static bool quad_of(const loader &l, const placement &p, size_t first, quad &q)
{
    uint32_t        element[2][3];
    const uint32_t *index = l.s->indices + 3 * first;
    auto            at    = [&](int t, int k) { return l.s->positions_ws + 3 * (size_t)index[3 * t + k % 3]; };
    auto            same  = [&](int k, int other) { return !memcmp(at(0, k), at(1, other), 3 * sizeof(double)); };
    for (size_t t = 0; t < 2; t++) triangle_elements(p, t, element[t]);
    for (int k = 0; k < 3; k++)
        for (int other = 0; other < 3; other++) {
            if (!same(k + 1, other + 1) || !same(k + 2, other)) continue;
            const uint32_t elements[4] = {element[0][k], element[0][(k + 1) % 3], element[1][(other + 2) % 3],
                                          element[0][(k + 2) % 3]};
            const double  *corners[4]  = {at(0, k), at(0, k + 1), at(1, other + 2), at(0, k + 2)};
            memcpy(q.element, elements, sizeof elements);
            for (int n = 0; n < 4; n++) memcpy(q.corner[n], corners[n], sizeof q.corner[n]);
            return true;
        }
    return false;
}

/* 1 when the fourth corner is where the other three imply. */
template <size_t count> static bool is_parallelogram(const double (&corner)[4][count])
{
    double off = 0, size = 0;
    for (size_t n = 0; n < count; n++) {
        off += std::fabs(corner[0][n] + corner[2][n] - corner[1][n] - corner[3][n]);
        size += std::fabs(corner[1][n] - corner[0][n]) + std::fabs(corner[3][n] - corner[0][n]);
    }
    return size > 0 && off <= 1e-4 * size;
}

/* ---- its texture ---- */

static size_t wrapped(double texels, size_t count, texture_wrap wrap)
{
    double n = std::floor(texels), most = (double)count - 1, turn = std::fmod(n, 2.0 * (double)count);
    if (wrap == WRAP_CLAMP) return (size_t)std::min(std::max(n, 0.0), most);
    if (turn < 0) turn += 2.0 * (double)count;
    if (wrap == WRAP_MIRROR) return (size_t)(turn > most ? 2 * most + 1 - turn : turn);
    return (size_t)turn % count;
}

/* Number of texels along a side. */
static uint32_t texels_along(const image_colours &image, const double from[2], const double to[2])
{
    double count = std::hypot((to[0] - from[0]) * image.width_px, (to[1] - from[1]) * image.height_px);
    return (uint32_t)std::min(std::max(std::round(count), 1.0), TEXELS_MAX);
}

static void turn_texture(const image_colours &image, const alpha_mask &wraps, const quad &q, scene_area &area)
{
    uint32_t wide = texels_along(image, q.uv[0], q.uv[1]), high = texels_along(image, q.uv[0], q.uv[3]);
    area.texture = (float *)malloc((size_t)wide * high * 3 * sizeof *area.texture);
    if (!area.texture) throw std::bad_alloc();
    area.wide_px = wide;
    area.high_px = high;
    float *out   = area.texture;
    for (uint32_t y = 0; y < high; y++)
        for (uint32_t x = 0; x < wide; x++) {
            double a = (x + 0.5) / wide, b = (y + 0.5) / high, uv[2];
            for (int n = 0; n < 2; n++) uv[n] = q.uv[0][n] + a * (q.uv[1][n] - q.uv[0][n]) + b * (q.uv[3][n] - q.uv[0][n]);
            size_t         column = wrapped(uv[0] * image.width_px, image.width_px, wraps.wrap_u);
            size_t         row    = wrapped(uv[1] * image.height_px, image.height_px, wraps.wrap_v);
            const uint8_t *from   = image.rgba.data() + 4 * (row * image.width_px + column);
            for (int n = 0; n < 3; n++) *out++ = srgb_light(from[n]);
        }
}

/* Find the texture coordinates of the corners. Returns false where the primitive has none, or where they are not a
 * parallelogram. */
static bool find_corner_uvs(loader &l, const placement &p, const texture_place &place, quad &q)
{
    int accessor = attribute(p.primitive->attributes, "TEXCOORD_" + std::to_string(place.uv_set));
    if (p.draco || accessor < 0) return false;
    sound_accessor(l, "", "texture coordinate", accessor);
    const elements &e = use_accessor(l, (size_t)accessor);
    const double   *t = place.transform;
    if (e.type != TINYGLTF_TYPE_VEC2 || e.count != p.positions->count) return false;
    for (int n = 0; n < 4; n++) {
        double u = e.value(q.element[n], 0), v = e.value(q.element[n], 1);
        q.uv[n][0] = t[0] * u + t[1] * v + t[2];
        q.uv[n][1] = t[3] * u + t[4] * v + t[5];
        if (!(std::fabs(q.uv[n][0]) < 1e6 && std::fabs(q.uv[n][1]) < 1e6)) return false;
    }
    return is_parallelogram(q.uv);
}

/* Add the resampled texture. Returns false where the texture exists but cannot be read. */
static bool add_texture(loader &l, const std::string &where, const json &object, const placement &p, quad &q, scene_area &area)
{
    check_shape(l, where, object, {{"emissiveTexture", is::object}});
    if (!object.contains("emissiveTexture")) return true;
    const json          &info = object["emissiveTexture"], &texture = texture_of(l, where, info);
    const image_colours &image = use_colours(l, texture_image(l, where, texture));
    alpha_mask           wraps = {};
    read_sampler(l, where, texture, wraps);
    if (image.rgba.empty() || !find_corner_uvs(l, p, read_texture_place(l, where, info), q)) return false;
    turn_texture(image, wraps, q, area);
    return true;
}

/* ------------------------------------------------------------------------------------------------------------------------------ */

void append_area(loader &l, const placement &p, size_t first, size_t count)
{
    const material &m = *p.material;
    scene          *s = l.s;
    quad            q = {};
    if (!(m.radiance[0] > 0 || m.radiance[1] > 0 || m.radiance[2] > 0)) return;
    if (p.triangles != 2 || count != 2 || !quad_of(l, p, first, q) || !is_parallelogram(q.corner)) {
        s->dim_count += count;
        return;
    }
    if (!array_reserve(&s->areas, &l.area_capacity, s->area_count + 1, sizeof *s->areas)) throw std::bad_alloc();
    scene_area &area = s->areas[s->area_count];
    area             = {};
    area.part        = (uint32_t)l.parts.size() - 1;
    memcpy(area.corner_ws, q.corner[0], sizeof area.corner_ws);
    memcpy(area.radiance, m.radiance, sizeof area.radiance);
    vec3_sub(q.corner[1], q.corner[0], area.across_ws);
    vec3_sub(q.corner[3], q.corner[0], area.up_ws);
    s->area_count++;

    std::string where = label("material", l.materials, (size_t)p.primitive->material);
    bool        read  = false;
    failure     f =
        caught([&] { read = add_texture(l, where, items(l.rest, "materials")[(size_t)p.primitive->material], p, q, area); });
    if (read) return;
    take_note(l, cost::MATERIAL, (size_t)p.primitive->material, where,
              std::string("its emissiveTexture is not read") + (f ? " (" + f.text + ")" : "") + ": it shines as if it were grey",
              "store it as PNG or WebP, and give it texture coordinates");
    for (float &c : area.radiance) c = (float)(GREY * (double)c);
}

} // namespace gltf
