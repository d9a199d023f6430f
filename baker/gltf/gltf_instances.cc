/* EXT_mesh_gpu_instancing: a node's mesh, placed once for each element of its TRANSLATION, ROTATION and SCALE.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/gltf/gltf_loader.h"

#include <cmath>

namespace gltf
{

static const char *const NAME = "EXT_mesh_gpu_instancing";

/* The accessor of an attribute of the extension, or -1; the extension's shape is known. */
static int instance_accessor(const tinygltf::Node &node, const char *name)
{
    const tinygltf::Value &attributes = node.extensions.at(NAME).Get("attributes");
    return attributes.Has(name) ? attributes.Get(name).GetNumberAsInt() : -1;
}

/* TRANSLATION and SCALE are floats by the extension, ROTATION floats or normalised integers; all of them are read in any type. */
static vxs_result check_attribute(loader &l, size_t node, const char *name, int type, size_t &count)
{
    const tinygltf::Node &n     = l.model.nodes[node];
    int                   index = instance_accessor(n, name);
    if (index < 0) return VXS_OK;
    std::string where = label("node", node, n.name) + " " + NAME + " " + name;
    if ((size_t)index >= l.accessors.size()) return l.error(VXS_E_SCENE, "%s: accessor %d does not exist", where.c_str(), index);

    const tinygltf::Accessor &a = l.model.accessors[(size_t)index];
    if (a.type != type)
        return l.error(VXS_E_SCENE, "%s: accessor %d is not a %s", where.c_str(), index,
                       type == TINYGLTF_TYPE_VEC3 ? "VEC3" : "VEC4");
    if (a.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT)
        return l.error(VXS_E_SCENE, "%s: accessor %d is of 32-bit integers", where.c_str(), index);
    if (count != SIZE_MAX && a.count != count)
        return l.error(VXS_E_SCENE, "%s: %zu elements, the attribute before has %zu", where.c_str(), a.count, count);
    count = a.count;
    const elements *e;
    return use_accessor(l, index, e);
}

vxs_result count_instances(loader &l, size_t node, size_t &count)
{
    const tinygltf::Node &n = l.model.nodes[node];
    vxs_result            r;
    count = 1;
    if (!n.extensions.count(NAME)) return VXS_OK;

    size_t found = SIZE_MAX;
    if ((r = check_attribute(l, node, "TRANSLATION", TINYGLTF_TYPE_VEC3, found)) != VXS_OK) return r;
    if ((r = check_attribute(l, node, "ROTATION", TINYGLTF_TYPE_VEC4, found)) != VXS_OK) return r;
    if ((r = check_attribute(l, node, "SCALE", TINYGLTF_TYPE_VEC3, found)) != VXS_OK) return r;
    for (const auto &other : n.extensions.at(NAME).Get("attributes").Get<tinygltf::Value::Object>()) {
        size_t index = (size_t)other.second.GetNumberAsInt();
        if (index >= l.accessors.size())
            return l.error(VXS_E_SCENE, "%s %s: accessor %zu does not exist", label("node", node, n.name).c_str(), NAME, index);
        if (found == SIZE_MAX) found = l.accessors[index].count; /* where they are is the node's own place */
    }
    if (found == SIZE_MAX) return l.error(VXS_E_SCENE, "%s %s has no attributes", label("node", node, n.name).c_str(), NAME);
    count = found;
    return VXS_OK;
}

static void read_values(const loader &l, int accessor, size_t i, size_t count, double *values)
{
    if (accessor < 0) return;
    const elements &e = l.accessors[(size_t)accessor];
    for (size_t k = 0; k < count; k++)
        values[k] = component_at(e.data + i * e.stride + k * component_bytes(e.component), e.component, e.normalized);
}

vxs_result instance_transform(loader &l, size_t node, size_t i, transform &ws_from_instance)
{
    const tinygltf::Node &n = l.model.nodes[node];
    ws_from_instance        = l.ws_from_node[node];
    if (!n.extensions.count(NAME)) return VXS_OK;

    double translation[3] = {0, 0, 0}, rotation[4] = {0, 0, 0, 1}, scale[3] = {1, 1, 1};
    read_values(l, instance_accessor(n, "TRANSLATION"), i, 3, translation);
    read_values(l, instance_accessor(n, "ROTATION"), i, 4, rotation);
    read_values(l, instance_accessor(n, "SCALE"), i, 3, scale);
    if (!normalize_rotation(rotation))
        return l.error(VXS_E_SCENE, "%s %s: ROTATION %zu is not a unit quaternion", label("node", node, n.name).c_str(), NAME, i);
    ws_from_instance = multiply(ws_from_instance, trs_transform(translation, rotation, scale));
    return VXS_OK;
}

} // namespace gltf
