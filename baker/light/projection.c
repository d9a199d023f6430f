/* Project casters into a map; see projection.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/light/projection.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/array.h"
#include "baker/base/box.h"
#include "baker/base/pages.h"
#include "baker/base/parallel.h"
#include "baker/light/map_space.h"

#define NONE UINT32_MAX

enum { GRAIN = 4096 };

/* A vertex of the casters in map space. */
typedef struct seen_vertex {
    double   at[3];
    uint32_t outside; /* bits of planes that it is outside of */
    uint32_t vertex;  /* number in the projection, or NONE */
} seen_vertex;

/* Bits of seen_vertex: sides one texel beyond the map; the plane of a spot light; sides beyond which triangles are clipped. */
enum { TOUCH_SIDES = (1 << MAP_SIDES) - 1, BEHIND = 1 << MAP_SIDES, KEEP_SHIFT = MAP_SIDES + 1 };

typedef struct projector {
    projection      *p;
    const vxs_light *light;
    int              map;
    double           side_px;
    map_frame        frame;
    map_sides        touch, keep;
    map_plane        touch_ws[MAP_SIDES]; /* touch, in world space */
    uint32_t        *seen_as;             /* [casters->vertex_count] 1 + number in seen; 0: not seen yet */
    seen_vertex     *seen;                /* vertices of triangles in runs that may touch the map */
    size_t           seen_count, seen_capacity;
    size_t           vertex_capacity, triangle_capacity, uvq_capacity, meets_capacity, sides_capacity;
    uint8_t          meets;                               /* for the current caster; 1: its solid meets another solid or itself */
    uint8_t          double_sided;                        /* for the current caster; 1: double-sided */
    int              leaves_bounds[PARALLEL_THREADS_MAX]; /* by worker; 1: a vertex is far outside the map */
} projector;

static vertex_ls project(const projector *w, const double at[3])
{
    if (!w->p->reversed) return (vertex_ls){at[0], at[1], at[2]};
    double per_px = at[2] * w->light->texel_metres;
    return (vertex_ls){0.5 * w->side_px + at[0] / per_px, 0.5 * w->side_px + at[1] / per_px, w->light->near_metres / at[2]};
}

/* Project vertices for a directional light; often all of them are in bounds. */
static void project_vertices(void *user, size_t begin, size_t end, uint32_t worker)
{
    projector *w    = user;
    double     side = w->side_px, at[3];
    for (size_t n = begin; n < end; n++) {
        map_space_from_ws(&w->frame, w->p->casters->positions_ws + 3 * n, at);
        if (!(at[0] >= -side && at[0] <= 2 * side && at[1] >= -side && at[1] <= 2 * side)) w->leaves_bounds[worker] = 1;
        w->p->vertices[n] = project(w, at);
    }
}

/* one caster ------------------------------------------------------------------------------------------------------------------ */

/* Returns the index of a new vertex, or NONE. */
static uint32_t add_vertex(projector *w, const double at[3])
{
    projection *p = w->p;
    if (p->vertex_count == NONE || !array_reserve(&p->vertices, &w->vertex_capacity, p->vertex_count + 1, sizeof *p->vertices))
        return NONE;
    p->vertices[p->vertex_count] = project(w, at);
    return (uint32_t)p->vertex_count++;
}

/* Store the image coordinates of the next triangle's corners. */
static int add_uvq(projector *w, const map_corner *const corners[3])
{
    projection *p     = w->p;
    size_t      count = p->triangle_count - p->holed_first;
    if (!array_reserve(&p->uvq, &w->uvq_capacity, count + 1, sizeof *p->uvq)) return 0;
    for (int n = 0; n < 3; n++) {
        double q         = p->reversed ? project(w, corners[n]->at).z : 1;
        p->uvq[count][n] = (hole_uvq){(float)(corners[n]->uv[0] * q), (float)(corners[n]->uv[1] * q), (float)q};
    }
    return 1;
}

static int add_triangle(projector *w, const uint32_t corners[3])
{
    projection *p = w->p;
    if (!array_reserve(&p->own_indices, &w->triangle_capacity, p->triangle_count + 1, 3 * sizeof *p->own_indices)) return 0;
    if (!array_reserve(&p->own_meets, &w->meets_capacity, p->triangle_count + 1, sizeof *p->own_meets)) return 0;
    p->own_meets[p->triangle_count] = w->meets;
    if (p->casters->double_sided) {
        if (!array_reserve(&p->own_double_sided, &w->sides_capacity, p->triangle_count + 1, sizeof *p->own_double_sided)) return 0;
        p->own_double_sided[p->triangle_count] = w->double_sided;
    }
    memcpy(p->own_indices + 3 * p->triangle_count++, corners, 3 * sizeof *corners);
    return 1;
}

