/* The bytes of a glTF file, and of the files beside it; where the JSON is in them (4.4).
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/gltf/gltf_loader.h"

#include <cerrno>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "baker/files/input_file.h"

namespace gltf
{

file_bytes read_bytes(loader &l, const char *path, size_t limit, bool regular_only, int &error)
{
    file_bytes out;
    int        file = regular_only ? open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK) : input_open(path);
    error           = file < 0 ? errno : 0;
    if (error) return out;

    struct stat status;
    if (fstat(file, &status))
        error = errno;
    else if (S_ISDIR(status.st_mode))
        error = EISDIR;
    else if (regular_only && !S_ISREG(status.st_mode))
        error = EINVAL;

    size_t found = 0;
    try {
        if (!error && S_ISREG(status.st_mode))
            l.need(std::min((size_t)status.st_size, limit),
                   strcmp(path, l.path) ? "the file '" + std::string(path) + "'" : "the file");
    } catch (...) {
        close(file);
        throw;
    }
    if (!error) out.resize(S_ISREG(status.st_mode) ? std::min((size_t)status.st_size, limit) : 0);
    while (!error && found < limit) {
        if (found == out.size()) out.resize(std::min(limit, found + std::max(found, (size_t)65536)));
        ssize_t n = read(file, out.data() + found, out.size() - found);
        if (n < 0 && errno != EINTR) error = errno;
        if (n == 0) break;
        if (n > 0) found += (size_t)n;
        if (found == out.size() && S_ISREG(status.st_mode) && found >= (size_t)status.st_size) break;
    }
    close(file);
    out.resize(found);
    return out;
}

void read_scene_file(loader &l, const char *path)
{
    int         reason;
    struct stat status;
    l.file            = read_bytes(l, path, FILE_BYTES_MAX, false, reason);
    /* what comes through a pipe lies nowhere: beside it are the files of the working folder */
    const char *slash = !stat(path, &status) && S_ISREG(status.st_mode) ? strrchr(path, '/') : nullptr;
    if (slash) l.folder.assign(path, slash + 1);
    if (reason || l.file.empty())
        throw failure{fail(l.m, VXS_E_READ, "cannot read '%s': %s", l.path, reason ? strerror(reason) : "the file is empty")};
    if (l.file.size() >= FILE_BYTES_MAX) l.unsupported("", "is 4 GiB or larger");
}

static constexpr uint32_t JSON_CHUNK = 0x4e4f534a, BIN_CHUNK = 0x004e4942;

static uint32_t u32_at(const file_bytes &file, size_t offset)
{
    const unsigned char *b = file.data() + offset;
    return (uint32_t)b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
}

container open_container(loader &l)
{
    const file_bytes &file = l.file;
    container         c    = {(const char *)file.data(), file.size(), nullptr, 0};
    if (file.size() < 4 || memcmp(file.data(), "glTF", 4)) return c;

    if (file.size() < 20) l.broken("GLB header", "%zu bytes found, at least 20 expected", file.size());
    uint32_t version = u32_at(file, 4), length = u32_at(file, 8), text_size = u32_at(file, 12);
    if (version != 2) l.unsupported("", "GLB version %u, expected 2", version);
    if (length > file.size()) l.broken("", "GLB header promises %u bytes, the file has %zu", length, file.size());
    if (u32_at(file, 16) != JSON_CHUNK) l.broken("", "the first GLB chunk is not JSON");
    if (!text_size || text_size % 4 || length < 20 || text_size > length - 20)
        l.broken("", "GLB JSON chunk of %u bytes in a file of %u: it must fit and be a multiple of 4", text_size, length);
    c.text += 20;
    c.text_size = text_size;

    size_t at = 20 + (size_t)text_size;
    for (size_t n = 1; at < length; n++) {
        if (length - at < 8 || u32_at(file, at) > length - at - 8) l.broken("", "GLB chunk %zu does not fit in the file", n);
        uint32_t size = u32_at(file, at), type = u32_at(file, at + 4);
        if (n == 1 && type != BIN_CHUNK) l.broken("", "the second GLB chunk is not BIN");
        if (n > 1 && (type == BIN_CHUNK || type == JSON_CHUNK)) l.broken("", "GLB chunk %zu is a second one of its type", n);
        if (n == 1) c.bin = file.data() + at + 8, c.bin_size = size;
        at += std::min((size_t)8 + (size + 3) / 4 * 4, (size_t)length - at); /* other types are for others */
    }
    return c;
}

} // namespace gltf
