/* What the files of the glTF loader share; private to baker/gltf/gltf_*.cc and scene_gltf.cc.
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
#include <memory>
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

constexpr size_t FILE_BYTES_MAX   = UINT32_MAX;      /* GLB and tinygltf count in 32 bits */
constexpr size_t TRIANGLES_MAX    = (size_t)1 << 26; /* of the whole scene: instancing makes scenes much larger than files */
constexpr size_t DENSE_MAX        = (size_t)1 << 24; /* elements that sparse accessors may expand to, together */
constexpr size_t DECODED_MAX      = (size_t)1 << 30; /* bytes that compressed bufferViews may expand to, together */
constexpr size_t ALPHA_PIXELS_MAX = (size_t)1 << 28; /* of all images that masks need */
constexpr long   JSON_DEPTH_MAX   = 200;             /* tinygltf recurses into extras */

/* An accessor's elements, known to lie in their bufferView; use_accessor finds the data. */
struct elements {
    const unsigned char       *data;
    size_t                     stride, count, size; /* size: bytes of an element */
    int                        component;           /* TINYGLTF_COMPONENT_TYPE_* */
    bool                       normalized;
    bool                       ready;         /* data is there */
    size_t                     indices_below; /* of indices that were looked at: all are less; 0 before */
    std::vector<unsigned char> dense;         /* owns data when the accessor is sparse or has no bufferView */
};

struct buffer {
    const unsigned char       *data; /* NULL: a fallback for readers that know no compression, never read */
    size_t                     size_bytes;
    bool                       missing; /* neither a uri nor a GLB chunk */
    std::vector<unsigned char> owned;   /* unless data is the GLB's own */
};

/* EXT_meshopt_compression, KHR_meshopt_compression: the bytes of a bufferView as they are stored. */
struct compressed_view {
    const char *extension; /* NULL: not compressed */
    size_t      buffer, offset, length, count, stride;
    std::string mode, filter;
};

struct buffer_view {
    size_t                     buffer, offset, length, stride; /* stride 0: elements follow each other */
    compressed_view            compressed;
    std::vector<unsigned char> decoded; /* once it was asked for */
};

/* An image's alpha; a JPEG's has no pixels, and is 255. */
struct image_alpha {
    uint32_t             width_px, height_px;
    std::vector<uint8_t> alpha; /* [height * width] */
    uint8_t              least, most;
    size_t               in_scene = SIZE_MAX; /* its number there, when a mask needs it */
};

/* Where a material with alphaMode MASK is a surface. */
struct material_mask {
    enum { UNKNOWN, PLAIN, HOLES, NOWHERE } kind = UNKNOWN;
    double   threshold                           = 0;
    uint32_t mask                                = 0; /* HOLES: index into l.masks */
    size_t   uv_set                              = 0;
    double   uv_transform[6]                     = {1, 0, 0, 0, 1, 0}; /* two rows: u, v, 1 */
    size_t   left_out                            = 0;                  /* NOWHERE: triangles */
};

/* What the baker reads of a material. */
struct material {
    std::string   name;
    bool          double_sided, mask;
    material_mask holes;
};

/* A primitive whose vertices and indices come from KHR_draco_mesh_compression. */
struct draco_primitive {
    std::map<std::string, elements> attributes; /* POSITION; with a mask, all that its alpha is made of */
    elements                        indices;
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

struct morph {
    double          weight; /* not 0 */
    int             accessor;
    const elements *positions;
};

/* One primitive placed by one node. */
struct placement {
    const tinygltf::Primitive *primitive;
    const draco_primitive     *draco; /* NULL: not compressed */
    const elements            *positions;
    const elements            *indices; /* NULL: 0, 1, 2, ... */
    const elements            *uvs;     /* NULL: no mask */
    const material_mask       *mask;    /* NULL: no material */
    std::vector<morph>         targets;
    transform                  ws_from_node;
    int                        mode;
    bool                       mirrored;
    uint8_t                    flags;
    size_t                     triangles;
};

struct loader {
    message        *m;
    const char     *path;
    scene          *s;
    bool            files_beside; /* buffers and images may be in other files */
    tinygltf::Model model;

    std::vector<unsigned char> bytes; /* of the file; a GLB's buffer 0 lies in it */
    std::shared_ptr<json>      rest;  /* what tinygltf does not get: materials, textures, samplers, images */

    std::vector<buffer>           buffers;
    std::vector<buffer_view>      views;
    std::vector<material>         materials;
    std::vector<light_definition> lights;
    size_t                        camera_count = 0;
    bool                          quantization = false; /* KHR_mesh_quantization is used */

    std::vector<elements> accessors;
    size_t                dense_left = DENSE_MAX, decoded_left = DECODED_MAX;

    std::map<const tinygltf::Primitive *, draco_primitive> draco;

    std::map<size_t, image_alpha>    images; /* those that were looked at, by the file's number */
    size_t                           pixels_left = ALPHA_PIXELS_MAX;
    std::vector<const image_alpha *> mask_images; /* the scene's */
    std::vector<alpha_mask>          masks;
    std::vector<mask_triangle>       mask_triangles;

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
    bool        binary;

