/* Buffers and bufferViews (3.6.1), and files beside the scene.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <algorithm>
#include <cerrno>
#include <dirent.h>
#include <set>
#include <strings.h>
#include <sys/stat.h>

#include "baker/files/file_access.h"
#include "baker/files/run_files.h"
#include "baker/scene/gltf/gltf_loader.h"

namespace gltf
{

static std::string percent_decoded(const std::string &uri)
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

static bool begins_with(const std::string &text, const char *lower)
{
    return !strncasecmp(text.c_str(), lower, strlen(lower));
}

/* ---- files beside the scene ---- */

static bool is_there(const loader &l, const std::string &path)
{
    struct stat status;
    if (!l.files_beside || path.find('\0') != std::string::npos) return false;
    const file_access *access = l.m->access;
    const std::string  name   = l.folder + path;
    return access ? access->size(access->user, name.c_str()) != FILE_ACCESS_MISSING : !stat(name.c_str(), &status);
}

/* The file of a URI, relative to the scene's folder. Some exporters do not percent-encode names, or write backslashes as
 * separators; these forms are tried if the file by the standard does not exist. */
static std::string file_of(const loader &l, const std::string &uri)
{
    std::string path = percent_decoded(begins_with(uri, "file://") ? uri.substr(7) : uri), slashed = path;
    if (is_there(l, path)) return path;
    std::replace(slashed.begin(), slashed.end(), '\\', '/');
    if (is_there(l, slashed)) return slashed;
    return is_there(l, uri) ? uri : path;
}

static std::string path_beside(const loader &l, const std::string &file)
{
    return file[0] == '/' ? file : l.folder + file;
}

/* 1 when a path leaves the scene's folder. Symbolic links inside it are not checked: they are their owner's responsibility. */
static bool leads_out(const std::string &file)
{
    long depth = 0;
    if (file[0] == '/' || file[0] == '\\' || (isalpha((unsigned char)file[0]) && file[1] == ':')) return true;
    for (size_t begin = 0; begin <= file.size();) {
        size_t      end  = std::min(file.find_first_of("/\\", begin), file.size());
        std::string part = file.substr(begin, end - begin);
        depth += part == ".." ? -1 : !part.empty() && part != ".";
        if (depth < 0) return true;
        begin = end + 1;
    }
    return false;
}

bool is_data(const std::string &uri)
{
    return begins_with(uri, "data:");
}

void check_files_beside(loader &l, const json &root)
{
    if (!l.files_beside) return;
    for (auto [list, kind] : {std::pair("buffers", "buffer"), std::pair("images", "image")}) {
        size_t index = 0;
        for (const json &object : items(root, list)) {
            std::string        what  = label(kind, index++) + " of '" + l.path + "'";
            auto               found = object.find("uri");
            const std::string *uri   = found == object.end() ? nullptr : found->get_ptr<const std::string *>();
            if (!uri || uri->empty() || is_data(*uri)) continue;
            std::string path = path_beside(l, file_of(l, *uri));
            if (path == "-") path = "./-"; /* here "-" is a file name, not standard input */
            vxs_result r = run_files_check_input(path.c_str(), what.c_str(), l.m);
            if (r != VXS_OK) throw failure{r, "", true};
        }
    }
}

/* A file in the same folder whose name differs only in case: on other systems this is the same file. */
static std::string other_case(const std::string &path)
{
    char        folder[PATH_MAX];
    const char *name  = path_split(path.c_str(), folder);
    DIR        *files = name ? opendir(folder) : nullptr;
    std::string found;
    for (struct dirent *file; files && (file = readdir(files));)
        if (!strcasecmp(file->d_name, name) && (found.empty() || found > file->d_name)) found = file->d_name;
    if (files) closedir(files);
    return found;
}

