/* The alpha of images that masks need: PNG by libpng, WebP by libwebp. A JPEG has none, so that its pixels do not matter.
 *
 * Sizes are checked before pixels are decoded: ALPHA_IMAGE_MAX_PX a side, PIXELS_MAX an image, and l.pixels_left together.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/gltf/gltf_loader.h"

#include <nlohmann/json.hpp>
#include <png.h>
#include <webp/decode.h>

namespace gltf
{

static constexpr size_t IMAGE_BYTES_MAX = (size_t)1 << 28; /* of a file */
static constexpr size_t PIXELS_MAX      = (size_t)1 << 26; /* decoded to four bytes each */

static vxs_result check_pixels(loader &l, const std::string &where, int width, int height, image_alpha &out)
{
    if (width < 1 || height < 1 || width > (int)ALPHA_IMAGE_MAX_PX || height > (int)ALPHA_IMAGE_MAX_PX)
        return l.error(VXS_E_UNSUPPORTED, "%s: %d x %d pixels, expected 1 to %u a side", where.c_str(), width, height,
                       ALPHA_IMAGE_MAX_PX);
    size_t pixels = (size_t)width * (size_t)height;
    if (pixels > PIXELS_MAX || pixels > l.pixels_left)
        return l.error(VXS_E_UNSUPPORTED, "%s: %d x %d pixels: masks may have %zu in an image, %zu together", where.c_str(), width,
                       height, PIXELS_MAX, ALPHA_PIXELS_MAX);
    l.pixels_left -= pixels;
    out.width_px  = (uint32_t)width;
    out.height_px = (uint32_t)height;
    return VXS_OK;
}

static void keep_alpha(const std::vector<unsigned char> &rgba, image_alpha &out)
{
    out.alpha.resize(rgba.size() / 4);
    for (size_t i = 0; i < out.alpha.size(); i++) out.alpha[i] = rgba[4 * i + 3];
    auto [least, most] = std::minmax_element(out.alpha.begin(), out.alpha.end());
    out.least          = *least;
    out.most           = *most;
}

/* Frees what libpng holds, whatever happens. */
struct png_reader {
    png_image image = {};
    ~png_reader() { png_image_free(&image); }
};

static vxs_result decode_png(loader &l, const std::string &where, const unsigned char *bytes, size_t size, image_alpha &out)
{
    png_reader png;
    png.image.version = PNG_IMAGE_VERSION;
    if (!png_image_begin_read_from_memory(&png.image, bytes, size))
        return l.error(VXS_E_SCENE, "%s: broken PNG: %s", where.c_str(), png.image.message);
    int width    = (int)std::min(png.image.width, (png_uint_32)INT32_MAX),
        height   = (int)std::min(png.image.height, (png_uint_32)INT32_MAX);
    vxs_result r = check_pixels(l, where, width, height, out);
    if (r != VXS_OK) return r;

    png.image.format = PNG_FORMAT_RGBA;
    std::vector<unsigned char> rgba(4 * (size_t)width * (size_t)height);
    if (!png_image_finish_read(&png.image, nullptr, rgba.data(), 0, nullptr))
        return l.error(VXS_E_SCENE, "%s: broken PNG: %s", where.c_str(), png.image.message);
    keep_alpha(rgba, out);
    return VXS_OK;
}

static vxs_result decode_webp(loader &l, const std::string &where, const unsigned char *bytes, size_t size, image_alpha &out)
{
    WebPBitstreamFeatures features;
    if (WebPGetFeatures(bytes, size, &features) != VP8_STATUS_OK) return l.error(VXS_E_SCENE, "%s: broken WebP", where.c_str());
    if (features.has_animation) return l.error(VXS_E_UNSUPPORTED, "%s: an animated WebP", where.c_str());
    vxs_result r = check_pixels(l, where, features.width, features.height, out);
    if (r != VXS_OK) return r;

    std::vector<unsigned char> rgba(4 * (size_t)features.width * (size_t)features.height);
    if (!WebPDecodeRGBAInto(bytes, size, rgba.data(), rgba.size(), 4 * features.width))
        return l.error(VXS_E_SCENE, "%s: broken WebP", where.c_str());
    keep_alpha(rgba, out);
    return VXS_OK;
}

