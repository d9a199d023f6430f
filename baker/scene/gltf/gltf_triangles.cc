/* Convert primitives to triangles in world space.
 *
 * Shared accessors: a vertex is created when an index first refers to it, and is shared by the primitives of a node. So memory
 * depends on triangles and not on accessors (2023 fans over one accessor create its vertices once).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/scene/gltf/gltf_loader.h"

#include "baker/base/array.h"

#include <utility>

namespace gltf
{

vec3 position(const elements &e, size_t index)
{
    if (e.component != TINYGLTF_COMPONENT_TYPE_FLOAT) return {e.value(index, 0), e.value(index, 1), e.value(index, 2)};
    float p[3];
    memcpy(p, e.data + index * e.stride, sizeof p);
    return {p[0], p[1], p[2]};
}

/* Vertex number in the scene of an accessor's element; UINT32_MAX when its position is not finite. */
static inline uint32_t vertex_of(loader &l, placement &p, uint32_t index)
{
    loader::slot &slot = l.slots[index];
    if (slot.generation == l.generation) return slot.vertex;

    scene *s = l.s;
    if (!array_reserve(&s->positions_ws, &l.vertex_capacity, s->vertex_count + 1, 3 * sizeof(double))) throw std::bad_alloc();
    bool off = false;
    vec3 v   = position(*p.positions, index);
    for (const morph &m : p.targets) { /* before the transform of the node or the joints */
        vec3 d = position(*m.positions, index);
        v      = {v.x + m.weight * d.x, v.y + m.weight * d.y, v.z + m.weight * d.z};
    }
    v = apply(p.skin ? skin_transform(p, index, off) : p.ws_from_node, v);
    p.off_count += off;
    if (!finite(v)) return UINT32_MAX;
    memcpy(s->positions_ws + 3 * s->vertex_count, &v, sizeof v);
    slot = {l.generation, (uint32_t)s->vertex_count++};
    return slot.vertex;
}

/* Accessor elements of the corners of triangle t (3.7.2.1). */
void triangle_elements(const placement &p, size_t t, uint32_t element[3])
{
    bool   off       = false;
    size_t corner[3] = {3 * t, 3 * t + 1, 3 * t + 2};
    if (p.primitive->mode == TINYGLTF_MODE_TRIANGLE_STRIP) corner[0] = t, corner[1] = t + 1 + t % 2, corner[2] = t + 2 - t % 2;
    if (p.primitive->mode == TINYGLTF_MODE_TRIANGLE_FAN) corner[0] = t + 1, corner[1] = t + 2, corner[2] = 0;
    for (int i = 0; i < 3; i++) element[i] = p.indices ? p.indices->index(corner[i]) : (uint32_t)corner[i];
    if (p.skin ? is_mirrored(skin_transform(p, element[0], off)) : p.mirrored) std::swap(element[1], element[2]);
}

/* Find the accessor with the value that is not finite. If there is none, the transformed position is too far away. */
static failure bad_vertex(const placement &p, uint32_t vertex)
{
    const elements *bad = finite(position(*p.positions, vertex)) ? nullptr : p.positions;
    for (const morph &target : p.targets)
        if (!bad && !finite(position(*target.positions, vertex))) bad = target.positions;
    if (bad) return {VXS_E_SCENE, bad->label + ": position " + std::to_string(vertex) + " is not finite", false};
    return {VXS_E_SCENE, "vertex " + std::to_string(vertex) + " is not finite once placed", false};
}

static void find_geometry(loader &l, const std::string &where, placement &p)
{
    const tinygltf::Primitive &primitive = *p.primitive;
    if (needs_draco(l, primitive)) {
        p.draco     = &use_draco(l, where, primitive);
        p.positions = &p.draco->attributes.at("POSITION");
        p.indices   = &p.draco->indices;
    } else {
        p.positions = &use_accessor(l, (size_t)attribute(primitive.attributes, "POSITION"));
        if (primitive.indices >= 0) p.indices = &use_accessor(l, (size_t)primitive.indices);
    }
    if (p.indices) check_index_values(l, *p.indices, p.positions->count, primitive.mode != TINYGLTF_MODE_TRIANGLES);
}

