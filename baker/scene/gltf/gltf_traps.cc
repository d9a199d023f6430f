/* Warnings of valid content that is probably a mistake: objects that cast shadow in a bake but are absent, duplicated or moving in
 * an engine. Each warning names the first node, the number of others, and their triangles. Names of collision shapes and of levels
 * of detail are checked elsewhere, when triangles are placed.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/scene/gltf/gltf_loader.h"

#include <strings.h>

namespace gltf
{

/* Casting triangles of each node, as far as known before they are placed. */
using casting = std::vector<size_t>;

static size_t casting_triangles(loader &l, size_t node)
{
    size_t count = 0;
    int    mesh  = l.model.nodes[node].mesh;
    if (mesh < 0) return 0;
    const auto &primitives = l.model.meshes[mesh].primitives;
    for (size_t i = 0; i < primitives.size(); i++)
        if (!primitive_fault(l, (size_t)mesh, i) && makes_triangles(primitives[i]) && exclusion_of(l, node, primitives[i]) == CASTS)
            count += triangle_count(l, primitives[i]);
    return count * count_instances(l, node);
}

/* Nodes with the same problem. */
struct group {
    size_t first = SIZE_MAX, count = 0, triangles = 0;

    void add(size_t node, size_t more)
    {
        if (!count++) first = node;
        triangles += more;
    }
    std::string text(const loader &l) const
    {
        return label("node", l.model.nodes, first) + (count > 1 ? " and " + std::to_string(count - 1) + " more" : "");
    }
};

static void say(loader &l, uint64_t id, const group &g, const std::string &why, const std::string &remedy)
{
    if (g.count) take_note(l, cost::TRAP, (uint64_t)1 << 32 | id, g.text(l), why, remedy, g.triangles);
}

/* ---- names ---- */

/* Levels of detail with MSFT_lod that the scene shows in addition to the finest level. */
static void look_at_lods(loader &l, const casting &casts)
{
    group             shown;
    std::vector<char> lower(l.nodes.size(), 0);
    for (const tinygltf::Node &node : l.model.nodes) {
        auto lod = node.extensions.find("MSFT_lod");
        if (lod == node.extensions.end() || !lod->second.Has("ids") || !lod->second.Get("ids").IsArray()) continue;
        const tinygltf::Value &ids = lod->second.Get("ids");
        for (size_t i = 0; i < ids.ArrayLen(); i++) {
            int id = ids.Get((int)i).IsNumber() ? ids.Get((int)i).GetNumberAsInt() : -1;
            if (id >= 0 && (size_t)id < lower.size()) lower[(size_t)id] = 1;
        }
    }
    for (size_t node : l.order)
        if (lower[node] && casts[node]) shown.add(node, casts[node]);
    say(l, 1, shown, "by MSFT_lod a level of detail of another node, and it casts a shadow, too",
        shown.count ? exclude_remedy("node:", shown.first, l.model.nodes[shown.first].name) : "");
}

/* Materials of tool brushes (names from level editors), which an engine does not draw. */
static void look_at_materials(loader &l, const casting &casts)
{
    static const char *const names[] = {"clip",      "playerclip", "trigger",         "hint",
                                        "skip",      "toolsclip",  "toolsplayerclip", "toolstrigger",
                                        "toolshint", "toolsskip",  "toolsinvisible"};
    for (size_t node : l.order) {
        if (!casts[node]) continue;
        size_t mesh = (size_t)l.model.nodes[node].mesh;
        for (const tinygltf::Primitive &p : l.model.meshes[mesh].primitives) {
            if (p.material < 0 || exclusion_of(l, node, p) != CASTS || !makes_triangles(p)) continue;
            const std::string &name = l.materials[p.material].name, last = name.substr(name.find_last_of("/\\") + 1);
            for (const char *known : names)
                if (!strcasecmp(last.c_str(), known))
                    take_note(l, cost::TRAP, (uint64_t)2 << 32 | (uint64_t)p.material,
                              label("material", l.materials, (size_t)p.material),
                              "by its name invisible, as level editors have it, and it casts a shadow",
                              exclude_remedy("material:", (size_t)p.material, name), triangle_count(l, p));
        }
    }
}

/* ---- places ---- */

/* 1 when a transform is degenerate: no two axes span an area. */
static bool is_collapsed(const transform &t)
{
    for (int i = 0; i < 3; i++) {
        vec3 a = t.axis[i], b = t.axis[(i + 1) % 3];
        if (a.y * b.z - a.z * b.y != 0 || a.z * b.x - a.x * b.z != 0 || a.x * b.y - a.y * b.x != 0) return false;
    }
    return true;
}

