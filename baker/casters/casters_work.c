/* Weld and classify the triangles that cast shadow; see casters.h and casters_work.h.
 *
 *   scene ---weld---> soup ---edges---> components ---measure, classify---> kinds ---emit---> casters
 *
 * Only inside solids may later stages choose freely between lit and shadowed ([CPVS16] 3.3). So a component becomes a solid only if
 * the tests prove it; otherwise it stays a sheet.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/casters/casters.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/array.h"
#include "baker/base/group.h"
#include "baker/base/pages.h"
#include "baker/base/parallel.h"
#include "baker/base/vec3.h"
#include "baker/casters/casters_work.h"
#include "baker/casters/mesh_split.h"

/* --- weld ------------------------------------------------------------------------------------------------------------- */

static vxs_result weld(work *w, const scene *s, run_context *m)
{
    enum { EACH = 4 * sizeof(uint32_t), OF_VERTEX = 3 * sizeof(double) + 5 * sizeof(uint32_t) };
    vxs_result r = check_room(s->triangle_count, EACH, s->vertex_count, OF_VERTEX, m);
    if (r == VXS_OK) r = mesh_weld_scene(&w->mesh, s, w->threads, m);
    if (r != VXS_OK) return r;
    w->holes = s->holed_triangles;
    w->flags = allocate(w->mesh.triangle_count, 1);
    if (s->holed_triangle_count) w->hole_of = allocate(w->mesh.triangle_count, sizeof *w->hole_of);
    if (!w->flags || (s->holed_triangle_count && !w->hole_of)) return out_of_memory(m, s->triangle_count);

    /* set the flags and holes of the remaining triangles; both lists ascend */
    size_t hole = 0;
    for (size_t t = 0; t < w->mesh.triangle_count; t++) {
        uint32_t of = w->mesh.from[t];
        while (hole < s->holed_triangle_count && s->holed_triangles[hole].triangle < of) hole++;
        int has_hole = hole < s->holed_triangle_count && s->holed_triangles[hole].triangle == of;
        w->flags[t]  = s->triangle_flags[of] & (TRIANGLE_DOUBLE_SIDED | TRIANGLE_ALPHA_MASK);
        if (has_hole) w->flags[t] |= TRIANGLE_ALPHA_MASK;
        if (w->hole_of) w->hole_of[t] = has_hole ? (uint32_t)hole : NONE;
    }
    return VXS_OK;
}

/* --- edges ------------------------------------------------------------------------------------------------------------ */

typedef struct edges {
    work     *of;
    uint32_t *sorted; /* [3 * triangle_count] from mesh_sort_edges */
    int       open;   /* 1: some edge is open */
} edges;

static void start_components(void *user, size_t begin, size_t end, uint32_t worker)
{
    work *w = user;
    (void)worker;
    for (size_t t = begin; t < end; t++) w->component_of[t] = (uint32_t)t;
    if (w->edge_mates) memset(w->edge_mates + 3 * begin, 0xff, 3 * (end - begin) * sizeof *w->edge_mates);
}

/* Join the triangles of an edge. Mark one of them if the edge is not used equally often in both directions. An edge of four or six
 * faces may be balanced: two boxes that touch along an edge are still two closed boxes. */
static void take_edge(void *user, uint32_t begin, uint32_t end)
{
    edges          *e      = user;
    work           *w      = e->of;
    const uint32_t *sorted = e->sorted, first = sorted[begin];
    for (uint32_t i = begin + 1; i < end; i++) mesh_join(w->component_of, first / 3, sorted[i] / 3);
    if (mesh_edge_balance(w->mesh.indices, sorted, begin, end)) {
        __atomic_fetch_or(&w->flags[first / 3], EDGE_OPEN, __ATOMIC_RELAXED);
        __atomic_store_n(&e->open, 1, __ATOMIC_RELAXED);
    } else if (end - begin == 2 && w->edge_mates) {
        w->edge_mates[first]             = sorted[begin + 1];
        w->edge_mates[sorted[begin + 1]] = first;
    }
}

