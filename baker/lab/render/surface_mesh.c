/* Triangles of a scene as OpenGL draws them here; see surface_mesh.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/render/surface_mesh.h"

#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/box.h"
#include "baker/base/memory.h"
#include "baker/base/vec3.h"

/* The default colour of materials. */
static const float plain[3] = {0.66f, 0.62f, 0.56f};

typedef struct surface_vertex {
    float   position[3], normal[3];
    uint8_t colour[4]; /* the square root of the linear colour: 8 linear bits are too few for dark colours */
    float   uv[2];
} surface_vertex;

typedef struct filling {
    const scene    *scene;
    surface_mesh   *mesh;
    surface_vertex *vertices; /* [3 * triangle_count] */
    uint32_t       *mask_of;  /* [triangle_count] 0: none; else 1 + its mask */
    float (*uvs)[3][2];       /* [triangle_count] where there is a mask */
} filling;

/* Triangles without a mask come first, then those of each mask. */
static void fill(filling *f)
{
    surface_mesh *mesh  = f->mesh;
    size_t        count = f->scene->triangle_count;
    uint32_t      part  = 0;
    for (size_t n = 0; n < count; n++) mesh->first[f->mask_of[n] + 1]++;
    for (size_t n = 1; n < mesh->mask_count + 2; n++) mesh->first[n] += mesh->first[n - 1];
    for (size_t n = 0; n < count; n++) {
        part = scene_part_at(f->scene, part, n);

        surface_vertex *out       = f->vertices + 3 * mesh->first[f->mask_of[n]]++;
        const scene    *s         = f->scene;
        const uint32_t *index     = s->indices + 3 * n;
        const double   *corner[3] = {s->positions_ws + 3 * (size_t)index[0], s->positions_ws + 3 * (size_t)index[1],
                                     s->positions_ws + 3 * (size_t)index[2]};
        double          a[3], b[3], across[3], normal[3] = {0, 1, 0};
        vec3_sub(corner[1], corner[0], a);
        vec3_sub(corner[2], corner[0], b);
        vec3_cross(a, b, across);
        vec3_unit(across, normal);
        for (int j = 0; j < 3; j++) {
            out[j]              = (surface_vertex){0};
            const float *linear = plain;
            if (part < s->part_count && s->parts[part].material < s->material_count)
                linear = s->material_colours[s->parts[part].material];
            for (int i = 0; i < 3; i++) out[j].colour[i] = (uint8_t)(255 * sqrtf(linear[i]) + 0.5f);
            out[j].colour[3] = 255;
            for (int k = 0; k < 3; k++) {
                out[j].position[k] = (float)(corner[j][k] - mesh->middle_ws[k]);
                out[j].normal[k]   = (float)normal[k];
            }
            memcpy(out[j].uv, f->uvs[n][j], sizeof out[j].uv);
        }
    }
    memmove(mesh->first + 1, mesh->first, (mesh->mask_count + 1) * sizeof *mesh->first);
    mesh->first[0] = 0;
}

static void put_vertices(surface_mesh *mesh, const gl_context *gl, const surface_vertex *vertices, size_t count)
{
    static const struct {
        GLint  size;
        GLenum type;
        size_t offset;
    } attributes[] = {{3, GL_FLOAT, offsetof(surface_vertex, position)},
                      {3, GL_FLOAT, offsetof(surface_vertex, normal)},
                      {4, GL_UNSIGNED_BYTE, offsetof(surface_vertex, colour)},
                      {2, GL_FLOAT, offsetof(surface_vertex, uv)}};
    gl->GenVertexArrays(1, &mesh->array);
    gl->BindVertexArray(mesh->array);
    gl->GenBuffers(1, &mesh->vertices);
    gl->BindBuffer(GL_ARRAY_BUFFER, mesh->vertices);
    gl->BufferData(GL_ARRAY_BUFFER, (GLsizeiptr)(count * sizeof *vertices), vertices, GL_STATIC_DRAW);
    for (GLuint n = 0; n < 4; n++) {
        gl->VertexAttribPointer(n, attributes[n].size, attributes[n].type, attributes[n].type == GL_UNSIGNED_BYTE, sizeof *vertices,
                                (const void *)attributes[n].offset);
        gl->EnableVertexAttribArray(n);
    }
}

