/* Lights (KHR_lights_punctual) and cameras (3.10).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/scene/gltf/gltf_loader.h"

#include <cmath>

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

static std::string formatted(const char *format, double value)
{
    char text[200];
    snprintf(text, sizeof text, format, value);
    return text;
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

static void read_range(const json &light, light_definition &out)
{
    double range = number_of(light, "range", INFINITY, out.odd, "none");
    if (!(range > 0))
        out.odd += (out.odd.empty() ? "" : ", ") + formatted("range is %g, expected more than 0: taken as none", range);
    if (range > 0) out.shape.range_m = range;
}

/* Colour and intensity are only for pictures, and to detect dark lights. Missing or invalid ones are 1. */
static void read_colour(const json &light, light_definition &out)
{
    auto   found     = light.find("intensity");
    double intensity = found != light.end() && found->is_number() && std::isfinite(found->get<double>()) ? found->get<double>() : 1;
    numbers_or(light, "color", 1, out.colour);
    if (intensity < 0) out.dark = "its intensity is below 0";
    if (intensity == 0) out.dark = "its intensity is 0";
    if (!out.dark && out.colour[0] + out.colour[1] + out.colour[2] == 0) out.dark = "its colour is black";
    for (double &c : out.colour) c *= out.dark ? 0 : intensity;
}

static light_definition read_light(const json &light)
{
    static const std::map<std::string, light_kind> kinds = {
        {"directional", LIGHT_DIRECTIONAL}, {"spot", LIGHT_SPOT}, {"point", LIGHT_POINT}};
    light_definition out  = {};
    auto             name = light.find("name"), type = light.find("type");
    if (name != light.end() && name->is_string()) out.name = name->get<std::string>();
    bool has_type     = type != light.end() && type->is_string();
    auto kind         = kinds.find(has_type ? type->get<std::string>() : "");
    out.shape.range_m = INFINITY;
    read_colour(light, out);
    if (!has_type) out.fault = "'type' is missing: expected directional, spot or point";
    if (has_type && kind == kinds.end())
        out.fault = "unknown type '" + type->get<std::string>().substr(0, 40) + "', expected directional, spot or point";
    if (!out.fault.empty()) return out;
    out.shape.kind = kind->second;
    if (out.shape.kind == LIGHT_SPOT) read_cone(light, out);
    if (out.shape.kind != LIGHT_DIRECTIONAL) read_range(light, out);
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
    const transform &t       = l.ws_from_node[node];
    vec3             forward = {-t.axis[2].x, -t.axis[2].y, -t.axis[2].z};
    double           length  = std::hypot(forward.x, forward.y, forward.z);
    bool             points  = length > 0 && std::isfinite(length);
    if (light.shape.kind != LIGHT_POINT && !points)
        light.fault = "it has no direction, for its node, or one above it, has a scale of 0";
    if (!finite(t.origin)) light.fault = "it is at infinity";
    if (!points) forward = {0, 0, -1}, length = 1;
    double position[3]  = {t.origin.x, t.origin.y, t.origin.z};
    double direction[3] = {forward.x / length, forward.y / length, forward.z / length};
    memcpy(light.shape.position_ws, position, sizeof position);
    memcpy(light.shape.direction_ws, direction, sizeof direction);
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

static bool uses_light(const loader &l, size_t node)
{
    return l.model.nodes[node].extensions.count("KHR_lights_punctual") || !l.nodes[node].light.empty();
}

static char *duplicate(const std::string &text)
{
    char *copy = strdup(text.c_str());
    if (!copy) throw std::bad_alloc();
    return copy;
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

static void add_lost_light(scene *s, const light_definition &light, const std::string &node_name, size_t node, bool is_hidden)
{
    lost_light *out = &s->lost_lights[s->lost_light_count++];
    out->node       = (uint32_t)node;
    out->name       = duplicate(light.name);
    out->node_name  = duplicate(node_name);
    if (!is_hidden) out->why = duplicate(light.fault + "; mend it in the scene");
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
        if (!uses_light(l, node)) continue;
        nodes.push_back(node);
        used_light(l, node, index);
        users[index]++;
    }
    if (nodes.empty()) return;

    scene *s       = l.s;
    s->lights      = (scene_light *)calloc(nodes.size(), sizeof *s->lights);
    s->lost_lights = (lost_light *)calloc(nodes.size(), sizeof *s->lost_lights);
    if (!s->lights || !s->lost_lights) throw std::bad_alloc();
    for (size_t node : nodes) {
        size_t             index;
        light_definition   light     = used_light(l, node, index);
        const std::string &node_name = l.model.nodes[node].name;
        bool               own       = !light.name.empty() && users[index] == 1;
        if (light.fault.empty()) place_light(l, node, light);
        if (!own && !node_name.empty()) light.name = node_name;
        if (light.name.empty()) light.name = "light" + (index < SIZE_MAX ? std::to_string(index) : "");
        light.name = unique_name(names, light.name);
        if (l.nodes[node].hidden || !light.fault.empty())
            add_lost_light(s, light, node_name, node, l.nodes[node].hidden);
        else
            add_light(s, light, node_name, node);
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

} // namespace gltf
