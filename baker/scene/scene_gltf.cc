/* glTF 2.0 to a scene, through tinygltf.
 *
 *   file -> container (GLB chunks) -> JSON shape -> tinygltf -> node tree -> placements -> triangles in world space
 *
 * tinygltf reads leniently: a property of the wrong type counts as absent, a primitive that it cannot parse is dropped, and
 * accessors are not held against their buffers. A baker must not bake something else than what the file says, so the JSON's
 * shape is checked first (the tables below list all that is read here), and every range is checked before it is read.
 * Section numbers are those of the glTF 2.0 specification.
 *
 * Shared accessors: vertices are emitted when an index first names them and shared between the primitives of a node, so
 * memory follows the triangles and not the accessors (2023 fans over one accessor emit its vertices once).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/scene/scene.h"

#include <cerrno>
#include <climits>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <fstream>
#include <map>
#include <set>
#include <stdexcept>
#include <string>
#include <sys/stat.h>
#include <unistd.h>
#include <vector>

#define TINYGLTF_IMPLEMENTATION
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_EXTERNAL_IMAGE
#define TINYGLTF_NO_FS
#include <tiny_gltf.h>

namespace
{

using json = nlohmann::json;

constexpr size_t FILE_BYTES_MAX = UINT32_MAX;      /* GLB and tinygltf count in 32 bits */
constexpr size_t INDICES_MAX    = (size_t)1 << 31; /* of the whole scene; vertices are never more */
constexpr size_t DENSE_MAX      = (size_t)1 << 25; /* elements that sparse accessors may expand to, together */
constexpr long   JSON_DEPTH_MAX = 200;             /* tinygltf recurses into extras */

/* An accessor's elements, known to lie in their buffer. */
struct elements {
    const unsigned char       *data; /* NULL: all zero, until made dense */
    size_t                     stride, count, size;
    std::vector<unsigned char> dense; /* owns data when the accessor is sparse or has no bufferView */
};

struct buffer_file {
    std::string path;
    size_t      size_bytes; /* as the file promises; the rest of a longer file is not read */
};

struct vec3 {
    double x, y, z;
};

/* Affine, column-major as in glTF: three axes, then the translation. */
struct transform {
    vec3 axis[3], origin;
};

struct loader {
    message        *m;
    const char     *path;
    scene          *s;
    tinygltf::Model model;

    std::vector<buffer_file> buffer_files; /* in the order in which tinygltf asks for them */
    size_t                   next_file = 0;

    std::vector<elements> accessors;
    size_t                dense_left = DENSE_MAX;

    std::vector<int>       roots, order; /* the scene's nodes, parents first */
    std::vector<transform> ws_from_node; /* by node */

    /* vertices emitted so far: slot i of the current generation is accessor element i */
    struct slot {
        uint32_t generation, vertex;
    };
    std::vector<slot> slots;
    uint32_t          generation      = 0;
    size_t            vertex_capacity = 0;

    vxs_result error(vxs_result code, const char *format, ...) __attribute__((format(printf, 3, 4)));
};

/* Every message names the file first. */
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

/* tinygltf's and nlohmann's texts may hold several lines, whole data URIs, and a bracketed class of error. */
std::string one_line(std::string text)
{
    if (text.rfind("[json.", 0) == 0 && text.find("] ") != std::string::npos) text.erase(0, text.find("] ") + 2);
    while (!text.empty() && isspace((unsigned char)text.back())) text.pop_back();
    for (char &c : text)
        if (c == '\n') c = ' ';
    if (text.size() > 300) text = text.substr(0, 300) + "...";
    return text.empty() ? "cannot be parsed" : text;
}

/* ---- files ---- */

/* The first `limit` bytes of a file, or an errno. A file that a scene refers to must be a regular one: a pipe may never end.
 */
int read_bytes(const char *path, size_t limit, bool regular_only, std::vector<unsigned char> &bytes)
{
    int file = open(path, O_RDONLY | O_CLOEXEC | (regular_only ? O_NONBLOCK : 0));
    if (file < 0) return errno;

    struct stat status;
    int         reason = 0;
    if (fstat(file, &status))
        reason = errno;
    else if (S_ISDIR(status.st_mode))
        reason = EISDIR;
    else if (regular_only && !S_ISREG(status.st_mode))
        reason = EINVAL;

    size_t found = 0;
    if (!reason) bytes.resize(S_ISREG(status.st_mode) ? std::min((size_t)status.st_size, limit) : 0);
    while (!reason && found < limit) {
        if (found == bytes.size()) bytes.resize(std::min(limit, found + std::max(found, (size_t)65536)));
        ssize_t n = read(file, bytes.data() + found, bytes.size() - found);
        if (n < 0 && errno != EINTR) reason = errno;
        if (n == 0) break;
        if (n > 0) found += (size_t)n;
        if (found == bytes.size() && S_ISREG(status.st_mode) && found >= (size_t)status.st_size) break;
    }
    close(file);
    bytes.resize(found);
    return reason;
}

vxs_result read_scene_file(loader &l, std::vector<unsigned char> &bytes)
{
    int reason = read_bytes(l.path, FILE_BYTES_MAX, false, bytes);
    if (reason) return fail(l.m, VXS_E_READ, "cannot read '%s': %s", l.path, strerror(reason));
    if (bytes.empty()) return fail(l.m, VXS_E_READ, "cannot read '%s': the file is empty", l.path);
    if (bytes.size() >= FILE_BYTES_MAX) return l.error(VXS_E_UNSUPPORTED, "is 4 GiB or larger");
    return VXS_OK;
}

std::string percent_decoded(const std::string &uri)
{
    std::string text;
    for (size_t i = 0; i < uri.size(); i++) {
        unsigned code;
        if (uri[i] == '%' && i + 2 < uri.size() && isxdigit((unsigned char)uri[i + 1]) && isxdigit((unsigned char)uri[i + 2]) &&
            sscanf(uri.c_str() + i + 1, "%2x", &code) == 1) {
            text += (char)code;
            i += 2;
        } else {
            text += uri[i];
        }
    }
    return text;
}

/* tinygltf would also look in the working directory and read '+' as a space: its paths are not used, only its order. */
bool read_buffer_file(std::vector<unsigned char> *out, std::string *, const std::string &, void *user)
{
    loader &l = *(loader *)user;
    if (l.next_file >= l.buffer_files.size()) return false;
    const buffer_file &wanted = l.buffer_files[l.next_file++];

    int reason = read_bytes(wanted.path.c_str(), wanted.size_bytes, true, *out);
    if (reason) {
        l.error(VXS_E_READ, "cannot read its buffer '%s': %s", wanted.path.c_str(), strerror(reason));
        return false;
    }
    if (out->size() < wanted.size_bytes) {
        l.error(VXS_E_READ, "its buffer '%s' ends after %zu bytes, expected %zu", wanted.path.c_str(), out->size(),
                wanted.size_bytes);
        return false;
    }
    return true;
}

bool any_file_exists(const std::string &, void *)
{
    return true;
}

std::string same_path(const std::string &path, void *)
{
    return path;
}

bool drop_image(tinygltf::Image *, const int, std::string *, std::string *, int, int, const unsigned char *, int, void *)
{
    return true;
}

/* ---- container (4.4): where the JSON is ---- */

struct container {
    const char *text;
    size_t      text_size;
    bool        binary, has_bin;
};

uint32_t u32_at(const std::vector<unsigned char> &bytes, size_t offset)
{
    const unsigned char *b = bytes.data() + offset;
    return (uint32_t)b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
}

