/* Parse the bytes of a file into tinygltf's model.
 *
 * tinygltf gets only the lists of nodes, meshes and accessors. Buffers are read here, without a copy of the GLB's bytes.
 * Animations, cameras and images are not passed on, so that it cannot fail on them.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <fstream> /* which tinygltf forgets */

#define TINYGLTF_IMPLEMENTATION
#include "baker/scene/gltf/gltf_loader.h"

namespace gltf
{

static void load_model(loader &l, json &root)
{
    json             part = take_model(root);
    std::vector<int> indices; /* of all primitives, taken out of the JSON: tinygltf insists that they have a bufferView */
    for (size_t i = 0; i < items(part, "meshes").size(); i++)
        for (json &primitive : part["meshes"][i]["primitives"]) {
            indices.push_back(primitive.value("indices", -1));
            primitive.erase("indices");
        }
    std::string text = part.dump(), error, warning;
    part             = json();

    tinygltf::TinyGLTF gltf;
    bool               ok   = gltf.LoadASCIIFromString(&l.model, &error, &warning, text.data(), (unsigned)text.size(), "");
    size_t             next = 0;
    for (tinygltf::Mesh &mesh : l.model.meshes)
        for (tinygltf::Primitive &p : mesh.primitives)
            if (next < indices.size()) p.indices = indices[next++];
    if (error.find("bad_alloc") != std::string::npos) throw std::bad_alloc(); /* tinygltf converts every exception to a text */
    if (!ok || next != indices.size()) l.broken("", "%s", one_line(error).c_str());
}

void parse(loader &l)
{
    container c    = open_container(l);
    json      root = parse_json(l, c);
    check_json(l, root);
    check_files_beside(l, root);
    read_buffers(l, root, c);
    read_buffer_views(l, root);
    read_lights(l, root);
    read_skins(l, root);
    read_materials(l, root);
    read_flags(l, root);
    l.camera_count = items(root, "cameras").size();
    for (const char *list : {"extensionsUsed", "extensionsRequired"})
        for (const json &name : items(root, list)) l.quantization |= name == "KHR_mesh_quantization";
    root.erase("buffers"); /* with their data URIs */

    load_model(l, root);
    l.rest = std::move(root);
}

} // namespace gltf
