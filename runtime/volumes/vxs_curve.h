/* Transmittance along a light ray, as a curve of a few nodes: one text for C99, C++ and GLSL. Built on vxs_space.h.
 *
 *     vxs_curve_empty      a curve through empty space
 *     vxs_curve_insert     multiply a segment of smoke into it, and keep a limited number of nodes; the same in steps:
 *                          vxs_curve_insertion_of, vxs_curve_insert_next
 *     vxs_curve_at         the transmittance at a depth
 *     vxs_curve_pad        fill the unused nodes of a stored curve
 *     vxs_curve_read       the transmittance at a depth, of a stored curve
 *
 * A node is a depth and the transmittance from the light to there: 1 is all light. Before the first node the transmittance is 1,
 * behind the last it is that of the last. Two nodes of equal depth are a step, as of a surface or a thin hair.
 *
 *     t 1 ---o.                       A segment from entry to exit with transmittance T. Nodes before it do not change. Nodes in it
 *            entry `o...........      are multiplied by the transmittance from its entry to the node, nodes behind it by T. It adds
 *              exit         :   `o--  a node at its entry and one at its exit. A third is added between them, where the product of
 *                                last segment and curve bends most.
 *
 * A thick segment is an exponential that falls most just behind its entry. It is multiplied in as several thin segments, in each
 * of which the exponential is nearly linear. Where many segments overlap, each adds a node where their product has become steep.
 *
 * While there are more than `nodes`, the inner node is removed whose triangle with its neighbours has the least area: this
 * changes the integral of the curve the least. Nodes never move, and the first and the last are never removed. So the curve
 * never rises, and behind its end it is the product of all segments, in any order of insertion. In between, the order decides
 * which nodes are removed.
 *
 * A stored curve is `nodes` pairs of numbers, depth and transmittance. Unused nodes have the depth VXS_CURVE_FAR and the
 * transmittance of the last node. A shader that reads curves must define, before this text, vxs_curve_number(curves, i): number
 * i of all stored numbers; vxs_curve_read passes `curves` to it. VXS_CURVE_MOST is the largest number of nodes of a curve; an
 * includer may define it; default 16.
 * Source: [AVSM10] 3.2, 3.3 and 4.1; segments with nodes at their own depths, transmittance 0, and several pieces are ours.
 * Public: what this comment names. Other names are internal, and may change in any version.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_CURVE_H
#define VXS_CURVE_H

#ifndef VXS_SPACE_H /* a shader that cannot include has it already */
#include "vxs_space.h"
#endif

#ifdef VXS_C
typedef struct vxs_curve           vxs_curve;
typedef struct vxs_curve_place     vxs_curve_place;
typedef struct vxs_curve_insertion vxs_curve_insertion;
#define VXS_CURVE           const vxs_curve *
#define VXS_CURVE_INOUT     vxs_curve *
#define VXS_CURVE_INSERTION vxs_curve_insertion *
#define VXS_CURVE_STORED    const float *
#ifndef vxs_curve_number
#define vxs_curve_number(curves, i) VXS_REAL((curves)[i])
#endif
#else
#define VXS_CURVE           vxs_curve
#define VXS_CURVE_INOUT     inout vxs_curve
#define VXS_CURVE_INSERTION inout vxs_curve_insertion
#define VXS_CURVE_STORED    uint
#endif

#ifndef VXS_CURVE_MOST
#define VXS_CURVE_MOST 16
#endif
#define VXS_CURVE_ROOM (VXS_CURVE_MOST + 3)
#define VXS_CURVE_FAR  1e30 /* finite, so that no infinity is multiplied by 0 */

struct vxs_curve {
    vxs_i32  count;                 /* number of nodes */
    vxs_real depth[VXS_CURVE_ROOM]; /* metres, or another unit common to all nodes; they never decrease */
    vxs_real left[VXS_CURVE_ROOM];  /* transmittance, 0 to 1; it never increases */
};

/* At a depth: the transmittance, and the number of nodes at or before it. */
struct vxs_curve_place {
    vxs_real left;
    vxs_i32  nodes;
};

