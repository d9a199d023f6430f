/* Casters from classified components; see casters_work.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include <string.h>

#include "baker/base/group.h"
#include "baker/base/pages.h"
#include "baker/base/parallel.h"
#include "baker/casters/casters_work.h"

static int has_holes(const work *w, size_t t)
{
    return w->hole_of && w->hole_of[t] != NONE;
}

/* Groups of casters in the result: solids, sheets, and one group per alpha mask for triangles with holes. */
enum { GROUP_SOLIDS, GROUP_SHEETS, GROUP_MASKS };

typedef struct emission {
    casters  *c;
    work     *w;
    uint32_t *order; /* [triangle_count] triangle numbers of `work` in the order of the result; NULL: the same order */
    uint32_t *place; /* [triangle_count] and back */

    /* of `work`, or taken over by the result */
    const uint32_t *indices, *component_of;
    uint32_t       *emitted_as; /* [vertex_count] number of a vertex in the result, or NONE */
} emission;

/* Write triangles of the result. A triangle starts at its least corner, whatever corner the file starts with: rasterizers interpolate
 * from the first corner, and the same surface must give the same depths. */
static void emit_triangles(void *user, size_t begin, size_t end, uint32_t worker)
{
    const emission *e = user;
    work           *w = e->w;
    casters        *c = e->c;
    (void)worker;
    for (size_t at = begin; at < end; at++) {
        size_t           t       = e->order ? e->order[at] : at;
        const uint32_t   from[3] = {e->indices[3 * t], e->indices[3 * t + 1], e->indices[3 * t + 2]};
        const component *of      = &w->components[e->component_of[t]];
        unsigned         first   = mesh_least_corner(w->mesh.positions_ws, from);
        int              turn    = of->kind == COMPONENT_SOLID && of->volume < 0; /* inside out: a solid only with --closed on */
        for (unsigned n = 0; n < 3; n++) c->indices[3 * at + n] = from[(first + (turn ? 3 - n : n)) % 3];
        c->component_of[at] = of->number;
        w->flags[t]         = (uint8_t)(w->flags[t] | first << STARTS_SHIFT | (turn ? TURNED : 0));
        if (e->place) e->place[t] = (uint32_t)at;
        if (c->double_sided) c->double_sided[at] = (w->flags[t] & TRIANGLE_DOUBLE_SIDED) != 0;
        for (unsigned n = 0; n < 3 && has_holes(w, t); n++)
            memcpy(&c->hole_uvs[6 * (at - c->holed_first) + 2 * n], w->holes[w->hole_of[t]].uv[(first + n) % 3],
                   2 * sizeof *c->hole_uvs);
    }
}

/* Number of a half-edge of `work` in the result. Edge 0 of a turned triangle ends at its first corner in `work`, and so on. */
static uint32_t emitted_edge(const emission *e, uint32_t h)
{
    uint32_t t = h / 3, i = h % 3, flags = e->w->flags[t], first = (flags & STARTS) >> STARTS_SHIFT;
    return 3 * (e->place ? e->place[t] : t) + (flags & TURNED ? first + 5 - i : i + 3 - first) % 3;
}

static void emit_mates(void *user, size_t begin, size_t end, uint32_t worker)
{
    const emission *e = user;
    (void)worker;
    for (size_t t = begin; t < end; t++) {
        const uint32_t *mates    = e->w->edge_mates + 3 * t;
        uint32_t        three[3] = {mates[0], mates[1], mates[2]};
        for (uint32_t i = 0; i < 3; i++)
            e->c->edge_mates[emitted_edge(e, 3 * (uint32_t)t + i)] = three[i] == NONE ? NONE : emitted_edge(e, three[i]);
    }
}

static void emit_vertices(void *user, size_t begin, size_t end, uint32_t worker)
{
    const emission *e = user;
    (void)worker;
    for (size_t v = begin; v < end; v++)
        if (e->emitted_as[v] != NONE)
            memcpy(&e->c->positions_ws[3 * (size_t)e->emitted_as[v]], &e->w->mesh.positions_ws[3 * v], 3 * sizeof(double));
}

static int any_double_sided(const work *w)
{
    for (size_t n = 0; n < w->component_count; n++)
        if (w->components[n].flags & TRIANGLE_DOUBLE_SIDED) return 1;
    return 0;
}

/* Allocate the result; casters_free releases it. What stays in its order is taken over.
 * first  [GROUP_MASKS + alpha_mask_count + 1] first triangle of each group */
static int make_room(emission *e, const scene *s, const uint32_t *first)
{
    casters *c      = e->c;
    work    *w      = e->w;
    size_t   count  = w->mesh.triangle_count;
    e->indices      = w->mesh.indices;
    e->component_of = w->component_of;
    if (e->order) {
        c->indices      = pages_alloc(3 * count * sizeof *c->indices);
        c->component_of = pages_alloc(count * sizeof *c->component_of);
        c->edge_mates   = w->edge_mates ? pages_alloc(3 * count * sizeof *c->edge_mates) : NULL;
        e->place        = w->edge_mates ? pages_alloc(count * sizeof *e->place) : NULL;
        if (w->edge_mates && (!c->edge_mates || !e->place)) return 0;
    } else {
        c->indices      = w->mesh.indices;
        c->component_of = w->component_of;
        c->edge_mates   = w->edge_mates;
        w->mesh.indices = w->component_of = NULL;
    }
    c->double_sided     = any_double_sided(w) ? malloc(count) : NULL;
    c->kind_of          = malloc(w->component_count * sizeof *c->kind_of);
    c->parts_of         = malloc(w->component_count * sizeof *c->parts_of);
    c->boxes            = malloc(w->component_count * sizeof *c->boxes);
    c->alpha_masks      = allocate(s->alpha_mask_count, sizeof *c->alpha_masks);
    c->alpha_mask_first = allocate(s->alpha_mask_count + 1, sizeof *c->alpha_mask_first);
    c->hole_uvs         = allocate(count - first[GROUP_MASKS], 6 * sizeof *c->hole_uvs);
    if (!c->indices || !c->component_of || !c->kind_of || !c->parts_of || !c->boxes || !c->alpha_masks || !c->alpha_mask_first ||
        !c->hole_uvs || (any_double_sided(w) && !c->double_sided))
        return 0;

    c->solid_triangle_count = first[GROUP_SHEETS];
    c->holed_first          = first[GROUP_MASKS];
    c->alpha_mask_count     = s->alpha_mask_count;
    c->images               = s->images;
    if (s->alpha_mask_count) memcpy(c->alpha_masks, s->alpha_masks, s->alpha_mask_count * sizeof *c->alpha_masks);
    for (size_t i = 0; i <= s->alpha_mask_count; i++) c->alpha_mask_first[i] = first[GROUP_MASKS + i];
    return 1;
}

