/* Nodes (3.5): transforms, the tree, and the scene that is asked for.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/gltf/gltf_loader.h"

#include <cmath>
#include <set>

namespace gltf
{

transform multiply(const transform &a, const transform &b)
{
    return {{rotate_scale(a, b.axis[0]), rotate_scale(a, b.axis[1]), rotate_scale(a, b.axis[2])}, apply(a, b.origin)};
}

bool trs_transform(const double translation[3], const double rotation[4], const double scale[3], transform &t)
{
    double x = rotation[0], y = rotation[1], z = rotation[2], w = rotation[3];
    double length = std::sqrt(x * x + y * y + z * z + w * w);
    double sx = scale[0], sy = scale[1], sz = scale[2];
    if (!(length > 0) || !std::isfinite(length)) return false;
    x /= length, y /= length, z /= length, w /= length;
    t = {{{sx * (1 - 2 * (y * y + z * z)), sx * 2 * (x * y + z * w), sx * 2 * (x * z - y * w)},
          {sy * 2 * (x * y - z * w), sy * (1 - 2 * (x * x + z * z)), sy * 2 * (y * z + x * w)},
          {sz * 2 * (x * z + y * w), sz * 2 * (y * z - x * w), sz * (1 - 2 * (x * x + y * y))}},
         {translation[0], translation[1], translation[2]}};
    return true;
}

double volume_scale(const transform &t)
{
    const vec3 *a = t.axis;
    return a[0].x * (a[1].y * a[2].z - a[1].z * a[2].y) - a[0].y * (a[1].x * a[2].z - a[1].z * a[2].x) +
           a[0].z * (a[1].x * a[2].y - a[1].y * a[2].x);
}

bool is_mirrored(const transform &t)
{
    return volume_scale(t) < 0;
}

static transform node_transform(loader &l, size_t index)
{
    const tinygltf::Node      &node  = l.model.nodes[index];
    const std::vector<double> &m     = node.matrix;
    std::string                where = label("node", index, node.name);
    if (!m.empty()) {
        if (std::fabs(m[3]) + std::fabs(m[7]) + std::fabs(m[11]) + std::fabs(m[15] - 1) > 1e-6)
            l.broken(where, "the last row of its matrix is not 0, 0, 0, 1");
        return {{{m[0], m[1], m[2]}, {m[4], m[5], m[6]}, {m[8], m[9], m[10]}}, {m[12], m[13], m[14]}};
    }

    double    translation[3] = {0, 0, 0}, rotation[4] = {0, 0, 0, 1}, scale[3] = {1, 1, 1};
    transform t;
    std::copy(node.translation.begin(), node.translation.end(), translation);
    std::copy(node.rotation.begin(), node.rotation.end(), rotation);
    std::copy(node.scale.begin(), node.scale.end(), scale);
    if (!trs_transform(translation, rotation, scale, t)) l.broken(where, "its rotation is not a unit quaternion");
    return t;
}

/* Nodes form a forest: every child exists and has one parent, and every node hangs from a root. */
std::vector<int> check_tree(loader &l)
{
    const auto      &nodes = l.model.nodes;
    std::vector<int> parent(nodes.size(), -1), open;
    for (size_t i = 0; i < nodes.size(); i++)
        for (int child : nodes[i].children) {
            if ((size_t)child >= nodes.size()) l.broken("", "node %zu: child %d does not exist", i, child);
            if (parent[child] >= 0) l.broken("", "node %d has two parents, node %d and node %zu", child, parent[child], i);
            parent[child] = (int)i;
        }

    std::vector<char> reached(nodes.size(), 0);
    for (size_t i = 0; i < nodes.size(); i++)
        if (parent[i] < 0) open.push_back((int)i);
    while (!open.empty()) {
        int at = open.back();
        open.pop_back();
        reached[at] = 1;
        open.insert(open.end(), nodes[at].children.begin(), nodes[at].children.end());
    }
    for (size_t i = 0; i < nodes.size(); i++)
        if (!reached[i]) l.broken("", "node %zu is in a loop of nodes", i);
    return parent;
}

void check_references(loader &l)
{
    const tinygltf::Model &model = l.model;
    for (size_t i = 0; i < model.nodes.size(); i++) {
        const tinygltf::Node &node  = model.nodes[i];
        auto                  use   = node.extensions.find("KHR_lights_punctual");
        int                   light = use == node.extensions.end() ? -1 : use->second.Get("light").GetNumberAsInt();
        struct {
            const char *kind;
            int         index;
            size_t      count;
        } references[] = {{"mesh", node.mesh, model.meshes.size()},
                          {"skin", node.skin, model.skins.size()},
                          {"camera", node.camera, l.camera_count},
                          {"light", light, l.lights.size()}};
        for (const auto &reference : references)
            if (reference.index >= 0 && (size_t)reference.index >= reference.count)
                l.broken(label("node", model.nodes, i), "%s %d does not exist, the file has %zu", reference.kind, reference.index,
                         reference.count);
    }
}

int choose_scene(loader &l, const char *which)
{
    const auto &scenes = l.model.scenes;
    if (!which) {
        int chosen = l.model.defaultScene >= 0 ? l.model.defaultScene : scenes.empty() ? -1 : 0;
        if (chosen >= 0 && (size_t)chosen >= scenes.size())
            l.broken("", "its default scene %d does not exist, the file has %zu", chosen, scenes.size());
        return chosen;
    }
    for (size_t i = 0; i < scenes.size(); i++)
        if (*which && scenes[i].name == which) return (int)i;

    size_t digits = strspn(which, "0123456789");
    if (digits && !which[digits] && digits < 10 && strtoul(which, nullptr, 10) < scenes.size())
        return (int)strtoul(which, nullptr, 10);

    std::string known;
    for (size_t i = 0; i < scenes.size() && known.size() < 200; i++) known += (i ? ", " : ": ") + label("scene", scenes, i);
    l.error(VXS_E_ARGUMENT, "no scene '%s'; the file has %zu%s", which, scenes.size(), known.c_str());
}

void choose_roots(loader &l, int chosen, const std::vector<int> &parent)
{
    for (size_t i = 0; chosen < 0 && i < parent.size(); i++)
        if (parent[i] < 0) l.roots.push_back(i);
    if (chosen < 0) return;

    std::string   where = label("scene", (size_t)chosen);
    std::set<int> seen;
    for (int node : l.model.scenes[chosen].nodes) {
        if ((size_t)node >= parent.size()) l.broken(where, "node %d does not exist", node);
        if (parent[node] >= 0) l.broken(where, "node %d is not a root, its parent is node %d", node, parent[node]);
        if (!seen.insert(node).second) l.broken("", "%s lists node %d twice", where.c_str(), node);
        l.roots.push_back((size_t)node);
    }
}

/* Parents come before children, children in the file's order; no recursion, for trees may be deep. */
void place_nodes(loader &l, const std::vector<int> &parent)
{
    std::vector<size_t> open(l.roots.rbegin(), l.roots.rend());
    l.ws_from_node.resize(l.model.nodes.size());
    while (!open.empty()) {
        size_t at = open.back();
        open.pop_back();
        transform &t = l.ws_from_node[at];
        t            = node_transform(l, at);
        if (parent[at] >= 0) t = multiply(l.ws_from_node[parent[at]], t);
        l.order.push_back(at);
        const auto &children = l.model.nodes[at].children;
        open.insert(open.end(), children.rbegin(), children.rend());
    }
}

} // namespace gltf
