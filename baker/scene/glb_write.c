/* Triangle meshes and one directional light as a binary glTF 2.0 file (glTF 2.0 specification, section 4, "GLB File
 * Format").
 *
 *     header  magic, version 2, length of the file            3 words
 *     chunk   length, "JSON", text padded with spaces         2 words + text
 *     chunk   length, "BIN\0", positions, indices             2 words + data; its parts are whole words, so never padded
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/scene/glb_write.h"

#include <jansson.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#if __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
#error "positions and indices are written as they lie in memory, which GLB wants little-endian"
#endif

enum {
    GLB_MAGIC            = 0x46546c67,
    GLB_JSON             = 0x4e4f534a,
    GLB_BIN              = 0x004e4942,
    GL_UNSIGNED_INT      = 5125,
    GL_FLOAT             = 5126,
    ARRAY_BUFFER         = 34962,
    ELEMENT_ARRAY_BUFFER = 34963,
    VERTEX_BYTES         = 3 * sizeof(float),
    TRIANGLE_BYTES       = 3 * sizeof(uint32_t)
};

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
    if (norm == 0) { /* straight along +Z: half a turn, about any axis across */
        q[0] = q[2] = q[3] = 0;
        q[1]               = 1;
        return;
    }
    q[0] = d[1] / norm;
    q[1] = 0 - d[0] / norm; /* not -d[0]: no "-0.0" in the file */
    q[2] = 0;
    q[3] = w / norm;
}

static json_t *json_real3(const float v[3])
{
    return json_pack("[f,f,f]", (double)v[0], (double)v[1], (double)v[2]);
}

static json_t *position_accessor(const glb_scene *s, const glb_mesh *mesh)
{
    const float *p = s->positions + 3 * mesh->vertex_first;
    float        low[3], high[3];
    memcpy(low, p, sizeof low);
    memcpy(high, p, sizeof high);
    for (size_t i = 1; i < mesh->vertex_count; i++)
        for (int axis = 0; axis < 3; axis++) {
            float x = p[3 * i + axis];
            if (x < low[axis]) low[axis] = x;
            if (x > high[axis]) high[axis] = x;
        }
    return json_pack("{s:i, s:I, s:i, s:I, s:s, s:o, s:o}", "bufferView", 0, "byteOffset",
                     (json_int_t)(mesh->vertex_first * VERTEX_BYTES), "componentType", GL_FLOAT, "count",
                     (json_int_t)mesh->vertex_count, "type", "VEC3", "min", json_real3(low), "max", json_real3(high));
}

static json_t *index_accessor(const glb_mesh *mesh)
{
    return json_pack("{s:i, s:I, s:i, s:I, s:s}", "bufferView", 1, "byteOffset",
                     (json_int_t)(mesh->triangle_first * TRIANGLE_BYTES), "componentType", GL_UNSIGNED_INT, "count",
                     (json_int_t)(3 * mesh->triangle_count), "type", "SCALAR");
}

/* Mesh i has accessors 2i and 2i + 1, and node i; the light is the last node. */
static int append_mesh(json_t *root, const glb_scene *s, size_t i)
{
    const glb_mesh *mesh      = &s->meshes[i];
    json_t         *accessors = json_object_get(root, "accessors");
    json_t         *gltf_mesh = json_pack("{s:s, s:[{s:{s:I}, s:I}]}", "name", mesh->name, "primitives", "attributes", "POSITION",
                                          (json_int_t)(2 * i), "indices", (json_int_t)(2 * i + 1));
    json_t         *node      = json_pack("{s:s, s:I}", "name", mesh->name, "mesh", (json_int_t)i);
    json_t         *drawn     = json_object_get(json_array_get(json_object_get(root, "scenes"), 0), "nodes");

    int failed = json_array_append_new(accessors, position_accessor(s, mesh));
    failed |= json_array_append_new(accessors, index_accessor(mesh));
    failed |= json_array_append_new(json_object_get(root, "meshes"), gltf_mesh);
    failed |= json_array_append_new(json_object_get(root, "nodes"), node);
    failed |= json_array_append_new(drawn, json_integer((json_int_t)i));
    return failed;
}

