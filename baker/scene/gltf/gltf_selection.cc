/* Selection of casters: --include and --exclude patterns, a flag in extras, and skins (whose pose is unknown).
 *
 * Rules are numbered in the order in which they apply: objects that no --include matches, each --exclude, extras, skins.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <algorithm>
#include <cmath>
#include <fnmatch.h>
#include <utility>

#include "baker/base/portable_math.h"
#include "baker/scene/gltf/gltf_loader.h"

namespace gltf
{

static const char *const FLAG = "vxs_cast_shadow";

static const struct {
    const char *name, *list, *prefix;
} kinds[KINDS] = {{"node", "nodes", "node:"}, {"mesh", "meshes", "mesh:"}, {"material", "materials", "material:"}};

/* --- extras ----------------------------------------------------------------------------------------------------------- */

/* Read the flag. Blender also writes booleans as 0 and 1. */
void read_flags(loader &l, const json &root)
{
    size_t      wrong = 0;
    std::string first;
    for (int k = 0; k < KINDS; k++) {
        const json &list = items(root, kinds[k].list);
        l.marks[k].resize(list.size());
        for (size_t i = 0; i < list.size(); i++) {
            const json &extras = items(list[i], "extras");
            auto        flag   = extras.find(FLAG);
            if (flag == extras.end()) continue;
            l.marks[k][i].flagged = *flag == false || *flag == 0;
            if (l.marks[k][i].flagged || *flag == true || *flag == 1) continue;
            if (!wrong++) first = label(kinds[k].name, i, list[i].value("name", ""));
        }
    }
    if (wrong)
        warn(l.m, "%s: %s in its extras is neither true nor false: ignored%s", first.c_str(), FLAG,
             wrong > 1 ? (", as in " + std::to_string(wrong - 1) + " more").c_str() : "");
}

/* --- patterns --------------------------------------------------------------------------------------------------------- */

struct pattern {
    const char *option, *text;
    std::string glob;
    bool        of[KINDS];
    bool        used;
};

static pattern read_pattern(const char *option, const char *text)
{
    pattern p = {option, text, text, {true, true, true}, false};
    for (int k = 0; k < KINDS; k++) {
        size_t length = strlen(kinds[k].prefix);
        if (strncmp(text, kinds[k].prefix, length) != 0) continue;
        for (int other = 0; other < KINDS; other++) p.of[other] = other == k;
        p.glob = text + length;
    }
    return p;
}

/* All objects with names, in the file's order. */
struct nameable {
    kind               k;
    size_t             index;
    const std::string *name;
};

static std::vector<nameable> collect(const loader &l)
{
    std::vector<nameable> found;
    std::vector<char>     meshes(l.model.meshes.size(), 0), materials(l.materials.size(), 0);
    for (size_t node : l.order) {
        found.push_back({NODE, node, &l.model.nodes[node].name});
        int mesh = l.model.nodes[node].mesh;
        if (mesh < 0 || std::exchange(meshes[mesh], 1)) continue;
        found.push_back({MESH, (size_t)mesh, &l.model.meshes[mesh].name});
        for (const tinygltf::Primitive &p : l.model.meshes[mesh].primitives)
            if (p.material >= 0 && !std::exchange(materials[p.material], 1))
                found.push_back({MATERIAL, (size_t)p.material, &l.materials[p.material].name});
    }
    return found;
}

/* A few existing names for a message: those similar to the pattern (except for case or an affix), else the first ones. */
static std::string list_names(const pattern &p, const std::vector<nameable> &all, bool near)
{
    std::vector<std::string> listed;
    std::string              text, wanted = "*" + p.glob + "*";
    for (size_t i = 0; i < all.size() && listed.size() < 6; i++) {
        std::string shown = kinds[all[i].k].prefix + all[i].name->substr(0, 60);
        if (!p.of[all[i].k] || all[i].name->empty() || std::find(listed.begin(), listed.end(), shown) != listed.end()) continue;
        if (near && fnmatch(wanted.c_str(), all[i].name->c_str(), FNM_CASEFOLD) != 0) continue;
        text += (listed.empty() ? "" : ", ") + shown;
        listed.push_back(shown);
    }
    return text;
}