/* A segment that is inserted in pieces. The next piece starts at `begin`; `before` is the transmittance of the pieces before it;
 * the last piece is number `last`. The first `even` pieces each take an equal part of the fall of the square root of
 * transmittance. through, all: transmittance of the segment; `all` is never 0. */
struct vxs_curve_insertion {
    vxs_real entry, exit, through, all, root, begin, before;
    vxs_i32  next, even, last;
};

VXS_FN vxs_curve vxs_curve_empty(void)
{
    vxs_curve curve;
    curve.count = 0;
    for (vxs_i32 n = 0; n < VXS_CURVE_ROOM; n++) {
        curve.depth[n] = VXS_REAL(VXS_CURVE_FAR);
        curve.left[n]  = VXS_REAL(1.0);
    }
    return curve;
}

/* Interpolate between a and b, 1 >= a >= b >= 0, at a share of the distance: linear, or as through a medium of constant density.
 * Such a medium never reaches 0, so interpolation toward 0 is always linear. */
VXS_FN vxs_real vxs_curve_between(vxs_real a, vxs_real b, vxs_real part, vxs_i32 exponential)
{
    vxs_real left = exponential != 0 && b > 0.0 ? a * exp(log(b / a) * part) : a + (b - a) * part;
    left          = left < a ? left : a;
    return left > b ? left : b;
}

/* At the depth of a step, the result is the transmittance behind the step. */
VXS_FN vxs_curve_place vxs_curve_find(VXS_CURVE curve, vxs_real depth, vxs_i32 exponential)
{
    vxs_real        before = depth, behind = depth, a = VXS_REAL(1.0), b = VXS_REAL(1.0);
    vxs_curve_place place;
    place.nodes = 0;
    /* without branches, because invocations that run in groups execute both sides of a branch */
    for (vxs_i32 n = 0; n < VXS_CURVE_ROOM; n++) {
        vxs_real d = VXS_FIELD(curve, depth)[n], left = VXS_FIELD(curve, left)[n];
        vxs_i32  is_node = n < VXS_FIELD(curve, count) ? 1 : 0, is_before = d > depth ? 0 : is_node;
        vxs_i32  is_next = is_before != 0 || behind > depth ? 0 : is_node;
        before           = is_before != 0 ? d : before;
        a                = is_before != 0 ? left : a;
        behind           = is_next != 0 ? d : behind;
        b                = is_next != 0 ? left : b;
        place.nodes += is_before;
    }
    place.left = behind > depth ? vxs_curve_between(a, b, (depth - before) / (behind - before), exponential) : a;
    return place;
}

VXS_FN vxs_real vxs_curve_at(VXS_CURVE curve, vxs_real depth, vxs_i32 exponential)
{
    vxs_curve_place place = vxs_curve_find(curve, depth, exponential);
    return place.left;
}

/* Transmittance of a segment of constant density, from its entry to a share of its length. The exponential is approximated by a
 * parabola, with an error of at most 2e-4 for a transmittance of 0.75 and 2e-3 for 0.5; of thicker segments by a line.
 * root  square root of the transmittance of the whole segment */
VXS_FN vxs_real vxs_curve_part(vxs_real through, vxs_real root, vxs_real part)
{
    vxs_real bow  = root > 0.7 ? 2.0 * (1.0 - root) * (1.0 - root) : VXS_REAL(0.0);
    vxs_real left = 1.0 - part * (1.0 - through + bow * (1.0 - part));
    left          = left < 1.0 ? left : VXS_REAL(1.0);
    return left > through ? left : through;
}

/* Depth where the product of a segment and the curve bends most. Between two nodes both are linear, and the product falls below
 * the line between its ends by at most a quarter of the product of both decreases. Returns the middle of the interval where that
 * is greatest; VXS_CURVE_FAR if there is none.
 * left, at_exit  transmittance of the curve at entry and exit */
