/* The triangles that cast shadows, welded and told apart; see casters.h.
 *
 *   scene ---weld---> soup ---edges---> components ---measure, judge---> kinds ---emit---> casters
 *
 * Only inside solids may later stages choose freely between lit and shadowed ([CPVS16] 3.3), so a solid has to be shown to
 * be one, and what is not shown stays a sheet.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/casters/casters.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/box.h"
#include "baker/casters/casters_cgal.h"
#include "baker/casters/mesh_edges.h"
#include "baker/casters/mesh_weld.h"

#define NONE UINT32_MAX

enum { EDGE_OPEN = 0x80 }; /* beside the scene's TRIANGLE_* */

typedef struct component {
    uint32_t       triangle_count;
    part_span      parts;
    uint8_t        flags; /* of all its triangles */
    component_kind kind;
    uint32_t       number;    /* in the result */
    double         origin[3]; /* one of its corners: volumes are summed from there, so that large coordinates cancel */
    double         volume;    /* signed: positive when it faces outward */
} component;

/* Everything between the scene and the result; vertex numbers are welded ones. */
typedef struct work {
    mesh_weld mesh;
    uint8_t  *flags;        /* [triangle_count] TRIANGLE_*, EDGE_OPEN */
    uint32_t *hole_of;      /* [triangle_count] which of the scene's holed_triangles, or NONE; NULL: the scene has none */
    uint32_t *component_of; /* [triangle_count] */

    size_t     component_count;
    component *components; /* in the order of their first triangles */
    box       *boxes;      /* [component_count] */
} work;

static void work_free(work *w)
{
    mesh_weld_free(&w->mesh);
    free(w->flags);
    free(w->hole_of);
    free(w->component_of);
    free(w->components);
    free(w->boxes);
}

/* Zeroed; a count of 0 is no failure, as it may be for calloc. */
static void *allocate(size_t count, size_t size)
{
    return calloc(count ? count : 1, size);
}

static vxs_result out_of_memory(message *m, size_t triangle_count)
{
    return fail(m, VXS_E_MEMORY, "out of memory while sorting %zu triangles into solids and sheets", triangle_count);
}

/* --- weld ------------------------------------------------------------------------------------------------------------- */

/* Which of the scene's holed_triangles triangle t is, or NONE. *at runs along them, as t along the triangles. */
static uint32_t find_hole(const scene *s, size_t t, size_t *at)
{
    while (*at < s->holed_triangle_count && s->holed_triangles[*at].triangle < t) ++*at;
    return *at < s->holed_triangle_count && s->holed_triangles[*at].triangle == t ? (uint32_t)*at : NONE;
}

/* The flags and holes of each triangle that is left. */
static void note_materials(work *w, const scene *s)
{
    size_t hole_at = 0;
    for (size_t t = 0; t < w->mesh.triangle_count; t++) {
        uint32_t hole = find_hole(s, w->mesh.from[t], &hole_at);
        w->flags[t]   = s->triangle_flags[w->mesh.from[t]] & (TRIANGLE_DOUBLE_SIDED | TRIANGLE_ALPHA_MASK);
        if (hole != NONE) w->flags[t] |= TRIANGLE_ALPHA_MASK;
        if (w->hole_of) w->hole_of[t] = hole;
    }
}

static vxs_result weld(work *w, const scene *s, message *m)
{
    vxs_result r = mesh_weld_scene(&w->mesh, s, m);
    if (r != VXS_OK) return r;
    w->flags = allocate(w->mesh.triangle_count, 1);
    if (s->holed_triangle_count) w->hole_of = allocate(w->mesh.triangle_count, sizeof *w->hole_of);
    if (!w->flags || (s->holed_triangle_count && !w->hole_of)) return out_of_memory(m, s->triangle_count);
    note_materials(w, s);
    return VXS_OK;
}

/* --- edges ------------------------------------------------------------------------------------------------------------ */

/* Mark a triangle of each edge that is not used equally often in both directions. An edge of four or six faces may well
 * balance: two boxes that touch along an edge are still two closed boxes. */
static void mark_open_edges(work *w, const uint32_t *sorted)
{
    uint32_t edge_count = (uint32_t)(3 * w->mesh.triangle_count);
    for (uint32_t begin = 0, end; begin < edge_count; begin = end) {
        end = mesh_edge_run(w->mesh.indices, sorted, begin, edge_count);
        if (mesh_edge_balance(w->mesh.indices, sorted, begin, end)) w->flags[sorted[begin] / 3] |= EDGE_OPEN;
    }
}

