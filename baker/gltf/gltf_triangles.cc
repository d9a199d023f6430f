/* Primitives to triangles in world space.
 *
 * Shared accessors: vertices are emitted when an index first names them and shared between the primitives of a node, so
 * memory follows the triangles and not the accessors (2023 fans over one accessor emit its vertices once).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/gltf/gltf_loader.h"

#include "baker/base/array.h"

namespace gltf
{

vec3 position(const elements &e, size_t index)
{
    if (e.component != TINYGLTF_COMPONENT_TYPE_FLOAT) return {e.value(index, 0), e.value(index, 1), e.value(index, 2)};
    float p[3];
    memcpy(p, e.data + index * e.stride, sizeof p);
    return {p[0], p[1], p[2]};
}

/* The scene's vertex for an accessor's element; UINT32_MAX when it has no finite position. */
static inline uint32_t vertex_of(loader &l, const placement &p, uint32_t index)
{
    loader::slot &slot = l.slots[index];
    if (slot.generation == l.generation) return slot.vertex;

    scene *s = l.s;
    if (!array_reserve(&s->positions_ws, &l.vertex_capacity, s->vertex_count + 1, 3 * sizeof(double))) throw std::bad_alloc();
    vec3 v = position(*p.positions, index);
    for (const morph &m : p.targets) {
        vec3 d = position(*m.positions, index);
        v      = {v.x + m.weight * d.x, v.y + m.weight * d.y, v.z + m.weight * d.z};
    }
    v = apply(p.ws_from_node, v);
    if (!finite(v)) return UINT32_MAX;
    memcpy(s->positions_ws + 3 * s->vertex_count, &v, sizeof v);
    slot = {l.generation, (uint32_t)s->vertex_count++};
    return slot.vertex;
}

/* Corners of triangle t (3.7.2.1). */
void triangle_elements(const placement &p, size_t t, uint32_t element[3])
{
    size_t corner[3] = {3 * t, 3 * t + 1, 3 * t + 2};
    if (p.primitive->mode == TINYGLTF_MODE_TRIANGLE_STRIP) corner[0] = t, corner[1] = t + 1 + t % 2, corner[2] = t + 2 - t % 2;
    if (p.primitive->mode == TINYGLTF_MODE_TRIANGLE_FAN) corner[0] = t + 1, corner[1] = t + 2, corner[2] = 0;
    if (p.mirrored) std::swap(corner[1], corner[2]);
    for (int i = 0; i < 3; i++) element[i] = p.indices ? p.indices->index(corner[i]) : (uint32_t)corner[i];
}

/* Which accessor has the value that is not finite; when none has, the place is too far away. */
[[noreturn]] static void explain_bad_vertex(loader &l, const placement &p, uint32_t vertex, size_t node)
{
    const elements *bad = finite(position(*p.positions, vertex)) ? nullptr : p.positions;
    for (const morph &target : p.targets)
        if (!bad && !finite(position(*target.positions, vertex))) bad = target.positions;
    if (bad) l.broken(bad->label, "position %u is not finite", vertex);
    l.broken(label("node", l.model.nodes, node), "a vertex of its mesh is not finite once placed");
}

static void find_geometry(loader &l, const std::string &where, placement &p)
{
    const tinygltf::Primitive &primitive = *p.primitive;
    if (needs_draco(l, primitive)) {
        p.draco     = &use_draco(l, where, primitive);
        p.positions = &p.draco->attributes.at("POSITION");
        p.indices   = &p.draco->indices;
    } else {
        p.positions = &use_accessor(l, attribute(primitive.attributes, "POSITION"));
        if (primitive.indices >= 0) p.indices = &use_accessor(l, primitive.indices);
    }
    if (p.indices) check_index_values(l, *p.indices, p.positions->count);
}

/* The weights of a node's morph targets (3.7.2.2) are its own, else the mesh's, else none. */
static void find_targets(loader &l, const tinygltf::Node &node, const std::string &where, placement &p)
{
    const std::vector<double> &weights = node.weights.empty() ? l.model.meshes[node.mesh].weights : node.weights;
    check_weights(l, label("mesh", l.model.meshes, node.mesh), weights, *p.primitive);
    for (size_t i = 0; i < weights.size(); i++) {
        int accessor = attribute(p.primitive->targets[i], "POSITION");
        if (weights[i] == 0 || accessor < 0) continue;
        const elements &target = use_accessor(l, accessor);
        if (target.count != p.positions->count)
            l.broken(where, "a morph target of %zu vertices, expected %zu", target.count, p.positions->count);
        p.targets.push_back({weights[i], &target});
    }
}

