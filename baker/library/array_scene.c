/* Scenes from arrays; see array_scene.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/library/array_scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/memory.h"
#include "baker/base/portable_math.h"
#include "baker/base/run_control.h"
#include "baker/base/vec3.h"
#include "baker/scene/light_choice.h"
#include "formats/vxs_format.h"

static const size_t TRIANGLES_MAX = (size_t)1 << 26; /* the same limit as for files */

enum { BETWEEN_PASSES = 4096 };

/* Sums over all meshes. */
typedef struct array_counts {
    size_t vertices, triangles;
} array_counts;

static int are_finite(const double v[3])
{
    return isfinite(v[0]) && isfinite(v[1]) && isfinite(v[2]);
}

static vxs_result count_all(array_counts *all, const vxs_bake_arrays *a, run_context *m)
{
    if (!a->meshes || !a->mesh_count) return fail(m, VXS_E_ARGUMENT, "arrays: expected a mesh");
    if (!a->lights && a->light_count) return fail(m, VXS_E_ARGUMENT, "arrays: %zu lights, and no array of them", a->light_count);
    if (!a->viewpoints_ws && a->viewpoint_count)
        return fail(m, VXS_E_ARGUMENT, "arrays: %zu viewpoints, and no array of them", a->viewpoint_count);
    for (size_t n = 0; n < a->mesh_count; n++) {
        const vxs_bake_mesh *mesh = &a->meshes[n];
        if (!mesh->positions && mesh->vertex_count) return fail(m, VXS_E_ARGUMENT, "arrays: mesh %zu has no positions", n);
        if (!mesh->indices && (uint64_t)mesh->triangle_count * 3 > mesh->vertex_count)
            return fail(m, VXS_E_ARGUMENT, "arrays: mesh %zu has no indices, and %u vertices for %u triangles", n,
                        mesh->vertex_count, mesh->triangle_count);
        if (!are_finite(mesh->origin_ws)) return fail(m, VXS_E_ARGUMENT, "arrays: mesh %zu: its origin is not finite", n);
        all->vertices += mesh->vertex_count;
        all->triangles += mesh->triangle_count;
        if (all->triangles > TRIANGLES_MAX || all->vertices > 3 * TRIANGLES_MAX)
            return fail(m, VXS_E_ARGUMENT, "arrays: more than %zu triangles, or three times as many vertices", TRIANGLES_MAX);
    }
    uint64_t bytes = 24 * (uint64_t)all->vertices + 13 * (uint64_t)all->triangles;
    return memory_check(bytes, m, "arrays of %zu triangles: the scene needs", all->triangles);
}

static vxs_result take_memory(scene *s, const array_counts *all, const vxs_bake_arrays *a, run_context *m)
{
    s->name                = strdup("");
    s->positions_ws        = malloc((all->vertices + 1) * 3 * sizeof *s->positions_ws);
    s->indices             = malloc((all->triangles + 1) * 3 * sizeof *s->indices);
    s->triangle_flags      = malloc(all->triangles + 1);
    s->origins             = calloc(a->mesh_count, sizeof *s->origins);
    s->lights              = calloc(a->light_count + 1, sizeof *s->lights);
    s->camera_positions_ws = calloc(a->viewpoint_count + 1, 3 * sizeof *s->camera_positions_ws);
    if (s->name && s->positions_ws && s->indices && s->triangle_flags && s->origins && s->lights && s->camera_positions_ws)
        return VXS_OK;
    return fail(m, VXS_E_MEMORY, "out of memory for arrays of %zu triangles", all->triangles);
}