/* Store the half-edges of all open edges. Returns 0 without memory. */
static int gather_border(work *w, const uint32_t *sorted)
{
    uint32_t edge_count = (uint32_t)(3 * w->mesh.triangle_count);
    for (uint32_t begin = 0, end; begin < edge_count; begin = end) {
        end = mesh_edge_run(w->mesh.indices, sorted, begin, edge_count);
        if (!mesh_edge_balance(w->mesh.indices, sorted, begin, end)) continue;
        if (!array_reserve(&w->border, &w->border_capacity, w->border_count + end - begin, sizeof *w->border)) return 0;
        memcpy(w->border + w->border_count, sorted + begin, (end - begin) * sizeof *sorted);
        w->border_count += end - begin;
    }
    return 1;
}

static vxs_result connect(work *w, int for_maps, run_context *m)
{
    enum { EACH = 10 * sizeof(uint32_t), OF_VERTEX = sizeof(uint32_t) };
    const mesh_weld *mesh = &w->mesh;
    if (check_room(mesh->triangle_count, EACH, mesh->vertex_count, OF_VERTEX, m) != VXS_OK) return VXS_E_MEMORY;
    edges      e = {w, pages_alloc(3 * mesh->triangle_count * sizeof *e.sorted), 0};
    vxs_result r = VXS_E_MEMORY;
    if (e.sorted) r = mesh_sort_edges(e.sorted, mesh->indices, mesh->triangle_count, mesh->vertex_count, w->threads);
    w->component_of = pages_alloc(mesh->triangle_count * sizeof *w->component_of);
    w->edge_mates   = for_maps ? pages_alloc(3 * mesh->triangle_count * sizeof *w->edge_mates) : NULL;
    if (!w->component_of || (for_maps && !w->edge_mates)) r = VXS_E_MEMORY;
    if (r == VXS_OK) {
        parallel_for(w->threads, mesh->triangle_count, GRAIN, start_components, w);
        mesh_for_each_edge(mesh->indices, e.sorted, mesh->triangle_count, w->threads, take_edge, &e);
        w->component_count = mesh_number_components(w->component_of, mesh->triangle_count, w->threads);
    }
    if (r == VXS_OK && for_maps && e.open && !gather_border(w, e.sorted)) r = VXS_E_MEMORY;
    free(e.sorted);
    return r == VXS_OK ? r : out_of_memory(m, mesh->triangle_count);
}

/* --- measure ---------------------------------------------------------------------------------------------------------- */

static void measure(component *c, box *around, const work *w, const uint32_t *members, uint32_t count)
{
    const double *positions = w->mesh.positions_ws, *origin = positions + 3 * (size_t)w->mesh.indices[3 * (size_t)members[0]];
    double        volume = 0; /* of tetrahedra */
    box           b      = box_empty();
    unsigned      flags  = 0;
    for (uint32_t n = 0; n < count; n++) {
        const uint32_t *corners = w->mesh.indices + 3 * (size_t)members[n];
        double          e[3][3];
        for (int i = 0; i < 3; i++) {
            const double *p = positions + 3 * (size_t)corners[i];
            box_add(&b, p);
            vec3_sub(p, origin, e[i]);
        }
        flags |= w->flags[members[n]];
        volume += (e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) + e[0][1] * (e[1][2] * e[2][0] - e[1][0] * e[2][2]) +
                   e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0])) /
                  6;
    }
    *c      = (component){.triangle_count = count, .flags = (uint8_t)flags, .volume = volume};
    *around = b;
}

static void measure_some(void *user, size_t begin, size_t end, uint32_t worker)
{
    work *w = user;
    (void)worker;
    for (size_t n = begin; n < end; n++)
        measure(&w->components[n], &w->boxes[n], w, w->members + w->first_of[n], w->first_of[n + 1] - w->first_of[n]);
}