static void apply_material(loader &l, const std::string &where, placement &p)
{
    if (!p.material) return;
    bool holes = p.material->surface == material::WITH_HOLES;
    p.flags    = (uint8_t)((p.material->double_sided ? TRIANGLE_DOUBLE_SIDED : 0) | (holes ? TRIANGLE_ALPHA_MASK : 0));
    if (p.material->masked) warn_about_colors(l, where, p);
    if (holes) find_uvs(l, where, p);
}

/* What one node places, each time. */
static std::vector<placement> find_placements(loader &l, size_t index, size_t instances)
{
    const tinygltf::Node  &node = l.model.nodes[index];
    std::vector<placement> placements;
    const auto            &primitives = l.model.meshes[node.mesh].primitives;
    for (size_t i = 0; i < primitives.size(); i++) {
        if (!makes_triangles(primitives[i]) || !triangle_count(l, primitives[i])) continue;
        if (exclusion_of(l, index, primitives[i]) != CASTS) continue;
        placement p = {};
        p.primitive = &primitives[i];
        p.triangles = triangle_count(l, primitives[i]);

        std::string where = primitive_label(l, node.mesh, i);
        if (primitives[i].material >= 0) {
            material &m = use_material(l, primitives[i].material);
            p.material  = &m;
            if (m.surface == material::NOWHERE) {
                m.left_out += instances * p.triangles;
                continue;
            }
        }
        find_geometry(l, where, p);
        find_targets(l, node, where, p);
        apply_material(l, where, p);
        placements.push_back(p);
    }
    return placements;
}

/* Primitives that follow each other over one accessor share its vertices; `last` is what the slots hold. */
static void place_primitive(loader &l, size_t node, const placement &p, const elements *&last)
{
    scene *s = l.s;
    if (p.positions != last || !p.targets.empty()) l.generation++;
    last = p.targets.empty() ? p.positions : nullptr;
    if (l.slots.size() < p.positions->count) l.slots.resize(p.positions->count);

    begin_part(l, node, *p.primitive, p.ws_from_node.origin);
    uint32_t *out = s->indices + 3 * s->triangle_count;
    for (size_t t = 0; t < p.triangles; t++, out += 3) {
        uint32_t element[3];
        triangle_elements(p, t, element);
        for (int i = 0; i < 3; i++) {
            out[i] = vertex_of(l, p, element[i]);
            if (out[i] == UINT32_MAX) explain_bad_vertex(l, p, element[i], node);
        }
    }
    memset(s->triangle_flags + s->triangle_count, p.flags, p.triangles);
    if (p.uvs) append_mask_triangles(l, p, s->triangle_count);
    size_t first = s->triangle_count;
    s->triangle_count += p.triangles;
    if (l.choice->areas && p.material) append_area(l, p, first);
}

static void place_node(loader &l, size_t node)
{
    size_t                 instances  = count_instances(l, node);
    std::vector<placement> placements = instances ? find_placements(l, node, instances) : std::vector<placement>();
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

static void make_room(loader &l, size_t triangles)
{
    l.s->positions_ws   = (double *)pages_alloc((3 * l.vertex_capacity + 1) * sizeof(double));
    l.s->indices        = (uint32_t *)pages_alloc(3 * triangles * sizeof(uint32_t));
    l.s->triangle_flags = (uint8_t *)pages_alloc(triangles);
    if (!l.s->positions_ws || !l.s->indices || !l.s->triangle_flags)
        l.error(VXS_E_MEMORY, "out of memory for %zu triangles", triangles);
}

void place_meshes(loader &l, size_t triangles)
{
    if (triangles) make_room(l, triangles);
    for (size_t node : l.order)
        if (l.model.nodes[node].mesh >= 0) place_node(l, node);
    place_masks(l);
    finish_parts(l);
    if (!l.s->vertex_count) return;
    double *fitted = (double *)realloc(l.s->positions_ws, 3 * l.s->vertex_count * sizeof(double));
    if (fitted) l.s->positions_ws = fitted;
}

} // namespace gltf
