/* Notes: faults of parts of a scene, collected while it is read and reported in a few lines: the first ones of each kind, then the
 * number of others. So the report stays short for a file with thousands of faults.
 * SPDX-License-Identifier: GPL-3.0-or-later */
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

static std::string counted(const char *format, size_t count)
{
    char text[160];
    snprintf(text, sizeof text, format, count);
    return text;
}

void say_notes(loader &l)
{
    for (const note &n : l.notes) {
        const auto &w = words[(int)n.kind];
        warn(l.m, "%s%s%s%s; %s", n.where.c_str(), n.why.empty() ? "" : ": ", n.why.c_str(),
             n.count ? counted(w.counted, n.count).c_str() : w.plain, n.remedy.c_str());
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

} // namespace gltf
