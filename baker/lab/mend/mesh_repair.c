/* Mending components; see mesh_repair.h. After each step that changed the scene a snapshot of it is taken for the next one.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/mend/mesh_repair.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/array.h"
#include "baker/base/box.h"
#include "baker/base/group.h"
#include "baker/base/scratch.h"
#include "baker/base/vec3.h"
#include "baker/casters/casters_cgal.h"
#include "baker/casters/mesh_edges.h"

#define NONE UINT32_MAX

enum {
    COPIES_MAX  = 64, /* an edge with more faces is intentional, not an error of copying */
    BORDERS_MAX = 256 /* around one vertex; with more, holes could be separated only in too long a time */
};

/* The scene between two steps, welded. */
typedef struct snapshot {
    mesh_weld mesh;
    scratch   memory; /* owns the following arrays */
    uint32_t  edge_count;
    uint32_t *sorted;       /* [edge_count] half-edges, sorted so that those of an edge are adjacent: a run */
    uint32_t *faces;        /* [edge_count] number of half-edges of a half-edge's edge */
    uint32_t *component_of; /* [triangles] */
    size_t    component_count;
    uint8_t  *broken; /* [component_count] 1: some edge is unbalanced, and no triangle is alpha-tested */
    uint8_t  *masked; /* [component_count] 1: some triangle is alpha-tested */
} snapshot;

/* Facts about a triangle of the scene. */
typedef struct triangle_note {
    uint32_t origin; /* its component in the original scene; NONE: it was collapsed */
    uint32_t part;   /* of the scene as it was */
    uint8_t  masked; /* 1: alpha-tested */
} triangle_note;

typedef struct repair {
    scene                *s;
    const repair_options *o;
    repair_report        *out;   /* its components: all of the original scene, until sum_up */
    triangle_note        *notes; /* [scene triangles] */
    size_t                note_capacity;
    snapshot              v;
    uint32_t              line[REPAIR_HOLE_EDGES_MAX];       /* vertices along a hole */
    double                points[3 * REPAIR_HOLE_EDGES_MAX]; /* of the line */
    uint32_t              filled[3 * REPAIR_HOLE_EDGES_MAX]; /* triangles, as numbers along the polygon */
} repair;

/* snapshot --------------------------------------------------------------------------------------------------------------------- */

static void snapshot_free(snapshot *v)
{
    mesh_weld_free(&v->mesh);
    scratch_free(&v->memory);
    *v = (snapshot){0};
}

static int64_t edge_balance(const snapshot *v, uint32_t begin, uint32_t end)
{
    return mesh_edge_balance(v->mesh.indices, v->sorted, begin, end);
}

static vxs_result out_of_memory(const repair *x, run_context *m)
{
    return fail(m, VXS_E_MEMORY, "out of memory while repairing %zu triangles", x->s->triangle_count);
}

static vxs_result take_snapshot(repair *x, run_context *m)
{
    snapshot  *v = &x->v;
    vxs_result r;
    snapshot_free(v);
    if ((r = mesh_weld_scene(&v->mesh, x->s, 1, m)) != VXS_OK) return r;
    size_t count    = v->mesh.triangle_count;
    v->edge_count   = (uint32_t)(3 * count);
    v->sorted       = scratch_take(&v->memory, v->edge_count, sizeof *v->sorted);
    v->faces        = scratch_take(&v->memory, v->edge_count, sizeof *v->faces);
    v->component_of = scratch_take(&v->memory, count, sizeof *v->component_of);
    v->broken       = scratch_take(&v->memory, count, sizeof *v->broken);
    v->masked       = scratch_take(&v->memory, count, sizeof *v->masked);
    if (v->memory.missing || mesh_sort_edges(v->sorted, v->mesh.indices, count, v->mesh.vertex_count, 1) != VXS_OK)
        return out_of_memory(x, m);
    for (uint32_t begin = 0, end; begin < v->edge_count; begin = end) {
        end = mesh_edge_run(v->mesh.indices, v->sorted, begin, v->edge_count);
        for (uint32_t i = begin; i < end; i++) v->faces[v->sorted[i]] = end - begin;
    }
    v->component_count = mesh_find_components(v->component_of, v->sorted, v->mesh.indices, count, 1);

    for (uint32_t t = 0; t < v->mesh.triangle_count; t++) v->masked[v->component_of[t]] |= x->notes[v->mesh.from[t]].masked;
    for (uint32_t begin = 0, end; begin < v->edge_count; begin = end) {
        end             = begin + v->faces[v->sorted[begin]];
        uint32_t within = v->component_of[v->sorted[begin] / 3];
        if (edge_balance(v, begin, end) && !v->masked[within]) v->broken[within] = 1;
    }

    return VXS_OK;
}