static vxs_result connect(work *w, message *m)
{
    uint32_t *sorted = malloc(3 * w->mesh.triangle_count * sizeof *sorted);
    w->component_of  = malloc(w->mesh.triangle_count * sizeof *w->component_of);
    if (!sorted || !w->component_of ||
        mesh_sort_edges(sorted, w->mesh.indices, w->mesh.triangle_count, w->mesh.vertex_count) != VXS_OK) {
        free(sorted);
        return out_of_memory(m, w->mesh.triangle_count);
    }
    w->component_count = mesh_find_components(w->component_of, sorted, w->mesh.indices, w->mesh.triangle_count);
    mark_open_edges(w, sorted);
    free(sorted);
    return VXS_OK;
}

/* --- measure ---------------------------------------------------------------------------------------------------------- */

static double tetrahedron_volume(const double *o, const double *const p[3])
{
    double e[3][3];
    for (int i = 0; i < 3; i++)
        for (int axis = 0; axis < 3; axis++) e[i][axis] = p[i][axis] - o[axis];
    return (e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) + e[0][1] * (e[1][2] * e[2][0] - e[1][0] * e[2][2]) +
            e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0])) /
           6;
}

static vxs_result measure_components(work *w, const scene *s, message *m)
{
    uint32_t part = 0;
    w->components = allocate(w->component_count, sizeof *w->components);
    w->boxes      = allocate(w->component_count, sizeof *w->boxes);
    if (!w->components || !w->boxes) return out_of_memory(m, w->mesh.triangle_count);

    for (size_t i = 0; i < w->component_count; i++) w->boxes[i] = box_empty();
    for (size_t t = 0; t < w->mesh.triangle_count; t++) {
        const uint32_t *v = &w->mesh.indices[3 * t];
        component      *c = &w->components[w->component_of[t]];
        const double   *p[3];
        for (int i = 0; i < 3; i++) {
            p[i] = &w->mesh.positions_ws[3 * (size_t)v[i]];
            box_add(&w->boxes[w->component_of[t]], p[i]);
        }
        if (!c->triangle_count++) memcpy(c->origin, p[0], sizeof c->origin);
        c->flags |= w->flags[t];
        part_span_add(&c->parts, part = scene_part_at(s, part, w->mesh.from[t]));
        c->volume += tetrahedron_volume(c->origin, p);
    }
    return VXS_OK;
}

/* The least volume that is more than rounding: of the sum, whose terms are products of the box's three sides, and of the
 * coordinates, which are only known to the last bit of the largest. */
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

/* --- judge ------------------------------------------------------------------------------------------------------------ */

/* The kind as far as the component alone shows. Occupied ones are still among the solids.
 *
 * A positive volume does not mean that no part is inside out: of two lobes joined along one edge, the smaller may be. There
 * the winding number is negative: a ray leaves before it enters. The peeling of exit depths counts both and calls only a
 * positive count inside, so the volume is enough here. Sizes beyond 1e100, whose volume is not a number, make sheets. */
static component_kind judge(const component *c, const box *b, closed_mode closed)
{
    if (closed == CLOSED_OFF) return COMPONENT_SHEET_FORCED;
    if (c->flags & TRIANGLE_ALPHA_MASK) return COMPONENT_SHEET_ALPHA_MASK;
    if (c->flags & EDGE_OPEN) return COMPONENT_SHEET_OPEN;
    if (closed == CLOSED_ON) return fabs(c->volume) > least_volume(b) ? COMPONENT_SOLID : COMPONENT_SHEET_INWARD;
    if (c->flags & TRIANGLE_DOUBLE_SIDED) return COMPONENT_SHEET_DOUBLE_SIDED;
    return c->volume > least_volume(b) ? COMPONENT_SOLID : COMPONENT_SHEET_INWARD;
}

/* Append a place; what is nowhere is not inside either. */
static void add_point(double *points, size_t *count, const double *at_ws)
{
    if (isfinite(at_ws[0]) && isfinite(at_ws[1]) && isfinite(at_ws[2])) memcpy(&points[3 * (*count)++], at_ws, 3 * sizeof *points);
}

