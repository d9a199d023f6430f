/* Meshes (3.7): check primitives, and count triangles.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <algorithm>

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

/* Integers are allowed even if KHR_mesh_quantization is not declared: the accessor gives the type. */
void check_attribute(loader &l, const std::string &primitive, const tinygltf::Primitive &p, const char *name, int type,
                     const char *type_text, size_t count)
{
    const elements &e     = sound_accessor(l, primitive, name, attribute(p.attributes, name));
    std::string     where = primitive + ", " + e.label;
    if (e.type != type) l.broken(where, "%s is not %s", name, type_text);
    if (e.component == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT) l.broken(where, "%s is of 32-bit integers", name);
    if (e.count != count) l.broken(where, "%zu elements, expected %zu", e.count, count);
}

bool makes_triangles(const tinygltf::Primitive &p)
{
    return p.mode >= TINYGLTF_MODE_TRIANGLES && p.mode <= TINYGLTF_MODE_TRIANGLE_FAN && attribute(p.attributes, "POSITION") >= 0;
}

size_t corner_count(const loader &l, const tinygltf::Primitive &p)
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
    size_t vertices = sound_accessor(l, where, "POSITION", attribute(p.attributes, "POSITION")).count;
    check_attribute(l, where, p, "POSITION", TINYGLTF_TYPE_VEC3, "a VEC3", vertices);
    if (p.indices >= 0) {
        const elements &e = sound_accessor(l, where, "indices", p.indices);
        if (e.type != TINYGLTF_TYPE_SCALAR || !is_unsigned(e.component))
            l.broken(where + ", " + e.label, "indices are not unsigned scalars");
    }
    if (makes_smoke(p)) check_smoke(l, where, p);

    /* check indices before decoding, if their data is available */
    if (p.indices < 0 || needs_draco(l, p)) return;
    const tinygltf::Accessor &a = l.model.accessors[p.indices];
    if (a.bufferView < 0 || a.sparse.isSparse || l.views[a.bufferView].compressed.extension) return;
    check_index_values(l, use_accessor(l, (size_t)p.indices), vertices, p.mode != TINYGLTF_MODE_TRIANGLES);
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
            if (!primitive_fault(l, i, k))
                if (failure f = caught([&] { check_primitive(l, where, p); })) l.primitive_faults[{i, k}] = f;
            if (p.material < 0 || (size_t)p.material < l.materials.size())
                continue; /* also for primitives that are left out, because patterns refer to materials */
            take_note(l, cost::REFERENCE, (uint64_t)1 << 63 | (uint64_t)i << 32 | k, where,
                      "material " + std::to_string(p.material) + " does not exist", "export it again");
            p.material = -1;
        }
}

/* ---- what a node places ---- */

