/* The mesh around the lit volume of a light, in C; see vxs_volumes.h. vxs_mesh_quads.h defines its quads and triangles.
 * SPDX-License-Identifier: MIT */
#include "light_mesh.h"

#include <math.h>
#include <string.h>

#include "vxs_desc.h"
#include "vxs_mesh_quads.h"
#include "vxs_volumes.h"

enum { LEVELS_MAX = 13, BESIDE = 12 };

/* A plan: which quads are split, and the index of each vertex. */
typedef struct mesh_plan {
    vxs_light_mesh_desc desc;
    vxs_mesh_shape      shape;
    uint32_t           *numbers; /* [layers][side + 1][side + 1], then [BESIDE]: 1 + index of a vertex; 0: not used */
    uint8_t            *splits;  /* [layers][vxs_mesh_larger_quads] */
    float              *places;  /* NULL while the size of the mesh is counted */
    uint32_t           *corners;
    uint32_t            vertex_count, triangle_count;
} mesh_plan;

/* shape ------------------------------------------------------------------------------------------------------------------------ */

/* The length of a row of a sun's matrix is texels, or voxels, per metre. */
static double row_length(const vxs_light_constants *light, int row)
{
    const float *r = light->ls_from_ws + 4 * row;
    return sqrt((double)r[0] * r[0] + (double)r[1] * r[1] + (double)r[2] * r[2]);
}

static void shape_sun(vxs_mesh_shape *s, const vxs_light_constants *light, double far_metres, const double *about)
{
    double baked = ldexp(1, (int)light->levels);
    s->texel     = baked / s->side;
    for (int n = 0; n < 3; n++) {
        double metres  = far_metres * row_length(light, n);
        s->box_low[n]  = fmin(about ? about[n] : 0, 0) - metres - 1;
        s->box_high[n] = fmax(about ? about[n] : baked, baked) + metres + 1;
    }
    s->least = s->box_low[2];
    s->reach = light->flags & VXS_LIGHT_BOUNDED ? baked : s->box_high[2];
    s->box_high[2] += 1;
}

int vxs_mesh_levels(uint32_t side_px)
{
    for (int levels = 0; levels <= LEVELS_MAX; levels++)
        if (1U << levels == side_px) return levels;
    return -1;
}

vxs_mesh_shape vxs_light_mesh_shape(const vxs_light_constants *light, uint32_t side_px, double far_metres, const double *about_ls)
{
    vxs_mesh_shape s = {.side   = (int32_t)side_px,
                        .levels = vxs_mesh_levels(side_px),
                        .layers = light->flags & VXS_LIGHT_CUBE ? 6 : 1,
                        .is_sun = light->kind == VXS_LIGHT_KIND_DIRECTIONAL,
                        .high   = side_px,
                        .reach  = light->range_metres > 0 ? (double)light->range_metres : far_metres};
    if (s.is_sun)
        shape_sun(&s, light, far_metres, about_ls);
    else
        s.texel = (double)light->texel_metres * ldexp(1, (int)light->levels) / side_px;
    s.error_scale = s.is_sun ? (double)light->voxel_metres / ((double)light->texel_metres * s.texel) : 1 / s.texel;
    if (s.layers == 6) { /* the edges of the cube; a map without a border ends in them */
        s.low  = fmax(0, 0.5 * side_px - 1 / s.texel);
        s.high = side_px - s.low;
    }
    s.first = (int32_t)floor(s.low);
    s.last  = (int32_t)ceil(s.high) - 1;
    return s;
}

/* quads ------------------------------------------------------------------------------------------------------------------------ */

/* For each quad of a level. */
#define EACH_QUAD(p, q, level_)                                                                                                    \
    for (vxs_mesh_quad q = {.level = (level_)}; q.layer < (p)->shape.layers; q.layer++)                                            \
        for (q.y = 0; q.y < 1 << ((p)->shape.levels - q.level); q.y++)                                                             \
            for (q.x = 0; q.x < 1 << ((p)->shape.levels - q.level); q.x++)

static int is_off(const mesh_plan *p, vxs_mesh_quad q)
{
    int size = 1 << q.level;
    if (p->desc.error_texels == 0) return 1;
    return vxs_mesh_is_off(p->desc.first, &p->shape, q, q.x * size, q.y * size, size, (double)p->desc.error_texels);
}

/* First split quads with too large errors, from the roots down; then split neighbours, from the smallest quads up, so that they
 * differ by at most one level. */
static void choose_quads(mesh_plan *p)
{
    int levels = p->shape.levels;
    for (int level = levels; level > 0; level--) EACH_QUAD(p, q, level)
    p->splits[vxs_mesh_quad_at(&p->shape, q)] = vxs_mesh_exists(p->splits, &p->shape, q) && is_off(p, q);
    for (int level = 1; level < levels; level++) EACH_QUAD(p, q, level)
    vxs_mesh_balance(p->splits, &p->shape, q);
}

/* triangles -------------------------------------------------------------------------------------------------------------------- */

static uint32_t *number_of(const mesh_plan *p, vxs_mesh_vertex v)
{
    size_t row = (size_t)p->shape.side + 1;
    if (v.layer < 0) return p->numbers + (size_t)p->shape.layers * row * row + (size_t)v.i;
    return p->numbers + ((size_t)v.layer * row + (size_t)v.j) * row + (size_t)v.i;
}

