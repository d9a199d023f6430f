/* Write a binary glTF 2.0 file; see glb_write.h (glTF 2.0 specification, section 4, "GLB File Format").
 *
 *     header  magic, version 2, length of the file            3 words
 *     chunk   length, "JSON", text padded with spaces         2 words + text
 *     chunk   length, "BIN\0", positions, indices, texture coordinates, smoke, images     2 words + data; images are padded
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/scene/gltf/glb_write.h"

#include <jansson.h>
#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "baker/files/json_file.h"
#include "baker/files/png_encode.h"

#if __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
#error "positions and indices are written as they lie in memory, which GLB wants little-endian"
#endif

enum {
    GLB_MAGIC            = 0x46546c67,
    GLB_JSON             = 0x4e4f534a,
    GLB_BIN              = 0x004e4942,
    GL_POINTS            = 0,
    GL_LINES             = 1,
    GL_UNSIGNED_INT      = 5125,
    GL_FLOAT             = 5126,
    ARRAY_BUFFER         = 34962,
    ELEMENT_ARRAY_BUFFER = 34963,
    GL_NEAREST           = 9728,
    GL_REPEAT            = 10497,
    GL_CLAMP_TO_EDGE     = 33071,
    GL_MIRRORED_REPEAT   = 33648,
    VERTEX_BYTES         = 3 * sizeof(float),
    TEXCOORD_BYTES       = 2 * sizeof(float),
    TRIANGLE_BYTES       = 3 * sizeof(uint32_t),
    SMOKE_BYTES          = sizeof(glb_smoke_vertex)
};

/* One part of the binary chunk: a buffer view. */
typedef struct part {
    const void *bytes;
    uint64_t    size_bytes;     /* without padding */
    int         stride, target; /* 0: left out */
    void       *owned;          /* memory to free, or NULL */
} part;

/* The binary chunk: positions, indices, texture coordinates and smoke if any, images. */
typedef struct chunk {
    size_t   part_count;
    part    *parts;
    size_t   texcoord_part, smoke_part, image_part; /* numbers of the first parts of these kinds */
    uint64_t size_bytes;                            /* with padding */
} chunk;

static uint64_t padding(uint64_t size_bytes)
{
    return -size_bytes & 3;
}

/* ---- the binary chunk ---- */

static void append_part(chunk *c, part p)
{
    c->parts[c->part_count++] = p;
    c->size_bytes += p.size_bytes + padding(p.size_bytes);
}

static int append_png(chunk *c, const glb_image *image)
{
    size_t   size_bytes;
    uint8_t *png = png_encode(image->rgba, image->width_px, image->height_px, 4, &size_bytes);
    if (!png) return 1;
    append_part(c, (part){png, size_bytes, 0, 0, png});
    return 0;
}

static int chunk_of(chunk *c, const glb_scene *s)
{
    *c       = (chunk){0};
    c->parts = calloc(4 + s->image_count, sizeof *c->parts);
    if (!c->parts) return 1;
    if (s->mesh_count) {
        append_part(c, (part){s->positions, (uint64_t)s->vertex_count * VERTEX_BYTES, VERTEX_BYTES, ARRAY_BUFFER, NULL});
        append_part(c, (part){s->indices, (uint64_t)s->triangle_count * TRIANGLE_BYTES, 0, ELEMENT_ARRAY_BUFFER, NULL});
    }
    c->texcoord_part = c->part_count;
    if (s->texcoords)
        append_part(c, (part){s->texcoords, (uint64_t)s->vertex_count * TEXCOORD_BYTES, TEXCOORD_BYTES, ARRAY_BUFFER, NULL});
    c->smoke_part = c->part_count;
    if (s->smoke_count)
        append_part(c, (part){s->smoke_vertices, (uint64_t)s->smoke_vertex_count * SMOKE_BYTES, SMOKE_BYTES, ARRAY_BUFFER, NULL});
    c->image_part = c->part_count;
    int failed    = 0;
    for (size_t i = 0; !failed && i < s->image_count; i++) failed = append_png(c, &s->images[i]);
    return failed;
}

/* ---- the text ---- */

