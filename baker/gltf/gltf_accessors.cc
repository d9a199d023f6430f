/* Accessors (3.6): elements, held against their bufferViews and buffers.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/gltf/gltf_loader.h"

namespace gltf
{

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
static size_t element_bytes(int type, size_t component)
{
    switch (type) {
    case TINYGLTF_TYPE_MAT2: return component == 1 ? 8 : 4 * component;
    case TINYGLTF_TYPE_MAT3: return component == 4 ? 36 : 12 * component;
    case TINYGLTF_TYPE_MAT4: return 16 * component;
    }
    return (size_t)tinygltf::GetNumComponentsInType((uint32_t)type) * component;
}

/* Whether `count` elements of `size` bytes from `offset` lie in a bufferView, and how far apart they are. */
static vxs_result check_extent(loader &l, const std::string &where, int view_index, size_t offset, size_t count, size_t size,
                               size_t &stride)
{
    if (view_index < 0 || (size_t)view_index >= l.views.size())
        return l.error(VXS_E_SCENE, "%s: bufferView %d does not exist", where.c_str(), view_index);
    const buffer_view &view = l.views[(size_t)view_index];
    stride                  = view.stride ? view.stride : size;
    if (stride < size)
        return l.error(VXS_E_SCENE, "%s: byteStride %zu is less than its elements of %zu bytes", where.c_str(), stride, size);
    if (offset > view.length || count > SIZE_MAX / 256 ||
        (count && (view.length - offset < size || (count - 1) > (view.length - offset - size) / stride)))
        return l.error(VXS_E_SCENE, "%s: %zu elements at byte %zu do not fit in bufferView %d of %zu bytes", where.c_str(), count,
                       offset, view_index, view.length);
    return VXS_OK;
}

size_t offset_in_buffer(const loader &l, const tinygltf::Accessor &a)
{
    const buffer_view &view = l.views[(size_t)a.bufferView];
    return a.byteOffset + (view.compressed.extension ? 0 : view.offset);
}