/* Find the weights of morph targets (3.7.2.2): the node's, else the mesh's, else none. Additional weights are ignored. */
static void find_targets(loader &l, const tinygltf::Node &node, const std::string &where, placement &p)
{
    const std::vector<double> &weights = node.weights.empty() ? l.model.meshes[node.mesh].weights : node.weights;
    const auto                &targets = p.primitive->targets;
    if (!weights.empty() && weights.size() != targets.size())
        take_note(l, cost::MORPH, (uint64_t)1 << 63 | (uint64_t)node.mesh << 32 | p.index, where,
                  std::to_string(weights.size()) + " weights for " + std::to_string(targets.size()) +
                      " morph targets: the rest of them means nothing, or is 0",
                  "export it again");
    for (size_t i = 0; i < std::min(weights.size(), targets.size()); i++) {
        int accessor = attribute(targets[i], "POSITION");
        if (weights[i] == 0 || accessor < 0) continue;
        const elements &target = sound_accessor(l, where, "morph target POSITION", accessor);
        if (target.type != TINYGLTF_TYPE_VEC3 || target.component == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT)
            l.broken(where, "a morph target's POSITION is not a VEC3 of floats, or of 8 or 16 bits");
        if (target.count != p.positions->count)
            l.broken(where, "a morph target of %zu vertices, expected %zu", target.count, p.positions->count);
        p.targets.push_back({weights[i], &use_accessor(l, (size_t)accessor)});
    }
}

static void apply_material(loader &l, const std::string &where, size_t node, size_t instances, placement &p)
{
    if (!p.material) return;
    bool holes = p.material->surface == material::WITH_HOLES;
    if (p.material->mode != alpha_mode::SOLID) warn_about_colors(l, where, node, p);
    if (holes)
        if (failure f = caught([&] { find_uvs(l, where, p); })) {
            holes = false;
            lose_primitive(l, cost::MASK, node, p.index, {f.code, f.text, false}, instances * p.triangles);
        }
    p.flags = (uint8_t)((p.material->double_sided ? TRIANGLE_DOUBLE_SIDED : 0) | (holes ? TRIANGLE_ALPHA_MASK : 0));
}

/* Prepare one primitive of a node. Returns false if its material has no surface. */
static bool find_placement(loader &l, size_t node, size_t instances, placement &p)
{
    const tinygltf::Node &n     = l.model.nodes[node];
    std::string           where = primitive_label(l, (size_t)n.mesh, p.index);
    p.primitive                 = &l.model.meshes[n.mesh].primitives[p.index];
    p.triangles                 = triangle_count(l, *p.primitive);
    find_geometry(l, where, p);
    find_targets(l, n, where, p);
    if (n.skin >= 0) find_skin(l, where, n, p);
    if (p.primitive->material >= 0) {
        material &m = use_material(l, (size_t)p.primitive->material);
        p.material  = &m;
        if (m.used_by.empty()) m.used_by = " (" + label("node", l.model.nodes, node) + ", " + where + ")";
        (m.surface == material::NOWHERE ? m.left_out : m.triangles) += instances * p.triangles;
        if (m.surface == material::NOWHERE) return false;
    }
    apply_material(l, where, node, instances, p);
    return true;
}

/* Prepare all primitives of one node, for one placement. */
static std::vector<placement> find_placements(loader &l, size_t index, size_t instances)
{
    std::vector<placement> placements;
    size_t                 mesh       = (size_t)l.model.nodes[index].mesh;
    const auto            &primitives = l.model.meshes[mesh].primitives;
    for (size_t i = 0; i < primitives.size(); i++) {
        if (primitive_fault(l, mesh, i) || !makes_triangles(primitives[i]) || !triangle_count(l, primitives[i])) continue;
        if (exclusion_of(l, index, primitives[i]) != CASTS) continue;
        placement p = {};
        p.index     = i;
        bool    has = false;
        failure f   = fault_of([&] { has = find_placement(l, index, instances, p); });
        if (f) lose_primitive(l, cost::PRIMITIVE, index, i, f, instances * triangle_count(l, primitives[i]));
        if (has) placements.push_back(p);
    }
    return placements;
}