/* Apply the patterns to one object. The first `excludes` patterns exclude. */
static void mark_by_patterns(std::vector<pattern> &patterns, size_t excludes, const nameable &n, mark &said)
{
    for (size_t i = patterns.size(); i-- > 0;) {
        const std::string &glob = patterns[i].glob;
        if (!patterns[i].of[n.k] || glob.empty()) continue;
        if (*n.name != glob && glob != "#" + std::to_string(n.index) && fnmatch(glob.c_str(), n.name->c_str(), 0) != 0) continue;
        patterns[i].used = true;
        if (i < excludes)
            said.excluded = i;
        else
            said.included = true;
    }
    if (said.included) said.flagged = false;
}

void select_casters(loader &l, const std::vector<int> &parent)
{
    const text_list     &exclude = l.choice->exclude, &include = l.choice->include;
    std::vector<pattern> patterns;
    for (size_t i = 0; i < exclude.count; i++) patterns.push_back(read_pattern("--exclude", exclude.items[i]));
    for (size_t i = 0; i < include.count; i++) patterns.push_back(read_pattern("--include", include.items[i]));

    std::vector<nameable> all = collect(l);
    for (const nameable &n : all) {
        mark &said = l.marks[n.k][n.index];
        mark_by_patterns(patterns, exclude.count, n, said);
        if (n.k != NODE || parent[n.index] < 0) continue;
        const mark &above = l.marks[NODE][parent[n.index]]; /* parents come first */
        said.flagged      = said.flagged || (above.flagged && !said.included);
        said.included     = said.included || above.included;
        said.excluded     = std::min(said.excluded, above.excluded);
    }
    for (const pattern &p : patterns) {
        if (p.used) continue;
        std::string near = list_names(p, all, true), some = list_names(p, all, false);
        l.error(VXS_E_ARGUMENT, "%s %s names nothing in the scene; %s%s", p.option, p.text,
                !near.empty()   ? "near it are "
                : !some.empty() ? "there are "
                                : "nothing there has a name, #0 is the first of each kind",
                (near.empty() ? some : near).c_str());
    }

    l.exclusions.push_back({EXCLUDED_BY_INCLUDE, nullptr, 0, 0});
    for (size_t i = 0; i < exclude.count; i++) l.exclusions.push_back({EXCLUDED_BY_EXCLUDE, exclude.items[i], 0, 0});
    for (exclusion_rule rule : {EXCLUDED_BY_EXTRAS, EXCLUDED_AS_SKINNED, EXCLUDED_AS_HIDDEN, EXCLUDED_AS_BLEND})
        l.exclusions.push_back({rule, nullptr, 0, 0});
}

size_t exclusion_of(const loader &l, size_t node, const tinygltf::Primitive &p)
{
    static const mark     nothing;
    const tinygltf::Node &n = l.model.nodes[node];
    const mark           &a = l.marks[NODE][node], &b = l.marks[MESH][n.mesh];
    const mark           &c        = p.material >= 0 ? l.marks[MATERIAL][p.material] : nothing;
    size_t                excluded = std::min({a.excluded, b.excluded, c.excluded}), excludes = l.choice->exclude.count;
    if (l.nodes[node].hidden) return 3 + excludes;
    if (l.choice->include.count && !a.included && !b.included && !c.included) return 0;
    if (excluded < excludes) return 1 + excluded;
    if (a.flagged || b.flagged || c.flagged) return 1 + excludes;
    if (n.skin >= 0 && l.choice->skinned == SKINNED_EXCLUDE) return 2 + excludes;
    return CASTS;
}

void warn_about_skinned(loader &l)
{
    size_t triangles = l.exclusions[2 + l.choice->exclude.count].triangles;
    if (l.skinned_excluded && !l.choice->skinned_given)
        warn(l.m,
             "skinned meshes cast no shadow, for they move: %zu with %zu triangles are left out; --skinned rest takes "
             "them in the pose that the file has, --skinned exclude says that this is meant",
             l.skinned_excluded, triangles);
}

void finish_exclusions(loader &l)
{
    std::vector<scene_exclusion> kept;
    size_t                       hidden = 0;
    for (size_t node : l.order) hidden += l.nodes[node].hidden;
    for (scene_exclusion e : l.exclusions) {
        if (e.rule == EXCLUDED_AS_HIDDEN) e.nodes = hidden;
        if (e.triangles || e.nodes || e.rule == EXCLUDED_BY_EXCLUDE) kept.push_back(e);
    }
    l.s->exclusions      = copied(kept);
    l.s->exclusion_count = kept.size();
}

