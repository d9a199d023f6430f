/* What the files of the glTF loader share; private to baker/scene/gltf/.
 *
 *   file -> container (GLB chunks) -> JSON shape -> tinygltf -> node tree -> placements -> triangles in world space
 *
 * Every range is checked before it is read. What fails throws `failure`, as the libraries below throw errors of their own. A fault of one
 * primitive, material, light or node costs that part: it is caught where the part is used (fault_of), and noted (gltf_notes.cc). All other
 * failures end in scene_gltf.cc, which returns a result.
 * Section numbers are those of the glTF 2.0 specification.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef GLTF_LOADER_H
#define GLTF_LOADER_H

#include "baker/base/pages.h"
#include "baker/base/text.h"
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
constexpr size_t NAME_BYTES       = 60;              /* of a name in a message */

/* Why something cannot be read. */
struct failure {
    vxs_result  code = VXS_OK;
    std::string text;          /* "accessor 3: ..."; "": the message has it already */
    bool        whole = false; /* no part of the scene can be read without it */

    explicit operator bool() const { return code != VXS_OK; }
};

/* What work throws, to be thrown where it is needed; none where it succeeds. Missing memory and wrong options are passed on. */
template <typename function> failure caught(function &&work)
{
    try {
        work();
    } catch (failure &f) {
        if (f.text.empty() || f.code == VXS_E_MEMORY || f.code == VXS_E_ARGUMENT) throw;
        return std::move(f);
    }
    return {};
}

/* The same, but what no part of the scene can be read without is passed on, too. */
template <typename function> failure fault_of(function &&work)
{
    failure f = caught(work);
    if (f.whole) throw f;
    return f;
}

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
    failure              fault;         /* use_accessor throws it */

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
    const unsigned char *data; /* NULL: a fallback for readers that know no compression, never read; or a fault */
    size_t               size_bytes;
    size_t               there; /* bytes of these that there are, and may be read */
    file_bytes           owned; /* unless data is the GLB's own */
    failure              fault; /* of what lies in it */
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
    failure         fault;   /* of what lies in it */
};

/* An image's alpha; a JPEG's has no pixels, and is 255. */
struct image_alpha {
    uint32_t             width_px, height_px;
    std::vector<uint8_t> alpha; /* [height * width] */
    uint8_t              least, most;
    bool                 has_alpha;           /* it says something of alpha */
    size_t               in_scene = SIZE_MAX; /* its number there, when an alpha mask needs it */
};

/* An image's colours, as it has them: sRGB. */
struct image_colours {
    uint32_t             width_px, height_px;
    bool                 has_alpha;
    std::vector<uint8_t> rgba; /* [4 * height * width]; empty: a JPEG's, which are not read */
};

/* Which texture coordinates a texture is seen by. */
struct texture_place {
    size_t uv_set       = 0;
    double transform[6] = {1, 0, 0, 0, 1, 0}; /* two rows: u, v, 1 */
};

enum class alpha_mode { SOLID, MASK, BLEND };

/* What the baker reads of a material, and where one that is no wall is a surface. */
struct material {
    std::string name, odd; /* odd: what of it is not read as it is written, and why; "": nothing */
    bool        double_sided;
    alpha_mode  mode;
    const char *transmits;   /* the extension by which it lets light through; NULL: none */
    float       colour[3];   /* its base colour, linear */
    float       radiance[3]; /* what it shines with, linear */

    enum { UNKNOWN, EVERYWHERE, WITH_HOLES, NOWHERE } surface = UNKNOWN;
    double        threshold                                   = 0;
    uint32_t      alpha_mask                                  = 0; /* WITH_HOLES: index into l.alpha_masks */
    texture_place holes;                                           /* WITH_HOLES */
    std::string   fault;                                           /* why its mask cannot be read, which is EVERYWHERE then */
    std::string   trap;                                            /* why its mask is hardly meant as it is */
    bool          is_clear = false, is_nothing = false;            /* its alpha is below 1 somewhere, 0 everywhere */
    std::string   used_by;                                         /* " (node 1 'tree', mesh 0 'branch')" */
    size_t        triangles = 0, left_out = 0;                     /* that cast; NOWHERE: that do not */
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
    const char *dark;  /* why it shines with nothing; NULL: it shines */
    std::string fault; /* why it cannot be baked; "": it can */
    std::string odd;   /* what of it is not read as it is written, and why; "": nothing */
};

/* A skin's joints, and where each of them was when the mesh was bound to them. */
struct skin {
    std::vector<size_t>    joints;       /* nodes */
    int                    inverse_bind; /* accessor, or -1 */
    failure                fault;
    std::vector<transform> ws_from_bind; /* [joints] once it was asked for */
};

struct morph {
    double          weight; /* not 0 */
    const elements *positions;
};