file_bytes read_beside(loader &l, const std::string &what, const std::string &uri, size_t limit)
{
    std::string file = file_of(l, uri), path = path_beside(l, file), shown = shown_uri(file);
    if (path.find('\0') != std::string::npos) l.refused(what, "uri '%s' holds a zero byte", shown.c_str());
    for (const char *scheme : {"http:", "https:", "ftp:", "blob:"})
        if (begins_with(uri, scheme))
            l.refused(what, "'%s' is not a file: fetch it, and refer to it by its name beside the scene", shown.c_str());
    if (!l.files_beside) throw failure{VXS_E_READ, what + " is in another file, '" + shown + "', and only this one is read", true};
    if (leads_out(file) && !l.choice->allow_outside)
        throw failure{VXS_E_READ,
                      what + ": '" + shown +
                          "' is not in the scene's folder: --allow-outside reads it all the same, or put it beside the scene",
                      true};
    int        reason;
    file_bytes found = read_bytes(l, path.c_str(), limit, true, reason);
    if (!reason) return found;
    std::string text = "cannot read " + what + ", '" + shown_uri(path) + "': " + strerror(reason),
                near = reason == ENOENT && !l.m->access ? other_case(path) : "";
    throw failure{reason == ENOMEM ? VXS_E_MEMORY : VXS_E_READ, text + (near.empty() ? "" : "; there is '" + near + "': rename it"),
                  true};
}

/* Results of the visitor, and warnings that have become errors, end the visit; messages are set. */
static void go_on(loader &l, vxs_result r)
{
    if (r == VXS_OK) r = run_check(l.m);
    if (r != VXS_OK) throw failure{r, "", true};
}

void visit_files(loader &l, const json &root, scene_file_fn *visit, void *user)
{
    std::set<std::string> visited;
    check_files_beside(l, root);
    go_on(l, visit(user, nullptr, l.file.data(), l.file.size(), l.m));
    for (auto [list, kind] : {std::pair("buffers", "buffer"), std::pair("images", "image")}) {
        size_t index = 0;
        for (const json &object : items(root, list)) {
            std::string what = label(kind, index++), uri = text_of(object, "uri");
            file_bytes  bytes;
            if (uri.empty() || is_data(uri) || !visited.insert(uri).second) continue;
            failure f = caught([&] { bytes = read_beside(l, what, uri, FILE_BYTES_MAX); });
            if (f && !strcmp(kind, "buffer")) throw f;
            if (f)
                warn(l.m, "'%s': %s: it is left out", l.path, f.text.c_str());
            else
                go_on(l, visit(user, uri.c_str(), bytes.data(), bytes.size(), l.m));
        }
    }
    go_on(l, VXS_OK);
}

/* ---- data URIs (RFC 2397): data:[type][;parameter]...[;base64],data; the prefix is not case-sensitive ---- */

/* Decode base64. White space is ignored, and final padding may be missing. Returns the number of valid characters. */
static size_t decode_base64(const char *text, size_t size, file_bytes &out)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    uint32_t          bits     = 0;
    int               held     = 0;
    size_t            at       = 0;
    out.reserve(size / 4 * 3 + 3);
    for (; at < size && text[at] != '='; at++) {
        char c = text[at] == '-' ? '+' : text[at] == '_' ? '/' : text[at];
        if (isspace((unsigned char)c)) continue;
        const char *six = c ? strchr(digits, c) : nullptr;
        if (!six) return at;
        bits = bits << 6 | (uint32_t)(six - digits);
        held += 6;
        if (held < 8) continue;
        held -= 8;
        out.push_back((unsigned char)(bits >> held));
    }
    while (at < size && (text[at] == '=' || isspace((unsigned char)text[at]))) at++;
    return at;
}

file_bytes data_of(loader &l, const std::string &where, const std::string &uri)
{
    size_t     comma = uri.find(',');
    file_bytes out;
    if (comma == std::string::npos)
        l.broken(where, "'%s' is not a data URI: expected data:application/octet-stream;base64, and the data",
                 shown_uri(uri).c_str());
    std::string head = uri.substr(0, comma);
    while (!head.empty() && isspace((unsigned char)head.back())) head.pop_back();
    bool        is_base64 = head.size() >= 7 && begins_with(head.substr(head.size() - 7), ";base64");
    bool        encoded   = uri.find('%', comma) != std::string::npos;
    std::string text      = encoded ? percent_decoded(uri.substr(comma + 1)) : std::string();
    const char *from      = encoded ? text.data() : uri.data() + comma + 1;
    size_t      size      = encoded ? text.size() : uri.size() - comma - 1;
    if (!is_base64) {
        out.assign(from, from + size);
        return out;
    }
    size_t good = decode_base64(from, size, out);
    if (good < size) l.broken(where, "its data URI has a character that is no base64, %zu behind the comma", good);
    return out;
}