/* Where lights and cameras are; sunlight comes from nowhere.  points  [3 * (light_count + camera_count)] */
static size_t collect_points(double *points, const scene *s)
{
    size_t count = 0;
    for (size_t i = 0; i < s->light_count; i++)
        if (s->lights[i].shape.kind != LIGHT_DIRECTIONAL) add_point(points, &count, s->lights[i].shape.position_ws);
    for (size_t i = 0; i < s->camera_count; i++) add_point(points, &count, &s->camera_positions_ws[3 * i]);
    return count;
}

/* Solids with something inside become sheets: where a light or a camera is, or another component, shadows are asked for.
 *
 * Copies of a solid: exact ones share their edges, so they are one component, whose winding number is that of both
 * together (2 inside when both face outward, 0 when one is turned). Copies with other vertices lie in each other, and all
 * become sheets: right, only larger. */
static vxs_result evict_occupied(work *w, const scene *s, message *m)
{
    vxs_result r        = VXS_OK;
    double    *points   = allocate(s->light_count + s->camera_count, 3 * sizeof *points);
    uint32_t  *first    = malloc((w->component_count + 1) * sizeof *first);
    uint32_t  *members  = malloc(w->mesh.triangle_count * sizeof *members);
    uint8_t   *wanted   = allocate(w->component_count, 1);
    uint8_t   *occupied = allocate(w->component_count, 1);

    if (!points || !first || !members || !wanted || !occupied) {
        r = out_of_memory(m, w->mesh.triangle_count);
        goto done;
    }
    mesh_group(first, members, w->component_of, w->mesh.triangle_count, w->component_count);
    for (size_t i = 0; i < w->component_count; i++) wanted[i] = w->components[i].kind == COMPONENT_SOLID;

    shell_set shells = {.positions_ws = w->mesh.positions_ws,
                        .indices      = w->mesh.indices,
                        .count        = w->component_count,
                        .first        = first,
                        .members      = members,
                        .boxes        = w->boxes,
                        .point_count  = collect_points(points, s),
                        .points       = points};
    if ((r = shells_find_occupied(&shells, wanted, occupied)) != VXS_OK) {
        out_of_memory(m, w->mesh.triangle_count);
        goto done;
    }
    for (size_t i = 0; i < w->component_count; i++)
        if (occupied[i]) w->components[i].kind = COMPONENT_SHEET_OCCUPIED;
done:
    free(points);
    free(first);
    free(members);
    free(wanted);
    free(occupied);
    return r;
}

static vxs_result judge_components(work *w, const scene *s, closed_mode closed, message *m)
{
    for (size_t i = 0; i < w->component_count; i++) w->components[i].kind = judge(&w->components[i], &w->boxes[i], closed);
    return closed == CLOSED_AUTO ? evict_occupied(w, s, m) : VXS_OK;
}

/* --- emit ------------------------------------------------------------------------------------------------------------- */

static void count_kinds(casters *c, const work *w)
{
    for (size_t i = 0; i < w->component_count; i++) {
        c->component_count[w->components[i].kind]++;
        c->triangles_of_kind[w->components[i].kind] += w->components[i].triangle_count;
    }
}

/* Give components their numbers in the result: solids first. Their own numbers are in the order of their first triangles. */
static void number_by_kind(casters *c, work *w)
{
    size_t next_solid = 0, next_sheet = c->component_count[COMPONENT_SOLID];
    for (size_t i = 0; i < w->component_count; i++) {
        component *k           = &w->components[i];
        k->number              = (uint32_t)(k->kind == COMPONENT_SOLID ? next_solid++ : next_sheet++);
        c->kind_of[k->number]  = (uint8_t)k->kind;
        c->parts_of[k->number] = k->parts;
    }
}

/* A vertex gets its number when it is first used; those of collapsed triangles alone get none. */
static uint32_t emit_vertex(casters *c, const work *w, uint32_t *emitted_as, uint32_t v)
{
    if (emitted_as[v] == NONE) {
        memcpy(&c->positions_ws[3 * c->vertex_count], &w->mesh.positions_ws[3 * (size_t)v], 3 * sizeof *c->positions_ws);
        emitted_as[v] = (uint32_t)c->vertex_count++;
    }
    return emitted_as[v];
}

