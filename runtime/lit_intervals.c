/* Where a ray is lit; see vxs_query.h.
 *
 * In light space a ray stays a line: of a sun in texels and voxels, of a lamp in metres about it, where borders of texels are planes
 * through the light, and borders of voxels planes across its axis. So all that may change along a ray is crossed at a plane, or at the
 * light's cone and range, which are quadrics:
 *
 *     t_begin --- cut --- cut ------------ cut --- t_end      cuts: cone, range, borders of maps; between two it is in one map, or outside
 *                          |  node | node | node |            in a map: from uniform node to uniform node, through planes
 *
 * Between cuts a voxel's coordinates only grow or only shrink. A step leaves a node through the plane that is crossed first, into the voxel
 * behind it; the other coordinates are held in the node, and never turn back. So rounding can move where a border is crossed, but not lead
 * through a border twice, and a walk ends.
 * SPDX-License-Identifier: MIT */
#include <math.h>
#include <string.h>

#include "uniform_node.h"
#include "vxs_space.h"

_Static_assert(sizeof(vxs_depth_cursor) <= sizeof((vxs_lit_walk *)0)->kept, "a walk has room for it");

enum { CUTS_MAX = sizeof((vxs_lit_walk *)0)->cuts / sizeof(double) };

static int is_sun(const vxs_light *light)
{
    return light->kind == VXS_LIGHT_KIND_DIRECTIONAL;
}

static int32_t side_of(const vxs_light *light)
{
    return (int32_t)1 << light->levels;
}

/* cuts --------------------------------------------------------------------------------------------------------------------------- */

/* In order, between the two that are there, each once. */
static void add_cut(vxs_lit_walk *w, double t)
{
    int32_t last = w->cut_count - 1;
    if (!(t > w->cuts[0] && t < w->cuts[last]) || w->cut_count == CUTS_MAX) return;
    while (last > 0 && w->cuts[last - 1] >= t) last--;
    if (w->cuts[last] == t) return;
    memmove(w->cuts + last + 1, w->cuts + last, (size_t)(w->cut_count - last) * sizeof *w->cuts);
    w->cuts[last] = t;
    w->cut_count++;
}

/* Where a + b t is 0. */
static void cut_at_plane(vxs_lit_walk *w, double a, double b)
{
    if (b != 0) add_cut(w, -a / b);
}