vxs_result surface_mesh_make(surface_mesh *mesh, gl_context *gl, const scene *s, run_context *m)
{
    *mesh        = (surface_mesh){.mask_count = s->alpha_mask_count};
    box        b = box_of_corners(s->positions_ws, s->indices, 3 * s->triangle_count);
    filling    f = {.scene = s, .mesh = mesh};
    vxs_result r =
        memory_check(3 * (uint64_t)s->triangle_count * sizeof *f.vertices * 2, m, "%zu triangles to draw need", s->triangle_count);
    for (int n = 0; n < 3; n++) mesh->middle_ws[n] = 0.5 * (b.min[n] + b.max[n]);
    mesh->size_metres = fmax(box_diagonal(&b), 1e-9);
    if (r != VXS_OK) return r;
    f.vertices       = malloc(3 * s->triangle_count * sizeof *f.vertices);
    f.mask_of        = calloc(s->triangle_count, sizeof *f.mask_of);
    f.uvs            = calloc(s->triangle_count, sizeof *f.uvs);
    mesh->first      = calloc(s->alpha_mask_count + 3, sizeof *mesh->first);
    mesh->masks      = calloc(s->alpha_mask_count + 1, sizeof *mesh->masks);
    mesh->thresholds = calloc(s->alpha_mask_count + 1, sizeof *mesh->thresholds);
    if (!f.vertices || !f.mask_of || !f.uvs || !mesh->first || !mesh->masks || !mesh->thresholds)
        r = fail(m, VXS_E_MEMORY, "out of memory for %zu triangles to draw", s->triangle_count);
    if (r == VXS_OK) {
        for (const holed_triangle *h = s->holed_triangles; h < s->holed_triangles + s->holed_triangle_count; h++) {
            f.mask_of[h->triangle] = 1 + h->mask;
            memcpy(f.uvs[h->triangle], h->uv, sizeof h->uv);
        }
        fill(&f);
        put_vertices(mesh, gl, f.vertices, 3 * s->triangle_count);
        for (size_t n = 0; n < mesh->mask_count; n++) {
            /* sampled as in baker/scene/scene.h, by OpenGL's filters */
            static const GLint wraps[] = {GL_REPEAT, GL_CLAMP_TO_EDGE, GL_MIRRORED_REPEAT};
            const alpha_mask  *mask    = &s->alpha_masks[n];
            const alpha_image *image   = &s->images[mask->image];
            GLint              filter  = mask->nearest ? GL_NEAREST : GL_LINEAR;
            gl->CreateTextures(GL_TEXTURE_2D, 1, &mesh->masks[n]);
            gl->TextureStorage2D(mesh->masks[n], 1, GL_R8, (GLsizei)image->width_px, (GLsizei)image->height_px);
            gl->PixelStorei(GL_UNPACK_ALIGNMENT, 1);
            gl->TextureSubImage2D(mesh->masks[n], 0, 0, 0, (GLsizei)image->width_px, (GLsizei)image->height_px, GL_RED,
                                  GL_UNSIGNED_BYTE, image->alpha);
            gl->PixelStorei(GL_UNPACK_ALIGNMENT, 4);
            gl->TextureParameteri(mesh->masks[n], GL_TEXTURE_MIN_FILTER, filter);
            gl->TextureParameteri(mesh->masks[n], GL_TEXTURE_MAG_FILTER, filter);
            gl->TextureParameteri(mesh->masks[n], GL_TEXTURE_WRAP_S, wraps[mask->wrap_u]);
            gl->TextureParameteri(mesh->masks[n], GL_TEXTURE_WRAP_T, wraps[mask->wrap_v]);
            mesh->thresholds[n] = mask->threshold;
        }
    }
    free(f.vertices);
    free(f.mask_of);
    free(f.uvs);
    return r;
}

void surface_mesh_draw(const surface_mesh *mesh, const gl_context *gl, GLuint program)
{
    GLint threshold = gl->GetUniformLocation(program, "threshold");
    gl->BindVertexArray(mesh->array);
    for (size_t n = 0; n < mesh->mask_count + 1; n++) {
        if (mesh->first[n] == mesh->first[n + 1]) continue;
        if (n) gl->BindTextureUnit(0, mesh->masks[n - 1]);
        gl->ProgramUniform1f(program, threshold, n ? mesh->thresholds[n - 1] : 0.0f);
        gl->DrawArrays(GL_TRIANGLES, (GLint)(3 * mesh->first[n]), (GLsizei)(3 * (mesh->first[n + 1] - mesh->first[n])));
    }
}

void surface_mesh_free(surface_mesh *mesh, const gl_context *gl)
{
    if (mesh->masks) gl->DeleteTextures((GLsizei)mesh->mask_count, mesh->masks);
    if (mesh->vertices) gl->DeleteBuffers(1, &mesh->vertices);
    if (mesh->array) gl->DeleteVertexArrays(1, &mesh->array);
    free(mesh->first);
    free(mesh->masks);
    free(mesh->thresholds);
    *mesh = (surface_mesh){0};
}
