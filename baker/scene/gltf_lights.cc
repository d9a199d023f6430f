/* Lights (KHR_lights_punctual) and cameras (3.10).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/scene/gltf_loader.h"

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

static vxs_result light_at(loader &l, size_t node_index, size_t light_index, scene_light &out)
{
    const tinygltf::Light &light = l.model.lights[light_index];
    const transform       &t     = l.ws_from_node[node_index];
    std::string            where = label("node", node_index, l.model.nodes[node_index].name);
    if (light.type == "directional")
        out.shape.kind = LIGHT_DIRECTIONAL;
    else if (light.type == "spot")
        out.shape.kind = LIGHT_SPOT;
    else if (light.type == "point")
        out.shape.kind = LIGHT_POINT;
    else
        return l.error(VXS_E_SCENE, "%s: unknown type '%s', expected directional, spot or point",
                       label("light", light_index, light.name).c_str(), light.type.c_str());

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
        std::string name  = l.model.lights[index].name;
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
