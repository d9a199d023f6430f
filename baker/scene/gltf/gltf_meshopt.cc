/* EXT_meshopt_compression, and the common subset of KHR_meshopt_compression: decompress bufferViews with meshoptimizer.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/scene/gltf/gltf_loader.h"

#include <meshoptimizer.h>
#include <set>

namespace gltf
{

/* Upper limit of the compression ratio: a byte column of 256 vertices takes at least 4 bytes, a triangle of indices at least
 * one. */
static constexpr size_t RATIO_MAX = 64;

/* The stride that the decoders require. */
static const char *expected_stride(const compressed_view &c)
{
    if (c.mode != "ATTRIBUTES") return c.stride == 2 || c.stride == 4 ? nullptr : "2 or 4";
    if (!c.stride || c.stride > 256 || c.stride % 4) return "a multiple of 4 up to 256";
    if (c.filter == "OCTAHEDRAL") return c.stride == 4 || c.stride == 8 ? nullptr : "4 or 8";
    if (c.filter == "QUATERNION") return c.stride == 8 ? nullptr : "8";
    return nullptr;
}

static void check_compressed_view(loader &l, const std::string &where, size_t length, const compressed_view &c)
{
    static const std::set<std::string> modes   = {"ATTRIBUTES", "TRIANGLES", "INDICES"},
                                       filters = {"NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL"};
    bool newer                                 = c.filter == "COLOR" && !strcmp(c.extension, "KHR_meshopt_compression");
    if (!modes.count(c.mode)) l.broken(where, "unknown mode '%s'", c.mode.c_str());
    if (!filters.count(c.filter) && !newer) l.broken(where, "unknown filter '%s'", c.filter.c_str());
    if (c.filter != "NONE" && c.mode != "ATTRIBUTES") l.broken(where, "filter %s with mode %s", c.filter.c_str(), c.mode.c_str());
    if (const char *expected = expected_stride(c)) l.broken(where, "byteStride is %zu, expected %s", c.stride, expected);
    if (c.mode == "TRIANGLES" && c.count % 3) l.broken(where, "count is %zu, expected a multiple of 3", c.count);
    if (!c.count || c.count > length / c.stride || c.count * c.stride != length)
        l.broken(where, "%zu elements of %zu bytes, in a bufferView of %zu bytes", c.count, c.stride, length);

    if (c.buffer >= l.buffers.size()) l.broken(where, "buffer %zu does not exist", c.buffer);
    if (!l.buffers[c.buffer].data && l.buffers[c.buffer].fault) throw l.buffers[c.buffer].fault;
    if (!l.buffers[c.buffer].data) l.broken(where, "buffer %zu holds nothing but a fallback", c.buffer);
    check_in_buffer(l, where, c.length, c.offset, c.buffer);
    if (length / RATIO_MAX > c.length) l.broken(where, "%zu bytes cannot hold %zu", c.length, length);
}

void read_compressed_view(loader &l, const std::string &where, const json &view, compressed_view &c)
{
    static constexpr shape members = {{"buffer", is::index, true},
                                      {"byteOffset", is::size},
                                      {"byteLength", is::size, true},
                                      {"byteStride", is::size, true},
                                      {"count", is::size, true},
                                      {"mode", is::text, true},
                                      {"filter", is::text}};
    for (const char *name : {"EXT_meshopt_compression", "KHR_meshopt_compression"}) {
        const json *e = check_extension(l, where, view, name, members);
        if (!e) continue;
        c.extension = name;
        c.buffer    = (*e)["buffer"];
        c.offset    = e->value("byteOffset", (size_t)0);
        c.length    = (*e)["byteLength"];
        c.stride    = (*e)["byteStride"];
        c.count     = (*e)["count"];
        c.mode      = (*e)["mode"];
        c.filter    = e->value("filter", "NONE");
        return check_compressed_view(l, where + " " + name, view["byteLength"].get<size_t>(), c);
    }
}

void decode_view(loader &l, size_t index)
{
    buffer_view           &v     = l.views[index];
    const compressed_view &c     = v.compressed;
    std::string            where = label("bufferView", index) + " " + c.extension;
    const unsigned char   *from  = l.buffers[c.buffer].data + c.offset;
    if (v.length > l.decoded_left) l.refused(where, "compressed bufferViews would hold more than %zu bytes", DECODED_MAX);
    if (c.filter == "COLOR") l.unsupported(where, "filter COLOR is not read");
    if (c.mode == "ATTRIBUTES" && from[0] == 0xa1) l.unsupported(where, "version 1 of the vertex codec is not read");

    l.decoded_left -= v.length;
    l.need(v.length, where);
    bytes out(v.length);
    int   failed = c.mode == "ATTRIBUTES"  ? meshopt_decodeVertexBuffer(out.data(), c.count, c.stride, from, c.length)
                   : c.mode == "TRIANGLES" ? meshopt_decodeIndexBuffer(out.data(), c.count, c.stride, from, c.length)
                                           : meshopt_decodeIndexSequence(out.data(), c.count, c.stride, from, c.length);
    if (failed) l.broken(where, "its %s cannot be decompressed", c.mode.c_str());
    if (c.filter == "OCTAHEDRAL") meshopt_decodeFilterOct(out.data(), c.count, c.stride);
    if (c.filter == "QUATERNION") meshopt_decodeFilterQuat(out.data(), c.count, c.stride);
    if (c.filter == "EXPONENTIAL") meshopt_decodeFilterExp(out.data(), c.count, c.stride);
    v.decoded.swap(out);
}

} // namespace gltf
