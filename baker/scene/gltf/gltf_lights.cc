/* Lights (KHR_lights_punctual) and cameras (3.10).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <cmath>

#include "baker/base/array.h"
#include "baker/base/srgb.h"
#include "baker/base/vec3.h"
#include "baker/scene/gltf/gltf_loader.h"

namespace gltf
{

/* A name that is unique in the scene: the second "lamp" becomes "lamp#2". */
static std::string unique_name(std::map<std::string, size_t> &uses, const std::string &name)
{
    std::string candidate = name;
    for (size_t n = ++uses[name]; n > 1; n = ++uses[name]) {
        candidate = name + "#" + std::to_string(n);
        if (++uses[candidate] == 1) break;
    }
    return candidate;
}

/* A number, or `otherwise` if it is missing or invalid. Invalid numbers are accepted with a note, because a bake can do without a
 * name, range or cone. */
static double number_of(const json &object, const char *name, double otherwise, std::string &odd, const char *taken)
{
    auto found = object.find(name);
    if (found == object.end()) return otherwise;
    if (found->is_number() && std::isfinite(found->get<double>())) return found->get<double>();
    odd += std::string(odd.empty() ? "" : ", ") + "'" + name + "' is not a number: taken as " + taken;
    return otherwise;
}

/* Read the cone angles. Some writers round pi/2 to a float slightly above it. A wider spot light becomes a point light: its six
 * maps cover all it can light, and an engine that supports such cones knows their limits. */
static void read_cone(const json &light, light_definition &out)
{
    static const json none = json::object();
    auto              spot = light.find("spot");
    bool              has  = spot != light.end() && spot->is_object();
    if (!has) out.odd = "it has no 'spot' object: its cone is taken as one of 45 degrees";
    const json &cone      = has ? *spot : none;
    double      outer_rad = number_of(cone, "outerConeAngle", M_PI_4, out.odd, "45 degrees");
    out.shape.outer_rad   = std::min(outer_rad, M_PI_2);
    out.inner_rad         = std::min(number_or(cone, "innerConeAngle", 0, M_PI_2), out.shape.outer_rad);
    if (!(outer_rad > 0)) out.fault = formatted("outerConeAngle is %g: expected more than 0", outer_rad);
    if (outer_rad <= M_PI_2 * (1 + 1e-6)) return;
    out.shape.kind = LIGHT_POINT;
    out.odd +=
        (out.odd.empty() ? "" : ", ") + formatted("outerConeAngle is %.4g radians", outer_rad) +
        formatted(outer_rad > M_PI ? ", which %g degrees would be less than: baked as a point light, for all directions"
                                   : " (%.4g degrees), more than the pi/2 of a spot: baked as a point light, for all directions",
                  outer_rad > M_PI ? 180.0 : outer_rad * 180 / M_PI);
}

static light_definition read_light(const json &light)
{
    static const std::map<std::string, light_kind> kinds = {
        {"directional", LIGHT_DIRECTIONAL}, {"spot", LIGHT_SPOT}, {"point", LIGHT_POINT}};
    light_definition out      = {};
    bool             has_type = light.contains("type") && light["type"].is_string();
    std::string      type     = text_of(light, "type");
    auto             kind     = kinds.find(type);
    out.name                  = text_of(light, "name");
    out.shape.range_metres    = INFINITY;

    /* colour and intensity are only for pictures, and to detect dark lights; missing or invalid ones are 1 */
    auto   found     = light.find("intensity");
    double intensity = found != light.end() && found->is_number() && std::isfinite(found->get<double>()) ? found->get<double>() : 1;
    numbers_or(light, "color", 1, out.colour);
    if (intensity < 0) out.dark = "its intensity is below 0";
    if (intensity == 0) out.dark = "its intensity is 0";
    if (!out.dark && out.colour[0] + out.colour[1] + out.colour[2] == 0) out.dark = "its colour is black";
    for (double &c : out.colour) c *= out.dark ? 0 : intensity;

    if (!has_type) out.fault = "'type' is missing: expected directional, spot or point";
    if (has_type && kind == kinds.end())
        out.fault = "unknown type '" + type.substr(0, 40) + "', expected directional, spot or point";
    if (!out.fault.empty()) return out;
    out.shape.kind = kind->second;
    if (out.shape.kind == LIGHT_SPOT) read_cone(light, out);
    if (out.shape.kind == LIGHT_DIRECTIONAL) return out;
    double range = number_of(light, "range", INFINITY, out.odd, "none");
    if (!(range > 0))
        out.odd += (out.odd.empty() ? "" : ", ") + formatted("range is %g, expected more than 0: taken as none", range);
    if (range > 0) out.shape.range_metres = range;
    return out;
}

void read_lights(loader &l, const json &root)
{
    const json *lights = extension(root, "KHR_lights_punctual");
    if (!lights) return;
    const json &list = items(*lights, "lights");
    for (size_t i = 0; list.is_array() && i < list.size(); i++)
        l.lights.push_back(list[i].is_object() ? read_light(list[i]) : read_light(json::object()));
}

