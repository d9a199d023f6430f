/* Shape of the JSON: all that is read here has the type that the specification gives it.
 *
 * tinygltf reads leniently: a property of the wrong type counts as absent, and a primitive that it cannot parse is dropped. A baker
 * must not bake something else than the file holds, so the tables below list all that is read, and it is checked first.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/gltf/gltf_loader.h"

#include <algorithm>
#include <climits>
#include <set>

namespace gltf
{

/* clang-format off */
static constexpr shape root_shape = {
    {"asset", is::object, true}, {"extensionsUsed", is::texts}, {"extensionsRequired", is::texts}, {"scene", is::index},
    {"scenes", is::objects}, {"nodes", is::objects}, {"meshes", is::objects}, {"materials", is::objects},
    {"accessors", is::objects}, {"bufferViews", is::objects}, {"buffers", is::objects}, {"skins", is::objects},
    {"cameras", is::objects}, {"extensions", is::extensions}};
static constexpr shape scene_shape = {
    {"name", is::text}, {"nodes", is::indices}};
static constexpr shape node_shape = {
    {"name", is::text}, {"children", is::indices}, {"mesh", is::index}, {"skin", is::index}, {"camera", is::index},
    {"matrix", is::numbers, false, 16}, {"translation", is::numbers, false, 3}, {"rotation", is::numbers, false, 4},
    {"scale", is::numbers, false, 3}, {"weights", is::numbers}, {"extensions", is::extensions}};
static constexpr shape mesh_shape = {
    {"name", is::text}, {"primitives", is::objects, true}, {"weights", is::numbers}};
static constexpr shape primitive_shape = {
    {"attributes", is::index_map, true}, {"indices", is::index}, {"material", is::index}, {"mode", is::index},
    {"targets", is::objects}, {"extensions", is::extensions}};
static constexpr shape material_shape = {
    {"name", is::text}, {"alphaMode", is::text}, {"doubleSided", is::flag}};
static constexpr shape accessor_shape = {
    {"bufferView", is::index}, {"byteOffset", is::size}, {"componentType", is::index, true}, {"count", is::size, true},
    {"type", is::text, true}, {"normalized", is::flag}, {"sparse", is::object}};
static constexpr shape sparse_shape = {
    {"count", is::index, true}, {"indices", is::object, true}, {"values", is::object, true}};
static constexpr shape sparse_indices_shape = {
    {"bufferView", is::index, true}, {"byteOffset", is::index}, {"componentType", is::index, true}};
static constexpr shape sparse_values_shape = {
    {"bufferView", is::index, true}, {"byteOffset", is::index}};
static constexpr shape buffer_view_shape = {
    {"buffer", is::index, true}, {"byteOffset", is::size}, {"byteLength", is::size, true}, {"byteStride", is::size},
    {"extensions", is::extensions}};
static constexpr shape buffer_shape = {
    {"byteLength", is::size, true}, {"uri", is::text}, {"extensions", is::extensions}};
static constexpr shape skin_shape = {
    {"name", is::text}, {"joints", is::indices, true}};
static constexpr shape draco_shape = {
    {"bufferView", is::index, true}, {"attributes", is::index_map, true}};
static constexpr shape instancing_shape = {
    {"attributes", is::index_map, true}};
static constexpr shape light_use_shape = {
    {"light", is::index, true}};
/* clang-format on */

static bool is_index(const json &value)
{
    return value.is_number_unsigned() && value.get<uint64_t>() <= INT_MAX;
}

static bool is_text(const json &value)
{
    return value.is_string();
}

static bool is_number(const json &value)
{
    return value.is_number();
}

static bool is_object(const json &value)
{
    return value.is_object();
}

static bool all(const json &values, bool (*hold)(const json &))
{
    return std::all_of(values.begin(), values.end(), hold);
}

