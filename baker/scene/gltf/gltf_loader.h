/* Internals of the glTF loader; private to baker/scene/gltf/.
 *
 *   file -> container (GLB chunks) -> JSON shape -> tinygltf -> node tree -> placements -> triangles in world space
 *
 * Every range is checked before it is read. Errors throw `failure`, as the libraries used here also throw. A fault of one
 * primitive, material, light or node drops only that part: it is caught where the part is used (fault_of) and noted
 * (gltf_notes.cc). All other failures are caught in scene_gltf.cc, which returns a result.
 * Section numbers refer to the glTF 2.0 specification.
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

/* Allocator for arrays on huge pages that are not zeroed, because data is read into them immediately. */
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

constexpr size_t FILE_BYTES_MAX   = UINT32_MAX;      /* sizes in GLB and tinygltf have 32 bits */
constexpr size_t TRIANGLES_MAX    = (size_t)1 << 26; /* of the whole scene: instancing can make a scene much larger than its file */
constexpr size_t DENSE_MAX        = (size_t)1 << 24; /* total number of elements that sparse accessors may expand to */
constexpr size_t DECODED_MAX      = (size_t)1 << 30; /* total bytes that compressed bufferViews may expand to */
constexpr size_t ALPHA_PIXELS_MAX = (size_t)1 << 28; /* total pixels of images whose alpha is read */
constexpr long   JSON_DEPTH_MAX   = 200;             /* tinygltf recurses into extras */
constexpr size_t NAME_BYTES       = 60;              /* maximum length of a name in a message */

/* The reason why something cannot be read. */
struct failure {
    vxs_result  code = VXS_OK;
    std::string text;          /* "accessor 3: ..."; "": already written to the message */
    bool        whole = false; /* 1: the whole scene cannot be read without it */

    explicit operator bool() const { return code != VXS_OK; }
};

/* Run `work` and return the failure that it throws; no failure if it succeeds. Out of memory and wrong options are rethrown. */
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

/* The same, but also rethrows failures that affect the whole scene. */
template <typename function> failure fault_of(function &&work)
{
    failure f = caught(work);
    if (f.whole) throw f;
    return f;
}

/* The elements of an accessor, checked to be inside their bufferView. use_accessor sets the data. */
struct elements {
    std::string          label; /* "accessor 3 'name'" */
    const unsigned char *data;
    size_t               stride, count, size; /* size: bytes per element */
    int                  type;                /* TINYGLTF_TYPE_* */
    int                  component;           /* TINYGLTF_COMPONENT_TYPE_* */
    size_t               component_size;      /* bytes: 1, 2 or 4 */
    bool                 normalized;
    bool                 ready;         /* data is set */
    mutable size_t       indices_below; /* upper bound of the elements as indices (all are less); 0: not computed */
    bytes                dense;         /* owns data if the accessor is sparse or compressed, or has no bufferView */
    failure              fault;         /* thrown by use_accessor */

    /* Element i of indices with 1, 2 or 4 bytes. */
    uint32_t index(size_t i) const
    {
        const unsigned char *at = data + i * stride;
        uint16_t             two;
        uint32_t             four;
        if (size == 1) return *at;
        if (size == 2) return memcpy(&two, at, sizeof two), two;
        return memcpy(&four, at, sizeof four), four;
    }

    /* Component k of element i: a float or an integer; a normalised integer is converted (3.11, KHR_mesh_quantization). */
    double value(size_t i, size_t k) const;
};

struct buffer {
    const unsigned char *data; /* NULL: a fallback for readers without decompression, never read; or a fault */
    size_t               size_bytes;
    size_t               there; /* bytes that are available to read, at most size_bytes */
    file_bytes           owned; /* owns data, unless it points into the GLB */
    failure              fault; /* applies to everything in the buffer */
};

/* EXT_meshopt_compression, KHR_meshopt_compression: the compressed bytes of a bufferView. */
struct compressed_view {
    const char *extension; /* NULL: not compressed */
    size_t      buffer, offset, length, count, stride;
    std::string mode, filter;
};

