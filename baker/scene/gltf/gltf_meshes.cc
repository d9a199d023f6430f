/* Meshes (3.7): check primitives, and count triangles.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/scene/gltf/gltf_loader.h"

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

/* Positions are floats, or 8 or 16 bit integers, even if KHR_mesh_quantization is not declared: the accessor gives the type. */
static void check_positions(loader &l, const std::string &primitive, int index, size_t count)
{
    const elements &e     = sound_accessor(l, primitive, "POSITION", index);
    std::string     where = primitive + ", " + e.label;
    if (e.type != TINYGLTF_TYPE_VEC3) l.broken(where, "POSITION is not a VEC3");
    if (e.component == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT) l.broken(where, "POSITION is of 32-bit integers");
    if (e.count != count) l.broken(where, "%zu elements, expected %zu", e.count, count);
}

static void check_indices(loader &l, const std::string &primitive, int index)
{
    const elements &e     = sound_accessor(l, primitive, "indices", index);
    std::string     where = primitive + ", " + e.label;
    if (e.type != TINYGLTF_TYPE_SCALAR || !is_unsigned(e.component)) l.broken(where, "indices are not unsigned scalars");
}

bool makes_triangles(const tinygltf::Primitive &p)
{
    return p.mode >= TINYGLTF_MODE_TRIANGLES && p.mode <= TINYGLTF_MODE_TRIANGLE_FAN && attribute(p.attributes, "POSITION") >= 0;
}

static size_t corner_count(const loader &l, const tinygltf::Primitive &p)
{
    size_t accessor = (size_t)(p.indices >= 0 ? p.indices : attribute(p.attributes, "POSITION"));
    return accessor < l.accessors.size() ? l.accessors[accessor].count : 0;
}

size_t triangle_count(const loader &l, const tinygltf::Primitive &p)
{
    size_t corners = corner_count(l, p);
    return p.mode == TINYGLTF_MODE_TRIANGLES ? corners / 3 : corners < 3 ? 0 : corners - 2;
}

/* Check what triangles or smoke require. Other attributes are checked where they are used. */
static void check_primitive(loader &l, const std::string &where, const tinygltf::Primitive &p)
{
    if (p.mode > TINYGLTF_MODE_TRIANGLE_FAN) l.broken(where, "unknown mode %d", p.mode);
    if (!makes_triangles(p) && !makes_smoke(p)) return;
    int position = attribute(p.attributes, "POSITION");
    check_positions(l, where, position, sound_accessor(l, where, "POSITION", position).count);
    if (p.indices >= 0) check_indices(l, where, p.indices);
    if (makes_smoke(p)) check_smoke(l, where, p);
}

const failure *primitive_fault(const loader &l, size_t mesh, size_t primitive)
{
    auto found = l.primitive_faults.find({mesh, primitive});
    return found == l.primitive_faults.end() ? nullptr : &found->second;
}

void check_model_meshes(loader &l)
{
    for (size_t i = 0; i < l.model.meshes.size(); i++)
        for (size_t k = 0; k < l.model.meshes[i].primitives.size(); k++) {
            tinygltf::Primitive &p     = l.model.meshes[i].primitives[k];
            std::string          where = primitive_label(l, i, k);
            failure              f     = primitive_fault(l, i, k) ? failure{} : caught([&] { check_primitive(l, where, p); });
            if (f) l.primitive_faults[{i, k}] = f;
            if (p.material < 0 || (size_t)p.material < l.materials.size())
                continue; /* also for primitives that are left out, because patterns refer to materials */
            take_note(l, cost::REFERENCE, (uint64_t)1 << 63 | i << 32 | k, where,
                      "material " + std::to_string(p.material) + " does not exist", "export it again");
            p.material = -1;
        }
}

/* Check indices before decoding, if their data is available. */
static void check_primitive_indices(loader &l, const tinygltf::Primitive &p)
{
    if (p.indices < 0 || !(makes_triangles(p) || makes_smoke(p)) || needs_draco(l, p)) return;
    const tinygltf::Accessor &a = l.model.accessors[p.indices];
    if (a.bufferView < 0 || a.sparse.isSparse || l.views[a.bufferView].compressed.extension) return;
    check_index_values(l, use_accessor(l, (size_t)p.indices), l.accessors[attribute(p.attributes, "POSITION")].count,
                       p.mode != TINYGLTF_MODE_TRIANGLES);
}

void check_all_indices(loader &l)
{
    for (size_t i = 0; i < l.model.meshes.size(); i++)
        for (size_t k = 0; k < l.model.meshes[i].primitives.size(); k++) {
            if (primitive_fault(l, i, k)) continue;
            failure f = caught([&] { check_primitive_indices(l, l.model.meshes[i].primitives[k]); });
            if (f) l.primitive_faults[{i, k}] = f;
        }
}

/* ---- what a node places ---- */

static std::string placed_by(const loader &l, size_t node, const tinygltf::Primitive &p)
{
    std::string text = " (" + label("node", l.model.nodes, node);
    if (p.material >= 0) text += ", " + label("material", l.materials, (size_t)p.material);
    return text + ")";
}

