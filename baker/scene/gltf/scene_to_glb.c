/* Convert a loaded scene to a glb_scene; see glb_write.h.
 *
 * Each mesh holds the triangles of one material. Meshes without a mask share the scene's vertices. Meshes with a mask have three
 * vertices per triangle, because texture coordinates belong to corners:
 *
 *     vertices   the scene's | 3 of each masked triangle
 *     triangles  one-sided | double-sided | mask 0, one-sided | mask 0, double-sided | mask 1, ...
 *
 * Capsules of smoke keep their order. Consecutive capsules form a run if all are points or all are lines, and have the same colour.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/scene/gltf/glb_write.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MATERIALS_WITHOUT_MASK = 2 };

typedef struct material_sort {
    size_t  count; /* number of materials: one-sided and double-sided, without a mask and with each mask */
    size_t *first; /* [count + 1] material i has triangles first[i] .. first[i + 1] - 1 */
    size_t *next;  /* [count] index for the next triangle of a material */
} material_sort;

/* Material number of a triangle. 0 is glTF's default material, which needs no entry; glb_mesh.material is 0 for it. */
static size_t material_of(const scene *s, size_t triangle, const holed_triangle *hole)
{
    size_t double_sided = (s->triangle_flags[triangle] & TRIANGLE_DOUBLE_SIDED) != 0;
    return double_sided + (hole ? MATERIALS_WITHOUT_MASK * (1 + (size_t)hole->mask) : 0);
}

/* The hole of triangle t, or NULL. *at is a cursor in holed_triangles; call with ascending t. */
static const holed_triangle *hole_of(const scene *s, size_t t, size_t *at)
{
    while (*at < s->holed_triangle_count && s->holed_triangles[*at].triangle < t) ++*at;
    return *at < s->holed_triangle_count && s->holed_triangles[*at].triangle == t ? &s->holed_triangles[*at] : NULL;
}

static void add_triangles(glb_scene *out, material_sort *k, const scene *s)
{
    for (size_t i = 0; i < 3 * s->vertex_count; i++) out->positions[i] = (float)(s->positions_ws[i] - out->origin_ws[i % 3]);
    for (size_t t = 0, at = 0; t < s->triangle_count; t++) {
        const holed_triangle *hole     = hole_of(s, t, &at);
        size_t                material = material_of(s, t, hole), place = k->next[material]++;
        const uint32_t       *corners = &s->indices[3 * t];
        for (size_t i = 0; i < 3 && !hole; i++) out->indices[3 * place + i] = corners[i];
        for (size_t i = 0; i < 3 && hole; i++) {
            size_t vertex = s->vertex_count + 3 * (place - k->first[MATERIALS_WITHOUT_MASK]) + i;
            memcpy(&out->positions[3 * vertex], &out->positions[3 * (size_t)corners[i]], 3 * sizeof *out->positions);
            memcpy(&out->texcoords[2 * vertex], hole->uv[i], 2 * sizeof *out->texcoords);
            out->indices[3 * place + i] = (uint32_t)(3 * (place - k->first[material]) + i);
        }
    }
}

static void add_materials(glb_scene *out, const scene *s)
{
    for (size_t i = 1; i < MATERIALS_WITHOUT_MASK * (1 + s->alpha_mask_count); i++) {
        glb_material material = {.name = "double-sided", .double_sided = i % MATERIALS_WITHOUT_MASK};
        if (i >= MATERIALS_WITHOUT_MASK) {
            const alpha_mask *mask = &s->alpha_masks[i / MATERIALS_WITHOUT_MASK - 1];
            material.name          = "mask";
            material.alpha_cutoff  = mask->threshold;
            material.image         = mask->image + 1;
            material.wrap_u        = mask->wrap_u;
            material.wrap_v        = mask->wrap_v;
            material.nearest       = mask->nearest;
        }
        out->materials[out->material_count++] = material;
    }
}

/* Add an image: white, with the mask's alpha. */
static int add_image(glb_scene *out, const alpha_image *image)
{
    size_t   pixels = (size_t)image->width_px * image->height_px;
    uint8_t *rgba   = malloc(4 * pixels);
    if (!rgba) return 0;
    memset(rgba, 0xff, 4 * pixels);
    for (size_t i = 0; i < pixels; i++) rgba[4 * i + 3] = image->alpha[i];
    out->images[out->image_count++] = (glb_image){image->width_px, image->height_px, rgba};
    return 1;
}

/* ---- smoke ---- */

static int is_line(const vxs_capsule *c)
{
    return memcmp(c->begin, c->end, sizeof c->begin) != 0;
}

/* 1 when capsule n starts a run. */
static int begins_run(const scene_smoke *smoke, uint32_t n)
{
    return !n || is_line(&smoke->list[n]) != is_line(&smoke->list[n - 1]) ||
           memcmp(smoke->albedos[n], smoke->albedos[n - 1], sizeof *smoke->albedos);
}

