/* tinygltf, and what it is not trusted with: its paths, its images.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <fstream> /* which tinygltf forgets */

#define TINYGLTF_IMPLEMENTATION
#include "baker/scene/gltf_loader.h"

namespace gltf
{

/* tinygltf would also look in the working directory and read '+' as a space: its paths are not used, only its order. */
static bool read_buffer_file(std::vector<unsigned char> *out, std::string *, const std::string &, void *user)
{
    loader &l = *(loader *)user;
    if (l.next_file >= l.buffer_files.size()) return false;
    const buffer_file &wanted = l.buffer_files[l.next_file++];

    int reason = read_bytes(wanted.path.c_str(), wanted.size_bytes, true, *out);
    if (reason) {
        l.error(VXS_E_READ, "cannot read its buffer '%s': %s", wanted.path.c_str(), strerror(reason));
        return false;
    }
    if (out->size() < wanted.size_bytes) {
        l.error(VXS_E_READ, "its buffer '%s' ends after %zu bytes, expected %zu", wanted.path.c_str(), out->size(),
                wanted.size_bytes);
        return false;
    }
    return true;
}

static bool any_file_exists(const std::string &, void *)
{
    return true;
}

static std::string same_path(const std::string &path, void *)
{
    return path;
}

static bool drop_image(tinygltf::Image *, const int, std::string *, std::string *, int, int, const unsigned char *, int, void *)
{
    return true;
}

/* tinygltf's own errors on success concern what is not read here: images, animations, cameras. */
vxs_result parse(loader &l)
{
    std::vector<unsigned char> bytes;
    container                  c;
    vxs_result                 r;
    if ((r = read_scene_file(l, bytes)) != VXS_OK) return r;
    if ((r = open_container(l, bytes, c)) != VXS_OK) return r;
    if ((r = check_json(l, c)) != VXS_OK) return r;

    tinygltf::TinyGLTF gltf;
    gltf.SetImageLoader(drop_image, nullptr);
    gltf.SetFsCallbacks({any_file_exists, same_path, read_buffer_file, nullptr, &l});
    std::string error, warning;
    bool        ok = c.binary ? gltf.LoadBinaryFromMemory(&l.model, &error, &warning, bytes.data(), (unsigned)bytes.size())
                              : gltf.LoadASCIIFromString(&l.model, &error, &warning, c.text, (unsigned)c.text_size, "");
    if (ok) return VXS_OK;
    if (l.m->error[0]) return VXS_E_READ; /* said by read_buffer_file */
    return l.error(VXS_E_SCENE, "%s", one_line(error).c_str());
}

} // namespace gltf
