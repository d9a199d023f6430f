/* Examining components; see mesh_health.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/mend/mesh_health.h"

#include <stdlib.h>
#include <string.h>

#include "baker/base/array.h"
#include "baker/base/scratch.h"
#include "baker/base/vec3.h"
#include "baker/casters/casters_cgal.h"
#include "baker/casters/mesh_edges.h"

/* Limits of the search for intersections: about ten seconds in total. */
#define LOOKS_MAX 1000000000u
#define TESTS_MAX 40000000u

enum { RECENT = 1 << 16 }; /* pairs of components that are remembered, so that most are listed only once */

typedef struct examination {
    mesh_health   *h;
    const casters *c;
    scratch        memory;     /* of the arrays but for pairs */
    uint32_t       edge_count; /* 3 * triangle_count */
    uint32_t      *sorted;     /* [edge_count] half-edges */
    uint32_t      *joined;     /* memory for union-find, [edge_count] at most */
    uint8_t       *turned;     /* [triangle_count] 1: turned against its parent in the forest */
    uint64_t      *keys;       /* scratch: [edge_count] */
    uint64_t      *pairs;      /* [pair_count] solids that intersect: lower, higher number */
    size_t         pair_count, pair_capacity;
    uint64_t      *recent; /* [RECENT] */
    int            no_memory;
} examination;

static component_health *component_at(const examination *x, size_t triangle)
{
    return &x->h->components[x->c->component_of[triangle]];
}

/* keys: two numbers each, to be sorted and counted ----------------------------------------------------------------------------- */

static int by_key(const void *a, const void *b)
{
    uint64_t p = *(const uint64_t *)a, q = *(const uint64_t *)b;
    return p < q ? -1 : p > q;
}

static void sort_keys(uint64_t *keys, size_t count)
{
    if (count > 1) qsort(keys, count, sizeof *keys, by_key); /* keys may be NULL when there are none */
}

static size_t drop_repeated(uint64_t *keys, size_t count)
{
    size_t kept = 0;
    sort_keys(keys, count);
    for (size_t i = 0; i < count; i++)
        if (!i || keys[i] != keys[i - 1]) keys[kept++] = keys[i];
    return kept;
}

/* edges ------------------------------------------------------------------------------------------------------------------------ */

/* Half-edges [begin, end) of x->sorted belong to one edge. To find surfaces that are not orientable, join triangles across edges
 * of two triangles, each with a flag that it is turned against its root. */
static void examine_edge(examination *x, uint32_t begin, uint32_t end)
{
    const uint32_t   *indices = x->c->indices;
    component_health *k       = component_at(x, x->sorted[begin] / 3);
    uint32_t          count   = end - begin;
    int64_t           balance = mesh_edge_balance(indices, x->sorted, begin, end);
    k->edges++;
    k->boundary_edges += count == 1;
    k->nonmanifold_edges += count > 2;
    k->misoriented_edges += count == 2 && balance;
    if (count % 2) k->closed = 0;
    if (balance > (int64_t)(count % 2) || -balance > (int64_t)(count % 2)) k->oriented = 0;
    if (count != 2) return;
    uint32_t h = x->sorted[begin], g = x->sorted[begin + 1];
    int      same_way = indices[h] == indices[g]; /* one of them is turned */
    if (!mesh_join_turned(x->joined, x->turned, h / 3, g / 3, same_way)) k->orientable = 0;
}

static void for_each_edge(examination *x, void (*examine)(examination *x, uint32_t begin, uint32_t end))
{
    for (uint32_t begin = 0, end; begin < x->edge_count; begin = end) {
        end = mesh_edge_run(x->c->indices, x->sorted, begin, x->edge_count);
        examine(x, begin, end);
    }
}

static void start_joining(examination *x, size_t count)
{
    for (uint32_t i = 0; i < count; i++) x->joined[i] = i;
}

/* Join the corners at each end of an edge. */
static void join_corners(examination *x, uint32_t begin, uint32_t end)
{
    const uint32_t *indices = x->c->indices;
    uint32_t        first = x->sorted[begin], start = indices[first];
    uint32_t        first_end = first % 3 == 2 ? first - 2 : first + 1;
    for (uint32_t i = begin + 1; i < end; i++) {
        uint32_t h = x->sorted[i], h_end = h % 3 == 2 ? h - 2 : h + 1;
        mesh_join(x->joined, first, indices[h] == start ? h : h_end);
        mesh_join(x->joined, first_end, indices[h] == start ? h_end : h);
    }
}

/* A hole is counted once, at the boundary edge whose root is its lowest vertex. A vertex that two components share joins their
 * holes, but each counts its own: roots are distinguished by component. */