/* NULL when the value has the shape, else what was expected. */
static const char *expected_instead(const json &value, is kind)
{
    bool array = value.is_array(), object = value.is_object();
    switch (kind) {
    case is::index: return is_index(value) ? nullptr : "an integer from 0 to 2147483647";
    case is::size: return value.is_number_unsigned() && value.get<uint64_t>() < (1ull << 53) ? nullptr : "an integer, 0 or more";
    case is::text: return is_text(value) ? nullptr : "a string";
    case is::flag: return value.is_boolean() ? nullptr : "true or false";
    case is::number: return is_number(value) ? nullptr : "a number";
    case is::numbers: return array && all(value, is_number) ? nullptr : "an array of numbers";
    case is::indices: return array && all(value, is_index) ? nullptr : "an array of indices";
    case is::texts: return array && all(value, is_text) ? nullptr : "an array of strings";
    case is::object: return object ? nullptr : "an object";
    case is::objects: return array && all(value, is_object) ? nullptr : "an array of objects";
    case is::extensions: return object && all(value, is_object) ? nullptr : "an object of objects";
    case is::index_map: return object && all(value, is_index) ? nullptr : "an object of indices";
    }
    return nullptr;
}

void check_shape(loader &l, const std::string &where, const json &object, const shape &expected)
{
    for (const property &p : expected) {
        auto found = object.find(p.name);
        if (found == object.end() && !p.required) continue;
        if (found == object.end()) l.broken(where, "'%s' is missing", p.name);
        if (const char *instead = expected_instead(*found, p.kind)) l.broken(where, "'%s' is not %s", p.name, instead);
        if (p.count && found->size() != p.count) l.broken(where, "'%s' is not %zu numbers", p.name, p.count);
    }
}

const json *check_extension(loader &l, const std::string &where, const json &object, const char *name, const shape &expected)
{
    const json *found = extension(object, name);
    if (found) check_shape(l, where + " " + name, *found, expected);
    return found;
}

const json &items(const json &object, const char *name)
{
    static const json none  = json::array();
    auto              found = object.find(name);
    return found == object.end() ? none : *found;
}

const json *extension(const json &object, const char *name)
{
    const json &extensions = items(object, "extensions");
    auto        found      = extensions.find(name);
    return found == extensions.end() ? nullptr : &*found;
}

void check_list(loader &l, const json &root, const char *list, const char *item_name, const shape &expected)
{
    size_t index = 0;
    for (const json &item : items(root, list)) check_shape(l, label(item_name, index++), item, expected);
}

static void check_version(loader &l, const json &root)
{
    auto asset = root.find("asset");
    if (asset == root.end() || !asset->is_object()) l.broken("", "not glTF 2.0: 'asset' is missing");
    for (const char *name : {"minVersion", "version"}) {
        auto     found = asset->find(name);
        unsigned major, minor;
        bool     is_least = !strcmp(name, "minVersion");
        if (found == asset->end() && is_least) continue;
        if (found == asset->end() || !found->is_string() ||
            sscanf(found->get_ref<const std::string &>().c_str(), "%u.%u", &major, &minor) != 2)
            l.broken("", "asset.%s: expected a text like \"2.0\"", name);
        if (major != 2 || (minor && is_least)) l.unsupported("", "asset.%s is %u.%u, expected 2.0", name, major, minor);
    }
}

/* Extensions that are read, and those that may be required because they change no shadow: how surfaces and images look. */
static bool extension_known(const std::string &name)
{
    /* clang-format off */
    static const std::set<std::string> known = {
        "EXT_mesh_gpu_instancing", "EXT_meshopt_compression", "KHR_draco_mesh_compression", "KHR_lights_punctual",
        "KHR_mesh_quantization", "KHR_meshopt_compression", "KHR_texture_transform", "EXT_texture_webp",
        "KHR_materials_pbrSpecularGlossiness", "KHR_materials_variants",

        "EXT_texture_avif", "KHR_texture_basisu", "MSFT_texture_dds", "KHR_animation_pointer", "KHR_xmp", "KHR_xmp_json_ld",
        "KHR_materials_anisotropy", "KHR_materials_clearcoat", "KHR_materials_common", "KHR_materials_diffuse_transmission",
        "KHR_materials_dispersion", "KHR_materials_emissive_strength", "KHR_materials_ior", "KHR_materials_iridescence",
        "KHR_materials_sheen", "KHR_materials_specular", "KHR_materials_transmission", "KHR_materials_unlit",
        "KHR_materials_volume"};
    /* clang-format on */
    return known.count(name) != 0;
}

static void check_required_extensions(loader &l, const json &root)
{
    for (const json &name : items(root, "extensionsRequired"))
        if (!extension_known(name)) l.unsupported("", "requires the extension %s", name.get<std::string>().c_str());
}