static int is_broken(const snapshot *v, uint32_t triangle)
{
    return v->broken[v->component_of[triangle]];
}

/* Changes to a triangle are counted for its original component. */
static repaired_component *origin_at(const repair *x, uint32_t triangle)
{
    return &x->out->components[x->notes[x->v.mesh.from[triangle]].origin];
}

static const double *position(const snapshot *v, uint32_t vertex)
{
    return &v->mesh.positions_ws[3 * (size_t)vertex];
}

/* remove ----------------------------------------------------------------------------------------------------------------------- */

/* 1 when the surface continues from a triangle that has `copies` in all: each of its edges has an odd number of other triangles. */
static int goes_on(const snapshot *v, uint32_t t, uint32_t copies)
{
    for (uint32_t h = 3 * t; h < 3 * t + 3; h++)
        if ((v->faces[h] - copies) % 2 == 0) return 0;
    return 1;
}

/* Mark repeated triangles at one edge. Each triangle is handled once, at the edge of its two lowest corners. Of its copies, keep
 * the first one with the winding of the majority. If both windings are equally frequent and the surface does not continue, they
 * are walls of closed surfaces that touch: keep all. */
static void find_repeated(const repair *x, uint32_t begin, uint32_t end, uint8_t *removed)
{
    const snapshot *v       = &x->v;
    const uint32_t *indices = v->mesh.indices;
    for (uint32_t i = begin; i < end && end - begin <= COPIES_MAX; i++) {
        uint32_t h = v->sorted[i], copies = 0;
        int      more = 0, kept = 0; /* excess of copies with the winding of h */
        if (removed[h / 3] || mesh_edge_opposite(indices, h) < mesh_edge_high(indices, h)) continue;
        for (uint32_t k = begin; k < end; k++) {
            if (mesh_edge_opposite(indices, v->sorted[k]) != mesh_edge_opposite(indices, h)) continue;
            more += indices[v->sorted[k]] == indices[h] ? 1 : -1;
            copies++;
        }
        if (!more && !goes_on(v, h / 3, copies)) continue;
        for (uint32_t k = begin; k < end; k++) {
            uint32_t g = v->sorted[k];
            if (mesh_edge_opposite(indices, g) != mesh_edge_opposite(indices, h)) continue;
            int as_most = (indices[g] == indices[h]) == (more >= 0);
            if (!as_most || kept) removed[g / 3] = 1;
            kept |= as_most;
        }
    }
}

/* Returns the number of triangles to remove. */
static size_t find_removed(repair *x, uint8_t *removed)
{
    const snapshot *v     = &x->v;
    mesh_soup       soup  = {v->mesh.positions_ws, v->mesh.indices, v->mesh.triangle_count};
    size_t          count = 0;
    for (uint32_t begin = 0, end; begin < v->edge_count; begin = end) {
        end = begin + v->faces[v->sorted[begin]];
        if (end - begin > 1 && is_broken(v, v->sorted[begin] / 3)) find_repeated(x, begin, end, removed);
    }
    for (uint32_t t = 0; t < v->mesh.triangle_count; t++) {
        int is_flat = !removed[t] && is_broken(v, t) && mesh_is_flat(&soup, t);
        origin_at(x, t)->removed_repeated += removed[t];
        origin_at(x, t)->removed_zero_area += (uint32_t)is_flat;
        removed[t] |= (uint8_t)is_flat;
        count += removed[t];
    }
    return count;
}

static vxs_result remove_triangles(repair *x, run_context *m)
{
    scratch    memory  = {0};
    uint8_t   *removed = scratch_take(&memory, x->v.mesh.triangle_count, sizeof *removed);
    vxs_result r       = memory.missing ? out_of_memory(x, m) : VXS_OK;
    if (r == VXS_OK && find_removed(x, removed)) {
        scene           *s    = x->s;
        const mesh_weld *mesh = &x->v.mesh;
        size_t           kept = 0, masks = 0, welded = 0, part = 0;
        for (size_t t = 0; t < s->triangle_count; t++) {
            int is_welded = welded < mesh->triangle_count && mesh->from[welded] == t;
            while (part < s->part_count && s->parts[part].triangle_first == t) s->parts[part++].triangle_first = (uint32_t)kept;
            while (masks < s->holed_triangle_count && s->holed_triangles[masks].triangle < t) masks++;
            if (is_welded && removed[welded++]) continue;
            if (masks < s->holed_triangle_count && s->holed_triangles[masks].triangle == t)
                s->holed_triangles[masks++].triangle = (uint32_t)kept;
            memmove(&s->indices[3 * kept], &s->indices[3 * t], 3 * sizeof *s->indices);
            s->triangle_flags[kept] = s->triangle_flags[t];
            x->notes[kept++]        = x->notes[t];
        }
        for (; part < s->part_count; part++) s->parts[part].triangle_first = (uint32_t)kept;
        s->triangle_count = kept;

        r = take_snapshot(x, m);
    }
    scratch_free(&memory);
    return r;
}