static void add_smoke_vertex(glb_scene *out, const scene_smoke *smoke, const float place[3], const vxs_capsule *c)
{
    glb_smoke_vertex *v = &out->smoke_vertices[out->smoke_vertex_count++];
    for (int k = 0; k < 3; k++) v->place[k] = (float)(smoke->origin_ws[k] - out->origin_ws[k] + (double)place[k]);
    v->radius_metres = c->radius_metres;
    v->extinction    = c->extinction;
    out->smoke[out->smoke_count - 1].vertex_count++;
}

static void add_smoke(glb_scene *out, const scene_smoke *smoke)
{
    for (uint32_t n = 0; n < smoke->count; n++) {
        const vxs_capsule *c = &smoke->list[n];
        if (begins_run(smoke, n)) {
            glb_smoke   *run      = &out->smoke[out->smoke_count++];
            glb_material material = {.name = "smoke"};
            for (int k = 0; k < 3; k++) material.colour[k] = (double)smoke->albedos[n][k];
            out->materials[out->material_count++] = material;
            *run                                  = (glb_smoke){.lines        = is_line(&smoke->list[n]),
                                                                .vertex_first = out->smoke_vertex_count,
                                                                .material     = (uint32_t)out->material_count};
            snprintf(run->name, sizeof run->name, "smoke %zu", out->smoke_count);
        }
        add_smoke_vertex(out, smoke, c->begin, c);
        if (is_line(c)) add_smoke_vertex(out, smoke, c->end, c);
    }
}

static uint32_t count_runs(const scene_smoke *smoke)
{
    uint32_t runs = 0;
    for (uint32_t n = 0; n < smoke->count; n++) runs += (uint32_t)begins_run(smoke, n);
    return runs;
}

/* ---- room ---- */

/* Allocate everything whose count is known; other arrays grow item by item. */
static int reserve(glb_scene *out, material_sort *k, const scene *s)
{
    uint32_t runs       = count_runs(&s->smoke);
    k->count            = MATERIALS_WITHOUT_MASK * (1 + s->alpha_mask_count);
    k->first            = calloc(k->count + 1, sizeof *k->first);
    k->next             = calloc(k->count, sizeof *k->next);
    out->vertex_count   = s->vertex_count + 3 * s->holed_triangle_count;
    out->triangle_count = s->triangle_count;
    out->positions      = malloc((3 * out->vertex_count + 1) * sizeof *out->positions);
    out->indices        = malloc((3 * out->triangle_count + 1) * sizeof *out->indices);
    out->meshes         = calloc(k->count, sizeof *out->meshes);
    out->materials      = calloc(k->count + runs, sizeof *out->materials);
    out->images         = calloc(s->image_count + 1, sizeof *out->images);
    out->lights         = calloc(s->light_count + 1, sizeof *out->lights);
    out->smoke          = calloc(runs + 1, sizeof *out->smoke);
    out->smoke_vertices = malloc((2 * (size_t)s->smoke.count + 1) * sizeof *out->smoke_vertices);
    if (s->holed_triangle_count && !(out->texcoords = calloc(out->vertex_count, 2 * sizeof *out->texcoords))) return 0;
    out->camera_positions_ws = malloc((3 * s->camera_count + 1) * sizeof *out->camera_positions_ws);
    return k->first && k->next && out->positions && out->indices && out->meshes && out->materials && out->images && out->lights &&
           out->smoke && out->smoke_vertices && out->camera_positions_ws;
}

/* ---- the origin ---- */

static double farthest_of(const scene *s, const double from[3])
{
    double far = 0;
    for (size_t i = 0; i < 3 * s->vertex_count; i++) far = fmax(far, fabs(s->positions_ws[i] - from[i % 3]));
    return far;
}

/* Maximum rounding error of a coordinate, metres. */
static double rounding_of(const scene *s, const double from[3])
{
    double moved = 0;
    for (size_t i = 0; i < 3 * s->vertex_count; i++) {
        double at = s->positions_ws[i], origin = from[i % 3];
        moved = fmax(moved, fabs(origin + (double)(float)(at - origin) - at));
    }
    return moved;
}

static const double FAR_TIMES = 8, MOVED_MAX_METRES = 1e-3;

