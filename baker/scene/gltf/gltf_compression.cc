/* KHR_draco_mesh_compression: decompress primitives with Draco.
 *
 * If a primitive also has uncompressed accessors, these are used: they are the original data.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <draco/compression/decode.h>
#include <draco/compression/point_cloud/point_cloud_decoder.h>
#include <draco/core/varint_decoding.h>
#include <draco/metadata/metadata_decoder.h>
#include <meshoptimizer.h>
#include <set>

#include "baker/scene/gltf/gltf_loader.h"

namespace gltf
{

static const char *const NAME = "KHR_draco_mesh_compression";

bool needs_draco(const loader &l, const tinygltf::Primitive &p)
{
    if (!p.extensions.count(NAME)) return false;
    for (int accessor : {attribute(p.attributes, "POSITION"), p.indices})
        if (accessor >= 0 && l.model.accessors[accessor].bufferView < 0) return true;
    return false;
}

/* Read the number of triangles from a stream's header, before memory is allocated. */
static bool triangles_in_header(const char *from, size_t size, uint32_t &triangles)
{
    draco::DecoderBuffer buffer;
    draco::DracoHeader   header;
    buffer.Init(from, size);
    if (!draco::PointCloudDecoder::DecodeHeader(&buffer, &header).ok() || header.encoder_type != draco::TRIANGULAR_MESH)
        return false;
    uint16_t version = DRACO_BITSTREAM_VERSION(header.version_major, header.version_minor);
    if (version < DRACO_BITSTREAM_VERSION(2, 2)) return false; /* glTF always requires 2.2 */
    buffer.set_bitstream_version(version);
    if (header.flags & METADATA_FLAG_MASK) {
        draco::GeometryMetadata metadata;
        if (!draco::MetadataDecoder().DecodeGeometryMetadata(&buffer, &metadata)) return false;
    }
    uint8_t  kind;
    uint32_t vertices;
    if (header.encoder_method == draco::MESH_SEQUENTIAL_ENCODING) return draco::DecodeVarint(&triangles, &buffer);
    return buffer.Decode(&kind) && draco::DecodeVarint(&vertices, &buffer) && draco::DecodeVarint(&triangles, &buffer);
}

/* lower estimate of the memory while a mesh is decoded */
constexpr uint64_t TRIANGLE_BYTES = 60;

/* Allocate tightly packed elements. */
static elements dense_elements(const elements &like, int component, size_t components, size_t count)
{
    elements e       = {};
    e.label          = like.label;
    e.type           = like.type;
    e.component      = component;
    e.component_size = component_bytes(component);
    e.normalized     = like.normalized;
    e.size = e.stride = components * e.component_size;
    e.count           = count;
    e.dense.resize(count * e.size);
    e.data  = e.dense.data();
    e.ready = true;
    return e;
}

/* Copy the values of an attribute for all points, in the component type of the corresponding accessor. */
static elements copy_attribute(loader &l, const std::string &where, const draco::Mesh &mesh, const tinygltf::Value &ids,
                               const std::string &name, const elements &accessor)
{
    const draco::PointAttribute *from =
        ids.Has(name) && ids.Get(name).IsInt() ? mesh.GetAttributeByUniqueId((uint32_t)ids.Get(name).GetNumberAsInt()) : nullptr;
    if (!from) l.broken(where, "%s is not in its %s data", name.c_str(), NAME);

    static const std::map<int, draco::DataType> types      = {{TINYGLTF_COMPONENT_TYPE_BYTE, draco::DT_INT8},
                                                              {TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE, draco::DT_UINT8},
                                                              {TINYGLTF_COMPONENT_TYPE_SHORT, draco::DT_INT16},
                                                              {TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT, draco::DT_UINT16},
                                                              {TINYGLTF_COMPONENT_TYPE_FLOAT, draco::DT_FLOAT32}};
    auto                                        type       = types.find(accessor.component);
    int                                         components = tinygltf::GetNumComponentsInType((uint32_t)accessor.type);
    if (type == types.end() || from->data_type() != type->second || from->num_components() != components)
        l.broken(where, "%s in its %s data is not of its accessor's type", name.c_str(), NAME);

    elements e = dense_elements(accessor, accessor.component, (size_t)components, mesh.num_points());
    for (uint32_t i = 0; i < mesh.num_points(); i++) {
        draco::AttributeValueIndex value = from->mapped_index(draco::PointIndex(i));
        if (value.value() >= from->size() || !from->IsAddressValid(from->GetAddress(value) + e.size - 1))
            l.broken(where, "%s in its %s data is incomplete", name.c_str(), NAME);
        memcpy(e.dense.data() + i * e.size, from->GetAddress(value), e.size);
    }
    return e;
}