/* orient ----------------------------------------------------------------------------------------------------------------------- */

/* A set of triangles connected by edges of two triangles. */
typedef struct patch {
    double area[2];   /* twice the area: with the winding of its first triangle, and with the opposite one */
    double volume;    /* six times the volume, by the winding of the first triangle, relative to its first corner */
    double origin[3]; /* that corner */
    int    started, one_sided;
} patch;

static void measure_patch(const snapshot *v, patch *p, uint32_t t, int turned)
{
    const uint32_t *corners = &v->mesh.indices[3 * (size_t)t];
    const double   *a = position(v, corners[0]), *b = position(v, corners[1]), *c = position(v, corners[2]);
    double          ab[3], ac[3], normal[3], from_origin[3];
    if (!p->started) memcpy(p->origin, a, sizeof p->origin);
    p->started = 1;
    vec3_sub(b, a, ab);
    vec3_sub(c, a, ac);
    vec3_cross(ab, ac, normal);
    vec3_sub(a, p->origin, from_origin);
    p->area[turned] += sqrt(vec3_dot(normal, normal));
    p->volume += (turned ? -1 : 1) * vec3_dot(from_origin, normal);
}

/* 1 to turn the triangles with the winding of the first one, 0 to turn the others. */
static int first_is_wrong(const patch *p)
{
    double all = p->area[0] + p->area[1];
    if (p->area[0] >= REPAIR_MAJORITY * all) return 0;
    if (p->area[1] >= REPAIR_MAJORITY * all) return 1;
    return p->volume < 0;
}

static vxs_result orient(repair *x, run_context *m)
{
    const snapshot *v         = &x->v;
    size_t          triangles = v->mesh.triangle_count, count = 0;
    scratch         memory  = {0};
    uint32_t       *parents = scratch_take(&memory, triangles, sizeof *parents);
    uint8_t        *turned  = scratch_take(&memory, triangles, sizeof *turned);
    patch          *patches = scratch_take(&memory, triangles, sizeof *patches); /* used at roots */
    vxs_result      r       = memory.missing ? out_of_memory(x, m) : VXS_OK;
    int             is_turned;
    if (r != VXS_OK) goto done;
    for (uint32_t t = 0; t < v->mesh.triangle_count; t++) parents[t] = t;
    for (uint32_t begin = 0, end; begin < v->edge_count; begin = end) {
        end = begin + v->faces[v->sorted[begin]];
        if (end - begin != 2 || !is_broken(v, v->sorted[begin] / 3)) continue;
        uint32_t a = v->sorted[begin] / 3, b = v->sorted[begin + 1] / 3;
        if (!mesh_join_turned(parents, turned, a, b, edge_balance(v, begin, end) != 0)) patches[a].one_sided = 1;
    }
    for (uint32_t t = 0; t < v->mesh.triangle_count; t++) {
        uint32_t root = mesh_find_turned(parents, turned, t, &is_turned);
        if (patches[t].one_sided) patches[root].one_sided = 1;
        measure_patch(v, &patches[root], t, is_turned);
    }
    for (uint32_t t = 0; t < v->mesh.triangle_count; t++) {
        const patch *p     = &patches[mesh_find_turned(parents, turned, t, &is_turned)];
        int          mixed = p->area[0] > 0 && p->area[1] > 0 && !p->one_sided;
        if (!mixed || is_turned != !first_is_wrong(p)) continue;
        uint32_t *corners = &x->s->indices[3 * (size_t)v->mesh.from[t]], second = corners[1];
        corners[1] = corners[2];
        corners[2] = second;
        origin_at(x, t)->turned_triangles++;
        count++;
    }
    if (count) r = take_snapshot(x, m);
done:
    scratch_free(&memory);
    return r;
}

