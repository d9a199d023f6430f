/* How much light is left along a light ray, as a curve of a few nodes: one text for C99, C++ and GLSL, that stands on vxs_space.h.
 *
 *     vxs_curve_empty      a curve through empty space
 *     vxs_curve_insert     multiply a segment of smoke into it, and keep no more than so many nodes
 *     vxs_curve_at         the transmittance at a depth
 *     vxs_curve_pad        fill up what is stored of it
 *     vxs_curve_read       the transmittance at a depth, of a curve that is stored
 *
 * A node is a depth and the transmittance there, from the light on: 1 is all light. Before the first node it is 1, behind the last what that has.
 * Two nodes of one depth are a step, as of a surface or a thin hair.
 *
 *     t 1 ---o.                      a segment from entry to exit that lets T through: nodes before it stay, those in it are multiplied
 *            entry `o...........     by what it lets through up to there, those behind it by T; it adds two, on the curve as it was
 *              exit         :   `o-----
 *                                last
 *
 * While there are more than `nodes`, the inner node goes whose triangle with its neighbours is the least: the integral of the curve changes the
 * least. Nodes never move, and the first and the last never go: so the curve never rises, and behind its end it is the product of all segments,
 * in whatever order they came. Between, the order says which nodes go.
 *
 * Stored, a curve is `nodes` pairs of numbers, depth and transmittance; unused nodes lie at VXS_CURVE_FAR, with the transmittance of the last. A
 * shader that reads them defines, before this text, vxs_curve_number(curves, i), number i of all that are stored; `curves` is what it hands to
 * vxs_curve_read. VXS_CURVE_MOST, which an includer may define, is the greatest number of nodes that a curve has room for: 16 if not.
 * Source: [AVSM10] 3.2, 3.3 and 4.1; how a segment lies on nodes of its own depths, and towards 0, is ours.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_CURVE_H
#define VXS_CURVE_H

#ifndef VXS_SPACE_H /* a shader that cannot include has it already */
#include "vxs_space.h"
#endif

#ifdef VXS_C
typedef struct vxs_curve vxs_curve;
#define VXS_CURVE        const vxs_curve *
#define VXS_CURVE_INOUT  vxs_curve *
#define VXS_CURVE_STORED const float *
#ifndef vxs_curve_number
#define vxs_curve_number(curves, i) VXS_REAL((curves)[i])
#endif
#else
#define VXS_CURVE        vxs_curve
#define VXS_CURVE_INOUT  inout vxs_curve
#define VXS_CURVE_STORED uint
#endif

#ifndef VXS_CURVE_MOST
#define VXS_CURVE_MOST 16
#endif
#define VXS_CURVE_ROOM (VXS_CURVE_MOST + 2)
#define VXS_CURVE_FAR  1e30 /* finite: no infinity times 0 */

struct vxs_curve {
    vxs_i32  count;                 /* of nodes */
    vxs_real depth[VXS_CURVE_ROOM]; /* metres, or any other length that all nodes have; they never fall */
    vxs_real left[VXS_CURVE_ROOM];  /* transmittance, 0 to 1; it never rises */
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
VXS_FN vxs_real vxs_curve_at(VXS_CURVE curve, vxs_real depth, vxs_i32 exponential)
{
    vxs_real before = depth, behind = depth, a = VXS_REAL(1.0), b = VXS_REAL(1.0);
    for (vxs_i32 n = 0; n < VXS_CURVE_ROOM; n++) {
        if (n >= VXS_FIELD(curve, count)) break;
        if (!(VXS_FIELD(curve, depth)[n] > depth)) {
            before = VXS_FIELD(curve, depth)[n];
            a      = VXS_FIELD(curve, left)[n];
        } else if (!(behind > depth)) {
            behind = VXS_FIELD(curve, depth)[n];
            b      = VXS_FIELD(curve, left)[n];
        }
    }
    return behind > depth ? vxs_curve_between(a, b, (depth - before) / (behind - before), exponential) : a;
}

/* How many nodes lie no farther than a depth. */
VXS_FN vxs_i32 vxs_curve_nodes_to(VXS_CURVE curve, vxs_real depth)
{
    vxs_i32 nodes = 0;
    for (vxs_i32 n = 0; n < VXS_CURVE_ROOM; n++)
        if (n < VXS_FIELD(curve, count) && !(VXS_FIELD(curve, depth)[n] > depth)) nodes++;
    return nodes;
}

/* Multiply a segment in, and add its two nodes: as if there were room for any number. */
VXS_FN void vxs_curve_multiply(VXS_CURVE_INOUT curve, vxs_real entry, vxs_real exit, vxs_real through)
{
    vxs_real at_entry = vxs_curve_at(curve, entry, 0), at_exit = vxs_curve_at(curve, exit, 0) * through;
    vxs_i32  first = vxs_curve_nodes_to(curve, entry), last = vxs_curve_nodes_to(curve, exit) + 1;
    vxs_real depth = entry, left = VXS_REAL(1.0), older_depth = depth, older_left = left, least = left;
    for (vxs_i32 n = 0; n < VXS_CURVE_ROOM; n++) { /* nodes behind entry move by one, those behind exit by two */
        vxs_real now_depth = VXS_FIELD(curve, depth)[n], now_left = VXS_FIELD(curve, left)[n], d = now_depth, t = now_left;
        if (n > last) {
            d = older_depth;
            t = older_left * through;
        } else if (n == last) {
            d = exit;
            t = at_exit;
        } else if (n > first) {
            d = depth;
            t = left * vxs_curve_between(VXS_REAL(1.0), through, (depth - entry) / (exit - entry), 0);
        } else if (n == first) {
            d = entry;
            t = at_entry;
        }
        least                      = t < least ? t : least; /* quotients of shading languages may be off by a bit */
        VXS_FIELD(curve, depth)[n] = d;
        VXS_FIELD(curve, left)[n]  = least;
        older_depth                = depth;
        older_left                 = left;
        depth                      = now_depth;
        left                       = now_left;
    }
    VXS_FIELD(curve, count) += 2;
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

/* nodes        that are kept, 2 to VXS_CURVE_MOST; the same at each call
 * entry, exit  depths, entry <= exit, between -VXS_CURVE_FAR and VXS_CURVE_FAR: else, and where it is no number, there is no segment
 * through      what it lets through: 0 to 1; 1 and more, and what is no number: there is none
 * Cost: no more than sums, products and a quotient for each node in the segment: a segment and what a curve is between its nodes are lines here. Exponentials
 * in their place are no nearer to the truth once nodes are removed, and take longer. */
VXS_FN void vxs_curve_insert(VXS_CURVE_INOUT curve, vxs_i32 nodes, vxs_real entry, vxs_real exit, vxs_real through)
{
    if (!(through < 1.0) || !(exit >= entry) || !(entry > -VXS_CURVE_FAR) || !(exit < VXS_CURVE_FAR)) return;
    vxs_curve_multiply(curve, entry, exit, through > 0.0 ? through : VXS_REAL(0.0));
    for (vxs_i32 n = 0; n < 2; n++)
        if (VXS_FIELD(curve, count) > nodes) vxs_curve_remove_least(curve);
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