/* Read the bytes of a buffer. `there` stays 0 if none can be read. */
static void read_buffer(loader &l, const json &object, const container &c, size_t index)
{
    buffer     &b     = l.buffers[index];
    std::string where = label("buffer", index);
    if (l.faults[BUFFERS].count(index)) throw l.faults[BUFFERS][index];
    std::string uri = object.value("uri", ""), source = "the GLB chunk";
    size_t      found = c.bin_size;
    b.size_bytes      = object["byteLength"].get<size_t>();
    if (!b.size_bytes) l.broken(where, "byteLength is 0");
    for (const char *name : {"EXT_meshopt_compression", "KHR_meshopt_compression"}) {
        const json *e = extension(object, name);
        if (e && e->value("fallback", json()) == true) return;
    }

    if (uri.empty()) {
        if (!c.bin || index) l.broken("", "buffer %zu has neither a uri nor a GLB chunk", index);
        b.data = c.bin;
    } else {
        if (is_data(uri)) {
            l.need(3 * uri.size(), where);
            b.owned = data_of(l, where, uri);
            source  = "its data URI";
        } else {
            b.owned = read_beside(l, where, uri, b.size_bytes);
            source  = "'" + shown_uri(uri) + "'";
        }
        b.data = b.owned.data();
        found  = b.owned.size();
    }
    b.there = std::min(found, b.size_bytes);
    /* bytes beyond the declared length are ignored */
    if (found < b.size_bytes) l.broken(where, "%s ends after %zu bytes, expected %zu", source.c_str(), found, b.size_bytes);
}

void read_buffers(loader &l, const json &root, const container &c)
{
    l.buffers.resize(items(root, "buffers").size());
    for (size_t i = 0; i < l.buffers.size(); i++) l.buffers[i].fault = caught([&] { read_buffer(l, root["buffers"][i], c, i); });
}

void check_there(loader &l, size_t index, size_t offset, size_t size)
{
    const buffer &b = l.buffers[index];
    if (b.fault && (offset > b.there || size > b.there - offset)) throw b.fault;
}

void check_in_buffer(loader &l, const std::string &where, size_t length, size_t offset, size_t index)
{
    const buffer &b = l.buffers[index];
    if (b.fault && !b.size_bytes) throw b.fault;
    if (!length || offset > b.size_bytes || length > b.size_bytes - offset)
        l.broken(where, "%zu bytes at byte %zu do not fit in buffer %zu of %zu bytes", length, offset, index, b.size_bytes);
}

void read_buffer_views(loader &l, const json &root)
{
    l.views.resize(items(root, "bufferViews").size());
    for (size_t i = 0; i < l.views.size(); i++) {
        const json  &object = root["bufferViews"][i];
        buffer_view &v      = l.views[i];
        std::string  where  = label("bufferView", i);
        v.fault             = caught([&] {
            if (l.faults[VIEWS].count(i)) throw l.faults[VIEWS][i];
            v.buffer = object["buffer"].get<size_t>();
            v.offset = object.value("byteOffset", (size_t)0);
            v.length = object["byteLength"].get<size_t>();
            v.stride = object.value("byteStride", (size_t)0);
            if (v.buffer >= l.buffers.size()) l.broken(where, "buffer %zu does not exist", v.buffer);
            if (!v.length) l.broken(where, "byteLength is 0");
            check_in_buffer(l, where, v.length, v.offset, v.buffer);
            read_compressed_view(l, where, object, v.compressed);
            if (v.compressed.extension) check_there(l, v.compressed.buffer, v.compressed.offset, v.compressed.length);
        });
    }
}