static void count_holes(examination *x)
{
    const uint32_t *indices   = x->c->indices;
    size_t          key_count = 0;
    start_joining(x, x->c->vertex_count);
    for (uint32_t begin = 0, end; begin < x->edge_count; begin = end) {
        uint32_t h = x->sorted[begin];
        end        = mesh_edge_run(indices, x->sorted, begin, x->edge_count);
        if (end - begin != 1) continue;
        mesh_join(x->joined, indices[h], mesh_edge_end(indices, h));
        x->keys[key_count++] = (uint64_t)x->c->component_of[h / 3] << 32 | indices[h];
    }
    for (size_t i = 0; i < key_count; i++) x->keys[i] = x->keys[i] >> 32 << 32 | mesh_find(x->joined, (uint32_t)x->keys[i]);
    key_count = drop_repeated(x->keys, key_count);
    for (size_t i = 0; i < key_count; i++) x->h->components[x->keys[i] >> 32].holes++;
}

/* triangles -------------------------------------------------------------------------------------------------------------------- */

/* Find repeated triangles at the edge of their two lowest corners: there, only the third corner differs. */
static void find_repeated(examination *x, uint32_t begin, uint32_t end)
{
    const uint32_t *indices = x->c->indices;
    size_t          count   = 0;
    if (end - begin < 2) return;
    for (uint32_t i = begin; i < end; i++) {
        uint32_t third = mesh_edge_opposite(indices, x->sorted[i]);
        if (third > mesh_edge_high(indices, x->sorted[i])) x->keys[count++] = third;
    }
    sort_keys(x->keys, count);
    for (size_t i = 1; i < count; i++) component_at(x, x->sorted[begin] / 3)->repeated_triangles += x->keys[i] == x->keys[i - 1];
}

/* Sizes and volumes. Volumes are summed relative to a corner of the box, to avoid cancellation with large coordinates. */
static void measure(examination *x)
{
    const casters *c    = x->c;
    mesh_soup      soup = {c->positions_ws, c->indices, c->triangle_count};
    for (size_t t = 0; t < c->triangle_count; t++) {
        component_health *k = component_at(x, t);
        k->triangles++;
        for (size_t i = 0; i < 3; i++) box_add(&k->box_ws, &c->positions_ws[3 * (size_t)c->indices[3 * t + i]]);
        k->zero_area_triangles += mesh_is_flat(&soup, t) != 0;
    }
    for (size_t t = 0; t < c->triangle_count; t++) {
        component_health *k = component_at(x, t);
        double            e[3][3], normal[3];
        if (!k->closed || !k->oriented) continue;
        for (size_t i = 0; i < 3; i++) vec3_sub(&c->positions_ws[3 * (size_t)c->indices[3 * t + i]], k->box_ws.min, e[i]);
        vec3_cross(e[1], e[2], normal);
        k->volume_m3 += vec3_dot(e[0], normal) / 6;
    }
}

/* intersections ---------------------------------------------------------------------------------------------------------------- */

static uint64_t pair_key(const examination *x, uint32_t a, uint32_t b)
{
    uint32_t p = x->c->component_of[a], q = x->c->component_of[b];
    return p < q ? (uint64_t)p << 32 | q : (uint64_t)q << 32 | p;
}

static uint64_t *recent_at(const examination *x, uint64_t key)
{
    return &x->recent[(key * 0x9e3779b97f4a7c15u) >> 48];
}

/* Remove repeated pairs when the array is full, before it grows. */
static int add_pair(examination *x, uint64_t key)
{
    if (x->pair_count == x->pair_capacity) x->pair_count = drop_repeated(x->pairs, x->pair_count);
    if (2 * x->pair_count >= x->pair_capacity &&
        !array_reserve(&x->pairs, &x->pair_capacity, 2 * x->pair_count + 1, sizeof *x->pairs))
        return 0;
    x->pairs[x->pair_count++] = key;
    return 1;
}

/* Pairs within one component, or of two solids not yet known to intersect. */
static int matters(void *user, uint32_t a, uint32_t b)
{
    const examination *x  = user;
    const uint32_t    *of = x->c->component_of;
    if (of[a] == of[b]) return 1;
    if (x->c->kind_of[of[a]] != COMPONENT_SOLID || x->c->kind_of[of[b]] != COMPONENT_SOLID) return 0;
    uint64_t key = pair_key(x, a, b);
    return *recent_at(x, key) != key;
}

static int keep_intersection(void *user, uint32_t a, uint32_t b)
{
    examination    *x  = user;
    const uint32_t *of = x->c->component_of, *indices = x->c->indices;
    if (of[a] == of[b]) {
        const uint32_t *v = &indices[3 * (size_t)a], *w = &indices[3 * (size_t)b];
        int             same = 0; /* the corners of a triangle are all different */
        for (int i = 0; i < 3; i++) same += v[i] == w[0] || v[i] == w[1] || v[i] == w[2];
        component_at(x, a)->self_intersections += same < 3;
        return 0;
    }
    uint64_t key       = pair_key(x, a, b);
    *recent_at(x, key) = key;
    x->no_memory       = !add_pair(x, key);
    return x->no_memory;
}