static uint32_t outside_of(const projector *w, const double at[3])
{
    uint32_t outside = map_space_point_behind(w->light, w->map, at) ? BEHIND : 0;
    for (int n = 0; n < MAP_SIDES; n++) {
        outside |= (uint32_t)(map_side_at(w->touch.n[n], at) < 0) << n;
        outside |= (uint32_t) !(map_side_at(w->keep.n[n], at) >= 0) << (KEEP_SHIFT + n);
    }
    return outside;
}

/* Returns the number of a vertex in w->seen, where there is room for it. */
static uint32_t see(projector *w, uint32_t vertex)
{
    uint32_t *as = &w->seen_as[vertex];
    if (!*as) {
        seen_vertex *s = &w->seen[w->seen_count];
        map_space_from_ws(&w->frame, w->p->casters->positions_ws + 3 * (size_t)vertex, s->at);
        s->outside = outside_of(w, s->at);
        s->vertex  = NONE;
        *as        = (uint32_t)++w->seen_count;
    }
    return *as - 1;
}

static void set_corner(map_corner *to, const projector *w, const seen_vertex *s, size_t triangle, size_t k)
{
    const casters *c         = w->p->casters;
    int            has_holes = c->alpha_mask_count && triangle >= c->holed_first;
    memcpy(to->at, s->at, sizeof to->at);
    for (size_t n = 0; n < 2; n++) to->uv[n] = has_holes ? (double)c->hole_uvs[6 * (triangle - c->holed_first) + 2 * k + n] : 0;
}

static int add_caster(projector *w, size_t n)
{
    const casters *c = w->p->casters;
    map_polygon    triangle, kept;
    seen_vertex   *seen[3];
    uint32_t       number[3];
    if (!array_reserve(&w->seen, &w->seen_capacity, w->seen_count + 3, sizeof *w->seen)) return 0;
    for (size_t k = 0; k < 3; k++) number[k] = see(w, c->indices[3 * n + k]);
    for (size_t k = 0; k < 3; k++) seen[k] = &w->seen[number[k]];
    if (seen[0]->outside & seen[1]->outside & seen[2]->outside & (TOUCH_SIDES | BEHIND)) return 1;
    w->meets        = n < c->solid_triangle_count && (!c->solid_meets || c->solid_meets[n]);
    w->double_sided = c->double_sided && c->double_sided[n];
    int has_holes   = c->alpha_mask_count && n >= c->holed_first;
    int clipped     = (seen[0]->outside | seen[1]->outside | seen[2]->outside) >> KEEP_SHIFT != 0;
    triangle.count  = 3;
    for (size_t k = 0; k < 3 && (clipped || has_holes); k++) set_corner(&triangle.corners[k], w, seen[k], n, k);
    if (!clipped) {
        uint32_t corners[3];
        for (int i = 0; i < 3; i++) {
            if (seen[i]->vertex == NONE && (seen[i]->vertex = add_vertex(w, seen[i]->at)) == NONE) return 0;
            corners[i] = seen[i]->vertex;
        }
        const map_corner *const of[3] = {&triangle.corners[0], &triangle.corners[1], &triangle.corners[2]};
        return (!has_holes || add_uvq(w, of)) && add_triangle(w, corners);
    }
    map_sides_clip(&w->keep, &triangle, &kept);
    if (kept.count < 3) return 1;

    /* Add a convex polygon as a triangle fan from its first corner. */
    uint32_t corners[3];
    for (int j = 0; j < kept.count; j++) {
        uint32_t vertex = add_vertex(w, kept.corners[j].at);
        if (vertex == NONE) return 0;
        if (j < 2) {
            corners[j] = vertex;
            continue;
        }
        const map_corner *const of[3] = {&kept.corners[0], &kept.corners[j - 1], &kept.corners[j]};
        corners[2]                    = vertex;
        if ((has_holes && !add_uvq(w, of)) || !add_triangle(w, corners)) return 0;
        corners[1] = vertex;
    }
    return 1;
}

/* the casters ----------------------------------------------------------------------------------------------------------------- */

/* First triangle with holes. */
static size_t opaque_end(const casters *c)
{
    return c->alpha_mask_count ? c->holed_first : c->triangle_count;
}

static int run_may_touch(const projector *w, size_t run)
{
    const box *runs = w->p->casters->runs;
    for (int n = 0; n < MAP_SIDES && runs; n++)
        if (map_plane_most(&w->touch_ws[n], &runs[run]) < 0) return 0;
    return 1;
}

/* Add casters [first, end) in order. */
static int add_range(projector *w, size_t first, size_t end)
{
    for (size_t n = first, next; n < end; n = next) {
        next = casters_run_end(w->p->casters, n / CASTERS_RUN);
        next = next < end ? next : end;
        if (!run_may_touch(w, n / CASTERS_RUN)) continue;
        for (; n < next; n++)
            if (!add_caster(w, n)) return 0;
    }
    return 1;
}

