/* Buffers and bufferViews (3.6.1), and files beside the scene.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/scene/gltf/gltf_loader.h"

#include <algorithm>
#include <cerrno>
#include <dirent.h>
#include <strings.h>
#include <sys/stat.h>

#include "baker/files/run_files.h"

namespace gltf
{

static std::string percent_decoded(const std::string &uri)
{
    std::string text;
    for (size_t i = 0; i < uri.size(); i++) {
        unsigned code;
        if (uri[i] == '%' && i + 2 < uri.size() && isxdigit((unsigned char)uri[i + 1]) && isxdigit((unsigned char)uri[i + 2]) &&
            sscanf(uri.c_str() + i + 1, "%2x", &code) == 1) {
            text += (char)code;
            i += 2;
        } else {
            text += uri[i];
        }
    }
    return text;
}

static bool begins_with(const std::string &text, const char *lower)
{
    return !strncasecmp(text.c_str(), lower, strlen(lower));
}

/* ---- files beside the scene ---- */

static bool is_there(const loader &l, const std::string &path)
{
    struct stat status;
    return l.files_beside && path.find('\0') == std::string::npos && !stat((l.folder + path).c_str(), &status);
}

/* The file of a URI, relative to the scene's folder. Some exporters do not percent-encode names, or write backslashes as
 * separators; these forms are tried if the file by the standard does not exist. */
static std::string file_of(const loader &l, const std::string &uri)
{
    std::string path = percent_decoded(begins_with(uri, "file://") ? uri.substr(7) : uri), slashed = path;
    if (is_there(l, path)) return path;
    std::replace(slashed.begin(), slashed.end(), '\\', '/');
    if (is_there(l, slashed)) return slashed;
    return is_there(l, uri) ? uri : path;
}

static std::string path_beside(const loader &l, const std::string &file)
{
    return file[0] == '/' ? file : l.folder + file;
}

/* 1 when a path leaves the scene's folder. Symbolic links inside it are not checked: they are their owner's responsibility. */
static bool leads_out(const std::string &file)
{
    long depth = 0;
    if (file[0] == '/' || file[0] == '\\' || (isalpha((unsigned char)file[0]) && file[1] == ':')) return true;
    for (size_t begin = 0; begin <= file.size();) {
        size_t      end  = std::min(file.find_first_of("/\\", begin), file.size());
        std::string part = file.substr(begin, end - begin);
        depth += part == ".." ? -1 : !part.empty() && part != ".";
        if (depth < 0) return true;
        begin = end + 1;
    }
    return false;
}

bool is_data(const std::string &uri)
{
    return begins_with(uri, "data:");
}

static void check_file_beside(loader &l, const std::string &what, const json &object)
{
    auto               found = object.find("uri");
    const std::string *uri   = found == object.end() ? nullptr : found->get_ptr<const std::string *>();
    if (!uri || uri->empty() || is_data(*uri)) return;
    std::string path = path_beside(l, file_of(l, *uri));
    if (path == "-") path = "./-"; /* here "-" is a file name, not standard input */
    vxs_result r = run_files_check_input(path.c_str(), (what + " of '" + l.path + "'").c_str(), l.m);
    if (r != VXS_OK) throw failure{r, "", true};
}

void check_files_beside(loader &l, const json &root)
{
    size_t index = 0;
    if (!l.files_beside) return;
    for (const json &object : items(root, "buffers")) check_file_beside(l, label("buffer", index++), object);
    index = 0;
    for (const json &object : items(root, "images")) check_file_beside(l, label("image", index++), object);
}

/* A file in the same folder whose name differs only in case: on other systems this is the same file. */
static std::string other_case(const std::string &path)
{
    char        folder[PATH_MAX];
    const char *name  = path_split(path.c_str(), folder);
    DIR        *files = name ? opendir(folder) : nullptr;
    std::string found;
    for (struct dirent *file; files && (file = readdir(files));)
        if (!strcasecmp(file->d_name, name) && (found.empty() || found > file->d_name)) found = file->d_name;
    if (files) closedir(files);
    return found;
}

