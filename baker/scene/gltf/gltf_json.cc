/* Check the JSON: everything the loader reads must have the type that the specification requires.
 *
 * tinygltf is lenient: it treats a property of the wrong type as missing, and drops a primitive that it cannot parse. A bake must
 * not silently differ from the file. So the tables below list everything that is read, and it is checked before. If an item of a
 * list is wrong, its fault is stored, and tinygltf gets an empty item instead.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/scene/gltf/gltf_loader.h"

#include <algorithm>
#include <climits>
#include <cmath>
#include <functional>
#include <set>
#include <strings.h>

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
    {"joints", is::indices, true}, {"inverseBindMatrices", is::index}};
static constexpr shape draco_shape = {
    {"bufferView", is::index, true}, {"attributes", is::index_map, true}};
static constexpr shape instancing_shape = {
    {"attributes", is::index_map, true}};
static constexpr shape light_use_shape = {
    {"light", is::index, true}};
static constexpr shape visibility_shape = {
    {"visible", is::flag}};
/* clang-format on */

static bool is_index(const json &value)
{
    return value.is_number_unsigned() && value.get<uint64_t>() <= INT_MAX;
}

template <typename test> static bool all(const json &values, test hold)
{
    return std::all_of(values.begin(), values.end(), [hold](const json &value) { return std::invoke(hold, value); });
}

/* NULL when the value has the expected type, else a description of that type. */
static const char *expected_instead(const json &value, is kind)
{
    bool array = value.is_array(), object = value.is_object();
    switch (kind) {
    case is::index: return is_index(value) ? nullptr : "an integer from 0 to 2147483647";
    case is::size: return value.is_number_unsigned() && value.get<uint64_t>() < (1ull << 53) ? nullptr : "an integer, 0 or more";
    case is::text: return value.is_string() ? nullptr : "a string";
    case is::flag: return value.is_boolean() ? nullptr : "true or false";
    case is::number: return value.is_number() ? nullptr : "a number";
    case is::numbers: return array && all(value, &json::is_number) ? nullptr : "an array of numbers";
    case is::indices: return array && all(value, is_index) ? nullptr : "an array of indices";
    case is::texts: return array && all(value, &json::is_string) ? nullptr : "an array of strings";
    case is::object: return object ? nullptr : "an object";
    case is::objects: return array && all(value, &json::is_object) ? nullptr : "an array of objects";
    case is::extensions: return object && all(value, &json::is_object) ? nullptr : "an object of objects";
    case is::index_map: return object && all(value, is_index) ? nullptr : "an object of indices";
    }
    return nullptr;
}

static void check_member(loader &l, const std::string &where, const json &object, const property &p)
{
    auto found = object.find(p.name);
    if (found == object.end() && !p.required) return;
    if (found == object.end()) l.broken(where, "'%s' is missing", p.name);
    if (const char *instead = expected_instead(*found, p.kind)) l.broken(where, "'%s' is not %s", p.name, instead);
    if (p.count && found->size() != p.count) l.broken(where, "'%s' is not %zu numbers", p.name, p.count);
}

void check_shape(loader &l, const std::string &where, const json &object, const shape &expected)
{
    for (const property &p : expected) check_member(l, where, object, p);
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

std::string text_of(const json &object, const char *name, const std::string &absent)
{
    auto found = object.find(name);
    return found != object.end() && found->is_string() ? found->get<std::string>() : absent;
}

/* The name of an object, for messages only. If it is not a string, it is removed, and the result is "". */
static std::string take_name(json &object)
{
    if (object.contains("name") && !object["name"].is_string()) object.erase("name");
    return text_of(object, "name");
}

/* Parse the version: "2.0", and variants that some writers use: 2.0 and 2, as a number or a string. */
static bool read_version(const json &value, unsigned *major, unsigned *minor)
{
    char end;
    *minor = 0;
    if (value.is_number()) {
        double number = value.get<double>();
        if (!(number >= 0 && number < 1000)) return false;
        *major = (unsigned)number;
        *minor = (unsigned)std::lround(10 * (number - *major));
        return true;
    }
    const char *text = value.is_string() ? value.get_ref<const std::string &>().c_str() : "";
    return sscanf(text, "%u.%u", major, minor) == 2 || sscanf(text, "%u%c", major, &end) == 1;
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
        if (found == asset->end() || !read_version(*found, &major, &minor))
            l.broken("", "asset.%s: expected a text like \"2.0\"", name);
        if (major != 2 || (minor && is_least))
            l.refused("", "asset.%s is %u.%u, expected 2.0%s", name, major, minor,
                      major < 2 ? ": glTF 1.0 is another format; convert it with gltf-pipeline, or export it again" : "");
    }
}

