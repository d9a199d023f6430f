/* Welding and splitting borders; see mesh_split.h.
 *
 *   border ---collect---> points ---weld---> indices ---find---> cuts of edges ---cut---> pieces
 *
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/casters/mesh_split.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/array.h"
#include "baker/base/vec3.h"
#include "baker/casters/mesh_edges.h"
#include "baker/casters/point_tree.h"

#define NONE UINT32_MAX

/* Limits per open edge, on average: visits of nodes and points, and cuts. Real scenes need a few dozen visits. A degenerate mesh of
 * collinear edges, where each edge ends on all others, would need a quadratic number. */
enum { VISITS_PER_EDGE = 512, VISITS_LEAST = 1 << 20, CUTS_PER_EDGE = 4, CUTS_LEAST = 1 << 16 };

/* A vertex on an edge. */
typedef struct cut {
    uint32_t vertex;
    double   share; /* position along the edge from its lower to its higher vertex */
} cut;

/* The cuts of one half-edge. */
typedef struct cut_edge {
    uint32_t half_edge;
    size_t   first, end; /* in cuts */
} cut_edge;

typedef struct splitter {
    mesh_split     *out;
    mesh_weld      *mesh;
    const uint32_t *border;
    size_t          border_count;
    const scene    *scene;

    uint32_t  *slot_of; /* [vertex_count] index of its point, or NONE: not on a border */
    point_tree tree;
    uint32_t  *target_of; /* [points] the point that it is merged into, or itself */

    size_t    cut_count, cut_capacity, cut_edge_count, cut_edge_capacity;
    cut      *cuts;
    cut_edge *cut_edges;

    size_t    made_count;
    uint32_t *made; /* [3 * made_count] triangles after splitting */
} splitter;

static const double *position(const splitter *x, uint32_t vertex)
{
    return &x->mesh->positions_ws[3 * (size_t)vertex];
}

static tree_point *point_of(const splitter *x, uint32_t vertex)
{
    return &x->tree.points[x->slot_of[vertex]];
}

static double distance2(const double *a, const double *b)
{
    double way[3];
    vec3_sub(a, b, way);
    return vec3_dot(way, way);
}

/* --- points ------------------------------------------------------------------------------------------------------------ */

/* Origin of a triangle of the scene; NULL: unknown. */
static const scene_origin *origin_at(const scene *s, uint32_t triangle)
{
    size_t low = 0, high = s->origin_count;
    if (!high) return NULL;
    while (high - low > 1) {
        size_t middle = low + (high - low) / 2;
        if (s->origins[middle].triangle_first <= triangle)
            low = middle;
        else
            high = middle;
    }
    return &s->origins[low];
}

/* Collect the ends of open edges once each, with the largest tolerance of their edges. */
static int collect_points(splitter *x)
{
    tree_point *points = malloc((2 * x->border_count + 1) * sizeof *points);
    size_t      count  = 0;
    x->slot_of         = malloc((x->mesh->vertex_count + 1) * sizeof *x->slot_of);
    x->tree.points     = points;
    if (!points || !x->slot_of) return 0;
    memset(x->slot_of, 0xff, x->mesh->vertex_count * sizeof *x->slot_of);
    for (size_t n = 0; n < x->border_count; n++) {
        uint32_t      h = x->border[n], ends[2] = {x->mesh->indices[h], mesh_edge_end(x->mesh->indices, h)};
        const double *at[2] = {position(x, ends[0]), position(x, ends[1])};

        /* Tolerance along an edge, for its end with the larger rounding error. */
        const scene_origin *from    = origin_at(x->scene, x->mesh->from[h / 3]);
        double              largest = 0, farthest2 = 0, way[3];
        int                 exponent;
        for (int k = 0; k < 2; k++) {
            for (int axis = 0; axis < 3; axis++) largest = fmax(largest, fabs(at[k][axis]));
            if (from) {
                vec3_sub(at[k], from->at_ws, way);
                farthest2 = fmax(farthest2, vec3_dot(way, way));
            }
        }
        frexp(sqrt(farthest2), &exponent);
        double reach = fmax(32 * DBL_EPSILON * largest, from ? MESH_SPLIT_STEPS * ldexp(1, exponent - FLT_MANT_DIG) : 0);

        for (int k = 0; k < 2; k++) {
            uint32_t *slot = &x->slot_of[ends[k]];
            if (*slot == NONE) points[ *slot = (uint32_t)count++] = (tree_point){{at[k][0], at[k][1], at[k][2]}, 0, ends[k]};
            points[*slot].reach = fmax(points[*slot].reach, reach);
        }
    }
    uint64_t visits = VISITS_LEAST + VISITS_PER_EDGE * (uint64_t)x->border_count;
    if (!point_tree_init(&x->tree, points, count, visits)) return 0;
    for (size_t n = 0; n < count; n++) x->slot_of[points[n].name] = (uint32_t)n;
    return 1;
}

