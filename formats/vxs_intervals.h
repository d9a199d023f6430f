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
#define VXS_WALK_IN    const vxs_walk *
#define VXS_SQUARE     const vxs_depths_square *
#define VXS_SPAN       vxs_span *
#define VXS_SPAN_INOUT vxs_span *
#ifndef VXS_NEVER
#define VXS_NEVER INFINITY
#endif
#else
#define VXS_WALK       inout vxs_walk
#define VXS_WALK_IN    const vxs_walk
#define VXS_SQUARE     const vxs_depths_square
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
#define VXS_WALK_ALL   (1 << 30)
#define VXS_NO_BORDER  (1 << 30)

/* A part of a ray, [begin, end), that is all lit, all in shadow, or outside the volume of the light. */
struct vxs_span {
    vxs_real begin, end;
    vxs_i32  state;  /* VXS_SPAN_* */
    vxs_i32  coarse; /* 1: a page is missing, and this is the coarse answer; else 0 */
};

/* The square of side_px texels about the place of a walk, depths [near, far). Below 0 and from the side of the map on there is no
 * end. */
struct vxs_walk_box {
    vxs_i32 side_px, near, far;
    vxs_i32 state; /* VXS_SPAN_*, with VXS_SPAN_COARSE; VXS_SPAN_NONE: a tile with depths of its own, [w.least, w.greatest] */
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
    vxs_i32   placed;     /* 1: `voxel` is that of t; 0: not yet; -1: not yet, and its depth is 0 */
    vxs_int3  voxel, way; /* direction of each coordinate: 1, -1, or 0 */

