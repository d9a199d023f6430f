/* Polygonal light volumes, drawn; see vxs_volumes.h.
 * SPDX-License-Identifier: MIT */
#include <limits.h>
#include <math.h>
#include <stddef.h>

#include "light_mesh.h"

#define FAR_MOST 1e12 /* metres: squares of coordinates still fit in a float */

/* Matrices in double, column-major. */

static void multiply(const double a[16], const double b[16], double out[16])
{
    for (int n = 0; n < 16; n++) {
        out[n] = 0;
        for (int k = 0; k < 4; k++) out[n] += a[4 * k + n % 4] * b[4 * (n / 4) + k];
    }
}

/* Gaussian elimination with the largest pivots.   Returns 0 if there is no inverse. */
static int invert(const double of[16], double out[16])
{
    double rows[4][8];
    for (int row = 0; row < 4; row++)
        for (int n = 0; n < 8; n++) rows[row][n] = n < 4 ? of[4 * n + row] : n == 4 + row;
    for (int k = 0; k < 4; k++) {
        int most = k;
        for (int row = k; row < 4; row++)
            if (fabs(rows[row][k]) > fabs(rows[most][k])) most = row;
        if (!(fabs(rows[most][k]) > 0) || !isfinite(rows[most][k])) return 0;
        for (int n = 0; n < 8; n++) {
            double swap   = rows[k][n];
            rows[k][n]    = rows[most][n];
            rows[most][n] = swap;
        }
        for (int n = 7; n >= k; n--) rows[k][n] /= rows[k][k];
        for (int row = 0; row < 4; row++)
            for (int n = 7; n >= k && row != k; n--) rows[row][n] -= rows[row][k] * rows[k][n];
    }
    for (int n = 0; n < 16; n++) out[n] = rows[n % 4][4 + n / 4];
    return 1;
}

/* Clip space of the view, as in OpenGL except for depth; w is positive before the eye. */
static int clip_from_point(const frame_block *f, double out[16])
{
    const double clip[16] = {2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1, 0, -1, -1, 0, 1};
    double       point_from_depth[16], depth_from_point[16], middle_w = 0;
    for (int n = 0; n < 16; n++) point_from_depth[n] = (double)f->point_from_depth[n];
    if (!invert(point_from_depth, depth_from_point)) return 0;
    for (int n = 0; n < 4; n++) middle_w += point_from_depth[4 * n + 3] * (n < 3 ? 0.5 : 1);
    for (int n = 0; n < 16 && middle_w < 0; n++) depth_from_point[n] = -depth_from_point[n];
    multiply(clip, depth_from_point, out);
    return 1;
}

/* Whether counterclockwise in light space is counterclockwise in the view, too, as seen from the eye. */
static float turn_of(const double clip[16])
{
    static const int rows[3] = {0, 1, 3};
    double           d       = 0;
    for (int n = 0; n < 3; n++) {
        int next = (n + 1) % 3, after = (n + 2) % 3;
        d += clip[rows[n]] * (clip[4 + rows[next]] * clip[8 + rows[after]] - clip[4 + rows[after]] * clip[8 + rows[next]]);
    }
    return d < 0 ? -1.0F : 1.0F;
}

/* Set the matrices of the light and its mesh in the view.   eye_ls  [out]   Returns 0 if there is no inverse. */
static int set_places(mesh_block *to, const frame_block *f, double eye_ls[3])
{
    double ls_from_ws[16] = {[15] = 1}, point_from_ls[16], clip[16], clip_ls[16];
    for (int n = 0; n < 12; n++) ls_from_ws[4 * (n % 4) + n / 4] = (double)f->light.ls_from_ws[n];
    if (!invert(ls_from_ws, point_from_ls) || !clip_from_point(f, clip)) return 0;
    for (int row = 0; row < 3; row++) {
        eye_ls[row] = ls_from_ws[12 + row];
        for (int n = 0; n < 3; n++) eye_ls[row] += ls_from_ws[4 * n + row] * (double)f->eye[n];
    }
    multiply(clip, point_from_ls, clip_ls);
    for (int n = 0; n < 3; n++) point_from_ls[12 + n] -= (double)f->eye[n];
    for (int n = 0; n < 16; n++) {
        to->clip_from_ls[n] = (float)clip_ls[n];
        to->eye_from_ls[n]  = (float)point_from_ls[n];
        if (!isfinite(to->clip_from_ls[n]) || !isfinite(to->eye_from_ls[n])) return 0;
    }
    to->turn = turn_of(clip_ls);
    return 1;
}