/* --- welding ----------------------------------------------------------------------------------------------------------- */

/* 1 when two points are within the larger of their tolerances. */
static int is_same_place(const tree_point *a, const tree_point *b)
{
    double reach = fmax(a->reach, b->reach);
    return distance2(a->at, b->at) <= reach * reach;
}

typedef struct weld_search {
    splitter *x;
    size_t    at;
    int       found;
} weld_search;

static int find_another(void *user, size_t point)
{
    weld_search *s = user;
    s->found       = point != s->at && is_same_place(&s->x->tree.points[point], &s->x->tree.points[s->at]);
    return s->found;
}

/* Merge a point within tolerance that has no cluster yet into the cluster of s->at. */
static int take_place(void *user, size_t point)
{
    weld_search *s = user;
    splitter    *x = s->x;
    if (x->target_of[point] == NONE && is_same_place(&x->tree.points[point], &x->tree.points[s->at])) {
        x->target_of[point] = (uint32_t)s->at;
        s->found++;
    }
    return 0;
}

static int search_about(splitter *x, size_t point, point_tree_visitor *visit, weld_search *s)
{
    const tree_point *p = &x->tree.points[point];
    *s                  = (weld_search){x, point, 0};
    return point_tree_search(&x->tree, p->at, p->at, (double[]){p->reach, p->reach, p->reach}, visit, s);
}

/* By tolerance, then by position: independent of the order in the file. */
static int compare_points(const void *a, const void *b)
{
    const tree_point *p = *(const tree_point *const *)a, *q = *(const tree_point *const *)b;
    if (p->reach != q->reach) return p->reach < q->reach ? -1 : 1;
    for (int axis = 0; axis < 3; axis++)
        if (p->at[axis] != q->at[axis]) return p->at[axis] < q->at[axis] ? -1 : 1;
    return 0;
}

/* Cluster the points that have neighbours, from the smallest tolerance on: each point without a cluster starts one and takes the
 * near points without a cluster. */
static int weld_points(splitter *x)
{
    size_t             crowd = 0, moved = 0;
    const tree_point **crowded = malloc((x->tree.count + 1) * sizeof *crowded);
    weld_search        s       = {0};
    x->target_of               = malloc((x->tree.count + 1) * sizeof *x->target_of);
    int ok                     = crowded && x->target_of;
    if (!ok) goto done;
    for (size_t n = 0; n < x->tree.count; n++) {
        x->target_of[n] = (uint32_t)n;
        if (search_about(x, n, find_another, &s) && s.found) crowded[crowd++] = &x->tree.points[n];
    }
    qsort(crowded, crowd, sizeof *crowded, compare_points);
    for (size_t n = 0; n < crowd; n++) x->target_of[crowded[n] - x->tree.points] = NONE;
    for (size_t n = 0; n < crowd; n++) {
        size_t at = (size_t)(crowded[n] - x->tree.points);
        if (x->target_of[at] != NONE) continue;
        x->target_of[at] = (uint32_t)at;
        search_about(x, at, take_place, &s);
        moved += (size_t)s.found;
    }
    if (moved) {
        /* Undo merges that would collapse a triangle: if two of its corners would merge, both stay. */
        const uint32_t *indices = x->mesh->indices;
        for (size_t h = 0; h < 3 * x->mesh->triangle_count; h++) {
            uint32_t p = x->slot_of[indices[h]], q = x->slot_of[mesh_edge_end(indices, (uint32_t)h)];
            if (p == NONE || q == NONE || x->target_of[p] != x->target_of[q]) continue;
            x->target_of[p] = p;
            x->target_of[q] = q;
        }

        for (size_t h = 0; h < 3 * x->mesh->triangle_count; h++) {
            uint32_t p = x->slot_of[x->mesh->indices[h]];
            if (p != NONE) x->mesh->indices[h] = x->tree.points[x->target_of[p]].name;
        }
        for (size_t n = 0; n < x->tree.count; n++) x->out->joined_count += x->target_of[n] != n;
    }
done:
    free(crowded);
    return ok;
}

