/* RAII handles of libvxs for C++11 and later: they close what vxs.h and vxs_stream.h open. Nothing here throws.
 *
 *     vxs::asset asset;
 *     if (vxs::open(asset, "level.vxs") != VXS_OK) ...
 *     float lit = vxs_lookup(vxs_asset_light(asset.get(), 0), position_ws, normal_ws, vxs_box(9));
 *
 * Public.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_HPP
#define VXS_HPP

#include <memory>

#include "vxs_stream.h"

namespace vxs {

struct closer {
    void operator()(vxs_asset *asset) const noexcept { vxs_asset_close(asset); }
    void operator()(vxs_stream *stream) const noexcept { vxs_stream_close(stream); }
};

using asset  = std::unique_ptr<vxs_asset, closer>;
using stream = std::unique_ptr<vxs_stream, closer>;

/* vxs_asset_open_file and vxs_asset_open. The previous content of the handle is closed first. On failure the handle is empty. */
inline vxs_result open(asset &to, const char *path, const vxs_read_desc *desc = nullptr) noexcept
{
    vxs_asset *opened = nullptr;
    to.reset();
    vxs_result result = vxs_asset_open_file(&opened, path, desc);
    to.reset(opened);
    return result;
}

inline vxs_result open_bytes(asset &to, const void *bytes, size_t size_bytes, const vxs_read_desc *desc = nullptr) noexcept
{
    vxs_asset *opened = nullptr;
    to.reset();
    vxs_result result = vxs_asset_open(&opened, bytes, size_bytes, desc);
    to.reset(opened);
    return result;
}

/* The same for vxs_stream_open. */
inline vxs_result open(stream &to, const vxs_stream_desc &desc) noexcept
{
    vxs_stream *opened = nullptr;
    to.reset();
    vxs_result result = vxs_stream_open(&opened, &desc);
    to.reset(opened);
    return result;
}

} // namespace vxs

#endif