/* ---- items of lists ---- */

static const char export_again[] = "export it again";

/* Check the members of an extension, and remove the extension if they are wrong. */
static failure take_out_extension(loader &l, const std::string &where, json &object, const char *name, const shape &expected)
{
    failure f = fault_of([&] { check_extension(l, where, object, name, expected); });
    if (f) object["extensions"].erase(name);
    return f;
}

/* A wrong transform or child list is a fault of the node and its subtree; other faults affect only their own part. */
static void check_node(loader &l, json &node, size_t index)
{
    node_state &state = l.nodes[index];
    std::string where = label("node", index, take_name(node));
    for (const property &p : node_shape) {
        failure f     = fault_of([&] { check_member(l, where, node, p); });
        bool    moves = p.kind == is::numbers && strcmp(p.name, "weights") != 0;
        if (f) node.erase(p.name);
        if (f && moves && !state.fault)
            state.fault = f;
        else if (f && !moves)
            take_fault(l, cost::REFERENCE, 16 * index + (size_t)(&p - node_shape.begin()), where, f, export_again);
    }
    if (node.contains("matrix") && (node.contains("translation") || node.contains("rotation") || node.contains("scale"))) {
        take_note(l, cost::TREE, index, where, "has both a matrix and translation, rotation or scale: the matrix counts",
                  export_again);
        for (const char *name : {"translation", "rotation", "scale"}) node.erase(name);
    }
    state.light      = take_out_extension(l, where, node, "KHR_lights_punctual", light_use_shape).text;
    state.instancing = take_out_extension(l, where, node, "EXT_mesh_gpu_instancing", instancing_shape);
    if (failure f = take_out_extension(l, where, node, "KHR_node_visibility", visibility_shape))
        take_note(l, cost::TREE, index, where, f.text.substr(f.text.find("KHR_node")) + ": taken as visible", export_again);
    const json *visibility = extension(node, "KHR_node_visibility");
    state.hidden           = visibility && visibility->value("visible", true) == false;
}

/* Check that tinygltf knows the type, and this loader the component type. */
static void check_accessor(loader &l, const std::string &where, const json &accessor)
{
    static const std::set<std::string> types = {"SCALAR", "VEC2", "VEC3", "VEC4", "MAT2", "MAT3", "MAT4"};
    check_shape(l, where, accessor, accessor_shape);
    std::string type = accessor["type"];
    if (!types.count(type)) l.broken(where, "unknown type '%.40s'", type.c_str());
    if (!component_bytes(accessor["componentType"]))
        l.broken(where, "unknown componentType %d", accessor["componentType"].get<int>());
    if (accessor.contains("byteOffset") && !accessor.contains("bufferView")) l.broken(where, "a byteOffset without a bufferView");
    auto sparse = accessor.find("sparse");
    if (sparse == accessor.end()) return;
    check_shape(l, where + " sparse", *sparse, sparse_shape);
    check_shape(l, where + " sparse indices", (*sparse)["indices"], sparse_indices_shape);
    check_shape(l, where + " sparse values", (*sparse)["values"], sparse_values_shape);
}

