/* Smoke: points and lines with the attributes _RADIUS and _EXTINCTION (3.7.2.1: names starting with _ are application-specific)
 * become capsules that attenuate light.
 *
 *     POINTS                            a ball per point
 *     LINES, LINE_STRIP, LINE_LOOP      a capsule per line, with the mean radius and extinction of its ends
 *
 * The scale of a node multiplies radii and divides extinctions, so that the transmittance of a cloud does not depend on its size.
 * For a non-uniform scale, the cube root of the change in volume is used, because a ball stays a ball.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/base/portable_math.h"
#include "baker/scene/gltf/gltf_loader.h"

namespace gltf
{

static const char *const RADIUS = "_RADIUS", *const EXTINCTION = "_EXTINCTION";

/* Larger positions, radii and extinctions are invalid (vxs_capsule.h). */
static const double METRES_MOST = 1e12, EXTINCTION_MOST = 1e30;

bool makes_smoke(const tinygltf::Primitive &p)
{
    return p.mode < TINYGLTF_MODE_TRIANGLES && attribute(p.attributes, "POSITION") >= 0 && attribute(p.attributes, RADIUS) >= 0 &&
           attribute(p.attributes, EXTINCTION) >= 0;
}

size_t capsule_count(const loader &l, const tinygltf::Primitive &p)
{
    size_t ends = corner_count(l, p);
    switch (p.mode) {
    case TINYGLTF_MODE_POINTS: return ends;
    case TINYGLTF_MODE_LINE: return ends / 2;
    case TINYGLTF_MODE_LINE_LOOP: return ends < 2 ? 0 : ends;
    default: return ends < 2 ? 0 : ends - 1;
    }
}

void check_smoke(loader &l, const std::string &primitive, const tinygltf::Primitive &p)
{
    size_t vertices = l.accessors[attribute(p.attributes, "POSITION")].count;
    for (const char *name : {RADIUS, EXTINCTION})
        check_attribute(l, primitive, p, name, TINYGLTF_TYPE_SCALAR, "a scalar", vertices);
}

/* One primitive of a node. */
struct cloud {
    const tinygltf::Primitive *primitive;
    const elements            *positions, *radii, *extinctions;
    const elements            *indices; /* NULL: 0, 1, 2, ... */
    size_t                     capsules;
    float                      albedo[3];
};

static double amount(loader &l, const elements &e, const char *name, uint32_t vertex)
{
    double value = e.value(vertex, 0);
    if (!(value >= 0) || !std::isfinite(value)) l.broken(e.label, "%s %u is %g, expected 0 or more", name, vertex, value);
    return value;
}

static vec3 placed_end(loader &l, const cloud &c, const transform &ws_from_node, uint32_t vertex)
{
    vec3 v = position(*c.positions, vertex);
    if (!finite(v)) l.broken(c.positions->label, "position %u is not finite", vertex);
    v           = apply(ws_from_node, v);
    double most = std::max({std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)});
    if (!(most < METRES_MOST)) l.broken(c.positions->label, "position %u is %g m away once placed", vertex, most);
    return v;
}

static void add_capsule(loader &l, const cloud &c, const transform &ws_from_node, double larger, size_t i)
{
    scene_smoke &smoke = l.s->smoke;
    int          mode  = c.primitive->mode;
    size_t       first = mode == TINYGLTF_MODE_LINE ? 2 * i : i, last = mode == TINYGLTF_MODE_POINTS ? first : first + 1;
    if (mode == TINYGLTF_MODE_LINE_LOOP && last == c.capsules) last = 0;
    uint32_t ends[2] = {c.indices ? c.indices->index(first) : (uint32_t)first, c.indices ? c.indices->index(last) : (uint32_t)last};
    double   radius  = larger * 0.5 * (amount(l, *c.radii, RADIUS, ends[0]) + amount(l, *c.radii, RADIUS, ends[1]));
    double   extinction = 0.5 * (amount(l, *c.extinctions, EXTINCTION, ends[0]) + amount(l, *c.extinctions, EXTINCTION, ends[1]));
    vec3     begin = placed_end(l, c, ws_from_node, ends[0]), end = placed_end(l, c, ws_from_node, ends[1]);
    if (!(radius > 0) || !(extinction > 0)) return;
    extinction /= larger;
    if (!(radius < METRES_MOST) || !(extinction < EXTINCTION_MOST))
        l.broken(c.radii->label, "a capsule of %g m with an extinction of %g a metre once placed", radius, extinction);
    if (!smoke.count) memcpy(smoke.origin_ws, &begin, sizeof begin);
    const double *o = smoke.origin_ws;
    memcpy(smoke.albedos[smoke.count], c.albedo, sizeof c.albedo);
    smoke.list[smoke.count++] = {{(float)(begin.x - o[0]), (float)(begin.y - o[1]), (float)(begin.z - o[2])},
                                 (float)radius,
                                 {(float)(end.x - o[0]), (float)(end.y - o[1]), (float)(end.z - o[2])},
                                 (float)extinction};
}

