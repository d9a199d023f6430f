/* Accessors (3.6): their elements, checked against bufferViews and buffers.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/scene/gltf/gltf_loader.h"

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

bool is_unsigned(int component)
{
    return component == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE || component == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ||
           component == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
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

/* Check that `count` elements of `size` bytes from `offset` are inside a bufferView, and inside the available part of its buffer.
 * Returns the stride. */
static size_t check_extent(loader &l, const std::string &where, int index, size_t offset, size_t count, size_t size)
{
    check_view_index(l, where, (size_t)index);
    const buffer_view &view   = l.views[index];
    size_t             stride = view.stride ? view.stride : size;
    if (view.fault) throw view.fault;
    if (stride < size) l.broken(where, "byteStride %zu is less than its elements of %zu bytes", stride, size);
    if (offset > view.length || count > SIZE_MAX / 256 ||
        (count && (view.length - offset < size || (count - 1) > (view.length - offset - size) / stride)))
        l.broken(where, "%zu elements at byte %zu do not fit in bufferView %d of %zu bytes", count, offset, index, view.length);
    if (count && !view.compressed.extension) check_there(l, view.buffer, view.offset + offset, (count - 1) * stride + size);
    return stride;
}

size_t offset_in_buffer(const loader &l, const tinygltf::Accessor &a)
{
    const buffer_view &view = l.views[a.bufferView];
    return a.byteOffset + (view.compressed.extension ? 0 : view.offset);
}

static void check_accessor(loader &l, const tinygltf::Accessor &a, elements &e)
{
    auto broken = l.faults[ACCESSORS].find(l.accessors.size());
    if (broken != l.faults[ACCESSORS].end()) throw broken->second;
    e.component      = a.componentType;
    e.component_size = component_bytes(a.componentType);
    e.size = e.stride = element_bytes(a.type, e.component_size);
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

static void overlay_sparse(loader &l, const tinygltf::Accessor &a, elements &e)
{
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

static void make_dense(loader &l, const tinygltf::Accessor &a, elements &e)
{
    if (e.count > l.dense_left) l.refused(e.label, "sparse accessors would hold more than %zu elements", DENSE_MAX);
    l.dense_left -= e.count;
    l.need(e.count * e.size, e.label);
    e.dense.resize(e.count * e.size);
    for (size_t i = 0; e.data && i < e.count; i++) memcpy(e.dense.data() + i * e.size, e.data + i * e.stride, e.size);
    e.data   = e.dense.data();
    e.stride = e.size;
    if (a.sparse.isSparse) overlay_sparse(l, a, e);
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