file_bytes read_beside(loader &l, const std::string &what, const std::string &uri, size_t limit)
{
    std::string file = file_of(l, uri), path = path_beside(l, file), shown = shown_uri(file);
    if (path.find('\0') != std::string::npos) l.refused(what, "uri '%s' holds a zero byte", shown.c_str());
    for (const char *scheme : {"http:", "https:", "ftp:", "blob:"})
        if (begins_with(uri, scheme))
            l.refused(what, "'%s' is not a file: fetch it, and refer to it by its name beside the scene", shown.c_str());
    if (!l.files_beside) throw failure{VXS_E_READ, what + " is in another file, '" + shown + "', and only this one is read", true};
    if (leads_out(file) && !l.choice->allow_outside)
        throw failure{VXS_E_READ,
                      what + ": '" + shown +
                          "' is not in the scene's folder: --allow-outside reads it all the same, or put it beside the scene",
                      true};
    int        reason;
    file_bytes found = read_bytes(l, path.c_str(), limit, true, reason);
    if (!reason) return found;
    std::string text = "cannot read " + what + ", '" + shown_uri(path) + "': " + strerror(reason),
                near = reason == ENOENT ? other_case(path) : "";
    throw failure{VXS_E_READ, text + (near.empty() ? "" : "; there is '" + near + "': rename it"), true};
}

/* ---- data URIs (RFC 2397): data:[type][;parameter]...[;base64],data; the prefix is not case-sensitive ---- */

static int sextet(char c)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const char       *found    = c ? strchr(digits, c == '-' ? '+' : c == '_' ? '/' : c) : nullptr;
    return found ? (int)(found - digits) : -1;
}

/* Decode base64. White space is ignored, and final padding may be missing. Returns the number of valid characters. */
static size_t decode_base64(const char *text, size_t size, file_bytes &out)
{
    uint32_t bits = 0;
    int      held = 0;
    size_t   at   = 0;
    out.reserve(size / 4 * 3 + 3);
    for (; at < size && text[at] != '='; at++) {
        int six = sextet(text[at]);
        if (isspace((unsigned char)text[at])) continue;
        if (six < 0) return at;
        bits = bits << 6 | (uint32_t)six;
        held += 6;
        if (held < 8) continue;
        held -= 8;
        out.push_back((unsigned char)(bits >> held));
    }
    while (at < size && (text[at] == '=' || isspace((unsigned char)text[at]))) at++;
    return at;
}

file_bytes data_of(loader &l, const std::string &where, const std::string &uri)
{
    size_t     comma = uri.find(',');
    file_bytes out;
    if (comma == std::string::npos)
        l.broken(where, "'%s' is not a data URI: expected data:application/octet-stream;base64, and the data",
                 shown_uri(uri).c_str());
    std::string head = uri.substr(0, comma);
    while (!head.empty() && isspace((unsigned char)head.back())) head.pop_back();
    bool        is_base64 = head.size() >= 7 && begins_with(head.substr(head.size() - 7), ";base64");
    bool        encoded   = uri.find('%', comma) != std::string::npos;
    std::string text      = encoded ? percent_decoded(uri.substr(comma + 1)) : std::string();
    const char *from      = encoded ? text.data() : uri.data() + comma + 1;
    size_t      size      = encoded ? text.size() : uri.size() - comma - 1;
    if (!is_base64) {
        out.assign(from, from + size);
        return out;
    }
    size_t good = decode_base64(from, size, out);
    if (good < size) l.broken(where, "its data URI has a character that is no base64, %zu behind the comma", good);
    return out;
}

static bool is_fallback(const json &object)
{
    for (const char *name : {"EXT_meshopt_compression", "KHR_meshopt_compression"}) {
        const json *e = extension(object, name);
        if (e && e->value("fallback", json()) == true) return true;
    }
    return false;
}