/* Append an item to an array of the root. The array is created at first use, so that empty lists are left out. */
static int append(json_t *root, const char *list, json_t *item)
{
    json_t *array = json_object_get(root, list);
    if (!array) {
        if (json_object_set_new(root, list, json_array())) return json_decref(item), 1;
        array = json_object_get(root, list);
    }
    return json_array_append_new(array, item);
}

/* Append a node, and add it to the scene's roots. */
static int append_node(json_t *root, json_t *node)
{
    json_t *drawn = json_array_get(json_object_get(root, "scenes"), 0);
    size_t  index = json_array_size(json_object_get(root, "nodes"));
    return append(root, "nodes", node) | append(drawn, "nodes", json_integer((json_int_t)index));
}

static int is_zero(const double v[3])
{
    return v[0] == 0 && v[1] == 0 && v[2] == 0;
}

/* A glTF light shines along the -Z of its node. The rotation from a = (0,0,-1) to the unit vector d is the quaternion
 * (a x d, 1 + a.d), normalized. */
static void quaternion_from_direction(double q[4], const double direction[3])
{
    double largest = fmax(fabs(direction[0]), fmax(fabs(direction[1]), fabs(direction[2])));
    double d[3]    = {direction[0] / largest, direction[1] / largest, direction[2] / largest};
    double length  = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    for (int i = 0; i < 3; i++) d[i] /= length;

    double aside = d[0] * d[0] + d[1] * d[1];
    double w     = d[2] > 0 ? aside / (1 + d[2]) : 1 - d[2]; /* 1 - d[2] either way, without cancellation */
    double norm  = sqrt(aside + w * w);
    if (norm == 0) { /* exactly along +Z: half a turn about any perpendicular axis */
        q[0] = q[2] = q[3] = 0;
        q[1]               = 1;
        return;
    }
    q[0] = d[1] / norm;
    q[1] = 0 - d[0] / norm; /* avoids "-0.0" in the file */
    q[2] = 0;
    q[3] = w / norm;
}

static json_t *json_light(const scene_light *light)
{
    json_t *json   = json_pack("{s:s, s:s}", "name", light->name, "type", light_kind_name(light->shape.kind));
    int     failed = !json;
    if (!failed && light->shape.kind != LIGHT_DIRECTIONAL && isfinite(light->shape.range_metres))
        failed = json_object_set_new(json, "range", json_real(light->shape.range_metres));
    if (!failed && !is_zero(light->colour)) {
        /* the largest component becomes the intensity: components of `color` are at most 1 */
        double intensity = fmax(light->colour[0], fmax(light->colour[1], light->colour[2])), share[3];
        for (int i = 0; i < 3; i++) share[i] = light->colour[i] / intensity;
        failed =
            json_object_set_new(json, "color", json_vector(share)) | json_object_set_new(json, "intensity", json_real(intensity));
    }
    if (!failed && light->dark) failed = json_object_set_new(json, "intensity", json_real(0));
    if (!failed && light->shape.kind == LIGHT_SPOT)
        failed = json_object_set_new(json, "spot", json_pack("{s:f}", "outerConeAngle", light->shape.outer_rad));
    if (!failed) return json;
    json_decref(json);
    return NULL;
}

static int append_light_node(json_t *root, const glb_scene *s, size_t i)
{
    const light_shape *shape  = &s->lights[i].shape;
    json_t            *node   = json_pack("{s:s}", "name", s->lights[i].name);
    int                failed = !node;
    if (!failed && shape->kind != LIGHT_DIRECTIONAL)
        failed = json_object_set_new(node, "translation", json_vector(shape->position_ws));
    if (!failed && shape->kind != LIGHT_POINT) {
        double q[4];
        quaternion_from_direction(q, shape->direction_ws);
        failed = json_object_set_new(node, "rotation", json_pack("[f,f,f,f]", q[0], q[1], q[2], q[3]));
    }
    if (!failed)
        failed = json_object_set_new(node, "extensions", json_pack("{s:{s:I}}", "KHR_lights_punctual", "light", (json_int_t)i));
    if (!failed) return append_node(root, node);
    json_decref(node);
    return 1;
}

