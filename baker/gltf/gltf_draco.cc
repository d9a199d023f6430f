/* KHR_draco_mesh_compression: primitives decompressed with Draco.
 *
 * A primitive that also has uncompressed accessors is read from these: they are what was compressed.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/gltf/gltf_loader.h"

#include <draco/compression/decode.h>
#include <draco/compression/point_cloud/point_cloud_decoder.h>
#include <draco/core/varint_decoding.h>
#include <draco/metadata/metadata_decoder.h>

namespace gltf
{

static const char *const NAME = "KHR_draco_mesh_compression";

/* Triangles that a stream of so many bytes may hold. Regular meshes take few bits a triangle; a stream that promises millions in a
 * few bytes is no mesh. */
static size_t plausible_triangles(size_t bytes)
{
    return ((size_t)1 << 20) + 64 * bytes;
}

bool needs_draco(const loader &l, const tinygltf::Primitive &p)
{
    if (!p.extensions.count(NAME)) return false;
    for (int accessor : {attribute(p.attributes, "POSITION"), p.indices})
        if (accessor >= 0 && (size_t)accessor < l.accessors.size() && l.model.accessors[(size_t)accessor].bufferView < 0)
            return true;
    return false;
}

/* How many triangles a stream says it has, before anything is allocated for them. */
static bool triangles_in_header(const char *bytes, size_t size, uint32_t &triangles)
{
    draco::DecoderBuffer buffer;
    draco::DracoHeader   header;
    buffer.Init(bytes, size);
    if (!draco::PointCloudDecoder::DecodeHeader(&buffer, &header).ok() || header.encoder_type != draco::TRIANGULAR_MESH)
        return false;
    uint16_t version = DRACO_BITSTREAM_VERSION(header.version_major, header.version_minor);
    if (version < DRACO_BITSTREAM_VERSION(2, 2)) return false; /* glTF has always had 2.2 */
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

/* An attribute's values for every point, in the type of the accessor that they stand for. */
static vxs_result copy_attribute(loader &l, const std::string &where, const draco::Mesh &mesh, const tinygltf::Value &ids,
                                 const std::string &name, const tinygltf::Accessor &a, elements &e)
{
    const draco::PointAttribute *from =
        ids.Has(name) && ids.Get(name).IsInt() ? mesh.GetAttributeByUniqueId((uint32_t)ids.Get(name).GetNumberAsInt()) : nullptr;
    if (!from) return l.error(VXS_E_SCENE, "%s: %s is not in its %s data", where.c_str(), name.c_str(), NAME);

    static const std::map<int, draco::DataType> types      = {{TINYGLTF_COMPONENT_TYPE_BYTE, draco::DT_INT8},
                                                              {TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE, draco::DT_UINT8},
                                                              {TINYGLTF_COMPONENT_TYPE_SHORT, draco::DT_INT16},
                                                              {TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT, draco::DT_UINT16},
                                                              {TINYGLTF_COMPONENT_TYPE_FLOAT, draco::DT_FLOAT32}};
    auto                                        type       = types.find(a.componentType);
    int                                         components = tinygltf::GetNumComponentsInType((uint32_t)a.type);
    if (type == types.end() || from->data_type() != type->second || from->num_components() != components)
        return l.error(VXS_E_SCENE, "%s: %s in its %s data is not of its accessor's type", where.c_str(), name.c_str(), NAME);

    e.component  = a.componentType;
    e.normalized = a.normalized;
    e.size = e.stride = (size_t)components * component_bytes(a.componentType);
    e.count           = mesh.num_points();
    e.dense.resize(e.count * e.size);
    for (uint32_t i = 0; i < mesh.num_points(); i++) {
        draco::AttributeValueIndex value = from->mapped_index(draco::PointIndex(i));
        if (value.value() >= from->size() || !from->IsAddressValid(from->GetAddress(value) + e.size - 1))
            return l.error(VXS_E_SCENE, "%s: %s in its %s data is incomplete", where.c_str(), name.c_str(), NAME);
        memcpy(e.dense.data() + i * e.size, from->GetAddress(value), e.size);
    }
    e.data  = e.dense.data();
    e.ready = true;
    return VXS_OK;
}

static void copy_indices(const draco::Mesh &mesh, elements &e)
{
    e.component = TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
    e.size = e.stride = sizeof(uint32_t);
    e.count           = 3 * (size_t)mesh.num_faces();
    e.dense.resize(e.count * e.size);
    for (uint32_t i = 0; i < mesh.num_faces(); i++)
        for (size_t k = 0; k < 3; k++) {
            uint32_t index = mesh.face(draco::FaceIndex(i))[k].value();
            memcpy(e.dense.data() + (3 * (size_t)i + k) * sizeof index, &index, sizeof index);
        }
    e.data  = e.dense.data();
    e.ready = true;
}

static vxs_result decode(loader &l, const std::string &where, const tinygltf::Primitive &p, draco_primitive &out)
{
    const tinygltf::Value &e    = p.extensions.at(NAME);
    size_t                 view = (size_t)e.Get("bufferView").GetNumberAsInt();
    const unsigned char   *bytes;
    vxs_result             r;
    if (view >= l.views.size()) return l.error(VXS_E_SCENE, "%s %s: bufferView %zu does not exist", where.c_str(), NAME, view);
    if (p.mode != TINYGLTF_MODE_TRIANGLES || p.indices < 0)
        return l.error(VXS_E_UNSUPPORTED, "%s: %s data is read for indexed triangles only", where.c_str(), NAME);
    if ((r = view_bytes(l, view, bytes)) != VXS_OK) return r;

    size_t   size = l.views[view].length, expected = l.accessors[(size_t)p.indices].count;
    uint32_t triangles;
    if (!triangles_in_header((const char *)bytes, size, triangles))
        return l.error(VXS_E_SCENE, "%s: its %s data is not a mesh", where.c_str(), NAME);
    if (3 * (size_t)triangles != expected)
        return l.error(VXS_E_SCENE, "%s: its %s data holds %u triangles, accessor %d says %zu indices", where.c_str(), NAME,
                       triangles, p.indices, expected);
    if (triangles > plausible_triangles(size))
        return l.error(VXS_E_UNSUPPORTED, "%s: %u triangles in %zu bytes of %s data", where.c_str(), triangles, size, NAME);

    draco::DecoderBuffer buffer;
    buffer.Init((const char *)bytes, size);
    draco::Decoder decoder;
    auto           mesh = decoder.DecodeMeshFromBuffer(&buffer);
    if (!mesh.ok())
        return l.error(VXS_E_SCENE, "%s: its %s data: %s", where.c_str(), NAME, one_line(mesh.status().error_msg_string()).c_str());
    if (mesh.value()->num_faces() != triangles) return l.error(VXS_E_SCENE, "%s: its %s data is incomplete", where.c_str(), NAME);
    copy_indices(*mesh.value(), out.indices);
    bool masked = p.material >= 0 && l.materials[(size_t)p.material].mask;
    for (const auto &[name, accessor] : p.attributes) {
        bool is_alpha = name.rfind("TEXCOORD_", 0) == 0 || name == "COLOR_0";
        if (name != "POSITION" && !(masked && is_alpha && e.Get("attributes").Has(name))) continue;
        if ((size_t)accessor >= l.accessors.size())
            return l.error(VXS_E_SCENE, "%s: %s accessor %d does not exist", where.c_str(), name.c_str(), accessor);
        r = copy_attribute(l, where, *mesh.value(), e.Get("attributes"), name, l.model.accessors[(size_t)accessor],
                           out.attributes[name]);
        if (r != VXS_OK) return r;
    }
    return VXS_OK;
}

vxs_result use_draco(loader &l, const std::string &where, const tinygltf::Primitive &p, const draco_primitive *&out)
{
    auto found = l.draco.find(&p);
    if (found == l.draco.end()) {
        draco_primitive decoded = {};
        vxs_result      r       = decode(l, where, p, decoded);
        if (r != VXS_OK) return r;
        found = l.draco.emplace(&p, std::move(decoded)).first;
    }
    out = &found->second;
    return VXS_OK;
}

} // namespace gltf
