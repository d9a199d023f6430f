/* The bytes of a glTF file and of files beside it; the chunks of a GLB (4.4).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <cerrno>
#include <endian.h>
#include <fcntl.h>
#include <png.h>
#include <sys/stat.h>
#include <unistd.h>
#include <webp/decode.h>

#include "baker/files/file_access.h"
#include "baker/files/foreign_file.h"
#include "baker/files/input_file.h"
#include "baker/scene/gltf/gltf_loader.h"

namespace gltf
{

namespace
{
struct descriptor {
    int file;
    ~descriptor()
    {
        if (file >= 0) close(file);
    }
};
} // namespace

static constexpr size_t LOOKED_AT = 65536;

/* The same from the caller's files. */
static file_bytes read_from_caller(loader &l, const char *path, size_t limit, int &error, check_head check)
{
    const file_access *access = l.m->access;
    uint64_t           size   = access->size(access->user, path);
    file_bytes         out;
    error = size == FILE_ACCESS_MISSING ? ENOENT : 0;
    if (error) return out;
    if (!check) size = std::min(size, (uint64_t)limit);
    l.need(size, strcmp(path, l.path) ? "the file '" + std::string(path) + "'" : "the file");
    out.resize(size);
    error = access->read(access->user, path, out.data(), out.size());
    if (!error && check) limit = std::min(limit, check(l, out.data(), out.size(), size));
    out.resize(std::min(out.size(), limit));
    return out;
}

file_bytes read_bytes(loader &l, const char *path, size_t limit, bool regular_only, int &error, check_head check)
{
    if (l.m->access) return read_from_caller(l, path, limit, error, check);
    file_bytes  out;
    descriptor  d = {regular_only ? open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK) : input_open(path)};
    struct stat status;
    error = d.file < 0 || fstat(d.file, &status) ? errno : 0;
    if (error) return out;
    bool regular = S_ISREG(status.st_mode);
    if (S_ISDIR(status.st_mode)) error = EISDIR;
    if (!error && regular_only && !regular) error = EINVAL;

    std::string what  = strcmp(path, l.path) ? "the file '" + std::string(path) + "'" : "the file";
    size_t      found = 0, known = regular && !error ? std::min((size_t)status.st_size, limit) : 0;
    auto        make_room = [&](size_t size) {
        l.need(size, what);
        out.resize(size);
    };
    if (!error) make_room(std::min(known, check ? LOOKED_AT : known));
    while (!error && found < limit) {
        if (found == out.size()) make_room(std::min(limit, found < known ? known : found + std::max(found, LOOKED_AT)));
        ssize_t n = read(d.file, out.data() + found, out.size() - found);
        if (n < 0 && errno != EINTR) error = errno;
        if (n > 0) found += (size_t)n;
        if (check && n >= 0 && (n == 0 || found >= LOOKED_AT || found == known)) {
            limit = std::min(limit, check(l, out.data(), found, regular ? (uint64_t)status.st_size : n == 0 ? found : 0));
            known = std::min(known, limit);
            check = nullptr;
        }
        if (n == 0 || (regular && found == out.size() && found >= known)) break;
    }
    out.resize(std::min(found, limit));
    return out;
}

/* Recognize the file format by the first bytes, so that other formats are refused before they are read, however large they are. If
 * it cannot be JSON, only the beginning is read, and the parser reports the error. A GLB contains its own length; a pipe may
 * continue after it.
 * Returns the maximum number of bytes to read. */
static size_t look_at_scene(loader &l, const unsigned char *bytes, size_t size, uint64_t total_bytes)
{
    char text[FOREIGN_BYTES];
    bool is_glb = size >= 12 && !memcmp(bytes, "glTF", 4), is_gltf = may_be_gltf(bytes, size);
    if (!is_gltf && foreign_file_text(text, bytes, size, total_bytes)) l.refused("", "is %s, expected glTF", text);
    if (total_bytes >= FILE_BYTES_MAX) l.refused("", "is 4 GiB or larger, and a glTF file is less");
    if (!is_gltf) return size;
    uint32_t length = 0;
    if (is_glb) memcpy(&length, bytes + 8, sizeof length);
    return is_glb && !total_bytes && le32toh(length) >= 20 ? le32toh(length) : FILE_BYTES_MAX;
}

void read_scene_file(loader &l, const char *path)
{
    int         reason;
    struct stat status;
    l.file            = read_bytes(l, path, FILE_BYTES_MAX, false, reason, look_at_scene);
    /* a pipe has no folder: files beside the scene are in the working folder */
    const char *slash = l.m->access || (!stat(path, &status) && S_ISREG(status.st_mode)) ? strrchr(path, '/') : nullptr;
    if (slash) l.folder.assign(path, slash + 1);
    if (reason || l.file.empty())
        throw failure{fail(l.m, reason == ENOMEM ? VXS_E_MEMORY : VXS_E_READ, "cannot read '%s': %s", l.path,
                           reason ? strerror(reason) : "the file is empty"),
                      "", true};
    if (l.file.size() >= FILE_BYTES_MAX) l.refused("", "is 4 GiB or larger, and a glTF file is less");
}

static constexpr uint32_t JSON_CHUNK = 0x4e4f534a, BIN_CHUNK = 0x004e4942;

static uint32_t u32_at(const file_bytes &file, size_t offset)
{
    const unsigned char *b = file.data() + offset;
    return (uint32_t)b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
}