/* `count` float elements from an offset in a buffer view. */
static json_t *float_accessor(size_t view, size_t offset, size_t count, const char *type)
{
    return json_pack("{s:I, s:I, s:i, s:I, s:s}", "bufferView", (json_int_t)view, "byteOffset", (json_int_t)offset, "componentType",
                     GL_FLOAT, "count", (json_int_t)count, "type", type);
}

/* places  positions, `stride` floats apart. Bounds ignore positions that are not finite, because JSON cannot represent them. */
static json_t *position_accessor(size_t view, size_t offset, size_t count, const float *places, size_t stride)
{
    double low[3], high[3];
    for (int axis = 0; axis < 3; axis++) {
        low[axis] = INFINITY, high[axis] = -INFINITY;
        for (size_t i = 0; i < count; i++) {
            double x = places[stride * i + axis];
            if (x < low[axis] && x > -INFINITY) low[axis] = x;
            if (x > high[axis] && x < INFINITY) high[axis] = x;
        }
        if (low[axis] > high[axis]) low[axis] = high[axis] = 0;
    }
    json_t *accessor = float_accessor(view, offset, count, "VEC3");
    if (!accessor ||
        (json_object_set_new(accessor, "min", json_vector(low)) | json_object_set_new(accessor, "max", json_vector(high))))
        return json_decref(accessor), NULL;
    return accessor;
}

static int append_mesh(json_t *root, const chunk *c, const glb_scene *s, size_t i)
{
    const glb_mesh *mesh  = &s->meshes[i];
    json_int_t      first = (json_int_t)json_array_size(json_object_get(root, "accessors"));

    int failed = append(root, "accessors",
                        position_accessor(0, mesh->vertex_first * VERTEX_BYTES, mesh->vertex_count,
                                          s->positions + 3 * mesh->vertex_first, 3)) |
                 append(root, "accessors",
                        json_pack("{s:i, s:I, s:i, s:I, s:s}", "bufferView", 1, "byteOffset",
                                  (json_int_t)(mesh->triangle_first * TRIANGLE_BYTES), "componentType", GL_UNSIGNED_INT, "count",
                                  (json_int_t)(3 * mesh->triangle_count), "type", "SCALAR"));

    json_t *primitive = json_pack("{s:{s:I}, s:I}", "attributes", "POSITION", first, "indices", first + 1);
    failed |= !primitive;
    size_t material = mesh->material ? mesh->material - 1 : s->material_count;
    if (!failed) failed = json_object_set_new(primitive, "material", json_integer((json_int_t)material));
    if (!failed && mesh->material && s->materials[material].image) {
        failed |= append(root, "accessors",
                         float_accessor(c->texcoord_part, mesh->vertex_first * TEXCOORD_BYTES, mesh->vertex_count, "VEC2"));
        failed |= json_object_set_new(json_object_get(primitive, "attributes"), "TEXCOORD_0", json_integer(first + 2));
    }
    failed |= append(root, "meshes", json_pack("{s:s, s:[o]}", "name", mesh->name, "primitives", primitive));

    json_t *node = json_pack("{s:s, s:I}", "name", mesh->name, "mesh", (json_int_t)i);
    if (node && !is_zero(mesh->translation)) failed |= json_object_set_new(node, "translation", json_vector(mesh->translation));
    return failed | append_node(root, node);
}

static int append_smoke(json_t *root, const chunk *c, const glb_scene *s, size_t i)
{
    const glb_smoke        *smoke  = &s->smoke[i];
    const glb_smoke_vertex *first  = &s->smoke_vertices[smoke->vertex_first];
    size_t                  offset = smoke->vertex_first * SMOKE_BYTES, count = smoke->vertex_count;
    json_int_t              accessor = (json_int_t)json_array_size(json_object_get(root, "accessors"));

    int failed =
        append(root, "accessors", position_accessor(c->smoke_part, offset, count, first->place, SMOKE_BYTES / sizeof(float))) |
        append(root, "accessors",
               float_accessor(c->smoke_part, offset + offsetof(glb_smoke_vertex, radius_metres), count, "SCALAR")) |
        append(root, "accessors", float_accessor(c->smoke_part, offset + offsetof(glb_smoke_vertex, extinction), count, "SCALAR"));

    json_t *primitive = json_pack("{s:{s:I, s:I, s:I}, s:i}", "attributes", "POSITION", accessor, "_RADIUS", accessor + 1,
                                  "_EXTINCTION", accessor + 2, "mode", smoke->lines ? GL_LINES : GL_POINTS);
    failed |= !primitive;
    if (!failed && smoke->material)
        failed = json_object_set_new(primitive, "material", json_integer((json_int_t)smoke->material - 1));
    failed |= append(root, "meshes", json_pack("{s:s, s:[o]}", "name", smoke->name, "primitives", primitive));
    return failed | append_node(root, json_pack("{s:s, s:I}", "name", smoke->name, "mesh", (json_int_t)(s->mesh_count + i)));
}