/* One primitive placed by one node. */
struct placement {
    const tinygltf::Primitive    *primitive;
    const draco_primitive        *draco; /* NULL: not compressed */
    const elements               *positions;
    const elements               *indices;         /* NULL: 0, 1, 2, ... */
    const elements               *uvs;             /* NULL: no holes */
    const gltf::material         *material;        /* NULL: none */
    size_t                        index;           /* of the primitive in its mesh */
    const gltf::skin             *skin;            /* NULL: its node places it */
    std::vector<const elements *> joints, weights; /* [sets] */
    size_t                        off_count;       /* vertices whose weights are far from a sum of 1 */
    std::vector<morph>            targets;
    transform                     ws_from_node;
    bool                          mirrored;
    uint8_t                       flags; /* TRIANGLE_* */
    size_t                        triangles;
};

/* What has a name that patterns may give, and extras. */
enum kind { NODE, MESH, MATERIAL, KINDS };

/* What is said of one of them. */
struct mark {
    bool   included = false;    /* an --include names it */
    bool   flagged  = false;    /* its extras say that it casts no shadow */
    size_t excluded = SIZE_MAX; /* the first --exclude that names it; SIZE_MAX: none */
};

/* What of the JSON's lists is not in shape costs what refers to it: lists whose items are looked up by number. */
enum list { SCENES, ACCESSORS, VIEWS, BUFFERS, SKINS, LISTS };

/* What is known of a node besides what tinygltf has. */
struct node_state {
    failure     fault;      /* it cannot be placed, nor what is below it */
    failure     instancing; /* its mesh cannot be placed */
    std::string light;      /* why its light cannot be read; "": it can, or there is none */
    bool        hidden;     /* by KHR_node_visibility: this one; once placed, also by one above it */
    bool        in_scene;
    bool        counted; /* instances is known */
    size_t      instances;
};

/* What a fault costs; the words are in gltf_notes.cc. */
enum class cost {
    NUMBERS,
    TREE,
    NODE,
    REFERENCE,
    INSTANCES,
    PRIMITIVE,
    TRIANGLES,
    CORNERS,
    SMOKE,
    CAPSULES,
    MASK,
    MATERIAL,
    TRAP,
    BLEND,
    MORPH,
    SKIN,
    COLOUR,
    CAMERA,
    EXTENSION,
    KINDS
};

/* Something that is left out, or is not read as it is written. */
struct note {
    cost        kind;
    std::string where, why, remedy;
    size_t      count; /* of triangles or capsules */
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
    std::vector<skin>             skins;
    std::vector<node_state>       nodes;
    size_t                        camera_count = 0;
    bool                          quantization = false; /* KHR_mesh_quantization is used */

    std::map<size_t, failure>                    faults[LISTS]; /* by item */
    std::map<size_t, failure>                    mesh_faults;
    std::map<std::pair<size_t, size_t>, failure> primitive_faults; /* by mesh and number in it */
    failure                                      first_fault;      /* by which geometry is lost */
    std::vector<note>                            notes;            /* in order; of each kind some, the rest counted */
    std::map<std::pair<int, uint64_t>, size_t>   note_of;          /* by kind and what it is about: in notes, or SIZE_MAX */
    size_t                                       notes_more[(int)cost::KINDS] = {}, notes_more_count[(int)cost::KINDS] = {};

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
    std::vector<int>       file_parent;  /* by node, whatever the scene takes for roots; -1: none */
    std::vector<transform> ws_from_node; /* by node */

    /* vertices emitted so far: slot i of the current generation is accessor element i */
    struct slot {
        uint32_t generation, vertex;
    };
    std::vector<slot> slots;
    uint32_t          generation      = 0;
    size_t            vertex_capacity = 0; /* of the scene; as many as are expected, before any is emitted */

    /* Throw "where: ..." (an empty `where` is left out). broken: VXS_E_SCENE; unsupported: VXS_E_UNSUPPORTED; refused: the same, and
     * whole. */
    [[noreturn]] void error(vxs_result code, const char *format, ...) __attribute__((format(printf, 3, 4)));
    [[noreturn]] void broken(const std::string &where, const char *format, ...) __attribute__((format(printf, 3, 4)));
    [[noreturn]] void unsupported(const std::string &where, const char *format, ...) __attribute__((format(printf, 3, 4)));
    [[noreturn]] void refused(const std::string &where, const char *format, ...) __attribute__((format(printf, 3, 4)));

    /* So many bytes are about to be taken for something, "buffer 3": throw when there are not as many. */
    void need(uint64_t size_bytes, const std::string &what);
};

/* "node 3 'lamp'": a long name is shortened. */
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

/* ---- gltf_notes.cc ---- */

/* Note what is wrong with what `id` stands for: the same again adds to its count. The line will be "where: why: cost; remedy". */
void take_note(loader &l, cost kind, uint64_t id, const std::string &where, const std::string &why, const std::string &remedy,
               size_t count = 0);