static vxs_result add_mesh(scene *s, const vxs_bake_mesh *mesh, size_t number, run_context *m)
{
    uint32_t first = (uint32_t)s->vertex_count;
    s->origins[s->origin_count++] =
        (scene_origin){(uint32_t)s->triangle_count, {mesh->origin_ws[0], mesh->origin_ws[1], mesh->origin_ws[2]}};
    for (size_t n = 0; n < 3 * (size_t)mesh->vertex_count; n++) {
        if (n % BETWEEN_PASSES == 0) run_control_wait();
        if (!isfinite(mesh->positions[n]))
            return fail(m, VXS_E_ARGUMENT, "arrays: mesh %zu: vertex %zu is not finite", number, n / 3);
        s->positions_ws[3 * s->vertex_count + n] = mesh->origin_ws[n % 3] + mesh->positions[n];
    }
    for (size_t n = 0; n < 3 * (size_t)mesh->triangle_count; n++) {
        uint32_t index = mesh->indices ? mesh->indices[n] : (uint32_t)n;
        if (n % BETWEEN_PASSES == 0) run_control_wait();
        if (index >= mesh->vertex_count)
            return fail(m, VXS_E_ARGUMENT, "arrays: mesh %zu: index %zu is %u, and there are %u vertices", number, n, index,
                        mesh->vertex_count);
        s->indices[3 * s->triangle_count + n] = first + index;
    }
    memset(s->triangle_flags + s->triangle_count, mesh->double_sided ? TRIANGLE_DOUBLE_SIDED : 0, mesh->triangle_count);
    s->vertex_count += mesh->vertex_count;
    s->triangle_count += mesh->triangle_count;
    return VXS_OK;
}

/* Convert a light, with the fields that its kind uses. Returns NULL, or an error text. */
static const char *shape_of(light_shape *out, const vxs_bake_light *l)
{
    static const light_kind kinds[] = {LIGHT_DIRECTIONAL, LIGHT_SPOT, LIGHT_POINT};
    *out                            = (light_shape){.range_metres = INFINITY};
    if ((unsigned)l->kind > VXS_BAKE_POINT) return "its kind is none";
    out->kind = kinds[l->kind];
    if (out->kind != LIGHT_POINT && (!are_finite(l->direction_ws) || !vec3_unit(l->direction_ws, out->direction_ws)))
        return "expected a direction, finite and not zero";
    if (out->kind == LIGHT_DIRECTIONAL) return NULL;
    if (!are_finite(l->position_ws)) return "expected a position that is finite";
    memcpy(out->position_ws, l->position_ws, sizeof out->position_ws);
    if (!(l->range_metres >= 0)) return "expected a range of more than 0 metres, or 0 for one without end";
    if (l->range_metres > 0) out->range_metres = l->range_metres;
    if (out->kind == LIGHT_POINT) return NULL;
    out->outer_rad = portable_acos(l->cos_outer);
    return l->cos_outer > 0 && l->cos_outer < 1 ? NULL : "expected cos_outer, of its cone, of more than 0 and less than 1";
}

static vxs_result add_light(scene *s, const vxs_bake_light *l, size_t number, run_context *m)
{
    scene_light *light = &s->lights[s->light_count];
    if (!l->name || !light_name_is_sound(l->name))
        return fail(m, VXS_E_ARGUMENT, "arrays: light %zu: expected a name of 1 to %d bytes in UTF-8", number,
                    VXS_LIGHT_NAME_BYTES - 1);
    for (size_t n = 0; n < s->light_count; n++)
        if (!strcmp(s->lights[n].name, l->name)) return fail(m, VXS_E_ARGUMENT, "arrays: two lights are named '%s'", l->name);
    const char *wrong = shape_of(&light->shape, l);
    if (wrong) return fail(m, VXS_E_ARGUMENT, "arrays: light '%s': %s", l->name, wrong);
    light->name = strdup(l->name);
    if (!light->name) return fail(m, VXS_E_MEMORY, "out of memory for light '%s'", l->name);
    s->light_count++;
    return VXS_OK;
}

vxs_result scene_from_arrays(scene *s, const vxs_bake_arrays *arrays, run_context *m)
{
    const vxs_bake_arrays *a   = arrays;
    array_counts           all = {0, 0};
    *s                         = (scene){0};
    vxs_result r               = count_all(&all, a, m);
    if (r == VXS_OK) r = take_memory(s, &all, a, m);
    for (size_t n = 0; n < a->mesh_count && r == VXS_OK; n++) r = add_mesh(s, &a->meshes[n], n, m);
    for (size_t n = 0; n < a->light_count && r == VXS_OK; n++) r = add_light(s, &a->lights[n], n, m);
    for (size_t n = 0; n < a->viewpoint_count && r == VXS_OK; n++) {
        const double *at_ws = a->viewpoints_ws + 3 * n;
        if (!are_finite(at_ws)) r = fail(m, VXS_E_ARGUMENT, "arrays: viewpoint %zu is not finite", n);
        memcpy(s->camera_positions_ws + 3 * s->camera_count++, at_ws, 3 * sizeof *at_ws);
    }
    if (r != VXS_OK) scene_free(s);
    return r;
}