VXS_FN vxs_real vxs_curve_bend(VXS_CURVE curve, vxs_real entry, vxs_real exit, vxs_real left, vxs_real at_exit)
{
    vxs_real at = VXS_REAL(VXS_CURVE_FAR), most = VXS_REAL(0.0), begin = entry;
    for (vxs_i32 n = 0; n < VXS_CURVE_ROOM; n++) {
        vxs_i32  is_in = n < VXS_FIELD(curve, count) && VXS_FIELD(curve, depth)[n] < exit ? 1 : 0;
        vxs_real end = is_in != 0 ? VXS_FIELD(curve, depth)[n] : exit, next = is_in != 0 ? VXS_FIELD(curve, left)[n] : at_exit;
        vxs_real length = end - begin, bend = length > 0.0 ? (left - next) * length * length : VXS_REAL(-1.0);
        at    = bend > most ? begin + 0.5 * length : at;
        most  = bend > most ? bend : most;
        left  = end >= begin ? next : left; /* else it is before the segment */
        begin = end >= begin ? end : begin;
    }
    return at;
}

/* Multiply a segment in, and add its two or three nodes. The curve must have room for them. */
VXS_FN void vxs_curve_multiply(VXS_CURVE_INOUT curve, vxs_real entry, vxs_real exit, vxs_real through)
{
    vxs_curve_place begin = vxs_curve_find(curve, entry, 0), end = vxs_curve_find(curve, exit, 0), within;
    vxs_real        bend = vxs_curve_bend(curve, entry, exit, begin.left, end.left), at_entry = begin.left, at_bend = at_entry;
    vxs_real        at_exit = end.left * through, root = sqrt(through);
    vxs_i32         bends = bend < exit ? 1 : 0, first = begin.nodes, last = end.nodes + 1 + bends, middle = VXS_CURVE_ROOM;
    if (bends != 0) {
        within  = vxs_curve_find(curve, bend, 0);
        at_bend = within.left;
        middle  = within.nodes + 1;
    }
    vxs_real older_depth = entry, older_left = VXS_REAL(1.0), old_depth = entry, old_left = VXS_REAL(1.0), depth = entry,
             left = VXS_REAL(1.0), least = left;
    for (vxs_i32 n = 0; n < VXS_CURVE_ROOM; n++) { /* move nodes by the number of new nodes before them */
        vxs_real now_depth = VXS_FIELD(curve, depth)[n], now_left = VXS_FIELD(curve, left)[n], d = now_depth, t = now_left;
        if (n > last) {
            d = bends != 0 ? older_depth : old_depth;
            t = (bends != 0 ? older_left : old_left) * through;
        } else if (n == last) {
            d = exit;
            t = at_exit;
        } else if (n == first) {
            d = entry;
            t = at_entry;
        } else if (n > first) {
            d = n == middle ? bend : n > middle ? old_depth : depth;
            t = n == middle ? at_bend : n > middle ? old_left : left;
            t *= vxs_curve_part(through, root, (d - entry) / (exit - entry));
        }
        least                      = t < least ? t : least; /* quotients in shading languages may be off by a bit */
        VXS_FIELD(curve, depth)[n] = d;
        VXS_FIELD(curve, left)[n]  = least;
        older_depth                = old_depth;
        older_left                 = old_left;
        old_depth                  = depth;
        old_left                   = left;
        depth                      = now_depth;
        left                       = now_left;
    }
    VXS_FIELD(curve, count) += 2 + bends;
}

/* Remove the inner node that changes the integral the least, by the area of its triangle. The curve must have at least three
 * nodes. */
