/* Uniting the solids of casters; see mesh_union.h.
 *
 *   solids ---meet---> clusters ---mesh_unite---> results ---weld, number---> casters
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/mend/mesh_union.h"

#include <stdlib.h>
#include <string.h>

#include "baker/casters/mesh_edges.h"
#include "baker/casters/mesh_meet.h"
#include "baker/casters/mesh_weld.h"

#define NONE UINT32_MAX

typedef struct uniting {
    casters      *c;
    size_t        solids;
    uint32_t     *cluster_of;                      /* [solids] */
    uint32_t     *first, *members;                 /* triangles by solid */
    uint32_t     *cluster_first, *cluster_members; /* solids by cluster */
    unite_part   *parts;                           /* [solids] */
    uint8_t      *gone;                            /* [solids] 1: it is in a result */
    unite_result *results;                         /* [result_count] of each cluster */
    size_t        result_count, new_solids, new_triangles, new_vertices;
} uniting;

static void uniting_free(uniting *u)
{
    for (size_t i = 0; i < u->result_count; i++) unite_result_free(&u->results[i]);
    free(u->results);
    free(u->cluster_of);
    free(u->first);
    free(u->members);
    free(u->cluster_first);
    free(u->cluster_members);
    free(u->parts);
    free(u->gone);
}

static int uniting_init(uniting *u)
{
    size_t n           = u->solids + 1;
    u->cluster_of      = malloc(n * sizeof *u->cluster_of);
    u->first           = malloc((n + 1) * sizeof *u->first);
    u->members         = malloc((u->c->solid_triangle_count + 1) * sizeof *u->members);
    u->cluster_first   = malloc((n + 1) * sizeof *u->cluster_first);
    u->cluster_members = malloc(n * sizeof *u->cluster_members);
    u->parts           = calloc(n, sizeof *u->parts);
    u->gone            = calloc(n, sizeof *u->gone);
    u->results         = calloc(n, sizeof *u->results);
    return u->cluster_of && u->first && u->members && u->cluster_first && u->cluster_members && u->parts && u->gone && u->results;
}

/* --- clusters --------------------------------------------------------------------------------------------------------- */

static vxs_result unite_cluster(uniting *u, uint32_t cluster, union_cluster *k)
{
    const uint32_t *solids = &u->cluster_members[u->cluster_first[cluster]];
    size_t          count  = u->cluster_first[cluster + 1] - u->cluster_first[cluster];
    mesh_soup       soup   = {u->c->positions_ws, u->c->indices, u->c->solid_triangle_count};
    unite_part     *parts  = u->parts;
    *k                     = (union_cluster){.solid = cluster, .solids = (uint32_t)count};
    for (size_t i = 0; i < count; i++) {
        const uint32_t *members = &u->members[u->first[solids[i]]];
        parts[i]                = (unite_part){members, u->first[solids[i] + 1] - u->first[solids[i]], UNITE_TOO_LARGE, 0};
        k->triangles += (uint32_t)parts[i].count;
    }
    if (k->triangles <= UNION_TRIANGLES_MAX) {
        unite_result *result = &u->results[u->result_count];
        if (mesh_unite(&soup, parts, count, result) != VXS_OK) return VXS_E_MEMORY;
        u->result_count++;
        u->new_solids += result->result_count;
        u->new_triangles += result->triangle_count;
        u->new_vertices += result->vertex_count;
        k->results = (uint32_t)result->result_count;
    }
    for (size_t i = 0; i < count; i++) {
        k->left[parts[i].outcome]++;
        u->gone[solids[i]] = parts[i].outcome == UNITED;
    }
    return VXS_OK;
}

static void add_up(union_cluster *sum, const union_cluster *k)
{
    sum->solids += k->solids;
    sum->triangles += k->triangles;
    sum->results += k->results;
    for (int i = 0; i < UNITE_OUTCOMES; i++) sum->left[i] += k->left[i];
}