/* The shape is so large that no eye ray leaves it, except where a punctual light's range ends. */
static vxs_mesh_shape set_shape(mesh_block *to, const frame_block *f, const double eye_ls[3])
{
    double far_metres = (double)f->far_metres;
    int    is_sun     = f->light.kind == VXS_LIGHT_KIND_DIRECTIONAL;
    for (int n = 0; n < 3 && !is_sun; n++) far_metres += fabs(eye_ls[n]);
    vxs_mesh_shape s = vxs_light_mesh_shape(&f->light, f->map_side_px, far_metres < FAR_MOST ? far_metres : FAR_MOST, eye_ls);
    to->low          = (float)s.low;
    to->high         = (float)s.high;
    to->texel        = (float)s.texel;
    to->least        = (float)s.least;
    to->reach        = (float)s.reach;
    to->error_scale  = (float)s.error_scale;
    to->first        = s.first;
    to->last         = s.last;
    for (int n = 0; n < 3; n++) {
        to->box_low[n]  = (float)s.box_low[n];
        to->box_high[n] = (float)s.box_high[n];
    }
    return s;
}

vxs_result vxs_mesh_begin(vxs_volumes *v, const vxs_volumes_light *light, const vxs_shadow_depth_map *map, vxs_mesh_shape *shape)
{
    double eye_ls[3];
    if (light->smoke) return VXS_E_ARGUMENT;
    vxs_result result = vxs_volumes_set_light(v, light, map);
    if (result != VXS_OK) return result;
    v->own.mesh = (mesh_block){0};
    if (!set_places(&v->own.mesh, &v->frame, eye_ls)) return VXS_E_ARGUMENT;
    if (!map) return VXS_OK;
    if (vxs_mesh_levels(map->side_px) < 0) return VXS_E_ARGUMENT;
    *shape = set_shape(&v->own.mesh, &v->frame, eye_ls);
    return vxs_mesh_triangles(shape) <= INT_MAX / 3 ? VXS_OK : VXS_E_ARGUMENT;
}

gl_name vxs_mesh_program(vxs_volumes *v, const char *names)
{
    return vxs_volumes_light_program(
        v, &(program_texts){names, .vertex = &vxs_volumes_text_mesh_vert_glsl, .body = &vxs_volumes_text_mesh_frag_glsl});
}

static void draw_corners(const vxs_volumes *v, const mesh_draw *draw)
{
    const volumes_api *api = &v->api;
    int                commands;
    if (!vxs_volumes_can_draw(v)) return;
    if (draw->vertex_array) {
        api->BindVertexArray(draw->vertex_array);
        api->DrawElements(GL_MODE_TRIANGLES, draw->corners, GL_TYPE_UNSIGNED_INT, NULL);
    } else if (draw->commands) {
        api->GetIntegerv(GL_IS_DRAW_COMMANDS, &commands);
        api->BindBuffer(GL_TARGET_DRAW_COMMANDS, draw->commands);
        api->DrawArraysIndirect(GL_MODE_TRIANGLES, NULL);
        api->BindBuffer(GL_TARGET_DRAW_COMMANDS, (gl_name)commands);
    } else
        api->DrawArrays(GL_MODE_TRIANGLES, 0, draw->corners);
}

/* Draw the crossings of the frame, in the pixels that may see the light. Alpha counts the crossings of this light alone. */
static void draw_crossings(const vxs_volumes *v, const mesh_draw *draw)
{
    static const float none[4] = {0};
    const volumes_api *api     = &v->api;
    const vxs_pixels  *p       = &v->frame.pixels;
    saved_raster       saved   = vxs_volumes_draw(v, GL_BLEND_ONE, GL_BLEND_ONE, GL_BLEND_ONE);
    api->Scissor((int)p->x, (int)p->y, (int)p->wide_px, (int)p->high_px);
    api->Enable(GL_STATE_SCISSOR_TEST);
    api->ColorMaski(0, 0, 0, 0, 1);
    api->ClearNamedFramebufferfv(v->target, GL_BUFFER_COLOUR, 0, none);
    api->ColorMaski(0, 1, 1, 1, 1);
    api->BindFramebuffer(GL_TARGET_DRAW_FRAMEBUFFER, v->target);
    api->ActiveTexture(GL_UNIT_0 + v->first_unit + UNIT_MESH);
    api->BindTexture(GL_TARGET_TEXTURE_BUFFER, draw->texture);
    draw_corners(v, draw);
    vxs_volumes_restore_raster(v, &saved);
}

/* Add the airlight of crossings; then that of the whole ray, where the crossings show that the eye is in light. */
void vxs_mesh_add(vxs_volumes *v, const vxs_shadow_depth_map *map, const mesh_draw *draw)
{
    if (vxs_volumes_find_cull_result(v, &v->frame.pixels) != VXS_NOT_CULLED) return;
    saved_state saved = vxs_volumes_use(v, draw->program, map ? vxs_shadow_depth_map_texture(map) : 0, 0, 0);
    draw_crossings(v, draw);
    vxs_volumes_restore(v, &saved);
    vxs_volumes_add(v, vxs_volumes_light_program(v, &(program_texts){.body = &vxs_volumes_text_mesh_whole_glsl}), 0);
}

