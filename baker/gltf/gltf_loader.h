/* What the files of the glTF loader share; private to baker/gltf/.
 *
 *   file -> container (GLB chunks) -> JSON shape -> tinygltf -> node tree -> placements -> triangles in world space
 *
 * Every range is checked before it is read. What fails writes its message, once, and throws `failure`, as the libraries below throw
 * errors of their own; scene_gltf.cc catches all of them and returns a result.
 * Section numbers are those of the glTF 2.0 specification.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef GLTF_LOADER_H
#define GLTF_LOADER_H

#include "baker/base/pages.h"
#include "baker/scene/scene.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>
#include <new>
#include <string>
#include <vector>

#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_EXTERNAL_IMAGE
#define TINYGLTF_NO_FS
#include <nlohmann/json.hpp>
#include <tiny_gltf.h>

namespace gltf
{

using json  = nlohmann::json;
using bytes = std::vector<unsigned char>;

/* For arrays that lie on large pages, and are not filled with zeros before something is read into them. */
template <typename item> struct unfilled {
    using value_type = item;

    item *allocate(size_t count)
    {
        void *memory = pages_alloc(count * sizeof(item));
        if (!memory) throw std::bad_alloc();
        return (item *)memory;
    }
    void deallocate(item *memory, size_t) { free(memory); }

    void                           construct(item *at) { ::new ((void *)at) item; }
    template <typename value> void construct(item *at, value &&from) { ::new ((void *)at) item(from); }

    bool operator==(const unfilled &) const { return true; }
    bool operator!=(const unfilled &) const { return false; }
};
using file_bytes = std::vector<unsigned char, unfilled<unsigned char>>;

constexpr size_t FILE_BYTES_MAX   = UINT32_MAX;      /* GLB and tinygltf count in 32 bits */
constexpr size_t TRIANGLES_MAX    = (size_t)1 << 26; /* of the whole scene: instancing makes scenes much larger than files */
constexpr size_t DENSE_MAX        = (size_t)1 << 24; /* elements that sparse accessors may expand to, together */
constexpr size_t DECODED_MAX      = (size_t)1 << 30; /* bytes that compressed bufferViews may expand to, together */
constexpr size_t ALPHA_PIXELS_MAX = (size_t)1 << 28; /* of all images whose alpha is read */
constexpr long   JSON_DEPTH_MAX   = 200;             /* tinygltf recurses into extras */

struct failure {
    vxs_result code;
};

/* An accessor's elements, known to lie in their bufferView; use_accessor finds the data. */
struct elements {
    std::string          label; /* "accessor 3 'name'" */
    const unsigned char *data;
    size_t               stride, count, size; /* size: bytes of an element */
    int                  type;                /* TINYGLTF_TYPE_* */
    int                  component;           /* TINYGLTF_COMPONENT_TYPE_* */
    size_t               component_size;      /* bytes: 1, 2 or 4 */
    bool                 normalized;
    bool                 ready;         /* data is there */
    mutable size_t       indices_below; /* every one, taken as an index, is less; 0: not looked for */
    bytes                dense;         /* owns data when the accessor is sparse, compressed, or has no bufferView */

    /* Element i of indices: of 1, 2 or 4 bytes. */
    uint32_t index(size_t i) const
    {
        const unsigned char *at = data + i * stride;
        uint16_t             two;
        uint32_t             four;
        if (size == 1) return *at;
        if (size == 2) return memcpy(&two, at, sizeof two), two;
        return memcpy(&four, at, sizeof four), four;
    }

    /* Component k of element i: a float, or an integer, normalised if it is so (3.11, KHR_mesh_quantization). */
    double value(size_t i, size_t k) const;
};

struct buffer {
    const unsigned char *data; /* NULL: a fallback for readers that know no compression, never read */
    size_t               size_bytes;
    bool                 missing; /* neither a uri nor a GLB chunk */
    file_bytes           owned;   /* unless data is the GLB's own */
};

/* EXT_meshopt_compression, KHR_meshopt_compression: the bytes of a bufferView as they are stored. */
struct compressed_view {
    const char *extension; /* NULL: not compressed */
    size_t      buffer, offset, length, count, stride;
    std::string mode, filter;
};

