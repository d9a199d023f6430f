/* Views of cameras (3.10), for pictures. Invalid numbers make a camera without a view; a picture that needs it reports this, and a
 * bake never fails.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/scene/gltf/gltf_loader.h"

#include <cmath>

namespace gltf
{

/* A positive number, or 0 if it is missing or invalid. */
static double above_zero(const json &object, const char *name)
{
    auto value = object.find(name);
    if (value == object.end() || !value->is_number()) return 0;
    double number = value->get<double>();
    return number > 0 && std::isfinite(number) ? number : 0;
}

static void read_projection(const json &camera, scene_view &view)
{
    auto        type        = camera.find("type");
    std::string kind        = type != camera.end() && type->is_string() ? type->get<std::string>() : "";
    const json &perspective = items(camera, "perspective"), &orthographic = items(camera, "orthographic");
    if (kind == "perspective" && perspective.is_object()) {
        double angle   = above_zero(perspective, "yfov");
        view.half_high = angle < M_PI ? std::tan(angle / 2) : 0;
        view.aspect    = above_zero(perspective, "aspectRatio");
        view.near_m    = above_zero(perspective, "znear");
        view.kind      = view.half_high > 0 ? VIEW_PERSPECTIVE : VIEW_NONE;
    } else if (kind == "orthographic" && orthographic.is_object()) {
        double wide    = above_zero(orthographic, "xmag");
        view.half_high = above_zero(orthographic, "ymag");
        view.aspect    = view.half_high > 0 ? wide / view.half_high : 0;
        view.near_m    = above_zero(orthographic, "znear");
        view.kind      = wide > 0 && view.half_high > 0 ? VIEW_ORTHOGRAPHIC : VIEW_NONE;
    }
}

static bool unit(vec3 v, double out[3])
{
    double length = std::hypot(v.x, v.y, v.z), values[3] = {v.x / length, v.y / length, v.z / length};
    if (!(length > 0) || !std::isfinite(length)) return false;
    std::copy(values, values + 3, out);
    return true;
}

/* A camera looks along -Z of its node. Up is +Y, made orthogonal again, because a scale may have changed the angle. */
static bool read_pose(const transform &t, scene_view &view)
{
    vec3 forward = {-t.axis[2].x, -t.axis[2].y, -t.axis[2].z}, up = t.axis[1];
    if (!finite(t.origin) || !unit(forward, view.forward_ws)) return false;
    double along  = up.x * view.forward_ws[0] + up.y * view.forward_ws[1] + up.z * view.forward_ws[2],
           eye[3] = {t.origin.x, t.origin.y, t.origin.z};
    up            = {up.x - along * view.forward_ws[0], up.y - along * view.forward_ws[1], up.z - along * view.forward_ws[2]};
    std::copy(eye, eye + 3, view.eye_ws);
    return unit(up, view.up_ws);
}

void place_views(loader &l)
{
    const json         &cameras = items(l.rest, "cameras");
    std::vector<size_t> nodes;
    for (size_t node : l.order)
        if (l.model.nodes[node].camera >= 0 && (size_t)l.model.nodes[node].camera < cameras.size()) nodes.push_back(node);
    if (nodes.empty()) return;
    l.s->views = (scene_view *)calloc(nodes.size(), sizeof *l.s->views);
    if (!l.s->views) throw std::bad_alloc();
    for (size_t node : nodes) {
        const json &camera = cameras[(size_t)l.model.nodes[node].camera];
        scene_view  view   = {};
        std::string name   = l.model.nodes[node].name;
        auto        own    = camera.find("name");
        if (name.empty() && own != camera.end() && own->is_string()) name = own->get<std::string>();
        if (name.empty()) name = "camera" + std::to_string(l.model.nodes[node].camera);
        read_projection(camera, view);
        if (!read_pose(l.ws_from_node[node], view)) view.kind = VIEW_NONE;
        if (!(view.name = strdup(name.c_str()))) throw std::bad_alloc();
        l.s->views[l.s->view_count++] = view;
    }
}

} // namespace gltf
