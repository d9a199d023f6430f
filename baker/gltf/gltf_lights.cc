/* Lights (KHR_lights_punctual) and cameras (3.10).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/gltf/gltf_loader.h"

#include <cmath>
#include <nlohmann/json.hpp>

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

/* A member that is a number, or `absent`. */
static vxs_result number(loader &l, const std::string &where, const json &object, const char *name, double absent, double &value)
{
    auto found = object.find(name);
    value      = absent;
    if (found == object.end()) return VXS_OK;
    if (!found->is_number()) return l.error(VXS_E_SCENE, "%s: '%s' is not a number", where.c_str(), name);
    value = found->get<double>();
    return VXS_OK;
}

/* Angles between the light's direction and the edge of its cone. Writers that round pi/2 to float go beyond it a little, and some
 * let the inner cone be as wide as the outer. */
static vxs_result read_cone(loader &l, const std::string &where, const json &light, double &outer_rad)
{
    auto spot = light.find("spot");
    if (spot == light.end() || !spot->is_object())
        return l.error(VXS_E_SCENE, "%s: a spot light without a 'spot' object", where.c_str());

    vxs_result r;
    double     inner_rad;
    if ((r = number(l, where, *spot, "outerConeAngle", M_PI_4, outer_rad)) != VXS_OK) return r;
    if ((r = number(l, where, *spot, "innerConeAngle", 0, inner_rad)) != VXS_OK) return r;
    if (!(outer_rad > 0) || outer_rad > M_PI_2 * (1 + 1e-6))
        return l.error(VXS_E_SCENE, "%s: outerConeAngle is %g, expected more than 0 and at most pi/2", where.c_str(), outer_rad);
    if (!(inner_rad >= 0) || inner_rad > outer_rad)
        return l.error(VXS_E_SCENE, "%s: innerConeAngle is %g, expected 0 to outerConeAngle, %g", where.c_str(), inner_rad,
                       outer_rad);
    outer_rad = std::min(outer_rad, M_PI_2);
    return VXS_OK;
}

static vxs_result read_light(loader &l, const std::string &where, const json &light, light_shape &shape)
{
    const std::string &type = light["type"].get_ref<const std::string &>();
    if (type == "directional")
        shape.kind = LIGHT_DIRECTIONAL;
    else if (type == "spot")
        shape.kind = LIGHT_SPOT;
    else if (type == "point")
        shape.kind = LIGHT_POINT;
    else
        return l.error(VXS_E_SCENE, "%s: unknown type '%s', expected directional, spot or point", where.c_str(), type.c_str());

    vxs_result r = number(l, where, light, "range", INFINITY, shape.range_m);
    if (r != VXS_OK) return r;
    if (!(shape.range_m > 0)) return l.error(VXS_E_SCENE, "%s: range is %g, expected more than 0", where.c_str(), shape.range_m);
    return shape.kind == LIGHT_SPOT ? read_cone(l, where, light, shape.outer_rad) : VXS_OK;
}

vxs_result read_lights(loader &l, const json &root)
{
    vxs_result  r;
    const json *lights = extension(root, "KHR_lights_punctual");
    if (!lights) return VXS_OK;
    if ((r = check_shape(l, "KHR_lights_punctual", *lights, {{"lights", is::objects, true}})) != VXS_OK) return r;
    if ((r = check_list(l, *lights, "lights", "light", {{"name", is::text}, {"type", is::text, true}})) != VXS_OK) return r;
    for (const json &light : items(*lights, "lights")) {
        light_definition d     = {light.value("name", ""), {}};
        std::string      where = label("light", l.lights.size(), d.name);
        if ((r = read_light(l, where, light, d.shape)) != VXS_OK) return r;
        l.lights.push_back(d);
    }
    return VXS_OK;
}

static vxs_result light_at(loader &l, size_t node_index, size_t light_index, scene_light &out)
{
    const transform &t     = l.ws_from_node[node_index];
    std::string      where = label("node", node_index, l.model.nodes[node_index].name);
    out.shape              = l.lights[light_index].shape;

    vec3   forward = {-t.axis[2].x, -t.axis[2].y, -t.axis[2].z};
    double length  = std::hypot(forward.x, forward.y, forward.z);
    if (out.shape.kind != LIGHT_POINT && (!(length > 0) || !std::isfinite(length)))
        return l.error(VXS_E_SCENE, "%s: its light has no direction", where.c_str());
    if (!finite(t.origin)) return l.error(VXS_E_SCENE, "%s: its light is at infinity", where.c_str());
    if (!(length > 0) || !std::isfinite(length)) forward = {0, 0, -1}, length = 1;
    double position[3]  = {t.origin.x, t.origin.y, t.origin.z};
    double direction[3] = {forward.x / length, forward.y / length, forward.z / length};
    memcpy(out.shape.position_ws, position, sizeof position);
    memcpy(out.shape.direction_ws, direction, sizeof direction);
    return VXS_OK;
}

vxs_result place_lights(loader &l)
{
    std::map<std::string, size_t> uses;
    std::vector<scene_light>      lights;
    std::vector<std::string>      names;
    for (int node : l.order) {
        const auto &extensions = l.model.nodes[(size_t)node].extensions;
        auto        use        = extensions.find("KHR_lights_punctual");
        if (use == extensions.end()) continue;
        size_t      index = (size_t)use->second.Get("light").GetNumberAsInt();
        std::string name  = l.lights[index].name;
        scene_light light = {};
        vxs_result  r     = light_at(l, (size_t)node, index, light);
        if (r != VXS_OK) return r;
        names.push_back(unique_name(uses, name.empty() ? "light" + std::to_string(index) : name));
        lights.push_back(light);
    }
    if (lights.empty()) return VXS_OK;

    l.s->lights = (scene_light *)calloc(lights.size(), sizeof *l.s->lights);
    if (!l.s->lights) throw std::bad_alloc();
    for (size_t i = 0; i < lights.size(); i++) {
        l.s->lights[i]      = lights[i];
        l.s->lights[i].name = strdup(names[i].c_str());
        l.s->light_count    = i + 1;
        if (!l.s->lights[i].name) throw std::bad_alloc();
    }
    return VXS_OK;
}

vxs_result place_cameras(loader &l)
{
    std::vector<double> positions;
    for (int index : l.order) {
        const tinygltf::Node &node = l.model.nodes[(size_t)index];
        const vec3           &at   = l.ws_from_node[(size_t)index].origin;
        if (node.camera < 0) continue;
        if (!finite(at))
            return l.error(VXS_E_SCENE, "%s: its camera is at infinity", label("node", (size_t)index, node.name).c_str());
        positions.insert(positions.end(), {at.x, at.y, at.z});
    }
    if (positions.empty()) return VXS_OK;

    l.s->camera_positions_ws = (double *)malloc(positions.size() * sizeof(double));
    if (!l.s->camera_positions_ws) throw std::bad_alloc();
    memcpy(l.s->camera_positions_ws, positions.data(), positions.size() * sizeof(double));
    l.s->camera_count = positions.size() / 3;
    return VXS_OK;
}

} // namespace gltf
