/* Building blocks of generators; see generate_parts.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "scenes/generate_parts.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/array.h"

/* ---- a scene that grows ---- */

/* Make room for one more item in *list. Returns 0 when out of memory, now or before. */
static int reserve(parts *p, void *list, size_t *capacity, size_t count, size_t item_bytes)
{
    if (!p->out_of_memory && !array_reserve(list, capacity, count + 1, item_bytes)) p->out_of_memory = 1;
    return !p->out_of_memory;
}

/* Texture coordinates for `count` vertices; (0, 0) for those without. */
static int reserve_texcoords(parts *p, size_t count)
{
    glb_scene *s    = p->s;
    size_t     have = p->texcoords;
    if (!count || !reserve(p, &s->texcoords, &p->texcoords, count - 1, 2 * sizeof *s->texcoords)) return 0;
    memset(s->texcoords + 2 * have, 0, 2 * (p->texcoords - have) * sizeof *s->texcoords);
    return 1;
}

parts parts_begin(glb_scene *s, const char *name)
{
    *s = (glb_scene){.name = name};
    return (parts){.s = s};
}

parts parts_continue(glb_scene *s)
{
    return (parts){.s              = s,
                   .vertices       = s->vertex_count,
                   .texcoords      = s->texcoords ? s->vertex_count : 0,
                   .triangles      = s->triangle_count,
                   .meshes         = s->mesh_count,
                   .materials      = s->material_count,
                   .images         = s->image_count,
                   .lights         = s->light_count,
                   .smoke          = s->smoke_count,
                   .smoke_vertices = s->smoke_vertex_count};
}

/* Remove the last mesh if it is empty. */
static void drop_empty_mesh(glb_scene *s)
{
    if (s->mesh_count && !s->meshes[s->mesh_count - 1].triangle_count) s->mesh_count--;
}

vxs_result parts_end(parts *p, run_context *m)
{
    glb_scene *s = p->s;
    if (s->texcoords) reserve_texcoords(p, s->vertex_count);
    if (p->out_of_memory) {
        glb_scene_free(s);
        return fail(m, VXS_E_MEMORY, "out of memory for a scene of more than %zu triangles", p->triangles);
    }
    drop_empty_mesh(s);
    return VXS_OK;
}

void parts_mesh(parts *p, const char *name, uint32_t material)
{
    glb_scene *s = p->s;
    drop_empty_mesh(s);
    if (!reserve(p, &s->meshes, &p->meshes, s->mesh_count, sizeof *s->meshes)) return;
    glb_mesh *mesh = &s->meshes[s->mesh_count++];
    *mesh          = (glb_mesh){.vertex_first = s->vertex_count, .triangle_first = s->triangle_count, .material = material};
    snprintf(mesh->name, sizeof mesh->name, "%s", name);
}

void parts_smoke(parts *p, const char *name, int lines, uint32_t material)
{
    glb_scene *s = p->s;
    if (!reserve(p, &s->smoke, &p->smoke, s->smoke_count, sizeof *s->smoke)) return;
    glb_smoke *run = &s->smoke[s->smoke_count++];
    *run           = (glb_smoke){.lines = lines, .vertex_first = s->smoke_vertex_count, .material = material};
    snprintf(run->name, sizeof run->name, "%s", name);
}

void parts_smoke_vertex(parts *p, const double place[3], double radius_metres, double extinction)
{
    glb_scene *s = p->s;
    if (!reserve(p, &s->smoke_vertices, &p->smoke_vertices, s->smoke_vertex_count, sizeof *s->smoke_vertices)) return;
    s->smoke_vertices[s->smoke_vertex_count++] =
        (glb_smoke_vertex){{(float)place[0], (float)place[1], (float)place[2]}, (float)radius_metres, (float)extinction};
    s->smoke[s->smoke_count - 1].vertex_count++;
}

uint32_t parts_material(parts *p, glb_material material)
{
    glb_scene *s = p->s;
    if (!reserve(p, &s->materials, &p->materials, s->material_count, sizeof *s->materials)) return 0;
    s->materials[s->material_count++] = material;
    return (uint32_t)s->material_count;
}