vxs_result vxs_volumes_mesh_map(vxs_volumes *v, const vxs_volumes_light *light, const vxs_shadow_depth_map *map)
{
    vxs_mesh_shape shape;
    if (!map) return VXS_E_ARGUMENT;
    vxs_result result = vxs_mesh_begin(v, light, map, &shape);
    if (result != VXS_OK) return result;
    gl_name program = vxs_mesh_program(v, "#define VXS_MESH_OF_MAP\n");
    vxs_mesh_add(v, map, &(mesh_draw){.program = program, .corners = 3 * vxs_mesh_triangles(&shape)});
    return vxs_volumes_done(v);
}

/* made in C -------------------------------------------------------------------------------------------------------------------- */

vxs_result vxs_light_mesh_create(vxs_light_mesh **out, vxs_volumes *v, const float *places, const uint32_t *corners,
                                 const vxs_light_mesh_size *size)
{
    const volumes_api *api          = &v->api;
    int                most         = 0;
    uint64_t           corner_words = 3 * (uint64_t)size->triangle_count, place_words = 3 * (uint64_t)size->vertex_count;
    gl_bytes           corner_bytes = (gl_bytes)(corner_words * sizeof *corners);
    gl_bytes           place_bytes  = (gl_bytes)(place_words * sizeof *places);
    *out                            = NULL;
    if (!places || !corners || !size->vertex_count || !size->triangle_count) return VXS_E_ARGUMENT;
    api->GetIntegerv(GL_MOST_BUFFER_TEXELS, &most);
    if (corner_words + place_words > (uint64_t)most)
        return vxs_volumes_fail(v, VXS_E_MEMORY,
                                "a light mesh is larger than a buffer texture of this context: plan it with a larger error_texels");
    vxs_light_mesh *mesh = vxs_volumes_alloc(v, sizeof *mesh);
    if (!mesh) return VXS_E_MEMORY;
    *mesh = (vxs_light_mesh){.volumes = v, .triangle_count = size->triangle_count};
    vxs_volumes_forget_error(v);
    api->CreateBuffers(1, &mesh->words);
    api->NamedBufferStorage(mesh->words, corner_bytes + place_bytes, NULL, GL_STORAGE_DYNAMIC);
    if (api->GetError() != GL_ERROR_NONE) {
        vxs_light_mesh_destroy(mesh);
        return VXS_E_MEMORY;
    }
    api->NamedBufferSubData(mesh->words, 0, corner_bytes, corners);
    api->NamedBufferSubData(mesh->words, corner_bytes, place_bytes, places);
    api->CreateTextures(GL_TARGET_TEXTURE_BUFFER, 1, &mesh->texture);
    api->TextureBuffer(mesh->texture, GL_FORMAT_R32UI, mesh->words);
    api->CreateVertexArrays(1, &mesh->vertex_array);
    api->EnableVertexArrayAttrib(mesh->vertex_array, 0);
    api->VertexArrayAttribFormat(mesh->vertex_array, 0, 3, GL_TYPE_FLOAT, 0, 0);
    api->VertexArrayAttribBinding(mesh->vertex_array, 0, 0);
    api->VertexArrayVertexBuffer(mesh->vertex_array, 0, mesh->words, corner_bytes, 3 * sizeof *places);
    api->VertexArrayElementBuffer(mesh->vertex_array, mesh->words);
    *out = mesh;
    return VXS_OK;
}

void vxs_light_mesh_destroy(vxs_light_mesh *mesh)
{
    if (!mesh) return;
    const vxs_volumes *v = mesh->volumes;
    if (mesh->vertex_array) v->api.DeleteVertexArrays(1, &mesh->vertex_array);
    if (mesh->texture) v->api.DeleteTextures(1, &mesh->texture);
    if (mesh->words) v->api.DeleteBuffers(1, &mesh->words);
    vxs_volumes_free(v, mesh, sizeof *mesh);
}

unsigned vxs_light_mesh_buffer(const vxs_light_mesh *mesh)
{
    return mesh->words;
}

uint32_t vxs_light_mesh_triangles(const vxs_light_mesh *mesh)
{
    return mesh->triangle_count;
}

vxs_result vxs_volumes_mesh(vxs_volumes *v, const vxs_volumes_light *light, const vxs_light_mesh *mesh)
{
    if (!mesh) return VXS_E_ARGUMENT;
    vxs_result result = vxs_mesh_begin(v, light, NULL, NULL);
    if (result != VXS_OK) return result;
    v->own.mesh.first_place = (int32_t)(3 * mesh->triangle_count); /* positions are stored after corners */
    vxs_mesh_add(v, NULL,
                 &(mesh_draw){.program      = vxs_mesh_program(v, ""),
                              .texture      = mesh->texture,
                              .vertex_array = mesh->vertex_array,
                              .corners      = 3 * (int)mesh->triangle_count});
    return vxs_volumes_done(v);
}
