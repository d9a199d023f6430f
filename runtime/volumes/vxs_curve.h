/* How much light is left along a light ray, as a curve of a few nodes: one text for C99, C++ and GLSL, that stands on vxs_space.h.
 *
 *     vxs_curve_empty      a curve through empty space
 *     vxs_curve_insert     multiply a segment of smoke into it, and keep no more than so many nodes; piece by piece: vxs_curve_insertion_of, vxs_curve_insert_next
 *     vxs_curve_at         the transmittance at a depth
 *     vxs_curve_pad        fill up what is stored of it
 *     vxs_curve_read       the transmittance at a depth, of a curve that is stored
 *
 * A node is a depth and the transmittance there, from the light on: 1 is all light. Before the first node it is 1, behind the last what that has.
 * Two nodes of one depth are a step, as of a surface or a thin hair.
 *
 *     t 1 ---o.                      a segment from entry to exit that lets T through: nodes before it stay, those in it are multiplied
 *            entry `o...........     by what it lets through up to there, those behind it by T; it adds two, on the curve as it was, and
 *              exit         :   `o-----   a third between them, where the product of the segment and the curve bends most
 *                                last
 *
 * A thick segment falls as an exponential, most of it behind its entry: it is multiplied in as several thin ones, between whose nodes the exponential
 * is nearly a line. And of many segments that overlap, each adds a node where their product has become steep.
 *
 * While there are more than `nodes`, the inner node goes whose triangle with its neighbours is the least: the integral of the curve changes the
 * least. Nodes never move, and the first and the last never go: so the curve never rises, and behind its end it is the product of all segments,
 * in whatever order they came. Between, the order says which nodes go.
 *
 * Stored, a curve is `nodes` pairs of numbers, depth and transmittance; unused nodes lie at VXS_CURVE_FAR, with the transmittance of the last. A
 * shader that reads them defines, before this text, vxs_curve_number(curves, i), number i of all that are stored; `curves` is what it hands to
 * vxs_curve_read. VXS_CURVE_MOST, which an includer may define, is the greatest number of nodes that a curve has room for: 16 if not.
 * Source: [AVSM10] 3.2, 3.3 and 4.1; how a segment lies on nodes of its own depths, towards 0, and in pieces, is ours.
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
#define VXS_CURVE_FAR  1e30 /* finite: no infinity times 0 */

struct vxs_curve {
    vxs_i32  count;                 /* of nodes */
    vxs_real depth[VXS_CURVE_ROOM]; /* metres, or any other length that all nodes have; they never fall */
    vxs_real left[VXS_CURVE_ROOM];  /* transmittance, 0 to 1; it never rises */
};

/* Of a depth: what is left there, and how many nodes lie no farther. */
struct vxs_curve_place {
    vxs_real left;
    vxs_i32  nodes;
};

/* What is multiplied in piece by piece, the next one from `begin` on, before which it has let `before` through; done with the last. `even` pieces have as much of
 * the fall of the root of transmittance each; through and all: what it lets through, the second one never 0. */
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

/* Between a and b, 1 >= a >= b >= 0, at a part of the way: along a line, or as through a medium of even density. No such medium ends at 0, so that
 * towards 0 it is a line, too. */
VXS_FN vxs_real vxs_curve_between(vxs_real a, vxs_real b, vxs_real part, vxs_i32 exponential)
{
    vxs_real left = exponential != 0 && b > 0.0 ? a * exp(log(b / a) * part) : a + (b - a) * part;
    left          = left < a ? left : a;
    return left > b ? left : b;
}