struct buffer_view {
    size_t          buffer, offset, length, stride; /* stride 0: tightly packed */
    compressed_view compressed;
    bytes           decoded; /* [length] after first use */
    failure         fault;   /* applies to everything in the view */
};

/* The alpha of an image. A JPEG has no pixels here; its alpha is 255. */
struct image_alpha {
    uint32_t             width_px, height_px;
    std::vector<uint8_t> alpha; /* [height * width] */
    uint8_t              least, most;
    bool                 has_alpha;           /* the image has an alpha channel */
    size_t               in_scene = SIZE_MAX; /* its number in the scene, if an alpha mask uses it */
};

/* The colours of an image, in sRGB. */
struct image_colours {
    uint32_t             width_px, height_px;
    bool                 has_alpha;
    std::vector<uint8_t> rgba; /* [4 * height * width]; empty for a JPEG, which is not read */
};

/* Texture coordinate set and transform of a texture. */
struct texture_place {
    size_t uv_set       = 0;
    double transform[6] = {1, 0, 0, 0, 1, 0}; /* two rows: u, v, 1 */
};

enum class alpha_mode { SOLID, MASK, BLEND };

/* Properties of a material that the baker reads, and where a material with alpha has a surface. */
struct material {
    std::string name, odd; /* odd: properties not used as given, and why; "": none */
    bool        double_sided;
    alpha_mode  mode;
    const char *transmits;   /* the extension that lets light through; NULL: none */
    float       colour[3];   /* base colour, linear */
    float       radiance[3]; /* emitted radiance, linear */

    enum { UNKNOWN, EVERYWHERE, WITH_HOLES, NOWHERE } surface = UNKNOWN;
    double        threshold                                   = 0;
    uint32_t      alpha_mask                                  = 0; /* WITH_HOLES: index into l.alpha_masks */
    texture_place holes;                                           /* WITH_HOLES */
    std::string   fault;                                           /* why its mask cannot be read; then its surface is EVERYWHERE */
    std::string   trap;                                            /* why its mask is probably a mistake */
    bool          is_clear = false, is_nothing = false;            /* its alpha is below 1 somewhere; its alpha is 0 everywhere */
    std::string   used_by;                                         /* " (node 1 'tree', mesh 0 'branch')" */
    size_t        triangles = 0, left_out = 0;                     /* casting triangles; triangles left out by NOWHERE */
};

/* A primitive with vertices and indices from KHR_draco_mesh_compression. */
struct draco_primitive {
    std::map<std::string, elements> attributes; /* POSITION; for a masked material also the attributes that its alpha depends on */
    elements                        indices;
};

struct vec3 {
    double x, y, z;
};

/* Affine transform, column-major as in glTF: three axes, then the translation. */
struct transform {
    vec3 axis[3], origin;
};

/* A light definition of the file. Position and direction come from the nodes that use it. */
struct light_definition {
    std::string name;
    light_shape shape;
    double      colour[3]; /* linear, times intensity */
    double      inner_rad;
    const char *dark;  /* why it emits no light; NULL: it does */
    std::string fault; /* why it cannot be baked; "": it can */
    std::string odd;   /* properties not used as given, and why; "": none */
};

/* A skin: joints, and their inverse bind matrices. */
struct skin {
    std::vector<size_t>    joints;       /* nodes */
    int                    inverse_bind; /* accessor, or -1 */
    failure                fault;
    std::vector<transform> ws_from_bind; /* [joints] computed at first use */
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
    size_t                        index;           /* number of the primitive in its mesh */
    const gltf::skin             *skin;            /* NULL: placed by its node */
    std::vector<const elements *> joints, weights; /* [sets] */
    size_t                        off_count;       /* vertices whose weights do not sum to 1, even approximately */
    std::vector<morph>            targets;
    transform                     ws_from_node;
    bool                          mirrored;
    uint8_t                       flags; /* TRIANGLE_* */
    size_t                        triangles;
};

/* Kinds of objects with names that patterns can match, and with extras. */
enum kind { NODE, MESH, MATERIAL, KINDS };

