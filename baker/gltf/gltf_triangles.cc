/* Primitives to triangles in world space.
 *
 * Shared accessors: vertices are emitted when an index first names them and shared between the primitives of a node, so
 * memory follows the triangles and not the accessors (2023 fans over one accessor emit its vertices once).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/gltf/gltf_loader.h"

namespace gltf
{

static vec3 read_position(const elements &e, size_t index)
{
    const unsigned char *at = e.data + index * e.stride;
    if (e.component == TINYGLTF_COMPONENT_TYPE_FLOAT) {
        float p[3];
        memcpy(p, at, sizeof p);
        return {p[0], p[1], p[2]};
    }
    size_t step = component_bytes(e.component);
    return {component_at(at, e.component, e.normalized), component_at(at + step, e.component, e.normalized),
            component_at(at + 2 * step, e.component, e.normalized)};
}

static vec3 morphed_position(const placement &p, size_t index)
{
    vec3 v = read_position(*p.positions, index);
    for (const morph &m : p.targets) {
        vec3 d = read_position(*m.positions, index);
        v      = {v.x + m.weight * d.x, v.y + m.weight * d.y, v.z + m.weight * d.z};
    }
    return v;
}

/* The scene's vertex for an accessor's element; UINT32_MAX when it has no finite position or there is no memory. */
static inline uint32_t vertex_of(loader &l, const placement &p, uint32_t index)
{
    loader::slot &slot = l.slots[index];
    if (slot.generation == l.generation) return slot.vertex;

    scene *s = l.s;
    if (s->vertex_count == l.vertex_capacity) {
        size_t  capacity = std::max((size_t)4096, 2 * l.vertex_capacity);
        double *grown    = (double *)realloc(s->positions_ws, 3 * capacity * sizeof(double));
        if (!grown) throw std::bad_alloc();
        s->positions_ws   = grown;
        l.vertex_capacity = capacity;
    }
    vec3 v = apply(p.ws_from_node, p.targets.empty() ? read_position(*p.positions, index) : morphed_position(p, index));
    if (!finite(v)) return UINT32_MAX;
    memcpy(s->positions_ws + 3 * s->vertex_count, &v, sizeof v);
    slot = {l.generation, (uint32_t)s->vertex_count++};
    return slot.vertex;
}

/* Corners of triangle t (3.7.2.1). */
static inline void triangle_corners(int mode, size_t t, size_t corner[3])
{
    switch (mode) {
    case TINYGLTF_MODE_TRIANGLE_STRIP: corner[0] = t, corner[1] = t + 1 + t % 2, corner[2] = t + 2 - t % 2; break;
    case TINYGLTF_MODE_TRIANGLE_FAN: corner[0] = t + 1, corner[1] = t + 2, corner[2] = 0; break;
    default: corner[0] = 3 * t, corner[1] = 3 * t + 1, corner[2] = 3 * t + 2;
    }
}

template <typename T> inline uint32_t index_at(const elements *indices, size_t i)
{
    T value;
    memcpy(&value, indices->data + i * sizeof value, sizeof value);
    return value;
}

template <> inline uint32_t index_at<void>(const elements *, size_t i)
{
    return (uint32_t)i;
}

/* Append the placement's triangles; false at a vertex without a finite position, whose element goes to `bad`. */
template <typename T> bool append_triangles(loader &l, const placement &p, uint32_t &bad)
{
    uint32_t *out = l.s->indices + 3 * l.s->triangle_count;
    for (size_t t = 0; t < p.triangles; t++, out += 3) {
        size_t corner[3];
        triangle_corners(p.mode, t, corner);
        if (p.mirrored) std::swap(corner[1], corner[2]);
        for (int i = 0; i < 3; i++) {
            uint32_t index = index_at<T>(p.indices, corner[i]);
            out[i]         = vertex_of(l, p, index);
            if (out[i] == UINT32_MAX) return bad = index, false;
        }
    }
    return true;
}