static int add_casters(projector *w)
{
    projection    *p = w->p;
    const casters *c = p->casters;
    w->touch         = map_sides_of(w->light, 1);
    w->keep          = map_sides_of(w->light, w->side_px);
    for (int n = 0; n < MAP_SIDES; n++) w->touch_ws[n] = map_plane_of(&w->frame, w->touch.n[n]);
    if (!(w->seen_as = calloc(c->vertex_count + 1, sizeof *w->seen_as))) return 0;

    if (!add_range(w, 0, c->solid_triangle_count)) return 0;
    p->solid_triangle_count = p->triangle_count;
    if (!add_range(w, c->solid_triangle_count, opaque_end(c))) return 0;
    p->holed_first = p->triangle_count;
    for (size_t mask = 0; mask < c->alpha_mask_count; mask++) {
        p->alpha_mask_first[mask] = p->triangle_count;
        if (!add_range(w, c->alpha_mask_first[mask], c->alpha_mask_first[mask + 1])) return 0;
    }
    p->alpha_mask_first[c->alpha_mask_count] = p->triangle_count;
    p->indices                               = p->own_indices;
    p->meets                                 = p->own_meets;
    p->double_sided                          = p->own_double_sided;
    return 1;
}

/* Project all vertices. Returns 0 when some are out of bounds, or without memory. */
static int project_all(projector *w, uint32_t threads)
{
    projection *p       = w->p;
    size_t      count   = p->casters->vertex_count;
    int         outside = 0;
    if (!(p->vertices = pages_alloc((count + 1) * sizeof *p->vertices))) return 0;
    parallel_for(threads, count, GRAIN, project_vertices, w);
    for (int n = 0; n < PARALLEL_THREADS_MAX; n++) outside |= w->leaves_bounds[n];
    if (!outside) return 1;
    free(p->vertices);
    p->vertices = NULL;
    return 0;
}

/* All vertices are in bounds: use the casters' own triangles. */
static int take_casters(projector *w)
{
    projection    *p        = w->p;
    const casters *c        = p->casters;
    p->vertex_count         = c->vertex_count;
    p->triangle_count       = c->triangle_count;
    p->solid_triangle_count = c->solid_triangle_count;
    p->holed_first          = opaque_end(c);
    p->indices              = c->indices;
    p->meets                = c->solid_meets;
    p->double_sided         = c->double_sided;
    p->edge_mates           = c->edge_mates;
    for (size_t mask = 0; mask <= c->alpha_mask_count; mask++)
        p->alpha_mask_first[mask] = c->alpha_mask_count ? c->alpha_mask_first[mask] : c->triangle_count;

    size_t with_holes = c->triangle_count - p->holed_first;
    p->uvq            = malloc((with_holes + 1) * sizeof *p->uvq);
    if (!p->uvq) return 0;
    for (size_t n = 0; n < 3 * with_holes; n++) p->uvq[n / 3][n % 3] = (hole_uvq){c->hole_uvs[2 * n], c->hole_uvs[2 * n + 1], 1};
    return 1;
}

vxs_result projection_init(projection *p, const casters *c, const vxs_light *light, int map, uint32_t threads, run_context *m)
{
    *p          = (projection){.casters = c, .reversed = light->kind != VXS_LIGHT_KIND_DIRECTIONAL};
    projector w = {.p = p, .light = light, .map = map, .side_px = ldexp(1, (int)light->levels), .frame = map_frame_of(light, map)};
    p->alpha_mask_first = malloc((c->alpha_mask_count + 1) * sizeof *p->alpha_mask_first);
    int complete        = p->alpha_mask_first != NULL;
    if (complete) complete = !p->reversed && project_all(&w, threads) ? take_casters(&w) : add_casters(&w);
    free(w.seen_as);
    free(w.seen);
    return complete ? VXS_OK : fail(m, VXS_E_MEMORY, "out of memory for the vertices of a map");
}

/* Copy the items of kept triangles to `to`, which may be `items`.
 * items  of triangles [first, end), size_bytes each */
static void keep_items(void *to, const void *items, size_t size_bytes, const uint8_t *kept, size_t first, size_t end)
{
    uint8_t       *out = to;
    const uint8_t *in  = items;
    for (size_t t = first; t < end; t++) {
        if (!kept[t]) continue;
        memmove(out, in + (t - first) * size_bytes, size_bytes);
        out += size_bytes;
    }
}

/* Replace a triangle number by the number of kept triangles before it. Call with ascending numbers.
 * counted, found  [in, out] triangles counted so far, and kept ones among them; 0 at first */
static void keep_count(size_t *count, const uint8_t *kept, size_t *counted, size_t *found)
{
    for (; *counted < *count; ++*counted) *found += kept[*counted];
    *count = *found;
}