/* At a node of just that depth: behind its step. */
VXS_FN vxs_curve_place vxs_curve_find(VXS_CURVE curve, vxs_real depth, vxs_i32 exponential)
{
    vxs_real        before = depth, behind = depth, a = VXS_REAL(1.0), b = VXS_REAL(1.0);
    vxs_curve_place place;
    place.nodes = 0;
    for (vxs_i32 n = 0; n < VXS_CURVE_ROOM; n++) { /* without branches: shaders on processors take all of them */
        vxs_i32 is_node = n < VXS_FIELD(curve, count) ? 1 : 0, is_before = VXS_FIELD(curve, depth)[n] > depth ? 0 : is_node;
        vxs_i32 is_next = is_before != 0 || behind > depth ? 0 : is_node;
        before          = is_before != 0 ? VXS_FIELD(curve, depth)[n] : before;
        a               = is_before != 0 ? VXS_FIELD(curve, left)[n] : a;
        behind          = is_next != 0 ? VXS_FIELD(curve, depth)[n] : behind;
        b               = is_next != 0 ? VXS_FIELD(curve, left)[n] : b;
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

/* What an evenly dense segment lets through up to a part of it: the exponential by a parabola, which is off by 2e-4 at most where three quarters get through, 2e-3 where a half does, and of what
 * is thicker a line.   root  of what it lets through in all */
VXS_FN vxs_real vxs_curve_part(vxs_real through, vxs_real root, vxs_real part)
{
    vxs_real bow  = root > 0.7 ? 2.0 * (1.0 - root) * (1.0 - root) : VXS_REAL(0.0);
    vxs_real left = 1.0 - part * (1.0 - through + bow * (1.0 - part));
    left          = left < 1.0 ? left : VXS_REAL(1.0);
    return left > through ? left : through;
}

/* Where the product of a segment and the curve bends most: both are lines between two nodes, and the product falls below the line between its ends by a quarter
 * of what both lose there. The middle of that part; where there is none, VXS_CURVE_FAR.   left, at_exit  of the curve, at the ends */
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

/* Multiply a segment in, and add its two or three nodes: as if there were room for any number. */
VXS_FN void vxs_curve_multiply(VXS_CURVE_INOUT curve, vxs_real entry, vxs_real exit, vxs_real through)
{
    vxs_curve_place begin = vxs_curve_find(curve, entry, 0), end = vxs_curve_find(curve, exit, 0), within;
    vxs_real bend = vxs_curve_bend(curve, entry, exit, begin.left, end.left), at_entry = begin.left, at_bend = at_entry;
    vxs_real at_exit = end.left * through, root = sqrt(through);
    vxs_i32  bends = bend < exit ? 1 : 0, first = begin.nodes, last = end.nodes + 1 + bends, middle = VXS_CURVE_ROOM;
    if (bends != 0) {
        within  = vxs_curve_find(curve, bend, 0);
        at_bend = within.left * vxs_curve_part(through, root, (bend - entry) / (exit - entry));
        middle  = within.nodes + 1;
    }
    vxs_real older_depth = entry, older_left = VXS_REAL(1.0), old_depth = entry, old_left = VXS_REAL(1.0), depth = entry,
             left = VXS_REAL(1.0), least = left;
    for (vxs_i32 n = 0; n < VXS_CURVE_ROOM; n++) { /* nodes move by as many as have come before them */
        vxs_real now_depth = VXS_FIELD(curve, depth)[n], now_left = VXS_FIELD(curve, left)[n], d = now_depth, t = now_left;
        if (n > last) {
            d = bends != 0 ? older_depth : old_depth;
            t = (bends != 0 ? older_left : old_left) * through;
        } else if (n == last) {
            d = exit;
            t = at_exit;
        } else if (n == middle) {
            d = bend;
            t = at_bend;
        } else if (n == first) {
            d = entry;
            t = at_entry;
        } else if (n > first) {
            d = n > middle ? old_depth : depth;
            t = n > middle ? old_left : left;
            t *= vxs_curve_part(through, root, (d - entry) / (exit - entry));
        }
        least                      = t < least ? t : least; /* quotients of shading languages may be off by a bit */
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

/* Remove the inner node that changes the integral the least: by twice the area of its triangle. Of a curve of three nodes and more. */
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

/* The same, and no more than so many nodes are kept. */
VXS_FN void vxs_curve_insert_thin(VXS_CURVE_INOUT curve, vxs_i32 nodes, vxs_real entry, vxs_real exit, vxs_real through)
{
    vxs_curve_multiply(curve, entry, exit, through);
    for (vxs_i32 n = 0; n < 3; n++)
        if (VXS_FIELD(curve, count) > nodes) vxs_curve_remove_least(curve);
}

#define VXS_CURVE_LEAST 1e-3 /* transmittance below which a segment is one more piece */

/* In how many pieces a segment is multiplied in: such that a line is off by no more than a hundredth in each, but for one that is short beside the curve.
 * root  of what it lets through, no less than of VXS_CURVE_LEAST */
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

/* A segment that is to be multiplied in piece by piece.
 * nodes        that are kept, 2 to VXS_CURVE_MOST; the same at each call
 * entry, exit  depths, entry <= exit, between -VXS_CURVE_FAR and VXS_CURVE_FAR: else, and where it is no number, there is no segment
 * through      what it lets through: 0 to 1; 1 and more, and what is no number: there is none. Between its ends it is evenly dense; of 0, as good as
 *              opaque from its entry on */
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
 * Cost: no more than sums, products and a quotient for each node; a piece that is not the last takes two logarithms. */
VXS_FN void vxs_curve_insert_next(VXS_CURVE_INOUT curve, vxs_i32 nodes, VXS_CURVE_INSERTION segment)
{
    vxs_real entry = VXS_FIELD(segment, entry), exit = VXS_FIELD(segment, exit), begin = VXS_FIELD(segment, begin), end = exit;
    vxs_real left = VXS_FIELD(segment, through);
    vxs_i32  n    = VXS_FIELD(segment, next);
    if (n > VXS_FIELD(segment, last)) return;
    if (n < VXS_FIELD(segment, last)) { /* roots of transmittance are spaced evenly: so is the error of lines */
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

/* All of them. In shaders that insert many segments, a loop of their own over vxs_curve_insert_next is one loop and not two. */
VXS_FN void vxs_curve_insert(VXS_CURVE_INOUT curve, vxs_i32 nodes, vxs_real entry, vxs_real exit, vxs_real through)
{
    vxs_curve_insertion segment = vxs_curve_insertion_of(curve, nodes, entry, exit, through);
    while (segment.next <= segment.last) vxs_curve_insert_next(curve, nodes, VXS_REF(segment));
}

/* Fill nodes [count, nodes) as they are stored. */
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

/* first        the number with which the curve begins
 * nodes        that are stored of it, 2 to 31
 * exponential  between two nodes: 0: along a line; 1: as through a medium of even density
 * Reads a depth in each of five steps, and two nodes. */
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
