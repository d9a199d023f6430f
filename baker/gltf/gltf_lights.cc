/* Lights (KHR_lights_punctual) and cameras (3.10).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/gltf/gltf_loader.h"

#include <cmath>

namespace gltf
{

/* A name that no other light of the scene has: the second "lamp" becomes "lamp#2". */
static std::string unique_name(std::map<std::string, size_t> &uses, const std::string &name)
{
    std::string candidate = name;
    for (size_t n = ++uses[name]; n > 1; n = ++uses[name]) {
        candidate = name + "#" + std::to_string(n);
        if (++uses[candidate] == 1) break;
    }
    return candidate;
}

/* Angles between the light's direction and the edge of its cone. Writers that round pi/2 to float go beyond it a little, and some
 * let the inner cone be as wide as the outer. */
static double read_cone(loader &l, const std::string &where, const json &light)
{
    auto spot = light.find("spot");
    if (spot == light.end() || !spot->is_object()) l.broken(where, "a spot light without a 'spot' object");
    check_shape(l, where, *spot, {{"outerConeAngle", is::number}, {"innerConeAngle", is::number}});
    double outer_rad = spot->value("outerConeAngle", M_PI_4), inner_rad = spot->value("innerConeAngle", 0.0);
    if (!(outer_rad > 0) || outer_rad > M_PI_2 * (1 + 1e-6))
        l.broken(where, "outerConeAngle is %g, expected more than 0 and at most pi/2", outer_rad);
    if (!(inner_rad >= 0) || inner_rad > outer_rad)
        l.broken(where, "innerConeAngle is %g, expected 0 to outerConeAngle, %g", inner_rad, outer_rad);
    return std::min(outer_rad, M_PI_2);
}

static light_shape read_light(loader &l, const std::string &where, const json &light)
{
    static const std::map<std::string, light_kind> kinds = {
        {"directional", LIGHT_DIRECTIONAL}, {"spot", LIGHT_SPOT}, {"point", LIGHT_POINT}};
    std::string type = light["type"];
    auto        kind = kinds.find(type);
    light_shape out  = {};
    if (kind == kinds.end()) l.broken(where, "unknown type '%s', expected directional, spot or point", type.c_str());
    check_shape(l, where, light, {{"range", is::number}});
    out.kind    = kind->second;
    out.range_m = light.value("range", (double)INFINITY);
    if (!(out.range_m > 0)) l.broken(where, "range is %g, expected more than 0", out.range_m);
    if (out.kind == LIGHT_SPOT) out.outer_rad = read_cone(l, where, light);
    return out;
}

/* Only pictures ask: what is no colour or no intensity is 1, as when nothing is said. */
static light_definition described_light(const std::string &name, const light_shape &shape, const json &light)
{
    light_definition out       = {name, shape, {1, 1, 1}, 0};
    double           intensity = number_or(light, "intensity", 1, INFINITY);
    numbers_or(light, "color", 1, out.colour);
    for (double &c : out.colour) c *= intensity;
    if (shape.kind == LIGHT_SPOT) out.inner_rad = std::min(light["spot"].value("innerConeAngle", 0.0), shape.outer_rad);
    return out;
}

void read_lights(loader &l, const json &root)
{
    const json *lights = extension(root, "KHR_lights_punctual");
    if (!lights) return;
    check_shape(l, "KHR_lights_punctual", *lights, {{"lights", is::objects, true}});
    check_list(l, *lights, "lights", "light", {{"name", is::text}, {"type", is::text, true}});
    for (const json &light : items(*lights, "lights")) {
        std::string name = light.value("name", "");
        l.lights.push_back(described_light(name, read_light(l, label("light", l.lights.size(), name), light), light));
    }
}

static light_shape placed_light(loader &l, size_t node, light_shape light)
{
    const transform &t       = l.ws_from_node[node];
    std::string      where   = label("node", l.model.nodes, node);
    vec3             forward = {-t.axis[2].x, -t.axis[2].y, -t.axis[2].z};
    double           length  = std::hypot(forward.x, forward.y, forward.z);
    bool             points  = length > 0 && std::isfinite(length);
    if (light.kind != LIGHT_POINT && !points) l.broken(where, "its light has no direction");
    if (!finite(t.origin)) l.broken(where, "its light is at infinity");
    if (!points) forward = {0, 0, -1}, length = 1;
    double position[3]  = {t.origin.x, t.origin.y, t.origin.z};
    double direction[3] = {forward.x / length, forward.y / length, forward.z / length};
    memcpy(light.position_ws, position, sizeof position);
    memcpy(light.direction_ws, direction, sizeof direction);
    return light;
}

void place_lights(loader &l)
{
    std::map<std::string, size_t> uses;
    std::vector<light_definition> lights;
    for (size_t node : l.order) {
        const auto &extensions = l.model.nodes[node].extensions;
        auto        use        = extensions.find("KHR_lights_punctual");
        if (use == extensions.end()) continue;
        size_t                  index = (size_t)use->second.Get("light").GetNumberAsInt();
        const light_definition &light = l.lights[index];
        light_shape             shape = placed_light(l, node, light.shape);
        lights.push_back(light);
        lights.back().name  = unique_name(uses, light.name.empty() ? "light" + std::to_string(index) : light.name);
        lights.back().shape = shape;
    }
    if (lights.empty()) return;

    l.s->lights = (scene_light *)calloc(lights.size(), sizeof *l.s->lights);
    if (!l.s->lights) throw std::bad_alloc();
    for (const light_definition &light : lights) {
        char *name = strdup(light.name.c_str());
        if (!name) throw std::bad_alloc();
        l.s->lights[l.s->light_count++] = {name, light.shape, {light.colour[0], light.colour[1], light.colour[2]}, light.inner_rad};
    }
}

void place_cameras(loader &l)
{
    std::vector<double> positions;
    for (size_t node : l.order) {
        const vec3 &at = l.ws_from_node[node].origin;
        if (l.model.nodes[node].camera < 0) continue;
        if (!finite(at)) l.broken(label("node", l.model.nodes, node), "its camera is at infinity");
        positions.insert(positions.end(), {at.x, at.y, at.z});
    }
    if (positions.empty()) return;
    l.s->camera_positions_ws = copied(positions);
    l.s->camera_count        = positions.size() / 3;
}

} // namespace gltf