/* Make all nodes so far children of a node with the translation origin_ws. */
static int append_origin(json_t *root, const double origin_ws[3])
{
    json_t *drawn    = json_array_get(json_object_get(root, "scenes"), 0);
    json_t *children = json_incref(json_object_get(drawn, "nodes"));
    if (json_object_set_new(drawn, "nodes", json_array())) return json_decref(children), 1;
    return append_node(root,
                       json_pack("{s:s, s:o, s:o}", "name", "origin", "translation", json_vector(origin_ws), "children", children));
}

static int has_sampler(const glb_material *material)
{
    return material->image && (material->wrap_u != WRAP_REPEAT || material->wrap_v != WRAP_REPEAT || material->nearest);
}

/* Texture i shows image i, repeated and bilinear. Materials with other samplers have additional textures after these. */
static size_t texture_of(const glb_scene *s, size_t material)
{
    if (!has_sampler(&s->materials[material])) return s->materials[material].image - 1;
    size_t index = s->image_count;
    for (size_t i = 0; i < material; i++) index += (size_t)has_sampler(&s->materials[i]);
    return index;
}

static int set_emission(json_t *root, json_t *material, size_t texture, double strength)
{
    static const char extension[] = "KHR_materials_emissive_strength";
    json_t *members = json_pack("{s:{s:[f,f,f,f]}, s:[f,f,f], s:{s:I}, s:{s:{s:f}}}", "pbrMetallicRoughness", "baseColorFactor",
                                0.0, 0.0, 0.0, 1.0, "emissiveFactor", 1.0, 1.0, 1.0, "emissiveTexture", "index",
                                (json_int_t)texture, "extensions", extension, "emissiveStrength", strength);
    return json_object_update_new(material, members) | append(root, "extensionsUsed", json_string(extension));
}

/* What glTF leaves to its reader is a metal, which has no colour of its own: matt in every viewer. */
static json_t *matt_surface(const glb_scene *s, const glb_material *material, size_t i)
{
    json_t *json   = json_pack("{s:f, s:f}", "metallicFactor", 0.0, "roughnessFactor", 1.0);
    int     failed = !json;
    if (!failed && material->image)
        failed |= json_object_set_new(json, "baseColorTexture", json_pack("{s:I}", "index", (json_int_t)texture_of(s, i)));
    else if (!failed && !is_zero(material->colour))
        failed |= json_object_set_new(json, "baseColorFactor",
                                      json_pack("[f,f,f,f]", material->colour[0], material->colour[1], material->colour[2], 1.0));
    if (!failed) return json;
    json_decref(json);
    return NULL;
}

static int append_material(json_t *root, const glb_scene *s, const glb_material *material, size_t i)
{
    json_t *json   = json_pack("{s:s}", "name", material->name);
    int     failed = !json;
    if (!failed && material->double_sided) failed |= json_object_set_new(json, "doubleSided", json_true());
    if (!failed && material->alpha_cutoff > 0) {
        failed |= json_object_set_new(json, "alphaMode", json_string("MASK"));
        failed |= json_object_set_new(json, "alphaCutoff", json_real(material->alpha_cutoff));
    }
    if (!failed && material->emission > 0)
        failed |= set_emission(root, json, texture_of(s, i), material->emission);
    else if (!failed)
        failed |= json_object_set_new(json, "pbrMetallicRoughness", matt_surface(s, material, i));
    return failed | append(root, "materials", json);
}

