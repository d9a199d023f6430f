/* What the files of the glTF loader share; private to baker/scene/gltf_*.cc and scene_gltf.cc.
 *
 *   file -> container (GLB chunks) -> JSON shape -> tinygltf -> node tree -> placements -> triangles in world space
 *
 * Every range is checked before it is read. Functions say why they fail, once, and return the code.
 * Section numbers are those of the glTF 2.0 specification.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef GLTF_LOADER_H
#define GLTF_LOADER_H

#include "baker/scene/scene.h"

#include <cstdio>
#include <cstring>
#include <map>
#include <string>
#include <utility>
#include <vector>

#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_EXTERNAL_IMAGE
#define TINYGLTF_NO_FS
#include <nlohmann/json_fwd.hpp>
#include <tiny_gltf.h>

namespace gltf
{

using json = nlohmann::json;

constexpr size_t FILE_BYTES_MAX = UINT32_MAX;      /* GLB and tinygltf count in 32 bits */
constexpr size_t INDICES_MAX    = (size_t)1 << 31; /* of the whole scene; vertices are never more */
constexpr size_t DENSE_MAX      = (size_t)1 << 25; /* elements that sparse accessors may expand to, together */
constexpr long   JSON_DEPTH_MAX = 200;             /* tinygltf recurses into extras */

/* An accessor's elements, known to lie in their buffer. */
struct elements {
    const unsigned char       *data; /* NULL: all zero, until made dense */
    size_t                     stride, count, size;
    std::vector<unsigned char> dense; /* owns data when the accessor is sparse or has no bufferView */
};

struct buffer_file {
    std::string path;
    size_t      size_bytes; /* as the file promises; the rest of a longer file is not read */
};

struct vec3 {
    double x, y, z;
};

/* Affine, column-major as in glTF: three axes, then the translation. */
struct transform {
    vec3 axis[3], origin;
};

/* A light as the file defines it: position and direction come with the nodes that use it. */
struct light_definition {
    std::string name;
    light_shape shape;
};

struct loader {
    message        *m;
    const char     *path;
    scene          *s;
    tinygltf::Model model;

    std::vector<light_definition> lights;

    std::vector<buffer_file> buffer_files; /* in the order in which tinygltf asks for them */
    size_t                   next_file = 0;

    std::vector<elements> accessors;
    size_t                dense_left = DENSE_MAX;

    std::vector<int>       roots, order; /* the scene's nodes, parents first */
    std::vector<transform> ws_from_node; /* by node */

    /* vertices emitted so far: slot i of the current generation is accessor element i */
    struct slot {
        uint32_t generation, vertex;
    };
    std::vector<slot> slots;
    uint32_t          generation      = 0;
    size_t            vertex_capacity = 0;

    /* Every message names the file first. */
    vxs_result error(vxs_result code, const char *format, ...) __attribute__((format(printf, 3, 4)));
};

/* "node 3 'lamp'" */
std::string label(const char *kind, size_t index, const std::string &name);

/* tinygltf's and nlohmann's texts may hold several lines, whole data URIs, and a bracketed class of error. */
std::string one_line(std::string text);

/* ---- gltf_container.cc ---- */

struct container {
    const char *text;
    size_t      text_size;
    bool        binary, has_bin;
};

/* The first `limit` bytes of a file, or an errno. A file that a scene refers to must be a regular one: a pipe may never end. */
int        read_bytes(const char *path, size_t limit, bool regular_only, std::vector<unsigned char> &bytes);
vxs_result read_scene_file(loader &l, std::vector<unsigned char> &bytes);
vxs_result open_container(loader &l, const std::vector<unsigned char> &bytes, container &c);

/* ---- gltf_json.cc, gltf_parse.cc ---- */

enum class is { index, size, text, flag, numbers, indices, texts, object, objects, extensions, index_map };

struct property {
    const char *name;
    is          kind;
    bool        required = false;
    size_t      count    = 0; /* of numbers; 0: any */
};

/* Members of an object, and of each object of a list, have the types that are given. */
vxs_result check_shape(loader &l, const std::string &where, const json &object, const std::vector<property> &shape);
vxs_result check_list(loader &l, const json &root, const char *list, const char *item_name, const std::vector<property> &shape);

/* The items of a list, none when it is not there. */
const json &items(const json &object, const char *name);

/* The members of extensions.NAME, or NULL. */
const json *extension(const json &object, const char *name);

vxs_result check_json(loader &l, const container &c);

/* From the file to l.model, with all that is read of it in shape. */
vxs_result parse(loader &l);

/* ---- gltf_accessors.cc ---- */

vxs_result check_accessors(loader &l);

/* Where an accessor's elements are: in the buffer, or made dense once. */
vxs_result use_accessor(loader &l, int index, const elements *&out);

/* A little-endian number of 1, 2 or 4 bytes. */
uint32_t unsigned_at(const unsigned char *at, size_t size);

/* ---- gltf_nodes.cc ---- */

vec3 rotate_scale(const transform &t, vec3 v);
vec3 apply(const transform &t, vec3 v);
bool finite(vec3 v);

/* The triangles of a mirrored node turn their backs, unless two corners are swapped (3.7.4). */
bool is_mirrored(const transform &t);

vxs_result check_tree(loader &l, std::vector<int> &parent);
vxs_result check_references(loader &l);
vxs_result choose_scene(loader &l, const char *which, int &chosen);
vxs_result choose_roots(loader &l, int chosen, const std::vector<int> &parent);
vxs_result place_nodes(loader &l, const std::vector<int> &parent);

/* ---- gltf_meshes.cc, gltf_triangles.cc ---- */

/* The accessor of an attribute, or -1. */
int attribute(const std::map<std::string, int> &attributes, const char *name);

/* The weights of a node's morph targets (3.7.2.2): its own, else the mesh's, else none. */
const std::vector<double> &morph_weights(const tinygltf::Node &node, const tinygltf::Mesh &mesh);

bool   makes_triangles(const tinygltf::Primitive &p);
size_t corner_count(const loader &l, const tinygltf::Primitive &p);
size_t triangle_count(const loader &l, const tinygltf::Primitive &p);

vxs_result check_materials(loader &l);
vxs_result check_model_meshes(loader &l);

/* Count before allocating: instancing makes scenes much larger than files. */
vxs_result measure(loader &l);
vxs_result place_meshes(loader &l);

/* ---- gltf_lights.cc ---- */

/* The lights of KHR_lights_punctual, into l.lights. */
vxs_result read_lights(loader &l, const json &root);

vxs_result place_lights(loader &l);
vxs_result place_cameras(loader &l);

} // namespace gltf

#endif
