/* Notes: faults of parts of a scene, collected while it is read and reported in a few lines: the first ones of each kind, then the
 * number of others. So the report stays short for a file with thousands of faults.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <algorithm>
#include <iterator>
#include <set>
#include <strings.h>

#include "baker/scene/gltf/gltf_loader.h"

namespace gltf
{

static constexpr size_t SHOWN = 3, EXTENSIONS_SHOWN = 16, URI_BYTES = 100;

/* Texts by cost: for one note with a count, without a count, and for many notes. */
static const struct {
    const char *counted, *plain, *many;
} words[] = {
    {"", "", "values"},
    {"", "", "faults of the node tree"},
    {"", ": left out, with all below it", "nodes are left out"},
    {"", ": ignored", "references of nodes are ignored"},
    {": its mesh is left out, %zu triangles", ": its mesh is left out", "nodes' instances are left out"},
    {": %zu triangles left out", ": left out", "primitives are left out"},
    {": %zu triangles left out", ": left out", "primitives have such triangles, which are left out"},
    {": %zu corners beyond the last triangle are ignored", ": ignored", "primitives end within a triangle"},
    {": %zu capsules of smoke left out", ": left out", "primitives of smoke are left out"},
    {": %zu capsules of smoke left out", ": left out", "primitives of smoke have such capsules, which are left out"},
    {": taken as opaque, %zu triangles", ": taken as opaque", "masks are taken as opaque"},
    {"", "", "materials have such members"},
    {", %zu triangles", "", "things that are hardly meant so"},
    {", %zu triangles", "", "materials let light through"},
    {"", "", "meshes or primitives with morph targets"},
    {", %zu vertices", "", "skins or primitives with one"},
    {"", "", "primitives with colours like that"},
    {"", ": ignored", "cameras are ignored"},
    {"", "", "extensions are used and not read"},
};
static_assert(sizeof words / sizeof *words == (size_t)cost::KINDS, "a line for each cost");

void take_note(loader &l, cost kind, uint64_t id, const std::string &where, const std::string &why, const std::string &remedy,
               size_t count)
{
    auto [known, is_new] = l.note_of.emplace(std::make_pair((int)kind, id), SIZE_MAX);
    if (!is_new) {
        (known->second < SIZE_MAX ? l.notes[known->second].count : l.notes_more_count[(int)kind]) += count;
        return;
    }
    size_t shown = 0;
    for (const note &n : l.notes) shown += n.kind == kind;
    if (shown >= (kind == cost::EXTENSION ? EXTENSIONS_SHOWN : SHOWN)) {
        l.notes_more[(int)kind]++;
        l.notes_more_count[(int)kind] += count;
        return;
    }
    known->second = l.notes.size();
    l.notes.push_back({kind, where, why, remedy, count});
}

std::string why_of(const failure &f, const std::string &where)
{
    size_t skipped = where.size();
    if (f.text.compare(0, skipped, where) != 0) return f.text;
    while (skipped < f.text.size() && strchr(":, ", f.text[skipped])) skipped++;
    return f.text.substr(skipped);
}

void take_fault(loader &l, cost kind, uint64_t id, const std::string &where, const failure &f, const std::string &remedy,
                size_t count, const std::string &besides)
{
    if (!l.first_fault) l.first_fault = f;
    take_note(l, kind, id, where + besides, why_of(f, where), remedy, count);
}

void say_notes(loader &l)
{
    for (const note &n : l.notes) {
        const auto &w = words[(int)n.kind];
        warn(l.m, "%s%s%s%s; %s", n.where.c_str(), n.why.empty() ? "" : ": ", n.why.c_str(),
             n.count ? formatted(w.counted, n.count).c_str() : w.plain, n.remedy.c_str());
    }
    for (int kind = 0; kind < (int)cost::KINDS; kind++) {
        if (!l.notes_more[kind]) continue;
        std::string together = l.notes_more_count[kind] ? ", " + std::to_string(l.notes_more_count[kind]) + " in all" : "";
        warn(l.m, "%zu more %s%s; see to those above, and run again", l.notes_more[kind], words[kind].many, together.c_str());
        l.notes_more[kind] = l.notes_more_count[kind] = 0;
    }
    l.notes.clear();
    l.note_of.clear();
}