void triangle_elements(const placement &p, size_t t, uint32_t element[3])
{
    size_t corner[3];
    triangle_corners(p.mode, t, corner);
    if (p.mirrored) std::swap(corner[1], corner[2]);
    for (int i = 0; i < 3; i++)
        element[i] = !p.indices             ? index_at<void>(p.indices, corner[i])
                     : p.indices->size == 1 ? index_at<uint8_t>(p.indices, corner[i])
                     : p.indices->size == 2 ? index_at<uint16_t>(p.indices, corner[i])
                                            : index_at<uint32_t>(p.indices, corner[i]);
}

/* Which accessor has the value that is not finite; when none has, the place is too far away. */
static vxs_result explain_bad_vertex(loader &l, const placement &p, uint32_t vertex, size_t node_index)
{
    int accessor = finite(read_position(*p.positions, vertex)) ? -1 : attribute(p.primitive->attributes, "POSITION");
    for (const morph &target : p.targets)
        if (accessor < 0 && !finite(read_position(*target.positions, vertex))) accessor = target.accessor;
    if (accessor >= 0)
        return l.error(VXS_E_SCENE, "%s: position %u is not finite",
                       label("accessor", (size_t)accessor, l.model.accessors[(size_t)accessor].name).c_str(), vertex);
    return l.error(VXS_E_SCENE, "%s: a vertex of its mesh is not finite once placed",
                   label("node", node_index, l.model.nodes[node_index].name).c_str());
}

static vxs_result open_geometry(loader &l, const std::string &where, placement &p)
{
    const tinygltf::Primitive &primitive = *p.primitive;
    vxs_result                 r;
    if (needs_draco(l, primitive)) {
        if ((r = use_draco(l, where, primitive, p.draco)) != VXS_OK) return r;
        p.positions = &p.draco->attributes.at("POSITION");
        p.indices   = &p.draco->indices;
    } else {
        if ((r = use_accessor(l, attribute(primitive.attributes, "POSITION"), p.positions)) != VXS_OK) return r;
        if (primitive.indices >= 0 && (r = use_accessor(l, primitive.indices, p.indices)) != VXS_OK) return r;
    }
    return p.indices ? check_index_values(l, *p.indices, primitive.indices, p.positions->count) : VXS_OK;
}

static vxs_result open_targets(loader &l, const tinygltf::Node &node, const std::string &where, placement &p)
{
    const tinygltf::Mesh      &mesh    = l.model.meshes[(size_t)node.mesh];
    const std::vector<double> &weights = morph_weights(node, mesh);
    if (!weights.empty() && weights.size() != p.primitive->targets.size())
        return l.error(VXS_E_SCENE, "%s: %zu weights for %zu morph targets", label("mesh", (size_t)node.mesh, mesh.name).c_str(),
                       weights.size(), p.primitive->targets.size());
    for (size_t i = 0; i < weights.size(); i++) {
        int             accessor = attribute(p.primitive->targets[i], "POSITION");
        const elements *target   = nullptr;
        if (weights[i] == 0 || accessor < 0) continue;
        vxs_result r = use_accessor(l, accessor, target);
        if (r != VXS_OK) return r;
        if (target->count != p.positions->count)
            return l.error(VXS_E_SCENE, "%s: a morph target of %zu vertices, expected %zu", where.c_str(), target->count,
                           p.positions->count);
        p.targets.push_back({weights[i], accessor, target});
    }
    return VXS_OK;
}

static vxs_result open_material(loader &l, const std::string &where, placement &p)
{
    if (!p.mask) return VXS_OK;
    const material &m     = l.materials[(size_t)p.primitive->material];
    bool            holes = p.mask->kind == material_mask::HOLES;
    p.flags               = (uint8_t)((m.double_sided ? TRIANGLE_DOUBLE_SIDED : 0) | (holes ? TRIANGLE_ALPHA_MASK : 0));
    if (m.mask) warn_about_colors(l, where, p);
    return holes ? open_mask(l, where, p) : VXS_OK;
}