static double dot(const double *a, const double *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Where a s^2 + 2 b s + c is 0, s counted from `middle`; by sums that do not cancel. */
static void cut_at_roots(vxs_lit_walk *w, double middle, double a, double b, double c)
{
    double part = b * b - a * c;
    if (!(part >= 0)) return;
    double far = -(b + copysign(sqrt(part), b));
    if (a != 0) add_cut(w, middle + far / a);
    if (far != 0) add_cut(w, middle + c / far);
}

/* A lamp's range, and a spot's cone; from where the ray is nearest the light, so that its distance from there costs no digits. */
static void cut_at_quadrics(vxs_lit_walk *w)
{
    const vxs_light *light  = &w->baked->light;
    double           length = dot(w->along, w->along), middle, near[3], cos2 = light->cos_outer * light->cos_outer;
    if (!(length > 0)) return;
    middle = -dot(w->from, w->along) / length;
    for (int n = 0; n < 3; n++) near[n] = w->from[n] + middle * w->along[n];
    double slope = dot(near, w->along), distance2 = dot(near, near);
    if (light->range_metres > 0) cut_at_roots(w, middle, length, slope, distance2 - light->range_metres * light->range_metres);
    if (light->kind != VXS_LIGHT_KIND_SPOT) return;
    cut_at_plane(w, w->from[2], w->along[2]); /* the cone has another behind the light */
    cut_at_roots(w, middle, w->along[2] * w->along[2] - cos2 * length, near[2] * w->along[2] - cos2 * slope,
                 near[2] * near[2] - cos2 * distance2);
}

static void find_cuts(vxs_lit_walk *w)
{
    const vxs_light *light = &w->baked->light;
    double           side  = side_of(light);
    for (int axis = 0; axis < 3 && is_sun(light); axis++) {
        if (axis == 2 && !(light->flags & VXS_LIGHT_BOUNDED)) break;
        cut_at_plane(w, w->from[axis], w->along[axis]);
        cut_at_plane(w, w->from[axis] - side, w->along[axis]);
    }
    if (is_sun(light)) return;
    cut_at_quadrics(w);
    for (int a = 0; a < 3 && light->flags & VXS_LIGHT_CUBE; a++) {
        int b = (a + 1) % 3;
        cut_at_plane(w, w->from[a] - w->from[b], w->along[a] - w->along[b]);
        cut_at_plane(w, w->from[a] + w->from[b], w->along[a] + w->along[b]);
    }
}

/* maps --------------------------------------------------------------------------------------------------------------------------- */

static void point_at(const double *p, const double *d, double t, double *out)
{
    for (int n = 0; n < 3; n++) out[n] = d[n] != 0 ? p[n] + d[n] * t : p[n];
}

/* The map of a point of light space, or -1. */
static int32_t map_of(const vxs_light *light, const double *ls)
{
    double side = side_of(light);
    if (!is_sun(light)) return vxs_in_reach(light, ls) ? vxs_map_from_ls(light, ls) : -1;
    int axes = light->flags & VXS_LIGHT_BOUNDED ? 3 : 2;
    for (int axis = 0; axis < axes; axis++)
        if (!(ls[axis] >= 0 && ls[axis] < side)) return -1;
    return 0;
}

/* The voxel of a point of a map's space. What rounding leads out of the map is held in it. */
static void voxel_of(const vxs_light *light, const double *p, int32_t *voxel)
{
    int32_t last = side_of(light) - 1;
    if (is_sun(light)) {
        for (int axis = 0; axis < 3; axis++) voxel[axis] = vxs_clamped(floor(p[axis]));
        voxel[0] = vxs_clamp(voxel[0], 0, last);
        voxel[1] = vxs_clamp(voxel[1], 0, last);
        if (light->flags & VXS_LIGHT_BOUNDED) voxel[2] = vxs_clamp(voxel[2], 0, last);
        return;
    }
    double z = p[2] > DBL_MIN ? p[2] : DBL_MIN;
    voxel[0] = vxs_lamp_texel(light, vxs_lamp_coordinate(light, p[0], z), 0);
    voxel[1] = vxs_lamp_texel(light, vxs_lamp_coordinate(light, p[1], z), 0);
    voxel[2] = vxs_clamped(floor(log(z / light->near_metres) / light->voxel_metres));
}

static int32_t sign_of(double x)
{
    return (x > 0) - (x < 0);
}

/* Into a map, at t: its space, the voxel there, and which way each coordinate goes. Of a lamp u is x / z: its way is the
 * sign of x' z - x z'. */
static void enter_map(vxs_lit_walk *w, double t)
{
    const vxs_light  *light = &w->baked->light;
    double            at[3];
    vxs_depth_cursor *kept = (vxs_depth_cursor *)w->kept;
    kept->block.side_px = kept->tile.side_px = 0; /* of another map */
    w->in_tile                               = 0;
    memcpy(w->p, w->from, sizeof w->p);
    memcpy(w->d, w->along, sizeof w->d);
    if (!is_sun(light)) {
        vxs_face_from_ls(vxs_face_of_map(light, w->map), w->from, w->p);
        vxs_face_from_ls(vxs_face_of_map(light, w->map), w->along, w->d);
    }
    point_at(w->p, w->d, t, at);
    voxel_of(light, at, w->voxel);
    for (int axis = 0; axis < 3; axis++) {
        int across   = !is_sun(light) && axis < 2;
        w->way[axis] = sign_of(across ? w->d[axis] * w->p[2] - w->p[axis] * w->d[2] : w->d[axis]);
    }
}

/* Where the ray, from t on, crosses border `border` of an axis in its way there; INFINITY: nowhere. */
static double crossing(const vxs_lit_walk *w, int axis, int32_t border, double t)
{
    const vxs_light *light = &w->baked->light;
    double           a = w->p[axis] - border, b = w->d[axis], way = w->way[axis]; /* of a sun: a + b t is 0 there */
    if (!is_sun(light) && axis == 2) a = w->p[2] - light->near_metres * exp(border * light->voxel_metres);
    if (!is_sun(light) && axis < 2) {
        double slope = (border - 0.5 * side_of(light)) * light->texel_metres;
        a            = w->p[axis] - slope * w->p[2];
        b            = w->d[axis] - slope * w->d[2];
    }
    if (way * (b != 0 ? a + b * t : a) >= 0) return t;
    if (!(way * b > 0)) return INFINITY;
    return -a / b > t ? -a / b : t;
}

/* A step: from t to where the node is left, but not beyond t_end. Returns where it is. */
static double leave_node(vxs_lit_walk *w, const vxs_node *node, double t, double t_end)
{
    const vxs_light *light = &w->baked->light;
    int32_t          side = side_of(light), through = -1, at[3];
    int              in_front = node->end[2] == 0; /* of all texels at once: near a lamp theirs are rounding noise */
    double           first    = t_end, p[3];
    for (int axis = 0; axis < 3; axis++) {
        int32_t border = w->way[axis] > 0 ? node->end[axis] : node->first[axis];
        if (!w->way[axis] || border == VXS_NODE_FAR || border == -VXS_NODE_FAR) continue;
        if (axis < 2 && (border == 0 || border == side)) continue; /* a cut is there */
        double crossed = crossing(w, axis, border, t);
        if (!(crossed < first)) continue;
        first   = crossed;
        through = axis;
    }
    if (through < 0) return t_end;

    point_at(w->p, w->d, first, p);
    voxel_of(light, p, at);
    for (int axis = 0; axis < 3; axis++) {
        int32_t on = vxs_clamp(at[axis], node->first[axis], node->end[axis] - 1), was = w->voxel[axis];
        if (in_front || (w->way[axis] > 0 && on > was) || (w->way[axis] < 0 && on < was)) w->voxel[axis] = on;
    }
    w->voxel[through] = w->way[through] > 0 ? node->end[through] : node->first[through] - 1;
    return first;
}

/* texels ------------------------------------------------------------------------------------------------------------------------- */

/* Where the ray leaves its texel along axis 0 or 1; at a border of the map is a cut. */
static double leaves_texel(const vxs_lit_walk *w, int axis, double t)
{
    int32_t border = w->voxel[axis] + (w->way[axis] > 0);
    if (!w->way[axis] || border == 0 || border == side_of(&w->baked->light)) return INFINITY;
    return crossing(w, axis, border, t);
}

/* On a texel of a tile whose depths are known, which is not decided as a whole. */
static void enter_tile(vxs_lit_walk *w, double t)
{
    w->in_tile = 1;
    w->next[0] = leaves_texel(w, 0, t);
    w->next[1] = leaves_texel(w, 1, t);
}

/* Out of a tile: its depth is known again, which never turns back. */
static void leave_tile(vxs_lit_walk *w, double t)
{
    double  p[3];
    int32_t at[3], was = w->voxel[2];
    w->in_tile = 0;
    point_at(w->p, w->d, t, p);
    voxel_of(&w->baked->light, p, at);
    if (w->way[2] * (at[2] - was) > 0) w->voxel[2] = at[2];
}

/* From texel to texel of a tile: each is lit before its depth, and in shadow behind it. Of its borders only the one that is crossed is another
 * then. */
static void step_texel(vxs_lit_walk *w, double t_end, vxs_interval *piece)
{
    const vxs_depth_cursor *kept  = (const vxs_depth_cursor *)w->kept;
    int32_t                 depth = kept->depth[8 * (w->voxel[1] & 7) + (w->voxel[0] & 7)], way = w->way[2];
    int                     axis = w->next[1] < w->next[0], lit;
    double                  t = w->t, t_next = w->next[axis] < t_end ? w->next[axis] : t_end;
    if (depth == side_of(&w->baked->light) || !way)
        lit = depth > w->voxel[2] || depth == side_of(&w->baked->light);
    else {
        double t_depth = crossing(w, 2, depth, t);
        lit            = (t_depth > t) == (way > 0);
        if (t_depth > t && t_depth < t_next) {
            *piece = (vxs_interval){t, t_depth, lit, 0};
            w->t   = t_depth;
            return;
        }
    }
    *piece = (vxs_interval){t, t_next, lit, 0};
    w->t   = t_next;
    if (t_next == t_end) {
        leave_tile(w, t_next);
        return;
    }
    w->voxel[axis] += w->way[axis];
    w->next[axis] = leaves_texel(w, axis, t_next);
    if (w->voxel[axis] >> 3 != (axis ? kept->tile.j : kept->tile.i) >> 3) leave_tile(w, t_next);
}

/* the walk ----------------------------------------------------------------------------------------------------------------------- */

vxs_result vxs_lit_begin(vxs_lit_walk *w, const vxs_baked_light *baked, const vxs_ray *ray)
{
    const double most = 1e50;
    memset(w, 0, sizeof *w);
    w->baked = baked;
    for (int n = 0; n < 3; n++)
        if (!(fabs(ray->origin_ws[n]) <= most && fabs(ray->direction_ws[n]) <= most)) return VXS_E_ARGUMENT;
    if (!isfinite(ray->t_begin) || !(ray->t_end >= ray->t_begin)) return VXS_E_ARGUMENT;
    vxs_ls_from_ws(&baked->light, ray->origin_ws, 1, w->from);
    vxs_ls_from_ws(&baked->light, ray->direction_ws, 0, w->along);
    w->t         = ray->t_begin;
    w->cuts[0]   = ray->t_begin;
    w->cuts[1]   = ray->t_end;
    w->cut_count = 2;
    w->last      = (vxs_interval){ray->t_begin, ray->t_begin, 0, 0};
    find_cuts(w);
    return VXS_OK;
}

/* Within the part of the ray between two cuts: its middle; or, where that is very far, where the ray has gone as far again as it is from
 * anything: beyond, rounding would decide which of two maps it is in. */
static double within(const vxs_lit_walk *w, double first, double next)
{
    double size = side_of(&w->baked->light), speed = 0, half = 0.5 * next - 0.5 * first;
    for (int n = 0; n < 3; n++) {
        size  = fmax(size, fabs(w->from[n]));
        speed = fmax(speed, fabs(w->along[n]));
    }
    double far = speed > 0 ? fabs(first) + 8 * size / speed : 1;
    return first + (half < far ? half : far);
}

/* The map behind a cut. */
static void pass_cut(vxs_lit_walk *w)
{
    double first = w->cuts[w->cut], middle[3];
    point_at(w->from, w->along, within(w, first, w->cuts[w->cut + 1]), middle);
    w->map = map_of(&w->baked->light, middle);
    if (w->map >= 0) enter_map(w, first);
    w->cut++;
}

static int is_texel(const vxs_lit_walk *w, const vxs_node *node)
{
    const vxs_depth_cursor *kept = (const vxs_depth_cursor *)w->kept;
    return node->end[0] - node->first[0] == 1 && kept->tile.side_px && kept->has_depths && w->voxel[2] >= 0 &&
           w->baked->light.coding == VXS_CODING_BLOCKS;
}

/* The next piece of one state. 0: the ray is at its end. */
static int step(vxs_lit_walk *w, vxs_interval *piece)
{
    vxs_node node = {.state = VXS_INTERVAL_OUTSIDE};
    if (w->cut == 0 || w->t >= w->cuts[w->cut]) {
        if (w->cut + 1 >= w->cut_count) return 0;
        pass_cut(w);
    }
    double t = w->t, t_end = w->cuts[w->cut];
    if (w->in_tile) {
        step_texel(w, t_end, piece);
        return 1;
    }
    int inside = w->map >= 0 && vxs_find_uniform_node(w->baked, w->map, w->voxel, 1, &node, (vxs_depth_cursor *)w->kept);
    if (inside && is_texel(w, &node)) {
        enter_tile(w, t);
        step_texel(w, t_end, piece);
        return 1;
    }
    w->t   = inside ? leave_node(w, &node, t, t_end) : t_end;
    *piece = (vxs_interval){t, w->t, inside ? node.state : VXS_INTERVAL_OUTSIDE, node.coarse};
    return 1;
}

size_t vxs_lit_next(vxs_lit_walk *w, vxs_interval *intervals, size_t capacity)
{
    size_t       count = 0;
    vxs_interval piece, *last = &w->last;
    while (count < capacity && w->cut_count) {
        if (!step(w, &piece)) {
            w->cut_count = 0;
            if (last->t_end > last->t_begin) intervals[count++] = *last;
            break;
        }
        if (!(piece.t_end > piece.t_begin)) continue;
        if (piece.state == last->state && piece.coarse == last->coarse)
            last->t_end = piece.t_end;
        else {
            if (last->t_end > last->t_begin) intervals[count++] = *last;
            *last = piece;
        }
    }
    return count;
}