/* A fault of an object that the scene does not use. If there is nothing to bake, it may be the reason. */
static const failure *idle_fault(const loader &l)
{
    for (const auto &of_list : l.faults)
        for (const auto &[index, fault] : of_list) return &fault;
    for (const auto &[index, fault] : l.mesh_faults) return &fault;
    for (const auto &[index, fault] : l.primitive_faults) return &fault;
    for (const elements &e : l.accessors)
        if (e.fault) return &e.fault;
    for (const buffer_view &v : l.views)
        if (v.fault) return &v.fault;
    for (const buffer &b : l.buffers)
        if (b.fault) return &b.fault;
    return nullptr;
}

void require_geometry(const loader &l, size_t triangles, size_t capsules)
{
    if (triangles || capsules) return;
    if (l.first_fault) throw l.first_fault;
    bool excludes = false; /* exclusions that the user requested are not a fault */
    for (const scene_exclusion &e : l.exclusions) excludes |= e.triangles > 0;
    if (const failure *f = excludes ? nullptr : idle_fault(l)) throw *f;
}

std::string exclude_remedy(const char *prefix, size_t index, const std::string &name)
{
    bool        plain   = !name.empty() && name.size() <= NAME_BYTES && name.find_first_of("*?[]\\#'\"$` ") == std::string::npos;
    std::string pattern = plain ? name : "#" + std::to_string(index);
    return std::string("--exclude ") + prefix + pattern + " bakes without it";
}

std::string shown_uri(const std::string &uri)
{
    char text[URI_BYTES + 1];
    if (uri.size() >= 5 && !strncasecmp(uri.c_str(), "data:", 5))
        return shorten(text, 40, uri.substr(0, uri.find(',')).c_str()) + std::string(",...");
    return shorten(text, URI_BYTES, uri.c_str());
}

std::string label(const char *kind, size_t index, const std::string &name)
{
    char        shown[NAME_BYTES + 1];
    std::string text = std::string(kind) + " " + std::to_string(index);
    return name.empty() ? text : text + " '" + shorten(shown, NAME_BYTES, name.c_str()) + "'";
}

/* Warnings of valid content that is probably a mistake: objects that cast shadow in a bake but are absent, duplicated or moving in
 * an engine. Each warning names the first node, the number of others, and their triangles. Names of collision shapes and of levels
 * of detail are checked elsewhere, when triangles are placed. */

/* Casting triangles of each node, as far as known before they are placed. */
using casting = std::vector<size_t>;

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

void warn_about_traps(loader &l, int chosen, size_t triangles)
{
    casting casts(l.nodes.size(), 0);
    for (size_t node : l.order) {
        int mesh = l.model.nodes[node].mesh;
        if (mesh < 0) continue;
        const auto &primitives = l.model.meshes[mesh].primitives;
        for (size_t i = 0; i < primitives.size(); i++)
            if (!primitive_fault(l, (size_t)mesh, i) && makes_triangles(primitives[i]) &&
                exclusion_of(l, node, primitives[i]) == CASTS)
                casts[node] += triangle_count(l, primitives[i]);
        casts[node] *= count_instances(l, node);
    }
    look_at_lods(l, casts);
    look_at_materials(l, casts);
    look_at_places(l, casts);
    look_at_animations(l, casts);
    look_at_scenes(l, chosen, triangles);
}

/* Extensions that a file uses or requires. An extension that is neither implemented nor known to be irrelevant to shadows may
 * change shapes, places, lights or visibility. A file that requires such an extension is refused; a file that uses it gets a
 * warning. */

