/* Meshes of a current shadow depth map, with few triangles where it is flat; see vxs_volumes.h. In each frame, shaders choose the
 * quads of vxs_mesh_quads.h level by level, list their triangles, and draw the listed triangles.
 * SPDX-License-Identifier: MIT */
#include <limits.h>

#include "light_mesh.h"
#include "vxs_desc.h"
#include "vxs_mesh_quads.h"

/* As in mesh_quads.glsl (std430); corners follow. */
typedef struct list_head {
    uint32_t corners_drawn, instances, first_corner, first_instance;
    uint32_t triangles, reserved[3];
} list_head;
_Static_assert(sizeof(list_head) == 32, "a head is eight words");

struct vxs_adaptive_mesh {
    vxs_volumes   *volumes;
    vxs_mesh_shape most; /* of the largest map; only the fields that determine the number of triangles */
    uint32_t       triangles_most;
    gl_name        splits, list, list_texture;
};

static uint64_t split_bytes(const vxs_mesh_shape *shape)
{
    return 4 * ((uint64_t)shape->layers * (uint64_t)vxs_mesh_larger_quads(shape->levels) + 1); /* 0 for a layer of one texel */
}

static uint64_t list_bytes(const vxs_adaptive_mesh *mesh)
{
    return sizeof(list_head) + 12 * (uint64_t)mesh->triangles_most;
}

/* Largest size of a storage buffer that is also read as a texture. */
static uint64_t list_bytes_most(const vxs_volumes *v)
{
    int storage = 0, texels = 0;
    v->api.GetIntegerv(GL_MOST_STORAGE_BYTES, &storage);
    v->api.GetIntegerv(GL_MOST_BUFFER_TEXELS, &texels);
    return (uint32_t)storage / 4 < (uint32_t)texels ? (uint32_t)storage : 4 * (uint64_t)(uint32_t)texels;
}

static uint32_t triangles_at_most(const vxs_volumes *v, const vxs_mesh_shape *shape, uint32_t asked)
{
    uint32_t all   = (uint32_t)vxs_mesh_triangles(shape);
    uint64_t holds = (list_bytes_most(v) - sizeof(list_head)) / 12;
    if (asked) return asked < all ? asked : all;
    return holds < all ? (uint32_t)holds : all;
}

static vxs_result make(vxs_adaptive_mesh *mesh)
{
    vxs_volumes *v = mesh->volumes;
    if (split_bytes(&mesh->most) > list_bytes_most(v) || list_bytes(mesh) > list_bytes_most(v))
        return vxs_volumes_fail(
            v, VXS_E_GL, "an adaptive mesh is larger than a buffer of this context: use a smaller side_px or triangles_most");
    mesh->splits = vxs_volumes_buffer(v, split_bytes(&mesh->most));
    mesh->list   = vxs_volumes_buffer(v, list_bytes(mesh));
    if (!mesh->splits || !mesh->list) return VXS_E_MEMORY;
    v->api.CreateTextures(GL_TARGET_TEXTURE_BUFFER, 1, &mesh->list_texture);
    v->api.TextureBuffer(mesh->list_texture, GL_FORMAT_R32UI, mesh->list);
    return VXS_OK;
}

vxs_result vxs_adaptive_mesh_create(vxs_adaptive_mesh **out, vxs_volumes *v, const vxs_adaptive_mesh_desc *desc)
{
    vxs_adaptive_mesh_desc known = {0};
    const size_t           first = offsetof(vxs_adaptive_mesh_desc, triangles_most) + sizeof known.triangles_most;
    *out                         = NULL;
    if (vxs_desc_take(&known, sizeof known, first, desc) != VXS_OK) return VXS_E_ARGUMENT;
    vxs_mesh_shape shape = {.side   = (int32_t)known.side_px,
                            .levels = vxs_mesh_levels(known.side_px),
                            .layers = (int32_t)known.layers,
                            .is_sun = known.layers == 1};
    if (shape.levels < 0 || (shape.layers != 1 && shape.layers != 6)) return VXS_E_ARGUMENT;
    if (vxs_mesh_triangles(&shape) > INT_MAX / 3) return VXS_E_ARGUMENT;
    vxs_adaptive_mesh *mesh = vxs_volumes_alloc(v, sizeof *mesh);
    if (!mesh) return VXS_E_MEMORY;
    uint32_t most     = triangles_at_most(v, &shape, known.triangles_most);
    *mesh             = (vxs_adaptive_mesh){.volumes = v, .most = shape, .triangles_most = most};
    vxs_result result = make(mesh);
    if (result == VXS_OK)
        *out = mesh;
    else
        vxs_adaptive_mesh_destroy(mesh);
    return result;
}