/* Opaque, if it is there from its first marker to its last. */
static vxs_result decode_jpeg(loader &l, const std::string &where, const unsigned char *bytes, size_t size, image_alpha &out)
{
    if (!memmem(bytes, size, "\xff\xd9", 2)) return l.error(VXS_E_SCENE, "%s: broken JPEG: it has no end", where.c_str());
    out.least = out.most = 255;
    return VXS_OK;
}

static vxs_result decode(loader &l, const std::string &where, const unsigned char *bytes, size_t size, image_alpha &out)
{
    auto begins = [bytes, size](const char *magic, size_t length, size_t at) {
        return size >= at + length && !memcmp(bytes + at, magic, length);
    };
    if (begins("\x89PNG", 4, 0)) return decode_png(l, where, bytes, size, out);
    if (begins("\xff\xd8\xff", 3, 0)) return decode_jpeg(l, where, bytes, size, out);
    if (begins("RIFF", 4, 0) && begins("WEBP", 4, 8)) return decode_webp(l, where, bytes, size, out);
    if (begins("\xabKTX", 4, 0)) return l.error(VXS_E_UNSUPPORTED, "%s: KTX images are not read", where.c_str());
    return l.error(VXS_E_UNSUPPORTED, "%s: not a PNG, JPEG or WebP", where.c_str());
}

static vxs_result read_image(loader &l, const std::string &where, const json &object, image_alpha &out)
{
    std::vector<unsigned char> owned;
    const unsigned char       *bytes = nullptr;
    size_t                     size  = 0;
    vxs_result                 r     = check_shape(l, where, object, {{"uri", is::text}, {"bufferView", is::index}});
    if (r != VXS_OK) return r;

    std::string uri = object.value("uri", "");
    if (object.contains("bufferView")) {
        size_t view = object["bufferView"].get<size_t>();
        if (view >= l.views.size()) return l.error(VXS_E_SCENE, "%s: bufferView %zu does not exist", where.c_str(), view);
        if ((r = view_bytes(l, view, bytes)) != VXS_OK) return r;
        size = l.views[view].length;
        return decode(l, where, bytes, size, out);
    }
    if (uri.empty()) return l.error(VXS_E_SCENE, "%s has neither a uri nor a bufferView", where.c_str());
    if (uri.rfind("data:", 0) == 0) {
        size_t comma = uri.find(";base64,");
        if (comma == std::string::npos || !decode_base64(uri.substr(comma + 8), owned))
            return l.error(VXS_E_SCENE, "%s: '%.40s' is not a base64 data URI", where.c_str(), uri.c_str());
    } else if ((r = read_beside(l, where, uri, IMAGE_BYTES_MAX, owned)) != VXS_OK) {
        return r;
    }
    return decode(l, where, owned.data(), owned.size(), out);
}

vxs_result use_image(loader &l, size_t index, image_alpha *&out)
{
    auto found = l.images.find(index);
    if (found == l.images.end()) {
        const json &object = items(*l.rest, "images")[index];
        std::string uri    = object.contains("uri") && object["uri"].is_string() ? object["uri"].get<std::string>() : "";
        std::string name   = object.contains("name") && object["name"].is_string() ? object["name"].get<std::string>() : uri;
        image_alpha image  = {};
        vxs_result  r      = read_image(l, label("image", index, name.rfind("data:", 0) == 0 ? "" : name), object, image);
        if (r != VXS_OK) return r;
        found = l.images.emplace(index, std::move(image)).first;
    }
    out = &found->second;
    return VXS_OK;
}

} // namespace gltf