vxs_result check_accessors(loader &l)
{
    vxs_result r;
    l.accessors.resize(l.model.accessors.size());
    for (size_t i = 0; i < l.accessors.size(); i++) {
        const tinygltf::Accessor &a         = l.model.accessors[i];
        elements                 &e         = l.accessors[i];
        std::string               where     = label("accessor", i, a.name);
        size_t                    component = component_bytes(a.componentType);
        if (!component) return l.error(VXS_E_SCENE, "%s: unknown componentType %d", where.c_str(), a.componentType);

        e.count      = a.count;
        e.size       = element_bytes(a.type, component);
        e.stride     = e.size;
        e.component  = a.componentType;
        e.normalized = a.normalized;
        if (a.bufferView >= 0 && (r = check_extent(l, where, a.bufferView, a.byteOffset, a.count, e.size, e.stride)) != VXS_OK)
            return r;
        if (a.bufferView >= 0 && offset_in_buffer(l, a) % component)
            return l.error(VXS_E_SCENE, "%s: byte %zu of its buffer is not a multiple of its components' %zu bytes", where.c_str(),
                           offset_in_buffer(l, a), component);
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

double component_at(const unsigned char *at, int component, bool normalized)
{
    float    real;
    int16_t  s16;
    uint16_t u16;
    switch (component) {
    case TINYGLTF_COMPONENT_TYPE_BYTE: return normalized ? std::max((signed char)*at / 127.0, -1.0) : (signed char)*at;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE: return normalized ? *at / 255.0 : *at;
    case TINYGLTF_COMPONENT_TYPE_SHORT: memcpy(&s16, at, sizeof s16); return normalized ? std::max(s16 / 32767.0, -1.0) : s16;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT: memcpy(&u16, at, sizeof u16); return normalized ? u16 / 65535.0 : u16;
    default: memcpy(&real, at, sizeof real); return real;
    }
}

/* `count` elements of `size` bytes from `offset` in a bufferView. */
static vxs_result view_elements(loader &l, const std::string &where, int view, int offset, size_t count, size_t size, elements &e)
{
    vxs_result r;
    if ((r = check_extent(l, where, view, (size_t)offset, count, size, e.stride)) != VXS_OK) return r;
    if ((r = view_bytes(l, (size_t)view, e.data)) != VXS_OK) return r;
    e.data += offset;
    e.size = size;
    return VXS_OK;
}

static vxs_result overlay_sparse(loader &l, const std::string &where, const tinygltf::Accessor &a, elements &e)
{
    const auto &sparse = a.sparse;
    int         kind   = sparse.indices.componentType;
    size_t      count = (size_t)sparse.count, last = 0;
    elements    indices = {}, values = {};
    vxs_result  r;
    if (kind != TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE && kind != TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT &&
        kind != TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT)
        return l.error(VXS_E_SCENE, "%s: sparse indices of componentType %d", where.c_str(), kind);
    if ((r = view_elements(l, where + " sparse indices", sparse.indices.bufferView, sparse.indices.byteOffset, count,
                           component_bytes(kind), indices)) != VXS_OK)
        return r;
    if ((r = view_elements(l, where + " sparse values", sparse.values.bufferView, sparse.values.byteOffset, count, e.size,
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

static vxs_result make_dense(loader &l, const std::string &where, const tinygltf::Accessor &a, elements &e)
{
    if (e.count > l.dense_left)
        return l.error(VXS_E_UNSUPPORTED, "%s: sparse accessors would hold more than %zu elements", where.c_str(), DENSE_MAX);
    l.dense_left -= e.count;
    e.dense.resize(e.count * e.size);
    for (size_t i = 0; e.data && i < e.count; i++) memcpy(e.dense.data() + i * e.size, e.data + i * e.stride, e.size);
    e.data   = e.dense.data();
    e.stride = e.size;
    return a.sparse.isSparse ? overlay_sparse(l, where, a, e) : VXS_OK;
}

vxs_result use_accessor(loader &l, int index, const elements *&out)
{
    elements                 &e = l.accessors[(size_t)index];
    const tinygltf::Accessor &a = l.model.accessors[(size_t)index];
    vxs_result                r = VXS_OK;
    out                         = &e;
    if (e.ready) return VXS_OK;

    if (a.bufferView >= 0) {
        if ((r = view_bytes(l, (size_t)a.bufferView, e.data)) != VXS_OK) return r;
        e.data += a.byteOffset;
    }
    if (a.sparse.isSparse || a.bufferView < 0) r = make_dense(l, label("accessor", (size_t)index, a.name), a, e);
    e.ready = r == VXS_OK;
    return r;
}

template <typename T> static size_t least_above(const elements &e)
{
    T most = 0, value;
    for (size_t i = 0; i < e.count; i++) {
        memcpy(&value, e.data + i * e.stride, sizeof value);
        most = std::max(most, value);
    }
    return e.count ? (size_t)most + 1 : 0;
}

vxs_result check_index_values(loader &l, const elements &e, int accessor, size_t vertices)
{
    size_t limit = std::min(vertices, e.size == 4 ? (size_t)UINT32_MAX : ((size_t)1 << 8 * e.size) - 1);
    size_t below = e.indices_below;
    if (!below) below = e.size == 1 ? least_above<uint8_t>(e) : e.size == 2 ? least_above<uint16_t>(e) : least_above<uint32_t>(e);
    if (&e == &l.accessors[(size_t)accessor]) l.accessors[(size_t)accessor].indices_below = below;
    if (below <= limit) return VXS_OK;

    size_t bad = 0;
    while (unsigned_at(e.data + bad * e.stride, e.size) < limit) bad++;
    return l.error(VXS_E_SCENE, "%s: index %zu is %u, expected less than %zu",
                   label("accessor", (size_t)accessor, l.model.accessors[(size_t)accessor].name).c_str(), bad,
                   unsigned_at(e.data + bad * e.stride, e.size), limit);
}

} // namespace gltf