vxs_result open_container(loader &l, const std::vector<unsigned char> &bytes, container &c)
{
    c = {(const char *)bytes.data(), bytes.size(), false, false};
    if (bytes.size() < 4 || memcmp(bytes.data(), "glTF", 4)) return VXS_OK;

    c.binary = true;
    if (bytes.size() < 20) return l.error(VXS_E_SCENE, "GLB header: %zu bytes found, at least 20 expected", bytes.size());
    uint32_t version = u32_at(bytes, 4), length = u32_at(bytes, 8), text_size = u32_at(bytes, 12);
    if (version != 2) return l.error(VXS_E_UNSUPPORTED, "GLB version %u, expected 2", version);
    if (length > bytes.size()) return l.error(VXS_E_SCENE, "GLB header promises %u bytes, the file has %zu", length, bytes.size());
    if (u32_at(bytes, 16) != 0x4e4f534a) return l.error(VXS_E_SCENE, "the first GLB chunk is not JSON");
    if (!text_size || text_size % 4 || length < 20 || text_size > length - 20)
        return l.error(VXS_E_SCENE, "GLB JSON chunk of %u bytes in a file of %u: it must fit and be a multiple of 4", text_size,
                       length);
    c.text += 20;
    c.text_size = text_size;

    size_t at = 20 + (size_t)text_size;
    if (at == length) return VXS_OK;
    if (length - at < 8 || u32_at(bytes, at) > length - at - 8)
        return l.error(VXS_E_SCENE, "the second GLB chunk does not fit in the file");
    if (u32_at(bytes, at + 4) != 0x004e4942) return l.error(VXS_E_SCENE, "the second GLB chunk is not BIN");
    c.has_bin = true;
    return VXS_OK;
}

/* ---- shape of the JSON: all that is read here has the type that the specification gives it ---- */

enum class is { index, size, text, flag, numbers, indices, texts, object, objects, extensions, index_map };

struct property {
    const char *name;
    is          kind;
    bool        required = false;
    size_t      count    = 0; /* of numbers; 0: any */
};

/* clang-format off */
const std::vector<property> root_shape = {
    {"asset", is::object, true}, {"extensionsUsed", is::texts}, {"extensionsRequired", is::texts}, {"scene", is::index},
    {"scenes", is::objects}, {"nodes", is::objects}, {"meshes", is::objects}, {"materials", is::objects},
    {"accessors", is::objects}, {"bufferViews", is::objects}, {"buffers", is::objects}, {"skins", is::objects},
    {"cameras", is::objects}, {"extensions", is::extensions}};
const std::vector<property> scene_shape = {
    {"name", is::text}, {"nodes", is::indices}};
const std::vector<property> node_shape = {
    {"name", is::text}, {"children", is::indices}, {"mesh", is::index}, {"skin", is::index}, {"camera", is::index},
    {"matrix", is::numbers, false, 16}, {"translation", is::numbers, false, 3}, {"rotation", is::numbers, false, 4},
    {"scale", is::numbers, false, 3}, {"weights", is::numbers}, {"extensions", is::extensions}};
const std::vector<property> mesh_shape = {
    {"name", is::text}, {"primitives", is::objects, true}, {"weights", is::numbers}};
const std::vector<property> primitive_shape = {
    {"attributes", is::index_map, true}, {"indices", is::index}, {"material", is::index}, {"mode", is::index},
    {"targets", is::objects}, {"extensions", is::extensions}};
const std::vector<property> material_shape = {
    {"name", is::text}, {"alphaMode", is::text}, {"doubleSided", is::flag}};
const std::vector<property> accessor_shape = {
    {"bufferView", is::index}, {"byteOffset", is::size}, {"componentType", is::index, true}, {"count", is::size, true},
    {"type", is::text, true}, {"normalized", is::flag}, {"sparse", is::object}};
const std::vector<property> sparse_shape = {
    {"count", is::index, true}, {"indices", is::object, true}, {"values", is::object, true}};
const std::vector<property> sparse_indices_shape = {
    {"bufferView", is::index, true}, {"byteOffset", is::index}, {"componentType", is::index, true}};
const std::vector<property> sparse_values_shape = {
    {"bufferView", is::index, true}, {"byteOffset", is::index}};
const std::vector<property> buffer_view_shape = {
    {"buffer", is::index, true}, {"byteOffset", is::size}, {"byteLength", is::size, true}, {"byteStride", is::size},
    {"extensions", is::extensions}};
const std::vector<property> buffer_shape = {
    {"byteLength", is::size, true}, {"uri", is::text}, {"extensions", is::extensions}};
const std::vector<property> skin_shape = {
    {"name", is::text}, {"joints", is::indices, true}};
const std::vector<property> light_shape = {
    {"name", is::text}, {"type", is::text, true}};
const std::vector<property> light_use_shape = {
    {"light", is::index, true}};
/* clang-format on */

bool is_index(const json &value)
{
    return value.is_number_unsigned() && value.get<uint64_t>() <= INT_MAX;
}

/* NULL when the value has the shape, else what was expected. */
const char *expected_instead(const json &value, const property &p)
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

const json no_items = json::array();

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

vxs_result check_version(loader &l, const json &root)
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

/* Extensions that may be required because they change nothing here, or are read. */
bool extension_known(const std::string &name)
{
    for (const char *prefix : {"KHR_materials_", "KHR_texture_", "EXT_texture_"})
        if (name.rfind(prefix, 0) == 0) return true;
    for (const char *known : {"KHR_lights_punctual", "MSFT_texture_dds", "KHR_xmp_json_ld", "KHR_animation_pointer"})
        if (name == known) return true;
    return false;
}

vxs_result check_required_extensions(loader &l, const json &root)
{
    for (const json &name : items(root, "extensionsRequired"))
        if (!extension_known(name.get_ref<const std::string &>()))
            return l.error(VXS_E_UNSUPPORTED, "requires the extension %s", name.get_ref<const std::string &>().c_str());
    return VXS_OK;
}

/* Buffers without data of their own would get the GLB's bytes from tinygltf, whatever these are. */
vxs_result check_buffers(loader &l, const json &root, const container &c)
{
    std::string folder = l.path;
    folder.erase(folder.rfind('/') == std::string::npos ? 0 : folder.rfind('/') + 1);

    size_t index = 0;
    for (const json &buffer : items(root, "buffers")) {
        std::string where = label("buffer", index, "");
        size_t      bytes = buffer["byteLength"].get<size_t>();
        std::string uri   = buffer.value("uri", "");
        if (!bytes) return l.error(VXS_E_SCENE, "%s: byteLength is 0", where.c_str());
        if (uri.empty() && !(c.has_bin && index == 0)) {
            for (const char *name : {"EXT_meshopt_compression", "KHR_meshopt_compression"})
                if (extension(buffer, name)) return l.error(VXS_E_UNSUPPORTED, "%s is only there for %s", where.c_str(), name);
            return l.error(VXS_E_SCENE, "%s has neither a uri nor a GLB chunk", where.c_str());
        }
        if (!uri.empty() && !tinygltf::IsDataURI(uri)) {
            if (uri.rfind("data:", 0) == 0)
                return l.error(VXS_E_SCENE, "%s: '%.40s' is not a base64 data URI of a buffer", where.c_str(), uri.c_str());
            std::string name = percent_decoded(uri);
            if (name.find('\0') != std::string::npos)
                return l.error(VXS_E_SCENE, "%s: uri '%s' holds a zero byte", where.c_str(), uri.c_str());
            l.buffer_files.push_back({folder + name, bytes});
        }
        index++;
    }
    return VXS_OK;
}