/* Meshes without a material have the one behind all others. Its mark lets `vxs view` show them in a colour of its own. */
static int append_plain_material(json_t *root, const glb_scene *s)
{
    const glb_material plain   = {.name = "plain"};
    size_t             without = 0;
    for (size_t i = 0; i < s->mesh_count; i++) without += !s->meshes[i].material;
    if (!without) return 0;
    if (append_material(root, s, &plain, s->material_count)) return 1;
    json_t *material = json_array_get(json_object_get(root, "materials"), s->material_count);
    return json_object_set_new(material, "extras", json_pack("{s:b}", "vxs_plain", 1));
}

static int append_image(json_t *root, const chunk *c, size_t i)
{
    return append(root, "textures", json_pack("{s:I}", "source", (json_int_t)i)) |
           append(root, "images", json_pack("{s:I, s:s}", "bufferView", (json_int_t)(c->image_part + i), "mimeType", "image/png"));
}

static int append_sampler(json_t *root, const glb_material *material)
{
    static const int wraps[] = {[WRAP_REPEAT] = GL_REPEAT, [WRAP_CLAMP] = GL_CLAMP_TO_EDGE, [WRAP_MIRROR] = GL_MIRRORED_REPEAT};
    json_int_t       index   = (json_int_t)json_array_size(json_object_get(root, "samplers"));
    json_t          *json    = json_pack("{s:i, s:i}", "wrapS", wraps[material->wrap_u], "wrapT", wraps[material->wrap_v]);
    int              failed  = json && material->nearest && json_object_set_new(json, "magFilter", json_integer(GL_NEAREST));
    return failed | append(root, "samplers", json) |
           append(root, "textures", json_pack("{s:I, s:I}", "sampler", index, "source", (json_int_t)material->image - 1));
}

/* Arrays appear in the order of their first item. */
static json_t *json_from_scene(const glb_scene *s, const chunk *c)
{
    json_t *root   = json_pack("{s:{s:s, s:s}}", "asset", "version", "2.0", "generator", "vxs");
    int     failed = !root;
    if (!failed && s->light_count) {
        /* Write the light definitions. */
        json_t *lights = json_array();
        failed         = !lights;
        for (size_t i = 0; !failed && i < s->light_count; i++) failed = json_array_append_new(lights, json_light(&s->lights[i]));
        failed |= json_object_set_new(root, "extensionsUsed", json_pack("[s]", "KHR_lights_punctual"));
        failed |= json_object_set_new(root, "extensions", json_pack("{s:{s:o}}", "KHR_lights_punctual", "lights", lights));
    }
    if (!failed) failed = json_object_set_new(root, "scene", json_integer(0));
    if (!failed) failed = append(root, "scenes", json_pack("{s:s}", "name", s->name));
    if (!failed && s->mesh_count + s->smoke_count + s->light_count + s->camera_count)
        failed = json_object_set_new(root, "nodes", json_array());
    if (!failed && s->mesh_count + s->smoke_count) failed = json_object_set_new(root, "meshes", json_array());
    for (size_t i = 0; !failed && i < s->mesh_count; i++) failed = append_mesh(root, c, s, i);
    for (size_t i = 0; !failed && i < s->smoke_count; i++) failed = append_smoke(root, c, s, i);
    if (!failed && s->mesh_count + s->smoke_count && !is_zero(s->origin_ws)) failed = append_origin(root, s->origin_ws);
    for (size_t i = 0; !failed && i < s->material_count; i++) failed = append_material(root, s, &s->materials[i], i);
    if (!failed) failed = append_plain_material(root, s);
    for (size_t i = 0; !failed && i < s->image_count; i++) failed = append_image(root, c, i);
    for (size_t i = 0; !failed && i < s->material_count; i++)
        failed = has_sampler(&s->materials[i]) && append_sampler(root, &s->materials[i]);
    for (size_t i = 0; !failed && i < s->light_count; i++) failed = append_light_node(root, s, i);
    if (!failed && s->camera_count)
        failed = append(root, "cameras",
                        json_pack("{s:s, s:{s:f, s:f}}", "type", "perspective", "perspective", "yfov", 1.0, "znear", 0.1));
    /* all camera nodes share one camera */
    for (size_t i = 0; !failed && i < s->camera_count; i++)
        failed = append_node(root, json_pack("{s:s, s:i, s:o}", "name", "camera", "camera", 0, "translation",
                                             json_vector(&s->camera_positions_ws[3 * i])));
    if (!failed) {
        uint64_t at = 0;
        failed      = 0;
        for (size_t i = 0; i < c->part_count; i++) {
            const part *p = &c->parts[i];
            json_t     *view =
                json_pack("{s:i, s:I, s:I}", "buffer", 0, "byteOffset", (json_int_t)at, "byteLength", (json_int_t)p->size_bytes);
            if (view && p->stride) failed |= json_object_set_new(view, "byteStride", json_integer(p->stride));
            if (view && p->target) failed |= json_object_set_new(view, "target", json_integer(p->target));
            failed |= append(root, "bufferViews", view);
            at += p->size_bytes + padding(p->size_bytes);
        }
        if (at) failed |= append(root, "buffers", json_pack("{s:I}", "byteLength", (json_int_t)at));
    }
    if (!failed) return root;
    json_decref(root);
    return NULL;
}