static draco_primitive decode(loader &l, const std::string &where, const tinygltf::Primitive &p)
{
    const tinygltf::Value &e    = p.extensions.at(NAME);
    size_t                 view = (size_t)e.Get("bufferView").GetNumberAsInt();
    const char            *from = (const char *)whole_view(l, where + " " + NAME, view);
    if (p.mode != TINYGLTF_MODE_TRIANGLES || p.indices < 0)
        l.unsupported(where, "%s data is read for indexed triangles only", NAME);

    const elements &indices = l.accessors[p.indices];
    size_t          size    = l.views[view].length;
    uint32_t        triangles;
    if (!triangles_in_header(from, size, triangles)) l.broken(where, "its %s data is not a mesh", NAME);
    if (3 * (size_t)triangles != indices.count)
        l.broken(where, "its %s data holds %u triangles, accessor %d says %zu indices", NAME, triangles, p.indices, indices.count);
    /* regular meshes need only a few bits per triangle, but a declaration of millions in a few bytes is invalid */
    if (triangles > ((size_t)1 << 20) + 64 * size)
        l.unsupported(where, "%u triangles in %zu bytes of %s data", triangles, size, NAME);

    l.need(TRIANGLE_BYTES * triangles, where);
    draco::DecoderBuffer buffer;
    buffer.Init(from, size);
    draco::Decoder decoder;
    auto           mesh = decoder.DecodeMeshFromBuffer(&buffer);
    if (!mesh.ok()) l.broken(where, "its %s data: %s", NAME, one_line(mesh.status().error_msg_string()).c_str());
    if (mesh.value()->num_faces() != triangles) l.broken(where, "its %s data is incomplete", NAME);

    draco_primitive out    = {{}, dense_elements(indices, TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT, 1, 3 * (size_t)triangles)};
    bool            masked = p.material >= 0 && l.materials[p.material].mode != alpha_mode::SOLID;
    for (size_t i = 0; i < out.indices.count; i++) {
        uint32_t index = mesh.value()->face(draco::FaceIndex((uint32_t)(i / 3)))[i % 3].value();
        memcpy(out.indices.dense.data() + i * sizeof index, &index, sizeof index);
    }
    for (const auto &[name, accessor] : p.attributes) {
        bool is_alpha = name.rfind("TEXCOORD_", 0) == 0 || name == "COLOR_0",
             is_skin  = name.rfind("JOINTS_", 0) == 0 || name.rfind("WEIGHTS_", 0) == 0;
        bool is_read  = (masked && is_alpha) || (is_skin && l.choice->skinned == SKINNED_REST);
        if ((size_t)accessor >= l.accessors.size() || l.accessors[accessor].fault)
            continue; /* needed attributes report their fault elsewhere */
        if (name == "POSITION" || (is_read && e.Get("attributes").Has(name)))
            out.attributes[name] = copy_attribute(l, where, *mesh.value(), e.Get("attributes"), name, l.accessors[accessor]);
    }
    return out;
}

const draco_primitive &use_draco(loader &l, const std::string &where, const tinygltf::Primitive &p)
{
    auto found = l.draco.find(&p);
    if (found == l.draco.end()) found = l.draco.emplace(&p, decode(l, where, p)).first;
    return found->second;
}

/* EXT_meshopt_compression, and the common subset of KHR_meshopt_compression: decompress bufferViews with meshoptimizer. */

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
