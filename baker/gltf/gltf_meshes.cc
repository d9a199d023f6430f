/* Meshes (3.7): their primitives checked, and how many triangles there will be.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/gltf/gltf_loader.h"

namespace gltf
{

int attribute(const std::map<std::string, int> &attributes, const std::string &name)
{
    auto found = attributes.find(name);
    return found == attributes.end() ? -1 : found->second;
}

std::string primitive_label(const loader &l, size_t mesh, size_t primitive)
{
    return label("mesh", l.model.meshes, mesh) + " " + label("primitive", primitive);
}

static void check_positions(loader &l, const std::string &primitive, int index, size_t count)
{
    const elements &e     = l.accessors[index];
    std::string     where = primitive + ", " + e.label;
    bool            apart = l.model.accessors[index].bufferView >= 0;
    if (e.type != TINYGLTF_TYPE_VEC3) l.broken(where, "POSITION is not a VEC3");
    if (e.component == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT) l.broken(where, "POSITION is of 32-bit integers");
    if (e.component != TINYGLTF_COMPONENT_TYPE_FLOAT && !l.quantization)
        l.broken(where, "POSITION is not of floats, and KHR_mesh_quantization is not used");
    if (apart && (offset_in_buffer(l, l.model.accessors[index]) % 4 || e.stride % 4))
        l.broken(where, "positions do not begin at multiples of 4 bytes");
    if (e.count != count) l.broken(where, "%zu elements, expected %zu", e.count, count);
}

static void check_indices(loader &l, const std::string &primitive, int index)
{
    if ((size_t)index >= l.accessors.size()) l.broken(primitive, "indices accessor %d does not exist", index);
    const elements &e     = l.accessors[index];
    std::string     where = primitive + ", " + e.label;
    int             view  = l.model.accessors[index].bufferView;
    if (e.type != TINYGLTF_TYPE_SCALAR || !is_unsigned(e.component)) l.broken(where, "indices are not unsigned scalars");
    if (view >= 0 && l.views[view].stride) l.broken(where, "indices with a byteStride");
}

bool makes_triangles(const tinygltf::Primitive &p)
{
    return p.mode >= TINYGLTF_MODE_TRIANGLES && p.mode <= TINYGLTF_MODE_TRIANGLE_FAN && attribute(p.attributes, "POSITION") >= 0;
}

static size_t corner_count(const loader &l, const tinygltf::Primitive &p)
{
    return l.accessors[p.indices >= 0 ? p.indices : attribute(p.attributes, "POSITION")].count;
}

size_t triangle_count(const loader &l, const tinygltf::Primitive &p)
{
    size_t corners = corner_count(l, p);
    return p.mode == TINYGLTF_MODE_TRIANGLES ? corners / 3 : corners < 3 ? 0 : corners - 2;
}

/* Attributes that are not read exist, too. */
static void check_attributes(loader &l, const std::string &where, const std::map<std::string, int> &attributes)
{
    for (const auto &[name, accessor] : attributes)
        if ((size_t)accessor >= l.accessors.size()) l.broken(where, "%s accessor %d does not exist", name.c_str(), accessor);
}

static void check_primitive(loader &l, const std::string &where, const tinygltf::Primitive &p)
{
    auto target_label = [&where](size_t i) { return where + " target " + std::to_string(i); };
    if (p.mode > TINYGLTF_MODE_TRIANGLE_FAN) l.broken(where, "unknown mode %d", p.mode);
    if (p.material >= 0 && (size_t)p.material >= l.materials.size()) l.broken(where, "material %d does not exist", p.material);
    check_attributes(l, where, p.attributes);
    for (size_t i = 0; i < p.targets.size(); i++) check_attributes(l, target_label(i), p.targets[i]);
    if (!makes_triangles(p) && !makes_smoke(p)) return;

    int    position = attribute(p.attributes, "POSITION");
    size_t vertices = l.accessors[position].count;
    check_positions(l, where, position, vertices);
    for (size_t i = 0; i < p.targets.size(); i++)
        if (attribute(p.targets[i], "POSITION") >= 0)
            check_positions(l, target_label(i), attribute(p.targets[i], "POSITION"), vertices);
    if (p.indices >= 0) check_indices(l, where, p.indices);
    if (makes_smoke(p)) check_smoke(l, where, p);
}

void check_weights(loader &l, const std::string &where, const std::vector<double> &weights, const tinygltf::Primitive &p)
{
    if (!weights.empty() && weights.size() != p.targets.size())
        l.broken(where, "%zu weights for %zu morph targets", weights.size(), p.targets.size());
}

void check_model_meshes(loader &l)
{
    for (size_t i = 0; i < l.model.meshes.size(); i++) {
        const tinygltf::Mesh &mesh = l.model.meshes[i];
        for (size_t k = 0; k < mesh.primitives.size(); k++) {
            std::string where = primitive_label(l, i, k);
            check_primitive(l, where, mesh.primitives[k]);
            check_weights(l, where, mesh.weights, mesh.primitives[k]);
        }
    }
}