static vxs_result unite_clusters(uniting *u, union_report *out)
{
    for (uint32_t i = 0; i < u->solids; i++) {
        if (u->cluster_first[i + 1] - u->cluster_first[i] < 2) continue;
        if (unite_cluster(u, i, &out->clusters[out->count]) != VXS_OK) return VXS_E_MEMORY;
        add_up(&out->total, &out->clusters[out->count++]);
    }
    return VXS_OK;
}

/* --- casters anew ----------------------------------------------------------------------------------------------------- */

/* Everything as one list of triangles, not welded: solids that are left, new ones, sheets. */
typedef struct list {
    scene     s;         /* positions and indices alone */
    uint32_t *component; /* [triangles] */
    size_t    solids;    /* triangles of solids */
} list;

static void add_old(list *l, const casters *c, size_t t, uint32_t component)
{
    memcpy(&l->s.indices[3 * l->s.triangle_count], &c->indices[3 * t], 3 * sizeof *l->s.indices);
    l->component[l->s.triangle_count++] = component;
}

static void add_result(list *l, const unite_result *r, uint32_t *next_component)
{
    uint32_t vertex = (uint32_t)l->s.vertex_count;
    memcpy(&l->s.positions_ws[3 * l->s.vertex_count], r->positions_ws, 3 * r->vertex_count * sizeof *r->positions_ws);
    l->s.vertex_count += r->vertex_count;
    for (size_t i = 0; i < 3 * r->triangle_count; i++) l->s.indices[3 * l->s.triangle_count + i] = vertex + r->indices[i];
    for (size_t t = 0; t < r->triangle_count; t++) l->component[l->s.triangle_count++] = *next_component + r->result_of[t];
    *next_component += (uint32_t)r->result_count;
}

/* numbers  [solids] scratch: of solids that are left */
static void make_list(list *l, const uniting *u, uint32_t *numbers)
{
    const casters *c    = u->c;
    uint32_t       next = 0;
    for (size_t i = 0; i < u->solids; i++) numbers[i] = u->gone[i] ? NONE : next++;
    memcpy(l->s.positions_ws, c->positions_ws, 3 * c->vertex_count * sizeof *c->positions_ws);
    l->s.vertex_count = c->vertex_count;
    for (size_t t = 0; t < c->solid_triangle_count; t++)
        if (!u->gone[c->component_of[t]]) add_old(l, c, t, numbers[c->component_of[t]]);
    for (size_t i = 0; i < u->result_count; i++) add_result(l, &u->results[i], &next);
    l->solids = l->s.triangle_count;
    for (size_t t = c->solid_triangle_count; t < c->triangle_count; t++)
        add_old(l, c, t, (uint32_t)(c->component_of[t] - u->solids + next));
}

static int list_init(list *l, const uniting *u)
{
    size_t vertices = u->c->vertex_count + u->new_vertices, triangles = u->c->triangle_count + u->new_triangles;
    l->s.positions_ws = malloc((3 * vertices + 1) * sizeof *l->s.positions_ws);
    l->s.indices      = malloc((3 * triangles + 1) * sizeof *l->s.indices);
    l->component      = malloc((triangles + 1) * sizeof *l->component);
    return l->s.positions_ws && l->s.indices && l->component;
}

static void list_free(list *l)
{
    free(l->s.positions_ws);
    free(l->s.indices);
    free(l->component);
}