/* tinygltf reads images through their bufferViews without a look at the buffer. Its buffers have just the promised size. */
vxs_result check_buffer_views(loader &l, const json &root)
{
    const json &buffers = items(root, "buffers");
    size_t      index   = 0;
    for (const json &view : items(root, "bufferViews")) {
        size_t buffer = view["buffer"].get<size_t>(), length = view["byteLength"].get<size_t>();
        size_t offset = view.value("byteOffset", (size_t)0);
        if (buffer >= buffers.size()) return l.error(VXS_E_SCENE, "bufferView %zu: buffer %zu does not exist", index, buffer);
        size_t bytes = buffers[buffer]["byteLength"].get<size_t>();
        if (!length || offset > bytes || length > bytes - offset)
            return l.error(VXS_E_SCENE, "bufferView %zu: %zu bytes at byte %zu do not fit in buffer %zu of %zu bytes", index,
                           length, offset, buffer, bytes);
        index++;
    }
    return VXS_OK;
}

/* A compressed primitive is read from its uncompressed copy, where it has one. */
vxs_result check_draco(loader &l, const std::string &where, const json &root, const json &primitive)
{
    if (!extension(primitive, "KHR_draco_mesh_compression")) return VXS_OK;
    const json &accessors = items(root, "accessors");
    json        wanted    = json::array({primitive["attributes"].value("POSITION", -1), primitive.value("indices", -1)});
    for (const json &index : wanted)
        if (is_index(index) && index.get<size_t>() < accessors.size() && !accessors[index.get<size_t>()].contains("bufferView"))
            return l.error(VXS_E_UNSUPPORTED, "%s has only KHR_draco_mesh_compression data", where.c_str());
    return VXS_OK;
}

vxs_result check_meshes(loader &l, const json &root)
{
    vxs_result r;
    size_t     mesh_index = 0;
    for (const json &mesh : items(root, "meshes")) {
        size_t index = 0;
        for (const json &primitive : mesh["primitives"]) {
            std::string where = label("mesh", mesh_index, "") + " " + label("primitive", index++, "");
            if ((r = check_shape(l, where, primitive, primitive_shape)) != VXS_OK) return r;
            if ((r = check_draco(l, where, root, primitive)) != VXS_OK) return r;
            for (const json &target : items(primitive, "targets"))
                for (const json &accessor : target)
                    if (!is_index(accessor))
                        return l.error(VXS_E_SCENE, "%s: a morph target's attribute is not an index", where.c_str());
        }
        mesh_index++;
    }
    return VXS_OK;
}

vxs_result check_sparse(loader &l, const json &root)
{
    vxs_result r;
    size_t     index = 0;
    for (const json &accessor : items(root, "accessors")) {
        std::string where  = label("accessor", index++, "") + " sparse";
        auto        sparse = accessor.find("sparse");
        if (sparse == accessor.end()) continue;
        if ((r = check_shape(l, where, *sparse, sparse_shape)) != VXS_OK) return r;
        if ((r = check_shape(l, where + " indices", (*sparse)["indices"], sparse_indices_shape)) != VXS_OK) return r;
        if ((r = check_shape(l, where + " values", (*sparse)["values"], sparse_values_shape)) != VXS_OK) return r;
    }
    return VXS_OK;
}

vxs_result check_nodes(loader &l, const json &root)
{
    vxs_result r;
    size_t     index = 0;
    for (const json &node : items(root, "nodes")) {
        std::string where = label("node", index++, "");
        if (node.contains("matrix") && (node.contains("translation") || node.contains("rotation") || node.contains("scale")))
            return l.error(VXS_E_SCENE, "%s has both a matrix and translation, rotation or scale", where.c_str());
        if (const json *use = extension(node, "KHR_lights_punctual"))
            if ((r = check_shape(l, where + " KHR_lights_punctual", *use, light_use_shape)) != VXS_OK) return r;
    }
    return VXS_OK;
}

vxs_result check_lights(loader &l, const json &root)
{
    vxs_result  r;
    const json *lights = extension(root, "KHR_lights_punctual");
    if (!lights) return VXS_OK;
    if ((r = check_shape(l, "KHR_lights_punctual", *lights, {{"lights", is::objects, true}})) != VXS_OK) return r;
    return check_list(l, *lights, "lights", "light", light_shape);
}

/* How deep brackets nest, at most. nlohmann could tell while it parses, but in quadratic time. */
long nesting(const container &c)
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

vxs_result check_json(loader &l, const container &c)
{
    if (nesting(c) > JSON_DEPTH_MAX) return l.error(VXS_E_SCENE, "its JSON is nested too deeply");
    json       root = json::parse(c.text, c.text + c.text_size);
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
    if ((r = check_lights(l, root)) != VXS_OK) return r;
    if ((r = check_sparse(l, root)) != VXS_OK) return r;
    if ((r = check_buffer_views(l, root)) != VXS_OK) return r;
    if ((r = check_buffers(l, root, c)) != VXS_OK) return r;
    return check_meshes(l, root);
}

/* tinygltf's own errors on success concern what is not read here: images, animations, cameras. */
vxs_result parse(loader &l)
{
    std::vector<unsigned char> bytes;
    container                  c;
    vxs_result                 r;
    if ((r = read_scene_file(l, bytes)) != VXS_OK) return r;
    if ((r = open_container(l, bytes, c)) != VXS_OK) return r;
    if ((r = check_json(l, c)) != VXS_OK) return r;

    tinygltf::TinyGLTF gltf;
    gltf.SetImageLoader(drop_image, nullptr);
    gltf.SetFsCallbacks({any_file_exists, same_path, read_buffer_file, nullptr, &l});
    std::string error, warning;
    bool        ok = c.binary ? gltf.LoadBinaryFromMemory(&l.model, &error, &warning, bytes.data(), (unsigned)bytes.size())
                              : gltf.LoadASCIIFromString(&l.model, &error, &warning, c.text, (unsigned)c.text_size, "");
    if (ok) return VXS_OK;
    if (l.m->error[0]) return VXS_E_READ; /* said by read_buffer_file */
    return l.error(VXS_E_SCENE, "%s", one_line(error).c_str());
}

/* ---- accessors (3.6) ---- */

size_t component_bytes(int component)
{
    switch (component) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE: return 1;
    case TINYGLTF_COMPONENT_TYPE_SHORT:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT: return 2;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
    case TINYGLTF_COMPONENT_TYPE_FLOAT: return 4;
    }
    return 0;
}

/* Matrix columns start at multiples of four bytes (3.6.2.4). */
size_t element_bytes(int type, size_t component)
{
    switch (type) {
    case TINYGLTF_TYPE_MAT2: return component == 1 ? 8 : 4 * component;
    case TINYGLTF_TYPE_MAT3: return component == 4 ? 36 : 12 * component;
    case TINYGLTF_TYPE_MAT4: return 16 * component;
    }
    return (size_t)tinygltf::GetNumComponentsInType((uint32_t)type) * component;
}