/* Place the next triangle.
 * why  [out] the fault if it cannot be placed; only the first one is stored
 * Returns false if it cannot be placed. */
static bool place_triangle(loader &l, placement &p, size_t t, failure &why)
{
    scene   *s = l.s;
    uint32_t element[3], *out = s->indices + 3 * s->triangle_count;
    triangle_elements(p, t, element);
    for (int i = 0; i < 3; i++) {
        if ((out[i] = vertex_of(l, p, element[i])) < UINT32_MAX) continue;
        if (!why) why = bad_vertex(p, element[i]);
        return false;
    }
    if (p.uvs && !append_mask_triangle(l, p, element)) {
        if (!why)
            why = {VXS_E_SCENE, p.uvs->label + ": a texture coordinate of triangle " + std::to_string(t) + " is not finite", false};
        return false;
    }
    s->triangle_flags[s->triangle_count++] = p.flags;
    return true;
}

/* Place the triangles of a primitive. Consecutive primitives with the same accessor share its vertices; `last` is the accessor of
 * the current slots. */
static void place_primitive(loader &l, size_t node, placement &p, const elements *&last)
{
    bool    own_places = !p.targets.empty() || p.skin;
    failure why;
    size_t  first = l.s->triangle_count, mesh = (size_t)l.model.nodes[node].mesh;
    if (p.positions != last || own_places) l.generation++;
    last = own_places ? nullptr : p.positions;
    if (l.slots.size() < p.positions->count) l.slots.resize(p.positions->count);

    begin_part(l, node, *p.primitive, p.skin ? p.skin->ws_from_bind[0].origin : p.ws_from_node.origin);
    for (size_t t = 0; t < p.triangles; t++) place_triangle(l, p, t, why);
    size_t placed = l.s->triangle_count - first;
    if (placed < p.triangles) lose_primitive(l, cost::TRIANGLES, node, p.index, why, p.triangles - placed);
    if (l.choice->areas && p.material) append_area(l, p, first, placed);
    if (p.off_count)
        take_note(l, cost::SKIN, (uint64_t)mesh << 32 | p.index, primitive_label(l, mesh, p.index),
                  "weights of joints do not sum to 1: taken as shares of their sum", "export it again",
                  std::exchange(p.off_count, 0));
}

void place_meshes(loader &l, size_t triangles)
{
    if (triangles) {
        l.s->positions_ws   = (double *)pages_alloc((3 * l.vertex_capacity + 1) * sizeof(double));
        l.s->indices        = (uint32_t *)pages_alloc(3 * triangles * sizeof(uint32_t));
        l.s->triangle_flags = (uint8_t *)pages_alloc(triangles);
        if (!l.s->positions_ws || !l.s->indices || !l.s->triangle_flags)
            l.error(VXS_E_MEMORY, "out of memory for %zu triangles", triangles);
    }
    for (size_t node : l.order) {
        size_t                 instances = l.model.nodes[node].mesh >= 0 ? usable_instances(l, node) : 0;
        std::vector<placement> placements;
        if (instances) placements = find_placements(l, node, instances);
        for (size_t i = 0; i < instances && !placements.empty(); i++) {
            transform       ws_from_instance = instance_transform(l, node, i);
            const elements *last             = nullptr;
            for (placement &p : placements) {
                p.ws_from_node = ws_from_instance;
                p.mirrored     = is_mirrored(ws_from_instance);
                place_primitive(l, node, p, last);
            }
        }
    }
    place_masks(l);
    finish_parts(l);
    finish_exclusions(l);
    if (!l.s->vertex_count) return;
    double *fitted = (double *)realloc(l.s->positions_ws, 3 * l.s->vertex_count * sizeof(double));
    if (fitted) l.s->positions_ws = fitted;
}

} // namespace gltf