void lose_primitive(loader &l, cost kind, size_t node, size_t index, const failure &f, size_t count)
{
    if (f.whole) throw f;
    size_t                     mesh = (size_t)l.model.nodes[node].mesh;
    const tinygltf::Primitive &p    = l.model.meshes[mesh].primitives[index];
    take_fault(l, kind, (uint64_t)mesh << 32 | index, primitive_label(l, mesh, index), f,
               "mend it, or " + exclude_remedy("mesh:", mesh, l.model.meshes[mesh].name), count, placed_by(l, node, p));
}

/* Primitives that are not baked, or not exactly, and that no rule excludes. */
struct skipped {
    size_t points, lines; /* primitives */
};

static void warn_about(loader &l, size_t mesh, size_t i, skipped &skip)
{
    const tinygltf::Primitive &p     = l.model.meshes[mesh].primitives[i];
    std::string                where = primitive_label(l, mesh, i);
    uint64_t                   id    = (uint64_t)mesh << 32 | i;
    if (makes_smoke(p)) return;
    if (p.mode == TINYGLTF_MODE_POINTS)
        skip.points++;
    else if (p.mode < TINYGLTF_MODE_TRIANGLES)
        skip.lines++;
    else if (!makes_triangles(p))
        take_note(l, cost::PRIMITIVE, id, where, "no POSITION", "give it positions, or delete it");
    else if (p.mode == TINYGLTF_MODE_TRIANGLES && corner_count(l, p) % 3)
        take_note(l, cost::CORNERS, id, where, std::to_string(corner_count(l, p)) + " corners, not a multiple of 3",
                  "export it again", corner_count(l, p) % 3);
    if (!p.targets.empty())
        take_note(l, cost::MORPH, mesh, label("mesh", l.model.meshes, mesh), "morph targets are baked at their default weights",
                  "set those to the shape that is to cast");
}

/* Casting triangles of a node's mesh, and vertices created for them per placement. Consecutive primitives with the same accessor
 * share vertices. */
struct mesh_counts {
    size_t triangles = 0, vertices = 0;
    size_t sharing = 0, shared = 0; /* triangles of consecutive primitives with this accessor, and their vertices */
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

/* Memory of a scene's arrays, and of the arrays that all users of a scene create: welded vertices, then edges (mesh_weld.c,
 * casters.c). */
static uint64_t scene_bytes(uint64_t triangles, uint64_t vertices)
{
    return std::max(29 * triangles + 60 * vertices, 66 * triangles + 28 * vertices);
}

/* Warn of a mesh without any readable primitive. */
static void warn_about_mesh(loader &l, size_t node)
{
    size_t mesh   = (size_t)l.model.nodes[node].mesh;
    auto   broken = l.mesh_faults.find(mesh);
    if (broken == l.mesh_faults.end() || exclusion_of(l, node, tinygltf::Primitive()) != CASTS) return;
    take_fault(l, cost::PRIMITIVE, (uint64_t)mesh << 32 | UINT32_MAX, label("mesh", l.model.meshes, mesh), broken->second,
               "mend it, or " + exclude_remedy("mesh:", mesh, l.model.meshes[mesh].name));
}

/* Count what a node's mesh casts, per placement. Other triangles are counted by their exclusion rule. */
static mesh_counts measure_node(loader &l, size_t index, size_t instances, skipped &skip)
{
    const tinygltf::Node &node       = l.model.nodes[index];
    const auto           &primitives = l.model.meshes[node.mesh].primitives;
    mesh_counts           casting;
    bool                  skinned = false;
    warn_about_mesh(l, index);
    for (size_t i = 0; i < primitives.size(); i++) {
        size_t triangles     = makes_triangles(primitives[i]) ? std::min(triangle_count(l, primitives[i]), TRIANGLES_MAX + 1) : 0;
        size_t rule          = exclusion_of(l, index, primitives[i]);
        const failure *fault = primitive_fault(l, (size_t)node.mesh, i);
        if (rule == CASTS && fault) {
            lose_primitive(l, cost::PRIMITIVE, index, i, *fault, instances * triangles);
        } else if (rule == CASTS) {
            warn_about(l, (size_t)node.mesh, i, skip);
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
            l.refused("", "more than %zu triangles in the scene, with those of %s", TRIANGLES_MAX,
                      label("node", l.model.nodes, index).c_str());
        total += instances * triangles;
        vertices += instances * casting.vertices;
        placed += triangles ? instances : 0;
    }
    if (skip.points)
        warn(l.m,
             "primitives of points skipped: %zu; what is to cast a shadow needs triangles, or is smoke by _RADIUS and _EXTINCTION",
             skip.points);
    if (skip.lines)
        warn(l.m,
             "primitives of lines skipped: %zu; what is to cast a shadow needs triangles, or is smoke by _RADIUS and _EXTINCTION",
             skip.lines);
    warn_about_skinned(l);
    l.vertex_capacity = vertices;
    if (total)
        l.need(scene_bytes(total, vertices), std::to_string(total) + " triangles with " + std::to_string(vertices) +
                                                 " vertices, meshes placed " + std::to_string(placed) + " times");
    return total;
}

} // namespace gltf
