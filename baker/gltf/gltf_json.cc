/* Shape of the JSON: all that is read here has the type that the specification gives it.
 *
 * tinygltf reads leniently: a property of the wrong type counts as absent, and a primitive that it cannot parse is dropped. A baker
 * must not bake something else than what the file says, so the tables below list all that is read, and it is checked first.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/gltf/gltf_loader.h"

#include <climits>
#include <nlohmann/json.hpp>
#include <set>

namespace gltf
{

/* clang-format off */
static const std::vector<property> root_shape = {
    {"asset", is::object, true}, {"extensionsUsed", is::texts}, {"extensionsRequired", is::texts}, {"scene", is::index},
    {"scenes", is::objects}, {"nodes", is::objects}, {"meshes", is::objects}, {"materials", is::objects},
    {"accessors", is::objects}, {"bufferViews", is::objects}, {"buffers", is::objects}, {"skins", is::objects},
    {"cameras", is::objects}, {"extensions", is::extensions}};
static const std::vector<property> scene_shape = {
    {"name", is::text}, {"nodes", is::indices}};
static const std::vector<property> node_shape = {
    {"name", is::text}, {"children", is::indices}, {"mesh", is::index}, {"skin", is::index}, {"camera", is::index},
    {"matrix", is::numbers, false, 16}, {"translation", is::numbers, false, 3}, {"rotation", is::numbers, false, 4},
    {"scale", is::numbers, false, 3}, {"weights", is::numbers}, {"extensions", is::extensions}};
static const std::vector<property> mesh_shape = {
    {"name", is::text}, {"primitives", is::objects, true}, {"weights", is::numbers}};
static const std::vector<property> primitive_shape = {
    {"attributes", is::index_map, true}, {"indices", is::index}, {"material", is::index}, {"mode", is::index},
    {"targets", is::objects}, {"extensions", is::extensions}};
static const std::vector<property> material_shape = {
    {"name", is::text}, {"alphaMode", is::text}, {"doubleSided", is::flag}};
static const std::vector<property> accessor_shape = {
    {"bufferView", is::index}, {"byteOffset", is::size}, {"componentType", is::index, true}, {"count", is::size, true},
    {"type", is::text, true}, {"normalized", is::flag}, {"sparse", is::object}};
static const std::vector<property> sparse_shape = {
    {"count", is::index, true}, {"indices", is::object, true}, {"values", is::object, true}};
static const std::vector<property> sparse_indices_shape = {
    {"bufferView", is::index, true}, {"byteOffset", is::index}, {"componentType", is::index, true}};
static const std::vector<property> sparse_values_shape = {
    {"bufferView", is::index, true}, {"byteOffset", is::index}};
static const std::vector<property> buffer_view_shape = {
    {"buffer", is::index, true}, {"byteOffset", is::size}, {"byteLength", is::size, true}, {"byteStride", is::size},
    {"extensions", is::extensions}};
static const std::vector<property> buffer_shape = {
    {"byteLength", is::size, true}, {"uri", is::text}, {"extensions", is::extensions}};
static const std::vector<property> skin_shape = {
    {"name", is::text}, {"joints", is::indices, true}};
static const std::vector<property> draco_shape = {
    {"bufferView", is::index, true}, {"attributes", is::index_map, true}};
static const std::vector<property> instancing_shape = {
    {"attributes", is::index_map, true}};
static const std::vector<property> light_use_shape = {
    {"light", is::index, true}};
/* clang-format on */

bool is_index(const json &value)
{
    return value.is_number_unsigned() && value.get<uint64_t>() <= INT_MAX;
}

/* NULL when the value has the shape, else what was expected. */
static const char *expected_instead(const json &value, const property &p)
{
    auto all = [&value](auto &&holds) {
        for (const json &item : value)
            if (!holds(item)) return false;
        return true;
    };
    switch (p.kind) {
    case is::index: return is_index(value) ? nullptr : "an integer from 0 to 2147483647";
    case is::size: return value.is_number_unsigned() && value.get<uint64_t>() < (1ull << 53) ? nullptr : "an integer, 0 or more";
    case is::text: return value.is_string() ? nullptr : "a string";
    case is::flag: return value.is_boolean() ? nullptr : "true or false";
    case is::numbers:
        if (!value.is_array() || !all([](const json &v) { return v.is_number(); })) return "an array of numbers";
        return !p.count || value.size() == p.count ? nullptr
               : p.count == 16                     ? "16 numbers"
               : p.count == 4                      ? "4 numbers"
               : p.count == 2                      ? "2 numbers"
                                                   : "3 numbers";
    case is::indices: return value.is_array() && all(is_index) ? nullptr : "an array of indices";
    case is::texts: return value.is_array() && all([](const json &v) { return v.is_string(); }) ? nullptr : "an array of strings";
    case is::object: return value.is_object() ? nullptr : "an object";
    case is::objects: return value.is_array() && all([](const json &v) { return v.is_object(); }) ? nullptr : "an array of objects";
    case is::extensions:
        return value.is_object() && all([](const json &v) { return v.is_object(); }) ? nullptr : "an object of objects";
    case is::index_map: return value.is_object() && all(is_index) ? nullptr : "an object of indices";
    }
    return nullptr;
}