/* `count` elements of `size` bytes from `offset` in a bufferView, held against view and buffer. */
vxs_result view_elements(loader &l, const std::string &where, int view_index, size_t offset, size_t count, size_t size, elements &e)
{
    if (view_index < 0 || (size_t)view_index >= l.model.bufferViews.size())
        return l.error(VXS_E_SCENE, "%s: bufferView %d does not exist", where.c_str(), view_index);
    const tinygltf::BufferView &view   = l.model.bufferViews[(size_t)view_index];
    size_t                      stride = view.byteStride ? view.byteStride : size;
    if (stride < size)
        return l.error(VXS_E_SCENE, "%s: byteStride %zu is less than its elements of %zu bytes", where.c_str(), stride, size);
    if (offset > view.byteLength || count > SIZE_MAX / 256 ||
        (count && (view.byteLength - offset < size || (count - 1) > (view.byteLength - offset - size) / stride)))
        return l.error(VXS_E_SCENE, "%s: %zu elements at byte %zu do not fit in bufferView %d of %zu bytes", where.c_str(), count,
                       offset, view_index, view.byteLength);
    const auto &buffer = l.model.buffers[(size_t)view.buffer].data;
    e.data             = buffer.data() + view.byteOffset + offset;
    e.stride           = stride;
    e.count            = count;
    e.size             = size;
    return VXS_OK;
}

vxs_result check_accessors(loader &l)
{
    vxs_result r;
    l.accessors.resize(l.model.accessors.size());
    for (size_t i = 0; i < l.accessors.size(); i++) {
        const tinygltf::Accessor &a         = l.model.accessors[i];
        std::string               where     = label("accessor", i, a.name);
        size_t                    component = component_bytes(a.componentType);
        if (!component) return l.error(VXS_E_SCENE, "%s: unknown componentType %d", where.c_str(), a.componentType);

        size_t size          = element_bytes(a.type, component);
        l.accessors[i].count = a.count;
        l.accessors[i].size  = size;
        if (a.bufferView >= 0 && (r = view_elements(l, where, a.bufferView, a.byteOffset, a.count, size, l.accessors[i])) != VXS_OK)
            return r;
        if (a.sparse.isSparse && (size_t)a.sparse.count > a.count)
            return l.error(VXS_E_SCENE, "%s: sparse count %d exceeds its %zu elements", where.c_str(), a.sparse.count, a.count);
    }
    return VXS_OK;
}

uint32_t unsigned_at(const unsigned char *at, size_t size)
{
    uint32_t value = 0;
    for (size_t i = 0; i < size; i++) value |= (uint32_t)at[i] << 8 * i;
    return value;
}

vxs_result overlay_sparse(loader &l, const std::string &where, const tinygltf::Accessor &a, elements &e)
{
    const auto &sparse = a.sparse;
    int         kind   = sparse.indices.componentType;
    size_t      count = (size_t)sparse.count, last = 0;
    elements    indices = {}, values = {};
    vxs_result  r;
    if (kind != TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE && kind != TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT &&
        kind != TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT)
        return l.error(VXS_E_SCENE, "%s: sparse indices of componentType %d", where.c_str(), kind);
    if ((r = view_elements(l, where + " sparse indices", sparse.indices.bufferView, (size_t)sparse.indices.byteOffset, count,
                           component_bytes(kind), indices)) != VXS_OK)
        return r;
    if ((r = view_elements(l, where + " sparse values", sparse.values.bufferView, (size_t)sparse.values.byteOffset, count, e.size,
                           values)) != VXS_OK)
        return r;
    for (size_t i = 0; i < count; i++) {
        size_t at = unsigned_at(indices.data + i * indices.stride, indices.size);
        if (at >= e.count || (i && at <= last))
            return l.error(VXS_E_SCENE, "%s: sparse index %zu is %zu, expected an increasing number below %zu", where.c_str(), i,
                           at, e.count);
        memcpy(e.dense.data() + at * e.size, values.data + i * values.stride, e.size);
        last = at;
    }
    return VXS_OK;
}

/* Where an accessor's elements are: in the buffer, or made dense once. */
vxs_result use_accessor(loader &l, int index, const elements *&out)
{
    elements                 &e = l.accessors[(size_t)index];
    const tinygltf::Accessor &a = l.model.accessors[(size_t)index];
    out                         = &e;
    if ((e.data && !a.sparse.isSparse) || !e.dense.empty() || !e.count) return VXS_OK;

    std::string where = label("accessor", (size_t)index, a.name);
    if (e.count > l.dense_left)
        return l.error(VXS_E_UNSUPPORTED, "%s: sparse accessors would hold more than %zu elements", where.c_str(), DENSE_MAX);
    l.dense_left -= e.count;
    e.dense.resize(e.count * e.size);
    for (size_t i = 0; e.data && i < e.count; i++) memcpy(e.dense.data() + i * e.size, e.data + i * e.stride, e.size);
    vxs_result r = a.sparse.isSparse ? overlay_sparse(l, where, a, e) : VXS_OK;
    e.data       = e.dense.data();
    e.stride     = e.size;
    return r;
}

/* ---- nodes (3.5) ---- */

vec3 rotate_scale(const transform &t, vec3 v)
{
    return {t.axis[0].x * v.x + t.axis[1].x * v.y + t.axis[2].x * v.z, t.axis[0].y * v.x + t.axis[1].y * v.y + t.axis[2].y * v.z,
            t.axis[0].z * v.x + t.axis[1].z * v.y + t.axis[2].z * v.z};
}

vec3 apply(const transform &t, vec3 v)
{
    vec3 p = rotate_scale(t, v);
    return {p.x + t.origin.x, p.y + t.origin.y, p.z + t.origin.z};
}