/* Which corner has the least position, by x, then y, then z. Triangles begin there, wherever a file begins them: rasterizers interpolate
 * from the first corner, and the same surface in another encoding has to give the same depths. */
static unsigned least_corner(const work *w, size_t t)
{
    const uint32_t *v     = &w->mesh.indices[3 * t];
    unsigned        least = 0;
    for (unsigned n = 1; n < 3; n++) {
        const double *a = &w->mesh.positions_ws[3 * (size_t)v[n]], *b = &w->mesh.positions_ws[3 * (size_t)v[least]];
        int           axis = 0;
        while (axis < 2 && a[axis] == b[axis]) axis++;
        if (a[axis] < b[axis]) least = n;
    }
    return least;
}

static int has_holes(const work *w, size_t t)
{
    return w->hole_of && w->hole_of[t] != NONE;
}

/* The casters come in groups: solids, sheets, and the triangles with holes of each alpha mask. */
enum { GROUP_SOLIDS, GROUP_SHEETS, GROUP_MASKS };

static uint32_t group_of(const work *w, const scene *s, size_t t)
{
    if (has_holes(w, t)) return GROUP_MASKS + s->holed_triangles[w->hole_of[t]].mask;
    return w->components[w->component_of[t]].kind == COMPONENT_SOLID ? GROUP_SOLIDS : GROUP_SHEETS;
}

/* Append triangle t of the work to the result. */
static void emit_triangle(casters *c, const work *w, const scene *s, uint32_t *emitted_as, size_t t)
{
    const uint32_t  *from  = &w->mesh.indices[3 * t];
    const component *of    = &w->components[w->component_of[t]];
    size_t           at    = c->triangle_count++;
    unsigned         begin = least_corner(w, t);
    int              turn  = of->kind == COMPONENT_SOLID && of->volume < 0; /* inside out: a solid by --closed on alone */
    for (unsigned n = 0; n < 3; n++) c->indices[3 * at + n] = emit_vertex(c, w, emitted_as, from[(begin + (turn ? 3 - n : n)) % 3]);
    c->component_of[at] = of->number;
    for (unsigned n = 0; n < 3 && has_holes(w, t); n++)
        memcpy(&c->hole_uvs[6 * (at - c->holed_first) + 2 * n], s->holed_triangles[w->hole_of[t]].uv[(begin + n) % 3],
               2 * sizeof *c->hole_uvs);
}

/* Room for the result, which casters_free releases.  first  [GROUP_MASKS + alpha_mask_count + 1] where each group begins */
static int make_room(casters *c, const work *w, const scene *s, const uint32_t *first)
{
    c->positions_ws     = malloc(3 * w->mesh.vertex_count * sizeof *c->positions_ws);
    c->indices          = malloc(3 * w->mesh.triangle_count * sizeof *c->indices);
    c->component_of     = malloc(w->mesh.triangle_count * sizeof *c->component_of);
    c->kind_of          = malloc(w->component_count * sizeof *c->kind_of);
    c->parts_of         = malloc(w->component_count * sizeof *c->parts_of);
    c->alpha_masks      = allocate(s->alpha_mask_count, sizeof *c->alpha_masks);
    c->alpha_mask_first = allocate(s->alpha_mask_count + 1, sizeof *c->alpha_mask_first);
    c->hole_uvs         = allocate(w->mesh.triangle_count - first[GROUP_MASKS], 6 * sizeof *c->hole_uvs);
    if (!c->positions_ws || !c->indices || !c->component_of || !c->kind_of || !c->parts_of || !c->alpha_masks ||
        !c->alpha_mask_first || !c->hole_uvs)
        return 0;

    c->solid_triangle_count = first[GROUP_SHEETS];
    c->holed_first          = first[GROUP_MASKS];
    c->alpha_mask_count     = s->alpha_mask_count;
    c->images               = s->images;
    if (s->alpha_mask_count) memcpy(c->alpha_masks, s->alpha_masks, s->alpha_mask_count * sizeof *c->alpha_masks);
    for (size_t i = 0; i <= s->alpha_mask_count; i++) c->alpha_mask_first[i] = first[GROUP_MASKS + i];
    return 1;
}