vxs_result check_shape(loader &l, const std::string &where, const json &object, const std::vector<property> &shape)
{
    for (const property &p : shape) {
        auto found = object.find(p.name);
        if (found == object.end()) {
            if (p.required) return l.error(VXS_E_SCENE, "%s: '%s' is missing", where.c_str(), p.name);
        } else if (const char *expected = expected_instead(*found, p)) {
            return l.error(VXS_E_SCENE, "%s: '%s' is not %s", where.c_str(), p.name, expected);
        }
    }
    return VXS_OK;
}

static const json no_items = json::array();

const json &items(const json &object, const char *name)
{
    auto found = object.find(name);
    return found == object.end() ? no_items : *found;
}

/* The members of extensions.NAME, or NULL. */
const json *extension(const json &object, const char *name)
{
    auto extensions = object.find("extensions");
    if (extensions == object.end()) return nullptr;
    auto found = extensions->find(name);
    return found == extensions->end() ? nullptr : &*found;
}

vxs_result check_list(loader &l, const json &root, const char *list, const char *item_name, const std::vector<property> &shape)
{
    vxs_result r;
    size_t     index = 0;
    for (const json &item : items(root, list))
        if ((r = check_shape(l, label(item_name, index++, ""), item, shape)) != VXS_OK) return r;
    return VXS_OK;
}

static vxs_result check_version(loader &l, const json &root)
{
    auto asset = root.find("asset");
    if (asset == root.end() || !asset->is_object()) return l.error(VXS_E_SCENE, "not glTF 2.0: 'asset' is missing");
    for (const char *name : {"minVersion", "version"}) {
        auto     found = asset->find(name);
        unsigned major, minor;
        if (found == asset->end() && !strcmp(name, "minVersion")) continue;
        if (found == asset->end() || !found->is_string() ||
            sscanf(found->get_ref<const std::string &>().c_str(), "%u.%u", &major, &minor) != 2)
            return l.error(VXS_E_SCENE, "asset.%s: expected a text like \"2.0\"", name);
        if (major != 2 || (minor != 0 && !strcmp(name, "minVersion")))
            return l.error(VXS_E_UNSUPPORTED, "asset.%s is %u.%u, expected 2.0", name, major, minor);
    }
    return VXS_OK;
}

/* Extensions that are read, and those that may be required because they change no shadow: how surfaces and images look. */
static bool extension_known(const std::string &name)
{
    static const std::set<std::string> known = {"EXT_mesh_gpu_instancing",
                                                "EXT_meshopt_compression",
                                                "KHR_draco_mesh_compression",
                                                "KHR_lights_punctual",
                                                "KHR_mesh_quantization",
                                                "KHR_meshopt_compression",
                                                "KHR_texture_transform",
                                                "EXT_texture_webp",
                                                "KHR_materials_pbrSpecularGlossiness",
                                                "KHR_materials_variants",

                                                "EXT_texture_avif",
                                                "KHR_texture_basisu",
                                                "MSFT_texture_dds",
                                                "KHR_animation_pointer",
                                                "KHR_xmp",
                                                "KHR_xmp_json_ld",
                                                "KHR_materials_anisotropy",
                                                "KHR_materials_clearcoat",
                                                "KHR_materials_common",
                                                "KHR_materials_diffuse_transmission",
                                                "KHR_materials_dispersion",
                                                "KHR_materials_emissive_strength",
                                                "KHR_materials_ior",
                                                "KHR_materials_iridescence",
                                                "KHR_materials_sheen",
                                                "KHR_materials_specular",
                                                "KHR_materials_transmission",
                                                "KHR_materials_unlit",
                                                "KHR_materials_volume"};
    return known.count(name) != 0;
}

static vxs_result check_required_extensions(loader &l, const json &root)
{
    for (const json &name : items(root, "extensionsRequired"))
        if (!extension_known(name.get_ref<const std::string &>()))
            return l.error(VXS_E_UNSUPPORTED, "requires the extension %s", name.get_ref<const std::string &>().c_str());
    return VXS_OK;
}