/* Read the bytes of a buffer. `there` stays 0 if none can be read. */
static void read_buffer(loader &l, const json &object, const container &c, size_t index)
{
    buffer     &b     = l.buffers[index];
    std::string where = label("buffer", index);
    auto        bad   = l.faults[BUFFERS].find(index);
    if (bad != l.faults[BUFFERS].end()) throw bad->second;
    std::string uri = object.value("uri", ""), source = "the GLB chunk";
    size_t      found = c.bin_size;
    b.size_bytes      = object["byteLength"].get<size_t>();
    if (!b.size_bytes) l.broken(where, "byteLength is 0");
    if (is_fallback(object)) return;

    if (uri.empty()) {
        if (!c.bin || index) l.broken("", "buffer %zu has neither a uri nor a GLB chunk", index);
        b.data = c.bin;
    } else {
        if (is_data(uri)) {
            l.need(3 * uri.size(), where);
            b.owned = data_of(l, where, uri);
            source  = "its data URI";
        } else {
            b.owned = read_beside(l, where, uri, b.size_bytes);
            source  = "'" + shown_uri(uri) + "'";
        }
        b.data = b.owned.data();
        found  = b.owned.size();
    }
    b.there = std::min(found, b.size_bytes);
    /* bytes beyond the declared length are ignored */
    if (found < b.size_bytes) l.broken(where, "%s ends after %zu bytes, expected %zu", source.c_str(), found, b.size_bytes);
}

void read_buffers(loader &l, const json &root, const container &c)
{
    l.buffers.resize(items(root, "buffers").size());
    for (size_t i = 0; i < l.buffers.size(); i++) l.buffers[i].fault = caught([&] { read_buffer(l, root["buffers"][i], c, i); });
}

void check_there(loader &l, size_t index, size_t offset, size_t size)
{
    const buffer &b = l.buffers[index];
    if (b.fault && (offset > b.there || size > b.there - offset)) throw b.fault;
}

void check_in_buffer(loader &l, const std::string &where, size_t length, size_t offset, size_t index)
{
    const buffer &b = l.buffers[index];
    if (b.fault && !b.size_bytes) throw b.fault;
    if (!length || offset > b.size_bytes || length > b.size_bytes - offset)
        l.broken(where, "%zu bytes at byte %zu do not fit in buffer %zu of %zu bytes", length, offset, index, b.size_bytes);
}

static void read_buffer_view(loader &l, size_t index, const json &object)
{
    buffer_view &v     = l.views[index];
    std::string  where = label("bufferView", index);
    auto         bad   = l.faults[VIEWS].find(index);
    if (bad != l.faults[VIEWS].end()) throw bad->second;
    v.buffer = object["buffer"].get<size_t>();
    v.offset = object.value("byteOffset", (size_t)0);
    v.length = object["byteLength"].get<size_t>();
    v.stride = object.value("byteStride", (size_t)0);
    if (v.buffer >= l.buffers.size()) l.broken(where, "buffer %zu does not exist", v.buffer);
    if (!v.length) l.broken(where, "byteLength is 0");
    check_in_buffer(l, where, v.length, v.offset, v.buffer);
    read_compressed_view(l, where, object, v.compressed);
    if (v.compressed.extension) check_there(l, v.compressed.buffer, v.compressed.offset, v.compressed.length);
}

void read_buffer_views(loader &l, const json &root)
{
    l.views.resize(items(root, "bufferViews").size());
    for (size_t i = 0; i < l.views.size(); i++) l.views[i].fault = caught([&] { read_buffer_view(l, i, root["bufferViews"][i]); });
}

void check_view_index(loader &l, const std::string &where, size_t view)
{
    if (view >= l.views.size()) l.broken(where, "bufferView %zu does not exist", view);
    if (l.views[view].fault) throw l.views[view].fault;
}

const unsigned char *view_bytes(loader &l, size_t index)
{
    buffer_view &v = l.views[index];
    if (v.compressed.extension) {
        if (v.decoded.empty()) decode_view(l, index);
        return v.decoded.data();
    }
    if (!l.buffers[v.buffer].data)
        l.broken("", "bufferView %zu is not compressed, and its buffer %zu holds nothing but a fallback", index, v.buffer);
    return l.buffers[v.buffer].data + v.offset;
}

const unsigned char *whole_view(loader &l, const std::string &where, size_t index)
{
    check_view_index(l, where, index);
    const buffer_view &v = l.views[index];
    if (!v.compressed.extension) check_there(l, v.buffer, v.offset, v.length);
    return view_bytes(l, index);
}

} // namespace gltf