static vxs_result emit(casters *c, work *w, const scene *s, message *m)
{
    vxs_result r          = VXS_OK;
    size_t     groups     = GROUP_MASKS + s->alpha_mask_count;
    uint32_t  *emitted_as = malloc(w->mesh.vertex_count * sizeof *emitted_as);
    uint32_t  *group      = malloc(w->mesh.triangle_count * sizeof *group);
    uint32_t  *order      = malloc(w->mesh.triangle_count * sizeof *order);
    uint32_t  *first      = malloc((groups + 1) * sizeof *first);
    if (!emitted_as || !group || !order || !first) {
        r = out_of_memory(m, w->mesh.triangle_count);
        goto done;
    }
    for (size_t t = 0; t < w->mesh.triangle_count; t++) group[t] = group_of(w, s, t);
    mesh_group(first, order, group, w->mesh.triangle_count, groups);
    if (!make_room(c, w, s, first)) {
        r = out_of_memory(m, w->mesh.triangle_count);
        goto done;
    }
    count_kinds(c, w);
    number_by_kind(c, w);
    memset(emitted_as, 0xff, w->mesh.vertex_count * sizeof *emitted_as);
    for (size_t i = 0; i < w->mesh.triangle_count; i++) emit_triangle(c, w, s, emitted_as, order[i]);
done:
    free(emitted_as);
    free(group);
    free(order);
    free(first);
    return r;
}

/* ---------------------------------------------------------------------------------------------------------------------- */

/* "30 triangles: --exclude node:Door*; 12 triangles: skinned, ..." */
static vxs_result all_excluded(const scene *s, message *m)
{
    char   list[640] = "", rule[128];
    size_t used      = 0;
    for (const scene_exclusion *e = s->exclusions; e < s->exclusions + s->exclusion_count && used < sizeof list; e++)
        if (e->triangles)
            used += (size_t)snprintf(list + used, sizeof list - used, "%s%zu triangles: %s", used ? "; " : "", e->triangles,
                                     exclusion_text(rule, e));
    return used ? fail(m, VXS_E_NO_CASTER, "nothing casts a shadow: all that the scene has is excluded; %s", list) : VXS_OK;
}

static vxs_result no_caster(const scene *s, message *m)
{
    if (!s->triangle_count && all_excluded(s, m) != VXS_OK) return VXS_E_NO_CASTER;
    if (!s->triangle_count) return fail(m, VXS_E_NO_CASTER, "nothing casts a shadow: the scene has no triangles");
    return fail(m, VXS_E_NO_CASTER, "nothing casts a shadow: each of the scene's %zu triangles collapses to a line or a point",
                s->triangle_count);
}

vxs_result casters_from_scene(casters *c, const scene *s, closed_mode closed, message *m)
{
    vxs_result r;
    work       w = {0};

    *c = (casters){0};
    if ((r = weld(&w, s, m)) != VXS_OK) goto done;
    c->collapsed_count    = s->triangle_count - w.mesh.triangle_count;
    c->scene_vertex_count = s->vertex_count;
    if (!w.mesh.triangle_count) {
        r = no_caster(s, m);
        goto done;
    }
    if ((r = connect(&w, m)) != VXS_OK) goto done;
    if ((r = measure_components(&w, s, m)) != VXS_OK) goto done;
    if ((r = judge_components(&w, s, closed, m)) != VXS_OK) goto done;
    r = emit(c, &w, s, m);
done:
    if (r != VXS_OK) casters_free(c);
    work_free(&w);
    return r;
}

void casters_free(casters *c)
{
    free(c->positions_ws);
    free(c->indices);
    free(c->component_of);
    free(c->kind_of);
    free(c->parts_of);
    free(c->solid_meets);
    free(c->alpha_masks);
    free(c->alpha_mask_first);
    free(c->hole_uvs);
    *c = (casters){0};
}

const char *component_kind_name(component_kind kind)
{
    static const char *const names[COMPONENT_KINDS] = {
        [COMPONENT_SOLID]              = "solid",
        [COMPONENT_SHEET_FORCED]       = "forced",
        [COMPONENT_SHEET_ALPHA_MASK]   = "alpha mask",
        [COMPONENT_SHEET_OPEN]         = "open",
        [COMPONENT_SHEET_DOUBLE_SIDED] = "double sided",
        [COMPONENT_SHEET_INWARD]       = "inward",
        [COMPONENT_SHEET_OCCUPIED]     = "occupied",
    };
    return (unsigned)kind < COMPONENT_KINDS ? names[kind] : "unknown";
}
