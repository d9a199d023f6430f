/* EXT_meshopt_compression, and KHR_meshopt_compression as far as it is the same: bufferViews decompressed with meshoptimizer.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/gltf/gltf_loader.h"

#include <meshoptimizer.h>
#include <nlohmann/json.hpp>

namespace gltf
{

/* No stream of the codecs decompresses to more than this many times its bytes: a byte column of 256 vertices takes 4 bytes at least,
 * a triangle of indices one. */
static constexpr size_t RATIO_MAX = 64;

/* What the decoders assert. */
static const char *expected_stride(const compressed_view &c)
{
    if (c.mode != "ATTRIBUTES") return c.stride == 2 || c.stride == 4 ? nullptr : "2 or 4";
    if (!c.stride || c.stride > 256 || c.stride % 4) return "a multiple of 4 up to 256";
    if (c.filter == "OCTAHEDRAL") return c.stride == 4 || c.stride == 8 ? nullptr : "4 or 8";
    if (c.filter == "QUATERNION") return c.stride == 8 ? nullptr : "8";
    return nullptr;
}

static vxs_result check_compressed_view(loader &l, const std::string &where, size_t length, const compressed_view &c)
{
    bool mode   = c.mode == "ATTRIBUTES" || c.mode == "TRIANGLES" || c.mode == "INDICES";
    bool filter = c.filter == "NONE" || c.filter == "OCTAHEDRAL" || c.filter == "QUATERNION" || c.filter == "EXPONENTIAL";
    bool newer  = c.filter == "COLOR" && !strcmp(c.extension, "KHR_meshopt_compression");
    if (!mode) return l.error(VXS_E_SCENE, "%s: unknown mode '%s'", where.c_str(), c.mode.c_str());
    if (!filter && !newer) return l.error(VXS_E_SCENE, "%s: unknown filter '%s'", where.c_str(), c.filter.c_str());
    if (c.filter != "NONE" && c.mode != "ATTRIBUTES")
        return l.error(VXS_E_SCENE, "%s: filter %s with mode %s", where.c_str(), c.filter.c_str(), c.mode.c_str());
    if (const char *expected = expected_stride(c))
        return l.error(VXS_E_SCENE, "%s: byteStride is %zu, expected %s", where.c_str(), c.stride, expected);
    if (c.mode == "TRIANGLES" && c.count % 3)
        return l.error(VXS_E_SCENE, "%s: count is %zu, expected a multiple of 3", where.c_str(), c.count);
    if (!c.count || c.count > length / c.stride || c.count * c.stride != length)
        return l.error(VXS_E_SCENE, "%s: %zu elements of %zu bytes, in a bufferView of %zu bytes", where.c_str(), c.count, c.stride,
                       length);

    if (c.buffer >= l.buffers.size()) return l.error(VXS_E_SCENE, "%s: buffer %zu does not exist", where.c_str(), c.buffer);
    const buffer &b = l.buffers[c.buffer];
    if (!b.data) return l.error(VXS_E_SCENE, "%s: buffer %zu holds nothing but a fallback", where.c_str(), c.buffer);
    if (!c.length || c.offset > b.size_bytes || c.length > b.size_bytes - c.offset)
        return l.error(VXS_E_SCENE, "%s: %zu bytes at byte %zu do not fit in buffer %zu of %zu bytes", where.c_str(), c.length,
                       c.offset, c.buffer, b.size_bytes);
    if (length / RATIO_MAX > c.length)
        return l.error(VXS_E_SCENE, "%s: %zu bytes cannot hold %zu", where.c_str(), c.length, length);
    return VXS_OK;
}

vxs_result read_compressed_view(loader &l, const std::string &where, const json &view, compressed_view &c)
{
    for (const char *name : {"EXT_meshopt_compression", "KHR_meshopt_compression"}) {
        const json *e = extension(view, name);
        if (!e) continue;
        static const std::vector<property> shape = {{"buffer", is::index, true},
                                                    {"byteOffset", is::size},
                                                    {"byteLength", is::size, true},
                                                    {"byteStride", is::size, true},
                                                    {"count", is::size, true},
                                                    {"mode", is::text, true},
                                                    {"filter", is::text}};
        std::string                        place = where + " " + name;
        vxs_result                         r     = check_shape(l, place, *e, shape);
        if (r != VXS_OK) return r;
        c.extension = name;
        c.buffer    = (*e)["buffer"].get<size_t>();
        c.offset    = e->value("byteOffset", (size_t)0);
        c.length    = (*e)["byteLength"].get<size_t>();
        c.stride    = (*e)["byteStride"].get<size_t>();
        c.count     = (*e)["count"].get<size_t>();
        c.mode      = (*e)["mode"].get<std::string>();
        c.filter    = e->value("filter", "NONE");
        return check_compressed_view(l, place, view["byteLength"].get<size_t>(), c);
    }
    return VXS_OK;
}

vxs_result decode_view(loader &l, size_t index)
{
    buffer_view           &v     = l.views[index];
    const compressed_view &c     = v.compressed;
    std::string            where = label("bufferView", index, "") + " " + c.extension;
    const unsigned char   *bytes = l.buffers[c.buffer].data + c.offset;
    if (v.length > l.decoded_left)
        return l.error(VXS_E_UNSUPPORTED, "%s: compressed bufferViews would hold more than %zu bytes", where.c_str(), DECODED_MAX);
    if (c.filter == "COLOR") return l.error(VXS_E_UNSUPPORTED, "%s: filter COLOR is not read", where.c_str());
    if (c.mode == "ATTRIBUTES" && bytes[0] == 0xa1)
        return l.error(VXS_E_UNSUPPORTED, "%s: version 1 of the vertex codec is not read", where.c_str());

    l.decoded_left -= v.length;
    std::vector<unsigned char> out(v.length);
    int failed = c.mode == "ATTRIBUTES"  ? meshopt_decodeVertexBuffer(out.data(), c.count, c.stride, bytes, c.length)
                 : c.mode == "TRIANGLES" ? meshopt_decodeIndexBuffer(out.data(), c.count, c.stride, bytes, c.length)
                                         : meshopt_decodeIndexSequence(out.data(), c.count, c.stride, bytes, c.length);
    if (failed) return l.error(VXS_E_SCENE, "%s: its %s cannot be decompressed", where.c_str(), c.mode.c_str());
    if (c.filter == "OCTAHEDRAL") meshopt_decodeFilterOct(out.data(), c.count, c.stride);
    if (c.filter == "QUATERNION") meshopt_decodeFilterQuat(out.data(), c.count, c.stride);
    if (c.filter == "EXPONENTIAL") meshopt_decodeFilterExp(out.data(), c.count, c.stride);
    v.decoded.swap(out);
    return VXS_OK;
}

} // namespace gltf
