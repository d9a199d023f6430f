/* Primitives to triangles in world space.
 *
 * Shared accessors: vertices are emitted when an index first names them and shared between the primitives of a node, so
 * memory follows the triangles and not the accessors (2023 fans over one accessor emit its vertices once).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/scene/gltf_loader.h"

namespace gltf
{

/* One primitive placed by one node. */
struct placement {
    const elements                                  *positions;
    const elements                                  *indices; /* NULL: 0, 1, 2, ... */
    std::vector<std::pair<double, const elements *>> targets; /* of weight not 0 */
    transform                                        ws_from_node;
    int                                              mode;
    bool                                             mirrored;
    size_t                                           triangles;
};

static vec3 read_position(const elements &e, size_t index)
{
    float p[3];
    memcpy(p, e.data + index * e.stride, sizeof p);
    return {p[0], p[1], p[2]};
}

static vec3 morphed_position(const placement &p, size_t index)
{
    vec3 v = read_position(*p.positions, index);
    for (const auto &[weight, target] : p.targets) {
        vec3 d = read_position(*target, index);
        v      = {v.x + weight * d.x, v.y + weight * d.y, v.z + weight * d.z};
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

/* The first corner whose index is not below the limit, or the count of corners. */
template <typename T> size_t find_bad_index(const elements &indices, size_t limit)
{
    size_t i = 0;
    while (i < indices.count && index_at<T>(&indices, i) < limit) i++;
    return i;
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

/* 3.7.2.1: no index may name a missing vertex or be the largest value of its type, which restarts primitives elsewhere. */
static vxs_result check_index_values(loader &l, const placement &p, int accessor)
{
    const elements &e     = *p.indices;
    size_t          limit = std::min(p.positions->count, e.size == 4 ? (size_t)UINT32_MAX : ((size_t)1 << 8 * e.size) - 1);
    size_t          bad   = e.size == 1   ? find_bad_index<uint8_t>(e, limit)
                            : e.size == 2 ? find_bad_index<uint16_t>(e, limit)
                                          : find_bad_index<uint32_t>(e, limit);
    if (bad == e.count) return VXS_OK;
    return l.error(VXS_E_SCENE, "%s: index %zu is %u, expected less than %zu",
                   label("accessor", (size_t)accessor, l.model.accessors[(size_t)accessor].name).c_str(), bad,
                   unsigned_at(e.data + bad * e.stride, e.size), limit);
}

static vxs_result explain_bad_vertex(loader &l, const placement &p, uint32_t vertex, size_t node_index, int position_accessor)
{
    if (!finite(read_position(*p.positions, vertex)))
        return l.error(VXS_E_SCENE, "%s: position %u is not finite",
                       label("accessor", (size_t)position_accessor, l.model.accessors[(size_t)position_accessor].name).c_str(),
                       vertex);
    return l.error(VXS_E_SCENE, "%s: a vertex of its mesh is not finite once placed",
                   label("node", node_index, l.model.nodes[node_index].name).c_str());
}

static vxs_result open_placement(loader &l, const tinygltf::Node &node, const tinygltf::Primitive &primitive, placement &p)
{
    const tinygltf::Mesh      &mesh    = l.model.meshes[(size_t)node.mesh];
    const std::vector<double> &weights = morph_weights(node, mesh);
    vxs_result                 r       = use_accessor(l, attribute(primitive.attributes, "POSITION"), p.positions);
    if (r == VXS_OK && primitive.indices >= 0) r = use_accessor(l, primitive.indices, p.indices);
    if (r == VXS_OK && p.indices) r = check_index_values(l, p, primitive.indices);
    if (r == VXS_OK && !weights.empty() && weights.size() != primitive.targets.size())
        return l.error(VXS_E_SCENE, "%s: %zu weights for %zu morph targets", label("mesh", (size_t)node.mesh, mesh.name).c_str(),
                       weights.size(), primitive.targets.size());
    for (size_t i = 0; r == VXS_OK && i < weights.size(); i++) {
        int             accessor = attribute(primitive.targets[i], "POSITION");
        const elements *target   = nullptr;
        if (weights[i] == 0 || accessor < 0) continue;
        r = use_accessor(l, accessor, target);
        p.targets.push_back({weights[i], target});
    }
    return r;
}

static uint8_t material_flags(const loader &l, int material)
{
    if (material < 0) return 0;
    const tinygltf::Material &m = l.model.materials[(size_t)material];
    return (uint8_t)((m.doubleSided ? TRIANGLE_DOUBLE_SIDED : 0) | (m.alphaMode == "MASK" ? TRIANGLE_ALPHA_MASK : 0));
}

/* Primitives that follow each other over one accessor share its vertices; `last_position` is what the slots hold. */
static vxs_result place_primitive(loader &l, size_t node_index, const tinygltf::Primitive &primitive, int &last_position)
{
    const tinygltf::Node &node     = l.model.nodes[node_index];
    int                   position = attribute(primitive.attributes, "POSITION");
    placement             p        = {};
    p.ws_from_node                 = l.ws_from_node[node_index];
    p.mirrored                     = is_mirrored(p.ws_from_node);
    p.mode                         = primitive.mode;
    p.triangles                    = triangle_count(l, primitive);
    vxs_result r                   = open_placement(l, node, primitive, p);
    if (r != VXS_OK) return r;

    if (position != last_position || !p.targets.empty()) l.generation++;
    last_position = p.targets.empty() ? position : -1;
    if (l.slots.size() < p.positions->count) l.slots.resize(p.positions->count);

    uint32_t bad = 0;
    bool     ok  = !p.indices             ? append_triangles<void>(l, p, bad)
                   : p.indices->size == 1 ? append_triangles<uint8_t>(l, p, bad)
                   : p.indices->size == 2 ? append_triangles<uint16_t>(l, p, bad)
                                          : append_triangles<uint32_t>(l, p, bad);
    if (!ok) return explain_bad_vertex(l, p, bad, node_index, position);
    memset(l.s->triangle_flags + l.s->triangle_count, material_flags(l, primitive.material), p.triangles);
    l.s->triangle_count += p.triangles;
    return VXS_OK;
}

vxs_result place_meshes(loader &l)
{
    vxs_result r = measure(l);
    for (size_t i = 0; r == VXS_OK && i < l.order.size(); i++) {
        size_t node          = (size_t)l.order[i];
        int    last_position = -1;
        if (l.model.nodes[node].mesh < 0) continue;
        for (const tinygltf::Primitive &p : l.model.meshes[(size_t)l.model.nodes[node].mesh].primitives)
            if (makes_triangles(p) && triangle_count(l, p) && (r = place_primitive(l, node, p, last_position)) != VXS_OK) break;
    }
    if (r == VXS_OK && l.s->vertex_count) {
        double *fitted = (double *)realloc(l.s->positions_ws, 3 * l.s->vertex_count * sizeof(double));
        if (fitted) l.s->positions_ws = fitted;
    }
    return r;
}

} // namespace gltf