struct buffer_view {
    size_t          buffer, offset, length, stride; /* stride 0: elements follow each other */
    compressed_view compressed;
    bytes           decoded; /* [length] once it was asked for */
};

/* An image's alpha; a JPEG's has no pixels, and is 255. */
struct image_alpha {
    uint32_t             width_px, height_px;
    std::vector<uint8_t> alpha; /* [height * width] */
    uint8_t              least, most;
    size_t               in_scene = SIZE_MAX; /* its number there, when an alpha mask needs it */
};

/* An image's colours, as it has them: sRGB. */
struct image_colours {
    uint32_t             width_px, height_px;
    std::vector<uint8_t> rgba; /* [4 * height * width]; empty: a JPEG's, which are not read */
};

/* Which texture coordinates a texture is seen by. */
struct texture_place {
    size_t uv_set       = 0;
    double transform[6] = {1, 0, 0, 0, 1, 0}; /* two rows: u, v, 1 */
};

/* What the baker reads of a material, and where one with alphaMode MASK is a surface. */
struct material {
    std::string name;
    bool        double_sided, masked; /* masked: alphaMode is MASK */
    float       colour[3];            /* its base colour, linear */
    float       radiance[3];          /* what it shines with, linear */

    enum { UNKNOWN, EVERYWHERE, WITH_HOLES, NOWHERE } surface = UNKNOWN;
    double        threshold                                   = 0;
    uint32_t      alpha_mask                                  = 0; /* WITH_HOLES: index into l.alpha_masks */
    texture_place holes;                                           /* WITH_HOLES */
    size_t        left_out = 0;                                    /* NOWHERE: triangles */
};

/* A primitive whose vertices and indices come from KHR_draco_mesh_compression. */
struct draco_primitive {
    std::map<std::string, elements> attributes; /* POSITION; of a masked material, all that its alpha is made of */
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
    double      colour[3]; /* times intensity */
    double      inner_rad;
};

struct morph {
    double          weight; /* not 0 */
    const elements *positions;
};

/* One primitive placed by one node. */
struct placement {
    const tinygltf::Primitive *primitive;
    const draco_primitive     *draco; /* NULL: not compressed */
    const elements            *positions;
    const elements            *indices;  /* NULL: 0, 1, 2, ... */
    const elements            *uvs;      /* NULL: no holes */
    const gltf::material      *material; /* NULL: none */
    std::vector<morph>         targets;
    transform                  ws_from_node;
    bool                       mirrored;
    uint8_t                    flags; /* TRIANGLE_* */
    size_t                     triangles;
};

/* What has a name that patterns may give, and extras. */
enum kind { NODE, MESH, MATERIAL, KINDS };

/* What is said of one of them. */
struct mark {
    bool   included = false;    /* an --include names it */
    bool   flagged  = false;    /* its extras say that it casts no shadow */
    size_t excluded = SIZE_MAX; /* the first --exclude that names it; SIZE_MAX: none */
};

struct loader {
    message            *m;
    const char         *path; /* as messages call it */
    const scene_choice *choice;
    scene              *s;
    bool                files_beside; /* buffers and images may be in other files */
    std::string         folder;       /* of those: "" or with a slash at its end */
    tinygltf::Model     model;

    file_bytes file; /* a GLB's buffer 0 lies in it */
    json       rest; /* what tinygltf does not get: materials, textures, samplers, images */

    std::vector<buffer>           buffers;
    std::vector<buffer_view>      views;
    std::vector<material>         materials;
    std::vector<light_definition> lights;
    size_t                        camera_count = 0;
    bool                          quantization = false; /* KHR_mesh_quantization is used */

    std::vector<elements> accessors;
    size_t                dense_left = DENSE_MAX, decoded_left = DECODED_MAX;

    std::map<const tinygltf::Primitive *, draco_primitive> draco;

    std::map<size_t, image_alpha>    images;            /* those that were looked at, by the file's number */
    std::map<size_t, image_colours>  colours;           /* likewise */
    size_t                           area_capacity = 0; /* of the scene */
    size_t                           pixels_left   = ALPHA_PIXELS_MAX;
    std::vector<const image_alpha *> hole_images; /* the scene's */
    std::vector<alpha_mask>          alpha_masks;
    std::vector<holed_triangle>      holed_triangles;