static vxs_result check_meshes(loader &l, const json &root)
{
    vxs_result r;
    size_t     mesh_index = 0;
    for (const json &mesh : items(root, "meshes")) {
        size_t index = 0;
        for (const json &primitive : mesh["primitives"]) {
            std::string where = label("mesh", mesh_index, "") + " " + label("primitive", index++, "");
            if ((r = check_shape(l, where, primitive, primitive_shape)) != VXS_OK) return r;
            if (const json *draco = extension(primitive, "KHR_draco_mesh_compression"))
                if ((r = check_shape(l, where + " KHR_draco_mesh_compression", *draco, draco_shape)) != VXS_OK) return r;
            for (const json &target : items(primitive, "targets"))
                for (const json &accessor : target)
                    if (!is_index(accessor))
                        return l.error(VXS_E_SCENE, "%s: a morph target's attribute is not an index", where.c_str());
        }
        mesh_index++;
    }
    return VXS_OK;
}

static vxs_result check_accessor_members(loader &l, const json &root)
{
    vxs_result r;
    size_t     index = 0;
    for (const json &accessor : items(root, "accessors")) {
        std::string where  = label("accessor", index++, "") + " sparse";
        auto        sparse = accessor.find("sparse");
        if (accessor.contains("byteOffset") && !accessor.contains("bufferView"))
            return l.error(VXS_E_SCENE, "accessor %zu: a byteOffset without a bufferView", index - 1);
        if (sparse == accessor.end()) continue;
        if ((r = check_shape(l, where, *sparse, sparse_shape)) != VXS_OK) return r;
        if ((r = check_shape(l, where + " indices", (*sparse)["indices"], sparse_indices_shape)) != VXS_OK) return r;
        if ((r = check_shape(l, where + " values", (*sparse)["values"], sparse_values_shape)) != VXS_OK) return r;
    }
    return VXS_OK;
}

static vxs_result check_nodes(loader &l, const json &root)
{
    vxs_result r;
    size_t     index = 0;
    for (const json &node : items(root, "nodes")) {
        std::string where = label("node", index++, "");
        if (node.contains("matrix") && (node.contains("translation") || node.contains("rotation") || node.contains("scale")))
            return l.error(VXS_E_SCENE, "%s has both a matrix and translation, rotation or scale", where.c_str());
        if (const json *use = extension(node, "KHR_lights_punctual"))
            if ((r = check_shape(l, where + " KHR_lights_punctual", *use, light_use_shape)) != VXS_OK) return r;
        if (const json *instances = extension(node, "EXT_mesh_gpu_instancing"))
            if ((r = check_shape(l, where + " EXT_mesh_gpu_instancing", *instances, instancing_shape)) != VXS_OK) return r;
    }
    return VXS_OK;
}

/* How deep brackets nest, at most. nlohmann could tell while it parses, but in quadratic time. */
static long nesting(const container &c)
{
    long depth = 0, deepest = 0;
    bool quoted = false;
    for (size_t i = 0; i < c.text_size; i++) {
        char at = c.text[i];
        if (quoted && at == '\\')
            i++;
        else if (at == '"')
            quoted = !quoted;
        else if (!quoted && (at == '[' || at == '{'))
            deepest = std::max(deepest, ++depth);
        else if (!quoted && (at == ']' || at == '}'))
            depth--;
    }
    return deepest;
}

vxs_result parse_json(loader &l, const container &c, json &root)
{
    if (nesting(c) > JSON_DEPTH_MAX) return l.error(VXS_E_SCENE, "its JSON is nested too deeply");
    root = json::parse(c.text, c.text + c.text_size);
    return VXS_OK;
}

vxs_result check_json(loader &l, const json &root)
{
    vxs_result r;
    if (!root.is_object()) return l.error(VXS_E_SCENE, "its JSON is not an object");
    if ((r = check_version(l, root)) != VXS_OK) return r;
    if ((r = check_shape(l, "glTF", root, root_shape)) != VXS_OK) return r;
    if ((r = check_required_extensions(l, root)) != VXS_OK) return r;
    if ((r = check_list(l, root, "scenes", "scene", scene_shape)) != VXS_OK) return r;
    if ((r = check_list(l, root, "nodes", "node", node_shape)) != VXS_OK) return r;
    if ((r = check_list(l, root, "meshes", "mesh", mesh_shape)) != VXS_OK) return r;
    if ((r = check_list(l, root, "materials", "material", material_shape)) != VXS_OK) return r;
    if ((r = check_list(l, root, "accessors", "accessor", accessor_shape)) != VXS_OK) return r;
    if ((r = check_list(l, root, "bufferViews", "bufferView", buffer_view_shape)) != VXS_OK) return r;
    if ((r = check_list(l, root, "buffers", "buffer", buffer_shape)) != VXS_OK) return r;
    if ((r = check_list(l, root, "skins", "skin", skin_shape)) != VXS_OK) return r;
    if ((r = check_nodes(l, root)) != VXS_OK) return r;
    if ((r = check_accessor_members(l, root)) != VXS_OK) return r;
    return check_meshes(l, root);
}

} // namespace gltf