VXS_FN void vxs_curve_remove_least(VXS_CURVE_INOUT curve)
{
    vxs_i32  count = VXS_FIELD(curve, count), which = 1;
    vxs_real least = VXS_REAL(-1.0);
    for (vxs_i32 n = 1; n < VXS_CURVE_ROOM - 1; n++) {
        vxs_real behind = VXS_FIELD(curve, depth)[n + 1] - VXS_FIELD(curve, depth)[n];
        vxs_real wide   = VXS_FIELD(curve, depth)[n + 1] - VXS_FIELD(curve, depth)[n - 1];
        vxs_real area   = vxs_abs(wide * (VXS_FIELD(curve, left)[n + 1] - VXS_FIELD(curve, left)[n]) -
                                  behind * (VXS_FIELD(curve, left)[n + 1] - VXS_FIELD(curve, left)[n - 1]));
        if (n + 1 < count && (least < 0.0 || area < least)) {
            least = area;
            which = n;
        }
    }
    for (vxs_i32 n = 0; n < VXS_CURVE_ROOM - 1; n++)
        if (n >= which) {
            VXS_FIELD(curve, depth)[n] = VXS_FIELD(curve, depth)[n + 1];
            VXS_FIELD(curve, left)[n]  = VXS_FIELD(curve, left)[n + 1];
        }
    VXS_FIELD(curve, count)--;
}

/* The same as vxs_curve_multiply, then keep at most `nodes` nodes. */
VXS_FN void vxs_curve_insert_thin(VXS_CURVE_INOUT curve, vxs_i32 nodes, vxs_real entry, vxs_real exit, vxs_real through)
{
    vxs_curve_multiply(curve, entry, exit, through);
    for (vxs_i32 n = 0; n < 3; n++)
        if (VXS_FIELD(curve, count) > nodes) vxs_curve_remove_least(curve);
}

/* A segment of which no piece is left. */
VXS_FN vxs_curve_insertion vxs_curve_inserted(void)
{
    vxs_curve_insertion s;
    s.entry = s.exit = s.begin = VXS_REAL(0.0);
    s.through = s.all = s.root = s.before = VXS_REAL(1.0);
    s.even = s.last = 0;
    s.next          = 1;
    return s;
}

#define VXS_CURVE_LEAST 1e-3 /* transmittance below which a segment gets one more piece */

/* Number of pieces of a segment, such that a linear piece has an error of at most 0.01. A segment that is short relative to the
 * curve gets one piece.
 * root  square root of the transmittance, at least that of VXS_CURVE_LEAST */
VXS_FN vxs_i32 vxs_curve_pieces(VXS_CURVE curve, vxs_i32 nodes, vxs_real length, vxs_real root)
{
    vxs_real first = VXS_REAL(0.0), last = first, pieces = ceil((1.0 - root) / 0.1414);
    if (!(pieces > 1.0)) return 1;
    for (vxs_i32 n = 0; n < VXS_CURVE_ROOM; n++) {
        if (n >= VXS_FIELD(curve, count)) break;
        if (n == 0) first = VXS_FIELD(curve, depth)[n];
        last = VXS_FIELD(curve, depth)[n];
    }
    if (!(64.0 * length > last - first)) return 1;
    return pieces < VXS_REAL(nodes - 1) ? VXS_I(pieces) : nodes - 1;
}

/* Prepare a segment for insertion in pieces.
 * nodes        number that is kept, 2 to VXS_CURVE_MOST; the same at each call
 * entry, exit  depths, entry <= exit, between -VXS_CURVE_FAR and VXS_CURVE_FAR; otherwise, and if NaN, the segment is ignored
 * through      transmittance, 0 to 1; if 1 or more, or NaN, the segment is ignored. Its density is constant; if it is 0, the
 *              segment is practically opaque from its entry on */
VXS_FN vxs_curve_insertion vxs_curve_insertion_of(VXS_CURVE curve, vxs_i32 nodes, vxs_real entry, vxs_real exit, vxs_real through)
{
    vxs_curve_insertion s;
    s.entry   = entry;
    s.exit    = exit;
    s.through = through > 0.0 ? through : VXS_REAL(0.0);
    s.all     = through > 1e-30 ? through : VXS_REAL(1e-30);
    s.root    = sqrt(s.all > VXS_CURVE_LEAST ? s.all : VXS_REAL(VXS_CURVE_LEAST));
    s.begin   = entry;
    s.before  = VXS_REAL(1.0);
    s.next    = 1;
    s.even    = vxs_curve_pieces(curve, nodes, exit - entry, s.root);
    s.last    = s.even > 1 && s.all < VXS_CURVE_LEAST ? s.even + 1 : s.even;
    if (!(through < 1.0) || !(exit >= entry) || !(entry > -VXS_CURVE_FAR) || !(exit < VXS_CURVE_FAR)) s.last = 0;
    return s;
}

