/* Projecting casters into a map; see projection.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/light/projection.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/parallel.h"
#include "baker/light/map_space.h"

#define NONE UINT32_MAX

typedef struct projector {
    projection      *p;
    const vxs_light *light;
    int              map;
    double           side_px;
    map_corner      *corners; /* [casters->vertex_count] in map space */
    map_sides        touch, keep;
    uint32_t        *slot; /* [casters->vertex_count] its vertex in the projection, or NONE */
    size_t           vertex_capacity, triangle_capacity, uvq_capacity, meets_capacity;
    uint8_t          meets; /* what is true of the caster in work */
    int              leaves_bounds[PARALLEL_THREADS_MAX];
} projector;

static vertex_ls project(const projector *j, const double at[3])
{
    if (!j->p->reversed) return (vertex_ls){at[0], at[1], at[2]};
    double per_px = at[2] * j->light->texel_metres;
    return (vertex_ls){0.5 * j->side_px + at[0] / per_px, 0.5 * j->side_px + at[1] / per_px, j->light->near_metres / at[2]};
}

static void transform_vertices(void *user, size_t begin, size_t end, uint32_t worker)
{
    projector *j    = user;
    double     side = j->side_px;
    for (size_t n = begin; n < end; n++) {
        double *at = j->corners[n].at;
        map_space_from_ws(j->light, j->map, j->p->casters->positions_ws + 3 * n, at);
        if (!(at[0] >= -side && at[0] <= 2 * side && at[1] >= -side && at[1] <= 2 * side)) j->leaves_bounds[worker] = 1;
    }
}

/* arrays that grow ------------------------------------------------------------------------------------------------------------ */

static int grow(void **array, size_t *capacity, size_t needed, size_t size)
{
    if (needed <= *capacity) return 1;
    size_t more  = *capacity ? *capacity * 2 : 1024;
    void  *grown = more < needed || more > SIZE_MAX / size ? NULL : realloc(*array, more * size);
    if (!grown) return 0;
    *array    = grown;
    *capacity = more;
    return 1;
}

/* The index of a new vertex, or NONE. */
static uint32_t add_vertex(projector *j, const double at[3])
{
    projection *p = j->p;
    if (p->vertex_count == NONE || !grow((void **)&p->vertices, &j->vertex_capacity, p->vertex_count + 1, sizeof *p->vertices))
        return NONE;
    p->vertices[p->vertex_count] = project(j, at);
    return (uint32_t)p->vertex_count++;
}

/* The places of the triangle that is added next in its mask's image. */
static int add_uvq(projector *j, const map_corner *const corners[3])
{
    projection *p     = j->p;
    size_t      count = p->triangle_count - p->masked_first;
    if (!grow((void **)&p->uvq, &j->uvq_capacity, count + 1, sizeof *p->uvq)) return 0;
    for (int n = 0; n < 3; n++) {
        double q         = p->reversed ? project(j, corners[n]->at).z : 1;
        p->uvq[count][n] = (mask_uvq){(float)(corners[n]->uv[0] * q), (float)(corners[n]->uv[1] * q), (float)q};
    }
    return 1;
}

static int add_triangle(projector *j, const uint32_t corners[3])
{
    projection *p = j->p;
    if (!grow((void **)&p->own_indices, &j->triangle_capacity, p->triangle_count + 1, 3 * sizeof *p->own_indices)) return 0;
    if (!grow((void **)&p->own_meets, &j->meets_capacity, p->triangle_count + 1, sizeof *p->own_meets)) return 0;
    p->own_meets[p->triangle_count] = j->meets;
    memcpy(p->own_indices + 3 * p->triangle_count++, corners, 3 * sizeof *corners);
    return 1;
}

static int add_whole(projector *j, const uint32_t *caster, const map_polygon *triangle, int masked)
{
    uint32_t corners[3];
    for (int n = 0; n < 3; n++) {
        uint32_t *slot = &j->slot[caster[n]];
        if (*slot == NONE && (*slot = add_vertex(j, j->corners[caster[n]].at)) == NONE) return 0;
        corners[n] = *slot;
    }
    const map_corner *const of[3] = {&triangle->corners[0], &triangle->corners[1], &triangle->corners[2]};
    return (!masked || add_uvq(j, of)) && add_triangle(j, corners);
}

/* A convex polygon as triangles around its first corner. */
static int add_polygon(projector *j, const map_polygon *polygon, int masked)
{
    uint32_t corners[3];
    for (int n = 0; n < polygon->count; n++) {
        uint32_t vertex = add_vertex(j, polygon->corners[n].at);
        if (vertex == NONE) return 0;
        if (n < 2) {
            corners[n] = vertex;
            continue;
        }
        const map_corner *const of[3] = {&polygon->corners[0], &polygon->corners[n - 1], &polygon->corners[n]};
        corners[2]                    = vertex;
        if ((masked && !add_uvq(j, of)) || !add_triangle(j, corners)) return 0;
        corners[1] = vertex;
    }
    return 1;
}