void check_all_indices(loader &l)
{
    for (const tinygltf::Mesh &mesh : l.model.meshes)
        for (const tinygltf::Primitive &p : mesh.primitives) {
            if (p.indices < 0 || !(makes_triangles(p) || makes_smoke(p)) || needs_draco(l, p)) continue;
            const tinygltf::Accessor &a = l.model.accessors[p.indices];
            if (a.bufferView < 0 || a.sparse.isSparse || l.views[a.bufferView].compressed.extension) continue;
            check_index_values(l, use_accessor(l, p.indices), l.accessors[attribute(p.attributes, "POSITION")].count);
        }
}

/* What is not baked, or not as it is shown, and no rule excludes. */
struct skipped {
    size_t points, lines; /* primitives */
};

static void warn_about(loader &l, size_t mesh, size_t i, skipped &skip)
{
    const tinygltf::Primitive &p     = l.model.meshes[mesh].primitives[i];
    std::string                where = primitive_label(l, mesh, i);
    if (makes_smoke(p)) return;
    if (p.mode == TINYGLTF_MODE_POINTS)
        skip.points++;
    else if (p.mode < TINYGLTF_MODE_TRIANGLES)
        skip.lines++;
    else if (!makes_triangles(p))
        warn(l.m, "%s has no POSITION: skipped; give it positions, or delete it", where.c_str());
    else if (p.mode == TINYGLTF_MODE_TRIANGLES && corner_count(l, p) % 3)
        warn(l.m, "%s has %zu corners, not a multiple of 3: the last ones are ignored; export it again", where.c_str(),
             corner_count(l, p));
    if (!p.targets.empty())
        warn(l.m, "%s has morph targets: baked at their default weights; set those to the shape that is to cast",
             label("mesh", l.model.meshes, mesh).c_str());
}

/* Triangles of a node's mesh that cast, and vertices that are made of them each time it is placed: primitives that follow each other share
 * those of an accessor. */
struct mesh_counts {
    size_t triangles = 0, vertices = 0;
    size_t sharing = 0, shared = 0; /* triangles over the same accessor so far, and their vertices */
    int    last = -1;

    void add(const loader &l, const tinygltf::Primitive &p, size_t more)
    {
        if (!more) return;
        int positions = attribute(p.attributes, "POSITION");
        if (positions != last) sharing = shared = 0;
        last = positions;
        sharing += more;
        triangles += more;
        vertices -= shared;
        vertices += shared = std::min(l.accessors[positions].count, 3 * sharing);
    }
};

/* The arrays of a scene, and those that all who read one make of it: welded vertices, then edges (mesh_weld.c, casters.c). */
static uint64_t scene_bytes(uint64_t triangles, uint64_t vertices)
{
    return std::max(29 * triangles + 60 * vertices, 66 * triangles + 28 * vertices);
}

/* What of a node's mesh casts, once; triangles that do not are counted where they are excluded. */
static mesh_counts measure_node(loader &l, size_t index, size_t instances, skipped &skip)
{
    const tinygltf::Node &node       = l.model.nodes[index];
    const auto           &primitives = l.model.meshes[node.mesh].primitives;
    mesh_counts           casting;
    bool                  skinned = false;
    for (size_t i = 0; i < primitives.size(); i++) {
        size_t triangles = makes_triangles(primitives[i]) ? std::min(triangle_count(l, primitives[i]), TRIANGLES_MAX + 1) : 0;
        size_t rule      = exclusion_of(l, index, primitives[i]);
        if (rule == CASTS) {
            warn_about(l, node.mesh, i, skip);
            casting.add(l, primitives[i], triangles);
        } else {
            l.exclusions[rule].triangles += instances * triangles;
            skinned |= l.exclusions[rule].rule == EXCLUDED_AS_SKINNED && instances && triangles;
        }
    }
    l.skinned_excluded += skinned;
    return casting;
}

size_t measure(loader &l)
{
    size_t  total = 0, vertices = 0, placed = 0;
    skipped skip = {};
    for (size_t index : l.order) {
        if (l.model.nodes[index].mesh < 0) continue;
        size_t      instances = count_instances(l, index);
        mesh_counts casting   = measure_node(l, index, instances, skip);
        size_t      triangles = casting.triangles;
        if (triangles && instances > (TRIANGLES_MAX - std::min(total, TRIANGLES_MAX)) / triangles)
            l.unsupported("", "more than %zu triangles in the scene, with those of %s", TRIANGLES_MAX,
                          label("node", l.model.nodes, index).c_str());
        total += instances * triangles;
        vertices += instances * casting.vertices;
        placed += triangles ? instances : 0;
    }
    if (skip.points) warn(l.m, "primitives of points skipped: %zu; what is to cast a shadow needs triangles, or is smoke by _RADIUS and _EXTINCTION", skip.points);
    if (skip.lines) warn(l.m, "primitives of lines skipped: %zu; what is to cast a shadow needs triangles, or is smoke by _RADIUS and _EXTINCTION", skip.lines);
    finish_selection(l);
    l.vertex_capacity = vertices;
    if (total)
        l.need(scene_bytes(total, vertices), std::to_string(total) + " triangles with " + std::to_string(vertices) +
                                                 " vertices, meshes placed " + std::to_string(placed) + " times");
    return total;
}

} // namespace gltf