/* fill ------------------------------------------------------------------------------------------------------------------------- */

/* A new triangle. */
typedef struct addition {
    uint32_t corners[3]; /* scene vertices */
    uint32_t beside;     /* the triangle at the hole */
    int      is_first;   /* of its hole */
} addition;

typedef struct filling {
    scratch   memory;     /* of all up to the additions */
    uint32_t *ends_at;    /* [vertices + 1] border half-edges that end at vertex v are at[ends_at[v]] .. at[ends_at[v + 1] - 1] */
    uint32_t *at;         /* [half-edges] */
    uint8_t  *used;       /* [half-edges] */
    uint32_t *on_path;    /* [vertices] position on the path plus 1, or 0 */
    uint32_t *path;       /* [half-edges] half-edges, in reverse direction */
    uint32_t *vertex_of;  /* [vertices] a vertex of the scene at its position */
    uint8_t  *stays_open; /* [component_count] 1: it has other faults than holes, or too large holes */
    box      *boxes;      /* [component_count] */
    addition *added;      /* [added_count] */
    size_t    added_count, added_capacity;
    int       no_memory;
} filling;

/* Group border half-edges by the vertex where they end. Components with other unbalanced edges stay open.
 * ends  [half-edges] scratch */
static vxs_result gather_borders(const snapshot *v, filling *f, uint32_t *ends)
{
    uint32_t *borders = f->path; /* which is empty so far */
    size_t    count   = 0;
    for (uint32_t t = 0; t < v->mesh.triangle_count; t++)
        if (!is_broken(v, t)) f->stays_open[v->component_of[t]] = 1;
    for (uint32_t begin = 0, end; begin < v->edge_count; begin = end) {
        end        = begin + v->faces[v->sorted[begin]];
        uint32_t h = v->sorted[begin];
        if (end - begin > 1 && edge_balance(v, begin, end)) f->stays_open[v->component_of[h / 3]] = 1;
        if (end - begin > 1 || !is_broken(v, h / 3)) continue;
        ends[count]      = mesh_edge_end(v->mesh.indices, h);
        borders[count++] = h;
    }
    vxs_result r = group_by_key(f->ends_at, f->at, ends, count, v->mesh.vertex_count, 1);
    for (size_t i = 0; i < count && r == VXS_OK; i++) f->at[i] = borders[f->at[i]];
    return r;
}

/* Fill a hole with triangles, into x->filled, opposite to its half-edges. Returns 0 when the hole must not or cannot be filled. */
static int triangulate(repair *x, const filling *f, const uint32_t *edges, size_t count)
{
    const snapshot *v      = &x->v;
    box             bounds = box_empty();
    if (count > x->o->hole_edges_max || count > REPAIR_HOLE_EDGES_MAX || count < 3) return 0;
    for (size_t i = 0; i < count; i++) {
        x->line[i]      = mesh_edge_end(v->mesh.indices, edges[i]);
        const double *p = position(v, x->line[i]);
        memcpy(&x->points[3 * i], p, 3 * sizeof *p);
        box_add(&bounds, p);
    }
    double diameter = box_diagonal(&bounds), whole = box_diagonal(&f->boxes[v->component_of[edges[0] / 3]]);
    if ((diameter > x->o->hole_diameter_metres || diameter > REPAIR_HOLE_SHARE * whole) && !mesh_is_crack(x->points, count))
        return 0;
    return mesh_fill_hole(x->points, count, x->filled);
}

/* Record a hole, or an open path, by its half-edges. It counts as left until all of its component is filled. */
static void add_hole(repair *x, filling *f, const uint32_t *edges, size_t count, int closes)
{
    uint32_t beside     = edges[0] / 3;
    uint8_t *stays_open = &f->stays_open[x->v.component_of[beside]];
    origin_at(x, beside)->left_holes++;
    if (!*stays_open) *stays_open = !closes || !triangulate(x, f, edges, count);
    if (*stays_open) return;
    f->no_memory |= !array_reserve(&f->added, &f->added_capacity, f->added_count + count - 2, sizeof *f->added);
    for (size_t i = 0; i < count - 2 && !f->no_memory; i++) {
        addition *a = &f->added[f->added_count++];
        *a          = (addition){.beside = beside, .is_first = !i};
        for (size_t k = 0; k < 3; k++) a->corners[k] = f->vertex_of[x->line[x->filled[3 * i + k]]];
    }
}