static cloud find_cloud(loader &l, const tinygltf::Primitive &p)
{
    static const float grey = 0.9f;
    cloud              c    = {&p, nullptr, nullptr, nullptr, nullptr, capsule_count(l, p), {grey, grey, grey}};
    c.positions             = &use_accessor(l, attribute(p.attributes, "POSITION"));
    c.radii                 = &use_accessor(l, attribute(p.attributes, RADIUS));
    c.extinctions           = &use_accessor(l, attribute(p.attributes, EXTINCTION));
    if (p.indices >= 0) c.indices = &use_accessor(l, p.indices);
    if (c.indices) check_index_values(l, *c.indices, c.positions->count, true);
    if (p.material >= 0) memcpy(c.albedo, l.materials[p.material].colour, sizeof c.albedo);
    return c;
}

/* 1 when a node's primitive is smoke, as far as is known. */
static bool is_cloud(const loader &l, size_t node, size_t index)
{
    size_t                     mesh = (size_t)l.model.nodes[node].mesh;
    const tinygltf::Primitive &p    = l.model.meshes[mesh].primitives[index];
    return !primitive_fault(l, mesh, index) && makes_smoke(p) && capsule_count(l, p) && exclusion_of(l, node, p) == CASTS;
}

/* Place all instances of a node's smoke. */
static void place_clouds(loader &l, size_t node)
{
    const auto &primitives = l.model.meshes[l.model.nodes[node].mesh].primitives;
    for (size_t i = 0; i < primitives.size(); i++) {
        size_t instances = is_cloud(l, node, i) ? usable_instances(l, node) : 0;
        if (!instances) continue;
        cloud   c = {};
        failure f = fault_of([&] { c = find_cloud(l, primitives[i]); });
        if (f) lose_primitive(l, cost::SMOKE, node, i, f, instances * capsule_count(l, primitives[i]));
        for (size_t n = 0; n < instances && !f; n++) {
            transform ws_from_instance = instance_transform(l, node, n);
            double    larger           = portable_cbrt(std::fabs(volume_scale(ws_from_instance)));
            for (size_t k = 0; k < c.capsules; k++) {
                failure lost = fault_of([&] { add_capsule(l, c, ws_from_instance, larger, k); });
                if (lost) lose_primitive(l, cost::CAPSULES, node, i, lost, 1);
            }
        }
    }
}

size_t count_capsules(loader &l)
{
    size_t total = 0;
    for (size_t node : l.order) {
        if (l.model.nodes[node].mesh < 0) continue;
        size_t      instances  = count_instances(l, node);
        const auto &primitives = l.model.meshes[l.model.nodes[node].mesh].primitives;
        for (size_t i = 0; i < primitives.size(); i++) {
            if (!is_cloud(l, node, i)) continue;
            size_t capsules = capsule_count(l, primitives[i]);
            if (instances > (SMOKE_CAPSULES_MAX - total) / capsules)
                l.refused("", "more than %u capsules of smoke in the scene, with those of %s", SMOKE_CAPSULES_MAX,
                          label("node", l.model.nodes, node).c_str());
            total += instances * capsules;
        }
    }
    return total;
}

void place_smoke(loader &l)
{
    scene_smoke &smoke = l.s->smoke;
    size_t       total = count_capsules(l);
    if (!total) return;
    l.need(total * (sizeof *smoke.list + sizeof *smoke.albedos), std::to_string(total) + " capsules of smoke");
    smoke.list    = zeroed<vxs_capsule>(total);
    smoke.albedos = zeroed<float[3]>(total);
    for (size_t node : l.order)
        if (l.model.nodes[node].mesh >= 0) place_clouds(l, node);
}

} // namespace gltf