/* --- cuts -------------------------------------------------------------------------------------------------------------- */

typedef struct edge_search {
    splitter         *x;
    const tree_point *low, *high;
    double            step[3], length2;
    int               out_of_memory;
} edge_search;

/* Add a cut for a point that lies on the edge and is not an end of it. */
static int add_cut(void *user, size_t point)
{
    edge_search      *s = user;
    splitter         *x = s->x;
    const tree_point *p = &x->tree.points[point];
    double            from_low[3], on_edge[3];
    if (x->target_of[point] != point || p == s->low || p == s->high) return 0;
    vec3_sub(p->at, s->low->at, from_low);
    double share = vec3_dot(from_low, s->step) / s->length2;
    if (!(share > 0 && share < 1)) return 0;
    double reach = fmax(p->reach, s->low->reach + share * (s->high->reach - s->low->reach)), reach2 = reach * reach;
    vec3_mad(s->low->at, share, s->step, on_edge);
    if (distance2(p->at, on_edge) > reach2 || distance2(p->at, s->low->at) <= reach2 || distance2(p->at, s->high->at) <= reach2)
        return 0;
    if ((s->out_of_memory = !array_reserve(&x->cuts, &x->cut_capacity, x->cut_count + 1, sizeof *x->cuts))) return 1;
    x->cuts[x->cut_count++] = (cut){p->name, share};
    return 0;
}

static int compare_cuts(const void *a, const void *b)
{
    const cut *p = a, *q = b;
    if (p->share != q->share) return p->share < q->share ? -1 : 1;
    return (p->vertex > q->vertex) - (p->vertex < q->vertex);
}

/* Find the cuts of an edge, sorted from its lower to its higher vertex. Returns 0 without memory. */
static int find_cuts(splitter *x, uint32_t h, int *is_complete)
{
    const uint32_t *indices = x->mesh->indices;
    edge_search     s = {.x = x, .low = point_of(x, mesh_edge_low(indices, h)), .high = point_of(x, mesh_edge_high(indices, h))};
    size_t          first = x->cut_count;
    vec3_sub(s.high->at, s.low->at, s.step);
    s.length2    = vec3_dot(s.step, s.step);
    double reach = fmax(s.low->reach, s.high->reach);
    *is_complete = point_tree_search(&x->tree, s.low->at, s.high->at, (double[]){reach, reach, reach}, add_cut, &s) &&
                   x->cut_count <= CUTS_LEAST + CUTS_PER_EDGE * x->border_count;
    if (!*is_complete) x->cut_count = first;
    if (x->cut_count > first + 1) qsort(x->cuts + first, x->cut_count - first, sizeof *x->cuts, compare_cuts);
    return !s.out_of_memory;
}

/* Process all open edges in order. When the limit of work is reached, the remaining edges stay as they are. */
static int find_all_cuts(splitter *x)
{
    const uint32_t *indices     = x->mesh->indices;
    int             is_complete = 1;
    for (size_t begin = 0, end; begin < x->border_count; begin = end) {
        size_t first = x->cut_count;
        for (end = begin + 1; end < x->border_count && mesh_same_edge(indices, x->border[begin], x->border[end]);) end++;
        x->out->open_count++;
        if (is_complete && !find_cuts(x, x->border[begin], &is_complete)) return 0;
        if (!is_complete) x->out->left_count++;
        if (x->cut_count == first) continue;
        x->out->split_count++;
        if (!array_reserve(&x->cut_edges, &x->cut_edge_capacity, x->cut_edge_count + (end - begin), sizeof *x->cut_edges)) return 0;
        for (size_t n = begin; n < end; n++) x->cut_edges[x->cut_edge_count++] = (cut_edge){x->border[n], first, x->cut_count};
    }
    return 1;
}