uint32_t parts_image(parts *p, uint32_t width_px, uint32_t height_px, uint8_t *rgba)
{
    glb_scene *s = p->s;
    if (!rgba) p->out_of_memory = 1;
    if (!reserve(p, &s->images, &p->images, s->image_count, sizeof *s->images)) {
        free(rgba);
        return 0;
    }
    s->images[s->image_count++] = (glb_image){width_px, height_px, rgba};
    return (uint32_t)s->image_count;
}

uint32_t parts_vertex(parts *p, double x, double y, double z)
{
    glb_scene *s = p->s;
    if (!reserve(p, &s->positions, &p->vertices, s->vertex_count, 3 * sizeof *s->positions)) return 0;
    float *position = s->positions + 3 * s->vertex_count++;
    position[0]     = (float)x;
    position[1]     = (float)y;
    position[2]     = (float)z;
    return (uint32_t)s->meshes[s->mesh_count - 1].vertex_count++;
}

uint32_t parts_vertex_uv(parts *p, const double position[3], double u, double v)
{
    glb_scene *s = p->s;
    if (!reserve_texcoords(p, s->vertex_count + 1)) return 0;
    s->texcoords[2 * s->vertex_count]     = (float)u;
    s->texcoords[2 * s->vertex_count + 1] = (float)v;
    return parts_vertex(p, position[0], position[1], position[2]);
}

void parts_triangle(parts *p, uint32_t a, uint32_t b, uint32_t c)
{
    glb_scene *s = p->s;
    if (!reserve(p, &s->indices, &p->triangles, s->triangle_count, 3 * sizeof *s->indices)) return;
    uint32_t *corner = s->indices + 3 * s->triangle_count++;
    corner[0]        = a;
    corner[1]        = b;
    corner[2]        = c;
    s->meshes[s->mesh_count - 1].triangle_count++;
}

/* ---- circles ---- */

void parts_turn(uint32_t k, uint32_t n, double *cosine, double *sine)
{
    uint32_t quarter = n / 4;
    double   t = (double)(k % quarter) / quarter, c = (1 - t * t) / (1 + t * t), s = 2 * t / (1 + t * t);
    switch (k / quarter) {
    case 0: *cosine = c, *sine = s; break;
    case 1: *cosine = -s, *sine = c; break;
    case 2: *cosine = -c, *sine = -s; break;
    default: *cosine = s, *sine = -c;
    }
}

/* ---- shapes ---- */

void parts_box_triangles(parts *p, uint32_t first)
{
    static const uint8_t faces[12][3] = {{0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}, {0, 1, 5}, {0, 5, 4},
                                         {2, 6, 7}, {2, 7, 3}, {0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}};
    for (int t = 0; t < 12; t++) parts_triangle(p, first + faces[t][0], first + faces[t][1], first + faces[t][2]);
}

void parts_box(parts *p, parts_frame f, const double low[3], const double high[3])
{
    uint32_t last = 0;
    for (int c = 0; c < 8; c++) {
        double x = c & 1 ? high[0] : low[0], y = c & 2 ? high[1] : low[1], z = c & 4 ? high[2] : low[2];
        last = parts_vertex(p, f.at[0] + (f.cosine * x + f.sine * z), f.at[1] + y, f.at[2] + (f.cosine * z - f.sine * x));
    }
    parts_box_triangles(p, last - 7);
}

void parts_box_at(parts *p, const char *mesh, double x0, double x1, double y0, double y1, double z0, double z1)
{
    if (mesh) parts_mesh(p, mesh, 0);
    parts_box(p, parts_upright, (double[3]){x0, y0, z0}, (double[3]){x1, y1, z1});
}

void parts_quad(parts *p, const double a[3], const double b[3], const double c[3], const double d[3])
{
    const double *corners[4] = {a, b, c, d};
    uint32_t      v[4];
    for (int i = 0; i < 4; i++) v[i] = parts_vertex(p, corners[i][0], corners[i][1], corners[i][2]);
    parts_triangle(p, v[0], v[1], v[2]);
    parts_triangle(p, v[0], v[2], v[3]);
}