static void look_at_places(loader &l, const casting &casts)
{
    group                                                 collapsed, twice;
    std::map<std::pair<int, std::vector<double>>, size_t> placed;
    for (size_t node : l.order) {
        size_t triangles = casts[node];
        if (!triangles || l.model.nodes[node].skin >= 0) continue;
        const transform &t = l.ws_from_node[node];
        if (is_collapsed(t)) {
            collapsed.add(node, triangles);
            continue;
        }
        const double *numbers = &t.axis[0].x;
        if (l.model.nodes[node].extensions.count("EXT_mesh_gpu_instancing")) continue;
        if (!placed.emplace(std::make_pair(l.model.nodes[node].mesh, std::vector<double>(numbers, numbers + 12)), node).second)
            twice.add(node, triangles);
    }
    say(l, 100, collapsed, "has a scale of 0, or a node above it has: its mesh casts nothing", "give it a scale, or delete it");
    say(l, 101, twice, "shows a mesh that another node shows at the same place: it is there twice", "delete one of the two");
}

/* ---- hidden or moving objects ---- */

static void look_at_animations(loader &l, const casting &casts)
{
    group             moved;
    std::vector<char> moves(l.nodes.size(), 0);
    const json       &animations = items(l.rest, "animations");
    for (size_t i = 0; animations.is_array() && i < animations.size(); i++) {
        const json &channels = animations[i].is_object() ? items(animations[i], "channels") : animations[i];
        for (size_t k = 0; channels.is_array() && k < channels.size(); k++) {
            const json *target = channels[k].is_object() && channels[k].contains("target") ? &channels[k]["target"] : nullptr;
            if (!target || !target->is_object() || !target->contains("node") || !(*target)["node"].is_number_unsigned()) continue;
            size_t node = (*target)["node"];
            auto   path = target->find("path");
            if (node < moves.size() && path != target->end() && (*path == "translation" || *path == "rotation" || *path == "scale"))
                moves[node] = 1;
        }
    }
    for (size_t node : l.order) { /* parents come first */
        int parent = l.file_parent[node];
        if (parent >= 0) moves[node] |= moves[(size_t)parent];
        size_t triangles = moves[node] && l.model.nodes[node].skin < 0 ? casts[node] : 0;
        if (triangles) moved.add(node, triangles);
    }
    say(l, 200, moved, "moved by animations, and its shadow is baked where it stands in the file",
        moved.count ? exclude_remedy("node:", moved.first, l.model.nodes[moved.first].name) : "");
}

/* Nodes with meshes that are in no scene. */
static void look_at_scenes(loader &l, int chosen, size_t triangles)
{
    std::vector<char> shown(l.nodes.size(), 0);
    std::vector<int>  open;
    group             orphans;
    size_t            with_mesh = SIZE_MAX;
    for (size_t i = 0; i < l.model.scenes.size(); i++) {
        open = l.model.scenes[i].nodes;
        while (!open.empty()) {
            int at = open.back();
            open.pop_back();
            if (at < 0 || (size_t)at >= shown.size() || shown[(size_t)at] > 1) continue;
            shown[(size_t)at] = 2;
            if (l.model.nodes[(size_t)at].mesh >= 0 && (int)i != chosen && with_mesh == SIZE_MAX) with_mesh = i;
            open.insert(open.end(), l.model.nodes[(size_t)at].children.begin(), l.model.nodes[(size_t)at].children.end());
        }
    }
    for (size_t i = 0; i < l.nodes.size() && !l.model.scenes.empty(); i++)
        if (!shown[i] && l.model.nodes[i].mesh >= 0) orphans.add(i, 0);
    if (orphans.count)
        take_note(l, cost::TREE, (uint64_t)1 << 50, orphans.text(l), "in no scene of the file, and so not baked",
                  "list it, or the node that it hangs from, in the scene's nodes");
    if (!triangles && chosen >= 0 && with_mesh < SIZE_MAX)
        take_note(l, cost::TREE, (uint64_t)1 << 51, label("scene", l.model.scenes, (size_t)chosen),
                  "no mesh of it casts, and " + label("scene", l.model.scenes, with_mesh) + " has meshes", "choose with --scene");
}

void look_at_traps(loader &l, int chosen, size_t triangles)
{
    casting casts(l.nodes.size(), 0);
    for (size_t node : l.order) casts[node] = casting_triangles(l, node);
    look_at_lods(l, casts);
    look_at_materials(l, casts);
    look_at_places(l, casts);
    look_at_animations(l, casts);
    look_at_scenes(l, chosen, triangles);
}

} // namespace gltf
