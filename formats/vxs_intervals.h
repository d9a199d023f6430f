/* Exact intervals of a ray that are lit: a walk through the words of a light, exact to the voxel. One text for C99, C++,
 * GLSL and HLSL; it needs vxs_depths.h.
 *
 *     vxs_walk w = vxs_walk_of(light, eye_ws, direction_ws, t_begin, t_end);
 *     vxs_span span;
 *     while (vxs_walk_next(words, light, w, span) != 0)
 *         if (span.state == VXS_SPAN_LIT) airlight += ... from span.begin to span.end;
 *
 * In light space a ray remains a line. For a sun, light space is in texels and voxels. For a punctual light it is in metres
 * about the light: texel borders are planes through the light, and voxel borders are planes perpendicular to its axis. So
 * the state can change only where the ray crosses a plane, or the cone and range of the light, which are quadrics:
 *
 *     t_begin --- cut --- cut ------------ cut --- t_end   cuts: cone, range, borders of maps; between two: one map or outside
 *                          |  block | tile | tile |        in a map: regions that are all lit or all shadowed in one step;
 *                                   |. . . |               texel by texel in other tiles; each texel has one depth
 *
 * A square or block with bounds of its depths is all lit before the least depth, and all in shadow from the greatest depth
 * on. A tile is passed in one step if the same answer holds where the ray enters and where it leaves. Only other tiles are
 * walked by texels, and only through the texels that the ray crosses.
 *
 * Between two cuts each coordinate of the voxel only grows or only shrinks. A step leaves a box through the plane that is
 * crossed first, into the voxel behind it; the other coordinates are clamped to the box and never go back. So rounding can
 * move the point where a border is crossed, but cannot cross a border twice. A walk ends after at most VXS_WALK_STEPS times
 * the side of the map in steps, for any words.
 * Public: what this comment names. Other names are internal, and may change in any version.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_INTERVALS_H
#define VXS_INTERVALS_H

#ifndef VXS_DEPTHS_H /* a shader that cannot include already has this text */
#include "vxs_depths.h"
#endif

#ifdef VXS_C
typedef struct vxs_span     vxs_span;
typedef struct vxs_walk     vxs_walk;
typedef struct vxs_walk_box vxs_walk_box;
#define VXS_WALK       vxs_walk *
#define VXS_SQUARE     const vxs_depths_square *
#define VXS_SPAN       vxs_span *
#define VXS_SPAN_INOUT vxs_span *
#ifndef VXS_NEVER
#define VXS_NEVER INFINITY
#endif
#else
#define VXS_WALK       inout vxs_walk
#define VXS_SQUARE     vxs_depths_square
#define VXS_SPAN       out vxs_span
#define VXS_SPAN_INOUT inout vxs_span
#define VXS_NEVER      3e38
#endif

#define VXS_SPAN_LIT     0
#define VXS_SPAN_SHADOW  1
#define VXS_SPAN_OUTSIDE 2
#define VXS_SPAN_NONE    (-1)
#define VXS_SPAN_COARSE  4 /* added to a state inside a walk */

#define VXS_WALK_STEPS 64
#define VXS_NO_BORDER  (1 << 30)

/* A part of a ray, [begin, end), that is all lit, all in shadow, or outside the volume of the light. */
struct vxs_span {
    vxs_real begin, end;
    vxs_i32  state;  /* VXS_SPAN_* */
    vxs_i32  coarse; /* 1: a page is missing, and this is the coarse answer; else 0 */
};

/* Voxels of a map in the same state: a square of texels, depths [near, far). VXS_NO_BORDER and -VXS_NO_BORDER mean no end. */
struct vxs_walk_box {
    vxs_i32 i, j, side_px, near, far;
    vxs_i32 state; /* VXS_SPAN_*, with VXS_SPAN_COARSE */
};

struct vxs_walk {
    vxs_int3  origin;      /* sun: the voxel where light space starts here, so that floats near it are precise */
    vxs_real3 from, along; /* the ray in light space */
    vxs_real3 p, d;        /* the ray in the space of the current map */
    vxs_real3 per_d;       /* 1 / d; for a punctual light only [2] is used */
    vxs_real  t, cut, end; /* t: current place; cut: the current map ends there; end: end of the ray */
    vxs_real  begin;       /* start of the current interval, which reaches to t */
    vxs_i32   state;       /* its state, with VXS_SPAN_COARSE */
    vxs_i32   outside;     /* state outside the volume: VXS_SPAN_OUTSIDE unless the caller sets another */
    vxs_i32   steps;       /* steps left */
    /* the walk stops at t, as if t_end were there, if fewer steps than this are left; 0: never. The caller may set it after
     * vxs_walk_of */
    vxs_i32   pause;
    vxs_i32   map;
    vxs_int3  voxel, way; /* direction of each coordinate: 1, -1, or 0 */

    vxs_depths_square block;              /* bounds of a block or of something larger; side_px 0: none known */
    vxs_i32           is_block;           /* 1: they are of a block, which is known */
    vxs_i32           square_i, square_j; /* the known square of 256 x 256 texels; -1: none */
    vxs_depths_square square;
#ifdef VXS_TABLES
    uint node, slope, block_word; /* of tables: the node of the square, or 0; its slope; the word of the block */
    uint tile_record;
    int  tile_base;
#else
    vxs_blocks_block record;
    vxs_i32          has_node; /* 1: its node is known too */
    vxs_blocks_node  node;
    vxs_depths_tile  tile;
#endif

    vxs_i32 tile_i, tile_j;  /* tile of the map; -1: none known */
    vxs_i32 least, greatest; /* of the depths of the tile */

    vxs_i32   in_tile;           /* 1: the walk goes from texel to texel in the tile */
    vxs_real3 next;              /* where the ray crosses the next texel border, across and down */
    vxs_i32   nearest, farthest; /* depth range of the ray in the tile */
};

/* 1 or 0; a constant where a shader has one kind of light. */
#define vxs_walk_is_sun(light) (VXS_KIND(light) == VXS_LIGHT_KIND_DIRECTIONAL ? 1 : 0)

VXS_FN vxs_i32 vxs_walk_side(VXS_LIGHT light)
{
    return VXS_I(1) << VXS_FIELD(light, levels);
}

/* cuts ------------------------------------------------------------------------------------------------------------------------- */

/* The smaller of two places behind t. A place that is not behind t is ignored. */
VXS_FN vxs_real vxs_walk_sooner(vxs_real place, vxs_real t, vxs_real next)
{
    return place > t && place < next ? place : next;
}