static void check_nodes(loader &l, const json &root)
{
    size_t index = 0;
    for (const json &node : items(root, "nodes")) {
        std::string where = label("node", index++);
        if (node.contains("matrix") && (node.contains("translation") || node.contains("rotation") || node.contains("scale")))
            l.error(VXS_E_SCENE, "%s has both a matrix and translation, rotation or scale", where.c_str());
        check_extension(l, where, node, "KHR_lights_punctual", light_use_shape);
        check_extension(l, where, node, "EXT_mesh_gpu_instancing", instancing_shape);
    }
}

static void check_accessor_members(loader &l, const json &root)
{
    size_t index = 0;
    for (const json &accessor : items(root, "accessors")) {
        std::string where  = label("accessor", index++);
        auto        sparse = accessor.find("sparse");
        if (accessor.contains("byteOffset") && !accessor.contains("bufferView"))
            l.broken(where, "a byteOffset without a bufferView");
        if (sparse == accessor.end()) continue;
        check_shape(l, where + " sparse", *sparse, sparse_shape);
        check_shape(l, where + " sparse indices", (*sparse)["indices"], sparse_indices_shape);
        check_shape(l, where + " sparse values", (*sparse)["values"], sparse_values_shape);
    }
}

static void check_primitives(loader &l, const json &root)
{
    size_t mesh_index = 0;
    for (const json &mesh : items(root, "meshes")) {
        std::string mesh_label = label("mesh", mesh_index++);
        size_t      index      = 0;
        for (const json &primitive : mesh["primitives"]) {
            std::string where = mesh_label + " " + label("primitive", index++);
            check_shape(l, where, primitive, primitive_shape);
            check_extension(l, where, primitive, "KHR_draco_mesh_compression", draco_shape);
            for (const json &target : items(primitive, "targets"))
                if (!all(target, is_index)) l.broken(where, "a morph target's attribute is not an index");
        }
    }
}

/* What a text is made of. */
struct text_counts {
    long   deepest = 0; /* how deep brackets nest; nlohmann could count while it parses, but in quadratic time */
    size_t values  = 0; /* nearly */
};

static text_counts count_text(const container &c)
{
    text_counts counts;
    long        depth  = 0;
    bool        quoted = false;
    for (size_t i = 0; i < c.text_size; i++) {
        char at = c.text[i];
        if (quoted && at == '\\')
            i++;
        else if (at == '"')
            quoted = !quoted;
        else if (!quoted && (at == '[' || at == '{'))
            counts.deepest = std::max(counts.deepest, ++depth), counts.values++;
        else if (!quoted && (at == ']' || at == '}'))
            depth--;
        else if (!quoted && at == ',')
            counts.values++;
    }
    return counts;
}

/* What a text becomes, with the model that tinygltf makes of it: measured with long lists of nodes and with data URIs. */
constexpr uint64_t JSON_VALUE_BYTES = 150, JSON_TEXT_BYTES = 3;

json parse_json(loader &l, const container &c)
{
    text_counts counts = count_text(c);
    if (counts.deepest > JSON_DEPTH_MAX) l.broken("", "its JSON is nested too deeply");
    l.need(JSON_VALUE_BYTES * counts.values + JSON_TEXT_BYTES * c.text_size,
           "JSON of " + std::to_string(counts.values) + " values in " + std::to_string(c.text_size) + " bytes");
    return json::parse(c.text, c.text + c.text_size);
}

void check_json(loader &l, const json &root)
{
    if (!root.is_object()) l.broken("", "its JSON is not an object");
    check_version(l, root);
    check_shape(l, "glTF", root, root_shape);
    check_required_extensions(l, root);
    check_list(l, root, "scenes", "scene", scene_shape);
    check_list(l, root, "nodes", "node", node_shape);
    check_list(l, root, "meshes", "mesh", mesh_shape);
    check_list(l, root, "materials", "material", material_shape);
    check_list(l, root, "accessors", "accessor", accessor_shape);
    check_list(l, root, "bufferViews", "bufferView", buffer_view_shape);
    check_list(l, root, "buffers", "buffer", buffer_shape);
    check_list(l, root, "skins", "skin", skin_shape);
    check_nodes(l, root);
    check_accessor_members(l, root);
    check_primitives(l, root);
}

} // namespace gltf
