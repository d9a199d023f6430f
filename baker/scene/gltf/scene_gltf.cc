/* Load glTF 2.0 into a scene with tinygltf: the sequence of steps; see gltf_loader.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/scene/gltf/gltf_loader.h"

#include <cstdarg>
#include <stdexcept>

#include "baker/base/memory.h"
#include "baker/files/input_file.h"

namespace gltf
{

[[noreturn]] static void give_up(vxs_result code, bool whole, const std::string &where, const char *format, va_list args)
{
    char text[900];
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    throw failure{code, where.empty() ? text : where + ": " + text, whole};
}

void loader::error(vxs_result code, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    give_up(code, false, "", format, args);
}

void loader::broken(const std::string &where, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    give_up(VXS_E_SCENE, false, where, format, args);
}

void loader::unsupported(const std::string &where, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    give_up(VXS_E_UNSUPPORTED, false, where, format, args);
}

void loader::refused(const std::string &where, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    give_up(VXS_E_UNSUPPORTED, true, where, format, args);
}

void loader::need(uint64_t size_bytes, const std::string &what)
{
    vxs_result r = memory_check(size_bytes, m, "'%s': %s: this needs", path, what.c_str());
    if (r != VXS_OK) throw failure{r, "", true};
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

static void require_no_error(const loader &l, vxs_result r)
{
    if (r == VXS_OK) r = run_check(l.m);
    if (r != VXS_OK) throw failure{r, "", true};
}

static void load(loader &l, const scene_check *check)
{
    parse(l);
    check_accessors(l);
    check_model_meshes(l);
    std::vector<int> parent = check_tree(l);
    l.file_parent           = parent;
    int chosen              = choose_scene(l, l.choice->name);
    choose_roots(l, chosen, parent);
    place_nodes(l, parent);
    check_references(l);
    select_casters(l, parent);
    place_lights(l);
    place_cameras(l);
    place_views(l);
    place_materials(l);
    l.s->name        = duplicate(chosen < 0 ? "" : l.model.scenes[chosen].name);
    size_t triangles = measure(l);
    warn_about_traps(l, chosen, triangles);

    /* checks before triangles are placed, which may be many more than in the file */
    require_geometry(l, triangles, count_capsules(l));
    say_notes(l);
    require_no_error(l, VXS_OK);
    require_no_error(l, check ? check->check(check->user, l.s, l.m) : VXS_OK);

    place_smoke(l);
    place_meshes(l, triangles);
    require_geometry(l, l.s->triangle_count, l.s->smoke.count);
    say_notes(l);
    require_no_error(l, VXS_OK);
}

} // namespace gltf

/* Converts exceptions to results: none leaves the loader. */
template <typename function>
static vxs_result guarded(scene *s, const char *path, const scene_choice *choice, run_context *m, function &&work)
{
    static const scene_choice all = {};
    vxs_result                r   = VXS_OK;
    memset(s, 0, sizeof *s);
    try {
        gltf::loader l = {};
        l.m            = m;
        l.path         = path;
        l.choice       = choice ? choice : &all;
        l.s            = s;
        work(l);
    } catch (const gltf::failure &f) {
        r = f.text.empty() ? f.code : fail(m, f.code, "'%s': %s", path, f.text.c_str());
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

extern "C" vxs_result scene_load_gltf(scene *s, const char *path, const scene_choice *choice, run_context *m)
{
    return scene_load_gltf_checked(s, path, choice, nullptr, m);
}

extern "C" vxs_result scene_load_gltf_checked(scene *s, const char *path, const scene_choice *choice, const scene_check *check,
                                              run_context *m)
{
    return guarded(s, input_name(path), choice, m, [path, check](gltf::loader &l) {
        l.files_beside = true;
        gltf::read_scene_file(l, path);
        gltf::load(l, check);
    });
}

extern "C" vxs_result scene_check_files_gltf(const char *path, run_context *m)
{
    scene unread;
    return guarded(&unread, input_name(path), nullptr, m, [path](gltf::loader &l) {
        l.files_beside = true;
        gltf::read_scene_file(l, path);
        gltf::check_files_beside(l, gltf::parse_json(l, gltf::open_container(l)));
    });
}

extern "C" vxs_result scene_visit_files_gltf(const char *path, int allow_outside, scene_file_fn *visit, void *user, run_context *m)
{
    scene        unread;
    scene_choice choice  = {};
    choice.allow_outside = allow_outside;
    return guarded(&unread, input_name(path), &choice, m, [=](gltf::loader &l) {
        l.files_beside = true;
        gltf::read_scene_file(l, path);
        gltf::visit_files(l, gltf::parse_json(l, gltf::open_container(l)), visit, user);
    });
}

extern "C" vxs_result scene_load_gltf_memory(scene *s, const void *bytes, size_t size_bytes, const char *name, run_context *m)
{
    return guarded(s, name, nullptr, m, [bytes, size_bytes](gltf::loader &l) {
        if (size_bytes >= gltf::FILE_BYTES_MAX) l.refused("", "is 4 GiB or larger, and a glTF file is less");
        l.file.assign((const unsigned char *)bytes, (const unsigned char *)bytes + size_bytes);
        gltf::load(l, nullptr);
    });
}