/* Results of options and extras for one object. */
struct mark {
    bool   included = false;    /* matched by an --include */
    bool   flagged  = false;    /* its extras disable its shadow */
    size_t excluded = SIZE_MAX; /* number of the first matching --exclude; SIZE_MAX: none */
};

/* Lists whose items are looked up by number. An item with the wrong JSON shape is a fault of the objects that refer to it. */
enum list { SCENES, ACCESSORS, VIEWS, BUFFERS, SKINS, LISTS };

/* State of a node in addition to tinygltf's data. */
struct node_state {
    failure     fault;      /* the node and its subtree cannot be placed */
    failure     instancing; /* its mesh cannot be placed */
    std::string light;      /* why its light cannot be read; "": no fault, or no light */
    bool        hidden;     /* KHR_node_visibility of this node; after placement also of its ancestors */
    bool        in_scene;
    bool        counted; /* instances is set */
    size_t      instances;
};

/* What a fault costs. The texts are in gltf_notes.cc. */
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

/* Something that is left out, or not used as given. */
struct note {
    cost        kind;
    std::string where, why, remedy;
    size_t      count; /* triangles or capsules */
};

struct loader {
    run_context        *m;
    const char         *path; /* name in messages */
    const scene_choice *choice;
    scene              *s;
    bool                files_beside; /* buffers and images may be in other files */
    std::string         folder;       /* folder of these files: "" or with a trailing slash */
    tinygltf::Model     model;

    file_bytes file; /* contains buffer 0 of a GLB */
    json       rest; /* JSON that tinygltf does not get: materials, textures, samplers, images */

    std::vector<buffer>           buffers;
    std::vector<buffer_view>      views;
    std::vector<material>         materials;
    std::vector<light_definition> lights;
    std::vector<skin>             skins;
    std::vector<node_state>       nodes;
    size_t                        camera_count = 0;
    bool                          quantization = false; /* KHR_mesh_quantization is used */

    std::map<size_t, failure>                    faults[LISTS]; /* by item number */
    std::map<size_t, failure>                    mesh_faults;
    std::map<std::pair<size_t, size_t>, failure> primitive_faults; /* by mesh and number in it */
    failure                                      first_fault;      /* the first fault that drops geometry */
    std::vector<note>                            notes;            /* in order; limited per kind, further ones are only counted */
    std::map<std::pair<int, uint64_t>, size_t>   note_of;          /* by kind and id of the subject: index in notes, or SIZE_MAX */
    size_t                                       notes_more[(int)cost::KINDS] = {}, notes_more_count[(int)cost::KINDS] = {};

    std::vector<elements> accessors;
    size_t                dense_left = DENSE_MAX, decoded_left = DECODED_MAX;

    std::map<const tinygltf::Primitive *, draco_primitive> draco;

    std::map<size_t, image_alpha>    images;            /* decoded images, by number in the file */
    std::map<size_t, image_colours>  colours;           /* likewise */
    size_t                           area_capacity = 0; /* capacity of the scene's areas */
    size_t                           pixels_left   = ALPHA_PIXELS_MAX;
    std::vector<const image_alpha *> hole_images; /* images that are in the scene */
    std::vector<alpha_mask>          alpha_masks;
    std::vector<holed_triangle>      holed_triangles;

    std::vector<mark>            marks[KINDS];         /* for nodes: inherited from their ancestors */
    std::vector<scene_exclusion> exclusions;           /* all rules, by number */
    size_t                       skinned_excluded = 0; /* number of nodes */

    std::vector<scene_part>   parts;
    std::vector<uint32_t>     name_at[KINDS]; /* offset in names; 0: not stored yet */
    std::string               names;
    std::vector<scene_origin> origins;

    std::vector<size_t>    roots, order; /* nodes of the scene; in `order` parents come first */
    std::vector<int>       file_parent;  /* parent of each node in the file, whatever the roots of the scene are; -1: none */
    std::vector<transform> ws_from_node; /* by node */

    /* emitted vertices: a slot i of the current generation has the vertex of accessor element i */
    struct slot {
        uint32_t generation, vertex;
    };
    std::vector<slot> slots;
    uint32_t          generation      = 0;
    size_t            vertex_capacity = 0; /* capacity of the scene's vertices; reserved for the expected number in advance */

