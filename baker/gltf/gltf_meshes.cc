/* Meshes (3.7): their primitives checked, and how many triangles there will be.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/gltf/gltf_loader.h"

#include <nlohmann/json.hpp>

namespace gltf
{

int attribute(const std::map<std::string, int> &attributes, const char *name)
{
    auto found = attributes.find(name);
    return found == attributes.end() ? -1 : found->second;
}

static vxs_result check_positions(loader &l, const std::string &where, int index, size_t count)
{
    const tinygltf::Accessor &a    = l.model.accessors[(size_t)index];
    std::string               name = label("accessor", (size_t)index, a.name);
    if (a.type != TINYGLTF_TYPE_VEC3) return l.error(VXS_E_SCENE, "%s, %s: POSITION is not a VEC3", where.c_str(), name.c_str());
    if (a.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT)
        return l.error(VXS_E_SCENE, "%s, %s: POSITION is of 32-bit integers", where.c_str(), name.c_str());
    if (a.componentType != TINYGLTF_COMPONENT_TYPE_FLOAT && !l.quantization)
        return l.error(VXS_E_SCENE, "%s, %s: POSITION is not of floats, and KHR_mesh_quantization is not used", where.c_str(),
                       name.c_str());
    if (a.bufferView >= 0 && (offset_in_buffer(l, a) % 4 || l.accessors[(size_t)index].stride % 4))
        return l.error(VXS_E_SCENE, "%s, %s: positions do not begin at multiples of 4 bytes", where.c_str(), name.c_str());
    if (a.count != count)
        return l.error(VXS_E_SCENE, "%s, %s: %zu elements, expected %zu", where.c_str(), name.c_str(), a.count, count);
    return VXS_OK;
}

static vxs_result check_indices(loader &l, const std::string &where, int index)
{
    if ((size_t)index >= l.accessors.size())
        return l.error(VXS_E_SCENE, "%s: indices accessor %d does not exist", where.c_str(), index);
    const tinygltf::Accessor &a    = l.model.accessors[(size_t)index];
    std::string               name = label("accessor", (size_t)index, a.name);
    if (a.type != TINYGLTF_TYPE_SCALAR ||
        (a.componentType != TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE && a.componentType != TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT &&
         a.componentType != TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT))
        return l.error(VXS_E_SCENE, "%s, %s: indices are not unsigned scalars", where.c_str(), name.c_str());
    if (a.bufferView >= 0 && (size_t)a.bufferView < l.views.size() && l.views[(size_t)a.bufferView].stride)
        return l.error(VXS_E_SCENE, "%s, %s: indices with a byteStride", where.c_str(), name.c_str());
    return VXS_OK;
}

/* The weights of a node's morph targets (3.7.2.2): its own, else the mesh's, else none. */
const std::vector<double> &morph_weights(const tinygltf::Node &node, const tinygltf::Mesh &mesh)
{
    return node.weights.empty() ? mesh.weights : node.weights;
}

bool makes_triangles(const tinygltf::Primitive &p)
{
    return p.mode >= TINYGLTF_MODE_TRIANGLES && p.mode <= TINYGLTF_MODE_TRIANGLE_FAN && attribute(p.attributes, "POSITION") >= 0;
}

size_t corner_count(const loader &l, const tinygltf::Primitive &p)
{
    return l.accessors[(size_t)(p.indices >= 0 ? p.indices : attribute(p.attributes, "POSITION"))].count;
}

size_t triangle_count(const loader &l, const tinygltf::Primitive &p)
{
    size_t corners = corner_count(l, p);
    return p.mode == TINYGLTF_MODE_TRIANGLES ? corners / 3 : corners < 3 ? 0 : corners - 2;
}

/* Attributes that are not read exist, too. */
static vxs_result check_attributes(loader &l, const std::string &where, const std::map<std::string, int> &attributes)
{
    for (const auto &[name, accessor] : attributes)
        if ((size_t)accessor >= l.accessors.size())
            return l.error(VXS_E_SCENE, "%s: %s accessor %d does not exist", where.c_str(), name.c_str(), accessor);
    return VXS_OK;
}

static vxs_result check_primitive(loader &l, const std::string &where, const tinygltf::Primitive &p)
{
    if (p.mode > TINYGLTF_MODE_TRIANGLE_FAN) return l.error(VXS_E_SCENE, "%s: unknown mode %d", where.c_str(), p.mode);
    if (p.material >= 0 && (size_t)p.material >= l.materials.size())
        return l.error(VXS_E_SCENE, "%s: material %d does not exist", where.c_str(), p.material);
    vxs_result r = check_attributes(l, where, p.attributes);
    for (size_t i = 0; r == VXS_OK && i < p.targets.size(); i++)
        r = check_attributes(l, where + " target " + std::to_string(i), p.targets[i]);
    if (r != VXS_OK || !makes_triangles(p)) return r;

    int    position = attribute(p.attributes, "POSITION");
    size_t vertices = l.accessors[(size_t)position].count;
    r               = check_positions(l, where, position, vertices);
    for (size_t i = 0; r == VXS_OK && i < p.targets.size(); i++)
        if (attribute(p.targets[i], "POSITION") >= 0)
            r = check_positions(l, where + " target " + std::to_string(i), attribute(p.targets[i], "POSITION"), vertices);
    if (r == VXS_OK && p.indices >= 0) r = check_indices(l, where, p.indices);
    return r;
}

