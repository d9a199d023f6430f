/* The mesh about what a light reaches, in C; see vxs_volumes.h.
 *
 * Each map is a tree of quads, its root as wide as the map. A quad splits where its two triangles lie too far off the depth of any texel, and where the
 * quad beside it has split twice, so that quads that meet differ by one level; then the larger one has a vertex in the middle of
 * that edge, which leaves no gap. Trees of a cube's faces meet in its edges as quads of one face do.
 *
 *     +-------+---+---+
 *     |       |   |   |     the left one is a fan of three triangles about *
 *     |       *---+---+
 *     |       |   |   |
 *     +-------+---+---+
 *
 * Source: [Billeter 2010] 4.1 for a restricted tree and its fans. There a filter for edges says what splits; here the error does, which it bounds.
 * SPDX-License-Identifier: MIT */
#include "light_mesh.h"

#include <math.h>
#include <string.h>

#include "vxs_desc.h"
#include "vxs_volumes.h"

enum { LEVELS_MAX = 13, BESIDE = 12 };

/* What is planned: of each layer and level, coarse first, which quads split; and the number of each vertex. */
typedef struct mesh_plan {
    vxs_light_mesh_desc desc;
    vxs_mesh_shape      shape;
    int                 levels;  /* quads of the root: 2^levels texels wide */
    double              nearest; /* of lamps: depths nearer than this are alike, for errors */
    double              error_scale;
    uint32_t           *numbers; /* [layers][side + 1][side + 1], then [BESIDE]: 1 + number of a vertex; 0: it has none */
    uint8_t            *splits;  /* [layers][quads_of_layer] */
    float              *places;  /* NULL while the mesh is counted */
    uint32_t           *corners;
    uint32_t            vertex_count, triangle_count;
} mesh_plan;

/* A quad of 2^level x 2^level texels; x, y count such quads. */
typedef struct quad {
    int layer, level, x, y;
} quad;

/* shape -------------------------------------------------------------------------------------------------------------------------- */

/* Rows of a sun's matrix are as long as a metre is in texels or voxels. */
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

vxs_mesh_shape vxs_light_mesh_shape(const vxs_light_constants *light, uint32_t side_px, double far_metres, const double *about_ls)
{
    vxs_mesh_shape s = {.side   = (int32_t)side_px,
                        .layers = light->flags & VXS_LIGHT_CUBE ? 6 : 1,
                        .is_sun = light->kind == VXS_LIGHT_KIND_DIRECTIONAL,
                        .high   = side_px,
                        .reach  = light->range_metres > 0 ? (double)light->range_metres : far_metres};
    if (s.is_sun)
        shape_sun(&s, light, far_metres, about_ls);
    else
        s.texel = (double)light->texel_metres * ldexp(1, (int)light->levels) / side_px;
    if (s.layers == 6) { /* the edges of the cube; a map without border ends in them */
        s.low  = fmax(0, 0.5 * side_px - 1 / s.texel);
        s.high = side_px - s.low;
    }
    s.first = (int32_t)floor(s.low);
    s.last  = (int32_t)ceil(s.high) - 1;
    return s;
}

/* depths ------------------------------------------------------------------------------------------------------------------------- */

static double depth_of(const mesh_plan *p, vxs_mesh_vertex v)
{
    vxs_int3 texel;
    size_t   side = p->desc.side_px;
    if (v.layer < 0) return 0;
    vxs_mesh_texel(&p->shape, v, texel);
    return p->desc.first[((size_t)texel[2] * side + (size_t)texel[1]) * side + (size_t)texel[0]];
}

/* What is linear on a triangle, where vertices are by their places in the map: a sun's depth, the inverse of a lamp's. */
static double linear_depth(const mesh_plan *p, vxs_mesh_vertex v)
{
    double z = vxs_mesh_depth(&p->shape, depth_of(p, v));
    return p->shape.is_sun ? z : 1 / fmax(z, p->nearest);
}

/* How far apart two of these are, in widths of a texel at the nearer. */
static double error_of(const mesh_plan *p, double one, double other)
{
    double apart = fabs(one - other);
    return p->error_scale * (p->shape.is_sun ? apart : apart / fmin(one, other));
}

/* Where, of [a, b], vertex i lies; 0 where they have fallen together. */
static double share_of(const mesh_plan *p, int a, int b, int i)
{
    double low = vxs_mesh_at(&p->shape, a), high = vxs_mesh_at(&p->shape, b);
    return high > low ? (vxs_mesh_at(&p->shape, i) - low) / (high - low) : 0;
}