/* ---- the file ---- */

static vxs_result write_binary(output_file *out, const chunk *c, run_context *m)
{
    const uint32_t front[2] = {(uint32_t)c->size_bytes, GLB_BIN};
    vxs_result     r        = c->size_bytes ? output_file_write(out, front, sizeof front, m) : VXS_OK;
    for (size_t i = 0; r == VXS_OK && i < c->part_count; i++) {
        const part *p = &c->parts[i];
        if ((r = output_file_write(out, p->bytes, p->size_bytes, m)) == VXS_OK)
            r = output_file_write(out, "\0\0\0", padding(p->size_bytes), m);
    }
    return r;
}

static vxs_result write_file(output_file *out, const char *text, const chunk *c, run_context *m)
{
    uint64_t text_bytes = strlen(text), binary_bytes = c->size_bytes ? 8 + c->size_bytes : 0;
    uint64_t file_bytes = 12 + 8 + text_bytes + padding(text_bytes) + binary_bytes;
    if (file_bytes > UINT32_MAX)
        return fail(m, VXS_E_ARGUMENT, "%s: a GLB file cannot have %llu bytes, expected less than 4 GiB", out->name,
                    (unsigned long long)file_bytes);

    const uint32_t front[5] = {GLB_MAGIC, 2, (uint32_t)file_bytes, (uint32_t)(text_bytes + padding(text_bytes)), GLB_JSON};
    vxs_result     r;
    if ((r = output_file_write(out, front, sizeof front, m)) != VXS_OK) return r;
    if ((r = output_file_write(out, text, text_bytes, m)) != VXS_OK) return r;
    if ((r = output_file_write(out, "   ", padding(text_bytes), m)) != VXS_OK) return r;
    return write_binary(out, c, m);
}

vxs_result glb_write(const glb_scene *s, output_file *out, run_context *m)
{
    chunk      c;
    char      *text = NULL;
    json_t    *root = chunk_of(&c, s) ? NULL : json_from_scene(s, &c);
    vxs_result r;

    /* 17 digits reproduce a double exactly; jansson keeps insertion order and ignores the locale */
    if (root) text = json_print(root, JSON_COMPACT | JSON_REAL_PRECISION(17));
    r = text ? write_file(out, text, &c, m) : fail(m, VXS_E_MEMORY, "out of memory while writing %s", out->name);
    free(text);
    json_decref(root);
    for (size_t i = 0; i < c.part_count; i++) free(c.parts[i].owned);
    free(c.parts);
    return r;
}

void glb_scene_free(glb_scene *s)
{
    for (size_t i = 0; i < s->image_count; i++) free(s->images[i].rgba);
    free(s->positions);
    free(s->texcoords);
    free(s->indices);
    free(s->meshes);
    free(s->materials);
    free(s->images);
    for (size_t i = 0; i < s->light_count; i++) free(s->lights[i].name);
    free(s->lights);
    free(s->camera_positions_ws);
    free(s->smoke);
    free(s->smoke_vertices);
    *s = (glb_scene){0};
}