    std::vector<mark>            marks[KINDS];         /* of a node: with what is said of those above it */
    std::vector<scene_exclusion> exclusions;           /* all rules, by number */
    size_t                       skinned_excluded = 0; /* nodes */

    std::vector<scene_part>   parts;
    std::vector<uint32_t>     name_at[KINDS]; /* in names, 0: not there */
    std::string               names;
    std::vector<scene_origin> origins;

    std::vector<size_t>    roots, order; /* the scene's nodes, parents first */
    std::vector<transform> ws_from_node; /* by node */

    /* vertices emitted so far: slot i of the current generation is accessor element i */
    struct slot {
        uint32_t generation, vertex;
    };
    std::vector<slot> slots;
    uint32_t          generation      = 0;
    size_t            vertex_capacity = 0; /* of the scene; as many as are expected, before any is emitted */

    /* Write "'path': where: ..." (an empty `where` is left out) and throw. broken: VXS_E_SCENE; unsupported: VXS_E_UNSUPPORTED. */
    [[noreturn]] void error(vxs_result code, const char *format, ...) __attribute__((format(printf, 3, 4)));
    [[noreturn]] void broken(const std::string &where, const char *format, ...) __attribute__((format(printf, 3, 4)));
    [[noreturn]] void unsupported(const std::string &where, const char *format, ...) __attribute__((format(printf, 3, 4)));

    /* So many bytes are about to be taken for something, "buffer 3": throw when there are not as many. */
    void need(uint64_t size_bytes, const std::string &what);
};

/* "node 3 'lamp'" */
std::string label(const char *kind, size_t index, const std::string &name = "");

template <typename item> std::string label(const char *kind, const std::vector<item> &items, size_t index)
{
    return label(kind, index, items[index].name);
}

/* tinygltf's and nlohmann's texts may hold several lines, whole data URIs, and a bracketed class of error. */
std::string one_line(std::string text);

/* An array of the scene, which is freed by free(). */
template <typename item> item *copied(const std::vector<item> &from)
{
    item *to = (item *)malloc(std::max(from.size(), (size_t)1) * sizeof(item));
    if (!to) throw std::bad_alloc();
    if (!from.empty()) memcpy(to, from.data(), from.size() * sizeof(item));
    return to;
}

/* ---- gltf_container.cc ---- */

struct container {
    const char *text;
    size_t      text_size;

    const unsigned char *bin; /* NULL: there is none */
    size_t               bin_size;
};

/* The first `limit` bytes of a file; `error` is 0 or an errno. A file that a scene refers to must be a regular one: a pipe may never end. */
file_bytes read_bytes(loader &l, const char *path, size_t limit, bool regular_only, int &error);
void       read_scene_file(loader &l, const char *path);
container  open_container(loader &l);

/* ---- gltf_json.cc, gltf_parse.cc ---- */

enum class is { index, size, text, flag, number, numbers, indices, texts, object, objects, extensions, index_map };

struct property {
    const char *name;
    is          kind;
    bool        required = false;
    size_t      count    = 0; /* of numbers; 0: any */
};
using shape = std::initializer_list<property>;

/* Members of an object, and of each object of a list, have the types that are given. */
void check_shape(loader &l, const std::string &where, const json &object, const shape &expected);
void check_list(loader &l, const json &root, const char *list, const char *item_name, const shape &expected);

/* The items of a list, none when it is not there. */
const json &items(const json &object, const char *name);

/* The members of extensions.NAME, or NULL; the second checks them, too. */
const json *extension(const json &object, const char *name);
const json *check_extension(loader &l, const std::string &where, const json &object, const char *name, const shape &expected);

json parse_json(loader &l, const container &c);
void check_json(loader &l, const json &root);

/* From the file to l.model, with all that is read of it in shape. */
void parse(loader &l);

/* ---- gltf_buffers.cc, gltf_meshopt.cc ---- */

/* The bytes of every buffer, and the bufferViews, which lie in them. */
void read_buffers(loader &l, const json &root, const container &c);
void read_buffer_views(loader &l, const json &root);

