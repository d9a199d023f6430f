/* Buffers and bufferViews (3.6.1), and files beside the scene.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/gltf/gltf_loader.h"

#include <nlohmann/json.hpp>

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

vxs_result read_beside(loader &l, const std::string &what, const std::string &uri, size_t limit, std::vector<unsigned char> &bytes)
{
    std::string name = percent_decoded(uri), folder = l.path;
    if (name.find('\0') != std::string::npos)
        return l.error(VXS_E_SCENE, "%s: uri '%s' holds a zero byte", what.c_str(), uri.c_str());
    if (!l.files_beside)
        return l.error(VXS_E_READ, "%s is in another file, '%s', and only this one is read", what.c_str(), name.c_str());
    folder.erase(folder.rfind('/') == std::string::npos ? 0 : folder.rfind('/') + 1);
    int reason = read_bytes((folder + name).c_str(), limit, true, bytes);
    if (reason) return l.error(VXS_E_READ, "cannot read %s, '%s': %s", what.c_str(), (folder + name).c_str(), strerror(reason));
    return VXS_OK;
}

bool decode_base64(const std::string &text, std::vector<unsigned char> &bytes)
{
    std::string kind;
    return tinygltf::DecodeDataURI(&bytes, kind, "data:application/octet-stream;base64," + text, 0, false);
}

/* Bytes after the promised ones are not read. */
static vxs_result check_length(loader &l, const std::string &where, const char *what, size_t found, size_t promised)
{
    if (found >= promised) return VXS_OK;
    return l.error(VXS_E_SCENE, "%s: %s ends after %zu bytes, expected %zu", where.c_str(), what, found, promised);
}

static bool is_fallback(const json &object)
{
    for (const char *name : {"EXT_meshopt_compression", "KHR_meshopt_compression"}) {
        const json *e = extension(object, name);
        if (e && e->value("fallback", json()) == true) return true;
    }
    return false;
}

static vxs_result read_buffer(loader &l, const std::string &where, const json &object, const container &c, size_t index, buffer &b)
{
    std::string uri = object.value("uri", "");
    vxs_result  r;
    b.size_bytes = object["byteLength"].get<size_t>();
    if (!b.size_bytes) return l.error(VXS_E_SCENE, "%s: byteLength is 0", where.c_str());
    if (is_fallback(object)) return VXS_OK;

    if (uri.empty()) {
        b.missing = !c.bin || index;
        if (b.missing) return VXS_OK;
        b.data = c.bin;
        return check_length(l, where, "the GLB chunk", c.bin_size, b.size_bytes);
    }
    if (uri.rfind("data:", 0) == 0) {
        if (!tinygltf::IsDataURI(uri) || uri.rfind("data:image/", 0) == 0)
            return l.error(VXS_E_SCENE, "%s: '%.40s' is not a base64 data URI of a buffer", where.c_str(), uri.c_str());
        decode_base64(uri.substr(uri.find(',') + 1), b.owned);
        r = check_length(l, where, "its data URI", b.owned.size(), b.size_bytes);
    } else {
        if ((r = read_beside(l, where, uri, b.size_bytes, b.owned)) != VXS_OK) return r;
        r = check_length(l, where, ("'" + uri + "'").c_str(), b.owned.size(), b.size_bytes);
    }
    b.data = b.owned.data();
    return r;
}

vxs_result read_buffers(loader &l, const json &root, const container &c)
{
    l.buffers.resize(items(root, "buffers").size());
    for (size_t i = 0; i < l.buffers.size(); i++) {
        vxs_result r = read_buffer(l, label("buffer", i, ""), root["buffers"][i], c, i, l.buffers[i]);
        if (r != VXS_OK) return r;
    }
    return VXS_OK;
}

vxs_result check_buffers(loader &l)
{
    for (size_t i = 0; i < l.buffers.size(); i++)
        if (l.buffers[i].missing) return l.error(VXS_E_SCENE, "buffer %zu has neither a uri nor a GLB chunk", i);
    return VXS_OK;
}

static vxs_result read_buffer_view(loader &l, size_t index, const json &object, buffer_view &v)
{
    std::string where = label("bufferView", index, "");
    v.buffer          = object["buffer"].get<size_t>();
    v.offset          = object.value("byteOffset", (size_t)0);
    v.length          = object["byteLength"].get<size_t>();
    v.stride          = object.value("byteStride", (size_t)0);
    if (v.buffer >= l.buffers.size()) return l.error(VXS_E_SCENE, "%s: buffer %zu does not exist", where.c_str(), v.buffer);
    size_t bytes = l.buffers[v.buffer].size_bytes;
    if (!v.length) return l.error(VXS_E_SCENE, "%s: byteLength is 0", where.c_str());
    if (v.offset > bytes || v.length > bytes - v.offset)
        return l.error(VXS_E_SCENE, "%s: %zu bytes at byte %zu do not fit in buffer %zu of %zu bytes", where.c_str(), v.length,
                       v.offset, v.buffer, bytes);
    vxs_result r = read_compressed_view(l, where, object, v.compressed);
    if (r != VXS_OK || v.compressed.extension) return r;
    if (v.stride && (v.stride < 4 || v.stride > 252 || v.stride % 4))
        return l.error(VXS_E_SCENE, "%s: byteStride is %zu, expected a multiple of 4 from 4 to 252", where.c_str(), v.stride);
    if (v.stride && object.value("target", json()) == TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER)
        return l.error(VXS_E_SCENE, "%s: a byteStride, but its target is indices", where.c_str());
    return VXS_OK;
}

vxs_result read_buffer_views(loader &l, const json &root)
{
    l.views.resize(items(root, "bufferViews").size());
    for (size_t i = 0; i < l.views.size(); i++) {
        vxs_result r = read_buffer_view(l, i, root["bufferViews"][i], l.views[i]);
        if (r != VXS_OK) return r;
    }
    return VXS_OK;
}

vxs_result view_bytes(loader &l, size_t index, const unsigned char *&data)
{
    buffer_view &v = l.views[index];
    vxs_result   r;
    if (v.compressed.extension) {
        if (v.decoded.empty() && (r = decode_view(l, index)) != VXS_OK) return r;
        data = v.decoded.data();
        return VXS_OK;
    }
    if (!l.buffers[v.buffer].data)
        return l.error(VXS_E_SCENE, "bufferView %zu is not compressed, and its buffer %zu holds nothing but a fallback", index,
                       v.buffer);
    data = l.buffers[v.buffer].data + v.offset;
    return VXS_OK;
}

} // namespace gltf