    /* Throw "where: ..." ("where: " is left out if empty). broken: VXS_E_SCENE; unsupported: VXS_E_UNSUPPORTED; refused:
     * VXS_E_UNSUPPORTED for the whole scene. */
    [[noreturn]] void error(vxs_result code, const char *format, ...) __attribute__((format(printf, 3, 4)));
    [[noreturn]] void broken(const std::string &where, const char *format, ...) __attribute__((format(printf, 3, 4)));
    [[noreturn]] void unsupported(const std::string &where, const char *format, ...) __attribute__((format(printf, 3, 4)));
    [[noreturn]] void refused(const std::string &where, const char *format, ...) __attribute__((format(printf, 3, 4)));

    /* Throw when there is no memory for size_bytes more bytes. what  purpose, for the message: "buffer 3". */
    void need(uint64_t size_bytes, const std::string &what);
};

/* "node 3 'lamp'"; long names are shortened. */
std::string label(const char *kind, size_t index, const std::string &name = "");

template <typename item> std::string label(const char *kind, const std::vector<item> &items, size_t index)
{
    return label(kind, index, items[index].name);
}

/* Shortens error texts of tinygltf and nlohmann to one line: these may contain several lines, whole data URIs, and an error class
 * in brackets. */
std::string one_line(std::string text);

/* A copy of an array for the scene, released with free(). */
template <typename item> item *copied(const std::vector<item> &from)
{
    item *to = (item *)malloc(std::max(from.size(), (size_t)1) * sizeof(item));
    if (!to) throw std::bad_alloc();
    if (!from.empty()) memcpy(to, from.data(), from.size() * sizeof(item));
    return to;
}

/* An array of zeros for the scene, and a copy of a text. */
template <typename item> item *zeroed(size_t count)
{
    item *to = (item *)calloc(std::max(count, (size_t)1), sizeof(item));
    if (!to) throw std::bad_alloc();
    return to;
}
inline char *duplicate(const std::string &text)
{
    return strcpy(zeroed<char>(text.size() + 1), text.c_str());
}

template <typename value> std::string formatted(const char *format, value v)
{
    char text[200];
    snprintf(text, sizeof text, format, v);
    return text;
}

/* ---- gltf_notes.cc ---- */

/* Note a fault of the subject `id`. A repeated note adds to its count. The line will be "where: why: cost; remedy". */
void take_note(loader &l, cost kind, uint64_t id, const std::string &where, const std::string &why, const std::string &remedy,
               size_t count = 0);

/* Note a fault that drops geometry. If no geometry is left, it becomes the error. besides: appended to `where` in the note only. */
void take_fault(loader &l, cost kind, uint64_t id, const std::string &where, const failure &f, const std::string &remedy,
                size_t count = 0, const std::string &besides = "");

/* Warn of all notes since the last call: the first ones of each kind, and the number of others. */
void say_notes(loader &l);

/* The text of a failure without the leading `where`, which most texts start with. */
std::string why_of(const failure &f, const std::string &where);

/* Throw the first fault if there is no geometry. */
void require_geometry(const loader &l, size_t triangles, size_t capsules);

/* "--exclude mesh:crate bakes without it", by name; by number if the name cannot be used in a pattern. */
std::string exclude_remedy(const char *prefix, size_t index, const std::string &name);

/* A URI for messages: shortened; of a data URI only the media type. */
std::string shown_uri(const std::string &uri);

/* ---- gltf_container.cc ---- */

struct container {
    const char *text;
    size_t      text_size;

    const unsigned char *bin; /* NULL: there is none */
    size_t               bin_size;
};

/* Callback with the first 64 KiB of a file, or all of it. Returns how many bytes to read.
 * total_bytes  0: unknown */
using check_head = size_t (*)(loader &l, const unsigned char *bytes, size_t size, uint64_t total_bytes);

/* Read at most `limit` bytes of a file. `error` becomes 0 or an errno. With regular_only, for files that a scene refers to, a pipe
 * is an error, because it may never end. */