/* Put the welded list in the casters' place. Sheets lose nothing by welding, so masks only move. */
static void replace(casters *c, mesh_weld *w, const list *l, const uniting *u, uint8_t *kinds)
{
    size_t solids_left = 0, sheets = c->triangle_count - c->solid_triangle_count, solids = 0;
    for (size_t i = 0; i < u->solids; i++) solids_left += !u->gone[i];
    size_t sheet_components = 0, solid_components = solids_left + u->new_solids;
    for (int kind = COMPONENT_SOLID + 1; kind < COMPONENT_KINDS; kind++) sheet_components += c->component_count[kind];
    memset(kinds, COMPONENT_SOLID, solid_components);
    memcpy(kinds + solid_components, c->kind_of + u->solids, sheet_components);
    while (solids < w->triangle_count && w->from[solids] < l->solids) solids++;
    for (size_t t = 0; t < w->triangle_count; t++) w->from[t] = l->component[w->from[t]]; /* becomes component_of */

    free(c->positions_ws);
    free(c->indices);
    free(c->component_of);
    free(c->kind_of);
    free(c->solid_meets);
    c->positions_ws = w->positions_ws;
    c->vertex_count = w->vertex_count;
    c->indices      = w->indices;
    c->component_of = w->from;
    c->kind_of      = kinds;
    c->solid_meets  = NULL;
    c->meeting      = (meeting_counts){0};
    for (size_t i = 0; c->mask_first && i <= c->mask_count; i++) c->mask_first[i] += solids - c->solid_triangle_count;
    c->masked_first += solids - c->solid_triangle_count;
    c->component_count[COMPONENT_SOLID]   = solid_components;
    c->triangles_of_kind[COMPONENT_SOLID] = solids;
    c->solid_triangle_count               = solids;
    c->triangle_count                     = solids + sheets;
    free(w->welded_of);
}

static vxs_result rebuild(uniting *u, message *m)
{
    casters   *c          = u->c;
    list       l          = {0};
    mesh_weld  w          = {0};
    vxs_result r          = VXS_E_MEMORY;
    size_t     components = u->new_solids;
    for (int kind = 0; kind < COMPONENT_KINDS; kind++) components += c->component_count[kind];
    uint32_t *numbers = malloc((u->solids + 1) * sizeof *numbers);
    uint8_t  *kinds   = malloc(components + 1);
    if (numbers && kinds && list_init(&l, u)) {
        make_list(&l, u, numbers);
        r = mesh_weld_scene(&w, &l.s, m);
    }
    if (r == VXS_OK)
        replace(c, &w, &l, u, kinds);
    else
        free(kinds);
    free(numbers);
    list_free(&l);
    return r;
}

/* ---------------------------------------------------------------------------------------------------------------------- */

static vxs_result unite(uniting *u, union_report *out, message *m)
{
    vxs_result r;
    out->clusters = calloc(u->solids + 1, sizeof *out->clusters);
    if (!out->clusters || !uniting_init(u)) return VXS_E_MEMORY;
    if ((r = mesh_find_clusters(u->cluster_of, &out->gave_up, u->c, m)) != VXS_OK) return r;
    mesh_group(u->first, u->members, u->c->component_of, u->c->solid_triangle_count, u->solids);
    mesh_group(u->cluster_first, u->cluster_members, u->cluster_of, u->solids, u->solids);
    if ((r = unite_clusters(u, out)) != VXS_OK) return r;
    return u->new_solids ? rebuild(u, m) : VXS_OK;
}

vxs_result casters_unite(casters *c, union_report *out, message *m)
{
    uniting u    = {.c = c, .solids = c->component_count[COMPONENT_SOLID]};
    *out         = (union_report){0};
    vxs_result r = unite(&u, out, m);
    uniting_free(&u);
    if (r == VXS_OK) {
        out->solids_after    = c->component_count[COMPONENT_SOLID];
        out->triangles_after = c->solid_triangle_count;
        return VXS_OK;
    }
    union_report_free(out);
    return fail(m, r, "out of memory while uniting %zu solids", c->component_count[COMPONENT_SOLID]);
}

void union_report_free(union_report *r)
{
    free(r->clusters);
    *r = (union_report){0};
}

const char *unite_outcome_name(unite_outcome outcome)
{
    static const char *const names[UNITE_OUTCOMES] = {
        [UNITED]               = "united",
        [UNITE_NOT_MANIFOLD]   = "not manifold",
        [UNITE_CROSSES_ITSELF] = "crosses itself",
        [UNITE_NOT_OUTWARD]    = "not outward",
        [UNITE_FAILED]         = "no union",
        [UNITE_TOO_LARGE]      = "too large",
    };
    return (unsigned)outcome < UNITE_OUTCOMES ? names[outcome] : "unknown";
}