/* Multiply its next piece in, if next <= last.
 * Cost: sums, products and a quotient for each node; a piece that is not the last needs two logarithms. */
VXS_FN void vxs_curve_insert_next(VXS_CURVE_INOUT curve, vxs_i32 nodes, VXS_CURVE_INSERTION segment)
{
    vxs_real entry = VXS_FIELD(segment, entry), exit = VXS_FIELD(segment, exit), begin = VXS_FIELD(segment, begin), end = exit;
    vxs_real left = VXS_FIELD(segment, through);
    vxs_i32  n    = VXS_FIELD(segment, next);
    if (n > VXS_FIELD(segment, last)) return;
    if (n < VXS_FIELD(segment, last)) { /* equal steps of the root of transmittance give equal errors of linear pieces */
        vxs_real now = 1.0 - (1.0 - VXS_FIELD(segment, root)) * (VXS_REAL(n) / VXS_REAL(VXS_FIELD(segment, even)));
        left         = now * now;
        end          = entry + (exit - entry) * (log(left) / log(VXS_FIELD(segment, all)));
        end          = end > begin ? (end < exit ? end : exit) : begin;
    }
    vxs_curve_insert_thin(curve, nodes, begin, end, left / VXS_FIELD(segment, before));
    VXS_FIELD(segment, begin)  = end;
    VXS_FIELD(segment, before) = left;
    VXS_FIELD(segment, next)   = n + 1;
}

/* Insert all pieces. Shaders that insert many segments should loop over vxs_curve_insert_next themselves, to have one loop
 * instead of two nested loops. */
VXS_FN void vxs_curve_insert(VXS_CURVE_INOUT curve, vxs_i32 nodes, vxs_real entry, vxs_real exit, vxs_real through)
{
    vxs_curve_insertion segment = vxs_curve_insertion_of(curve, nodes, entry, exit, through);
    while (segment.next <= segment.last) vxs_curve_insert_next(curve, nodes, VXS_REF(segment));
}

/* Fill nodes [count, nodes) as in a stored curve. */
VXS_FN void vxs_curve_pad(VXS_CURVE_INOUT curve, vxs_i32 nodes)
{
    vxs_real left = VXS_REAL(1.0);
    for (vxs_i32 n = 0; n < VXS_CURVE_ROOM; n++) {
        if (n < VXS_FIELD(curve, count)) left = VXS_FIELD(curve, left)[n];
        if (n < VXS_FIELD(curve, count) || n >= nodes) continue;
        VXS_FIELD(curve, depth)[n] = VXS_REAL(VXS_CURVE_FAR);
        VXS_FIELD(curve, left)[n]  = left;
    }
}

/* first        index of the curve's first number
 * nodes        number of stored nodes, 2 to 31
 * exponential  interpolation between two nodes: 0: linear; 1: as through a medium of constant density
 * Cost: reads one depth in each of five steps, and two nodes. */
VXS_FN vxs_real vxs_curve_read(VXS_CURVE_STORED curves, vxs_i32 first, vxs_i32 nodes, vxs_real depth, vxs_i32 exponential)
{
    vxs_i32 before = 0;
    for (vxs_i32 step = 16; step > 0; step >>= 1)
        if (before + step <= nodes && !(vxs_curve_number(curves, first + 2 * (before + step - 1)) > depth)) before += step;
    if (before == 0) return VXS_REAL(1.0);
    vxs_i32  at = first + 2 * (before - 1);
    vxs_real d = vxs_curve_number(curves, at), a = vxs_curve_number(curves, at + 1);
    if (before == nodes) return a;
    return vxs_curve_between(a, vxs_curve_number(curves, at + 3), (depth - d) / (vxs_curve_number(curves, at + 2) - d),
                             exponential);
}

#endif