/* Follow a border from a half-edge. When the path returns to a vertex, split off the loop since then as its own hole, so that no
 * hole touches itself. */
static void follow_border(repair *x, filling *f, uint32_t first)
{
    const uint32_t *indices = x->v.mesh.indices;
    size_t          length  = 0;
    for (uint32_t h = first;;) {
        uint32_t from = mesh_edge_end(indices, h), to = indices[h];
        f->used[h]        = 1;
        f->path[length++] = h;
        f->on_path[from]  = (uint32_t)length; /* its place, plus 1 */
        if (f->on_path[to]) {
            size_t begin = f->on_path[to] - 1;
            add_hole(x, f, &f->path[begin], length - begin, 1);
            for (size_t i = begin; i < length; i++) f->on_path[mesh_edge_end(indices, f->path[i])] = 0;
            length = begin;
        }
        uint32_t next = NONE, tried = 0;
        for (uint32_t i = f->ends_at[to]; i < f->ends_at[to + 1] && next == NONE && tried < BORDERS_MAX; i++, tried++)
            if (!f->used[f->at[i]] && x->v.component_of[f->at[i] / 3] == x->v.component_of[h / 3]) next = f->at[i];
        if (next == NONE) break;
        h = next;
    }
    if (length) add_hole(x, f, f->path, length, 0); /* windings differ there */
    for (size_t i = 0; i < length; i++) f->on_path[mesh_edge_end(indices, f->path[i])] = 0;
}

/* Append the new triangles to the scene. */
static int append(repair *x, const filling *f)
{
    scene *s     = x->s;
    size_t count = s->triangle_count + f->added_count, indices_held = s->triangle_count, flags_held = s->triangle_count;
    size_t parts_held = s->part_count;
    if (!array_reserve(&s->indices, &indices_held, count, 3 * sizeof *s->indices) ||
        !array_reserve(&s->triangle_flags, &flags_held, count, sizeof *s->triangle_flags) ||
        !array_reserve(&x->notes, &x->note_capacity, count, sizeof *x->notes) ||
        (s->part_count && !array_reserve(&s->parts, &parts_held, s->part_count + f->added_count, sizeof *s->parts)))
        return 0;
    for (size_t i = 0; i < f->added_count; i++) {
        size_t   t    = s->triangle_count++;
        uint32_t like = x->v.mesh.from[f->added[i].beside];
        memcpy(&s->indices[3 * t], f->added[i].corners, sizeof f->added[i].corners);
        s->triangle_flags[t] = s->triangle_flags[like];
        x->notes[t]          = (triangle_note){x->notes[like].origin, x->notes[like].part, 0};
        if (!s->part_count) continue; /* it came from no file */
        s->parts[s->part_count]                  = s->parts[x->notes[t].part];
        s->parts[s->part_count++].triangle_first = (uint32_t)t;
    }
    return 1;
}

static vxs_result fill(repair *x, run_context *m)
{
    const snapshot *v    = &x->v;
    filling         f    = {0};
    vxs_result      r    = VXS_E_MEMORY;
    uint32_t       *ends = scratch_take(&f.memory, v->edge_count, sizeof *ends);

    scratch *memory = &f.memory;
    f.ends_at       = scratch_take(memory, v->mesh.vertex_count + 1, sizeof *f.ends_at);
    f.at            = scratch_take(memory, v->edge_count, sizeof *f.at);
    f.used          = scratch_take(memory, v->edge_count, sizeof *f.used);
    f.on_path       = scratch_take(memory, v->mesh.vertex_count, sizeof *f.on_path);
    f.path          = scratch_take(memory, v->edge_count, sizeof *f.path);
    f.vertex_of     = scratch_take(memory, v->mesh.vertex_count, sizeof *f.vertex_of);
    f.stays_open    = scratch_take(memory, v->component_count, sizeof *f.stays_open);
    f.boxes         = scratch_take(memory, v->component_count, sizeof *f.boxes);
    if (memory->missing) goto done;

    for (size_t i = 0; i < x->s->vertex_count; i++)
        if (v->mesh.welded_of[i] != NONE) f.vertex_of[v->mesh.welded_of[i]] = (uint32_t)i;
    if (gather_borders(v, &f, ends) != VXS_OK) goto done;
    for (size_t i = 0; i < v->component_count; i++) f.boxes[i] = box_empty();
    for (size_t i = 0; i < v->edge_count; i++) box_add(&f.boxes[v->component_of[i / 3]], position(v, v->mesh.indices[i]));
    for (size_t i = 0; i < f.ends_at[v->mesh.vertex_count]; i++)
        if (!f.used[f.at[i]]) follow_border(x, &f, f.at[i]);

    /* discard the triangles for components that stay open, and count the others */
    size_t kept = 0;
    for (size_t i = 0; i < f.added_count; i++) {
        addition            a      = f.added[i];
        repaired_component *origin = origin_at(x, a.beside);
        if (f.stays_open[v->component_of[a.beside]]) continue;
        f.added[kept++] = a;
        origin->added_triangles++;
        origin->filled_holes += (uint32_t)a.is_first;
        origin->left_holes -= (uint32_t)a.is_first;
    }
    f.added_count = kept;
    if (f.no_memory || (f.added_count && !append(x, &f))) goto done;
    r = f.added_count ? take_snapshot(x, m) : VXS_OK;
done:
    scratch_free(&f.memory);
    free(f.added);
    return r == VXS_E_MEMORY ? out_of_memory(x, m) : r; /* the first message stays */
}