/* Whether a vertex lies farther off the two triangles of a quad than is allowed. */
static int is_off(const mesh_plan *p, quad q)
{
    int    size = 1 << q.level, i0 = q.x * size, j0 = q.y * size;
    double at[4];
    for (int n = 0; n < 4; n++) at[n] = linear_depth(p, vxs_mesh_vertex_of(q.layer, i0 + (n & 1) * size, j0 + (n >> 1) * size));
    for (int j = j0; j <= j0 + size; j++) {
        double t = share_of(p, j0, j0 + size, j);
        for (int i = i0; i <= i0 + size; i++) {
            double s = share_of(p, i0, i0 + size, i), flat;
            if (s >= t)
                flat = at[0] + s * (at[1] - at[0]) + t * (at[3] - at[1]);
            else
                flat = at[0] + t * (at[2] - at[0]) + s * (at[3] - at[2]);
            if (error_of(p, flat, linear_depth(p, vxs_mesh_vertex_of(q.layer, i, j))) > (double)p->desc.error_texels) return 1;
        }
    }
    return 0;
}

/* quads -------------------------------------------------------------------------------------------------------------------------- */

/* Quads of more than a texel, of a map of 2^levels: (4^levels - 1) / 3. */
static size_t quads_of_layer(int levels)
{
    return (((size_t)1 << 2 * levels) - 1) / 3;
}

static uint8_t *split_of(const mesh_plan *p, quad q)
{
    size_t row = (size_t)1 << (p->levels - q.level), before = quads_of_layer(p->levels - q.level);
    return p->splits + (size_t)q.layer * quads_of_layer(p->levels) + before + (size_t)q.y * row + (size_t)q.x;
}

static int has_split(const mesh_plan *p, quad q)
{
    return q.level > 0 && *split_of(p, q);
}

static quad parent_of(quad q)
{
    return (quad){q.layer, q.level + 1, q.x / 2, q.y / 2};
}

static int exists(const mesh_plan *p, quad q)
{
    return q.level == p->levels || *split_of(p, parent_of(q));
}

/* The quad of the same size beside edge `edge`: 0 above, 1 right, 2 below, 3 left. Beyond the edge of a cube it is of another face.
 * Returns 0 at the border of a light with one map. */
static int beside(const mesh_plan *p, quad q, int edge, quad *other)
{
    int last = (1 << (p->levels - q.level)) - 1, high = edge == 1 || edge == 2, is_across = edge & 1;
    int at = is_across ? q.x : q.y;
    *other = q;
    if (at != (high ? last : 0)) {
        *(is_across ? &other->x : &other->y) += high ? 1 : -1;
        return 1;
    }
    if (p->shape.layers == 1) return 0;
    int crossed                              = vxs_ls_axis_from_face(q.layer, is_across ? 0 : 1), along[3];
    along[vxs_ls_axis_from_face(q.layer, 0)] = q.x;
    along[vxs_ls_axis_from_face(q.layer, 1)] = q.y;
    along[q.layer / 2]                       = q.layer & 1 ? 0 : last;
    other->layer                             = 2 * crossed + !high;
    other->x                                 = along[vxs_ls_axis_from_face(other->layer, 0)];
    other->y                                 = along[vxs_ls_axis_from_face(other->layer, 1)];
    return 1;
}

/* For each quad of a level. */
#define EACH_QUAD(p, q, level_)                                                                                                    \
    for (quad q = {.level = (level_)}; q.layer < (p)->shape.layers; q.layer++)                                                     \
        for (q.y = 0; q.y < 1 << ((p)->levels - q.level); q.y++)                                                                   \
            for (q.x = 0; q.x < 1 << ((p)->levels - q.level); q.x++)

/* From the roots down, what is too far off; then from the smallest up, so that quads that meet differ by one level: those beside one that
 * splits are no larger than it was. */
static void choose_quads(mesh_plan *p)
{
    for (int level = p->levels; level > 0; level--) EACH_QUAD(p, q, level)
    *split_of(p, q) = exists(p, q) && (p->desc.error_texels == 0 || is_off(p, q));
    for (int level = 1; level < p->levels; level++) EACH_QUAD(p, q, level)
        {
            quad other;
            if (!*split_of(p, q)) continue;
            *split_of(p, parent_of(q)) = 1;
            for (int edge = 0; edge < 4; edge++)
                if (beside(p, q, edge, &other)) *split_of(p, parent_of(other)) = 1;
        }
}

/* triangles ---------------------------------------------------------------------------------------------------------------------- */

/* Vertices that have fallen together are one. */
static vxs_mesh_vertex held(const mesh_plan *p, vxs_mesh_vertex v)
{
    int across, down, side = p->shape.side;
    if (v.layer < 0) return vxs_mesh_vertex_of(-1, p->shape.is_sun ? v.i : 0, 0);
    across = vxs_mesh_end(&p->shape, v.i);
    down   = vxs_mesh_end(&p->shape, v.j);
    return vxs_mesh_vertex_of(v.layer, across < 0 ? 0 : across > 0 ? side : v.i, down < 0 ? 0 : down > 0 ? side : v.j);
}