static vxs_result measure_components(work *w, const scene *s, run_context *m)
{
    size_t   triangles = w->mesh.triangle_count;
    uint32_t part      = 0;
    w->components      = pages_alloc(w->component_count * sizeof *w->components);
    w->boxes           = pages_alloc(w->component_count * sizeof *w->boxes);
    w->first_of        = pages_alloc((w->component_count + 1) * sizeof *w->first_of);
    w->members         = pages_alloc(triangles * sizeof *w->members);
    if (!w->components || !w->boxes || !w->first_of || !w->members ||
        group_by_key(w->first_of, w->members, w->component_of, triangles, w->component_count, w->threads) != VXS_OK)
        return out_of_memory(m, triangles);

    parallel_for(w->threads, w->component_count, 16, measure_some, w);
    for (size_t t = 0; t < triangles; t++)
        part_span_add(&w->components[w->component_of[t]].parts, part = scene_part_at(s, part, w->mesh.from[t]));
    return VXS_OK;
}

/* Smallest volume that is distinguishable from rounding errors: of the sum, whose terms are products of the three sides of the box,
 * and of the coordinates, which are exact only to the last bit of the largest one. */
static double least_volume(const box *b)
{
    double side[3], longest = 0, reach = 0;
    for (int axis = 0; axis < 3; axis++) {
        side[axis] = b->max[axis] - b->min[axis];
        longest    = fmax(longest, side[axis]);
        reach      = fmax(reach, fmax(fabs(b->min[axis]), fabs(b->max[axis])));
    }
    return 1e-9 * (side[0] * side[1] * side[2]) + 4 * DBL_EPSILON * reach * longest * longest;
}

/* --- classify ------------------------------------------------------------------------------------------------------------ */

/* Classify a component by itself. Occupied components still count as solids here.
 *
 * A positive volume does not exclude that a part is inside out: for example, the smaller one of two lobes joined along an edge.
 * There the winding number is negative: a ray leaves before it enters. Peeling of exit depths counts both, and treats only a
 * positive count as inside, so the volume test is sufficient. Components larger than 1e100, whose volume is not a number, become
 * sheets. */
static component_kind classify(const component *c, const box *b, closed_mode closed)
{
    if (closed == CLOSED_OFF) return COMPONENT_SHEET_FORCED;
    if (c->flags & TRIANGLE_ALPHA_MASK) return COMPONENT_SHEET_ALPHA_MASK;
    if (c->flags & EDGE_OPEN) return COMPONENT_SHEET_OPEN;
    if (closed == CLOSED_ON) return fabs(c->volume) > least_volume(b) ? COMPONENT_SOLID : COMPONENT_SHEET_INWARD;
    if (c->flags & TRIANGLE_DOUBLE_SIDED) return COMPONENT_SHEET_DOUBLE_SIDED;
    return c->volume > least_volume(b) ? COMPONENT_SOLID : COMPONENT_SHEET_INWARD;
}

/* Append a position, unless it is not finite. */
static void add_point(double *points, size_t *count, const double *at_ws)
{
    if (isfinite(at_ws[0]) && isfinite(at_ws[1]) && isfinite(at_ws[2])) memcpy(&points[3 * (*count)++], at_ws, 3 * sizeof *points);
}

/* Positions of lights and cameras; directional lights have none.
 * points  [3 * (light_count + camera_count)] */
static size_t collect_points(double *points, const scene *s)
{
    size_t count = 0;
    for (size_t i = 0; i < s->light_count; i++)
        if (s->lights[i].shape.kind != LIGHT_DIRECTIONAL) add_point(points, &count, s->lights[i].shape.position_ws);
    for (size_t i = 0; i < s->camera_count; i++) add_point(points, &count, &s->camera_positions_ws[3 * i]);
    return count;
}