void check_view_index(loader &l, const std::string &where, size_t view)
{
    if (view >= l.views.size()) l.broken(where, "bufferView %zu does not exist", view);
    if (l.views[view].fault) throw l.views[view].fault;
}

const unsigned char *view_bytes(loader &l, size_t index)
{
    buffer_view &v = l.views[index];
    if (v.compressed.extension) {
        if (v.decoded.empty()) decode_view(l, index);
        return v.decoded.data();
    }
    if (!l.buffers[v.buffer].data)
        l.broken("", "bufferView %zu is not compressed, and its buffer %zu holds nothing but a fallback", index, v.buffer);
    return l.buffers[v.buffer].data + v.offset;
}

const unsigned char *whole_view(loader &l, const std::string &where, size_t index)
{
    check_view_index(l, where, index);
    const buffer_view &v = l.views[index];
    if (!v.compressed.extension) check_there(l, v.buffer, v.offset, v.length);
    return view_bytes(l, index);
}

/* Accessors (3.6): their elements, checked against bufferViews and buffers. */

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

bool is_unsigned(int component)
{
    return component == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE || component == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ||
           component == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
}

/* Check that `count` elements of `size` bytes from `offset` are inside a bufferView, and inside the available part of its buffer.
 * Returns the stride. */
static size_t check_extent(loader &l, const std::string &where, int index, size_t offset, size_t count, size_t size)
{
    check_view_index(l, where, (size_t)index);
    const buffer_view &view   = l.views[index];
    size_t             stride = view.stride ? view.stride : size;
    if (stride < size) l.broken(where, "byteStride %zu is less than its elements of %zu bytes", stride, size);
    if (offset > view.length || count > SIZE_MAX / 256 ||
        (count && (view.length - offset < size || (count - 1) > (view.length - offset - size) / stride)))
        l.broken(where, "%zu elements at byte %zu do not fit in bufferView %d of %zu bytes", count, offset, index, view.length);
    if (count && !view.compressed.extension) check_there(l, view.buffer, view.offset + offset, (count - 1) * stride + size);
    return stride;
}

static void check_accessor(loader &l, const tinygltf::Accessor &a, elements &e)
{
    size_t index = l.accessors.size();
    if (l.faults[ACCESSORS].count(index)) throw l.faults[ACCESSORS][index];
    e.component      = a.componentType;
    e.component_size = component_bytes(a.componentType);
    size_t rows      = a.type == TINYGLTF_TYPE_MAT2 ? 2 : a.type == TINYGLTF_TYPE_MAT3 ? 3 : a.type == TINYGLTF_TYPE_MAT4 ? 4 : 0;
    e.size           = (size_t)tinygltf::GetNumComponentsInType((uint32_t)a.type) * e.component_size;
    if (rows) e.size = rows * ((rows * e.component_size + 3) / 4 * 4); /* columns start at multiples of four bytes (3.6.2.4) */
    e.stride = e.size;
    if (a.bufferView >= 0) e.stride = check_extent(l, e.label, a.bufferView, a.byteOffset, a.count, e.size);
    if (a.sparse.isSparse && (size_t)a.sparse.count > a.count)
        l.broken(e.label, "sparse count %d exceeds its %zu elements", a.sparse.count, a.count);
}

void check_accessors(loader &l)
{
    for (const tinygltf::Accessor &a : l.model.accessors) {
        elements e   = {};
        e.label      = label("accessor", l.accessors.size(), a.name);
        e.count      = a.count;
        e.type       = a.type;
        e.normalized = a.normalized;
        e.fault      = caught([&] { check_accessor(l, a, e); });
        l.accessors.push_back(std::move(e));
    }
}

const elements &sound_accessor(loader &l, const std::string &where, const char *what, int index)
{
    if (index < 0 || (size_t)index >= l.accessors.size()) l.broken(where, "%s accessor %d does not exist", what, index);
    if (l.accessors[index].fault) throw l.accessors[index].fault;
    return l.accessors[index];
}