static uint32_t *number_of(const mesh_plan *p, vxs_mesh_vertex v)
{
    size_t row = (size_t)p->shape.side + 1;
    if (v.layer < 0) return p->numbers + (size_t)p->shape.layers * row * row + (size_t)v.i;
    return p->numbers + ((size_t)v.layer * row + (size_t)v.j) * row + (size_t)v.i;
}

static uint32_t take_vertex(mesh_plan *p, vxs_mesh_vertex v)
{
    uint32_t *number = number_of(p, v);
    vxs_real3 ls;
    if (!p->places) {
        if (!*number) *number = ++p->vertex_count;
        return *number - 1;
    }
    vxs_mesh_place(&p->shape, v, depth_of(p, v), ls);
    for (int n = 0; n < 3; n++) p->places[3 * (size_t)(*number - 1) + (size_t)n] = (float)ls[n];
    return *number - 1;
}

static void add_triangle(mesh_plan *p, vxs_mesh_vertex a, vxs_mesh_vertex b, vxs_mesh_vertex c)
{
    const vxs_mesh_vertex corners[3] = {held(p, a), held(p, b), held(p, c)};
    const uint32_t       *numbers[3];
    for (int n = 0; n < 3; n++) numbers[n] = number_of(p, corners[n]);
    if (numbers[0] == numbers[1] || numbers[1] == numbers[2] || numbers[2] == numbers[0]) return; /* it has fallen together */
    for (size_t n = 0; n < 3; n++) {
        uint32_t vertex = take_vertex(p, corners[n]);
        if (p->corners) p->corners[3 * (size_t)p->triangle_count + n] = vertex;
    }
    p->triangle_count++;
}

/* The corners of a quad, and a vertex in the middle of each edge beside which there are smaller ones; a fan about the first of these, or two
 * triangles. Where the map ends, a wall. */
static void add_quad(mesh_plan *p, quad q)
{
    int             size = 1 << q.level, i = q.x * size, j = q.y * size, count = 0, fan = -1;
    int             walks[4][2] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}}; /* along each edge */
    vxs_mesh_vertex at[8];
    for (int edge = 0; edge < 4; edge++) {
        const int *walk = walks[edge];
        quad       other;
        at[count++] = vxs_mesh_vertex_of(q.layer, i, j);
        int meets   = beside(p, q, edge, &other);
        if (meets && has_split(p, other)) {
            if (fan < 0) fan = count;
            at[count++] = vxs_mesh_vertex_of(q.layer, i + walk[0] * size / 2, j + walk[1] * size / 2);
        }
        i += walk[0] * size;
        j += walk[1] * size;
        if (!meets) add_triangle(p, vxs_mesh_vertex_of(q.layer, i, j), at[count - 1], vxs_mesh_vertex_of(-1, edge, 0));
    }
    if (fan < 0) fan = 0;
    for (int n = 1; n + 1 < count; n++) add_triangle(p, at[fan], at[(fan + n) % count], at[(fan + n + 1) % count]);
}

static void add_triangles(mesh_plan *p)
{
    for (int level = p->levels; level >= 0; level--) EACH_QUAD(p, q, level)
    if (exists(p, q) && !has_split(p, q)) add_quad(p, q);
    for (int n = 0; n < vxs_mesh_closing(&p->shape); n++)
        add_triangle(p, vxs_mesh_closing_corner(&p->shape, n, 0), vxs_mesh_closing_corner(&p->shape, n, 1),
                     vxs_mesh_closing_corner(&p->shape, n, 2));
}

/* plan and fill -------------------------------------------------------------------------------------------------------------------- */

/* Returns 0 where the description makes no sense. */
static int begin_plan(mesh_plan *p, const vxs_light_mesh_desc *desc)
{
    const size_t first = offsetof(vxs_light_mesh_desc, error_texels) + sizeof desc->error_texels;
    *p                 = (mesh_plan){0};
    if (vxs_desc_take(&p->desc, sizeof p->desc, first, desc) != VXS_OK) return 0;
    const vxs_light_constants *light = p->desc.light;
    while (p->levels <= LEVELS_MAX && 1U << p->levels != p->desc.side_px) p->levels++;
    if (!light || !p->desc.first || p->levels > LEVELS_MAX || (uint32_t)p->levels > light->levels) return 0;
    if (!(p->desc.far_metres > 0 && isfinite(p->desc.far_metres)) || !(p->desc.error_texels >= 0)) return 0;
    if (!(light->texel_metres > 0 && isfinite(light->texel_metres)) || !isfinite(light->range_metres)) return 0;
    p->shape   = vxs_light_mesh_shape(light, p->desc.side_px, (double)p->desc.far_metres, NULL);
    p->nearest = 1e-6 * p->shape.reach;
    p->error_scale =
        p->shape.is_sun ? (double)light->voxel_metres / ((double)light->texel_metres * p->shape.texel) : 1 / p->shape.texel;
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
    return number_count(&p) * sizeof *p.numbers + (size_t)p.shape.layers * quads_of_layer(p.levels);
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