/* report ----------------------------------------------------------------------------------------------------------------------- */

static int is_closed(const snapshot *v, uint32_t triangle)
{
    return !is_broken(v, triangle) && !v->masked[v->component_of[triangle]];
}

/* Record the components of the original scene. */
static vxs_result start(repair *x, run_context *m)
{
    const scene *s = x->s;
    if (!array_reserve(&x->notes, &x->note_capacity, s->triangle_count, sizeof *x->notes)) return out_of_memory(x, m);
    uint32_t part = 0;
    for (size_t t = 0; t < s->triangle_count; t++) {
        part        = scene_part_at(s, part, t);
        x->notes[t] = (triangle_note){NONE, part, (s->triangle_flags[t] & TRIANGLE_ALPHA_MASK) != 0};
    }
    for (size_t i = 0; i < s->holed_triangle_count; i++) x->notes[s->holed_triangles[i].triangle].masked = 1;

    vxs_result r = take_snapshot(x, m);
    if (r != VXS_OK) return r;
    const snapshot *v       = &x->v;
    x->out->component_count = v->component_count;
    x->out->components      = calloc(v->component_count + 1, sizeof *x->out->components);
    if (!x->out->components) return out_of_memory(x, m);
    for (uint32_t t = 0; t < v->mesh.triangle_count; t++) {
        repaired_component *c            = &x->out->components[v->component_of[t]];
        x->notes[v->mesh.from[t]].origin = v->component_of[t];
        if (!c->triangles++) c->triangle = v->mesh.from[t];
        part_span_add(&c->parts, x->notes[v->mesh.from[t]].part);
        c->closed_before = (uint8_t)is_closed(v, t);
    }
    return VXS_OK;
}

vxs_result scene_repair(scene *s, const repair_options *o, repair_report *out, run_context *m)
{
    repair     x = {.s = s, .o = o, .out = out};
    vxs_result r;

    *out = (repair_report){0};
    if ((r = start(&x, m)) != VXS_OK) goto done;
    if ((r = remove_triangles(&x, m)) != VXS_OK) goto done;
    if ((r = orient(&x, m)) != VXS_OK) goto done;
    if ((r = fill(&x, m)) != VXS_OK) goto done;
    s->origin_count = 0; /* the order of triangles has changed, and new ones belong to no node */

    /* of a component that fell apart, closed_after requires that all parts are closed */
    for (size_t i = 0; i < x.out->component_count; i++) {
        repaired_component *c = &x.out->components[i];
        c->closed_after       = c->triangles > c->removed_repeated + c->removed_zero_area;
    }
    for (uint32_t t = 0; t < x.v.mesh.triangle_count; t++)
        if (!is_closed(&x.v, t)) origin_at(&x, t)->closed_after = 0;

    /* keep only components with something to report */
    for (size_t i = 0; i < out->component_count; i++) {
        const repaired_component c        = out->components[i];
        uint32_t                 findings = 0;
        out->closed_before += c.closed_before;
        out->closed_after += c.closed_after;
        out->total.triangles += c.triangles;
        for (int n = 0; n < REPAIR_COUNTS; n++) {
            out->total.counts[n] += c.counts[n];
            findings |= c.counts[n];
        }
        if (findings) out->components[out->count++] = c;
    }

done:
    if (r != VXS_OK) repair_report_free(out);
    snapshot_free(&x.v);
    free(x.notes);
    return r;
}

void repair_report_free(repair_report *r)
{
    free(r->components);
    *r = (repair_report){0};
}