/* No buffer is missing; checked after all faults that can be seen without data. */
void check_buffers(loader &l);

/* No file that the scene refers to, whether it will be read or not, is an output of this run. */
void check_files_beside(loader &l, const json &root);

/* At most `limit` bytes of a file beside the scene, by the uri of a buffer or an image, `what`. */
file_bytes read_beside(loader &l, const std::string &what, const std::string &uri, size_t limit);

/* The bytes of base64 text. */
bool decode_base64(const std::string &text, file_bytes &out);

/* The `length` bytes of a bufferView, decompressed once. */
const unsigned char *view_bytes(loader &l, size_t view);

void check_view_index(loader &l, const std::string &where, size_t view);
void check_in_buffer(loader &l, const std::string &where, size_t length, size_t offset, size_t buffer);
void read_compressed_view(loader &l, const std::string &where, const json &view, compressed_view &c);
void decode_view(loader &l, size_t index);

/* ---- gltf_accessors.cc ---- */

size_t component_bytes(int component);
bool   is_unsigned(int component);
void   check_accessors(loader &l);

/* Where the first element of an accessor with a bufferView begins. */
size_t offset_in_buffer(const loader &l, const tinygltf::Accessor &a);

/* An accessor's elements: in the buffer, or made dense once. */
const elements &use_accessor(loader &l, size_t index);

/* 3.7.2.1: no index may name a missing vertex or be the largest value of its type, which restarts primitives elsewhere. */
void check_index_values(loader &l, const elements &indices, size_t vertices);

/* ---- gltf_draco.cc ---- */

/* A primitive that is there in compressed form only. */
bool needs_draco(const loader &l, const tinygltf::Primitive &p);

/* Decode it once. */
const draco_primitive &use_draco(loader &l, const std::string &where, const tinygltf::Primitive &p);

/* ---- gltf_instances.cc: EXT_mesh_gpu_instancing ---- */

/* How often a node's mesh is placed, 1 without the extension; and where the i-th of them is. */
size_t    count_instances(loader &l, size_t node);
transform instance_transform(loader &l, size_t node, size_t i);

/* ---- gltf_nodes.cc ---- */

inline vec3 rotate_scale(const transform &t, vec3 v)
{
    return {t.axis[0].x * v.x + t.axis[1].x * v.y + t.axis[2].x * v.z, t.axis[0].y * v.x + t.axis[1].y * v.y + t.axis[2].y * v.z,
            t.axis[0].z * v.x + t.axis[1].z * v.y + t.axis[2].z * v.z};
}

inline vec3 apply(const transform &t, vec3 v)
{
    vec3 p = rotate_scale(t, v);
    return {p.x + t.origin.x, p.y + t.origin.y, p.z + t.origin.z};
}

/* First b, then a. */
transform multiply(const transform &a, const transform &b);

/* Scale, then rotation by a quaternion (x, y, z, w) of any length but 0, then translation; false when it has none. */
bool trs_transform(const double translation[3], const double rotation[4], const double scale[3], transform &t);