/* Compute position and direction from a node, or set the fault. */
static void place_light(loader &l, size_t node, light_definition &light)
{
    const transform &t        = l.ws_from_node[node];
    double           front[3] = {0, 0, -1};
    bool             points   = unit({-t.axis[2].x, -t.axis[2].y, -t.axis[2].z}, front);
    if (light.shape.kind != LIGHT_POINT && !points)
        light.fault = "it has no direction, for its node, or one above it, has a scale of 0";
    if (!finite(t.origin)) light.fault = "it is at infinity";
    memcpy(light.shape.position_ws, &t.origin, sizeof t.origin);
    memcpy(light.shape.direction_ws, front, sizeof front);
}

/* The light definition that a node uses. */
static light_definition used_light(loader &l, size_t node, size_t &index)
{
    const auto      &extensions = l.model.nodes[node].extensions;
    auto             use        = extensions.find("KHR_lights_punctual");
    light_definition none       = {};
    index                       = SIZE_MAX;
    none.fault                  = l.nodes[node].light;
    if (!none.fault.empty()) return none;
    index = (size_t)use->second.Get("light").GetNumberAsInt();
    if (index < l.lights.size()) return l.lights[index];
    none.fault = "light " + std::to_string(index) + " does not exist, the file has " + std::to_string(l.lights.size());
    return none;
}

static void add_light(scene *s, const light_definition &light, const std::string &node_name, size_t node)
{
    scene_light *out = &s->lights[s->light_count++];
    memcpy(out->colour, light.colour, sizeof out->colour);
    out->shape     = light.shape;
    out->inner_rad = light.inner_rad;
    out->node      = (uint32_t)node;
    out->dark      = light.dark;
    out->name      = duplicate(light.name);
    out->node_name = duplicate(node_name);
    if (!light.odd.empty()) out->odd = duplicate(light.odd + "; set it in the scene");
}

/* The name of a light is the name of its definition, if it has one and only one node uses it; else the name of its node. Exporters
 * often omit names of definitions, or share a definition between nodes. */
void place_lights(loader &l)
{
    std::map<std::string, size_t> names;
    std::map<size_t, size_t>      users;
    std::vector<size_t>           nodes;
    for (size_t node : l.order) {
        size_t index;
        if (!l.model.nodes[node].extensions.count("KHR_lights_punctual") && l.nodes[node].light.empty()) continue;
        nodes.push_back(node);
        used_light(l, node, index);
        users[index]++;
    }
    if (nodes.empty()) return;

    scene *s       = l.s;
    s->lights      = zeroed<scene_light>(nodes.size());
    s->lost_lights = zeroed<lost_light>(nodes.size());
    for (size_t node : nodes) {
        size_t             index;
        light_definition   light     = used_light(l, node, index);
        const std::string &node_name = l.model.nodes[node].name;
        bool               own       = !light.name.empty() && users[index] == 1;
        if (light.fault.empty()) place_light(l, node, light);
        if (!own && !node_name.empty()) light.name = node_name;
        if (light.name.empty()) light.name = "light" + (index < SIZE_MAX ? std::to_string(index) : "");
        light.name = unique_name(names, light.name);
        if (!l.nodes[node].hidden && light.fault.empty()) {
            add_light(s, light, node_name, node);
            continue;
        }
        lost_light *lost = &s->lost_lights[s->lost_light_count++];
        lost->node       = (uint32_t)node;
        lost->name       = duplicate(light.name);
        lost->node_name  = duplicate(node_name);
        if (!l.nodes[node].hidden) lost->why = duplicate(light.fault + "; mend it in the scene");
    }
}

/* Cameras of invisible nodes are included (KHR_node_visibility). */
void place_cameras(loader &l)
{
    std::vector<double> positions;
    for (size_t node : l.order) {
        const vec3 &at = l.ws_from_node[node].origin;
        if (l.model.nodes[node].camera < 0) continue;
        if (finite(at))
            positions.insert(positions.end(), {at.x, at.y, at.z});
        else
            take_note(l, cost::CAMERA, node, label("node", l.model.nodes, node), "its camera is at infinity",
                      "mend it in the scene");
    }
    if (positions.empty()) return;
    l.s->camera_positions_ws = copied(positions);
    l.s->camera_count        = positions.size() / 3;
}

/* Area lights, for pictures: two triangles of one primitive that form a parallelogram, with an emissive material: emissiveFactor,
 * times the strength of KHR_materials_emissive_strength, times emissiveTexture (3.9.3). The texture is resampled along the sides of
 * the parallelogram. */

static constexpr double GREY       = 0.45; /* value of a texture that is not read, as for base colours */
static constexpr double TEXELS_MAX = 2048; /* maximum side of a resampled texture */

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
    double u = (to[0] - from[0]) * image.width_px, v = (to[1] - from[1]) * image.height_px, count = std::sqrt(u * u + v * v);
    return (uint32_t)std::min(std::max(std::round(count), 1.0), TEXELS_MAX);
}

static void turn_texture(const image_colours &image, const alpha_mask &wraps, const quad &q, scene_area &area)
{
    uint32_t wide = texels_along(image, q.uv[0], q.uv[1]), high = texels_along(image, q.uv[0], q.uv[3]);
    float    light_of[256];
    for (int n = 0; n < 256; n++) light_of[n] = srgb_light((uint8_t)n);
    area.texture = zeroed<float>((size_t)wide * high * 3);
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
            for (int n = 0; n < 3; n++) *out++ = light_of[from[n]];
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