/* Solids that contain a light, a camera or another component become sheets, because shadows are looked up inside.
 *
 * Copies of a solid: exact copies share their edges, so they form one component, whose winding number is the sum (2 inside when
 * both face outward, 0 when one is reversed). Copies with different vertices contain each other, and all become sheets: this is
 * correct, only larger. */
static vxs_result evict_occupied(work *w, const scene *s, run_context *m)
{
    vxs_result r        = VXS_OK;
    double    *points   = allocate(s->light_count + s->camera_count, 3 * sizeof *points);
    uint8_t   *wanted   = allocate(w->component_count, 1);
    uint8_t   *occupied = allocate(w->component_count, 1);

    if (!points || !wanted || !occupied) {
        r = out_of_memory(m, w->mesh.triangle_count);
        goto done;
    }
    for (size_t i = 0; i < w->component_count; i++) wanted[i] = w->components[i].kind == COMPONENT_SOLID;

    shell_set shells = {.positions_ws = w->mesh.positions_ws,
                        .indices      = w->mesh.indices,
                        .count        = w->component_count,
                        .first        = w->first_of,
                        .members      = w->members,
                        .boxes        = w->boxes,
                        .point_count  = collect_points(points, s),
                        .points       = points};
    if ((r = shells_find_occupied(&shells, wanted, occupied, w->threads)) != VXS_OK) {
        out_of_memory(m, w->mesh.triangle_count);
        goto done;
    }
    for (size_t i = 0; i < w->component_count; i++)
        if (occupied[i]) w->components[i].kind = COMPONENT_SHEET_OCCUPIED;
done:
    free(points);
    free(wanted);
    free(occupied);
    return r;
}

/* --- split ------------------------------------------------------------------------------------------------------------ */

/* Copy per-triangle data to the pieces of each triangle. */
static int spread(work *w, const scene *s, const mesh_split *split)
{
    size_t   count = w->mesh.triangle_count;
    uint8_t *flags = realloc(w->flags, count * sizeof *w->flags);
    if (flags) w->flags = flags;
    uint32_t *component_of = realloc(w->component_of, count * sizeof *w->component_of);
    if (component_of) w->component_of = component_of;
    uint32_t *hole_of = w->hole_of ? realloc(w->hole_of, count * sizeof *w->hole_of) : NULL;
    if (hole_of) w->hole_of = hole_of;
    if (!flags || !component_of || (w->hole_of && !hole_of)) return 0;
    for (size_t t = count; t-- > 0;) { /* backward: no triangle comes before its parent */
        w->flags[t]        = w->flags[split->parents[t]];
        w->component_of[t] = w->component_of[split->parents[t]];
        if (w->hole_of) w->hole_of[t] = w->hole_of[split->parents[t]];
    }
    if (!w->hole_of) return 1;

    /* split triangles with holes get new entries after the scene's, with interpolated image coordinates */
    size_t holes = s->holed_triangle_count;
    if (!(w->own_holes = malloc((holes + split->piece_count) * sizeof *w->own_holes))) return 0;
    memcpy(w->own_holes, s->holed_triangles, holes * sizeof *w->own_holes);
    for (const mesh_piece *p = split->pieces; p < split->pieces + split->piece_count; p++) {
        uint32_t hole = w->hole_of[p->triangle];
        if (hole == NONE) continue;
        const holed_triangle *whole = &s->holed_triangles[hole];
        holed_triangle       *piece = &w->own_holes[w->hole_of[p->triangle] = (uint32_t)holes++];
        *piece                      = (holed_triangle){.triangle = whole->triangle, .mask = whole->mask};
        for (int n = 0; n < 3; n++)
            for (int axis = 0; axis < 2; axis++)
                for (int k = 0; k < 3; k++) piece->uv[n][axis] += (float)(p->weights[n][k] * (double)whole->uv[k][axis]);
    }
    w->holes = w->own_holes;
    return 1;
}

/* Give borders that meet the same vertices. Solids were determined before; they have no borders, so they are not split. A sheet
 * that this step closes stays a sheet: a gap closed by a tolerance does not prove an inside. */