void lose_primitive(loader &l, cost kind, size_t node, size_t index, const failure &f, size_t count)
{
    if (f.whole) throw f;
    size_t                     mesh      = (size_t)l.model.nodes[node].mesh;
    const tinygltf::Primitive &p         = l.model.meshes[mesh].primitives[index];
    std::string                placed_by = " (" + label("node", l.model.nodes, node);
    if (p.material >= 0) placed_by += ", " + label("material", l.materials, (size_t)p.material);
    take_fault(l, kind, (uint64_t)mesh << 32 | index, primitive_label(l, mesh, index), f,
               "mend it, or " + exclude_remedy("mesh:", mesh, l.model.meshes[mesh].name), count, placed_by + ")");
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

/* Count what a node's mesh casts, per placement. Other triangles are counted by their exclusion rule. */
static mesh_counts measure_node(loader &l, size_t index, size_t instances, skipped &skip)
{
    const tinygltf::Node &node       = l.model.nodes[index];
    const auto           &primitives = l.model.meshes[node.mesh].primitives;
    mesh_counts           casting;
    bool                  skinned = false;
    auto                  broken  = l.mesh_faults.find((size_t)node.mesh); /* no primitive can be read */
    if (broken != l.mesh_faults.end() && exclusion_of(l, index, tinygltf::Primitive()) == CASTS)
        take_fault(l, cost::PRIMITIVE, (uint64_t)node.mesh << 32 | UINT32_MAX, label("mesh", l.model.meshes, (size_t)node.mesh),
                   broken->second, "mend it, or " + exclude_remedy("mesh:", (size_t)node.mesh, l.model.meshes[node.mesh].name));
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
    for (auto [kind, count] : {std::pair("points", skip.points), std::pair("lines", skip.lines)})
        if (count)
            warn(l.m,
                 "primitives of %s skipped: %zu; what is to cast a shadow needs triangles, or is smoke by _RADIUS and _EXTINCTION",
                 kind, count);
    warn_about_skinned(l);
    l.vertex_capacity = vertices;
    if (total) /* the scene's arrays, and those that all users create: welded vertices, then edges (mesh_edges.c, casters_work.c) */
        l.need(std::max((uint64_t)29 * total + (uint64_t)60 * vertices, (uint64_t)66 * total + (uint64_t)28 * vertices),
               std::to_string(total) + " triangles with " + std::to_string(vertices) + " vertices, meshes placed " +
                   std::to_string(placed) + " times");
    return total;
}

/* Skins (3.7.3): joints determine the position of each vertex, in the pose given by the file's nodes. The transform of the mesh's
 * node is ignored. Bind space is the space of the stored vertices; a joint's inverse bind matrix transforms from it to the
 * joint. */

/* Deviation of a sum of weights that rounding to 8 bits cannot explain. */
static constexpr double FAR_OFF = 0.05;

void read_skins(loader &l, const json &root)
{
    for (size_t i = 0; i < items(root, "skins").size(); i++) {
        const json &object = root["skins"][i];
        skin        s      = {};
        s.inverse_bind     = object.value("inverseBindMatrices", -1);
        if (l.faults[SKINS].count(i)) s.fault = l.faults[SKINS][i];
        for (const json &joint : items(object, "joints")) s.joints.push_back(joint.get<size_t>());
        l.skins.push_back(s);
    }
}

/* World transform of a node, in the scene or not. */
static transform ws_from_any(loader &l, size_t node)
{
    std::vector<size_t> chain;
    for (long at = (long)node; at >= 0 && !l.nodes[(size_t)at].in_scene; at = l.file_parent[(size_t)at])
        chain.push_back((size_t)at);
    long      above = chain.empty() ? (long)node : l.file_parent[chain.back()];
    transform t     = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {0, 0, 0}};
    if (above >= 0) t = l.ws_from_node[(size_t)above];
    for (auto at = chain.rbegin(); at != chain.rend(); ++at) t = multiply(t, node_transform(l, *at));
    return t;
}

static transform inverse_bind(const elements *matrices, size_t joint)
{
    double m[16];
    if (!matrices) return {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {0, 0, 0}};
    for (size_t k = 0; k < 16; k++) m[k] = matrices->value(joint, k);
    return {{{m[0], m[1], m[2]}, {m[4], m[5], m[6]}, {m[8], m[9], m[10]}}, {m[12], m[13], m[14]}};
}