/* clang-format off */
/* Implemented, as far as a bake needs them. */
static const char *const known_to_be_read[] = {
    "EXT_mesh_gpu_instancing", "EXT_meshopt_compression", "EXT_texture_webp", "KHR_draco_mesh_compression", "KHR_lights_punctual",
    "KHR_materials_diffuse_transmission", "KHR_materials_emissive_strength", "KHR_materials_pbrSpecularGlossiness", "KHR_materials_transmission",
    "KHR_materials_variants", "KHR_mesh_quantization", "KHR_meshopt_compression", "KHR_node_visibility", "KHR_texture_transform"};

/* Irrelevant to shadows: appearance of surfaces, storage of images, animation, sound, touch, metadata. */
static const char *const known_to_be_harmless[] = {
    "ADOBE_materials_clearcoat_specular", "ADOBE_materials_clearcoat_tint", "EXT_materials_clearcoat_color", "EXT_textureInfo_constant_lod",
    "KHR_materials_anisotropy", "KHR_materials_clearcoat", "KHR_materials_common", "KHR_materials_diffuse_roughness", "KHR_materials_dispersion",
    "KHR_materials_ior", "KHR_materials_iridescence", "KHR_materials_sheen", "KHR_materials_specular", "KHR_materials_unlit", "KHR_materials_volume",
    "KHR_materials_volume_scatter", "MOZ_lightmap", "MSFT_packing_normalRoughnessMetallic", "MSFT_packing_occlusionRoughnessMetallic", "NV_materials_mdl",
    "VRMC_materials_hdr_emissiveMultiplier", "VRMC_materials_mtoon",

    "EXT_texture_astc", "EXT_texture_avif", "KHR_texture_basisu", "MOZ_texture_rgbe", "MPEG_texture_video", "MSFT_texture_dds",

    "EXT_lights_ies", "EXT_lights_image_based", "KHR_animation_pointer", "KHR_interactivity", "KHR_node_hoverability", "KHR_node_selectability",
    "VRMC_node_constraint", "VRMC_springBone", "VRMC_springBone_extended_collider", "VRMC_vrm_animation",

    "KHR_audio", "KHR_audio_emitter", "KHR_collision_shapes", "KHR_implicit_shapes", "KHR_physics_rigid_bodies", "KHR_rigid_bodies",
    "MSFT_audio_emitter", "OMI_audio_emitter", "OMI_audio_ogg_vorbis", "OMI_collider", "OMI_link", "OMI_physics_body", "OMI_physics_gravity",
    "OMI_physics_joint", "OMI_physics_shape", "OMI_seat", "OMI_spawn_point",

    "AGI_articulations", "AGI_stk_metadata", "CESIUM_primitive_outline", "EXT_feature_metadata", "EXT_instance_features", "EXT_mesh_features",
    "EXT_mesh_manifold", "EXT_structural_metadata", "FB_geometry_metadata", "FB_ngon_encoding", "GODOT_single_root", "GRIFFEL_bim_data", "KHR_xmp",
    "KHR_xmp_json_ld", "VRM", "VRMC_vrm"};
/* clang-format on */

static bool is_known(const std::string &name)
{
    return std::find(std::begin(known_to_be_read), std::end(known_to_be_read), name) != std::end(known_to_be_read) ||
           std::find(std::begin(known_to_be_harmless), std::end(known_to_be_harmless), name) != std::end(known_to_be_harmless);
}

void check_extensions(loader &l, const json &root)
{
    char shown[NAME_BYTES + 1];
    for (const json &name : items(root, "extensionsRequired"))
        if (!is_known(name))
            l.refused("", "requires the extension %s, which is not read: export it without, or convert it",
                      shorten(shown, NAME_BYTES, name.get_ref<const std::string &>().c_str()));
    std::set<std::string> said;
    for (const json &name : items(root, "extensionsUsed")) {
        if (is_known(name) || !said.insert(name).second) continue;
        take_note(l, cost::EXTENSION, said.size(),
                  std::string("extension ") + shorten(shown, NAME_BYTES, name.get_ref<const std::string &>().c_str()),
                  "used, and not read: what it says of shapes, places, lights or transparency is not baked",
                  "export without it, if it moves a shadow");
    }
}

} // namespace gltf
