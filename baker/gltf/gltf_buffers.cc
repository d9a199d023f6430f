/* Buffers and bufferViews (3.6.1), and files beside the scene.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/gltf/gltf_loader.h"

#include "baker/files/run_files.h"

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

/* Where the file is that a uri names: beside the scene. */
static std::string path_beside(const loader &l, const std::string &uri)
{
    return l.folder + percent_decoded(uri);
}

static bool is_data(const std::string &uri)
{
    return uri.rfind("data:", 0) == 0;
}

static void check_file_beside(loader &l, const std::string &what, const json &object)
{
    auto               found = object.find("uri");
    const std::string *uri   = found == object.end() ? nullptr : found->get_ptr<const std::string *>();
    if (!uri || uri->empty() || is_data(*uri)) return;
    std::string path = path_beside(l, *uri);
    if (path == "-") path = "./-"; /* a file, not standard input */
    vxs_result r = run_files_check_input(path.c_str(), (what + " of '" + l.path + "'").c_str(), l.m);
    if (r != VXS_OK) throw failure{r};
}

void check_files_beside(loader &l, const json &root)
{
    size_t index = 0;
    if (!l.files_beside) return;
    for (const json &object : items(root, "buffers")) check_file_beside(l, label("buffer", index++), object);
    index = 0;
    for (const json &object : items(root, "images")) check_file_beside(l, label("image", index++), object);
}

file_bytes read_beside(loader &l, const std::string &what, const std::string &uri, size_t limit)
{
    std::string path = path_beside(l, uri);
    if (path.find('\0') != std::string::npos) l.broken(what, "uri '%s' holds a zero byte", uri.c_str());
    if (!l.files_beside)
        l.error(VXS_E_READ, "%s is in another file, '%s', and only this one is read", what.c_str(), percent_decoded(uri).c_str());
    int        reason;
    file_bytes found = read_bytes(l, path.c_str(), limit, true, reason);
    if (reason) l.error(VXS_E_READ, "cannot read %s, '%s': %s", what.c_str(), path.c_str(), strerror(reason));
    return found;
}

bool decode_base64(const std::string &text, file_bytes &out)
{
    std::string kind;
    bytes       decoded;
    if (!tinygltf::DecodeDataURI(&decoded, kind, "data:application/octet-stream;base64," + text, 0, false)) return false;
    out.assign(decoded.begin(), decoded.end());
    return true;
}

static bool is_fallback(const json &object)
{
    for (const char *name : {"EXT_meshopt_compression", "KHR_meshopt_compression"}) {
        const json *e = extension(object, name);
        if (e && e->value("fallback", json()) == true) return true;
    }
    return false;
}

static void read_buffer(loader &l, const json &object, const container &c, size_t index)
{
    buffer     &b     = l.buffers[index];
    std::string where = label("buffer", index), uri = object.value("uri", ""), source = "the GLB chunk";
    size_t      found = c.bin_size;
    b.size_bytes      = object["byteLength"].get<size_t>();
    if (!b.size_bytes) l.broken(where, "byteLength is 0");
    if (is_fallback(object)) return;

    if (uri.empty()) {
        b.missing = !c.bin || index;
        if (b.missing) return;
        b.data = c.bin;
    } else {
        if (is_data(uri)) {
            if (!tinygltf::IsDataURI(uri) || uri.rfind("data:image/", 0) == 0)
                l.broken(where, "'%.40s' is not a base64 data URI of a buffer", uri.c_str());
            l.need(3 * uri.size(), where);
            decode_base64(uri.substr(uri.find(',') + 1), b.owned);
            source = "its data URI";
        } else {
            b.owned = read_beside(l, where, uri, b.size_bytes);
            source  = "'" + uri + "'";
        }
        b.data = b.owned.data();
        found  = b.owned.size();
    }
    /* bytes after the promised ones are not read */
    if (found < b.size_bytes) l.broken(where, "%s ends after %zu bytes, expected %zu", source.c_str(), found, b.size_bytes);
}

void read_buffers(loader &l, const json &root, const container &c)
{
    l.buffers.resize(items(root, "buffers").size());
    for (size_t i = 0; i < l.buffers.size(); i++) read_buffer(l, root["buffers"][i], c, i);
}

void check_buffers(loader &l)
{
    for (size_t i = 0; i < l.buffers.size(); i++)
        if (l.buffers[i].missing) l.broken("", "buffer %zu has neither a uri nor a GLB chunk", i);
}

void check_in_buffer(loader &l, const std::string &where, size_t length, size_t offset, size_t index)
{
    size_t size = l.buffers[index].size_bytes;
    if (!length || offset > size || length > size - offset)
        l.broken(where, "%zu bytes at byte %zu do not fit in buffer %zu of %zu bytes", length, offset, index, size);
}

static void read_buffer_view(loader &l, size_t index, const json &object)
{
    buffer_view &v     = l.views[index];
    std::string  where = label("bufferView", index);
    v.buffer           = object["buffer"].get<size_t>();
    v.offset           = object.value("byteOffset", (size_t)0);
    v.length           = object["byteLength"].get<size_t>();
    v.stride           = object.value("byteStride", (size_t)0);
    if (v.buffer >= l.buffers.size()) l.broken(where, "buffer %zu does not exist", v.buffer);
    if (!v.length) l.broken(where, "byteLength is 0");
    check_in_buffer(l, where, v.length, v.offset, v.buffer);
    read_compressed_view(l, where, object, v.compressed);
    if (v.compressed.extension) return;
    if (v.stride && (v.stride < 4 || v.stride > 252 || v.stride % 4))
        l.broken(where, "byteStride is %zu, expected a multiple of 4 from 4 to 252", v.stride);
    if (v.stride && object.value("target", json()) == TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER)
        l.broken(where, "a byteStride, but its target is indices");
}

void read_buffer_views(loader &l, const json &root)
{
    l.views.resize(items(root, "bufferViews").size());
    for (size_t i = 0; i < l.views.size(); i++) read_buffer_view(l, i, root["bufferViews"][i]);
}

void check_view_index(loader &l, const std::string &where, size_t view)
{
    if (view >= l.views.size()) l.broken(where, "bufferView %zu does not exist", view);
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

} // namespace gltf