file_bytes read_bytes(loader &l, const char *path, size_t limit, bool regular_only, int &error, check_head check = nullptr);
void       read_scene_file(loader &l, const char *path);
container  open_container(loader &l);

/* ---- gltf_json.cc, gltf_parse.cc ---- */

enum class is { index, size, text, flag, number, numbers, indices, texts, object, objects, extensions, index_map };

struct property {
    const char *name;
    is          kind;
    bool        required = false;
    size_t      count    = 0; /* count of numbers; 0: any */
};
using shape = std::initializer_list<property>;

/* Check that the members of an object have the given types. Throws a failure. */
void check_shape(loader &l, const std::string &where, const json &object, const shape &expected);

/* The items of a list; empty if there is no such list. */
const json &items(const json &object, const char *name);

/* A string member; `absent` if it is missing or not a string. */
std::string text_of(const json &object, const char *name, const std::string &absent = "");

/* The members of extensions.NAME, or NULL. check_extension also checks their types. */
const json *extension(const json &object, const char *name);
const json *check_extension(loader &l, const std::string &where, const json &object, const char *name, const shape &expected);

json parse_json(loader &l, const container &c);

/* Remove and note members with the wrong type, or store them as faults of the objects that refer to them. */
void check_json(loader &l, json &root);

/* Extract the part for tinygltf from a checked file: lists that contain only members that are read, and thus checked. */
json take_model(json &root);

/* Parse the file into l.model, and check everything that is read. */
void parse(loader &l);

/* ---- gltf_notes.cc ---- */

/* Refuse a required extension that is unknown. Note a used extension that is unknown. */
void check_extensions(loader &l, const json &root);

/* ---- gltf_buffers.cc, gltf_compression.cc ---- */

/* Read the bytes of all buffers, and the bufferViews, which refer to them. */
void read_buffers(loader &l, const json &root, const container &c);
void read_buffer_views(loader &l, const json &root);

/* Throw unless these bytes of a buffer, which are within its declared length, are available. */
void check_there(loader &l, size_t buffer, size_t offset, size_t size);

/* Check that no file that the scene refers to, needed or not, is an output of this run. */
void check_files_beside(loader &l, const json &root);

/* Visit the scene's file and those beside it (scene_visit_files_gltf). */
void visit_files(loader &l, const json &root, scene_file_fn *visit, void *user);

/* Read at most `limit` bytes of a file beside the scene, from the URI of the buffer or image `what`. */
file_bytes read_beside(loader &l, const std::string &what, const std::string &uri, size_t limit);

/* 1 for a data URI; the bytes of a data URI. */
bool       is_data(const std::string &uri);
file_bytes data_of(loader &l, const std::string &where, const std::string &uri);

/* The `length` bytes of a bufferView, decompressed at first use. Of an uncompressed view some may be missing, see check_there. */
const unsigned char *view_bytes(loader &l, size_t view);

/* The same for a view that is read completely. Throws when it does not exist or is incomplete. */
const unsigned char *whole_view(loader &l, const std::string &where, size_t view);

/* Throws when the view does not exist or cannot be read. */
void check_view_index(loader &l, const std::string &where, size_t view);
void check_in_buffer(loader &l, const std::string &where, size_t length, size_t offset, size_t buffer);
void read_compressed_view(loader &l, const std::string &where, const json &view, compressed_view &c);
void decode_view(loader &l, size_t index);

/* ---- gltf_buffers.cc ---- */

size_t component_bytes(int component); /* 0: unknown component type */
bool   is_unsigned(int component);

/* Set l.accessors: the elements of each accessor, or its fault. */
void check_accessors(loader &l);

/* An accessor by its user, for example "NORMAL". Throws when it does not exist or cannot be read. Its data may not be decoded
 * yet. */
const elements &sound_accessor(loader &l, const std::string &where, const char *what, int index);

/* The elements of an existing accessor, in the buffer or expanded at first use. */
const elements &use_accessor(loader &l, size_t index);

/* 3.7.2.1: indices must refer to existing vertices. `restarts`: the largest value of the type, which restarts a primitive, is not
 * allowed either. */