    const unsigned char *bin; /* NULL: there is none */
    size_t               bin_size;
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

vxs_result parse_json(loader &l, const container &c, json &root);
vxs_result check_json(loader &l, const json &root);

/* From the file to l.model, with all that is read of it in shape. */
vxs_result parse(loader &l);

/* ---- gltf_buffers.cc, gltf_meshopt.cc ---- */

/* The bytes of every buffer, and the bufferViews, which lie in them. */
vxs_result read_buffers(loader &l, const json &root, const container &c);
vxs_result read_buffer_views(loader &l, const json &root);

/* No buffer is missing: said after all faults that can be seen without data. */
vxs_result check_buffers(loader &l);

/* A file beside the scene, by the uri of a buffer or an image; at most `limit` bytes of it. `what` uses it. */
vxs_result read_beside(loader &l, const std::string &what, const std::string &uri, size_t limit, std::vector<unsigned char> &bytes);

/* The bytes after the comma of a base64 data URI. */
bool decode_base64(const std::string &text, std::vector<unsigned char> &bytes);

/* The `length` bytes of a bufferView, decompressed once. */
vxs_result view_bytes(loader &l, size_t view, const unsigned char *&data);

vxs_result read_compressed_view(loader &l, const std::string &where, const json &view, compressed_view &c);
vxs_result decode_view(loader &l, size_t index);

/* ---- gltf_accessors.cc ---- */

size_t     component_bytes(int component);
vxs_result check_accessors(loader &l);

/* Where the first element of an accessor with a bufferView begins. */
size_t offset_in_buffer(const loader &l, const tinygltf::Accessor &a);

/* An accessor's elements: in the buffer, or made dense once. */
vxs_result use_accessor(loader &l, int index, const elements *&out);

/* A little-endian number of 1, 2 or 4 bytes. */
uint32_t unsigned_at(const unsigned char *at, size_t size);

/* A component at `at`: a float, or an integer, normalised if it is so (3.11, KHR_mesh_quantization). */
double component_at(const unsigned char *at, int component, bool normalized);

/* ---- gltf_draco.cc ---- */

/* A primitive that is there in compressed form only. */
bool needs_draco(const loader &l, const tinygltf::Primitive &p);

/* Decode it once. */
vxs_result use_draco(loader &l, const std::string &where, const tinygltf::Primitive &p, const draco_primitive *&out);

/* ---- gltf_instances.cc: EXT_mesh_gpu_instancing ---- */

/* How often a node's mesh is placed: 1 without the extension. */
vxs_result count_instances(loader &l, size_t node, size_t &count);

/* Where the i-th of them is. */
vxs_result instance_transform(loader &l, size_t node, size_t i, transform &ws_from_instance);

/* ---- gltf_nodes.cc ---- */

vec3 rotate_scale(const transform &t, vec3 v);
vec3 apply(const transform &t, vec3 v);

/* First b, then a. */
transform multiply(const transform &a, const transform &b);

/* Scale, then rotation by a unit quaternion (x, y, z, w), then translation. */
transform trs_transform(const double translation[3], const double rotation[4], const double scale[3]);

/* A quaternion to unit length; false when it has none. */
bool normalize_rotation(double rotation[4]);

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

vxs_result read_materials(loader &l, const json &root);
vxs_result check_model_meshes(loader &l);

/* No index of an uncompressed primitive is too large, whether a node places it or not. */
vxs_result check_all_indices(loader &l);

/* 3.7.2.1: no index may name a missing vertex or be the largest value of its type, which restarts primitives elsewhere. */
vxs_result check_index_values(loader &l, const elements &indices, int accessor, size_t vertices);

/* Count before allocating: instancing makes scenes much larger than files. */
vxs_result measure(loader &l);
vxs_result place_meshes(loader &l);

/* The accessor elements of a triangle's corners, in the order of the scene's. */
void triangle_elements(const placement &p, size_t t, uint32_t element[3]);

/* ---- gltf_images.cc, gltf_masks.cc ---- */

/* Decode image `index`, which exists, once. */
vxs_result use_image(loader &l, size_t index, image_alpha *&out);

/* Whether a material has holes. */
vxs_result use_material(loader &l, int index, const material_mask *&out);

/* Find the texture coordinates of a placement that has holes. */
vxs_result open_mask(loader &l, const std::string &where, placement &p);
void       warn_about_colors(loader &l, const std::string &where, const placement &p);

/* The holes of the triangles that the placement made, from `first` on. */
vxs_result append_mask_triangles(loader &l, const placement &p, size_t first);

/* Masks and their images, into the scene. */
vxs_result place_masks(loader &l);

/* ---- gltf_lights.cc ---- */

/* The lights of KHR_lights_punctual, into l.lights. */
vxs_result read_lights(loader &l, const json &root);

vxs_result place_lights(loader &l);
vxs_result place_cameras(loader &l);

} // namespace gltf

#endif