static void check_mesh(loader &l, json &mesh, size_t index)
{
    std::string where    = label("mesh", index, take_name(mesh));
    l.mesh_faults[index] = fault_of([&] { check_shape(l, where, mesh, mesh_shape); });
    if (!l.mesh_faults[index]) l.mesh_faults.erase(index);
    if (l.mesh_faults.count(index)) mesh["primitives"] = json::array(), mesh.erase("weights");
    for (size_t i = 0; i < mesh["primitives"].size(); i++) {
        json       &primitive = mesh["primitives"][i];
        std::string what      = where + " " + label("primitive", i);
        failure     f         = fault_of([&] {
            check_shape(l, what, primitive, primitive_shape);
            check_extension(l, what, primitive, "KHR_draco_mesh_compression", draco_shape);
            for (const json &target : items(primitive, "targets"))
                if (!all(target, is_index)) l.broken(what, "a morph target's attribute is not an index");
        });
        if (f) {
            json instead = {{"attributes", json::object()}};
            if (primitive.contains("material") && is_index(primitive["material"]))
                instead["material"] = primitive["material"]; /* kept, because patterns may match it */
            l.primitive_faults[{index, i}] = f;
            primitive                      = instead;
        }
    }
}

/* Check items that are looked up by number. */
template <typename function>
static void check_items(loader &l, json &root, list which, const char *name, const json &instead, function &&check)
{
    static const char *const lists[LISTS] = {"scenes", "accessors", "bufferViews", "buffers", "skins"};
    for (size_t i = 0; i < items(root, lists[which]).size(); i++) {
        json &item = root[lists[which]][i];
        take_name(item);
        if (failure f = fault_of([&] { check(label(name, i), item); })) {
            l.faults[which][i] = f;
            item               = instead;
        }
    }
}

static json trimmed(json &object, const shape &kept)
{
    json out = json::object();
    for (const property &p : kept) {
        auto found = object.find(p.name);
        if (found != object.end()) out[p.name] = std::move(*found);
    }
    return out;
}

json take_model(json &root)
{
    static const struct {
        const char  *name;
        const shape &kept;
    } lists[]  = {{"scenes", scene_shape}, {"nodes", node_shape}, {"meshes", mesh_shape}, {"accessors", accessor_shape}};
    json model = json::object();
    for (const char *name : {"asset", "scene"})
        if (root.contains(name)) model[name] = std::move(root[name]);
    model["asset"]["version"] = "2.0"; /* as a string, even if the file has a number */
    for (const auto &list : lists) {
        if (!root.contains(list.name)) continue;
        json &to = model[list.name] = json::array();
        for (json &item : root[list.name]) to.push_back(trimmed(item, list.kept));
        root.erase(list.name);
    }
    for (json &mesh : model.contains("meshes") ? model["meshes"] : model["none"])
        for (json &primitive : mesh["primitives"]) primitive = trimmed(primitive, primitive_shape);
    model.erase("none");
    return model;
}

/* ---- the text ---- */

/* Memory per JSON value and per byte of text, including tinygltf's model. Measured with long lists of nodes and with data URIs. */
constexpr uint64_t JSON_VALUE_BYTES = 150, JSON_TEXT_BYTES = 3;

/* Replace invalid numbers that printf and scripts write (NaN, -Infinity, inf, -nan(ind), 1.#QNAN, 1e999) by null; properties that
 * need a number then report an error. Returns how many were replaced. */
static size_t replace_no_numbers(const container &c, std::string &text)
{
    static const char token_of[] = "+-.#()0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz";
    size_t            count      = 0;
    for (size_t i = 0; i < c.text_size;) {
        size_t begin = i;
        if (c.text[i] == '"') {
            for (i++; i < c.text_size && c.text[i] != '"'; i++) i += c.text[i] == '\\';
            i = std::min(i + 1, c.text_size);
            text.append(c.text + begin, i - begin);
            continue;
        }
        while (i < c.text_size && c.text[i] && strchr(token_of, c.text[i])) i++;
        if (i == begin) {
            text += c.text[i++];
            continue;
        }
        std::string token(c.text + begin, i - begin);
        char       *end;
        double      number = strtod(token.c_str(), &end); /* accepts these words */
        bool        bad    = end != token.c_str() && (*end == '#' || *end == '(' || (!*end && !std::isfinite(number)));
        text += bad ? "null" : token;
        count += bad;
    }
    return count;
}

/* Convert bytes that are not UTF-8 from Latin-1, as older Western European exporters write. These are nearly always in names.
 * Returns how many were converted. */