double elements::value(size_t i, size_t k) const
{
    const unsigned char *at = data + i * stride + k * component_size;
    float                real;
    int16_t              s16;
    uint16_t             u16;
    switch (component) {
    case TINYGLTF_COMPONENT_TYPE_BYTE: return normalized ? std::max((signed char)*at / 127.0, -1.0) : (signed char)*at;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE: return normalized ? *at / 255.0 : *at;
    case TINYGLTF_COMPONENT_TYPE_SHORT: memcpy(&s16, at, sizeof s16); return normalized ? std::max(s16 / 32767.0, -1.0) : s16;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT: memcpy(&u16, at, sizeof u16); return normalized ? u16 / 65535.0 : u16;
    default: memcpy(&real, at, sizeof real); return real;
    }
}

/* `count` elements of `size` bytes from `offset` in a bufferView. */
static elements view_elements(loader &l, const std::string &where, int view, int offset, size_t count, size_t size)
{
    elements e = {};
    e.size     = size;
    e.stride   = check_extent(l, where, view, (size_t)offset, count, size);
    e.data     = view_bytes(l, (size_t)view) + offset;
    return e;
}

/* Store the elements densely, with those of a sparse accessor in their places. */
static void make_dense(loader &l, const tinygltf::Accessor &a, elements &e)
{
    if (e.count > l.dense_left) l.refused(e.label, "sparse accessors would hold more than %zu elements", DENSE_MAX);
    l.dense_left -= e.count;
    l.need(e.count * e.size, e.label);
    e.dense.resize(e.count * e.size);
    for (size_t i = 0; e.data && i < e.count; i++) memcpy(e.dense.data() + i * e.size, e.data + i * e.stride, e.size);
    e.data   = e.dense.data();
    e.stride = e.size;
    if (!a.sparse.isSparse) return;

    const auto &at     = a.sparse.indices;
    const auto &values = a.sparse.values;
    size_t      count = (size_t)a.sparse.count, last = 0;
    if (!is_unsigned(at.componentType)) l.broken(e.label, "sparse indices of componentType %d", at.componentType);
    elements indices =
        view_elements(l, e.label + " sparse indices", at.bufferView, at.byteOffset, count, component_bytes(at.componentType));
    elements replaced = view_elements(l, e.label + " sparse values", values.bufferView, values.byteOffset, count, e.size);
    for (size_t i = 0; i < count; i++) {
        size_t index = indices.index(i);
        if (index >= e.count || (i && index <= last))
            l.broken(e.label, "sparse index %zu is %zu, expected an increasing number below %zu", i, index, e.count);
        memcpy(e.dense.data() + index * e.size, replaced.data + i * replaced.stride, e.size);
        last = index;
    }
}

const elements &use_accessor(loader &l, size_t index)
{
    elements                 &e = l.accessors[index];
    const tinygltf::Accessor &a = l.model.accessors[index];
    if (e.fault) throw e.fault;
    if (e.ready) return e;
    if (a.bufferView >= 0) e.data = view_bytes(l, a.bufferView) + a.byteOffset;
    if (a.sparse.isSparse || a.bufferView < 0) make_dense(l, a, e);
    e.ready = true;
    return e;
}

/* The largest value of a type restarts strips and fans. In triangle lists it is an ordinary index, if that vertex exists. */
void check_index_values(loader &l, const elements &e, size_t vertices, bool restarts)
{
    size_t largest = e.size == 4 ? (size_t)UINT32_MAX : ((size_t)1 << 8 * e.size) - 1;
    size_t limit   = restarts ? std::min(vertices, largest) : vertices;
    size_t below = e.indices_below, bad = 0;
    if (!below)
        for (size_t i = 0; i < e.count; i++) below = std::max(below, (size_t)e.index(i) + 1);
    e.indices_below = below;
    if (below <= limit) return;
    while (e.index(bad) < limit) bad++;
    l.broken(e.label, "index %zu is %u, expected less than %zu", bad, e.index(bad), limit);
}

} // namespace gltf