static int append_sun(json_t *root, const glb_scene *s)
{
    double q[4];
    quaternion_from_direction(q, s->sun_direction);
    json_t *node  = json_pack("{s:s, s:[f,f,f,f], s:{s:{s:i}}}", "name", "sun", "rotation", q[0], q[1], q[2], q[3], "extensions",
                              "KHR_lights_punctual", "light", 0);
    json_t *drawn = json_object_get(json_array_get(json_object_get(root, "scenes"), 0), "nodes");

    int failed = json_array_append_new(json_object_get(root, "nodes"), node);
    failed |= json_array_append_new(drawn, json_integer((json_int_t)s->mesh_count));
    return failed;
}

static json_t *json_from_scene(const glb_scene *s, uint64_t position_bytes, uint64_t index_bytes)
{
    json_t *root   = json_pack("{s:{s:s, s:s}, s:[s], s:{s:{s:[{s:s, s:s}]}}, s:i, s:[{s:s, s:[]}], s:[], s:[], s:[],"
                                 " s:[{s:i, s:i, s:I, s:i, s:i}, {s:i, s:I, s:I, s:i}], s:[{s:I}]}",
                               "asset", "version", "2.0", "generator", "vxs", "extensionsUsed", "KHR_lights_punctual", "extensions",
                               "KHR_lights_punctual", "lights", "name", "sun", "type", "directional", "scene", 0, "scenes", "name",
                               s->name, "nodes", "nodes", "meshes", "accessors", "bufferViews", "buffer", 0, "byteOffset", 0,
                               "byteLength", (json_int_t)position_bytes, "byteStride", VERTEX_BYTES, "target", ARRAY_BUFFER, "buffer",
                               0, "byteOffset", (json_int_t)position_bytes, "byteLength", (json_int_t)index_bytes, "target",
                               ELEMENT_ARRAY_BUFFER, "buffers", "byteLength", (json_int_t)(position_bytes + index_bytes));
    int     failed = !root;
    for (size_t i = 0; !failed && i < s->mesh_count; i++) failed = append_mesh(root, s, i);
    if (!failed) failed = append_sun(root, s);
    if (!failed) return root;
    json_decref(root);
    return NULL;
}

vxs_result glb_write(const glb_scene *s, output_file *out, message *m)
{
    uint64_t   position_bytes = (uint64_t)s->vertex_count * VERTEX_BYTES;
    uint64_t   index_bytes    = (uint64_t)s->triangle_count * TRIANGLE_BYTES;
    json_t    *root           = json_from_scene(s, position_bytes, index_bytes);
    char      *text           = NULL;
    vxs_result r;

    /* 17 digits bring back the same double; jansson keeps the order of insertion and ignores the locale */
    if (root) text = json_dumps(root, JSON_COMPACT | JSON_REAL_PRECISION(17));
    if (!text) {
        r = fail(m, VXS_E_MEMORY, "out of memory while writing %s", out->name);
        goto done;
    }

    uint64_t json_bytes = strlen(text), padding = -json_bytes & 3;
    uint64_t file_bytes = 12 + 8 + json_bytes + padding + 8 + position_bytes + index_bytes;
    if (file_bytes > UINT32_MAX) {
        r = fail(m, VXS_E_ARGUMENT, "%s: a GLB file cannot have %llu bytes, expected less than 4 GiB", out->name,
                 (unsigned long long)file_bytes);
        goto done;
    }
    const uint32_t front[5]  = {GLB_MAGIC, 2, (uint32_t)file_bytes, (uint32_t)(json_bytes + padding), GLB_JSON};
    const uint32_t middle[2] = {(uint32_t)(position_bytes + index_bytes), GLB_BIN};

    if ((r = output_file_write(out, front, sizeof front, m)) != VXS_OK) goto done;
    if ((r = output_file_write(out, text, json_bytes, m)) != VXS_OK) goto done;
    if ((r = output_file_write(out, "   ", padding, m)) != VXS_OK) goto done;
    if ((r = output_file_write(out, middle, sizeof middle, m)) != VXS_OK) goto done;
    if ((r = output_file_write(out, s->positions, position_bytes, m)) != VXS_OK) goto done;
    r = output_file_write(out, s->indices, index_bytes, m);
done:
    free(text);
    json_decref(root);
    return r;
}

void glb_scene_free(glb_scene *s)
{
    free(s->positions);
    free(s->indices);
    free(s->meshes);
    *s = (glb_scene){0};
}
