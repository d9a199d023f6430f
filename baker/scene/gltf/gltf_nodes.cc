/* Nodes (3.5): transforms, the tree, and the selected scene.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <cmath>
#include <set>

#include "baker/scene/gltf/gltf_loader.h"

/* EXT_mesh_gpu_instancing: a node's mesh is placed once for each element of TRANSLATION, ROTATION and SCALE. */

namespace gltf
{

static const char *const NAME = "EXT_mesh_gpu_instancing";

/* Accessor number of an attribute of the extension, or -1. The JSON shape is already checked. */
static int instance_accessor(const tinygltf::Node &node, const char *name)
{
    const tinygltf::Value &attributes = node.extensions.at(NAME).Get("attributes");
    return attributes.Has(name) ? attributes.Get(name).GetNumberAsInt() : -1;
}

/* The extension requires floats for TRANSLATION and SCALE, and floats or normalised integers for ROTATION. The loader accepts all
 * component types except 32-bit integers. */
static void check_attribute(loader &l, size_t node, const char *name, int type, size_t &count)
{
    int index = instance_accessor(l.model.nodes[node], name);
    if (index < 0) return;
    std::string where = label("node", l.model.nodes, node) + " " + NAME + " " + name;
    if ((size_t)index >= l.accessors.size()) l.broken(where, "accessor %d does not exist", index);
    const elements &e = sound_accessor(l, where, name, index);
    if (e.type != type) l.broken(where, "accessor %d is not a %s", index, type == TINYGLTF_TYPE_VEC3 ? "VEC3" : "VEC4");
    if (e.component == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT) l.broken(where, "accessor %d is of 32-bit integers", index);
    if (count != SIZE_MAX && e.count != count) l.broken(where, "%zu elements, the attribute before has %zu", e.count, count);
    count = e.count;
}

static size_t read_count(loader &l, size_t node)
{
    const tinygltf::Node &n     = l.model.nodes[node];
    std::string           where = label("node", node, n.name) + " " + NAME;
    size_t                found = SIZE_MAX;
    check_attribute(l, node, "TRANSLATION", TINYGLTF_TYPE_VEC3, found);
    check_attribute(l, node, "ROTATION", TINYGLTF_TYPE_VEC4, found);
    check_attribute(l, node, "SCALE", TINYGLTF_TYPE_VEC3, found);
    for (const auto &other : n.extensions.at(NAME).Get("attributes").Get<tinygltf::Value::Object>()) {
        size_t index = (size_t)other.second.GetNumberAsInt();
        if (index >= l.accessors.size()) l.broken(where, "accessor %zu does not exist", index);
        /* without the three attributes above, another one gives the number of instances, all at the node's place */
        if (found == SIZE_MAX) found = l.accessors[index].count;
    }
    if (found == SIZE_MAX) l.error(VXS_E_SCENE, "%s has no attributes", where.c_str());
    return found;
}

/* Note why a node's mesh cannot be placed. */
static void lose_instances(loader &l, size_t node, const failure &f)
{
    const std::string &name = l.model.nodes[node].name;
    l.nodes[node].instances = 0;
    take_fault(l, cost::INSTANCES, node, label("node", node, name), f, "mend it, or " + exclude_remedy("node:", node, name));
}

size_t count_instances(loader &l, size_t node)
{
    const tinygltf::Node &n     = l.model.nodes[node];
    node_state           &state = l.nodes[node];
    if (state.counted) return state.instances;
    state.counted   = true;
    state.instances = 1;
    if (n.skin >= 0) return 1; /* a skinned mesh is placed by its joints */
    failure f = state.instancing;
    if (!f && n.extensions.count(NAME)) f = fault_of([&] { state.instances = read_count(l, node); });
    if (f) lose_instances(l, node, f);
    return state.instances;
}

size_t usable_instances(loader &l, size_t node)
{
    if (!count_instances(l, node)) return 0;
    failure f = fault_of([&] { instance_transform(l, node, 0); });
    if (f) lose_instances(l, node, f);
    return l.nodes[node].instances;
}

static void read_values(loader &l, int accessor, size_t i, size_t count, double *values)
{
    if (accessor < 0) return;
    const elements &e = use_accessor(l, (size_t)accessor);
    for (size_t k = 0; k < count; k++) values[k] = e.value(i, k);
}

transform instance_transform(loader &l, size_t node, size_t i)
{
    const tinygltf::Node &n = l.model.nodes[node];
    if (!n.extensions.count(NAME) || n.skin >= 0) return l.ws_from_node[node];

    double    translation[3] = {0, 0, 0}, rotation[4] = {0, 0, 0, 1}, scale[3] = {1, 1, 1};
    transform node_from_instance;
    read_values(l, instance_accessor(n, "TRANSLATION"), i, 3, translation);
    read_values(l, instance_accessor(n, "ROTATION"), i, 4, rotation);
    read_values(l, instance_accessor(n, "SCALE"), i, 3, scale);
    if (!trs_transform(translation, rotation, scale, node_from_instance)) {
        take_note(l, cost::TREE, (uint64_t)1 << 48 | node, label("node", node, n.name) + " " + NAME,
                  "ROTATION " + std::to_string(i) + " is not a unit quaternion: taken as none", "export it again");
        const double none[4] = {0, 0, 0, 1};
        trs_transform(translation, none, scale, node_from_instance);
    }
    return multiply(l.ws_from_node[node], node_from_instance);
}

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

transform node_transform(loader &l, size_t index)
{
    const tinygltf::Node      &node  = l.model.nodes[index];
    const std::vector<double> &m     = node.matrix;
    std::string                where = label("node", index, node.name);
    if (l.nodes[index].fault) throw l.nodes[index].fault;
    if (!m.empty()) {
        /* some exporters write matrices row by row: then the translation is in the last row */
        bool by_rows = m[12] == 0 && m[13] == 0 && m[14] == 0 && m[15] == 1 && (m[3] != 0 || m[7] != 0 || m[11] != 0);
        if (std::fabs(m[3]) + std::fabs(m[7]) + std::fabs(m[11]) + std::fabs(m[15] - 1) > 1e-6)
            l.broken(where, "the last row of its matrix is not 0, 0, 0, 1%s",
                     by_rows ? " (it seems to be written by rows, not by columns)" : "");
        return {{{m[0], m[1], m[2]}, {m[4], m[5], m[6]}, {m[8], m[9], m[10]}}, {m[12], m[13], m[14]}};
    }

    double    translation[3] = {0, 0, 0}, rotation[4] = {0, 0, 0, 1}, scale[3] = {1, 1, 1};
    transform t;
    std::copy(node.translation.begin(), node.translation.end(), translation);
    std::copy(node.rotation.begin(), node.rotation.end(), rotation);
    std::copy(node.scale.begin(), node.scale.end(), scale);
    if (trs_transform(translation, rotation, scale, t)) return t;
    if (rotation[0] != 0 || rotation[1] != 0 || rotation[2] != 0 || rotation[3] != 0)
        l.broken(where, "its rotation is not a unit quaternion");
    /* as in all viewers: zeros mean no rotation */
    take_note(l, cost::TREE, index, where, "its rotation is 0, 0, 0, 0, not a unit quaternion: taken as none", "export it again");
    rotation[3] = 1;
    trs_transform(translation, rotation, scale, t);
    return t;
}

/* Remove children that do not exist or are listed twice. */
static void mend_children(loader &l, size_t index)
{
    auto            &children = l.model.nodes[index].children;
    std::set<int>    seen;
    std::vector<int> kept;
    std::string      where = label("node", index, l.model.nodes[index].name);
    for (int child : children) {
        bool        exists = (size_t)child < l.model.nodes.size();
        std::string what   = "child " + std::to_string(child);
        if (exists && seen.insert(child).second)
            kept.push_back(child);
        else if (exists)
            take_note(l, cost::TREE, index, where, what + " is listed twice: it is placed once", "export it again");
        else
            take_fault(l, cost::TREE, index, where, {VXS_E_SCENE, where + ": " + what + " does not exist: ignored", false},
                       "export it again");
    }
    children = kept;
}

/* Check that nodes form a forest: each node has at most one parent and a root above it. With two parents the intended one is
 * unknown. */
std::vector<int> check_tree(loader &l)
{
    const auto      &nodes = l.model.nodes;
    std::vector<int> parent(nodes.size(), -1), open;
    for (size_t i = 0; i < nodes.size(); i++) {
        mend_children(l, i);
        for (int child : nodes[i].children) {
            if (parent[child] >= 0)
                l.refused("", "%s has two parents, node %d and %s: a node may be a child of one; make a copy of it for the other",
                          label("node", nodes, (size_t)child).c_str(), parent[child], label("node", i).c_str());
            parent[child] = (int)i;
        }
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
        if (!reached[i])
            l.refused("", "%s is in a loop of nodes, each a child of the one before: take it out of the children of one of them",
                      label("node", nodes, i).c_str());
    return parent;
}

/* Remove references to missing objects from the nodes of the scene. Lights are checked where they are placed. */
void check_references(loader &l)
{
    tinygltf::Model &model = l.model;
    for (size_t i : l.order) {
        tinygltf::Node &node = model.nodes[i];
        struct {
            const char *kind;
            int        *index;
            size_t      count;
        } references[] = {{"mesh", &node.mesh, model.meshes.size()},
                          {"skin", &node.skin, l.skins.size()},
                          {"camera", &node.camera, l.camera_count}};
        for (const auto &reference : references) {
            if (*reference.index < 0 || (size_t)*reference.index < reference.count) continue;
            std::string where = label("node", model.nodes, i), text = reference.kind;
            text += " " + std::to_string(*reference.index) + " does not exist, the file has " + std::to_string(reference.count);
            take_fault(l, cost::REFERENCE, 16 * i + (size_t)(&reference - references), where,
                       {VXS_E_SCENE, where + ": " + text, false}, "export it again");
            *reference.index = -1;
        }
    }
}

/* The scene to load if no option selects one. */
static int default_scene(loader &l)
{
    const auto &scenes = l.model.scenes;
    int         named  = l.model.defaultScene;
    std::string count  = std::to_string(scenes.size()),
                first  = scenes.empty() ? "all nodes without a parent are taken" : label("scene", scenes, 0) + " is taken";
    if (named >= 0 && (size_t)named < scenes.size()) return named;
    if (named >= 0)
        take_fault(l, cost::TREE, SIZE_MAX, "glTF",
                   {VXS_E_SCENE,
                    "its default scene " + std::to_string(named) + " does not exist, the file has " + count + ": " + first, false},
                   "set it, or choose with --scene");
    else if (scenes.size() > 1)
        take_note(l, cost::TREE, SIZE_MAX, "glTF", "it has " + count + " scenes, and says of none that it is the default: " + first,
                  "set 'scene', or choose with --scene");
    return scenes.empty() ? -1 : 0;
}

int choose_scene(loader &l, const char *which)
{
    const auto &scenes = l.model.scenes;
    if (!which) return default_scene(l);
    for (size_t i = 0; i < scenes.size(); i++)
        if (*which && scenes[i].name == which) return (int)i;

    size_t digits = strspn(which, "0123456789");
    if (digits && !which[digits] && digits < 10 && strtoul(which, nullptr, 10) < scenes.size())
        return (int)strtoul(which, nullptr, 10);

    std::string known;
    for (size_t i = 0; i < scenes.size() && known.size() < 200; i++) known += (i ? ", " : ": ") + label("scene", scenes, i);
    l.error(VXS_E_ARGUMENT, "no scene '%s'; the file has %zu%s", which, scenes.size(), known.c_str());
}

/* True when a node's own transform is not the identity, or cannot be read. */
static bool is_moved(loader &l, size_t node)
{
    transform t   = {};
    failure   f   = fault_of([&] { t = node_transform(l, node); });
    double    off = std::fabs(t.axis[0].x - 1) + std::fabs(t.axis[1].y - 1) + std::fabs(t.axis[2].z - 1);
    for (double n :
         {t.axis[0].y, t.axis[0].z, t.axis[1].x, t.axis[1].z, t.axis[2].x, t.axis[2].y, t.origin.x, t.origin.y, t.origin.z})
        off += std::fabs(n);
    return f || off > 0;
}

/* Mark the nodes that are below a listed node. */
static std::vector<char> find_covered(const loader &l, const std::vector<int> &parent, const std::vector<char> &listed)
{
    std::vector<char> covered(parent.size(), 0);
    std::vector<int>  open;
    for (size_t i = 0; i < parent.size(); i++)
        if (parent[i] < 0) open.push_back((int)i);
    while (!open.empty()) {
        int at = open.back();
        open.pop_back();
        for (int child : l.model.nodes[at].children) {
            covered[child] = covered[at] || listed[at];
            open.push_back(child);
        }
    }
    return covered;
}

/* A scene lists its roots. If a listed node is below another listed node, it is placed only once. A listed node whose parent is not
 * in the scene is a root.
 * parent  [out] -1 for roots */
void choose_roots(loader &l, int chosen, std::vector<int> &parent)
{
    for (size_t i = 0; chosen < 0 && i < parent.size(); i++)
        if (parent[i] < 0) l.roots.push_back(i);
    if (chosen < 0) return;
    if (l.faults[SCENES].count((size_t)chosen)) throw l.faults[SCENES][(size_t)chosen];

    const auto       &nodes = l.model.nodes;
    std::string       where = label("scene", (size_t)chosen);
    std::vector<char> listed(parent.size(), 0), taken(parent.size(), 0);
    for (int node : l.model.scenes[chosen].nodes)
        if ((size_t)node < parent.size()) listed[node] = 1;
    std::vector<char> covered = find_covered(l, parent, listed);
    for (int node : l.model.scenes[chosen].nodes) {
        bool exists = (size_t)node < parent.size();
        if (exists && !taken[node] && !covered[node] && parent[node] < 0) {
            taken[node] = 1;
            l.roots.push_back((size_t)node);
            continue;
        }
        std::string name   = label("node", (size_t)node, exists ? nodes[node].name : ""), why,
                    remedy = "list the roots alone in the scene's nodes";
        uint64_t id        = (uint64_t)node + ((uint64_t)1 << 32);
        if (!exists) {
            take_fault(l, cost::TREE, id, where, {VXS_E_SCENE, where + ": " + name + " does not exist: ignored", false}, remedy);
            continue;
        }
        if (taken[node])
            why = " is listed twice: it is placed once";
        else if (covered[node])
            why = " is listed, and is a child of " + label("node", nodes, (size_t)parent[node]) +
                  ", too: it is placed once, under its parent";
        else
            why = " is not a root, its parent is " + label("node", nodes, (size_t)parent[node]) +
                  ", which is not in the scene: it is taken as a root" +
                  (is_moved(l, (size_t)parent[node]) ? ", and its parent's transform is not applied" : "");
        take_note(l, cost::TREE, id, where, name + why, remedy);
        if (taken[node] || covered[node]) continue;
        parent[node] = -1;
        taken[node]  = 1;
        l.roots.push_back((size_t)node);
    }
}

/* Place parents before children, and children in the file's order. Not recursive, because trees may be deep. If a node cannot be
 * placed, neither can its subtree. */
void place_nodes(loader &l, const std::vector<int> &parent)
{
    std::vector<size_t> open(l.roots.rbegin(), l.roots.rend());
    l.ws_from_node.resize(l.model.nodes.size());
    while (!open.empty()) {
        size_t at = open.back();
        open.pop_back();
        transform &t = l.ws_from_node[at];
        if (failure f = fault_of([&] { t = node_transform(l, at); })) {
            take_fault(l, cost::NODE, at, label("node", l.model.nodes, at), f, "export it again");
            continue;
        }
        if (parent[at] >= 0) {
            t = multiply(l.ws_from_node[parent[at]], t);
            l.nodes[at].hidden |= l.nodes[parent[at]].hidden;
        }
        l.nodes[at].in_scene = true;
        l.order.push_back(at);
        const auto &children = l.model.nodes[at].children;
        open.insert(open.end(), children.rbegin(), children.rend());
    }
}

} // namespace gltf