static int examine_intersections(examination *x)
{
    mesh_soup   soup   = {x->c->positions_ws, x->c->indices, x->c->triangle_count};
    mesh_search search = {
        .wanted = matters, .found = keep_intersection, .user = x, .overlaps_max = LOOKS_MAX, .tests_max = TESTS_MAX};
    if (mesh_find_intersections(&soup, &search) != VXS_OK || x->no_memory) return 0;
    x->h->gave_up = search.gave_up;

    /* store the solids that intersect: every pair twice, once for each solid */
    mesh_health *h     = x->h;
    size_t       count = drop_repeated(x->pairs, x->pair_count);
    h->met             = malloc((2 * count + 1) * sizeof *h->met);
    if (!h->met || !array_reserve(&x->pairs, &x->pair_capacity, 2 * count, sizeof *x->pairs)) return 0;
    for (size_t i = 0; i < count; i++) x->pairs[count + i] = x->pairs[i] << 32 | x->pairs[i] >> 32;
    sort_keys(x->pairs, 2 * count);
    for (size_t i = 0; i < 2 * count; i++) {
        component_health *k = &h->components[x->pairs[i] >> 32];
        if (!k->meets++) k->meets_first = i;
        h->met[i] = (uint32_t)x->pairs[i];
    }
    return 1;
}

static int examine(examination *x, mesh_health *h, const casters *c, void (*progress)(const char *what))
{
    if (progress) progress("edges");

    h->count      = casters_component_count(c);
    x->edge_count = (uint32_t)(3 * c->triangle_count);
    h->components = calloc(h->count + 1, sizeof *h->components);
    x->sorted     = scratch_take(&x->memory, x->edge_count, sizeof *x->sorted);
    x->joined     = scratch_take(&x->memory, x->edge_count, sizeof *x->joined); /* there are at most as many vertices as corners */
    x->turned     = scratch_take(&x->memory, c->triangle_count, sizeof *x->turned);
    x->keys       = scratch_take(&x->memory, x->edge_count, sizeof *x->keys);
    x->recent     = scratch_take(&x->memory, RECENT, sizeof *x->recent);
    if (x->recent) memset(x->recent, 0xff, RECENT * sizeof *x->recent);
    if (!(h->components && !x->memory.missing)) return 0;

    for (size_t i = 0; i < h->count; i++)
        h->components[i] = (component_health){
            .kind = (component_kind)c->kind_of[i], .closed = 1, .orientable = 1, .oriented = 1, .box_ws = box_empty()};
    if (mesh_sort_edges(x->sorted, c->indices, c->triangle_count, c->vertex_count, 1) != VXS_OK) return 0;
    start_joining(x, c->triangle_count);
    for_each_edge(x, examine_edge);
    for_each_edge(x, find_repeated);

    /* Count the roots of corners around a vertex: one for each group of triangles. */
    size_t key_count = 0;
    start_joining(x, x->edge_count); /* there are as many corners */
    for_each_edge(x, join_corners);
    for (uint32_t i = 0; i < x->edge_count; i++)
        if (mesh_find(x->joined, i) == i) x->keys[key_count++] = (uint64_t)x->c->component_of[i / 3] << 32 | x->c->indices[i];
    sort_keys(x->keys, key_count);
    for (size_t begin = 0, end; begin < key_count; begin = end) {
        component_health *k = &x->h->components[x->keys[begin] >> 32];
        for (end = begin; end < key_count && x->keys[end] == x->keys[begin];) end++;
        k->vertices++;
        k->nonmanifold_vertices += end - begin > 1;
    }

    count_holes(x);

    if (progress) progress("triangles");
    measure(x);
    if (progress) progress("intersections");
    return examine_intersections(x);
}

vxs_result mesh_health_examine(mesh_health *h, const casters *c, void (*progress)(const char *what), run_context *m)
{
    *h             = (mesh_health){.collapsed_triangles = c->collapsed_count};
    examination x  = {.h = h, .c = c};
    int         ok = examine(&x, h, c, progress);
    if (ok) {
        component_health *sum = &h->total;
        sum->box_ws           = box_empty();
        sum->closed = sum->orientable = sum->oriented = 1;
        for (size_t i = 0; i < h->count; i++) {
            const component_health *k = &h->components[i];
            box_add(&sum->box_ws, k->box_ws.min);
            box_add(&sum->box_ws, k->box_ws.max);
            for (int n = 0; n < HEALTH_COUNTS; n++) sum->counts[n] += k->counts[n];
            sum->meets += k->meets;
            sum->closed &= k->closed;
            sum->orientable &= k->orientable;
            sum->oriented &= k->oriented;
            if (k->kind == COMPONENT_SOLID) sum->volume_m3 += k->volume_m3;
        }
    }
    scratch_free(&x.memory);
    free(x.pairs);
    if (ok) return VXS_OK;
    mesh_health_free(h);
    return fail(m, VXS_E_MEMORY, "out of memory while examining %zu triangles", c->triangle_count);
}

void mesh_health_free(mesh_health *h)
{
    free(h->components);
    free(h->met);
    *h = (mesh_health){0};
}

int component_faults(const component_health *c)
{
    if (!c->closed || !c->orientable || !c->oriented || c->kind == COMPONENT_SHEET_INWARD) return 2;
    for (int n = HEALTH_FAULTS; n < HEALTH_COUNTS; n++)
        if (c->counts[n]) return 1;
    return 0;
}