static uint32_t take_vertex(mesh_plan *p, vxs_mesh_vertex v)
{
    uint32_t *number = number_of(p, v);
    vxs_int3  texel;
    vxs_real3 ls;
    double    depth = 0;
    if (!p->places) {
        if (!*number) *number = ++p->vertex_count;
        return *number - 1;
    }
    if (v.layer >= 0) {
        vxs_mesh_texel(&p->shape, v, texel);
        depth = vxs_mesh_first(p->desc.first, &p->shape, texel);
    }
    vxs_mesh_place(&p->shape, v, depth, ls);
    for (int n = 0; n < 3; n++) p->places[3 * (size_t)(*number - 1) + (size_t)n] = (float)ls[n];
    return *number - 1;
}

static void add_triangle(mesh_plan *p, vxs_mesh_vertex a, vxs_mesh_vertex b, vxs_mesh_vertex c)
{
    const vxs_mesh_vertex corners[3] = {vxs_mesh_held(&p->shape, a), vxs_mesh_held(&p->shape, b), vxs_mesh_held(&p->shape, c)};
    const uint32_t       *numbers[3];
    for (int n = 0; n < 3; n++) numbers[n] = number_of(p, corners[n]);
    if (numbers[0] == numbers[1] || numbers[1] == numbers[2] || numbers[2] == numbers[0]) return; /* vertices coincide */
    for (size_t n = 0; n < 3; n++) {
        uint32_t vertex = take_vertex(p, corners[n]);
        if (p->corners) p->corners[3 * (size_t)p->triangle_count + n] = vertex;
    }
    p->triangle_count++;
}

/* Add a fan, and walls where the map ends. */
static void add_quad(mesh_plan *p, vxs_mesh_quad q)
{
    int finer = vxs_mesh_finer(p->splits, &p->shape, q), first = vxs_mesh_fan_first(finer);
    for (int a = vxs_mesh_fan_next(finer, first), b; (b = vxs_mesh_fan_next(finer, a)) != first; a = b)
        add_triangle(p, vxs_mesh_outline(q, first), vxs_mesh_outline(q, a), vxs_mesh_outline(q, b));
    for (int edge = 0; edge < 4; edge++)
        if (finer >> (4 + edge) & 1)
            add_triangle(p, vxs_mesh_outline(q, 2 * edge + 2), vxs_mesh_outline(q, 2 * edge), vxs_mesh_vertex_of(-1, edge, 0));
}

static void add_triangles(mesh_plan *p)
{
    for (int level = p->shape.levels; level >= 0; level--) EACH_QUAD(p, q, level)
    if (vxs_mesh_is_drawn(p->splits, &p->shape, q)) add_quad(p, q);
    for (int n = 0; n < vxs_mesh_closing(&p->shape); n++)
        add_triangle(p, vxs_mesh_closing_corner(&p->shape, n, 0), vxs_mesh_closing_corner(&p->shape, n, 1),
                     vxs_mesh_closing_corner(&p->shape, n, 2));
}

/* plan and fill ---------------------------------------------------------------------------------------------------------------- */

/* Returns 0 if the description is invalid. */
static int begin_plan(mesh_plan *p, const vxs_light_mesh_desc *desc)
{
    const size_t first = offsetof(vxs_light_mesh_desc, error_texels) + sizeof desc->error_texels;
    *p                 = (mesh_plan){0};
    if (vxs_desc_take(&p->desc, sizeof p->desc, first, desc) != VXS_OK) return 0;
    const vxs_light_constants *light  = p->desc.light;
    int                        levels = vxs_mesh_levels(p->desc.side_px);
    if (!light || !p->desc.first || levels < 0 || (uint32_t)levels > light->levels) return 0;
    if (!(p->desc.far_metres > 0 && isfinite(p->desc.far_metres)) || !(p->desc.error_texels >= 0)) return 0;
    if (!(light->texel_metres > 0 && isfinite(light->texel_metres)) || !isfinite(light->range_metres)) return 0;
    p->shape = vxs_light_mesh_shape(light, p->desc.side_px, (double)p->desc.far_metres, NULL);
    return 1;
}

static size_t number_count(const mesh_plan *p)
{
    size_t row = (size_t)p->shape.side + 1;
    return row * row * (size_t)p->shape.layers + BESIDE;
}

static void use_room(mesh_plan *p, void *room)
{
    p->numbers = room;
    p->splits  = (uint8_t *)(p->numbers + number_count(p));
}

size_t vxs_light_mesh_room(const vxs_light_mesh_desc *desc)
{
    mesh_plan p;
    if (!begin_plan(&p, desc)) return 0;
    return number_count(&p) * sizeof *p.numbers + (size_t)(p.shape.layers * vxs_mesh_larger_quads(p.shape.levels));
}

vxs_result vxs_light_mesh_plan(const vxs_light_mesh_desc *desc, void *room, vxs_light_mesh_size *size)
{
    mesh_plan p;
    if (!room || !begin_plan(&p, desc)) return VXS_E_ARGUMENT;
    use_room(&p, room);
    memset(p.numbers, 0, number_count(&p) * sizeof *p.numbers);
    choose_quads(&p);
    add_triangles(&p);
    *size = (vxs_light_mesh_size){p.vertex_count, p.triangle_count};
    return VXS_OK;
}

void vxs_light_mesh_fill(const vxs_light_mesh_desc *desc, const void *room, float *places, uint32_t *corners)
{
    mesh_plan p;
    if (!begin_plan(&p, desc)) return;
    use_room(&p, (void *)(uintptr_t)room);
    p.places  = places;
    p.corners = corners;
    add_triangles(&p);
}