void vxs_adaptive_mesh_destroy(vxs_adaptive_mesh *mesh)
{
    if (!mesh) return;
    const vxs_volumes *v         = mesh->volumes;
    const gl_name      buffers[] = {mesh->splits, mesh->list};
    if (mesh->list_texture) v->api.DeleteTextures(1, &mesh->list_texture);
    for (int n = 0; n < 2; n++)
        if (buffers[n]) v->api.DeleteBuffers(1, &buffers[n]);
    vxs_volumes_free(v, mesh, sizeof *mesh);
}

unsigned vxs_adaptive_mesh_buffer(const vxs_adaptive_mesh *mesh)
{
    return mesh->list;
}

/* Run a program, of its own text, over the quads of a level, or parts of them.   side  number of them along a side of each layer */
static void run(const vxs_adaptive_mesh *mesh, const volumes_text *text, gl_name map, int level, int side)
{
    enum { GROUP = 8 };
    vxs_volumes *v       = mesh->volumes;
    uint32_t     groups  = ((uint32_t)side + GROUP - 1) / GROUP;
    gl_name      program = vxs_volumes_program(v, &(program_texts){.body = text});
    v->own.mesh.level    = level;
    saved_state saved    = vxs_volumes_use(v, program, map, 0, 0);
    vxs_volumes_dispatch(v, groups, groups, v->frame.map_layers);
    vxs_volumes_restore(v, &saved);
}

/* As in light_mesh.c: first split quads with too large errors, from the root down; then split neighbours, from the smallest up. */
static void choose_quads(const vxs_adaptive_mesh *mesh, const vxs_mesh_shape *shape, gl_name map, float error_texels)
{
    const volumes_api *api = &mesh->volumes->api;
    const uint32_t     all = error_texels == 0;
    api->ClearNamedBufferSubData(mesh->splits, GL_FORMAT_R32UI, 0, (gl_bytes)split_bytes(shape), GL_FORMAT_RED_INTEGER,
                                 GL_TYPE_UNSIGNED_INT, &all);
    if (all) return;
    for (int level = shape->levels; level > 0; level--)
        run(mesh, &vxs_volumes_text_mesh_split_glsl, map, level,
            shape->side >> (level < 3 ? level : 3)); /* as in mesh_split.glsl */
    for (int level = 1; level < shape->levels; level++)
        run(mesh, &vxs_volumes_text_mesh_balance_glsl, map, level, shape->side >> level);
}

static void list_triangles(const vxs_adaptive_mesh *mesh, const vxs_mesh_shape *shape, gl_name map)
{
    const list_head none  = {.instances = 1};
    int             least = shape->levels > 0; /* quads of one texel are listed by the quads that split into them */
    vxs_volumes_put(mesh->volumes, mesh->list, 0, sizeof none, &none);
    for (int level = shape->levels; level >= least; level--)
        run(mesh, &vxs_volumes_text_mesh_list_glsl, map, level, shape->side >> level);
}

vxs_result vxs_volumes_mesh_adaptive(vxs_volumes *v, const vxs_volumes_light *light, const vxs_shadow_depth_map *map,
                                     vxs_adaptive_mesh *mesh, float error_texels)
{
    vxs_mesh_shape shape;
    if (!map || !mesh || !(error_texels >= 0)) return VXS_E_ARGUMENT;
    if (map->side_px > (uint32_t)mesh->most.side || map->layers > (uint32_t)mesh->most.layers) return VXS_E_ARGUMENT;
    vxs_result result = vxs_mesh_begin(v, light, map, &shape);
    if (result != VXS_OK || vxs_volumes_find_cull_result(v, &v->frame.pixels) != VXS_NOT_CULLED) return result;
    gl_name       texture      = vxs_shadow_depth_map_texture(map);
    saved_storage saved        = vxs_volumes_save_storage(v);
    v->own.mesh.error_texels   = error_texels;
    v->own.mesh.triangles_most = mesh->triangles_most;
    vxs_volumes_use_storage(v, mesh->splits, mesh->list);
    choose_quads(mesh, &shape, texture, error_texels);
    list_triangles(mesh, &shape, texture);
    vxs_volumes_restore_storage(v, &saved);
    gl_name program = vxs_mesh_program(v, "#define VXS_MESH_OF_MAP\n#define VXS_MESH_LISTED\n");
    vxs_mesh_add(v, map, &(mesh_draw){.program = program, .texture = mesh->list_texture, .commands = mesh->list});
    return vxs_volumes_done(v);
}