/* Views of cameras (3.10), for pictures. Invalid numbers make a camera without a view; a picture that needs it reports this, and a
 * bake never fails. */

/* A positive number, or 0 if it is missing or invalid. */
static double above_zero(const json &object, const char *name)
{
    return number_or(object, name, 0, INFINITY);
}

static void read_projection(const json &camera, scene_view &view)
{
    std::string kind        = text_of(camera, "type");
    const json &perspective = items(camera, "perspective"), &orthographic = items(camera, "orthographic");
    if (kind == "perspective" && perspective.is_object()) {
        double angle     = above_zero(perspective, "yfov");
        view.half_high   = angle < M_PI ? portable_tan(angle / 2) : 0;
        view.aspect      = above_zero(perspective, "aspectRatio");
        view.near_metres = above_zero(perspective, "znear");
        view.kind        = view.half_high > 0 ? VIEW_PERSPECTIVE : VIEW_NONE;
    } else if (kind == "orthographic" && orthographic.is_object()) {
        double wide      = above_zero(orthographic, "xmag");
        view.half_high   = above_zero(orthographic, "ymag");
        view.aspect      = view.half_high > 0 ? wide / view.half_high : 0;
        view.near_metres = above_zero(orthographic, "znear");
        view.kind        = wide > 0 && view.half_high > 0 ? VIEW_ORTHOGRAPHIC : VIEW_NONE;
    }
}

bool unit(vec3 v, double out[3])
{
    /* not std::hypot: it differs between C++ libraries, and files have this direction in them */
    double most = std::max({std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)});
    double length =
        most > 0 ? most * std::sqrt((v.x / most) * (v.x / most) + (v.y / most) * (v.y / most) + (v.z / most) * (v.z / most)) : 0;
    double values[3] = {v.x / length, v.y / length, v.z / length};
    if (!(length > 0) || !std::isfinite(length)) return false;
    std::copy(values, values + 3, out);
    return true;
}

/* A camera looks along -Z of its node. Up is +Y, made orthogonal again, because a scale may have changed the angle. */
static bool read_pose(const transform &t, scene_view &view)
{
    vec3 forward = {-t.axis[2].x, -t.axis[2].y, -t.axis[2].z}, up = t.axis[1];
    if (!finite(t.origin) || !unit(forward, view.forward_ws)) return false;
    double along  = up.x * view.forward_ws[0] + up.y * view.forward_ws[1] + up.z * view.forward_ws[2],
           eye[3] = {t.origin.x, t.origin.y, t.origin.z};
    up            = {up.x - along * view.forward_ws[0], up.y - along * view.forward_ws[1], up.z - along * view.forward_ws[2]};
    std::copy(eye, eye + 3, view.eye_ws);
    return unit(up, view.up_ws);
}

void place_views(loader &l)
{
    const json         &cameras = items(l.rest, "cameras");
    std::vector<size_t> nodes;
    for (size_t node : l.order)
        if (l.model.nodes[node].camera >= 0 && (size_t)l.model.nodes[node].camera < cameras.size()) nodes.push_back(node);
    if (nodes.empty()) return;
    l.s->views = zeroed<scene_view>(nodes.size());
    for (size_t node : nodes) {
        const json &camera = cameras[(size_t)l.model.nodes[node].camera];
        scene_view  view   = {};
        std::string name   = l.model.nodes[node].name;
        if (name.empty()) name = text_of(camera, "name");
        if (name.empty()) name = "camera" + std::to_string(l.model.nodes[node].camera);
        read_projection(camera, view);
        if (!read_pose(l.ws_from_node[node], view)) view.kind = VIEW_NONE;
        view.name                     = duplicate(name);
        l.s->views[l.s->view_count++] = view;
    }
}

/* Origin of triangles: node, mesh and material, stored in the scene for messages. */

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

void begin_part(loader &l, size_t node, const tinygltf::Primitive &p, vec3 origin)
{
    scene_origin from = {(uint32_t)l.s->triangle_count, {origin.x, origin.y, origin.z}};
    if (l.origins.empty() || memcmp(l.origins.back().at_ws, from.at_ws, sizeof from.at_ws) != 0) l.origins.push_back(from);
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