/* Note a fault by which geometry is lost: where no geometry is left, it is the error. besides: what stands behind `where` in the note alone. */
void take_fault(loader &l, cost kind, uint64_t id, const std::string &where, const failure &f, const std::string &remedy,
                size_t count = 0, const std::string &besides = "");

/* Warn of all notes since the last call: of some of each kind, and how many more there are. */
void say_notes(loader &l);

/* What a fault says of what it is about, which most begin with. */
std::string why_of(const failure &f, const std::string &where);

/* Throw the first fault where there is nothing else. */
void require_geometry(const loader &l, size_t triangles, size_t capsules);

/* "--exclude mesh:crate bakes without it": by name, or by number where it has none that a pattern can give. */
std::string exclude_remedy(const char *prefix, size_t index, const std::string &name);

/* A uri as messages print it: shortened, and of data nothing but the media type. */
std::string shown_uri(const std::string &uri);

/* ---- gltf_container.cc ---- */

struct container {
    const char *text;
    size_t      text_size;

    const unsigned char *bin; /* NULL: there is none */
    size_t               bin_size;
};

/* Asked of a file's beginning, 64 KiB or all of it: how many bytes are to be read.   total_bytes  0: not known */
using scene_look = size_t (*)(loader &l, const unsigned char *bytes, size_t size, uint64_t total_bytes);

/* The first `limit` bytes of a file; `error` is 0 or an errno. A file that a scene refers to must be a regular one: a pipe may never end. */
file_bytes read_bytes(loader &l, const char *path, size_t limit, bool regular_only, int &error, scene_look look = nullptr);
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

/* Members of an object have the types that are given. */
void check_shape(loader &l, const std::string &where, const json &object, const shape &expected);

/* The items of a list, none when it is not there. */
const json &items(const json &object, const char *name);

/* The members of extensions.NAME, or NULL; the second checks them, too. */
const json *extension(const json &object, const char *name);
const json *check_extension(loader &l, const std::string &where, const json &object, const char *name, const shape &expected);

json parse_json(loader &l, const container &c);

/* What is not in shape is taken out and noted, or kept as a fault of what refers to it. */
void check_json(loader &l, json &root);

/* What tinygltf gets of a file that is checked, taken out of it: lists, with no members but those that are read, and so checked. */
json take_model(json &root);

/* From the file to l.model, with all that is read of it in shape. */
void parse(loader &l);

/* ---- gltf_extensions.cc ---- */

/* Refuse what is required and not known; note what is used and not known. */
void check_extensions(loader &l, const json &root);

/* ---- gltf_buffers.cc, gltf_meshopt.cc ---- */

/* The bytes of every buffer, and the bufferViews, which lie in them. */
void read_buffers(loader &l, const json &root, const container &c);
void read_buffer_views(loader &l, const json &root);

/* That so many bytes of a buffer can be read, which are within its promised length. */
void check_there(loader &l, size_t buffer, size_t offset, size_t size);

/* No file that the scene refers to, whether it will be read or not, is an output of this run. */
void check_files_beside(loader &l, const json &root);

/* At most `limit` bytes of a file beside the scene, by the uri of a buffer or an image, `what`. */
file_bytes read_beside(loader &l, const std::string &what, const std::string &uri, size_t limit);

/* Whether a uri holds data itself; the bytes of one that does. */
bool       is_data(const std::string &uri);
file_bytes data_of(loader &l, const std::string &where, const std::string &uri);

/* The `length` bytes of a bufferView, decompressed once. Of one that is not compressed check_there says which of them there are. */
const unsigned char *view_bytes(loader &l, size_t view);

/* The same of one that is read as a whole; throws when it does not exist, or not all of it is there. */
const unsigned char *whole_view(loader &l, const std::string &where, size_t view);

/* Throws when there is none, or it cannot be read. */
void check_view_index(loader &l, const std::string &where, size_t view);
void check_in_buffer(loader &l, const std::string &where, size_t length, size_t offset, size_t buffer);
void read_compressed_view(loader &l, const std::string &where, const json &view, compressed_view &c);
void decode_view(loader &l, size_t index);

/* ---- gltf_accessors.cc ---- */

size_t component_bytes(int component); /* 0: unknown */
bool   is_unsigned(int component);

/* Of each accessor what it is, or why it cannot be read. */
void check_accessors(loader &l);

/* An accessor by what refers to it, "NORMAL"; throws when there is none, or it cannot be read. Its data may not be there yet. */
const elements &sound_accessor(loader &l, const std::string &where, const char *what, int index);

/* Where the first element of an accessor with a bufferView begins. */
size_t offset_in_buffer(const loader &l, const tinygltf::Accessor &a);