/* What one node places, so often as it does. */
static vxs_result open_placements(loader &l, size_t node_index, size_t instances, std::vector<placement> &placements)
{
    const tinygltf::Node &node = l.model.nodes[node_index];
    const tinygltf::Mesh &mesh = l.model.meshes[(size_t)node.mesh];
    for (size_t i = 0; i < mesh.primitives.size(); i++) {
        const tinygltf::Primitive &primitive = mesh.primitives[i];
        if (!makes_triangles(primitive) || !triangle_count(l, primitive)) continue;
        placement p = {};
        p.primitive = &primitive;
        p.mode      = primitive.mode;
        p.triangles = triangle_count(l, primitive);

        std::string where = label("mesh", (size_t)node.mesh, mesh.name) + " " + label("primitive", i, "");
        vxs_result  r;
        if (primitive.material >= 0 && (r = use_material(l, primitive.material, p.mask)) != VXS_OK) return r;
        if (p.mask && p.mask->kind == material_mask::NOWHERE) {
            l.materials[(size_t)primitive.material].holes.left_out += instances * p.triangles;
            continue;
        }
        if ((r = open_geometry(l, where, p)) != VXS_OK) return r;
        if ((r = open_targets(l, node, where, p)) != VXS_OK) return r;
        if ((r = open_material(l, where, p)) != VXS_OK) return r;
        placements.push_back(p);
    }
    return VXS_OK;
}

/* Primitives that follow each other over one accessor share its vertices; `last` is what the slots hold. */
static vxs_result place_primitive(loader &l, size_t node_index, placement &p, const elements *&last)
{
    if (p.positions != last || !p.targets.empty()) l.generation++;
    last = p.targets.empty() ? p.positions : nullptr;
    if (l.slots.size() < p.positions->count) l.slots.resize(p.positions->count);

    uint32_t bad = 0;
    bool     ok  = !p.indices             ? append_triangles<void>(l, p, bad)
                   : p.indices->size == 1 ? append_triangles<uint8_t>(l, p, bad)
                   : p.indices->size == 2 ? append_triangles<uint16_t>(l, p, bad)
                                          : append_triangles<uint32_t>(l, p, bad);
    if (!ok) return explain_bad_vertex(l, p, bad, node_index);
    memset(l.s->triangle_flags + l.s->triangle_count, p.flags, p.triangles);
    l.s->triangle_count += p.triangles;
    return p.uvs ? append_mask_triangles(l, p, l.s->triangle_count - p.triangles) : VXS_OK;
}

static vxs_result place_node(loader &l, size_t node)
{
    std::vector<placement> placements;
    size_t                 instances;
    vxs_result             r;
    if ((r = count_instances(l, node, instances)) != VXS_OK || !instances) return r;
    if ((r = open_placements(l, node, instances, placements)) != VXS_OK || placements.empty()) return r;
    for (size_t i = 0; i < instances; i++) {
        transform       ws_from_instance;
        const elements *last = nullptr;
        if ((r = instance_transform(l, node, i, ws_from_instance)) != VXS_OK) return r;
        for (placement &p : placements) {
            p.ws_from_node = ws_from_instance;
            p.mirrored     = is_mirrored(ws_from_instance);
            if ((r = place_primitive(l, node, p, last)) != VXS_OK) return r;
        }
    }
    return VXS_OK;
}

vxs_result place_meshes(loader &l)
{
    vxs_result r = measure(l);
    for (size_t i = 0; r == VXS_OK && i < l.order.size(); i++)
        if (l.model.nodes[(size_t)l.order[i]].mesh >= 0) r = place_node(l, (size_t)l.order[i]);
    if (r == VXS_OK) r = place_masks(l);
    if (r == VXS_OK && l.s->vertex_count) {
        double *fitted = (double *)realloc(l.s->positions_ws, 3 * l.s->vertex_count * sizeof(double));
        if (fitted) l.s->positions_ws = fitted;
    }
    return r;
}

} // namespace gltf