static int add_caster(projector *j, size_t n)
{
    const casters  *c        = j->p->casters;
    const uint32_t *caster   = c->indices + 3 * n;
    map_polygon     triangle = {.count = 3}, kept;
    j->meets                 = n < c->solid_triangle_count && (!c->solid_meets || c->solid_meets[n]);
    int masked               = c->mask_count && n >= c->masked_first;
    for (int k = 0; k < 3; k++) triangle.corners[k] = j->corners[caster[k]];
    for (int k = 0; k < 6 && masked; k++)
        triangle.corners[k / 2].uv[k % 2] = (double)c->mask_uvs[6 * (n - c->masked_first) + (size_t)k];
    if (!map_sides_touch(&j->touch, &triangle) || map_space_behind(j->light, j->map, &triangle)) return 1;
    if (!map_sides_clip(&j->keep, &triangle, &kept)) return add_whole(j, caster, &triangle, masked);
    return kept.count < 3 || add_polygon(j, &kept, masked);
}

/* the casters ----------------------------------------------------------------------------------------------------------------- */

/* Where triangles with holes begin. */
static size_t opaque_end(const casters *c)
{
    return c->mask_count ? c->masked_first : c->triangle_count;
}

/* Casters [first, end), in order. */
static int add_run(projector *j, size_t first, size_t end)
{
    for (size_t n = first; n < end; n++)
        if (!add_caster(j, n)) return 0;
    return 1;
}

static int add_casters(projector *j)
{
    projection    *p = j->p;
    const casters *c = p->casters;
    j->touch         = map_sides_of(j->light, 1);
    j->keep          = map_sides_of(j->light, j->side_px);
    j->slot          = malloc((c->vertex_count + 1) * sizeof *j->slot);
    if (!j->slot) return 0;
    memset(j->slot, 0xff, c->vertex_count * sizeof *j->slot);

    if (!add_run(j, 0, c->solid_triangle_count)) return 0;
    p->solid_triangle_count = p->triangle_count;
    if (!add_run(j, c->solid_triangle_count, opaque_end(c))) return 0;
    p->masked_first = p->triangle_count;
    for (size_t mask = 0; mask < c->mask_count; mask++) {
        p->mask_first[mask] = p->triangle_count;
        if (!add_run(j, c->mask_first[mask], c->mask_first[mask + 1])) return 0;
    }
    p->mask_first[c->mask_count] = p->triangle_count;
    p->indices                   = p->own_indices;
    p->meets                     = p->own_meets;
    return 1;
}

/* All vertices are in bounds: the casters' own triangles serve. */
static int take_casters(projector *j)
{
    projection    *p = j->p;
    const casters *c = p->casters;
    p->vertices      = malloc((c->vertex_count + 1) * sizeof *p->vertices);
    if (!p->vertices) return 0;
    for (size_t n = 0; n < c->vertex_count; n++) p->vertices[n] = project(j, j->corners[n].at);
    p->vertex_count         = c->vertex_count;
    p->triangle_count       = c->triangle_count;
    p->solid_triangle_count = c->solid_triangle_count;
    p->masked_first         = opaque_end(c);
    p->indices              = c->indices;
    p->meets                = c->solid_meets;
    for (size_t mask = 0; mask <= c->mask_count; mask++)
        p->mask_first[mask] = c->mask_count ? c->mask_first[mask] : c->triangle_count;

    size_t masked = c->triangle_count - p->masked_first;
    p->uvq        = malloc((masked + 1) * sizeof *p->uvq);
    if (!p->uvq) return 0;
    for (size_t n = 0; n < 3 * masked; n++) p->uvq[n / 3][n % 3] = (mask_uvq){c->mask_uvs[2 * n], c->mask_uvs[2 * n + 1], 1};
    return 1;
}

vxs_result projection_init(projection *p, const casters *c, const vxs_light *light, int map, uint32_t threads, message *m)
{
    *p          = (projection){.casters = c, .reversed = light->kind != VXS_LIGHT_KIND_DIRECTIONAL};
    projector j = {.p = p, .light = light, .map = map, .side_px = ldexp(1, (int)light->levels)};
    int       ok;
    j.corners     = malloc((c->vertex_count + 1) * sizeof *j.corners);
    p->mask_first = malloc((c->mask_count + 1) * sizeof *p->mask_first);
    if ((ok = j.corners && p->mask_first)) {
        int some_leave = p->reversed;
        parallel_for(threads, c->vertex_count, 4096, transform_vertices, &j);
        for (int n = 0; n < PARALLEL_THREADS_MAX; n++) some_leave |= j.leaves_bounds[n];
        ok = some_leave ? add_casters(&j) : take_casters(&j);
    }
    free(j.corners);
    free(j.slot);
    return ok ? VXS_OK : fail(m, VXS_E_MEMORY, "out of memory for the vertices of a map");
}

void projection_free(projection *p)
{
    free(p->vertices);
    free(p->own_indices);
    free(p->mask_first);
    free(p->uvq);
    free(p->own_meets);
    *p = (projection){0};
}
