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

/* The indices of all primitives, mesh by mesh, taken out of the JSON: tinygltf insists that they have a bufferView. */
static std::vector<int> take_indices(json &model)
{
    std::vector<int> indices;
    for (size_t i = 0; i < items(model, "meshes").size(); i++)
        for (json &primitive : model["meshes"][i]["primitives"]) {
            indices.push_back(primitive.value("indices", -1));
            primitive.erase("indices");
        }
    return indices;
}

static void load_model(loader &l, json &root)
{
    json             part    = take_model(root);
    std::vector<int> indices = take_indices(part);
    std::string      text    = part.dump(), error, warning;
    part                     = json();

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