/* Find the order of the triangles in the result.
 * first  [out] [groups + 1] */
static vxs_result find_order(emission *e, uint32_t *first, size_t groups)
{
    const work *w     = e->w;
    size_t      count = w->mesh.triangle_count, solids = 0;
    vxs_result  r = VXS_E_MEMORY;
    for (size_t i = 0; i < w->component_count; i++) /* solids were not split */
        solids += w->components[i].kind == COMPONENT_SOLID ? w->components[i].triangle_count : 0;
    if (!w->hole_of && (!solids || solids == count)) { /* all are of one group */
        for (size_t n = 0; n <= groups; n++) first[n] = n > (solids ? GROUP_SOLIDS : GROUP_SHEETS) ? (uint32_t)count : 0;
        return VXS_OK;
    }
    uint32_t *group = pages_alloc(count * sizeof *group);
    e->order        = pages_alloc(count * sizeof *e->order);
    for (size_t t = 0; t < count && group; t++)
        group[t] = has_holes(w, t)                                             ? GROUP_MASKS + w->holes[w->hole_of[t]].mask
                   : w->components[w->component_of[t]].kind == COMPONENT_SOLID ? (uint32_t)GROUP_SOLIDS
                                                                               : (uint32_t)GROUP_SHEETS;
    if (group && e->order) r = group_by_key(first, e->order, group, count, groups, w->threads);
    free(group);
    return r;
}

/* Number the components in the result: solids first, otherwise in the order of first triangles. */
static void number_components(casters *c, work *w)
{
    for (size_t i = 0; i < w->component_count; i++) {
        c->component_count[w->components[i].kind]++;
        c->triangles_of_kind[w->components[i].kind] += w->components[i].triangle_count;
    }
    size_t next_solid = 0, next_sheet = c->component_count[COMPONENT_SOLID];
    for (size_t i = 0; i < w->component_count; i++) {
        component *k           = &w->components[i];
        k->number              = (uint32_t)(k->kind == COMPONENT_SOLID ? next_solid++ : next_sheet++);
        c->kind_of[k->number]  = (uint8_t)k->kind;
        c->parts_of[k->number] = k->parts;
        c->boxes[k->number]    = w->boxes[i];
    }
}

/* Give the result its vertices: all, or those that triangles use, in the order of first use. Returns 0 without memory. */
static int take_vertices(emission *e)
{
    casters *c = e->c;
    work    *w = e->w;
    if (!w->has_unused) {
        c->vertex_count      = w->mesh.vertex_count;
        c->positions_ws      = w->mesh.positions_ws;
        w->mesh.positions_ws = NULL;
        return 1;
    }
    c->positions_ws = pages_alloc(3 * w->mesh.vertex_count * sizeof *c->positions_ws);
    e->emitted_as   = pages_alloc(w->mesh.vertex_count * sizeof *e->emitted_as);
    if (!c->positions_ws || !e->emitted_as) return 0;
    memset(e->emitted_as, 0xff, w->mesh.vertex_count * sizeof *e->emitted_as);
    for (uint32_t *v = c->indices; v < c->indices + 3 * c->triangle_count; v++) {
        uint32_t *as = &e->emitted_as[*v];
        if (*as == NONE) *as = (uint32_t)c->vertex_count++;
        *v = *as;
    }
    parallel_for(w->threads, w->mesh.vertex_count, GRAIN, emit_vertices, e);
    return 1;
}

vxs_result casters_emit(casters *c, work *w, const scene *s, run_context *m)
{
    enum { EACH = 9 * sizeof(uint32_t) };
    vxs_result r     = VXS_E_MEMORY;
    size_t     count = w->mesh.triangle_count, groups = GROUP_MASKS + s->alpha_mask_count;
    if (check_room(count, EACH, 0, 0, m) != VXS_OK) return r;
    uint32_t *first = malloc((groups + 1) * sizeof *first);
    emission  e     = {.c = c, .w = w};
    if (!first || (r = find_order(&e, first, groups)) != VXS_OK) goto done;
    if (!make_room(&e, s, first)) {
        r = VXS_E_MEMORY;
        goto done;
    }
    number_components(c, w);
    c->triangle_count = count;
    parallel_for(w->threads, count, GRAIN, emit_triangles, &e);
    if (w->edge_mates) parallel_for(w->threads, count, GRAIN, emit_mates, &e);
    if (!take_vertices(&e)) r = VXS_E_MEMORY;
done:
    if (c->edge_mates == w->edge_mates) w->edge_mates = NULL; /* taken over */
    free(first);
    free(e.order);
    free(e.place);
    free(e.emitted_as);
    return r == VXS_OK ? r : out_of_memory(m, count);
}
