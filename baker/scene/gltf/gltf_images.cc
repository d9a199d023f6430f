/* Images for masks and lights: PNG with libpng, WebP with libwebp. A JPEG has no alpha, and its colours are not read.
 *
 * Sizes are checked before pixels are decoded: ALPHA_IMAGE_MAX_PX a side, PIXELS_MAX an image, and l.pixels_left in total.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/scene/gltf/gltf_loader.h"

#include <png.h>
#include <webp/decode.h>

namespace gltf
{

static constexpr size_t IMAGE_BYTES_MAX = (size_t)1 << 28; /* of an image file */
static constexpr size_t PIXELS_MAX      = (size_t)1 << 26; /* per image, decoded to four bytes each */

static void check_pixels(loader &l, const std::string &where, int width, int height, image_colours &out)
{
    if (width < 1 || height < 1 || width > (int)ALPHA_IMAGE_MAX_PX || height > (int)ALPHA_IMAGE_MAX_PX)
        l.unsupported(where, "%d x %d pixels, expected 1 to %u a side", width, height, ALPHA_IMAGE_MAX_PX);
    size_t pixels = (size_t)width * (size_t)height;
    if (pixels > PIXELS_MAX || pixels > l.pixels_left)
        l.unsupported(where, "%d x %d pixels: textures may have %zu in an image, %zu together", width, height, PIXELS_MAX,
                      ALPHA_PIXELS_MAX);
    l.pixels_left -= pixels;
    l.need(5 * pixels, where); /* four bytes per pixel, and one for its alpha */
    out.width_px  = (uint32_t)width;
    out.height_px = (uint32_t)height;
}

static image_alpha alpha_of(const image_colours &image)
{
    image_alpha out = {};
    out.width_px    = image.width_px;
    out.height_px   = image.height_px;
    out.least = out.most = 255;
    out.has_alpha        = image.has_alpha;
    if (image.rgba.empty()) return out;
    out.alpha.resize(image.rgba.size() / 4);
    for (size_t i = 0; i < out.alpha.size(); i++) out.alpha[i] = image.rgba[4 * i + 3];
    auto [least, most] = std::minmax_element(out.alpha.begin(), out.alpha.end());
    out.least          = *least;
    out.most           = *most;
    return out;
}

/* Frees libpng's memory in all cases. */
struct png_reader {
    png_image image = {};
    ~png_reader() { png_image_free(&image); }
};

static void decode_png(loader &l, const std::string &where, const unsigned char *from, size_t size, image_colours &out)
{
    png_reader png;
    png.image.version = PNG_IMAGE_VERSION;
    if (!png_image_begin_read_from_memory(&png.image, from, size)) l.broken(where, "broken PNG: %s", png.image.message);
    check_pixels(l, where, (int)std::min(png.image.width, (png_uint_32)INT32_MAX),
                 (int)std::min(png.image.height, (png_uint_32)INT32_MAX), out);

    out.has_alpha    = png.image.format & PNG_FORMAT_FLAG_ALPHA;
    png.image.format = PNG_FORMAT_RGBA;
    out.rgba.resize(4 * (size_t)out.width_px * out.height_px);
    if (!png_image_finish_read(&png.image, nullptr, out.rgba.data(), 0, nullptr))
        l.broken(where, "broken PNG: %s", png.image.message);
}

static void decode_webp(loader &l, const std::string &where, const unsigned char *from, size_t size, image_colours &out)
{
    WebPBitstreamFeatures features;
    if (WebPGetFeatures(from, size, &features) != VP8_STATUS_OK) l.broken(where, "broken WebP");
    if (features.has_animation) l.unsupported(where, "an animated WebP");
    check_pixels(l, where, features.width, features.height, out);
    out.has_alpha = features.has_alpha;

    out.rgba.resize(4 * (size_t)out.width_px * out.height_px);
    if (!WebPDecodeRGBAInto(from, size, out.rgba.data(), out.rgba.size(), 4 * features.width)) l.broken(where, "broken WebP");
}

/* Name of a known image format that is not supported; NULL: unknown. */
static const char *other_format(const unsigned char *from, size_t size)
{
    static const struct {
        const char *magic, *name;
        size_t      at;
    } formats[] = {{"\xabKTX", "KTX", 0},
                   {"DDS ", "DDS", 0},
                   {"BM", "BMP", 0},
                   {"GIF8", "GIF", 0},
                   {"ftypavif", "AVIF", 4},
                   {"ftyphei", "HEIF", 4},
                   {"\x76\x2f\x31\x01", "OpenEXR", 0},
                   {"#?", "Radiance", 0},
                   {"II*", "TIFF", 0},
                   {"MM", "TIFF", 0},
                   {"8BPS", "Photoshop", 0},
                   {"version https://git-lfs", "a Git LFS pointer (git lfs pull)", 0},
                   {"sB", "basis", 0}};
    for (const auto &f : formats)
        if (size >= f.at + strlen(f.magic) && !memcmp(from + f.at, f.magic, strlen(f.magic))) return f.name;
    return nullptr;
}

static void decode(loader &l, const std::string &where, const unsigned char *from, size_t size, image_colours &out)
{
    auto begins = [from, size](const char *magic, size_t length, size_t at) {
        return size >= at + length && !memcmp(from + at, magic, length);
    };
    if (begins("\x89PNG", 4, 0)) return decode_png(l, where, from, size, out);
    if (begins("RIFF", 4, 0) && begins("WEBP", 4, 8)) return decode_webp(l, where, from, size, out);
    const char *other = other_format(from, size);
    if (!begins("\xff\xd8\xff", 3, 0))
        l.unsupported(where, "not a PNG, JPEG or WebP%s%s", other ? ", but " : "", other ? other : "");
    /* a JPEG is opaque; only check that its start and end markers are there */
    if (!memmem(from, size, "\xff\xd9", 2)) l.broken(where, "broken JPEG: it has no end");
}

static void read_image(loader &l, const std::string &where, const json &object, image_colours &out)
{
    check_shape(l, where, object, {{"uri", is::text}, {"bufferView", is::index}});
    if (object.contains("bufferView")) {
        size_t               view  = object["bufferView"];
        const unsigned char *bytes = whole_view(l, where, view);
        return decode(l, where, bytes, l.views[view].length, out);
    }
    std::string uri = object.value("uri", "");
    if (uri.empty()) l.error(VXS_E_SCENE, "%s has neither a uri nor a bufferView", where.c_str());
    file_bytes owned = is_data(uri) ? data_of(l, where, uri) : read_beside(l, where, uri, IMAGE_BYTES_MAX);
    decode(l, where, owned.data(), owned.size(), out);
}

static std::string text_member(const json &object, const char *name, const std::string &absent)
{
    auto found = object.find(name);
    return found != object.end() && found->is_string() ? found->get<std::string>() : absent;
}

static image_colours colours_of(loader &l, size_t index)
{
    const json   &object = items(l.rest, "images")[index];
    std::string   name   = text_member(object, "name", text_member(object, "uri", ""));
    image_colours image  = {};
    read_image(l, label("image", index, is_data(name) ? "" : name), object, image);
    return image;
}

image_alpha &use_image(loader &l, size_t index)
{
    auto found = l.images.find(index);
    if (found != l.images.end()) return found->second;
    return l.images.emplace(index, alpha_of(colours_of(l, index))).first->second;
}

image_colours &use_colours(loader &l, size_t index)
{
    auto found = l.colours.find(index);
    if (found != l.colours.end()) return found->second;
    return l.colours.emplace(index, colours_of(l, index)).first->second;
}

} // namespace gltf
