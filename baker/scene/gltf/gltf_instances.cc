/* EXT_mesh_gpu_instancing: a node's mesh is placed once for each element of TRANSLATION, ROTATION and SCALE.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/scene/gltf/gltf_loader.h"

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

} // namespace gltf
