/* The bytes of a glTF file, and of the files beside it; where the JSON is in them (4.4).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/gltf/gltf_loader.h"

#include <cerrno>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace gltf
{

/* The first `limit` bytes of a file, or an errno. A file that a scene refers to must be a regular one: a pipe may never end.
 */
int read_bytes(const char *path, size_t limit, bool regular_only, std::vector<unsigned char> &bytes)
{
    int file = open(path, O_RDONLY | O_CLOEXEC | (regular_only ? O_NONBLOCK : 0));
    if (file < 0) return errno;

    struct stat status;
    int         reason = 0;
    if (fstat(file, &status))
        reason = errno;
    else if (S_ISDIR(status.st_mode))
        reason = EISDIR;
    else if (regular_only && !S_ISREG(status.st_mode))
        reason = EINVAL;

    size_t found = 0;
    if (!reason) bytes.resize(S_ISREG(status.st_mode) ? std::min((size_t)status.st_size, limit) : 0);
    while (!reason && found < limit) {
        if (found == bytes.size()) bytes.resize(std::min(limit, found + std::max(found, (size_t)65536)));
        ssize_t n = read(file, bytes.data() + found, bytes.size() - found);
        if (n < 0 && errno != EINTR) reason = errno;
        if (n == 0) break;
        if (n > 0) found += (size_t)n;
        if (found == bytes.size() && S_ISREG(status.st_mode) && found >= (size_t)status.st_size) break;
    }
    close(file);
    bytes.resize(found);
    return reason;
}

vxs_result read_scene_file(loader &l, std::vector<unsigned char> &bytes)
{
    int reason = read_bytes(l.path, FILE_BYTES_MAX, false, bytes);
    if (reason) return fail(l.m, VXS_E_READ, "cannot read '%s': %s", l.path, strerror(reason));
    if (bytes.empty()) return fail(l.m, VXS_E_READ, "cannot read '%s': the file is empty", l.path);
    if (bytes.size() >= FILE_BYTES_MAX) return l.error(VXS_E_UNSUPPORTED, "is 4 GiB or larger");
    return VXS_OK;
}

static constexpr uint32_t JSON_CHUNK = 0x4e4f534a, BIN_CHUNK = 0x004e4942;

static uint32_t u32_at(const std::vector<unsigned char> &bytes, size_t offset)
{
    const unsigned char *b = bytes.data() + offset;
    return (uint32_t)b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
}

vxs_result open_container(loader &l, const std::vector<unsigned char> &bytes, container &c)
{
    c = {(const char *)bytes.data(), bytes.size(), false, nullptr, 0};
    if (bytes.size() < 4 || memcmp(bytes.data(), "glTF", 4)) return VXS_OK;

    c.binary = true;
    if (bytes.size() < 20) return l.error(VXS_E_SCENE, "GLB header: %zu bytes found, at least 20 expected", bytes.size());
    uint32_t version = u32_at(bytes, 4), length = u32_at(bytes, 8), text_size = u32_at(bytes, 12);
    if (version != 2) return l.error(VXS_E_UNSUPPORTED, "GLB version %u, expected 2", version);
    if (length > bytes.size()) return l.error(VXS_E_SCENE, "GLB header promises %u bytes, the file has %zu", length, bytes.size());
    if (u32_at(bytes, 16) != JSON_CHUNK) return l.error(VXS_E_SCENE, "the first GLB chunk is not JSON");
    if (!text_size || text_size % 4 || length < 20 || text_size > length - 20)
        return l.error(VXS_E_SCENE, "GLB JSON chunk of %u bytes in a file of %u: it must fit and be a multiple of 4", text_size,
                       length);
    c.text += 20;
    c.text_size = text_size;

    size_t at = 20 + (size_t)text_size;
    for (size_t n = 1; at < length; n++) {
        if (length - at < 8 || u32_at(bytes, at) > length - at - 8)
            return l.error(VXS_E_SCENE, "GLB chunk %zu does not fit in the file", n);
        uint32_t size = u32_at(bytes, at), type = u32_at(bytes, at + 4);
        if (n == 1 && type != BIN_CHUNK) return l.error(VXS_E_SCENE, "the second GLB chunk is not BIN");
        if (n > 1 && (type == BIN_CHUNK || type == JSON_CHUNK))
            return l.error(VXS_E_SCENE, "GLB chunk %zu is a second one of its type", n);
        if (n == 1) c.bin = bytes.data() + at + 8, c.bin_size = size;
        at += std::min((size_t)8 + (size + 3) / 4 * 4, (size_t)length - at); /* other types are for others */
    }
    return VXS_OK;
}

} // namespace gltf