inline bool finite(vec3 v)
{
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

/* How many times a volume it is once transformed; less than 0 where it is mirrored. */
double volume_scale(const transform &t);

/* The triangles of a mirrored node turn their backs, unless two corners are swapped (3.7.4). */
bool is_mirrored(const transform &t);

/* The parent of each node, -1 of a root. */
std::vector<int> check_tree(loader &l);
void             check_references(loader &l);

/* The scene that is asked for: -1 when the file has none and all root nodes are meant. */
int  choose_scene(loader &l, const char *which);
void choose_roots(loader &l, int chosen, const std::vector<int> &parent);
void place_nodes(loader &l, const std::vector<int> &parent);

/* ---- gltf_selection.cc, gltf_parts.cc ---- */

constexpr size_t CASTS = SIZE_MAX;

/* What extras say, into l.marks. */
void read_flags(loader &l, const json &root);

/* What patterns say of the scene's nodes, of their meshes and of the materials of these, beside what extras do. */
void select_casters(loader &l, const std::vector<int> &parent);

/* The rule by which a node's primitive casts no shadow, a number of l.exclusions, or CASTS. */
size_t exclusion_of(const loader &l, size_t node, const tinygltf::Primitive &p);

/* What was excluded, into the scene; with a warning where nobody asked for it. */
void finish_selection(loader &l);

/* The triangles from here on are of that primitive, placed from that origin. */
void begin_part(loader &l, size_t node, const tinygltf::Primitive &p, vec3 origin);
void finish_parts(loader &l);

/* ---- gltf_meshes.cc, gltf_triangles.cc ---- */

/* The accessor of an attribute, or -1. */
int attribute(const std::map<std::string, int> &attributes, const std::string &name);

/* "mesh 0 'house' primitive 2" */
std::string primitive_label(const loader &l, size_t mesh, size_t primitive);

bool   makes_triangles(const tinygltf::Primitive &p);
size_t triangle_count(const loader &l, const tinygltf::Primitive &p);

void check_model_meshes(loader &l);

/* No index of an uncompressed primitive is too large, whether a node places it or not. */
void check_all_indices(loader &l);

/* A weight for each morph target of a primitive (3.7.2.2), or none. */
void check_weights(loader &l, const std::string &where, const std::vector<double> &weights, const tinygltf::Primitive &p);

/* The scene's triangles, counted before they are placed: instancing makes scenes much larger than files. */
size_t measure(loader &l);
void   place_meshes(loader &l, size_t triangles);

/* An element of an accessor of positions. */
vec3 position(const elements &e, size_t index);

/* The accessor elements of a triangle's corners, in the order of the scene's. */
void triangle_elements(const placement &p, size_t t, uint32_t element[3]);

/* ---- gltf_smoke.cc ---- */

/* Points and lines that dim light, and how many capsules they are each time that they are placed. */
bool   makes_smoke(const tinygltf::Primitive &p);
size_t capsule_count(const loader &l, const tinygltf::Primitive &p);

/* Its attributes that triangles have not. */
void check_smoke(loader &l, const std::string &primitive, const tinygltf::Primitive &p);

/* The scene's capsules. */
void place_smoke(loader &l);

/* ---- gltf_images.cc, gltf_materials.cc ---- */

void read_materials(loader &l, const json &root);
void place_materials(loader &l);

/* What pictures alone ask for, and no bake may fail by: a member that is 0 to `most`, three that are 0 to 1, or what it is otherwise. */
double number_or(const json &object, const char *name, double otherwise, double most);
void   numbers_or(const json &object, const char *name, double otherwise, double out[3]);

/* Decode image `index`, which exists, once: its alpha, or its colours. */
image_alpha   &use_image(loader &l, size_t index);
image_colours &use_colours(loader &l, size_t index);

/* A texture of the file by what refers to it, whose shape is checked; the image that it shows; how it goes on beyond [0, 1]; which coordinates it is seen by. */
const json   &texture_of(loader &l, const std::string &where, const json &info);
size_t        texture_image(loader &l, const std::string &where, const json &texture);
void          read_sampler(loader &l, const std::string &where, const json &texture, alpha_mask &out);
texture_place read_texture_place(loader &l, const std::string &where, const json &info);

/* A material, once it is known where it is a surface. */
material &use_material(loader &l, size_t index);

/* The texture coordinates of a placement that has holes. */
void find_uvs(loader &l, const std::string &where, placement &p);
void warn_about_colors(loader &l, const std::string &where, const placement &p);

/* The holes of the triangles that the placement made, from `first` on. */
void append_mask_triangles(loader &l, const placement &p, size_t first);

/* Alpha masks and their images, into the scene. */
void place_masks(loader &l);

/* ---- gltf_areas.cc ---- */

/* What a material shines with. */
void read_radiance(const json &object, material &m);

/* The triangles that the placement made, from `first` on, shine: the scene has an area light more, if they are a parallelogram. */
void append_area(loader &l, const placement &p, size_t first);

/* ---- gltf_lights.cc ---- */

/* The lights of KHR_lights_punctual, into l.lights. */
void read_lights(loader &l, const json &root);

void place_lights(loader &l);
void place_cameras(loader &l);

/* ---- gltf_cameras.cc ---- */

/* What cameras see, into the scene. */
void place_views(loader &l);

} // namespace gltf

#endif