void parts_grid(parts *p, const double corner[3], const double u[3], const double v[3], uint32_t columns, uint32_t rows)
{
    uint32_t last = 0;
    for (uint32_t j = 0; j <= rows; j++)
        for (uint32_t i = 0; i <= columns; i++) {
            double s = (double)i / columns, t = (double)j / rows, at[3];
            for (int k = 0; k < 3; k++) at[k] = corner[k] + (s * u[k] + t * v[k]);
            last = parts_vertex(p, at[0], at[1], at[2]);
        }
    uint32_t first = last + 1 - (columns + 1) * (rows + 1);
    for (uint32_t j = 0; j < rows; j++)
        for (uint32_t i = 0; i < columns; i++) {
            uint32_t a = first + j * (columns + 1) + i, b = a + columns + 1;
            parts_triangle(p, a, a + 1, b + 1);
            parts_triangle(p, a, b + 1, b);
        }
}

/* A ring of a lathe: one vertex, or `segments` of them. Returns the first. */
static uint32_t ring(parts *p, const double at[3], const double point[2], uint32_t segments)
{
    uint32_t count = point[0] == 0 ? 1 : segments, last = 0;
    for (uint32_t k = 0; k < count; k++) {
        double c, s;
        parts_turn(k, segments, &c, &s);
        last = parts_vertex(p, at[0] + point[0] * c, at[1] + point[1], at[2] + point[0] * s);
    }
    return last + 1 - count;
}

/* The quad of segment k between two rings. From +X towards +Z is clockwise seen from above: it faces outward. */
static void ring_quad(parts *p, uint32_t upper, uint32_t lower, uint32_t k, uint32_t segments)
{
    uint32_t next = (k + 1) % segments;
    parts_triangle(p, upper + k, upper + next, lower + next);
    parts_triangle(p, upper + k, lower + next, lower + k);
}

void parts_lathe(parts *p, const double at[3], const double (*profile)[2], uint32_t count, uint32_t segments)
{
    uint32_t upper = ring(p, at, profile[0], segments);
    for (uint32_t r = 1; r < count; r++) {
        uint32_t lower    = ring(p, at, profile[r], segments);
        int      is_point = profile[r][0] == 0, was_point = profile[r - 1][0] == 0;
        for (uint32_t k = 0; k < segments; k++) {
            uint32_t next = (k + 1) % segments;
            if (was_point)
                parts_triangle(p, upper, lower + next, lower + k);
            else if (is_point)
                parts_triangle(p, upper + k, upper + next, lower);
            else
                ring_quad(p, upper, lower, k, segments);
        }
        upper = lower;
    }
}

void parts_tube(parts *p, const double bottom[3], double bottom_radius, const double top[3], double top_radius, uint32_t sides)
{
    uint32_t upper = ring(p, top, (double[2]){top_radius, 0}, sides), lower = ring(p, bottom, (double[2]){bottom_radius, 0}, sides);
    for (uint32_t k = 0; k < sides; k++) ring_quad(p, upper, lower, k, sides);
    for (uint32_t k = 1; k + 1 < sides; k++) {
        parts_triangle(p, upper, upper + k + 1, upper + k);
        parts_triangle(p, lower, lower + k, lower + k + 1);
    }
}

/* ---- lights ---- */

void parts_light(parts *p, const char *name, light_shape shape)
{
    glb_scene *s = p->s;
    if (!reserve(p, &s->lights, &p->lights, s->light_count, sizeof *s->lights)) return;
    char *copy = strdup(name);
    if (copy)
        s->lights[s->light_count++] = (scene_light){.name = copy, .shape = shape};
    else
        p->out_of_memory = 1;
}

void parts_spot(parts *p, const char *name, const double at[3], const double direction[3], int degrees, double range_metres)
{
    parts_light(p, name,
                (light_shape){LIGHT_SPOT,
                              {at[0], at[1], at[2]},
                              {direction[0], direction[1], direction[2]},
                              degrees * (3.14159265358979323846 / 180),
                              range_metres});
}

void parts_point(parts *p, const char *name, const double at[3], double range_metres)
{
    parts_light(p, name, (light_shape){.kind = LIGHT_POINT, .position_ws = {at[0], at[1], at[2]}, .range_metres = range_metres});
}

void parts_sun(parts *p, const double direction[3])
{
    parts_light(p, "sun", (light_shape){LIGHT_DIRECTIONAL, {0}, {direction[0], direction[1], direction[2]}, 0, INFINITY});
}