static skin &use_skin(loader &l, const std::string &where, size_t index)
{
    skin &s = l.skins[index];
    if (s.fault) throw s.fault;
    if (!s.ws_from_bind.empty()) return s;
    std::string     label_of = where + ", " + label("skin", index);
    const elements *matrices = nullptr;
    if (s.joints.empty()) l.broken(label_of, "it has no joints");
    if (s.inverse_bind >= 0) {
        const elements &e = sound_accessor(l, label_of, "inverseBindMatrices", s.inverse_bind);
        if (e.type != TINYGLTF_TYPE_MAT4 || e.component != TINYGLTF_COMPONENT_TYPE_FLOAT)
            l.broken(label_of + ", " + e.label, "not matrices of 4 x 4 floats");
        if (e.count < s.joints.size()) l.broken(label_of + ", " + e.label, "%zu matrices for %zu joints", e.count, s.joints.size());
        matrices = &use_accessor(l, (size_t)s.inverse_bind);
    }
    std::vector<transform> found;
    for (size_t i = 0; i < s.joints.size(); i++) {
        if (s.joints[i] >= l.nodes.size()) l.broken(label_of, "joint %zu, node %zu, does not exist", i, s.joints[i]);
        found.push_back(multiply(ws_from_any(l, s.joints[i]), inverse_bind(matrices, i)));
    }
    s.ws_from_bind.swap(found);
    return s;
}

void find_skin(loader &l, const std::string &where, const tinygltf::Node &node, placement &p)
{
    p.skin = &use_skin(l, where, (size_t)node.skin);
    for (int set = 0; attribute(p.primitive->attributes, "JOINTS_" + std::to_string(set)) >= 0; set++) {
        const elements &joints  = attribute_of(l, where, p, "JOINTS_" + std::to_string(set));
        const elements &weights = attribute_of(l, where, p, "WEIGHTS_" + std::to_string(set));
        size_t          count   = p.skin->joints.size();
        for (auto [e, name] : {std::pair(&joints, "JOINTS_"), std::pair(&weights, "WEIGHTS_")})
            if (e->type != TINYGLTF_TYPE_VEC4) l.broken(where + ", " + e->label, "%s%d is not a VEC4", name, set);
        if (joints.normalized) l.broken(joints.label, "joints are normalised numbers");
        if (weights.component != TINYGLTF_COMPONENT_TYPE_FLOAT && !(is_unsigned(weights.component) && weights.normalized))
            l.broken(weights.label, "weights are not floats or normalised unsigned integers");
        if (!is_unsigned(joints.component) || joints.component == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT)
            l.broken(joints.label, "joints are not of 8 or 16 bits");
        for (size_t i = 0; i < 4 * joints.count; i++)
            if (double joint = joints.value(i / 4, i % 4); !(joint < (double)count))
                l.broken(joints.label, "joint %g of vertex %zu, and the skin has %zu", joint, i / 4, count);
        p.joints.push_back(&joints);
        p.weights.push_back(&weights);
    }
    if (p.joints.empty()) l.broken(where, "no JOINTS_0, which a mesh of a node with a skin needs");
}

static void add(transform &sum, const transform &t, double weight)
{
    for (int i = 0; i < 3; i++)
        sum.axis[i] = {sum.axis[i].x + weight * t.axis[i].x, sum.axis[i].y + weight * t.axis[i].y,
                       sum.axis[i].z + weight * t.axis[i].z};
    sum.origin = {sum.origin.x + weight * t.origin.x, sum.origin.y + weight * t.origin.y, sum.origin.z + weight * t.origin.z};
}

transform skin_transform(const placement &p, uint32_t element, bool &off)
{
    transform sum   = {};
    double    total = 0;
    for (size_t set = 0; set < p.joints.size(); set++)
        for (size_t k = 0; k < 4; k++) {
            double weight = p.weights[set]->value(element, k);
            if (weight > 0) total += weight; /* ignores NaN and negative weights */
        }
    off |= !(std::fabs(total - 1) <= FAR_OFF);
    if (!(total > 0) || !std::isfinite(total)) return p.skin->ws_from_bind[(size_t)p.joints[0]->value(element, 0)];
    for (size_t set = 0; set < p.joints.size(); set++)
        for (size_t k = 0; k < 4; k++) {
            double weight = p.weights[set]->value(element, k);
            if (weight > 0) add(sum, p.skin->ws_from_bind[(size_t)p.joints[set]->value(element, k)], weight / total);
        }
    return sum;
}

} // namespace gltf