vxs_result check_model_meshes(loader &l)
{
    for (size_t i = 0; i < l.model.meshes.size(); i++) {
        const tinygltf::Mesh &mesh = l.model.meshes[i];
        for (size_t k = 0; k < mesh.primitives.size(); k++) {
            std::string where = label("mesh", i, mesh.name) + " " + label("primitive", k, "");
            vxs_result  r     = check_primitive(l, where, mesh.primitives[k]);
            if (r != VXS_OK) return r;
            size_t targets = mesh.primitives[k].targets.size();
            if (!mesh.weights.empty() && mesh.weights.size() != targets)
                return l.error(VXS_E_SCENE, "%s: %zu weights for %zu morph targets", where.c_str(), mesh.weights.size(), targets);
        }
    }
    return VXS_OK;
}

vxs_result check_all_indices(loader &l)
{
    for (const tinygltf::Mesh &mesh : l.model.meshes)
        for (const tinygltf::Primitive &p : mesh.primitives) {
            if (p.indices < 0 || !makes_triangles(p) || needs_draco(l, p)) continue;
            const tinygltf::Accessor &a = l.model.accessors[(size_t)p.indices];
            if (a.bufferView < 0 || a.sparse.isSparse || l.views[(size_t)a.bufferView].compressed.extension) continue;
            const elements *indices;
            vxs_result      r = use_accessor(l, p.indices, indices);
            if (r == VXS_OK)
                r = check_index_values(l, *indices, p.indices, l.accessors[(size_t)attribute(p.attributes, "POSITION")].count);
            if (r != VXS_OK) return r;
        }
    return VXS_OK;
}

vxs_result read_materials(loader &l, const json &root)
{
    for (const json &object : items(root, "materials")) {
        std::string name = object.value("name", ""), mode = object.value("alphaMode", "OPAQUE");
        if (mode != "OPAQUE" && mode != "MASK" && mode != "BLEND")
            return l.error(VXS_E_SCENE, "%s: unknown alphaMode '%s'", label("material", l.materials.size(), name).c_str(),
                           mode.c_str());
        l.materials.push_back({name, object.value("doubleSided", false), mode == "MASK", {}});
    }
    return VXS_OK;
}

/* What is skipped or simplified, said once. */
static void warn_about(loader &l, const tinygltf::Node &node, size_t &points, size_t &lines)
{
    const tinygltf::Mesh &mesh = l.model.meshes[(size_t)node.mesh];
    for (size_t i = 0; i < mesh.primitives.size(); i++) {
        const tinygltf::Primitive &p = mesh.primitives[i];
        if (p.mode == TINYGLTF_MODE_POINTS)
            points++;
        else if (p.mode < TINYGLTF_MODE_TRIANGLES)
            lines++;
        else if (!makes_triangles(p))
            warn(l.m, "%s %s has no POSITION: skipped", label("mesh", (size_t)node.mesh, mesh.name).c_str(),
                 label("primitive", i, "").c_str());
        else if (p.mode == TINYGLTF_MODE_TRIANGLES && corner_count(l, p) % 3)
            warn(l.m, "%s %s has %zu corners, not a multiple of 3: the last ones are ignored",
                 label("mesh", (size_t)node.mesh, mesh.name).c_str(), label("primitive", i, "").c_str(), corner_count(l, p));
        if (!p.targets.empty())
            warn(l.m, "%s has morph targets: baked at their default weights", label("mesh", (size_t)node.mesh, mesh.name).c_str());
    }
    if (node.skin >= 0)
        warn(l.m, "%s: baked in rest pose, as its mesh is stored",
             label("skin", (size_t)node.skin, l.model.skins[(size_t)node.skin].name).c_str());
}

/* Count before allocating: instancing makes scenes much larger than files. */
vxs_result measure(loader &l)
{
    std::vector<size_t> of_mesh(l.model.meshes.size(), 0);
    for (size_t i = 0; i < of_mesh.size(); i++)
        for (const tinygltf::Primitive &p : l.model.meshes[i].primitives)
            if (makes_triangles(p)) of_mesh[i] += std::min(triangle_count(l, p), TRIANGLES_MAX + 1);

    size_t total = 0, points = 0, lines = 0, instances;
    for (int index : l.order) {
        const tinygltf::Node &node = l.model.nodes[(size_t)index];
        if (node.mesh < 0) continue;
        vxs_result r = count_instances(l, (size_t)index, instances);
        if (r != VXS_OK) return r;
        warn_about(l, node, points, lines);
        size_t triangles = of_mesh[(size_t)node.mesh];
        if (triangles && instances > (TRIANGLES_MAX - std::min(total, TRIANGLES_MAX)) / triangles)
            return l.error(VXS_E_UNSUPPORTED, "more than %zu triangles in the scene, with those of %s", TRIANGLES_MAX,
                           label("node", (size_t)index, node.name).c_str());
        total += instances * triangles;
    }
    if (points) warn(l.m, "primitives of points skipped: %zu", points);
    if (lines) warn(l.m, "primitives of lines skipped: %zu", lines);
    if (!total) return VXS_OK;

    l.s->indices        = (uint32_t *)malloc(3 * total * sizeof(uint32_t));
    l.s->triangle_flags = (uint8_t *)malloc(total);
    return l.s->indices && l.s->triangle_flags ? VXS_OK : l.error(VXS_E_MEMORY, "out of memory for %zu triangles", total);
}

} // namespace gltf