void glb_find_origin(const scene *s, double origin_ws[3])
{
    static const double zero[3] = {0, 0, 0};
    double              low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY}, half = 0;

    /* origin of the longest run of triangles; the first of equally long ones */
    const double *usual = s->origin_count ? s->origins[0].at_ws : NULL;
    for (size_t n = 0, most = 0; n < s->origin_count; n++) {
        size_t end = n + 1 < s->origin_count ? s->origins[n + 1].triangle_first : s->triangle_count;
        size_t own = end - s->origins[n].triangle_first;
        if (own <= most) continue;
        most  = own;
        usual = s->origins[n].at_ws;
    }
    for (size_t i = 0; i < 3 * s->vertex_count; i++) {
        low[i % 3]  = fmin(low[i % 3], s->positions_ws[i]);
        high[i % 3] = fmax(high[i % 3], s->positions_ws[i]);
    }
    for (int axis = 0; axis < 3; axis++) half = fmax(half, 0.5 * (high[axis] - low[axis]));
    memcpy(origin_ws, zero, sizeof zero);
    double far = farthest_of(s, zero);
    if (!(far > FAR_TIMES * half) || !isfinite(far)) return;
    double grid = half > 0 ? ldexp(1, ilogb(half) - 4) : 1; /* few digits, and close to the centre */
    for (int axis = 0; axis < 3; axis++) origin_ws[axis] = rint(0.5 * (low[axis] + high[axis]) / grid) * grid;
    if (usual && rounding_of(s, usual) <= rounding_of(s, origin_ws)) memcpy(origin_ws, usual, sizeof zero);
}

vxs_result glb_round_positions(scene *s, const double origin_ws[3], run_context *m)
{
    double moved = rounding_of(s, origin_ws);
    for (size_t i = 0; i < 3 * s->vertex_count; i++) {
        double from = origin_ws[i % 3], rounded = (float)(s->positions_ws[i] - from);
        if (isfinite(s->positions_ws[i]) && !isfinite(rounded))
            return fail(m, VXS_E_SCENE, "a vertex has the coordinate %g: expected one that fits into a float", s->positions_ws[i]);
        s->positions_ws[i] = from + rounded;
    }
    if (moved > MOVED_MAX_METRES)
        warn(m,
             "positions become floats, and vertices move by up to %.2g m, as the scene is %.3g m wide; mend what lies far apart by "
             "itself, with --include",
             moved, farthest_of(s, origin_ws));
    return run_check(m);
}

/* ---- all of it ---- */

vxs_result glb_from_scene(glb_scene *out, const scene *s, const double origin_ws[3], run_context *m)
{
    material_sort k  = {0};
    int           ok = 1;
    vxs_result    r  = VXS_OK;

    *out = (glb_scene){.name = s->name, .origin_ws = {origin_ws[0], origin_ws[1], origin_ws[2]}};
    ok   = reserve(out, &k, s);
    for (size_t i = 0; ok && i < s->image_count; i++) ok = add_image(out, &s->images[i]);
    for (size_t i = 0; ok && i < s->light_count; i++) {
        /* white with intensity 1 is glTF's default: it is stored as 0, and not written; a dark light stays dark */
        scene_light   copy = {.name = strdup(s->lights[i].name), .shape = s->lights[i].shape, .dark = s->lights[i].dark};
        const double *c    = s->lights[i].colour;
        if (c[0] != 1 || c[1] != 1 || c[2] != 1) memcpy(copy.colour, c, sizeof copy.colour);
        if (copy.name) out->lights[out->light_count++] = copy;
        ok = copy.name != NULL;
    }
    if (!ok) {
        r = fail(m, VXS_E_MEMORY, "out of memory for writing %zu triangles", s->triangle_count);
        goto done;
    }
    for (size_t t = 0, at = 0; t < s->triangle_count; t++) k.first[material_of(s, t, hole_of(s, t, &at)) + 1]++;
    for (size_t i = 0; i < k.count; i++) k.first[i + 1] += k.first[i];
    memcpy(k.next, k.first, k.count * sizeof *k.next);
    for (size_t i = 0; i < k.count; i++) {
        glb_mesh mesh = {.material = (uint32_t)i, .triangle_first = k.first[i], .triangle_count = k.first[i + 1] - k.first[i]};
        if (!mesh.triangle_count) continue;
        if (i < MATERIALS_WITHOUT_MASK) {
            mesh.vertex_count = s->vertex_count;
        } else {
            mesh.vertex_first = s->vertex_count + 3 * (mesh.triangle_first - k.first[MATERIALS_WITHOUT_MASK]);
            mesh.vertex_count = 3 * mesh.triangle_count;
        }
        snprintf(mesh.name, sizeof mesh.name, "material %zu", i);
        out->meshes[out->mesh_count++] = mesh;
    }
    add_triangles(out, &k, s);
    add_materials(out, s);
    add_smoke(out, &s->smoke);
    if (s->camera_count)
        memcpy(out->camera_positions_ws, s->camera_positions_ws, 3 * s->camera_count * sizeof *s->camera_positions_ws);
    out->camera_count = s->camera_count;
done:
    free(k.first);
    free(k.next);
    if (r != VXS_OK) glb_scene_free(out);
    return r;
}