    vxs_i32 square_i, square_j; /* the known square of 256 x 256 texels; -1: none */
#ifdef VXS_TABLES
#ifdef VXS_GL_STREAM
    ivec2 coarse; /* depths of the square where the answer is coarse; the first is the side of the map: none */
#endif
    ivec2 square, block;                 /* least and greatest depth of the square, and of the known block */
    int   block_i, block_j;              /* -1: none */
    uint  root, node, slope, block_word; /* of the map; the node of the square; its slope; the word of the block */
    uint  tile_record;
    int   tile_base;
    uvec2 dark, shaded; /* in_tile: texels of the tile in shadow at the nearest depth of the ray; at the farthest */
#else
    vxs_depths_square square;
    vxs_depths_square block;    /* bounds of a block or of something larger; side_px 0: none known */
    vxs_i32           is_block; /* 1: they are of a block, which is known */
    vxs_blocks_block  record;
    vxs_i32           has_node; /* 1: its node is known too */
    vxs_blocks_node   node;
    vxs_depths_tile   tile;
#endif
    vxs_i32 least, greatest; /* of the depths of the tile; of tables, `greatest` is known only in_tile */

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
VXS_FN vxs_real vxs_walk_sooner(const vxs_real place, const vxs_real t, const vxs_real next)
{
    return place > t && place < next ? place : next;
}

/* Root of a + b t. */
VXS_FN vxs_real vxs_walk_plane(const vxs_real a, const vxs_real b, const vxs_real t, const vxs_real next)
{
    return vxs_walk_sooner(b != 0.0 ? -a / b : t, t, next);
}

/* Roots of a s^2 + 2 b s + c, where s = t - middle; the sums do not cancel. */
VXS_FN vxs_real vxs_walk_roots(const vxs_real middle, const vxs_real a, const vxs_real b, const vxs_real c, const vxs_real t,
                               const vxs_real next)
{
    vxs_real part = b * b - a * c, first = next;
    if (part >= 0.0) {
        vxs_real far = b < 0.0 ? sqrt(part) - b : -(b + sqrt(part));
        if (a != 0.0) first = vxs_walk_sooner(middle + far / a, t, first);
        if (far != 0.0) first = vxs_walk_sooner(middle + c / far, t, first);
    }
    return first;
}

#ifdef VXS_C
VXS_FN vxs_real vxs_walk_dot(const vxs_real3 a, const vxs_real3 b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
#else
#define vxs_walk_dot(a, b) dot(a, b)
#endif

/* Crossings of the range of a punctual light and of the cone of a spot. They are computed from the point of the ray nearest
 * the light, so that a large distance from it costs no precision. */
VXS_FN vxs_real vxs_walk_quadrics(VXS_LIGHT light, const vxs_real3 from, const vxs_real3 along, const vxs_real t,
                                  const vxs_real end)
{
    vxs_real  length = vxs_walk_dot(along, along), range = VXS_FIELD(light, range_metres), next = end;
    vxs_real3 near;
    if (length > 0.0) {
        vxs_i32  is_spot = VXS_KIND(light) == VXS_LIGHT_KIND_POINT ? 0 : 1;
        vxs_real middle = -vxs_walk_dot(from, along) / length, cos2 = VXS_FIELD(light, cos_outer) * VXS_FIELD(light, cos_outer);
        for (vxs_i32 n = 0; n < 3; n++) near[n] = from[n] + middle * along[n];
        vxs_real slope = vxs_walk_dot(near, along), distance2 = vxs_walk_dot(near, near);
        for (vxs_i32 n = range > 0.0 ? 0 : 1; n <= is_spot; n++) { /* one call, because it is inlined */
            vxs_real a = length, b = slope, c = distance2 - range * range;
            if (n != 0) {
                a = along[2] * along[2] - cos2 * length;
                b = near[2] * along[2] - cos2 * slope;
                c = near[2] * near[2] - cos2 * distance2;
            }
            next = vxs_walk_roots(middle, a, b, c, t, next);
        }
        if (is_spot != 0) next = vxs_walk_plane(from[2], along[2], t, next); /* a second cone lies behind the light */
    }
    return next;
}

/* The first cut behind t, at most the end of the ray. */
VXS_FN vxs_real vxs_walk_next_cut(VXS_LIGHT light, VXS_WALK_IN w, const vxs_real t)
{
    vxs_real next = VXS_FIELD(w, end);
#ifdef VXS_HAS_SUNS
    if (vxs_walk_is_sun(light) != 0) {
        vxs_i32 borders = (VXS_FIELD(light, flags) & VXS_LIGHT_BOUNDED) != 0u ? 6 : 4;
        for (vxs_i32 n = 0; n < borders; n++) {
            vxs_i32 axis = n >> 1, border = (n & 1) != 0 ? vxs_walk_side(light) : 0;
            next = vxs_walk_plane(VXS_FIELD(w, from)[axis] + VXS_REAL(VXS_FIELD(w, origin)[axis] - border),
                                  VXS_FIELD(w, along)[axis], t, next);
        }
    }
#endif
#ifdef VXS_HAS_PUNCTUAL
    if (vxs_walk_is_sun(light) == 0) {
        next = vxs_walk_quadrics(light, VXS_FIELD(w, from), VXS_FIELD(w, along), t, next);
#if !defined(VXS_ONLY_CUBE) || VXS_ONLY_CUBE == 1
        for (vxs_i32 n = 0; n < 6 && VXS_IS_CUBE(light); n++) { /* where two axes are equally long */
            vxs_i32  a = n >> 1, b = (a + 1) % 3;
            vxs_real turn = (n & 1) != 0 ? VXS_REAL(1.0) : VXS_REAL(-1.0);
            next          = vxs_walk_plane(VXS_FIELD(w, from)[a] + turn * VXS_FIELD(w, from)[b],
                                           VXS_FIELD(w, along)[a] + turn * VXS_FIELD(w, along)[b], t, next);
        }
#endif
    }
#endif
    return next;
}

/* maps ------------------------------------------------------------------------------------------------------------------------- */

/* The ray in light space at t; t may be infinite. */
VXS_FN void vxs_walk_ls(VXS_WALK_IN w, const vxs_real t, VXS_OUT vxs_real3 ls)
{
    for (vxs_i32 n = 0; n < 3; n++) {
        vxs_real along = VXS_FIELD(w, along)[n];
        ls[n]          = VXS_FIELD(w, from)[n] + VXS_REAL(VXS_FIELD(w, origin)[n]);
        if (along != 0.0) ls[n] += along * t;
    }
}

/* The map that contains a point of light space, or -1. */
VXS_FN vxs_i32 vxs_walk_map_at(VXS_LIGHT light, const vxs_real3 ls)
{
    vxs_i32 map = 0;
#ifdef VXS_HAS_PUNCTUAL
    if (vxs_walk_is_sun(light) == 0) map = vxs_in_reach(light, ls) != 0 ? vxs_map_from_ls(light, ls) : -1;
#endif
#ifdef VXS_HAS_SUNS
    vxs_real side = VXS_REAL(vxs_walk_side(light));
    vxs_i32  axes = (VXS_FIELD(light, flags) & VXS_LIGHT_BOUNDED) != 0u ? 3 : 2;
    for (vxs_i32 n = 0; n < axes && vxs_walk_is_sun(light) != 0; n++)
        if (!(ls[n] >= 0.0 && ls[n] < side)) map = -1;
#endif
    return map;
}

#ifdef VXS_C
/* A coordinate as an integer, rounded down. Like vxs_clamped, but without floor, which not all processors have. */
VXS_INLINE vxs_i32 vxs_walk_floor(vxs_real coordinate)
{
    vxs_real limit = VXS_REAL(1 << 30);
    if (!(coordinate > -limit)) return -(1 << 30);
    if (!(coordinate < limit)) return 1 << 30;
    vxs_i32 n = VXS_I(coordinate);
    return VXS_REAL(n) > coordinate ? n - 1 : n;
}
#else
#define vxs_walk_floor(coordinate) VXS_I(clamp(floor(coordinate), -1073741824.0, 1073741824.0))
#endif

/* Texel of the ray at t, across or down; `along` is its distance from the light there. Rounding may give a texel outside the
 * map. */
VXS_INLINE vxs_i32 vxs_walk_texel(VXS_LIGHT light, VXS_WALK_IN w, const vxs_i32 axis, const vxs_real t, const vxs_real along)
{
    vxs_real at = VXS_FIELD(w, p)[axis] + VXS_FIELD(w, d)[axis] * t;
    if (vxs_walk_is_sun(light) == 0) at = vxs_punctual_coordinate(light, at, along > VXS_REAL_MIN ? along : VXS_REAL(VXS_REAL_MIN));
    return VXS_FIELD(w, origin)[axis] + vxs_walk_floor(at);
}

/* Depth of the ray in voxels, at distance `along` from the light. */
VXS_INLINE vxs_i32 vxs_walk_depth(VXS_LIGHT light, VXS_WALK_IN w, const vxs_real along)
{
    vxs_real at = along;
    if (vxs_walk_is_sun(light) == 0)
        at = log((along > VXS_REAL_MIN ? along : VXS_REAL(VXS_REAL_MIN)) / VXS_FIELD(light, near_metres)) /
             VXS_FIELD(light, voxel_metres);
    vxs_i32 k = VXS_FIELD(w, origin)[2] + vxs_walk_floor(at);
    if (vxs_walk_is_sun(light) != 0 && (VXS_FIELD(light, flags) & VXS_LIGHT_BOUNDED) != 0u)
        k = vxs_clamp(k, 0, vxs_walk_side(light) - 1);
    return k;
}

/* For a sun, light space starts at the voxel that contains the world's origin; the origin's place in that voxel is known to
 * 2^-20 voxel. So floats are as precise for rays near the origin as at the first texel of the map, wherever in the map the
 * origin is. Doubles need no such offset. */
#ifdef VXS_C
#define vxs_walk_origin(light, row) 0
#define vxs_walk_rest(light, row)   0.0
#else
VXS_FN vxs_i32 vxs_walk_origin(VXS_LIGHT light, const vxs_i32 row)
{
    return vxs_walk_is_sun(light) != 0 ? vxs_clamp(vxs_walk_floor(VXS_LS_FROM_WS(light, row, 3)), -(1 << 23), 1 << 23) : 0;
}

VXS_FN vxs_real vxs_walk_rest(VXS_LIGHT light, const vxs_i32 row)
{
    vxs_u32 rest =
        row == 2 ? VXS_FIELD(light, origin_fraction_k) << 16u : VXS_FIELD(light, origin_fraction_ij) << (row == 0 ? 16u : 0u);
    return VXS_REAL(VXS_I(rest) >> 16) / 1048576.0;
}
#endif

/* A place between two cuts: the middle; or, if that is very far away, a nearer place. At very large distances rounding would
 * decide which of two maps contains the place. */
VXS_FN vxs_real vxs_walk_within(VXS_LIGHT light, VXS_WALK_IN w, const vxs_real first, const vxs_real next)
{
    vxs_real size = VXS_REAL(vxs_walk_side(light)), speed = VXS_REAL(0.0), middle = 0.5 * next - 0.5 * first;
    for (vxs_i32 n = 0; n < 3; n++) {
        vxs_real from = vxs_abs(VXS_FIELD(w, from)[n] + VXS_REAL(VXS_FIELD(w, origin)[n])), along = vxs_abs(VXS_FIELD(w, along)[n]);
        size  = from > size ? from : size;
        speed = along > speed ? along : speed;
    }
    vxs_real far = speed > 0.0 ? vxs_abs(first) + 8.0 * size / speed : VXS_REAL(1.0);
    return first + (middle < far ? middle : far);
}

/* Set the voxel from the place of the ray, which is finite. */
VXS_FN void vxs_walk_place(VXS_LIGHT light, VXS_WALK w)
{
    vxs_real t = VXS_FIELD(w, t), z = VXS_FIELD(w, p)[2] + VXS_FIELD(w, d)[2] * t;
    vxs_i32  last = vxs_walk_side(light) - 1;
    for (vxs_i32 axis = 0; axis < 2; axis++) VXS_FIELD(w, voxel)[axis] = vxs_clamp(vxs_walk_texel(light, w, axis, t, z), 0, last);
    VXS_FIELD(w, voxel)[2] = VXS_FIELD(w, placed) < 0 ? 0 : vxs_walk_depth(light, w, z);
    VXS_FIELD(w, placed)   = 1;
}

/* Enter the map behind a cut: set its space, and the direction of each coordinate. For a punctual light u is x / z, so its
 * direction is the sign of x' z - x z'. */
VXS_FN void vxs_walk_pass_cut(VXS_LIGHT light, VXS_WALK w)
{
    vxs_real  t = VXS_FIELD(w, t);
    vxs_real3 middle;
    VXS_FIELD(w, cut) = vxs_walk_next_cut(light, w, t);
    vxs_walk_ls(w, vxs_walk_within(light, w, t, VXS_FIELD(w, cut)), middle);
    VXS_FIELD(w, map)      = vxs_walk_map_at(light, middle);
    VXS_FIELD(w, placed)   = 0;
    VXS_FIELD(w, square_i) = -1;
    VXS_FIELD(w, in_tile)  = 0;
#ifndef VXS_TABLES
    VXS_FIELD(w, block).side_px = 0;
#endif
    for (vxs_i32 n = 0; n < 3; n++) {
        VXS_FIELD(w, p)[n] = VXS_FIELD(w, from)[n];
        VXS_FIELD(w, d)[n] = VXS_FIELD(w, along)[n];
    }
#if !defined(VXS_ONLY_CUBE) || VXS_ONLY_CUBE == 1
    if (VXS_IS_CUBE(light) && VXS_FIELD(w, map) >= 0) {
        vxs_face_from_ls(VXS_FIELD(w, map), VXS_FIELD(w, from), VXS_FIELD(w, p));
        vxs_face_from_ls(VXS_FIELD(w, map), VXS_FIELD(w, along), VXS_FIELD(w, d));
    }
#endif
    for (vxs_i32 axis = 0; axis < 3; axis++) {
        vxs_real d = VXS_FIELD(w, d)[axis];
        if (vxs_walk_is_sun(light) == 0 && axis < 2) d = d * VXS_FIELD(w, p)[2] - VXS_FIELD(w, p)[axis] * VXS_FIELD(w, d)[2];
        VXS_FIELD(w, per_d)[axis] = 1.0 / d;
        VXS_FIELD(w, way)[axis]   = d > VXS_REAL_MIN ? 1 : d < -VXS_REAL_MIN ? -1 : 0;
    }
}

/* Where the ray, from t on, crosses texel border `border`, across or down, in its direction; VXS_NEVER: nowhere. Borders of
 * the map are cuts, and are not found here. */
VXS_INLINE vxs_real vxs_walk_cross(VXS_LIGHT light, VXS_WALK_IN w, const vxs_i32 axis, const vxs_i32 border, const vxs_real t)
{
    vxs_i32  side = vxs_walk_side(light), way = VXS_FIELD(w, way)[axis];
    vxs_real at = VXS_REAL(VXS_NEVER);
    if (way != 0 && VXS_U(border - 1) < VXS_U(side - 1)) {
        vxs_real p = VXS_FIELD(w, p)[axis], d = VXS_FIELD(w, d)[axis];
#ifdef VXS_HAS_SUNS
        if (vxs_walk_is_sun(light) != 0) at = (VXS_REAL(border - VXS_FIELD(w, origin)[axis]) - p) * VXS_FIELD(w, per_d)[axis];
#endif
#ifdef VXS_HAS_PUNCTUAL
        if (vxs_walk_is_sun(light) == 0) {
            vxs_real slope = (VXS_REAL(border) - 0.5 * VXS_REAL(side)) * VXS_FIELD(light, texel_metres);
            p -= slope * VXS_FIELD(w, p)[2];
            d -= slope * VXS_FIELD(w, d)[2];
            if (VXS_REAL(way) * (d != 0.0 ? p + d * t : p) >= 0.0)
                at = t;
            else if (VXS_REAL(way) * d > 0.0)
                at = -p / d;
        }
#endif
        at = at > t ? at : t;
    }
    return at;
}

/* The same for a voxel border in depth, nearer or deeper. */
VXS_INLINE vxs_real vxs_walk_cross_depth(VXS_LIGHT light, VXS_WALK_IN w, const vxs_i32 border, const vxs_real t)
{
    vxs_real z = VXS_REAL(border - VXS_FIELD(w, origin)[2]);
    if (vxs_walk_is_sun(light) == 0) z = VXS_FIELD(light, near_metres) * exp(z * VXS_FIELD(light, voxel_metres));
    vxs_real at = (z - VXS_FIELD(w, p)[2]) * VXS_FIELD(w, per_d)[2];
    return at > t ? at : t;
}

/* steps ------------------------------------------------------------------------------------------------------------------------ */

/* A coordinate computed with rounding: clamped to [first, end), and not allowed to go back. */
VXS_FN vxs_i32 vxs_walk_on(const vxs_i32 was, const vxs_i32 at, const vxs_i32 way, const vxs_i32 first, const vxs_i32 end)
{
    return vxs_clamp(at, way < 0 ? first : was, way > 0 ? end - 1 : was);
}

/* The next border in the direction of the ray, of the squares of side_px texels. */
VXS_FN vxs_i32 vxs_walk_ahead(const vxs_i32 i, const vxs_i32 way, const vxs_i32 side_px)
{
    return (i & -side_px) + (way > 0 ? side_px : 0);
}

/* Depth of the ray, clamped to the map: what lies behind the map is as its last voxels. */
VXS_FN vxs_i32 vxs_walk_in_map(VXS_LIGHT light, const vxs_i32 k)
{
    vxs_i32 last = vxs_walk_side(light) - 1;
    return k < last ? k : last;
}

/* All is lit in front of the map. Texels are not computed there, because near a punctual light they would be rounding noise. */
VXS_FN vxs_i32 vxs_walk_in_front(VXS_LIGHT light, VXS_WALK w)
{
    vxs_real cut = VXS_FIELD(w, cut), first = cut;
    if (VXS_FIELD(w, way)[2] > 0) first = vxs_walk_cross_depth(light, w, 0, VXS_FIELD(w, t));
    if (first < cut) VXS_FIELD(w, placed) = -1;
    VXS_FIELD(w, t) = first < cut ? first : cut;
    return VXS_SPAN_LIT;
}

/* Move from t to where the ray leaves a box, but not beyond the cut. In a tile with depths of its own, if they do not give one
 * state there, the walk enters its texels instead. Returns the state of what was passed; VXS_SPAN_NONE: nothing was. */
VXS_INLINE vxs_i32 vxs_walk_leave(VXS_LIGHT light, VXS_WALK w, const vxs_walk_box box)
{
    vxs_real t = VXS_FIELD(w, t), first = VXS_FIELD(w, cut), at;
    vxs_i32  way = VXS_FIELD(w, way)[2], k = VXS_FIELD(w, voxel)[2], depth = k, through = -1, state = box.state;
    vxs_i32  near = -VXS_NO_BORDER, far = box.far < vxs_walk_side(light) ? box.far : VXS_NO_BORDER;
    if (box.near > 0 || (box.near == 0 && (VXS_FIELD(light, flags) & VXS_LIGHT_BOUNDED) == 0u)) near = box.near;
    vxs_i32 border = way > 0 ? far : near;
    for (vxs_i32 axis = 0; axis < 2; axis++) {
        at = vxs_walk_cross(light, w, axis, vxs_walk_ahead(VXS_FIELD(w, voxel)[axis], VXS_FIELD(w, way)[axis], box.side_px), t);
        through = at < first ? axis : through;
        first   = at < first ? at : first;
    }
    if (way != 0 && border < VXS_NO_BORDER && border > -VXS_NO_BORDER) {
        at      = vxs_walk_cross_depth(light, w, border, t);
        through = at < first ? 2 : through;
        first   = at < first ? at : first;
    }
    vxs_real z = VXS_FIELD(w, p)[2] + VXS_FIELD(w, d)[2] * first;
    if (through == 2)
        depth = way > 0 ? far : near - 1;
    else if (way != 0)
        depth = vxs_walk_on(k, vxs_walk_depth(light, w, z), way, near, far);
    if (state == VXS_SPAN_NONE) {
        VXS_FIELD(w, nearest)  = way > 0 ? k : depth;
        VXS_FIELD(w, farthest) = way > 0 ? depth : k;
        if (vxs_walk_in_map(light, VXS_FIELD(w, farthest)) < VXS_FIELD(w, least))
            state = VXS_SPAN_LIT;
        else {
#ifdef VXS_TABLES /* a loop, and most tiles need it not */
            w.greatest = clamp(w.tile_base + int(vxs_table_last(w.tile_record)), w.least, vxs_walk_side(light));
#endif
            if (vxs_walk_in_map(light, VXS_FIELD(w, nearest)) >= VXS_FIELD(w, greatest)) state = VXS_SPAN_SHADOW;
        }
    }
    for (vxs_i32 axis = state == VXS_SPAN_NONE ? 0 : 2; axis < 2; axis++) { /* the first texel */
#ifdef VXS_TABLES
        uvec2 mask = vxs_table_shadow(w.tile_record, vxs_walk_in_map(light, axis == 0 ? w.nearest : w.farthest) - w.tile_base);
        if (axis == 0) w.dark = mask;
        w.shaded = mask;
#endif
        VXS_FIELD(w, in_tile) = 1;
        VXS_FIELD(w, next)
        [axis] = vxs_walk_cross(light, w, axis, vxs_walk_ahead(VXS_FIELD(w, voxel)[axis], VXS_FIELD(w, way)[axis], 1), t);
    }
    if (state != VXS_SPAN_NONE) {
        VXS_FIELD(w, t)        = first;
        VXS_FIELD(w, voxel)[2] = depth;
        for (vxs_i32 axis = 0; axis < 2; axis++) {
            vxs_i32 was = VXS_FIELD(w, voxel)[axis], turn = VXS_FIELD(w, way)[axis], begin = was & -box.side_px;
            VXS_FIELD(w, voxel)
            [axis] = through == axis ? (turn > 0 ? begin + box.side_px : begin - 1)
                                     : vxs_walk_on(was, vxs_walk_texel(light, w, axis, first, z), turn, begin, begin + box.side_px);
        }
    }
    return state;
}

#ifdef VXS_HAS_BLOCKS
/* In a tile, move to the end of a texel, or to where the ray crosses its depth. After that only the border on the crossed axis
 * changes. */
VXS_INLINE vxs_i32 vxs_walk_through_texel(VXS_WORDS blocks, VXS_LIGHT light, VXS_WALK w)
{
    vxs_i32  i = VXS_FIELD(w, voxel)[0] & 7, j = VXS_FIELD(w, voxel)[1] & 7, way = VXS_FIELD(w, way)[2], state, in_texel = 0;
    vxs_i32  axis = VXS_FIELD(w, next)[1] < VXS_FIELD(w, next)[0] ? 1 : 0;
    vxs_real t = VXS_FIELD(w, t), cut = VXS_FIELD(w, cut), across = VXS_FIELD(w, next)[axis], next = across < cut ? across : cut;
#ifdef VXS_TABLES
    uint bit = uint(i + 8 * (j & 3)), dark = j < 4 ? w.dark.x : w.dark.y, shaded = j < 4 ? w.shaded.x : w.shaded.y;
    state       = ((shaded >> bit) & 1u) == 0u ? VXS_SPAN_LIT : VXS_SPAN_SHADOW;
    int crosses = int(((shaded & ~dark) >> bit) & 1u);
#else
    vxs_i32 depth = VXS_FIELD(w, least);
    if (depth != VXS_FIELD(w, greatest))
        depth = vxs_depths_texel(blocks, VXS_REF_OF(w, tile), depth, VXS_FIELD(w, greatest), VXS_U(i), VXS_U(j));
    state           = depth == vxs_walk_side(light) || depth > VXS_FIELD(w, farthest) ? VXS_SPAN_LIT : VXS_SPAN_SHADOW;
    vxs_i32 crosses = state == VXS_SPAN_SHADOW && depth > VXS_FIELD(w, nearest) && way != 0 ? 1 : 0;
#endif
    for (; crosses != 0; crosses = 0) { /* a loop: see vxs_walk_step */
#ifdef VXS_TABLES
        int depth = w.tile_base + int(vxs_table_delta(w.tile_record, uint(i), uint(j)));
#endif
        vxs_real at = vxs_walk_cross_depth(light, w, depth, t);
        state       = (at > t) == (way > 0) ? VXS_SPAN_LIT : VXS_SPAN_SHADOW;
        if (at > t && at < next) {
            next     = at;
            in_texel = 1;
        }
    }
    VXS_FIELD(w, t) = next;
    if (in_texel == 0) {
        VXS_FIELD(w, in_tile) = 0;
        if (across < cut) {
            vxs_i32 was = VXS_FIELD(w, voxel)[axis], now = was + VXS_FIELD(w, way)[axis];
            VXS_FIELD(w, voxel)[axis] = now;
            if (((was ^ now) & ~7) == 0) {
                VXS_FIELD(w, next)[axis] = vxs_walk_cross(light, w, axis, vxs_walk_ahead(now, VXS_FIELD(w, way)[axis], 1), next);
                VXS_FIELD(w, in_tile)    = 1;
            } else
                VXS_FIELD(w, voxel)[2] = way > 0 ? VXS_FIELD(w, farthest) : VXS_FIELD(w, nearest);
        }
    }
    return state;
}

/* palette blocks --------------------------------------------------------------------------------------------------------------- */

#ifdef VXS_TABLES

/* The largest square about the voxel whose bounds decide its depth: of 256 or 32 texels; else its tile. */
vxs_walk_box vxs_walk_box_of_blocks(const uint words, VXS_LIGHT light, inout vxs_walk w)
{
    vxs_walk_box box;
    int          i = w.voxel[0], j = w.voxel[1], side = vxs_walk_side(light), k = min(w.voxel[2], side - 1);
    while (w.square_i != i >> 8 || w.square_j != j >> 8) {
        w.square_i = i >> 8;
        w.square_j = j >> 8;
        w.block_i  = -1;
        w.node     = vxs_table_square(w.root, light.levels, uint(w.square_i), uint(w.square_j));
        w.square   = ivec2(w.node & 0x7fffffffu);
        if (w.node < 0x80000000u) {
            w.slope  = vxs_word(w.node, 0u);
            w.square = ivec2(vxs_word(w.node, 1u), vxs_word(w.node, 2u));
        }
#ifdef VXS_GL_STREAM
        uint top = vxs_table_top(w.root, light.levels, uint(w.square_i), uint(w.square_j)), up = max(light.levels, 8u) - 8u;
        w.coarse = vxs_table_is_missing(top) ? ivec2(top & 0xffu, ((top >> 8) & 0xffu) + 1u) << int(up) : ivec2(side);
#endif
    }
    ivec2 bounds = w.square;
    box.side_px  = 256;
    if (k >= bounds.x && k < bounds.y) {
        while (w.block_i != i >> 5 || w.block_j != j >> 5) {
            w.block_i    = i >> 5;
            w.block_j    = j >> 5;
            w.block_word = vxs_word(w.node, uint(4 + (w.block_i & 7) + 8 * (w.block_j & 7)));
            if (w.block_word < 0x80000000u)
                w.block = ivec2(vxs_word(w.block_word, 0u), vxs_word(w.block_word, 1u));
            else { /* least and greatest in two corners */
                int x = (i >> 3) & 28, y = (j >> 3) & 28, depth = int(w.block_word & 0x7fffffffu);
                int last = min(side / 8, 4) - 1, left = (w.slope & 0x8000u) != 0u ? last : 0,
                    up  = w.slope >= 0x80000000u ? last : 0;
                w.block = ivec2(depth) - ivec2(vxs_table_slope(w.slope, x + last - left, y + last - up),
                                               vxs_table_slope(w.slope, x + left, y + up));
            }
        }
        bounds      = w.block;
        box.side_px = 32;
    }
    box.state = k < bounds.x ? VXS_SPAN_LIT : k >= bounds.y ? VXS_SPAN_SHADOW : VXS_SPAN_NONE;
    box.near  = box.state == VXS_SPAN_SHADOW ? bounds.y : 0;
    box.far   = box.state == VXS_SPAN_LIT ? bounds.x : side;
#ifdef VXS_GL_STREAM
    if (w.coarse.x < side) { /* outside of these depths the answer is exact */
        bool is_coarse = k >= w.coarse.x && k < w.coarse.y;
        box.near       = max(box.near, is_coarse ? w.coarse.x : k < w.coarse.x ? 0 : w.coarse.y);
        box.far        = min(box.far, is_coarse ? w.coarse.y : k < w.coarse.x ? w.coarse.x : side);
        if (is_coarse) box.state += VXS_SPAN_COARSE;
    }
#endif
    if (box.state == VXS_SPAN_NONE) {
        int x = i >> 3, y = j >> 3;
        box.near      = -VXS_NO_BORDER;
        box.side_px   = 8;
        w.tile_base   = int(w.block_word & 0x7fffffffu);
        w.tile_record = 0u;
        if (w.block_word < 0x80000000u) {
            uint at       = w.block_word + uint(2 + 2 * ((x & 3) | ((y & 3) << 2)));
            w.tile_base   = int(vxs_word(at, 0u));
            w.tile_record = vxs_word(at, 1u);
        }
        w.tile_base -= vxs_table_slope(w.slope, x & 31, y & 31);
        w.least = clamp(w.tile_base, 0, side);
    }
    box.side_px = min(box.side_px, side);
    return box;
}

#else

/* Whether depth k is outside the bounds of a square, so that the bounds give its state. */
VXS_INLINE vxs_i32 vxs_walk_decides(VXS_SQUARE s, const vxs_i32 k)
{
    return k < VXS_FIELD(s, least) || k >= VXS_FIELD(s, greatest) ? 1 : 0;
}

/* The part of a square with the same state as depth k. In a coarse square, depths before `low` and from `high` on are exact. */
VXS_FN vxs_walk_box vxs_walk_box_in(VXS_LIGHT light, VXS_SQUARE s, const vxs_i32 k)
{
    vxs_walk_box box;
    vxs_i32 low = VXS_FIELD(s, low), high = VXS_FIELD(s, high), coarse = VXS_FIELD(s, coarse);
    box.side_px = VXS_FIELD(s, side_px);
    box.near = 0;
    box.far = vxs_walk_side(light);
    if (coarse == 0 || (k >= low && k < high)) {
        if (coarse != 0) box.near = low;
        if (coarse != 0) box.far = high;
        box.state = k < VXS_FIELD(s, least) ? VXS_SPAN_LIT : VXS_SPAN_SHADOW;
        if (box.state == VXS_SPAN_LIT)
            box.far = VXS_FIELD(s, least);
        else
            box.near = VXS_FIELD(s, greatest);
        if (coarse != 0) box.state += VXS_SPAN_COARSE;
    } else if (k < low) {
        box.far = low;
        box.state = VXS_SPAN_LIT;
    } else {
        box.near = high;
        box.state = VXS_SPAN_SHADOW;
    }
    return box;
}

/* Find bounds of the square about the voxel if they decide its depth, else of the block. */
VXS_FN void vxs_walk_find_block(VXS_WORDS blocks, VXS_LIGHT light, VXS_WALK w)
{
    vxs_i32 i = VXS_FIELD(w, voxel)[0], j = VXS_FIELD(w, voxel)[1], k = vxs_walk_in_map(light, VXS_FIELD(w, voxel)[2]);
    vxs_u32 map = VXS_U(VXS_FIELD(w, map)), levels = VXS_FIELD(light, levels);
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

/* The largest square about the voxel whose bounds decide its depth: of 256 or 32 texels; else its tile. */
VXS_INLINE vxs_walk_box vxs_walk_box_of_blocks(VXS_WORDS blocks, VXS_LIGHT light, VXS_WALK w)
{
    vxs_walk_box box;
    vxs_i32 i = VXS_FIELD(w, voxel)[0], j = VXS_FIELD(w, voxel)[1], k = vxs_walk_in_map(light, VXS_FIELD(w, voxel)[2]);
    vxs_i32 side_px = VXS_FIELD(w, block).side_px;
    /* a square that is no block was kept for a depth, and may not decide this one */
    if (side_px == 0 || (((i ^ VXS_FIELD(w, block).i) | (j ^ VXS_FIELD(w, block).j)) & -side_px) != 0 ||
        (VXS_FIELD(w, is_block) == 0 && vxs_walk_decides(VXS_REF_OF(w, block), k) == 0))
        vxs_walk_find_block(blocks, light, w);
    if (vxs_walk_decides(VXS_REF_OF(w, block), k) != 0)
        box = vxs_walk_box_in(light, VXS_REF_OF(w, block), k);
    else {
        vxs_walk_find_tile(blocks, w);
        box.side_px = 8;
        box.near = -VXS_NO_BORDER;
        box.far = VXS_NO_BORDER;
        box.state = VXS_SPAN_NONE;
    }
    return box;
}

#endif
#endif

/* DAGs ------------------------------------------------------------------------------------------------------------------------- */

/* The largest uniform node about a voxel; in a slice with a mask, the single voxel. */
VXS_FN vxs_walk_box vxs_walk_box_of_dag(VXS_WORDS dag, VXS_LIGHT light, VXS_WALK_IN w)
{
    vxs_walk_box box;
    vxs_i32      i = VXS_FIELD(w, voxel)[0], j = VXS_FIELD(w, voxel)[1], k = vxs_walk_in_map(light, VXS_FIELD(w, voxel)[2]);
    vxs_u32      node = vxs_root_of(dag, light, VXS_FIELD(w, map)), state = 2u, states;
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
    box.state = state == 0u ? VXS_SPAN_LIT : VXS_SPAN_SHADOW;
    return box;
}

/* the walk --------------------------------------------------------------------------------------------------------------------- */

/* Enter the map behind a cut, or pass what has no map. Returns the state of what was passed; VXS_SPAN_NONE: nothing was passed, and
 * the walk is at a voxel of a map. */
VXS_INLINE vxs_i32 vxs_walk_enter(VXS_LIGHT light, VXS_WALK w)
{
    vxs_i32 state = VXS_SPAN_NONE;
    if (!(VXS_FIELD(w, t) < VXS_FIELD(w, cut))) vxs_walk_pass_cut(light, w);
    if (VXS_FIELD(w, map) < 0) {
        VXS_FIELD(w, t) = VXS_FIELD(w, cut);
        state           = VXS_FIELD(w, outside);
    } else {
        if (VXS_FIELD(w, placed) <= 0) vxs_walk_place(light, w);
        if (VXS_FIELD(w, voxel)[2] < 0) state = vxs_walk_in_front(light, w);
    }
    return state;
}

/* One step to where the state may change; not inside a tile. What few steps need is in loops: software rasterisers run both sides of
 * a branch, but no loop that no ray is in. Returns the state of what was passed; VXS_SPAN_NONE: nothing was passed. */
VXS_INLINE vxs_i32 vxs_walk_step(VXS_WORDS words, VXS_LIGHT light, VXS_WALK w)
{
    vxs_i32 state  = VXS_SPAN_NONE;
    vxs_i32 enters = !(VXS_FIELD(w, t) < VXS_FIELD(w, cut)) || VXS_FIELD(w, placed) <= 0 || VXS_FIELD(w, voxel)[2] < 0 ? 1 : 0;
    for (; enters != 0; enters = 0) {
        state = vxs_walk_enter(light, w);
#ifdef VXS_TABLES
        w.root = vxs_root_of(words, light, w.map);
#endif
    }
    if (state == VXS_SPAN_NONE) {
        vxs_walk_box box;
#ifdef VXS_HAS_BLOCKS
        if (VXS_CODING(light) == VXS_CODING_BLOCKS) box = vxs_walk_box_of_blocks(words, light, w);
#endif
#ifdef VXS_HAS_DAGS
        if (VXS_CODING(light) != VXS_CODING_BLOCKS) box = vxs_walk_box_of_dag(words, light, w);
#endif
        state = vxs_walk_leave(light, w, box);
    }
    return state;
}

/* The walk passed from `from` to t in state `next`. Returns 1 if this ends an interval of the wanted state; then `span` is
 * that interval. */
VXS_INLINE vxs_i32 vxs_walk_passed(VXS_WALK w, const vxs_real from, const vxs_i32 next, const vxs_i32 only, VXS_SPAN_INOUT span)
{
    vxs_i32 was = VXS_FIELD(w, state), found = 0;
    VXS_FIELD(w, steps) -= 1;
    if (VXS_FIELD(w, steps) < 0) VXS_FIELD(w, t) = VXS_FIELD(w, end);
    if (VXS_FIELD(w, t) > from && next != was) {
        VXS_FIELD(span, begin) = VXS_FIELD(w, begin);
        VXS_FIELD(span, end)   = from;
        VXS_FIELD(span, state) = was;
        VXS_FIELD(w, state)    = next;
        VXS_FIELD(w, begin)    = from;
        found                  = was != VXS_SPAN_NONE && (only == VXS_SPAN_NONE || (was & 3) == only) ? 1 : 0;
    }
    return found;
}

/* Start a walk at t_begin.
 * origin_ws, direction_ws  metres, as for vxs_place_from_ws; the direction may have any length; with length 1, t is in
 *                          metres
 * t_begin, t_end           finite in shaders; t_end < t_begin: the walk is empty */
VXS_FN vxs_walk vxs_walk_of(VXS_LIGHT light, const vxs_real3 origin_ws, const vxs_real3 direction_ws, const vxs_real t_begin,
                            const vxs_real t_end)
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
    w.placed              = 0;
    w.in_tile             = 0;
    return w;
}

/* 0: the walk has ended. */
VXS_FN vxs_i32 vxs_walk_is_on(VXS_WALK_IN w)
{
    vxs_i32 moves = VXS_FIELD(w, t) < VXS_FIELD(w, end) && VXS_FIELD(w, steps) >= VXS_FIELD(w, pause) ? 1 : 0;
    return moves != 0 || VXS_FIELD(w, state) != VXS_SPAN_NONE ? 1 : 0;
}

/* Go on for at most `rounds` rounds, or to the next interval; in state `only`, unless it is VXS_SPAN_NONE. A round is one step, and
 * then the texels of a tile: they have a loop of their own, because of many rays side by side few are in tiles at one time.
 * Returns 1 if `span` is an interval. */
VXS_INLINE vxs_i32 vxs_walk_some(VXS_WORDS words, VXS_LIGHT light, VXS_WALK w, const vxs_i32 only, const vxs_i32 rounds,
                                 VXS_SPAN span)
{
    vxs_i32  found = 0;
    vxs_span s;
    s.begin = s.end = VXS_FIELD(w, begin);
    s.state         = VXS_SPAN_NONE;
    for (vxs_i32 n = 0; n < rounds && found == 0 && vxs_walk_is_on(w) != 0; n++) {
        vxs_real from = VXS_FIELD(w, t);
        vxs_i32  next;
        if (!(from < VXS_FIELD(w, end)) || VXS_FIELD(w, steps) < VXS_FIELD(w, pause)) { /* the last interval */
            s.begin             = VXS_FIELD(w, begin);
            s.end               = from;
            s.state             = VXS_FIELD(w, state);
            found               = from > s.begin && (only == VXS_SPAN_NONE || (s.state & 3) == only) ? 1 : 0;
            VXS_FIELD(w, begin) = from;
            VXS_FIELD(w, state) = VXS_SPAN_NONE;
        } else if (VXS_FIELD(w, in_tile) == 0) {
            next  = vxs_walk_step(words, light, w);
            found = vxs_walk_passed(w, from, next, only, VXS_REF(s));
        }
#ifdef VXS_HAS_BLOCKS
        while (VXS_CODING(light) == VXS_CODING_BLOCKS && found == 0 && VXS_FIELD(w, in_tile) != 0 &&
               VXS_FIELD(w, t) < VXS_FIELD(w, end) && VXS_FIELD(w, steps) >= VXS_FIELD(w, pause)) {
            from  = VXS_FIELD(w, t);
            next  = vxs_walk_through_texel(words, light, w);
            found = vxs_walk_passed(w, from, next, only, VXS_REF(s));
        }
#endif
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
    return vxs_walk_some(words, light, w, VXS_SPAN_NONE, VXS_WALK_ALL, span);
}

/* The next lit interval. With this function, of many rays side by side none waits for another ray that is in shadow. State
 * outside the volume of the light is w.outside. */
VXS_FN vxs_i32 vxs_walk_next_lit(VXS_WORDS words, VXS_LIGHT light, VXS_WALK w, VXS_SPAN span)
{
    return vxs_walk_some(words, light, w, VXS_SPAN_LIT, VXS_WALK_ALL, span);
}

#endif