/* The elements of an accessor that exists: in the buffer, or made dense once. */
const elements &use_accessor(loader &l, size_t index);

/* 3.7.2.1: no index may name a missing vertex, or be one that restarts a primitive. */
void check_index_values(loader &l, const elements &indices, size_t vertices, bool restarts);

/* ---- gltf_draco.cc ---- */

/* A primitive that is there in compressed form only. */
bool needs_draco(const loader &l, const tinygltf::Primitive &p);

/* Decode it once. */
const draco_primitive &use_draco(loader &l, const std::string &where, const tinygltf::Primitive &p);

/* ---- gltf_instances.cc: EXT_mesh_gpu_instancing ---- */

/* How often a node's mesh is placed, 1 without the extension, 0 where it cannot be read; and where the i-th of them is. */
size_t    count_instances(loader &l, size_t node);
size_t    usable_instances(loader &l, size_t node); /* the same, once their data is decoded */
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

/* A node's own transform, by its parent's. */
transform node_transform(loader &l, size_t node);

/* The parent of each node, -1 of a root. */
std::vector<int> check_tree(loader &l);

/* The scene that is asked for: -1 when the file has none and all root nodes are meant. */
int  choose_scene(loader &l, const char *which);
void choose_roots(loader &l, int chosen, std::vector<int> &parent);
void place_nodes(loader &l, const std::vector<int> &parent);
void check_references(loader &l);

/* ---- gltf_selection.cc, gltf_parts.cc ---- */

constexpr size_t CASTS = SIZE_MAX;

/* What extras say, into l.marks. */
void read_flags(loader &l, const json &root);

/* What patterns say of the scene's nodes, of their meshes and of the materials of these, beside what extras do. */
void select_casters(loader &l, const std::vector<int> &parent);

/* The rule by which a node's primitive casts no shadow, a number of l.exclusions, or CASTS. */
size_t exclusion_of(const loader &l, size_t node, const tinygltf::Primitive &p);

/* Warn of what is excluded without an option that asks for it. */
void warn_about_skinned(loader &l);

/* What was excluded, into the scene, once all that is left out is known. */
void finish_exclusions(loader &l);

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

/* Faults of all primitives, placed or not. */
void check_model_meshes(loader &l);
void check_all_indices(loader &l);

/* Why a primitive cannot be read; NULL: it can, as far as is known. */
const failure *primitive_fault(const loader &l, size_t mesh, size_t primitive);

/* Note that a node's primitive, or so much of it, is left out; throws a fault that is whole. */
void lose_primitive(loader &l, cost kind, size_t node, size_t primitive, const failure &f, size_t count);

/* The scene's triangles, counted before they are placed: instancing makes scenes much larger than files. */
size_t measure(loader &l);
void   place_meshes(loader &l, size_t triangles);

/* An element of an accessor of positions. */
vec3 position(const elements &e, size_t index);

/* The accessor elements of a triangle's corners, in the order of the scene's. */
void triangle_elements(const placement &p, size_t t, uint32_t element[3]);

/* ---- gltf_skins.cc ---- */

void read_skins(loader &l, const json &root);

/* Of a placement of a node with a skin: its joints, and what each vertex has to do with them. */
void find_skin(loader &l, const std::string &where, const tinygltf::Node &node, placement &p);

/* Where an element of a placement with a skin is in bind space to the world: its joints' transforms, weighted.
 * off  set to 1 where weights are far from a sum of 1 */
transform skin_transform(const placement &p, uint32_t element, bool &off);

/* ---- gltf_smoke.cc ---- */

/* Points and lines that dim light, and how many capsules they are each time that they are placed. */
bool   makes_smoke(const tinygltf::Primitive &p);
size_t capsule_count(const loader &l, const tinygltf::Primitive &p);

/* Its attributes that triangles have not. */
void check_smoke(loader &l, const std::string &primitive, const tinygltf::Primitive &p);

/* The scene's capsules, counted before they are placed, and placed. */
size_t count_capsules(loader &l);
void   place_smoke(loader &l);

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
void warn_about_colors(loader &l, const std::string &where, size_t node, const placement &p);

/* The holes of the next triangle of the scene, the placement's with these elements. Returns false where a coordinate is not finite. */
bool append_mask_triangle(loader &l, const placement &p, const uint32_t element[3]);

/* Alpha masks and their images, into the scene. */
void place_masks(loader &l);

/* ---- gltf_areas.cc ---- */

/* What a material shines with. */
void read_radiance(const json &object, material &m);

/* The triangles that the placement made, `count` from `first` on, shine: the scene has an area light more, if they are a parallelogram. */
void append_area(loader &l, const placement &p, size_t first, size_t count);

/* ---- gltf_traps.cc ---- */

/* Note what is sound and hardly meant.   triangles  that are to be placed */
void look_at_traps(loader &l, int chosen_scene, size_t triangles);

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