void check_index_values(loader &l, const elements &indices, size_t vertices, bool restarts);

/* ---- gltf_compression.cc ---- */

/* 1 when a primitive exists only in compressed form. */
bool needs_draco(const loader &l, const tinygltf::Primitive &p);

/* Decode it at first use. */
const draco_primitive &use_draco(loader &l, const std::string &where, const tinygltf::Primitive &p);

/* ---- gltf_nodes.cc: EXT_mesh_gpu_instancing ---- */

/* Number of times that a node's mesh is placed: 1 without the extension, 0 where it cannot be read. instance_transform returns the
 * transform of the i-th placement. */
size_t    count_instances(loader &l, size_t node);
size_t    usable_instances(loader &l, size_t node); /* the same, after decoding the data */
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

/* The product a b: applies b, then a. */
transform multiply(const transform &a, const transform &b);

/* Scale, then rotation by a quaternion (x, y, z, w) of any length but 0, then translation. Returns false when the rotation is
 * invalid. */
bool trs_transform(const double translation[3], const double rotation[4], const double scale[3], transform &t);

inline bool finite(vec3 v)
{
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

/* The unit vector along v. Returns false, and leaves `out`, where v has no direction. */
bool unit(vec3 v, double out[3]);

/* Signed ratio of the transformed volume to the original; negative for a mirrored transform. */
double volume_scale(const transform &t);

/* 1 for a mirrored node: two corners of its triangles must be swapped (3.7.4). */
bool is_mirrored(const transform &t);

/* The local transform of a node. */
transform node_transform(loader &l, size_t node);

/* Returns the parent of each node; -1 for roots. */
std::vector<int> check_tree(loader &l);

/* Index of the requested scene; -1: the file has no scenes, use all root nodes. */
int  choose_scene(loader &l, const char *which);
void choose_roots(loader &l, int chosen, std::vector<int> &parent);
void place_nodes(loader &l, const std::vector<int> &parent);
void check_references(loader &l);

/* ---- gltf_selection.cc, gltf_selection.cc ---- */

constexpr size_t CASTS = SIZE_MAX;

/* Read the extras into l.marks. */
void read_flags(loader &l, const json &root);

/* Apply the patterns to the scene's nodes, their meshes and the materials of these, in addition to extras. */
void select_casters(loader &l, const std::vector<int> &parent);

/* Number in l.exclusions of the rule that excludes a node's primitive, or CASTS. */
size_t exclusion_of(const loader &l, size_t node, const tinygltf::Primitive &p);

/* Warn of skinned meshes that are excluded without an option for it. */
void warn_about_skinned(loader &l);

/* Store the exclusions in the scene, after all triangles are counted. */
void finish_exclusions(loader &l);

/* Start a part: the next triangles are of this primitive, with this origin. */
void begin_part(loader &l, size_t node, const tinygltf::Primitive &p, vec3 origin);
void finish_parts(loader &l);

/* ---- gltf_meshes.cc, gltf_triangles.cc ---- */

/* Accessor number of an attribute, or -1. */
int attribute(const std::map<std::string, int> &attributes, const std::string &name);

/* "mesh 0 'house' primitive 2" */
std::string primitive_label(const loader &l, size_t mesh, size_t primitive);

bool   makes_triangles(const tinygltf::Primitive &p);
size_t corner_count(const loader &l, const tinygltf::Primitive &p); /* or points, or ends of lines */
size_t triangle_count(const loader &l, const tinygltf::Primitive &p);

/* Check that an attribute has this type, floats or integers of 8 or 16 bits, and `count` elements.
 * type_text  "a VEC3" */
void check_attribute(loader &l, const std::string &primitive, const tinygltf::Primitive &p, const char *name, int type,
                     const char *type_text, size_t count);

/* Find the faults of all primitives, placed or not. */
void check_model_meshes(loader &l);

/* Why a primitive cannot be read; NULL: no fault is known. */
const failure *primitive_fault(const loader &l, size_t mesh, size_t primitive);

/* Note that a node's primitive, or `count` of its elements, is left out. Throws a failure that affects the whole scene. */
void lose_primitive(loader &l, cost kind, size_t node, size_t primitive, const failure &f, size_t count);

/* Count the scene's triangles before they are placed: instancing can make a scene much larger than its file. */
size_t measure(loader &l);
void   place_meshes(loader &l, size_t triangles);

/* Element `index` of a position accessor. */
vec3 position(const elements &e, size_t index);

/* Accessor elements of a triangle's corners, in the scene's order. */
void triangle_elements(const placement &p, size_t t, uint32_t element[3]);

/* ---- gltf_meshes.cc ---- */

void read_skins(loader &l, const json &root);

/* For a node with a skin: set the joints, and the joint numbers and weights of the vertices. */
void find_skin(loader &l, const std::string &where, const tinygltf::Node &node, placement &p);

/* Transform from bind space to world space of an element of a skinned placement: the weighted sum of its joints' transforms.
 * off  set to 1 where the weights do not sum to 1, even approximately */
transform skin_transform(const placement &p, uint32_t element, bool &off);

/* ---- gltf_smoke.cc ---- */

/* 1 for points and lines that attenuate light. capsule_count: number of capsules per placement. */
bool   makes_smoke(const tinygltf::Primitive &p);
size_t capsule_count(const loader &l, const tinygltf::Primitive &p);

/* Check the attributes that only smoke has. */
void check_smoke(loader &l, const std::string &primitive, const tinygltf::Primitive &p);

/* Count the scene's capsules before they are placed; place them. */
size_t count_capsules(loader &l);
void   place_smoke(loader &l);

/* ---- gltf_container.cc, gltf_materials.cc ---- */

void read_materials(loader &l, const json &root);
void place_materials(loader &l);

/* Numbers for pictures only; these must not fail a bake. Returns a member in [0, most], or three members in [0, 1]; `otherwise` if
 * missing or invalid. */
double number_or(const json &object, const char *name, double otherwise, double most);
void   numbers_or(const json &object, const char *name, double otherwise, double out[3]);

/* Decode the existing image `index` at first use: its alpha, or its colours. */
image_alpha   &use_image(loader &l, size_t index);
image_colours &use_colours(loader &l, size_t index);

/* Properties of a texture, given the (checked) texture info that refers to it: the texture, its image, its sampler (wrap modes and
 * filter), and its texture coordinates. */
const json   &texture_of(loader &l, const std::string &where, const json &info);
size_t        texture_image(loader &l, const std::string &where, const json &texture);
void          read_sampler(loader &l, const std::string &where, const json &texture, alpha_mask &out);
texture_place read_texture_place(loader &l, const std::string &where, const json &info);

/* A material, after evaluating where it has a surface. */
material &use_material(loader &l, size_t index);

/* The elements of an additional attribute of a primitive, as many as positions. */
const elements &attribute_of(loader &l, const std::string &where, const placement &p, const std::string &name);

/* Find the texture coordinates of a placement with holes. */
void find_uvs(loader &l, const std::string &where, placement &p);
void warn_about_colors(loader &l, const std::string &where, size_t node, const placement &p);

/* Store the holes of the scene's next triangle, from these elements of the placement. Returns false where a coordinate is not
 * finite. */
bool append_mask_triangle(loader &l, const placement &p, const uint32_t element[3]);

/* Store alpha masks and their images in the scene. */
void place_masks(loader &l);

/* ---- gltf_lights.cc ---- */

/* Add an area light for the triangles [first, first + count) of an emissive placement, if they are a parallelogram. */
void append_area(loader &l, const placement &p, size_t first, size_t count);

/* ---- gltf_notes.cc ---- */

/* Note valid content that is probably a mistake.
 * triangles  number of triangles to be placed */
void warn_about_traps(loader &l, int chosen_scene, size_t triangles);

/* ---- gltf_lights.cc ---- */

/* Read the lights of KHR_lights_punctual into l.lights. */
void read_lights(loader &l, const json &root);

void place_lights(loader &l);
void place_cameras(loader &l);

/* ---- gltf_selection.cc ---- */

/* Store the views of cameras in the scene. */
void place_views(loader &l);

} // namespace gltf

#endif
