/* Skins (3.7.3): joints determine the position of each vertex, in the pose given by the file's nodes. The transform of the mesh's
 * node is ignored. Bind space is the space of the stored vertices; a joint's inverse bind matrix transforms from it to the joint.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/scene/gltf/gltf_loader.h"

#include <algorithm>

namespace gltf
{

/* Deviation of a sum of weights that rounding to 8 bits cannot explain. */
static constexpr double FAR_OFF = 0.05;

void read_skins(loader &l, const json &root)
{
    for (size_t i = 0; i < items(root, "skins").size(); i++) {
        const json &object = root["skins"][i];
        skin        s      = {};
        auto        broken = l.faults[SKINS].find(i);
        s.inverse_bind     = object.value("inverseBindMatrices", -1);
        if (broken != l.faults[SKINS].end()) s.fault = broken->second;
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

static const elements &attribute_of(loader &l, const std::string &where, const placement &p, const std::string &name)
{
    if (p.draco && p.draco->attributes.count(name)) return p.draco->attributes.at(name);
    const elements &e = sound_accessor(l, where, name.c_str(), attribute(p.primitive->attributes, name));
    if (e.type != TINYGLTF_TYPE_VEC4) l.broken(where + ", " + e.label, "%s is not a VEC4", name.c_str());
    if (e.count != p.positions->count)
        l.broken(where, "%zu elements of %s, expected %zu", e.count, name.c_str(), p.positions->count);
    return use_accessor(l, (size_t)attribute(p.primitive->attributes, name));
}

static void check_joints(loader &l, const elements &e, size_t joints)
{
    if (!is_unsigned(e.component) || e.component == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT)
        l.broken(e.label, "joints are not of 8 or 16 bits");
    for (size_t i = 0; i < e.count; i++)
        for (size_t k = 0; k < 4; k++)
            if (!(e.value(i, k) < (double)joints))
                l.broken(e.label, "joint %g of vertex %zu, and the skin has %zu", e.value(i, k), i, joints);
}

void find_skin(loader &l, const std::string &where, const tinygltf::Node &node, placement &p)
{
    p.skin = &use_skin(l, where, (size_t)node.skin);
    for (int set = 0; attribute(p.primitive->attributes, "JOINTS_" + std::to_string(set)) >= 0; set++) {
        const elements &joints  = attribute_of(l, where, p, "JOINTS_" + std::to_string(set));
        const elements &weights = attribute_of(l, where, p, "WEIGHTS_" + std::to_string(set));
        if (joints.normalized) l.broken(joints.label, "joints are normalised numbers");
        if (weights.component != TINYGLTF_COMPONENT_TYPE_FLOAT && !(is_unsigned(weights.component) && weights.normalized))
            l.broken(weights.label, "weights are not floats or normalised unsigned integers");
        check_joints(l, joints, p.skin->joints.size());
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
            if (!(weight > 0)) continue; /* ignores NaN and negative weights */
            total += weight;
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