/* Root of a + b t. */
VXS_FN vxs_real vxs_walk_plane(vxs_real a, vxs_real b, vxs_real t, vxs_real next)
{
    return b != 0.0 ? vxs_walk_sooner(-a / b, t, next) : next;
}

/* Roots of a s^2 + 2 b s + c, where s = t - middle; the sums do not cancel. */
VXS_FN vxs_real vxs_walk_roots(vxs_real middle, vxs_real a, vxs_real b, vxs_real c, vxs_real t, vxs_real next)
{
    vxs_real part = b * b - a * c;
    if (!(part >= 0.0)) return next;
    vxs_real far = b < 0.0 ? sqrt(part) - b : -(b + sqrt(part));
    if (a != 0.0) next = vxs_walk_sooner(middle + far / a, t, next);
    if (far != 0.0) next = vxs_walk_sooner(middle + c / far, t, next);
    return next;
}

VXS_FN vxs_real vxs_walk_dot(const vxs_real3 a, const vxs_real3 b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Crossings of the range of a punctual light and of the cone of a spot. They are computed from the point of the ray nearest
 * the light, so that a large distance from it costs no precision. */
VXS_FN vxs_real vxs_walk_quadrics(VXS_LIGHT light, const vxs_real3 from, const vxs_real3 along, vxs_real t, vxs_real next)
{
    vxs_real  length = vxs_walk_dot(along, along), range = VXS_FIELD(light, range_metres), outer = VXS_FIELD(light, cos_outer);
    vxs_real3 near;
    if (!(length > 0.0)) return next;
    vxs_real middle = -vxs_walk_dot(from, along) / length;
    for (vxs_i32 n = 0; n < 3; n++) near[n] = from[n] + middle * along[n];
    vxs_real slope = vxs_walk_dot(near, along), distance2 = vxs_walk_dot(near, near), cos2 = outer * outer;
    if (range > 0.0) next = vxs_walk_roots(middle, length, slope, distance2 - range * range, t, next);
    if (VXS_KIND(light) == VXS_LIGHT_KIND_POINT) return next;
    next = vxs_walk_plane(from[2], along[2], t, next); /* a second cone lies behind the light */
    return vxs_walk_roots(middle, along[2] * along[2] - cos2 * length, near[2] * along[2] - cos2 * slope,
                          near[2] * near[2] - cos2 * distance2, t, next);
}

/* The first cut behind t, at most the end of the ray. */
VXS_FN vxs_real vxs_walk_next_cut(VXS_LIGHT light, VXS_WALK w, vxs_real t)
{
    vxs_real next = VXS_FIELD(w, end);
    vxs_i32  axes = (VXS_FIELD(light, flags) & VXS_LIGHT_BOUNDED) != 0u ? 3 : 2;
    for (vxs_i32 axis = 0; axis < axes && vxs_walk_is_sun(light) != 0; axis++) {
        vxs_i32 origin = VXS_FIELD(w, origin)[axis];
        next           = vxs_walk_plane(VXS_FIELD(w, from)[axis] + VXS_REAL(origin), VXS_FIELD(w, along)[axis], t, next);
        next =
            vxs_walk_plane(VXS_FIELD(w, from)[axis] - VXS_REAL(vxs_walk_side(light) - origin), VXS_FIELD(w, along)[axis], t, next);
    }
    if (vxs_walk_is_sun(light) == 0) {
        next = vxs_walk_quadrics(light, VXS_FIELD(w, from), VXS_FIELD(w, along), t, next);
        for (vxs_i32 a = 0; a < 3 && VXS_IS_CUBE(light); a++) {
            vxs_i32  b      = (a + 1) % 3;
            vxs_real from_a = VXS_FIELD(w, from)[a], from_b = VXS_FIELD(w, from)[b];
            vxs_real along_a = VXS_FIELD(w, along)[a], along_b = VXS_FIELD(w, along)[b];
            next = vxs_walk_plane(from_a - from_b, along_a - along_b, t, next);
            next = vxs_walk_plane(from_a + from_b, along_a + along_b, t, next);
        }
    }
    return next;
}

/* maps ------------------------------------------------------------------------------------------------------------------------- */

/* A coordinate in light space at t; t may be infinite. */
VXS_FN vxs_real vxs_walk_ls(VXS_WALK w, vxs_i32 axis, vxs_real t)
{
    vxs_real from = VXS_FIELD(w, from)[axis] + VXS_REAL(VXS_FIELD(w, origin)[axis]), along = VXS_FIELD(w, along)[axis];
    return along != 0.0 ? from + along * t : from;
}

/* The map that contains a point of light space, or -1. */
VXS_FN vxs_i32 vxs_walk_map_at(VXS_LIGHT light, const vxs_real3 ls)
{
    vxs_real side = VXS_REAL(vxs_walk_side(light));
    if (vxs_walk_is_sun(light) == 0)
        return vxs_in_reach(light, ls) != 0 ? vxs_map_from_ls(light, ls) : -1;
    else if (!(ls[0] >= 0.0 && ls[0] < side && ls[1] >= 0.0 && ls[1] < side))
        return -1;
    else
        return (VXS_FIELD(light, flags) & VXS_LIGHT_BOUNDED) == 0u || (ls[2] >= 0.0 && ls[2] < side) ? 0 : -1;
}

/* A coordinate as an integer, rounded down. Like vxs_clamped, but without floor, which not all processors have. */
VXS_INLINE vxs_i32 vxs_walk_floor(vxs_real coordinate)
{
    vxs_real limit = VXS_REAL(1 << 30);
    if (!(coordinate > -limit)) return -(1 << 30);
    if (!(coordinate < limit)) return 1 << 30;
    vxs_i32 n = VXS_I(coordinate);
    return VXS_REAL(n) > coordinate ? n - 1 : n;
}

/* Texel of the ray at t, across or down; `along` is its distance from the light there. Rounding may give a texel outside the
 * map. */
VXS_INLINE vxs_i32 vxs_walk_texel(VXS_LIGHT light, VXS_WALK w, vxs_i32 axis, vxs_real t, vxs_real along)
{
    vxs_real at = VXS_FIELD(w, p)[axis] + VXS_FIELD(w, d)[axis] * t;
    if (vxs_walk_is_sun(light) != 0)
        return VXS_FIELD(w, origin)[axis] + vxs_walk_floor(at);
    else
        return vxs_walk_floor(vxs_punctual_coordinate(light, at, along > VXS_REAL_MIN ? along : VXS_REAL(VXS_REAL_MIN)));
}

/* Depth of the ray in voxels, at distance `along` from the light. */
VXS_INLINE vxs_i32 vxs_walk_depth(VXS_LIGHT light, VXS_WALK w, vxs_real along)
{
    if (vxs_walk_is_sun(light) == 0) {
        along = along > VXS_REAL_MIN ? along : VXS_REAL(VXS_REAL_MIN);
        return vxs_walk_floor(log(along / VXS_FIELD(light, near_metres)) / VXS_FIELD(light, voxel_metres));
    } else {
        vxs_i32 k = VXS_FIELD(w, origin)[2] + vxs_walk_floor(along);
        return (VXS_FIELD(light, flags) & VXS_LIGHT_BOUNDED) != 0u ? vxs_clamp(k, 0, vxs_walk_side(light) - 1) : k;
    }
}

/* For a sun, light space starts at the voxel that contains the world's origin; the origin's place in that voxel is known to
 * 2^-20 voxel. So floats are as precise for rays near the origin as at the first texel of the map, wherever in the map the
 * origin is. Doubles need no such offset. */
#ifdef VXS_C
#define vxs_walk_origin(light, row) 0
#define vxs_walk_rest(light, row)   0.0
#else
VXS_FN vxs_i32 vxs_walk_origin(VXS_LIGHT light, vxs_i32 row)
{
    return vxs_walk_is_sun(light) != 0 ? vxs_clamp(vxs_walk_floor(VXS_LS_FROM_WS(light, row, 3)), -(1 << 23), 1 << 23) : 0;
}

VXS_FN vxs_real vxs_walk_rest(VXS_LIGHT light, vxs_i32 row)
{
    vxs_u32 rest =
        row == 2 ? VXS_FIELD(light, origin_fraction_k) << 16u : VXS_FIELD(light, origin_fraction_ij) << (row == 0 ? 16u : 0u);
    return VXS_REAL(VXS_I(rest) >> 16) / 1048576.0;
}
#endif

VXS_FN vxs_i32 vxs_walk_sign(vxs_real x)
{
    return x > 0.0 ? 1 : x < 0.0 ? -1 : 0;
}

/* A place between two cuts: the middle; or, if that is very far away, a nearer place. At very large distances rounding would
 * decide which of two maps contains the place. */
VXS_FN vxs_real vxs_walk_within(VXS_LIGHT light, VXS_WALK w, vxs_real first, vxs_real next)
{
    vxs_real size = VXS_REAL(vxs_walk_side(light)), speed = VXS_REAL(0.0), middle = 0.5 * next - 0.5 * first;
    for (vxs_i32 n = 0; n < 3; n++) {
        vxs_real from = vxs_abs(vxs_walk_ls(w, n, VXS_REAL(0.0))), along = vxs_abs(VXS_FIELD(w, along)[n]);
        size  = from > size ? from : size;
        speed = along > speed ? along : speed;
    }
    vxs_real far = speed > 0.0 ? vxs_abs(first) + 8.0 * size / speed : VXS_REAL(1.0);
    return first + (middle < far ? middle : far);
}

/* Set the voxel from the place of the ray at t, which is finite. */
VXS_FN void vxs_walk_place(VXS_LIGHT light, VXS_WALK w, vxs_real t)
{
    vxs_real z    = VXS_FIELD(w, p)[2] + VXS_FIELD(w, d)[2] * t;
    vxs_i32  last = vxs_walk_side(light) - 1;
    for (vxs_i32 axis = 0; axis < 2; axis++) VXS_FIELD(w, voxel)[axis] = vxs_clamp(vxs_walk_texel(light, w, axis, t, z), 0, last);
    VXS_FIELD(w, voxel)[2] = vxs_walk_depth(light, w, z);
}

/* Enter the map behind a cut: set its space, the voxel, and the direction of each coordinate. For a punctual light u is x /
 * z, so its direction is the sign of x' z - x z'. */
VXS_FN void vxs_walk_pass_cut(VXS_LIGHT light, VXS_WALK w)
{
    vxs_real  t = VXS_FIELD(w, t);
    vxs_real3 middle;
    VXS_FIELD(w, cut) = vxs_walk_next_cut(light, w, t);
    vxs_real within   = vxs_walk_within(light, w, t, VXS_FIELD(w, cut));
    for (vxs_i32 n = 0; n < 3; n++) middle[n] = vxs_walk_ls(w, n, within);
    VXS_FIELD(w, map)           = vxs_walk_map_at(light, middle);
    VXS_FIELD(w, block).side_px = 0;
    VXS_FIELD(w, square_i)      = -1;
    VXS_FIELD(w, tile_i)        = -1;
    VXS_FIELD(w, in_tile)       = 0;
    if (VXS_FIELD(w, map) < 0) return;
    for (vxs_i32 n = 0; n < 3; n++) {
        VXS_FIELD(w, p)[n] = VXS_FIELD(w, from)[n];
        VXS_FIELD(w, d)[n] = VXS_FIELD(w, along)[n];
    }
    if (vxs_walk_is_sun(light) == 0) {
        vxs_i32 face = vxs_face_of_map(light, VXS_FIELD(w, map));
        vxs_face_from_ls(face, VXS_FIELD(w, from), VXS_FIELD(w, p));
        vxs_face_from_ls(face, VXS_FIELD(w, along), VXS_FIELD(w, d));
    }
    vxs_real z = VXS_FIELD(w, p)[2], dz = VXS_FIELD(w, d)[2];
    for (vxs_i32 axis = 0; axis < 3; axis++) {
        vxs_real d = VXS_FIELD(w, d)[axis];
        if (vxs_walk_is_sun(light) == 0 && axis < 2) d = d * z - VXS_FIELD(w, p)[axis] * dz;
        VXS_FIELD(w, per_d)[axis] = 1.0 / d;
        VXS_FIELD(w, way)[axis]   = vxs_abs(d) > VXS_REAL_MIN ? vxs_walk_sign(d) : 0;
    }
    vxs_walk_place(light, w, t);
}

/* Where the ray, from t on, crosses texel border `border`, across or down, in its direction; VXS_NEVER: nowhere. Borders of
 * the map are cuts, and are not found here. */
VXS_INLINE vxs_real vxs_walk_cross(VXS_LIGHT light, VXS_WALK w, vxs_i32 axis, vxs_i32 border, vxs_real t)
{
    vxs_i32  side = vxs_walk_side(light), way = VXS_FIELD(w, way)[axis];
    vxs_real p = VXS_FIELD(w, p)[axis], d = VXS_FIELD(w, d)[axis];
    if (way == 0 || VXS_U(border - 1) >= VXS_U(side - 1)) return VXS_REAL(VXS_NEVER);
    if (vxs_walk_is_sun(light) != 0) {
        vxs_real at = (VXS_REAL(border - VXS_FIELD(w, origin)[axis]) - p) * VXS_FIELD(w, per_d)[axis];
        return at > t ? at : t;
    } else {
        vxs_real slope = (VXS_REAL(border) - 0.5 * VXS_REAL(side)) * VXS_FIELD(light, texel_metres);
        p -= slope * VXS_FIELD(w, p)[2];
        d -= slope * VXS_FIELD(w, d)[2];
        if (VXS_REAL(way) * (d != 0.0 ? p + d * t : p) >= 0.0) return t;
        if (!(VXS_REAL(way) * d > 0.0)) return VXS_REAL(VXS_NEVER);
        return -p / d > t ? -p / d : t;
    }
}

/* The same for a voxel border in depth, nearer or deeper. */
VXS_INLINE vxs_real vxs_walk_cross_depth(VXS_LIGHT light, VXS_WALK w, vxs_i32 border, vxs_real t)
{
    vxs_real z = VXS_REAL(border - VXS_FIELD(w, origin)[2]);
    if (vxs_walk_is_sun(light) == 0) z = VXS_FIELD(light, near_metres) * exp(z * VXS_FIELD(light, voxel_metres));
    vxs_real at = (z - VXS_FIELD(w, p)[2]) * VXS_FIELD(w, per_d)[2];
    return at > t ? at : t;
}

/* boxes ------------------------------------------------------------------------------------------------------------------------ */

/* A coordinate computed with rounding: clamped to [first, end), and not allowed to go back. */
VXS_FN vxs_i32 vxs_walk_on(vxs_i32 was, vxs_i32 at, vxs_i32 way, vxs_i32 first, vxs_i32 end)
{
    if (way > 0) return vxs_clamp(at, was, end - 1);
    return way < 0 ? vxs_clamp(at, first, was) : was;
}

/* Move from t to where the ray leaves a box, but not beyond the cut. */
VXS_FN void vxs_walk_leave(VXS_LIGHT light, VXS_WALK w, vxs_walk_box box)
{
    vxs_real t = VXS_FIELD(w, t), first = VXS_FIELD(w, cut);
    vxs_i32  u = VXS_FIELD(w, way)[0], v = VXS_FIELD(w, way)[1], k = VXS_FIELD(w, way)[2], through = -1;
    vxs_i32  end_i = box.i + box.side_px, end_j = box.j + box.side_px, border = k > 0 ? box.far : box.near;
    vxs_real crossed = vxs_walk_cross(light, w, 0, u > 0 ? end_i : box.i, t);
    if (crossed < first) {
        first   = crossed;
        through = 0;
    }
    crossed = vxs_walk_cross(light, w, 1, v > 0 ? end_j : box.j, t);
    if (crossed < first) {
        first   = crossed;
        through = 1;
    }
    if (k != 0 && border < VXS_NO_BORDER && border > -VXS_NO_BORDER) {
        crossed = vxs_walk_cross_depth(light, w, border, t);
        if (crossed < first) {
            first   = crossed;
            through = 2;
        }
    }
    VXS_FIELD(w, t) = first;
    if (through < 0) return;
    vxs_real z = VXS_FIELD(w, p)[2] + VXS_FIELD(w, d)[2] * first;
    vxs_i32  i = VXS_FIELD(w, voxel)[0], j = VXS_FIELD(w, voxel)[1], depth = VXS_FIELD(w, voxel)[2];
    i = through == 0 ? (u > 0 ? end_i : box.i - 1) : vxs_walk_on(i, vxs_walk_texel(light, w, 0, first, z), u, box.i, end_i);
    j = through == 1 ? (v > 0 ? end_j : box.j - 1) : vxs_walk_on(j, vxs_walk_texel(light, w, 1, first, z), v, box.j, end_j);
    if (through == 2)
        depth = k > 0 ? box.far : box.near - 1;
    else
        depth = vxs_walk_on(depth, vxs_walk_depth(light, w, z), k, box.near, box.far);
    VXS_FIELD(w, voxel)[0] = i;
    VXS_FIELD(w, voxel)[1] = j;
    VXS_FIELD(w, voxel)[2] = depth;
}

/* All is lit in front of the map. Texels are not computed there, because near a punctual light they would be rounding noise. */
VXS_FN vxs_i32 vxs_walk_in_front(VXS_LIGHT light, VXS_WALK w)
{
    vxs_real first = VXS_FIELD(w, cut);
    if (VXS_FIELD(w, way)[2] > 0) first = vxs_walk_cross_depth(light, w, 0, VXS_FIELD(w, t));
    if (first < VXS_FIELD(w, cut)) {
        VXS_FIELD(w, t) = first;
        vxs_walk_place(light, w, first);
        VXS_FIELD(w, voxel)[2] = 0;
    } else
        VXS_FIELD(w, t) = VXS_FIELD(w, cut);
    return VXS_SPAN_LIT;
}

/* Depth of the ray, clamped to the map: what lies behind the map is as its last voxels. */
VXS_FN vxs_i32 vxs_walk_in_map(VXS_LIGHT light, vxs_i32 k)
{
    vxs_i32 last = vxs_walk_side(light) - 1;
    return k < last ? k : last;
}

/* Whether depth k is outside the bounds of a square, so that the bounds give its state. */
VXS_INLINE vxs_i32 vxs_walk_decides(VXS_SQUARE s, vxs_i32 k)
{
    return k < VXS_FIELD(s, least) || k >= VXS_FIELD(s, greatest) ? 1 : 0;
}

/* The part of a square with the same state as depth k. In a coarse square, depths before `low` and from `high` on are exact. */
VXS_FN vxs_walk_box vxs_walk_box_in(VXS_LIGHT light, VXS_SQUARE s, vxs_i32 k)
{
    vxs_walk_box box;
    vxs_i32      side = vxs_walk_side(light), low = VXS_FIELD(s, low), high = VXS_FIELD(s, high),
            is_coarse = k >= low && k < high ? 1 : 0;
    box.i             = VXS_FIELD(s, i);
    box.j             = VXS_FIELD(s, j);
    box.side_px       = VXS_FIELD(s, side_px);
    box.near          = 0;
    box.far           = side;
    if (VXS_FIELD(s, coarse) == 0 || is_coarse != 0) {
        if (VXS_FIELD(s, coarse) != 0) box.near = low;
        if (VXS_FIELD(s, coarse) != 0) box.far = high;
        box.state = k < VXS_FIELD(s, least) ? VXS_SPAN_LIT : VXS_SPAN_SHADOW;
        if (box.state == VXS_SPAN_LIT)
            box.far = VXS_FIELD(s, least);
        else
            box.near = VXS_FIELD(s, greatest);
        if (VXS_FIELD(s, coarse) != 0) box.state += VXS_SPAN_COARSE;
    } else if (k < low) {
        box.far   = low;
        box.state = VXS_SPAN_LIT;
    } else {
        box.near  = high;
        box.state = VXS_SPAN_SHADOW;
    }
    if (box.far == side) box.far = VXS_NO_BORDER;
    if (box.near == 0 && (VXS_FIELD(light, flags) & VXS_LIGHT_BOUNDED) != 0u) box.near = -VXS_NO_BORDER;
    return box;
}

/* tiles ------------------------------------------------------------------------------------------------------------------------ */

/* Leave a tile through the border that was crossed at t: along u (axis 0) or v (axis 1). */
VXS_INLINE void vxs_walk_into_next(VXS_LIGHT light, VXS_WALK w, vxs_i32 axis, vxs_real t)
{
    vxs_i32  other = 1 - axis, i = VXS_FIELD(w, voxel)[other], way = VXS_FIELD(w, way)[other];
    vxs_real z                 = VXS_FIELD(w, p)[2] + VXS_FIELD(w, d)[2] * t;
    vxs_i32  at                = vxs_walk_texel(light, w, other, t, z);
    vxs_i32  u                 = VXS_FIELD(w, voxel)[axis];
    VXS_FIELD(w, voxel)[other] = vxs_walk_on(i, at, way, i & ~7, (i & ~7) + 8);
    VXS_FIELD(w, voxel)[axis]  = VXS_FIELD(w, way)[axis] > 0 ? (u | 7) + 1 : (u & ~7) - 1;
}

/* The next border in the direction of the ray, of the squares of side_px texels. */
VXS_FN vxs_i32 vxs_walk_ahead(vxs_i32 i, vxs_i32 way, vxs_i32 side_px)
{
    return (i & -side_px) + (way > 0 ? side_px : 0);
}

/* Pass a tile in one step, or enter its texels. */
VXS_INLINE vxs_i32 vxs_walk_through_tile(VXS_LIGHT light, VXS_WALK w)
{
    vxs_real t = VXS_FIELD(w, t), cut = VXS_FIELD(w, cut);
    vxs_i32  i = VXS_FIELD(w, voxel)[0], j = VXS_FIELD(w, voxel)[1], k = VXS_FIELD(w, voxel)[2], way = VXS_FIELD(w, way)[2];
    vxs_real u      = vxs_walk_cross(light, w, 0, vxs_walk_ahead(i, VXS_FIELD(w, way)[0], 8), t);
    vxs_real v      = vxs_walk_cross(light, w, 1, vxs_walk_ahead(j, VXS_FIELD(w, way)[1], 8), t);
    vxs_real across = u < v ? u : v, last = across < cut ? across : cut;
    vxs_i32  k_last = k, state;
    if (way != 0) {
        k_last = vxs_walk_depth(light, w, VXS_FIELD(w, p)[2] + VXS_FIELD(w, d)[2] * last);
        k_last = (way > 0 ? k_last > k : k_last < k) ? k_last : k;
    }
    vxs_i32 nearest = vxs_walk_in_map(light, way > 0 ? k : k_last), farthest = vxs_walk_in_map(light, way > 0 ? k_last : k);
    if (farthest < VXS_FIELD(w, least))
        state = VXS_SPAN_LIT;
    else if (nearest >= VXS_FIELD(w, greatest))
        state = VXS_SPAN_SHADOW;
    else {
        VXS_FIELD(w, in_tile)  = 1;
        VXS_FIELD(w, next)[0]  = vxs_walk_cross(light, w, 0, vxs_walk_ahead(i, VXS_FIELD(w, way)[0], 1), t);
        VXS_FIELD(w, next)[1]  = vxs_walk_cross(light, w, 1, vxs_walk_ahead(j, VXS_FIELD(w, way)[1], 1), t);
        VXS_FIELD(w, nearest)  = way > 0 ? k : k_last;
        VXS_FIELD(w, farthest) = way > 0 ? k_last : k;
        return VXS_SPAN_NONE;
    }
    VXS_FIELD(w, t)        = last;
    VXS_FIELD(w, voxel)[2] = k_last;
    if (across < cut) vxs_walk_into_next(light, w, u < v ? 0 : 1, across);
    return state;
}

/* Move to the end of a texel, or to where the ray crosses its depth. After that only the border on the crossed axis changes. */
VXS_INLINE vxs_i32 vxs_walk_through_texel(VXS_WORDS blocks, VXS_LIGHT light, VXS_WALK w)
{
    vxs_i32  i = VXS_FIELD(w, voxel)[0], j = VXS_FIELD(w, voxel)[1], way = VXS_FIELD(w, way)[2], state;
    vxs_i32  depth = VXS_FIELD(w, least);
    vxs_real t = VXS_FIELD(w, t), cut = VXS_FIELD(w, cut);
    vxs_i32  axis   = VXS_FIELD(w, next)[1] < VXS_FIELD(w, next)[0] ? 1 : 0;
    vxs_real across = VXS_FIELD(w, next)[axis], next = across < cut ? across : cut;
#ifdef VXS_TABLES
    if (depth != w.greatest)
        depth = clamp(w.tile_base + int(vxs_table_delta(w.tile_record, uint(i & 7), uint(j & 7))), 0, vxs_walk_side(light));
#else
    if (depth != VXS_FIELD(w, greatest))
        depth = vxs_depths_texel(blocks, VXS_REF_OF(w, tile), depth, VXS_FIELD(w, greatest), VXS_U(i & 7), VXS_U(j & 7));
#endif
    if (depth == vxs_walk_side(light) || depth > VXS_FIELD(w, farthest))
        state = VXS_SPAN_LIT;
    else if (way == 0 || depth <= VXS_FIELD(w, nearest))
        state = VXS_SPAN_SHADOW;
    else {
        vxs_real at = vxs_walk_cross_depth(light, w, depth, t);
        state       = (at > t) == (way > 0) ? VXS_SPAN_LIT : VXS_SPAN_SHADOW;
        if (at > t && at < next) {
            VXS_FIELD(w, t) = at;
            return state;
        }
    }
    VXS_FIELD(w, t) = next;
    if (across < cut) {
        vxs_i32 was = VXS_FIELD(w, voxel)[axis], now = was + VXS_FIELD(w, way)[axis];
        VXS_FIELD(w, voxel)[axis] = now;
        if (((was ^ now) & ~7) == 0) {
            VXS_FIELD(w, next)[axis] = vxs_walk_cross(light, w, axis, vxs_walk_ahead(now, VXS_FIELD(w, way)[axis], 1), next);
            return state;
        }
        VXS_FIELD(w, voxel)[2] = way > 0 ? VXS_FIELD(w, farthest) : VXS_FIELD(w, nearest);
    }
    VXS_FIELD(w, in_tile) = 0;
    return state;
}

/* palette blocks --------------------------------------------------------------------------------------------------------------- */

#ifdef VXS_TABLES

/* Find bounds of the square about the voxel if they decide its depth, else of the block. */
void vxs_walk_find_block(uint words, vxs_light_constants light, inout vxs_walk w)
{
    int               i = w.voxel[0], j = w.voxel[1], side = vxs_walk_side(light);
    vxs_depths_square s = w.square;
    w.tile_i            = -1;
    if (w.square_i != i >> 8 || w.square_j != j >> 8) {
        uint root = vxs_root_of(words, light, w.map), word = vxs_table_square(root, light.levels, uint(i >> 8), uint(j >> 8));
        s.side_px = min(side, 256);
        s.i       = i & -s.side_px;
        s.j       = j & -s.side_px;
        s.coarse  = 0;
        s.low     = 0;
        s.high    = side;
        s.least = s.greatest = min(int(word & 0x7fffffffu), side);
#ifdef VXS_GL_STREAM
        uint top = vxs_table_top(root, light.levels, uint(i >> 8), uint(j >> 8)), up = max(light.levels, 8u) - 8u;
        if (vxs_table_is_missing(top)) {
            s.coarse = 1;
            s.low    = min(int((top & 0xffu) << up), side);
            s.high   = min(int((((top >> 8) & 0xffu) + 1u) << up), side);
        }
#endif
        if (word < 0x80000000u) {
            w.slope    = vxs_word(word, 0u);
            s.least    = clamp(int(vxs_word(word, 1u)), 0, side);
            s.greatest = clamp(int(vxs_word(word, 2u)), s.least, side);
        }
        w.node     = word;
        w.square   = s;
        w.square_i = i >> 8;
        w.square_j = j >> 8;
    }
    w.is_block = 0;
    w.block    = s;
    if (s.least == s.greatest || vxs_walk_decides(s, vxs_walk_in_map(light, w.voxel[2])) != 0) return;
    w.block_word = vxs_word(w.node, uint(4 + ((i >> 5) & 7) + 8 * ((j >> 5) & 7)));
    s.side_px    = min(s.side_px, 32);
    s.i          = i & -s.side_px;
    s.j          = j & -s.side_px;
    if (w.block_word < 0x80000000u) {
        s.least    = clamp(int(vxs_word(w.block_word, 0u)), 0, side);
        s.greatest = clamp(int(vxs_word(w.block_word, 1u)), s.least, side);
    } else { /* least and greatest in two corners */
        int x = (s.i >> 3) & 31, y = (s.j >> 3) & 31, last = s.side_px / 8 - 1, depth = int(w.block_word & 0x7fffffffu);
        int left = (w.slope & 0x8000u) != 0u ? last : 0, up = w.slope >= 0x80000000u ? last : 0;
        s.least    = clamp(depth - vxs_table_slope(w.slope, x + last - left, y + last - up), 0, side);
        s.greatest = clamp(depth - vxs_table_slope(w.slope, x + left, y + up), s.least, side);
    }
    w.block    = s;
    w.is_block = 1;
}

void vxs_walk_find_tile(vxs_light_constants light, inout vxs_walk w)
{
    int x = w.voxel[0] >> 3, y = w.voxel[1] >> 3, side = vxs_walk_side(light);
    if (w.tile_i == x && w.tile_j == y) return;
    w.tile_i      = x;
    w.tile_j      = y;
    w.tile_base   = int(w.block_word & 0x7fffffffu);
    w.tile_record = 0u;
    if (w.block_word < 0x80000000u) {
        uint at       = w.block_word + uint(2 + 2 * ((x & 3) | ((y & 3) << 2)));
        w.tile_base   = int(vxs_word(at, 0u));
        w.tile_record = vxs_word(at, 1u);
    }
    w.tile_base -= vxs_table_slope(w.slope, x & 31, y & 31);
    w.least    = clamp(w.tile_base, 0, side);
    w.greatest = clamp(w.tile_base + int(vxs_table_last(w.tile_record)), w.least, side);
}

#else

/* Find bounds of the square about the voxel if they decide its depth, else of the block. */
VXS_FN void vxs_walk_find_block(VXS_WORDS blocks, VXS_LIGHT light, VXS_WALK w)
{
    vxs_i32 i = VXS_FIELD(w, voxel)[0], j = VXS_FIELD(w, voxel)[1], k = vxs_walk_in_map(light, VXS_FIELD(w, voxel)[2]);
    vxs_u32 map = VXS_U(VXS_FIELD(w, map)), levels = VXS_FIELD(light, levels);
    VXS_FIELD(w, tile_i) = -1;
    if (VXS_FIELD(w, square_i) != i >> 8 || VXS_FIELD(w, square_j) != j >> 8) {
        VXS_FIELD(w, square) = vxs_depths_square_at(blocks, map, levels, i, j);
        VXS_FIELD(w, square_i) = i >> 8;
        VXS_FIELD(w, square_j) = j >> 8;
        VXS_FIELD(w, has_node) = 0;
    }
    vxs_depths_square s = VXS_FIELD(w, square);
    VXS_FIELD(w, is_block) = 0;
    if (s.least == s.greatest || k < s.least || k >= s.greatest) {
        VXS_FIELD(w, block) = s;
        return;
    }
    if (VXS_FIELD(w, has_node) == 0) VXS_FIELD(w, node) = vxs_depths_node_of(blocks, map, levels, i, j, s.least);
    VXS_FIELD(w, has_node) = 1;
    VXS_FIELD(w, record) = vxs_blocks_find_block(blocks, VXS_FIELD(w, node), VXS_U(((i >> 5) & 7) | (((j >> 5) & 7) << 3)));
    s.side_px = s.side_px < 32 ? s.side_px : 32;
    s.i = i & -s.side_px;
    s.j = j & -s.side_px;
    vxs_depths_bounds b = vxs_depths_bound_block(blocks, VXS_FIELD(w, node), VXS_FIELD(w, record), (s.i >> 3) & 28, (s.j >> 3) & 28,
                                                 s.side_px / 8 - 1, s.least, s.greatest);
    s.least = b.least;
    s.greatest = b.greatest;
    VXS_FIELD(w, block) = s;
    VXS_FIELD(w, is_block) = 1;
}

VXS_FN void vxs_walk_find_tile(VXS_WORDS blocks, VXS_WALK w)
{
    vxs_i32 x = VXS_FIELD(w, voxel)[0] >> 3, y = VXS_FIELD(w, voxel)[1] >> 3;
    if (VXS_FIELD(w, tile_i) == x && VXS_FIELD(w, tile_j) == y) return;
    VXS_FIELD(w, tile_i) = x;
    VXS_FIELD(w, tile_j) = y;
#ifdef VXS_C /* most tiles need no more; a shader has this code once, in vxs_depths_tile_of */
    if ((((VXS_FIELD(w, record).mixed | VXS_FIELD(w, record).own) >> VXS_U((x & 3) | ((y & 3) << 2))) & 1u) == 0u) {
        VXS_FIELD(w, least) = vxs_depths_whole(blocks, VXS_FIELD(w, node), VXS_FIELD(w, record), x & 31, y & 31,
                                               VXS_FIELD(w, square).least, VXS_FIELD(w, square).greatest);
        VXS_FIELD(w, greatest) = VXS_FIELD(w, least);
        return;
    }
#endif
    VXS_FIELD(w, tile) = vxs_depths_tile_of(blocks, VXS_FIELD(w, node), VXS_FIELD(w, record), x & 31, y & 31,
                                            VXS_FIELD(w, square).least, VXS_FIELD(w, square).greatest);
    vxs_depths_bounds b = vxs_depths_bound(blocks, VXS_REF_OF(w, tile));
    VXS_FIELD(w, least) = b.least;
    VXS_FIELD(w, greatest) = b.greatest;
}

#endif

VXS_INLINE vxs_i32 vxs_walk_in_blocks(VXS_WORDS blocks, VXS_LIGHT light, VXS_WALK w)
{
    vxs_i32 i = VXS_FIELD(w, voxel)[0], j = VXS_FIELD(w, voxel)[1], k = VXS_FIELD(w, voxel)[2];
    vxs_i32 side_px = VXS_FIELD(w, block).side_px;
    k               = vxs_walk_in_map(light, k); /* a square that is no block was kept for a depth, and may not decide this one */
    if (side_px == 0 || (((i ^ VXS_FIELD(w, block).i) | (j ^ VXS_FIELD(w, block).j)) & -side_px) != 0 ||
        (VXS_FIELD(w, is_block) == 0 && vxs_walk_decides(VXS_REF_OF(w, block), k) == 0))
        vxs_walk_find_block(blocks, light, w);
    if (vxs_walk_decides(VXS_REF_OF(w, block), k) != 0) {
        vxs_walk_box box = vxs_walk_box_in(light, VXS_REF_OF(w, block), k);
        vxs_walk_leave(light, w, box);
        return box.state;
    }
#ifdef VXS_TABLES
    vxs_walk_find_tile(light, w);
#else
    vxs_walk_find_tile(blocks, w);
#endif
    return vxs_walk_through_tile(light, w);
}

/* DAGs ------------------------------------------------------------------------------------------------------------------------- */

/* The largest uniform node about a voxel; in a slice with a mask, the single voxel. */
VXS_FN vxs_walk_box vxs_walk_box_of_dag(VXS_WORDS dag, VXS_LIGHT light, vxs_i32 map, vxs_i32 i, vxs_i32 j, vxs_i32 k)
{
    vxs_walk_box box;
    vxs_u32      node = vxs_root_of(dag, light, map), state = 2u, states;
    vxs_u32      bit = VXS_FIELD(light, levels);
    while (state >= 2u && bit > 3u) {
        bit--;
        vxs_u32 xy = ((VXS_U(i) >> bit) & 1u) | (((VXS_U(j) >> bit) & 1u) << 1), c = xy | (((VXS_U(k) >> bit) & 1u) << 2);
        states = vxs_word(dag, node);
        state  = (states >> (2u * c)) & 3u;
        if (state == 3u) c = xy; /* VXS_CHILD_SAME: the sibling with z = 0 owns the offset */
        if (state >= 2u) node = vxs_word(dag, node + 1u + vxs_popcount(vxs_own(states) & ((1u << (2u * c)) - 1u)));
    }
    box.side_px = VXS_I(1) << bit;
    box.near    = k & -box.side_px;
    box.far     = box.near + box.side_px;
    if (state >= 2u) {
        vxs_u32 slice = VXS_U(k) & 7u;
        states        = vxs_word(dag, node);
        state         = (states >> (2u * slice)) & 3u;
        if (state >= 2u) { /* the last slice at or before this one that owns a mask */
            vxs_u32 at  = vxs_word(dag, node + vxs_popcount(vxs_own(states) & ((2u << (2u * slice)) - 1u)));
            state       = (vxs_word(dag, at + ((VXS_U(j) >> 2) & 1u)) >> ((VXS_U(i) & 7u) + 8u * (VXS_U(j) & 3u))) & 1u;
            box.side_px = 1;
        }
        box.near = k;
        box.far  = k + 1;
    }
    box.i     = i & -box.side_px;
    box.j     = j & -box.side_px;
    box.state = state == 0u ? VXS_SPAN_LIT : VXS_SPAN_SHADOW;
    if (box.far == vxs_walk_side(light)) box.far = VXS_NO_BORDER;
    if (box.near == 0 && (VXS_FIELD(light, flags) & VXS_LIGHT_BOUNDED) != 0u) box.near = -VXS_NO_BORDER;
    return box;
}

VXS_FN vxs_i32 vxs_walk_in_dag(VXS_WORDS dag, VXS_LIGHT light, VXS_WALK w)
{
    vxs_i32      k   = vxs_walk_in_map(light, VXS_FIELD(w, voxel)[2]);
    vxs_walk_box box = vxs_walk_box_of_dag(dag, light, VXS_FIELD(w, map), VXS_FIELD(w, voxel)[0], VXS_FIELD(w, voxel)[1], k);
    vxs_walk_leave(light, w, box);
    return box.state;
}

/* the walk --------------------------------------------------------------------------------------------------------------------- */

/* One step to where the state may change; not inside a tile. Returns the state of what was passed; VXS_SPAN_NONE: nothing
 * was passed. */
VXS_INLINE vxs_i32 vxs_walk_step(VXS_WORDS words, VXS_LIGHT light, VXS_WALK w)
{
    if (!(VXS_FIELD(w, t) < VXS_FIELD(w, cut))) vxs_walk_pass_cut(light, w);
    if (VXS_FIELD(w, map) < 0) {
        VXS_FIELD(w, t) = VXS_FIELD(w, cut);
        return VXS_FIELD(w, outside);
    }
    if (VXS_FIELD(w, voxel)[2] < 0) return vxs_walk_in_front(light, w);
    if (VXS_CODING(light) == VXS_CODING_BLOCKS)
        return vxs_walk_in_blocks(words, light, w);
    else
        return vxs_walk_in_dag(words, light, w);
}

/* The walk passed from `from` to t in state `next`. Returns 1 if this ends an interval of the wanted state; then `span` is
 * that interval. */
VXS_INLINE vxs_i32 vxs_walk_passed(VXS_WALK w, vxs_real from, vxs_i32 next, vxs_i32 only, VXS_SPAN_INOUT span)
{
    vxs_i32 was = VXS_FIELD(w, state);
    VXS_FIELD(w, steps) -= 1;
    if (VXS_FIELD(w, steps) < 0) VXS_FIELD(w, t) = VXS_FIELD(w, end);
    if (!(VXS_FIELD(w, t) > from) || next == was) return 0;
    VXS_FIELD(span, begin) = VXS_FIELD(w, begin);
    VXS_FIELD(span, end)   = from;
    VXS_FIELD(span, state) = was;
    VXS_FIELD(w, state)    = next;
    VXS_FIELD(w, begin)    = from;
    return was != VXS_SPAN_NONE && (only == VXS_SPAN_NONE || (was & 3) == only) ? 1 : 0;
}

/* Start a walk at t_begin.
 * origin_ws, direction_ws  metres, as for vxs_place_from_ws; the direction may have any length; with length 1, t is in
 *                          metres
 * t_begin, t_end           finite in shaders; t_end < t_begin: the walk is empty */
VXS_FN vxs_walk vxs_walk_of(VXS_LIGHT light, const vxs_real3 origin_ws, const vxs_real3 direction_ws, vxs_real t_begin,
                            vxs_real t_end)
{
    vxs_walk w;
    for (vxs_i32 row = 0; row < 3; row++) {
        w.origin[row] = vxs_walk_origin(light, row);
        vxs_real at   = (VXS_LS_FROM_WS(light, row, 3) - VXS_REAL(w.origin[row])) + vxs_walk_rest(light, row);
        w.from[row]   = vxs_ls_coordinate(light, row, origin_ws, VXS_REAL(0.0)) + at;
        w.along[row]  = vxs_ls_coordinate(light, row, direction_ws, VXS_REAL(0.0));
    }
    w.t = w.cut = w.begin = t_begin;
    w.end                 = t_end;
    w.state               = VXS_SPAN_NONE;
    w.steps               = VXS_WALK_STEPS * vxs_walk_side(light);
    w.pause               = 0;
    w.outside             = VXS_SPAN_OUTSIDE;
    w.map                 = -1;
    w.in_tile             = 0;
    return w;
}

/* The next interval, or the next one in state `only`. Texels have a loop of their own, because of many rays side by side few
 * are in tiles at one time.
 * only  VXS_SPAN_NONE: any state */
VXS_INLINE vxs_i32 vxs_walk_next_of(VXS_WORDS words, VXS_LIGHT light, VXS_WALK w, vxs_i32 only, VXS_SPAN span)
{
    vxs_i32  found = 0, was;
    vxs_span s;
    s.begin = s.end = VXS_FIELD(w, begin);
    s.state         = VXS_SPAN_NONE;
    while (found == 0 && VXS_FIELD(w, t) < VXS_FIELD(w, end) && VXS_FIELD(w, steps) >= VXS_FIELD(w, pause)) {
        vxs_real from = VXS_FIELD(w, t);
        if (VXS_FIELD(w, in_tile) == 0) {
            vxs_i32 next = vxs_walk_step(words, light, w);
            found        = vxs_walk_passed(w, from, next, only, VXS_REF(s));
        }
        while (VXS_CODING(light) == VXS_CODING_BLOCKS && found == 0 && VXS_FIELD(w, in_tile) != 0 &&
               VXS_FIELD(w, t) < VXS_FIELD(w, end) && VXS_FIELD(w, steps) >= VXS_FIELD(w, pause)) {
            from         = VXS_FIELD(w, t);
            vxs_i32 next = vxs_walk_through_texel(words, light, w);
            found        = vxs_walk_passed(w, from, next, only, VXS_REF(s));
        }
    }
    was = VXS_FIELD(w, state);
    if (found == 0 && was != VXS_SPAN_NONE) { /* the last interval */
        s.begin             = VXS_FIELD(w, begin);
        s.end               = VXS_FIELD(w, t);
        s.state             = was;
        found               = s.end > s.begin && (only == VXS_SPAN_NONE || (was & 3) == only) ? 1 : 0;
        VXS_FIELD(w, begin) = s.end;
        VXS_FIELD(w, state) = VXS_SPAN_NONE;
    }
    VXS_FIELD(span, begin)  = s.begin;
    VXS_FIELD(span, end)    = s.end;
    VXS_FIELD(span, state)  = s.state & 3;
    VXS_FIELD(span, coarse) = s.state >= VXS_SPAN_COARSE ? 1 : 0;
    return found;
}

/* The next interval of a ray. Intervals follow each other without gaps, from t_begin to t_end; neighbours differ in state. A
 * point in an interval has the same state as a single tap there without a normal, except for rounding near the ends.
 * words  of the light
 * span   [out] valid only if 1 is returned
 * Returns 1; 0: the walk has ended. */
VXS_FN vxs_i32 vxs_walk_next(VXS_WORDS words, VXS_LIGHT light, VXS_WALK w, VXS_SPAN span)
{
    return vxs_walk_next_of(words, light, w, VXS_SPAN_NONE, span);
}

/* The next lit interval. With this function, of many rays side by side none waits for another ray that is in shadow. State
 * outside the volume of the light is w.outside. */
VXS_FN vxs_i32 vxs_walk_next_lit(VXS_WORDS words, VXS_LIGHT light, VXS_WALK w, VXS_SPAN span)
{
    return vxs_walk_next_of(words, light, w, VXS_SPAN_LIT, span);
}

#endif
