/* glTF 2.0 to a scene, through tinygltf: the order of things; gltf_loader.h has the parts.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/gltf/gltf_loader.h"

#include <cstdarg>
#include <stdexcept>

namespace gltf
{

vxs_result loader::error(vxs_result code, const char *format, ...)
{
    char    text[900];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    return fail(m, code, "'%s': %s", path, text);
}

std::string label(const char *kind, size_t index, const std::string &name)
{
    std::string text = std::string(kind) + " " + std::to_string(index);
    return name.empty() ? text : text + " '" + name + "'";
}

std::string one_line(std::string text)
{
    if (text.rfind("[json.", 0) == 0 && text.find("] ") != std::string::npos) text.erase(0, text.find("] ") + 2);
    while (!text.empty() && isspace((unsigned char)text.back())) text.pop_back();
    for (char &c : text)
        if (c == '\n') c = ' ';
    if (text.size() > 300) text = text.substr(0, 300) + "...";
    return text.empty() ? "cannot be parsed" : text;
}

static vxs_result load(loader &l, const char *which)
{
    std::vector<int> parent;
    int              chosen;
    vxs_result       r;
    if ((r = parse(l)) != VXS_OK) return r;
    if ((r = check_accessors(l)) != VXS_OK) return r;
    if ((r = check_model_meshes(l)) != VXS_OK) return r;
    if ((r = check_references(l)) != VXS_OK) return r;
    if ((r = check_tree(l, parent)) != VXS_OK) return r;
    if ((r = check_buffers(l)) != VXS_OK) return r;
    if ((r = check_all_indices(l)) != VXS_OK) return r;
    if ((r = choose_scene(l, which, chosen)) != VXS_OK) return r;
    if ((r = choose_roots(l, chosen, parent)) != VXS_OK) return r;
    if ((r = place_nodes(l, parent)) != VXS_OK) return r;
    if ((r = place_meshes(l)) != VXS_OK) return r;
    if ((r = place_lights(l)) != VXS_OK) return r;
    if ((r = place_cameras(l)) != VXS_OK) return r;
    l.s->name = strdup(chosen < 0 ? "" : l.model.scenes[(size_t)chosen].name.c_str());
    return l.s->name ? VXS_OK : l.error(VXS_E_MEMORY, "out of memory");
}

} // namespace gltf

/* No exception leaves the loader. */
template <typename function> static vxs_result guarded(scene *s, const char *path, message *m, function &&work)
{
    vxs_result r;
    memset(s, 0, sizeof *s);
    try {
        gltf::loader l = {};
        l.m            = m;
        l.path         = path;
        l.s            = s;
        r              = work(l);
    } catch (const std::bad_alloc &) {
        r = fail(m, VXS_E_MEMORY, "'%s': out of memory", path);
    } catch (const std::length_error &) {
        r = fail(m, VXS_E_MEMORY, "'%s': out of memory", path);
    } catch (const std::exception &e) {
        r = fail(m, VXS_E_SCENE, "'%s': %s", path, gltf::one_line(e.what()).c_str());
    } catch (...) {
        r = fail(m, VXS_E_SCENE, "'%s': cannot be parsed", path);
    }
    if (r != VXS_OK) scene_free(s);
    return r;
}

extern "C" vxs_result scene_load_gltf(scene *s, const char *path, const char *which, message *m)
{
    return guarded(s, path, m, [which](gltf::loader &l) {
        l.files_beside = true;
        vxs_result r   = gltf::read_scene_file(l, l.bytes);
        return r == VXS_OK ? gltf::load(l, which) : r;
    });
}

extern "C" vxs_result scene_load_gltf_memory(scene *s, const void *bytes, size_t size_bytes, const char *name, message *m)
{
    return guarded(s, name, m, [bytes, size_bytes](gltf::loader &l) {
        if (size_bytes >= gltf::FILE_BYTES_MAX) return l.error(VXS_E_UNSUPPORTED, "is 4 GiB or larger");
        l.bytes.assign((const unsigned char *)bytes, (const unsigned char *)bytes + size_bytes);
        return gltf::load(l, nullptr);
    });
}