static container open_chunks(loader &l, size_t length)
{
    const file_bytes &file      = l.file;
    container         c         = {(const char *)file.data() + 20, u32_at(file, 12), nullptr, 0};
    uint32_t          text_size = u32_at(file, 12);
    if (u32_at(file, 16) != JSON_CHUNK) l.broken("", "the first GLB chunk is not JSON");
    if (!text_size || length < 20 || text_size > length - 20)
        l.broken("", "GLB JSON chunk of %u bytes in a file of %zu: it must be there, and fit", text_size, length);

    /* the next chunk is at the next multiple of four, or directly after the JSON, where some exporters put it */
    size_t at = 20 + (size_t)text_size, aligned = (at + 3) / 4 * 4;
    if (at == aligned || at + 8 > length || u32_at(file, at + 4) != BIN_CHUNK) at = std::min(aligned, length);
    for (size_t n = 1; at < length; n++) {
        if (length - at < 8 || u32_at(file, at) > length - at - 8) l.broken("", "GLB chunk %zu does not fit in the file", n);
        uint32_t size = u32_at(file, at), type = u32_at(file, at + 4);
        if (n == 1 && type != BIN_CHUNK) l.broken("", "the second GLB chunk is not BIN");
        if (n > 1 && (type == BIN_CHUNK || type == JSON_CHUNK)) l.broken("", "GLB chunk %zu is a second one of its type", n);
        if (n == 1) c.bin = file.data() + at + 8, c.bin_size = size;
        at += std::min((size_t)8 + (size + 3) / 4 * 4, (size_t)length - at); /* chunks of other types are ignored */
    }
    while (c.text_size && !c.text[c.text_size - 1]) c.text_size--; /* some writers pad with zeros instead of spaces */
    return c;
}

/* A header may declare a wrong file length: this is accepted if the chunks are complete. */
container open_container(loader &l)
{
    const file_bytes &file = l.file;
    if (file.size() < 4 || memcmp(file.data(), "glTF", 4)) return {(const char *)file.data(), file.size(), nullptr, 0};

    if (file.size() < 20) l.broken("GLB header", "%zu bytes found, at least 20 expected", file.size());
    uint32_t version = u32_at(file, 4), length = u32_at(file, 8);
    if (version != 2)
        l.refused("", "GLB version %u, expected 2%s", version,
                  version == 1 ? ": binary glTF 1.0 is another format; convert it with gltf-pipeline, or export it again" : "");
    if (length <= file.size()) return open_chunks(l, length);
    container c = {};
    if (caught([&] { c = open_chunks(l, file.size()); }))
        l.broken("", "GLB header promises %u bytes, the file has %zu: it is not all there; copy it again", length, file.size());
    take_note(l, cost::TREE, (uint64_t)1 << 52, "GLB header",
              "promises " + std::to_string(length) + " bytes, the file has " + std::to_string(file.size()) +
                  ": its chunks are whole, and read",
              "export it again");
    return c;
}

/* Images for masks and lights: PNG with libpng, WebP with libwebp. A JPEG has no alpha, and its colours are not read.
 *
 * Sizes are checked before pixels are decoded: ALPHA_IMAGE_MAX_PX a side, PIXELS_MAX an image, and l.pixels_left in total. */

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

static void decode(loader &l, const std::string &where, const unsigned char *from, size_t size, image_colours &out)
{
    /* formats that are not read, by name for the message */
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
    auto begins = [from, size](const char *magic, size_t at) {
        return size >= at + strlen(magic) && !memcmp(from + at, magic, strlen(magic));
    };
    if (begins("\x89PNG", 0)) return decode_png(l, where, from, size, out);
    if (begins("RIFF", 0) && begins("WEBP", 8)) return decode_webp(l, where, from, size, out);
    if (!begins("\xff\xd8\xff", 0)) {
        for (const auto &f : formats)
            if (begins(f.magic, f.at)) l.unsupported(where, "not a PNG, JPEG or WebP, but %s", f.name);
        l.unsupported(where, "not a PNG, JPEG or WebP");
    }
    /* a JPEG is opaque; only check that its start and end markers are there */
    if (!memmem(from, size, "\xff\xd9", 2)) l.broken(where, "broken JPEG: it has no end");
}

static image_colours colours_of(loader &l, size_t index)
{
    const json   &object = items(l.rest, "images")[index];
    std::string   name   = text_of(object, "name", text_of(object, "uri"));
    std::string   where  = label("image", index, is_data(name) ? "" : name);
    image_colours out    = {};
    check_shape(l, where, object, {{"uri", is::text}, {"bufferView", is::index}});
    if (object.contains("bufferView")) {
        size_t               view  = object["bufferView"];
        const unsigned char *bytes = whole_view(l, where, view);
        decode(l, where, bytes, l.views[view].length, out);
        return out;
    }
    std::string uri = object.value("uri", "");
    if (uri.empty()) l.error(VXS_E_SCENE, "%s has neither a uri nor a bufferView", where.c_str());
    file_bytes owned = is_data(uri) ? data_of(l, where, uri) : read_beside(l, where, uri, IMAGE_BYTES_MAX);
    decode(l, where, owned.data(), owned.size(), out);
    return out;
}

image_alpha &use_image(loader &l, size_t index)
{
    auto found = l.images.find(index);
    if (found != l.images.end()) return found->second;
    image_colours image = colours_of(l, index);
    image_alpha   out   = {image.width_px, image.height_px, {}, 255, 255, image.has_alpha};
    for (size_t i = 3; i < image.rgba.size(); i += 4) out.alpha.push_back(image.rgba[i]);
    if (!out.alpha.empty()) {
        auto [least, most] = std::minmax_element(out.alpha.begin(), out.alpha.end());
        out.least          = *least;
        out.most           = *most;
    }
    return l.images.emplace(index, out).first->second;
}

image_colours &use_colours(loader &l, size_t index)
{
    auto found = l.colours.find(index);
    if (found != l.colours.end()) return found->second;
    return l.colours.emplace(index, colours_of(l, index)).first->second;
}

} // namespace gltf
