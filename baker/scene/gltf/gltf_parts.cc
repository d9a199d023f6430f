/* Origin of triangles: node, mesh and material, stored in the scene for messages.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/scene/gltf/gltf_loader.h"

namespace gltf
{

/* Offset of a name in l.names, where each name is stored once. */
static uint32_t name_at(loader &l, kind k, size_t index, const std::string &name)
{
    if (l.names.empty()) l.names.push_back('\0'); /* offset 0 is the empty name */
    if (l.name_at[k].size() <= index) l.name_at[k].resize(index + 1, 0);
    uint32_t &at = l.name_at[k][index];
    if (at || name.empty()) return at;
    at = (uint32_t)l.names.size();
    l.names.append(name.c_str(), strlen(name.c_str()) + 1);
    return at;
}

static void begin_origin(loader &l, vec3 origin)
{
    scene_origin from = {(uint32_t)l.s->triangle_count, {origin.x, origin.y, origin.z}};
    if (!l.origins.empty() && !memcmp(l.origins.back().at_ws, from.at_ws, sizeof from.at_ws)) return;
    l.origins.push_back(from);
}

void begin_part(loader &l, size_t node, const tinygltf::Primitive &p, vec3 origin)
{
    begin_origin(l, origin);
    scene_part part = {};
    part.node       = (uint32_t)node;
    part.mesh       = (uint32_t)l.model.nodes[node].mesh;
    part.material   = p.material >= 0 ? (uint32_t)p.material : SCENE_NO_MATERIAL;
    if (!l.parts.empty()) {
        const scene_part &last = l.parts.back(); /* instances of a primitive are consecutive and share a part */
        if (last.node == part.node && last.mesh == part.mesh && last.material == part.material) return;
    }
    part.triangle_first = (uint32_t)l.s->triangle_count;
    part.node_name      = name_at(l, NODE, node, l.model.nodes[node].name);
    part.mesh_name      = name_at(l, MESH, part.mesh, l.model.meshes[part.mesh].name);
    if (p.material >= 0) part.material_name = name_at(l, MATERIAL, part.material, l.materials[part.material].name);
    l.parts.push_back(part);
}

void finish_parts(loader &l)
{
    l.s->parts        = copied(l.parts);
    l.s->part_count   = l.parts.size();
    l.s->origins      = copied(l.origins);
    l.s->origin_count = l.origins.size();
    l.s->names        = copied(std::vector<char>(l.names.begin(), l.names.end()));
}

} // namespace gltf