bool finite(vec3 v)
{
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

/* The triangles of a mirrored node turn their backs, unless two corners are swapped (3.7.4). */
bool is_mirrored(const transform &t)
{
    const vec3 *a = t.axis;
    return a[0].x * (a[1].y * a[2].z - a[1].z * a[2].y) - a[0].y * (a[1].x * a[2].z - a[1].z * a[2].x) +
               a[0].z * (a[1].x * a[2].y - a[1].y * a[2].x) <
           0;
}

vxs_result matrix_transform(loader &l, const std::string &where, const std::vector<double> &m, transform &t)
{
    if (std::fabs(m[3]) + std::fabs(m[7]) + std::fabs(m[11]) + std::fabs(m[15] - 1) > 1e-6)
        return l.error(VXS_E_SCENE, "%s: the last row of its matrix is not 0, 0, 0, 1", where.c_str());
    t = {{{m[0], m[1], m[2]}, {m[4], m[5], m[6]}, {m[8], m[9], m[10]}}, {m[12], m[13], m[14]}};
    return VXS_OK;
}

vxs_result node_transform(loader &l, size_t index, transform &t)
{
    const tinygltf::Node &node  = l.model.nodes[index];
    std::string           where = label("node", index, node.name);
    if (!node.matrix.empty()) return matrix_transform(l, where, node.matrix, t);

    double x = 0, y = 0, z = 0, w = 1, sx = 1, sy = 1, sz = 1;
    if (!node.rotation.empty()) x = node.rotation[0], y = node.rotation[1], z = node.rotation[2], w = node.rotation[3];
    if (!node.scale.empty()) sx = node.scale[0], sy = node.scale[1], sz = node.scale[2];
    double length = std::sqrt(x * x + y * y + z * z + w * w);
    if (!(length > 0) || !std::isfinite(length))
        return l.error(VXS_E_SCENE, "%s: its rotation is not a unit quaternion", where.c_str());
    x /= length, y /= length, z /= length, w /= length;

    t.axis[0] = {sx * (1 - 2 * (y * y + z * z)), sx * 2 * (x * y + z * w), sx * 2 * (x * z - y * w)};
    t.axis[1] = {sy * 2 * (x * y - z * w), sy * (1 - 2 * (x * x + z * z)), sy * 2 * (y * z + x * w)};
    t.axis[2] = {sz * 2 * (x * z + y * w), sz * 2 * (y * z - x * w), sz * (1 - 2 * (x * x + y * y))};
    t.origin  = {0, 0, 0};
    if (!node.translation.empty()) t.origin = {node.translation[0], node.translation[1], node.translation[2]};
    return VXS_OK;
}

/* Nodes form a forest: every child exists and has one parent, and every node hangs from a root. */
vxs_result check_tree(loader &l, std::vector<int> &parent)
{
    const auto &nodes = l.model.nodes;
    parent.assign(nodes.size(), -1);
    for (size_t i = 0; i < nodes.size(); i++)
        for (int child : nodes[i].children) {
            if ((size_t)child >= nodes.size()) return l.error(VXS_E_SCENE, "node %zu: child %d does not exist", i, child);
            if (parent[(size_t)child] >= 0)
                return l.error(VXS_E_SCENE, "node %d has two parents, node %d and node %zu", child, parent[(size_t)child], i);
            parent[(size_t)child] = (int)i;
        }

    std::vector<char> reached(nodes.size(), 0);
    std::vector<int>  open;
    for (size_t i = 0; i < nodes.size(); i++)
        if (parent[i] < 0) open.push_back((int)i);
    while (!open.empty()) {
        size_t at = (size_t)open.back();
        open.pop_back();
        reached[at] = 1;
        open.insert(open.end(), nodes[at].children.begin(), nodes[at].children.end());
    }
    for (size_t i = 0; i < nodes.size(); i++)
        if (!reached[i]) return l.error(VXS_E_SCENE, "node %zu is in a loop of nodes", i);
    return VXS_OK;
}

vxs_result check_references(loader &l)
{
    const tinygltf::Model &model = l.model;
    for (size_t i = 0; i < model.nodes.size(); i++) {
        const tinygltf::Node &node  = model.nodes[i];
        auto                  use   = node.extensions.find("KHR_lights_punctual");
        int                   light = use == node.extensions.end() ? -1 : use->second.Get("light").GetNumberAsInt();
        struct {
            const char *kind;
            int         index;
            size_t      count;
        } references[] = {{"mesh", node.mesh, model.meshes.size()},
                          {"skin", node.skin, model.skins.size()},
                          {"camera", node.camera, model.cameras.size()},
                          {"light", light, model.lights.size()}};
        for (const auto &reference : references)
            if (reference.index >= 0 && (size_t)reference.index >= reference.count)
                return l.error(VXS_E_SCENE, "%s: %s %d does not exist, the file has %zu", label("node", i, node.name).c_str(),
                               reference.kind, reference.index, reference.count);
    }
    return VXS_OK;
}

/* The scene that is asked for: -1 when the file has none and all root nodes are meant. */
vxs_result choose_scene(loader &l, const char *which, int &chosen)
{
    const auto &scenes = l.model.scenes;
    chosen             = l.model.defaultScene >= 0 ? l.model.defaultScene : scenes.empty() ? -1 : 0;
    if (!which) {
        if (chosen >= 0 && (size_t)chosen >= scenes.size())
            return l.error(VXS_E_SCENE, "its default scene %d does not exist, the file has %zu", chosen, scenes.size());
        return VXS_OK;
    }
    for (size_t i = 0; i < scenes.size(); i++)
        if (*which && scenes[i].name == which) return chosen = (int)i, VXS_OK;

    size_t digits = strspn(which, "0123456789");
    if (digits && !which[digits] && digits < 10 && strtoul(which, nullptr, 10) < scenes.size())
        return chosen = (int)strtoul(which, nullptr, 10), VXS_OK;

    std::string known;
    for (size_t i = 0; i < scenes.size() && known.size() < 200; i++) known += (i ? ", " : ": ") + label("scene", i, scenes[i].name);
    return l.error(VXS_E_ARGUMENT, "no scene '%s'; the file has %zu%s", which, scenes.size(), known.c_str());
}

vxs_result choose_roots(loader &l, int chosen, const std::vector<int> &parent)
{
    if (chosen < 0) {
        for (size_t i = 0; i < parent.size(); i++)
            if (parent[i] < 0) l.roots.push_back((int)i);
        return VXS_OK;
    }
    std::set<int> seen;
    for (int node : l.model.scenes[(size_t)chosen].nodes) {
        if ((size_t)node >= parent.size()) return l.error(VXS_E_SCENE, "scene %d: node %d does not exist", chosen, node);
        if (parent[(size_t)node] >= 0)
            return l.error(VXS_E_SCENE, "scene %d: node %d is not a root, its parent is node %d", chosen, node,
                           parent[(size_t)node]);
        if (!seen.insert(node).second) return l.error(VXS_E_SCENE, "scene %d lists node %d twice", chosen, node);
        l.roots.push_back(node);
    }
    return VXS_OK;
}

/* Parents come before children, children in the file's order; no recursion, for trees may be deep. */
vxs_result place_nodes(loader &l, const std::vector<int> &parent)
{
    std::vector<int> open(l.roots.rbegin(), l.roots.rend());
    l.ws_from_node.resize(l.model.nodes.size());
    while (!open.empty()) {
        size_t at = (size_t)open.back();
        open.pop_back();
        transform &t = l.ws_from_node[at];
        vxs_result r = node_transform(l, at, t);
        if (r != VXS_OK) return r;
        if (parent[at] >= 0) {
            const transform &up = l.ws_from_node[(size_t)parent[at]];
            for (vec3 &axis : t.axis) axis = rotate_scale(up, axis);
            t.origin = apply(up, t.origin);
        }
        l.order.push_back((int)at);
        const auto &children = l.model.nodes[at].children;
        open.insert(open.end(), children.rbegin(), children.rend());
    }
    return VXS_OK;
}

/* ---- meshes (3.7) ---- */

int attribute(const std::map<std::string, int> &attributes, const char *name)
{
    auto found = attributes.find(name);
    return found == attributes.end() ? -1 : found->second;
}

vxs_result check_positions(loader &l, const std::string &where, int index, size_t count)
{
    if ((size_t)index >= l.accessors.size())
        return l.error(VXS_E_SCENE, "%s: POSITION accessor %d does not exist", where.c_str(), index);
    const tinygltf::Accessor &a    = l.model.accessors[(size_t)index];
    std::string               name = label("accessor", (size_t)index, a.name);
    if (a.type != TINYGLTF_TYPE_VEC3) return l.error(VXS_E_SCENE, "%s, %s: POSITION is not a VEC3", where.c_str(), name.c_str());
    if (a.componentType != TINYGLTF_COMPONENT_TYPE_FLOAT)
        return l.error(VXS_E_UNSUPPORTED, "%s, %s: POSITION is not of floats (KHR_mesh_quantization)", where.c_str(), name.c_str());
    if (a.count != count)
        return l.error(VXS_E_SCENE, "%s, %s: %zu elements, expected %zu", where.c_str(), name.c_str(), a.count, count);
    return VXS_OK;
}

vxs_result check_indices(loader &l, const std::string &where, int index)
{
    if ((size_t)index >= l.accessors.size())
        return l.error(VXS_E_SCENE, "%s: indices accessor %d does not exist", where.c_str(), index);
    const tinygltf::Accessor &a    = l.model.accessors[(size_t)index];
    std::string               name = label("accessor", (size_t)index, a.name);
    if (a.type != TINYGLTF_TYPE_SCALAR ||
        (a.componentType != TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE && a.componentType != TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT &&
         a.componentType != TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT))
        return l.error(VXS_E_SCENE, "%s, %s: indices are not unsigned scalars", where.c_str(), name.c_str());
    if (a.bufferView >= 0 && l.model.bufferViews[(size_t)a.bufferView].byteStride)
        return l.error(VXS_E_SCENE, "%s, %s: indices with a byteStride", where.c_str(), name.c_str());
    return VXS_OK;
}

/* The weights of a node's morph targets (3.7.2.2): its own, else the mesh's, else none. */
const std::vector<double> &morph_weights(const tinygltf::Node &node, const tinygltf::Mesh &mesh)
{
    return node.weights.empty() ? mesh.weights : node.weights;
}

bool makes_triangles(const tinygltf::Primitive &p)
{
    return p.mode >= TINYGLTF_MODE_TRIANGLES && p.mode <= TINYGLTF_MODE_TRIANGLE_FAN && attribute(p.attributes, "POSITION") >= 0;
}

size_t corner_count(const loader &l, const tinygltf::Primitive &p)
{
    return l.accessors[(size_t)(p.indices >= 0 ? p.indices : attribute(p.attributes, "POSITION"))].count;
}

size_t triangle_count(const loader &l, const tinygltf::Primitive &p)
{
    size_t corners = corner_count(l, p);
    return p.mode == TINYGLTF_MODE_TRIANGLES ? corners / 3 : corners < 3 ? 0 : corners - 2;
}

vxs_result check_primitive(loader &l, const std::string &where, const tinygltf::Primitive &p)
{
    if (p.mode > TINYGLTF_MODE_TRIANGLE_FAN) return l.error(VXS_E_SCENE, "%s: unknown mode %d", where.c_str(), p.mode);
    if (p.material >= 0 && (size_t)p.material >= l.model.materials.size())
        return l.error(VXS_E_SCENE, "%s: material %d does not exist", where.c_str(), p.material);
    if (!makes_triangles(p)) return VXS_OK;

    int        position = attribute(p.attributes, "POSITION");
    size_t     vertices = (size_t)position < l.accessors.size() ? l.accessors[(size_t)position].count : 0;
    vxs_result r        = check_positions(l, where, position, vertices);
    for (size_t i = 0; r == VXS_OK && i < p.targets.size(); i++)
        if (attribute(p.targets[i], "POSITION") >= 0)
            r = check_positions(l, where + " target " + std::to_string(i), attribute(p.targets[i], "POSITION"), vertices);
    if (r == VXS_OK && p.indices >= 0) r = check_indices(l, where, p.indices);
    return r;
}

vxs_result check_model_meshes(loader &l)
{
    for (size_t i = 0; i < l.model.meshes.size(); i++) {
        const tinygltf::Mesh &mesh = l.model.meshes[i];
        for (size_t k = 0; k < mesh.primitives.size(); k++) {
            std::string where = label("mesh", i, mesh.name) + " " + label("primitive", k, "");
            vxs_result  r     = check_primitive(l, where, mesh.primitives[k]);
            if (r != VXS_OK) return r;
        }
    }
    return VXS_OK;
}

vxs_result check_materials(loader &l)
{
    for (size_t i = 0; i < l.model.materials.size(); i++) {
        const std::string &mode = l.model.materials[i].alphaMode;
        if (mode != "" && mode != "OPAQUE" && mode != "MASK" && mode != "BLEND")
            return l.error(VXS_E_SCENE, "%s: unknown alphaMode '%s'", label("material", i, l.model.materials[i].name).c_str(),
                           mode.c_str());
    }
    return VXS_OK;
}

/* What is skipped or simplified, said once. */
void warn_about(loader &l, const tinygltf::Node &node, size_t &points, size_t &lines)
{
    const tinygltf::Mesh &mesh = l.model.meshes[(size_t)node.mesh];
    for (size_t i = 0; i < mesh.primitives.size(); i++) {
        const tinygltf::Primitive &p = mesh.primitives[i];
        if (p.mode == TINYGLTF_MODE_POINTS)
            points++;
        else if (p.mode < TINYGLTF_MODE_TRIANGLES)
            lines++;
        else if (!makes_triangles(p))
            warn(l.m, "%s %s has no POSITION: skipped", label("mesh", (size_t)node.mesh, mesh.name).c_str(),
                 label("primitive", i, "").c_str());
        else if (p.mode == TINYGLTF_MODE_TRIANGLES && corner_count(l, p) % 3)
            warn(l.m, "%s %s has %zu corners, not a multiple of 3: the last ones are ignored",
                 label("mesh", (size_t)node.mesh, mesh.name).c_str(), label("primitive", i, "").c_str(), corner_count(l, p));
        if (!p.targets.empty())
            warn(l.m, "%s has morph targets: baked at their default weights", label("mesh", (size_t)node.mesh, mesh.name).c_str());
        if (p.material < 0 || !makes_triangles(p)) continue;
        const tinygltf::Material &material = l.model.materials[(size_t)p.material];
        if (material.alphaMode == "MASK")
            warn(l.m, "%s is alpha-masked: baked as opaque",
                 material.name.empty() ? label("material", (size_t)p.material, "").c_str()
                                       : ("material '" + material.name + "'").c_str());
    }
    if (node.skin >= 0)
        warn(l.m, "%s: baked in rest pose, as its mesh is stored",
             label("skin", (size_t)node.skin, l.model.skins[(size_t)node.skin].name).c_str());
}

/* Count before allocating: instancing makes scenes much larger than files. */
vxs_result measure(loader &l)
{
    std::vector<size_t> of_mesh(l.model.meshes.size(), 0);
    for (size_t i = 0; i < of_mesh.size(); i++)
        for (const tinygltf::Primitive &p : l.model.meshes[i].primitives)
            if (makes_triangles(p)) of_mesh[i] += std::min(triangle_count(l, p), INDICES_MAX);

    size_t total = 0, points = 0, lines = 0;
    for (int index : l.order) {
        const tinygltf::Node &node = l.model.nodes[(size_t)index];
        if (node.mesh < 0) continue;
        if (node.extensions.count("EXT_mesh_gpu_instancing"))
            return l.error(VXS_E_UNSUPPORTED, "%s uses EXT_mesh_gpu_instancing", label("node", (size_t)index, node.name).c_str());
        warn_about(l, node, points, lines);
        total += of_mesh[(size_t)node.mesh];
        if (total > INDICES_MAX / 3) return l.error(VXS_E_UNSUPPORTED, "more than %zu triangles in the scene", INDICES_MAX / 3);
    }
    if (points) warn(l.m, "primitives of points skipped: %zu", points);
    if (lines) warn(l.m, "primitives of lines skipped: %zu", lines);
    if (!total) return VXS_OK;

    l.s->indices        = (uint32_t *)malloc(3 * total * sizeof(uint32_t));
    l.s->triangle_flags = (uint8_t *)malloc(total);
    return l.s->indices && l.s->triangle_flags ? VXS_OK : l.error(VXS_E_MEMORY, "out of memory for %zu triangles", total);
}

/* One primitive placed by one node. */
struct placement {
    const elements                                  *positions;
    const elements                                  *indices; /* NULL: 0, 1, 2, ... */
    std::vector<std::pair<double, const elements *>> targets; /* of weight not 0 */
    transform                                        ws_from_node;
    int                                              mode;
    bool                                             mirrored;
    size_t                                           triangles;
};

vec3 read_position(const elements &e, size_t index)
{
    float p[3];
    memcpy(p, e.data + index * e.stride, sizeof p);
    return {p[0], p[1], p[2]};
}

vec3 morphed_position(const placement &p, size_t index)
{
    vec3 v = read_position(*p.positions, index);
    for (const auto &[weight, target] : p.targets) {
        vec3 d = read_position(*target, index);
        v      = {v.x + weight * d.x, v.y + weight * d.y, v.z + weight * d.z};
    }
    return v;
}

/* The scene's vertex for an accessor's element; UINT32_MAX when it has no finite position or there is no memory. */
inline uint32_t vertex_of(loader &l, const placement &p, uint32_t index)
{
    loader::slot &slot = l.slots[index];
    if (slot.generation == l.generation) return slot.vertex;

    scene *s = l.s;
    if (s->vertex_count == l.vertex_capacity) {
        size_t  capacity = std::max((size_t)4096, 2 * l.vertex_capacity);
        double *grown    = (double *)realloc(s->positions_ws, 3 * capacity * sizeof(double));
        if (!grown) throw std::bad_alloc();
        s->positions_ws   = grown;
        l.vertex_capacity = capacity;
    }
    vec3 v = apply(p.ws_from_node, p.targets.empty() ? read_position(*p.positions, index) : morphed_position(p, index));
    if (!finite(v)) return UINT32_MAX;
    memcpy(s->positions_ws + 3 * s->vertex_count, &v, sizeof v);
    slot = {l.generation, (uint32_t)s->vertex_count++};
    return slot.vertex;
}

/* Corners of triangle t (3.7.2.1). */
inline void triangle_corners(int mode, size_t t, size_t corner[3])
{
    switch (mode) {
    case TINYGLTF_MODE_TRIANGLE_STRIP: corner[0] = t, corner[1] = t + 1 + t % 2, corner[2] = t + 2 - t % 2; break;
    case TINYGLTF_MODE_TRIANGLE_FAN: corner[0] = t + 1, corner[1] = t + 2, corner[2] = 0; break;
    default: corner[0] = 3 * t, corner[1] = 3 * t + 1, corner[2] = 3 * t + 2;
    }
}

template <typename T> inline uint32_t index_at(const elements *indices, size_t i)
{
    T value;
    memcpy(&value, indices->data + i * sizeof value, sizeof value);
    return value;
}

template <> inline uint32_t index_at<void>(const elements *, size_t i)
{
    return (uint32_t)i;
}

/* The first corner whose index is not below the limit, or the count of corners. */
template <typename T> size_t find_bad_index(const elements &indices, size_t limit)
{
    size_t i = 0;
    while (i < indices.count && index_at<T>(&indices, i) < limit) i++;
    return i;
}

/* Append the placement's triangles; false at a vertex without a finite position, whose element goes to `bad`. */
template <typename T> bool append_triangles(loader &l, const placement &p, uint32_t &bad)
{
    uint32_t *out = l.s->indices + 3 * l.s->triangle_count;
    for (size_t t = 0; t < p.triangles; t++, out += 3) {
        size_t corner[3];
        triangle_corners(p.mode, t, corner);
        if (p.mirrored) std::swap(corner[1], corner[2]);
        for (int i = 0; i < 3; i++) {
            uint32_t index = index_at<T>(p.indices, corner[i]);
            out[i]         = vertex_of(l, p, index);
            if (out[i] == UINT32_MAX) return bad = index, false;
        }
    }
    return true;
}

/* 3.7.2.1: no index may name a missing vertex or be the largest value of its type, which restarts primitives elsewhere. */
vxs_result check_index_values(loader &l, const placement &p, int accessor)
{
    const elements &e     = *p.indices;
    size_t          limit = std::min(p.positions->count, e.size == 4 ? (size_t)UINT32_MAX : ((size_t)1 << 8 * e.size) - 1);
    size_t          bad   = e.size == 1   ? find_bad_index<uint8_t>(e, limit)
                            : e.size == 2 ? find_bad_index<uint16_t>(e, limit)
                                          : find_bad_index<uint32_t>(e, limit);
    if (bad == e.count) return VXS_OK;
    return l.error(VXS_E_SCENE, "%s: index %zu is %u, expected less than %zu",
                   label("accessor", (size_t)accessor, l.model.accessors[(size_t)accessor].name).c_str(), bad,
                   unsigned_at(e.data + bad * e.stride, e.size), limit);
}

vxs_result explain_bad_vertex(loader &l, const placement &p, uint32_t vertex, size_t node_index, int position_accessor)
{
    if (!finite(read_position(*p.positions, vertex)))
        return l.error(VXS_E_SCENE, "%s: position %u is not finite",
                       label("accessor", (size_t)position_accessor, l.model.accessors[(size_t)position_accessor].name).c_str(),
                       vertex);
    return l.error(VXS_E_SCENE, "%s: a vertex of its mesh is not finite once placed",
                   label("node", node_index, l.model.nodes[node_index].name).c_str());
}

vxs_result open_placement(loader &l, const tinygltf::Node &node, const tinygltf::Primitive &primitive, placement &p)
{
    const tinygltf::Mesh      &mesh    = l.model.meshes[(size_t)node.mesh];
    const std::vector<double> &weights = morph_weights(node, mesh);
    vxs_result                 r       = use_accessor(l, attribute(primitive.attributes, "POSITION"), p.positions);
    if (r == VXS_OK && primitive.indices >= 0) r = use_accessor(l, primitive.indices, p.indices);
    if (r == VXS_OK && p.indices) r = check_index_values(l, p, primitive.indices);
    if (r == VXS_OK && !weights.empty() && weights.size() != primitive.targets.size())
        return l.error(VXS_E_SCENE, "%s: %zu weights for %zu morph targets", label("mesh", (size_t)node.mesh, mesh.name).c_str(),
                       weights.size(), primitive.targets.size());
    for (size_t i = 0; r == VXS_OK && i < weights.size(); i++) {
        int             accessor = attribute(primitive.targets[i], "POSITION");
        const elements *target   = nullptr;
        if (weights[i] == 0 || accessor < 0) continue;
        r = use_accessor(l, accessor, target);
        p.targets.push_back({weights[i], target});
    }
    return r;
}

uint8_t material_flags(const loader &l, int material)
{
    if (material < 0) return 0;
    const tinygltf::Material &m = l.model.materials[(size_t)material];
    return (uint8_t)((m.doubleSided ? TRIANGLE_DOUBLE_SIDED : 0) | (m.alphaMode == "MASK" ? TRIANGLE_ALPHA_MASK : 0));
}

/* Primitives that follow each other over one accessor share its vertices; `last_position` is what the slots hold. */
vxs_result place_primitive(loader &l, size_t node_index, const tinygltf::Primitive &primitive, int &last_position)
{
    const tinygltf::Node &node     = l.model.nodes[node_index];
    int                   position = attribute(primitive.attributes, "POSITION");
    placement             p        = {};
    p.ws_from_node                 = l.ws_from_node[node_index];
    p.mirrored                     = is_mirrored(p.ws_from_node);
    p.mode                         = primitive.mode;
    p.triangles                    = triangle_count(l, primitive);
    vxs_result r                   = open_placement(l, node, primitive, p);
    if (r != VXS_OK) return r;

    if (position != last_position || !p.targets.empty()) l.generation++;
    last_position = p.targets.empty() ? position : -1;
    if (l.slots.size() < p.positions->count) l.slots.resize(p.positions->count);

    uint32_t bad = 0;
    bool     ok  = !p.indices             ? append_triangles<void>(l, p, bad)
                   : p.indices->size == 1 ? append_triangles<uint8_t>(l, p, bad)
                   : p.indices->size == 2 ? append_triangles<uint16_t>(l, p, bad)
                                          : append_triangles<uint32_t>(l, p, bad);
    if (!ok) return explain_bad_vertex(l, p, bad, node_index, position);
    memset(l.s->triangle_flags + l.s->triangle_count, material_flags(l, primitive.material), p.triangles);
    l.s->triangle_count += p.triangles;
    return VXS_OK;
}

vxs_result place_meshes(loader &l)
{
    vxs_result r = measure(l);
    for (size_t i = 0; r == VXS_OK && i < l.order.size(); i++) {
        size_t node          = (size_t)l.order[i];
        int    last_position = -1;
        if (l.model.nodes[node].mesh < 0) continue;
        for (const tinygltf::Primitive &p : l.model.meshes[(size_t)l.model.nodes[node].mesh].primitives)
            if (makes_triangles(p) && triangle_count(l, p) && (r = place_primitive(l, node, p, last_position)) != VXS_OK) break;
    }
    if (r == VXS_OK && l.s->vertex_count) {
        double *fitted = (double *)realloc(l.s->positions_ws, 3 * l.s->vertex_count * sizeof(double));
        if (fitted) l.s->positions_ws = fitted;
    }
    return r;
}

/* ---- lights (KHR_lights_punctual) and cameras (3.10) ---- */

/* A name that no other light of the scene has: the second "lamp" becomes "lamp#2". */
std::string unique_name(std::map<std::string, size_t> &uses, const std::string &name)
{
    std::string candidate = name;
    for (size_t n = ++uses[name]; n > 1; n = ++uses[name]) {
        candidate = name + "#" + std::to_string(n);
        if (++uses[candidate] == 1) break;
    }
    return candidate;
}

vxs_result light_at(loader &l, size_t node_index, size_t light_index, scene_light &out)
{
    const tinygltf::Light &light = l.model.lights[light_index];
    const transform       &t     = l.ws_from_node[node_index];
    std::string            where = label("node", node_index, l.model.nodes[node_index].name);
    if (light.type == "directional")
        out.shape.kind = LIGHT_DIRECTIONAL;
    else if (light.type == "spot")
        out.shape.kind = LIGHT_SPOT;
    else if (light.type == "point")
        out.shape.kind = LIGHT_POINT;
    else
        return l.error(VXS_E_SCENE, "%s: unknown type '%s', expected directional, spot or point",
                       label("light", light_index, light.name).c_str(), light.type.c_str());

    vec3   forward = {-t.axis[2].x, -t.axis[2].y, -t.axis[2].z};
    double length  = std::hypot(forward.x, forward.y, forward.z);
    if (out.shape.kind != LIGHT_POINT && (!(length > 0) || !std::isfinite(length)))
        return l.error(VXS_E_SCENE, "%s: its light has no direction", where.c_str());
    if (!finite(t.origin)) return l.error(VXS_E_SCENE, "%s: its light is at infinity", where.c_str());
    if (!(length > 0) || !std::isfinite(length)) forward = {0, 0, -1}, length = 1;
    double position[3]  = {t.origin.x, t.origin.y, t.origin.z};
    double direction[3] = {forward.x / length, forward.y / length, forward.z / length};
    memcpy(out.shape.position_ws, position, sizeof position);
    memcpy(out.shape.direction_ws, direction, sizeof direction);
    out.shape.outer_rad = light.spot.outerConeAngle;
    out.shape.range_m   = light.range > 0 ? light.range : INFINITY;
    return VXS_OK;
}

vxs_result place_lights(loader &l)
{
    std::map<std::string, size_t> uses;
    std::vector<scene_light>      lights;
    std::vector<std::string>      names;
    for (int node : l.order) {
        const auto &extensions = l.model.nodes[(size_t)node].extensions;
        auto        use        = extensions.find("KHR_lights_punctual");
        if (use == extensions.end()) continue;
        size_t      index = (size_t)use->second.Get("light").GetNumberAsInt();
        std::string name  = l.model.lights[index].name;
        scene_light light = {};
        vxs_result  r     = light_at(l, (size_t)node, index, light);
        if (r != VXS_OK) return r;
        names.push_back(unique_name(uses, name.empty() ? "light" + std::to_string(index) : name));
        lights.push_back(light);
    }
    if (lights.empty()) return VXS_OK;

    l.s->lights = (scene_light *)calloc(lights.size(), sizeof *l.s->lights);
    if (!l.s->lights) throw std::bad_alloc();
    for (size_t i = 0; i < lights.size(); i++) {
        l.s->lights[i]      = lights[i];
        l.s->lights[i].name = strdup(names[i].c_str());
        l.s->light_count    = i + 1;
        if (!l.s->lights[i].name) throw std::bad_alloc();
    }
    return VXS_OK;
}

vxs_result place_cameras(loader &l)
{
    std::vector<double> positions;
    for (int index : l.order) {
        const tinygltf::Node &node = l.model.nodes[(size_t)index];
        const vec3           &at   = l.ws_from_node[(size_t)index].origin;
        if (node.camera < 0) continue;
        if (!finite(at))
            return l.error(VXS_E_SCENE, "%s: its camera is at infinity", label("node", (size_t)index, node.name).c_str());
        positions.insert(positions.end(), {at.x, at.y, at.z});
    }
    if (positions.empty()) return VXS_OK;

    l.s->camera_positions_ws = (double *)malloc(positions.size() * sizeof(double));
    if (!l.s->camera_positions_ws) throw std::bad_alloc();
    memcpy(l.s->camera_positions_ws, positions.data(), positions.size() * sizeof(double));
    l.s->camera_count = positions.size() / 3;
    return VXS_OK;
}

/* ---- the whole ---- */

vxs_result load(loader &l, const char *which)
{
    std::vector<int> parent;
    int              chosen;
    vxs_result       r;
    if ((r = parse(l)) != VXS_OK) return r;
    if ((r = check_accessors(l)) != VXS_OK) return r;
    if ((r = check_materials(l)) != VXS_OK) return r;
    if ((r = check_model_meshes(l)) != VXS_OK) return r;
    if ((r = check_references(l)) != VXS_OK) return r;
    if ((r = check_tree(l, parent)) != VXS_OK) return r;
    if ((r = choose_scene(l, which, chosen)) != VXS_OK) return r;
    if ((r = choose_roots(l, chosen, parent)) != VXS_OK) return r;
    if ((r = place_nodes(l, parent)) != VXS_OK) return r;
    if ((r = place_meshes(l)) != VXS_OK) return r;
    if ((r = place_lights(l)) != VXS_OK) return r;
    if ((r = place_cameras(l)) != VXS_OK) return r;
    l.s->name = strdup(chosen < 0 ? "" : l.model.scenes[(size_t)chosen].name.c_str());
    return l.s->name ? VXS_OK : l.error(VXS_E_MEMORY, "out of memory");
}

} // namespace

extern "C" vxs_result scene_load_gltf(scene *s, const char *path, const char *which, message *m)
{
    vxs_result r;
    memset(s, 0, sizeof *s);
    try {
        loader l;
        l.m    = m;
        l.path = path;
        l.s    = s;
        r      = load(l, which);
    } catch (const std::bad_alloc &) {
        r = fail(m, VXS_E_MEMORY, "'%s': out of memory", path);
    } catch (const std::length_error &) {
        r = fail(m, VXS_E_MEMORY, "'%s': out of memory", path);
    } catch (const std::exception &e) {
        r = fail(m, VXS_E_SCENE, "'%s': %s", path, one_line(e.what()).c_str());
    } catch (...) {
        r = fail(m, VXS_E_SCENE, "'%s': cannot be parsed", path);
    }
    if (r != VXS_OK) scene_free(s);
    return r;
}