static size_t replace_latin1(std::string &text)
{
    std::string out;
    size_t      count = 0;
    for (size_t i = 0, size; i < text.size(); i += size) {
        uint32_t      code;
        unsigned char byte = (unsigned char)text[i];
        size               = utf8_letter(text.c_str() + i, &code);
        if (size) {
            out.append(text, i, size);
            continue;
        }
        out += (char)(0xc0 | byte >> 6);
        out += (char)(0x80 | (byte & 0x3f));
        size = 1;
        count++;
    }
    text = std::move(out);
    return count;
}

static json parse_text(loader &l, const container &c)
{
    try {
        return json::parse(c.text, c.text + c.text_size);
    } catch (const json::exception &) {
        std::string text;
        size_t      numbers = replace_no_numbers(c, text), letters = replace_latin1(text);
        if (!numbers && !letters) throw;
        json root = json::parse(text);
        if (numbers)
            take_note(l, cost::NUMBERS, 0, "JSON",
                      std::to_string(numbers) +
                          " numbers are NaN or infinite, which JSON has not: what needs one of them is left out",
                      "export it again without them");
        if (letters)
            take_note(l, cost::NUMBERS, 1, "JSON", std::to_string(letters) + " bytes are no UTF-8: taken as Latin-1",
                      "save it as UTF-8");
        return root;
    }
}

/* Convert floats with integral values to integers: some languages write all numbers with a fraction, 24.0 for 24. */
static void take_whole_numbers(json &value)
{
    if (value.is_structured())
        for (json &item : value) take_whole_numbers(item);
    if (!value.is_number_float()) return;
    double number = value.get<double>();
    if (number < 9e15 && number == std::floor(number) && !std::signbit(number)) value = (uint64_t)number;
}

json parse_json(loader &l, const container &c)
{
    long   deepest = 0, depth = 0; /* nesting of brackets; counting it in nlohmann's parser would take quadratic time */
    size_t values = 0;             /* approximate */
    bool   quoted = false;
    for (size_t i = 0; i < c.text_size; i++) {
        char at = c.text[i];
        if (quoted && at == '\\')
            i++;
        else if (at == '"')
            quoted = !quoted;
        else if (!quoted && (at == '[' || at == '{'))
            deepest = std::max(deepest, ++depth), values++;
        else if (!quoted && (at == ']' || at == '}'))
            depth--;
        else if (!quoted && at == ',')
            values++;
    }
    if (deepest > JSON_DEPTH_MAX) l.broken("", "its JSON is nested too deeply");
    l.need(JSON_VALUE_BYTES * values + JSON_TEXT_BYTES * c.text_size,
           "JSON of " + std::to_string(values) + " values in " + std::to_string(c.text_size) + " bytes");
    json root = parse_text(l, c);
    take_whole_numbers(root);
    return root;
}

void check_json(loader &l, json &root)
{
    if (!root.is_object()) l.broken("", "its JSON is not an object");
    if (root.contains("geometricError") && root.contains("root")) /* also JSON with an `asset` */
        l.refused("", "is a tileset of 3D Tiles: give the glTF files that it refers to, one by one");
    check_version(l, root);
    check_shape(l, "glTF", root, root_shape);
    check_extensions(l, root);

    auto by = [&l](const shape &expected) {
        return [&l, &expected](const std::string &where, const json &item) { check_shape(l, where, item, expected); };
    };
    check_items(l, root, SCENES, "scene", json::object(), by(scene_shape));
    check_items(l, root, ACCESSORS, "accessor", {{"componentType", 5126}, {"count", 0}, {"type", "SCALAR"}},
                [&l](const std::string &where, const json &item) { check_accessor(l, where, item); });
    check_items(l, root, VIEWS, "bufferView", json::object(), by(buffer_view_shape));
    check_items(l, root, BUFFERS, "buffer", json::object(), by(buffer_shape));
    check_items(l, root, SKINS, "skin", json::object(), by(skin_shape));
    l.nodes.resize(items(root, "nodes").size());
    for (size_t i = 0; i < l.nodes.size(); i++) check_node(l, root["nodes"][i], i);
    for (size_t i = 0; i < items(root, "meshes").size(); i++) check_mesh(l, root["meshes"][i], i);
    for (size_t i = 0; i < items(root, "materials").size(); i++) take_name(root["materials"][i]);
}

} // namespace gltf