/* Keep the mates of edges between kept triangles, under their new numbers. Without memory they are not known. */
static void keep_mates(projection *p, const uint8_t *kept, size_t room)
{
    uint32_t *place = pages_alloc((p->triangle_count + 1) * sizeof *place), count = 0;
    p->own_edge_mates = pages_alloc(3 * room * sizeof *p->own_edge_mates);
    for (size_t t = 0; t < p->triangle_count && place; t++) {
        place[t] = count;
        count += kept[t];
    }
    for (size_t h = 0, to = 0; h < 3 * p->triangle_count && place && p->own_edge_mates; h++) {
        uint32_t mate = p->edge_mates[h];
        if (!kept[h / 3]) continue;
        p->own_edge_mates[to++] = mate != NONE && kept[mate / 3] ? 3 * place[mate / 3] + mate % 3 : NONE;
    }
    p->edge_mates = place ? p->own_edge_mates : NULL;
    free(place);
}

vxs_result projection_keep(projection *p, const uint8_t *kept)
{
    size_t count = p->triangle_count, room = 1, counted = 0, found = 0;
    for (size_t t = 0; t < count; t++) room += kept[t];
    if (!p->own_indices) p->own_indices = malloc(3 * room * sizeof *p->own_indices);
    if (!p->own_meets && p->meets) p->own_meets = malloc(room);
    if (!p->own_double_sided && p->double_sided) p->own_double_sided = malloc(room);
    if (!p->own_indices || (p->meets && !p->own_meets) || (p->double_sided && !p->own_double_sided)) return VXS_E_MEMORY;
    if (p->edge_mates) keep_mates(p, kept, room);
    keep_items(p->own_indices, p->indices, 3 * sizeof *p->indices, kept, 0, count);
    if (p->meets) keep_items(p->own_meets, p->meets, 1, kept, 0, p->solid_triangle_count);
    if (p->double_sided) keep_items(p->own_double_sided, p->double_sided, 1, kept, 0, count);
    if (p->uvq) keep_items(p->uvq, p->uvq, sizeof *p->uvq, kept, p->holed_first, count);
    p->indices      = p->own_indices;
    p->meets        = p->own_meets;
    p->double_sided = p->own_double_sided;
    keep_count(&p->solid_triangle_count, kept, &counted, &found);
    keep_count(&p->holed_first, kept, &counted, &found);
    for (size_t mask = 0; mask <= p->casters->alpha_mask_count; mask++)
        keep_count(&p->alpha_mask_first[mask], kept, &counted, &found);
    keep_count(&p->triangle_count, kept, &counted, &found);
    return VXS_OK;
}

void projection_free(projection *p)
{
    free(p->vertices);
    free(p->own_indices);
    free(p->alpha_mask_first);
    free(p->uvq);
    free(p->own_meets);
    free(p->own_double_sided);
    free(p->own_edge_mates);
    *p = (projection){0};
}

/* Clamp a coordinate, so that it fits an int32_t. Boxes far outside the map stay far outside. */
static double in_range(double t)
{
    t = t > -1e9 ? t : -1e9;
    return t < 1e9 ? t : 1e9;
}

/* First texel at or after t; last texel at or before t. */
static int32_t texel_from(double t)
{
    int32_t index = (int32_t)in_range(t);
    return index + (index < in_range(t));
}

static int32_t texel_to(double t)
{
    int32_t index = (int32_t)in_range(t);
    return index - (index > in_range(t));
}

static double least(double a, double b, double c)
{
    a = a < b ? a : b;
    return a < c ? a : c;
}

static double most(double a, double b, double c)
{
    a = a > b ? a : b;
    return a > c ? a : c;
}

texel_box texel_box_of(const projection *p, size_t triangle)
{
    const uint32_t  *t = p->indices + 3 * triangle;
    const vertex_ls *a = &p->vertices[t[0]], *b = &p->vertices[t[1]], *c = &p->vertices[t[2]];
    /* texel centres are at half integers; snapping may move an edge by half a subtexel */
    const double     slack = 0.5 / SUBTEXELS;
    return (texel_box){
        texel_from(least(a->u, b->u, c->u) - 0.5 - slack),
        texel_from(least(a->v, b->v, c->v) - 0.5 - slack),
        texel_to(most(a->u, b->u, c->u) - 0.5 + slack),
        texel_to(most(a->v, b->v, c->v) - 0.5 + slack),
    };
}

int texel_box_touches(const texel_box *b, int32_t u0, int32_t v0, int32_t side)
{
    return b->u0 <= b->u1 && b->v0 <= b->v1 && b->u0 < u0 + side && b->v0 < v0 + side && b->u1 >= u0 && b->v1 >= v0;
}