static vxs_result split_borders(work *w, casters *c, const scene *s, run_context *m)
{
    mesh_split split = {0};
    vxs_result r     = VXS_OK;
    if (!w->border_count) return VXS_OK;
    if ((r = mesh_split_borders(&split, &w->mesh, w->border, w->border_count, s, m)) != VXS_OK) return r;
    c->borders = (border_counts){split.open_count, split.split_count, split.left_count, split.added_count, split.joined_count};
    if (split.left_count)
        warn(m, "%zu edges are left as they are, and may let light through where sheets meet: too many of them lie upon each other",
             split.left_count);
    if (split.parents && !spread(w, s, &split)) r = out_of_memory(m, s->triangle_count);
    w->has_unused = split.joined_count != 0;
    if (split.parents || split.joined_count) {
        free(w->edge_mates);
        w->edge_mates = NULL;
    }
    mesh_split_free(&split);
    return r;
}

/* ---------------------------------------------------------------------------------------------------------------------- */

vxs_result casters_none(const scene *s, run_context *m)
{
    if (!s->triangle_count) {
        /* "30 triangles: --exclude node:Door*; 12 triangles: skinned, ..." */
        char   list[640] = "", rule[128];
        size_t used      = 0;
        for (const scene_exclusion *e = s->exclusions; e < s->exclusions + s->exclusion_count && used < sizeof list; e++)
            if (e->triangles)
                used += (size_t)snprintf(list + used, sizeof list - used, "%s%zu triangles: %s", used ? "; " : "", e->triangles,
                                         exclusion_text(rule, e));
        if (used) return fail(m, VXS_E_NO_CASTER, "nothing casts a shadow: all that the scene has is excluded; %s", list);
    }
    if (!s->triangle_count) return fail(m, VXS_E_NO_CASTER, "nothing casts a shadow: the scene has no triangles");
    return fail(m, VXS_E_NO_CASTER, "nothing casts a shadow: each of the scene's %zu triangles collapses to a line or a point",
                s->triangle_count);
}

static vxs_result sort_out(casters *c, const scene *s, closed_mode closed, int for_maps, uint32_t threads, run_context *m)
{
    vxs_result r;
    work       w = {.threads = threads};

    *c = (casters){0};
    if ((r = weld(&w, s, m)) != VXS_OK) goto done;
    c->collapsed_count    = s->triangle_count - w.mesh.triangle_count;
    c->scene_vertex_count = s->vertex_count;
    if (!w.mesh.triangle_count) {
        r = casters_none(s, m);
        goto done;
    }
    if ((r = connect(&w, for_maps, m)) != VXS_OK) goto done;
    if ((r = measure_components(&w, s, m)) != VXS_OK) goto done;
    for (size_t i = 0; i < w.component_count; i++) w.components[i].kind = classify(&w.components[i], &w.boxes[i], closed);
    if ((r = closed == CLOSED_AUTO ? evict_occupied(&w, s, m) : VXS_OK) != VXS_OK) goto done;
    if (for_maps && (r = split_borders(&w, c, s, m)) != VXS_OK) goto done;
    r = casters_emit(c, &w, s, m);
done:
    if (r != VXS_OK) casters_free(c);

    mesh_weld_free(&w.mesh);
    free(w.flags);
    free(w.hole_of);
    free(w.component_of);
    free(w.edge_mates);
    free(w.own_holes);
    free(w.border);
    free(w.components);
    free(w.boxes);
    free(w.first_of);
    free(w.members);

    return r;
}

vxs_result casters_from_scene(casters *c, const scene *s, closed_mode closed, uint32_t threads, run_context *m)
{
    return sort_out(c, s, closed, 0, threads, m);
}

vxs_result casters_for_maps(casters *c, const scene *s, closed_mode closed, uint32_t threads, run_context *m)
{
    return sort_out(c, s, closed, 1, threads, m);
}