static int compare_half_edges(const void *a, const void *b)
{
    uint32_t p = ((const cut_edge *)a)->half_edge, q = ((const cut_edge *)b)->half_edge;
    return (p > q) - (p < q);
}

/* --- pieces ------------------------------------------------------------------------------------------------------------ */

typedef struct corner {
    uint32_t vertex;
    double   weights[3];
} corner;

/* The points on the three sides of a triangle, in the direction of each side. */
typedef struct sides {
    corner *points; /* [first[3]] */
    size_t  first[4], capacity;
} sides;

/* Collect the points of all sides. Returns 0 without memory.
 * e  in and out: the first cut edge that does not belong to a triangle before t */
static int find_sides(const splitter *x, sides *s, uint32_t t, const cut_edge **e)
{
    const uint32_t *indices = x->mesh->indices;
    const cut_edge *end     = x->cut_edges + x->cut_edge_count;
    size_t          count   = 0;
    for (const cut_edge *n = *e; n < end && n->half_edge / 3 == t; n++) count += n->end - n->first;
    if (!array_reserve(&s->points, &s->capacity, count, sizeof *s->points)) return 0;
    for (uint32_t k = 0; k < 3; k++) {
        uint32_t h      = 3 * t + k;
        s->first[k + 1] = s->first[k];
        if (*e == end || (*e)->half_edge != h) continue;
        const cut_edge *cuts  = (*e)++;
        int             rises = indices[h] == mesh_edge_low(indices, h);
        for (size_t n = 0; n < cuts->end - cuts->first; n++) {
            const cut *c = &x->cuts[rises ? cuts->first + n : cuts->end - 1 - n];
            if (c->vertex == mesh_edge_opposite(indices, h)) continue; /* the triangle is degenerate there already */
            corner *p               = &s->points[s->first[k + 1]++];
            double  share           = rises ? c->share : 1 - c->share;
            *p                      = (corner){.vertex = c->vertex};
            p->weights[k]           = 1 - share;
            p->weights[(k + 1) % 3] = share;
        }
    }
    return 1;
}

/* Append a piece of triangle t. Skip it if two corners are equal: there the triangle is as narrow as the tolerance, and one vertex
 * lies on two of its sides. */
static void add_piece(splitter *x, uint32_t t, const corner *a, const corner *b, const corner *c)
{
    if (a->vertex == b->vertex || b->vertex == c->vertex || c->vertex == a->vertex) return;
    uint32_t      at    = (uint32_t)x->made_count++;
    const corner *of[3] = {a, b, c};
    mesh_piece   *piece = &x->out->pieces[x->out->piece_count++];
    piece->triangle     = at;
    for (int n = 0; n < 3; n++) {
        x->made[3 * (size_t)at + (size_t)n] = of[n]->vertex;
        memcpy(piece->weights[n], of[n]->weights, sizeof piece->weights[n]);
    }
    x->out->parents[at] = t;
}

/* Append triangles from `apex` to the segments of side k. */
static void add_fan(splitter *x, const sides *s, uint32_t t, const corner corners[3], uint32_t k, const corner *apex)
{
    const corner *from = &corners[k];
    for (size_t n = s->first[k]; n < s->first[k + 1]; n++) {
        add_piece(x, t, from, &s->points[n], apex);
        from = &s->points[n];
    }
    add_piece(x, t, from, &corners[(k + 1) % 3], apex);
}

/* Append triangle t or its remaining pieces. Returns 0 without memory. */
static int take_triangle(splitter *x, sides *s, uint32_t t, const cut_edge **e)
{
    const uint32_t *v     = &x->mesh->indices[3 * (size_t)t];
    size_t          first = x->made_count;
    if (!find_sides(x, s, t, e)) return 0;
    if (s->first[3]) {
        corner corners[3] = {{v[0], {1, 0, 0}}, {v[1], {0, 1, 0}}, {v[2], {0, 0, 1}}};

        /* Side k, which does not depend on the first corner of the triangle, has points: a fan from the opposite corner to its
         * segments. Points on the other two sides split the outermost triangles of the fan. */
        uint32_t k = mesh_least_corner(x->mesh->positions_ws, v);
        while (s->first[k] == s->first[k + 1]) k = (k + 1) % 3;
        uint32_t      next = (k + 1) % 3, last = (k + 2) % 3;
        const corner *points = s->points + s->first[k], *end = s->points + s->first[k + 1];
        add_fan(x, s, t, corners, last, points);
        for (const corner *p = points + 1; p < end; p++) add_piece(x, t, p - 1, p, &corners[last]);
        add_fan(x, s, t, corners, next, end - 1);
    }
    if (x->made_count > first) return 1;
    memcpy(&x->made[3 * first], v, 3 * sizeof *v);
    x->out->parents[x->made_count++] = t;
    return 1;
}

/* Write all triangles again, with cut ones as pieces. Returns 0 without memory, or when there are too many half-edges for 32
 * bits. */
static int make_triangles(splitter *x)
{
    mesh_weld      *mesh = x->mesh;
    sides           s    = {0};
    const cut_edge *e    = x->cut_edges;
    size_t          most = mesh->triangle_count, pieces = 0;
    qsort(x->cut_edges, x->cut_edge_count, sizeof *x->cut_edges, compare_half_edges);
    for (size_t n = 0; n < x->cut_edge_count; n++) pieces += 1 + x->cut_edges[n].end - x->cut_edges[n].first;
    most += pieces;
    if (most >= NONE / 3) return 0;
    x->made         = malloc(3 * most * sizeof *x->made);
    x->out->parents = malloc(most * sizeof *x->out->parents);
    x->out->pieces  = malloc(pieces * sizeof *x->out->pieces);
    int complete    = x->made && x->out->parents && x->out->pieces;
    for (size_t t = 0; t < mesh->triangle_count && complete; t++) complete = take_triangle(x, &s, (uint32_t)t, &e);
    free(s.points);
    return complete;
}

/* Replace the triangles of the mesh with the new ones. */
static int replace_triangles(splitter *x)
{
    mesh_weld *mesh = x->mesh;
    uint32_t  *from = malloc(x->made_count * sizeof *from);
    if (!from) return 0;
    for (size_t t = 0; t < x->made_count; t++) from[t] = mesh->from[x->out->parents[t]];
    free(mesh->from);
    free(mesh->indices);
    x->out->added_count  = x->made_count - mesh->triangle_count;
    mesh->from           = from;
    mesh->indices        = x->made;
    mesh->triangle_count = x->made_count;
    x->made              = NULL;
    return 1;
}

/* ----------------------------------------------------------------------------------------------------------------------- */

vxs_result mesh_split_borders(mesh_split *out, mesh_weld *w, const uint32_t *border, size_t border_count, const scene *s,
                              run_context *m)
{
    splitter x   = {.out = out, .mesh = w, .border = border, .border_count = border_count, .scene = s};
    *out         = (mesh_split){0};
    int complete = collect_points(&x) && weld_points(&x) && find_all_cuts(&x) &&
                   (!x.cut_edge_count || (make_triangles(&x) && replace_triangles(&x)));
    free(x.tree.points);
    point_tree_free(&x.tree);
    free(x.slot_of);
    free(x.target_of);
    free(x.cuts);
    free(x.cut_edges);
    free(x.made);
    if (complete) return VXS_OK;
    mesh_split_free(out);
    return fail(m, VXS_E_MEMORY, "out of memory while splitting %zu open edges", border_count);
}

void mesh_split_free(mesh_split *split)
{
    free(split->parents);
    free(split->pieces);
    *split = (mesh_split){0};
}
