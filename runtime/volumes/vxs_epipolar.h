/* Epipolar space: angles about the eye and a light. In it, eye rays and light rays are both parallel to an axis. One text for
 * C99, C++, GLSL and HLSL. Built on vxs_air.h.
 *
 *     vxs_epipolar_of_punctual     the frame of an eye and a punctual light, and the angles that a view can see
 *     vxs_epipolar_of_sun      the same of a sun
 *     vxs_epipolar_in_cone     the part of these angles that a spot light's cone can reach
 *     vxs_epipolar_from_place  position to angles
 *     vxs_epipolar_place       angles to position
 *     vxs_epipolar_eye         an eye ray: alpha and theta
 *     vxs_epipolar_phi_at      phi of a point on an eye ray
 *     vxs_epipolar_distance    the inverse: the distance of a point with a given phi
 *     vxs_epipolar_light_ray   a light ray: theta and phi
 *     vxs_epipolar_alpha_at    alpha of a point on a light ray
 *
 *                 light        alpha: at the eye, from the direction of the light to that of the point. Constant on an eye ray. On
 *                 a
 *      eye  alpha  *           light ray it increases away from the light, so that light ends at most once along the columns.
 *        *--------/ phi        theta: about the axis through eye and light. Constant on eye rays and light rays; 0 in the middle of
 *         `.     /             the view.
 *           `.  /              phi: at the light, from the direction of the eye to that of the point. 0 at the eye; on an eye ray
 *           it
 *             `/               increases to pi - alpha. Constant on a light ray.
 *            place             For a sun, whose rays are parallel, phi is the distance from the axis, in metres.
 *
 * Positions are metres from the eye. On the axis theta is undefined, and all points of an eye ray have the same phi, so that the
 * mapping has no inverse. An angle from asin or acos would lose half of its digits; this code uses atan2 of the length of a
 * cross product.
 * Source: [VSV11], "Creating VSVs"; suns and ranges are ours.
 * Internal: public texts need it; its names may change in any version.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_EPIPOLAR_H
#define VXS_EPIPOLAR_H

#ifndef VXS_AIR_H /* a shader that cannot include has it already */
#include "vxs_air.h"
#endif

#ifdef VXS_C
typedef struct vxs_epipolar      vxs_epipolar;
typedef struct vxs_epipolar_view vxs_epipolar_view;
typedef struct vxs_epipolar_ray  vxs_epipolar_ray;
#define VXS_EPIPOLAR      const vxs_epipolar *
#define VXS_EPIPOLAR_VIEW const vxs_epipolar_view *
#define VXS_EPIPOLAR_RAY  const vxs_epipolar_ray *
#else
#define VXS_EPIPOLAR      const vxs_epipolar
#define VXS_EPIPOLAR_VIEW const vxs_epipolar_view
#define VXS_EPIPOLAR_RAY  const vxs_epipolar_ray
#endif

/* The set of eye rays of a view. */
struct vxs_epipolar_view {
    vxs_real3 corners
        /* directions from the eye to the corners of the image, in order around it; of any length; all in less than a half space */
        [4];
    vxs_real far_metres; /* the largest length of an eye ray; > 0, finite */
};

/* Frame and ranges; angles in radians. */
struct vxs_epipolar {
    vxs_real3 axis;  /* unit vector from the eye toward the light */
    vxs_real3 ahead; /* unit vector across the axis, theta = 0 */
    vxs_real3 side;  /* unit vector across both, theta = pi / 2 */
    vxs_real  away;  /* metres from the eye to a punctual light, > 0; 0: a sun */
    vxs_real2 alpha; /* visible range: begin < end, in [0, pi] */
    vxs_real2 theta; /* visible range, in [-pi, pi]: the seam is opposite the view */
    vxs_real2 phi;   /* visible range: for punctual lights in [0, pi]; for suns metres, >= 0 */
};

/* An eye ray. */
struct vxs_epipolar_ray {
    vxs_real alpha, sine, cosine; /* sine and cosine of alpha */
    vxs_real theta;
};

#define VXS_EPIPOLAR_NEAREST 1e-9 /* metres; a nearer punctual light is placed at this distance from the eye */

/* angles ----------------------------------------------------------------------------------------------------------------------- */

/* atan2 in [0, pi], y >= 0; 0 if both are 0. C has full precision; shading languages guarantee about 4096 units in the last
 * place. */
VXS_FN vxs_real vxs_epipolar_angle(vxs_real y, vxs_real x)
{
#ifdef VXS_C
    return atan2(y, x);
#else
    vxs_real angle = vxs_air_angle(y, vxs_abs(x)); /* one call, because it is inlined */
    return x < 0.0 ? VXS_AIR_PI - angle : angle;
#endif
}

/* Sine and cosine of an angle in [0, pi]. The sine has an error of a few units in the last place, also near pi, relative to the
 * rounded angle.
 * turned  [out] sine, cosine */
VXS_FN void vxs_epipolar_turn(vxs_real angle, VXS_OUT vxs_real2 turned)
{
#ifdef VXS_C
    turned[0] = sin(angle);
    turned[1] = cos(angle);
#else
    float sharp = angle > 0.5 * VXS_AIR_PI ? VXS_AIR_PI - angle : angle, half_sine = vxs_air_sine(0.5 * sharp);
    turned[0] = 2.0 * half_sine * sqrt(1.0 - half_sine * half_sine);
    turned[1] = (angle > 0.5 * VXS_AIR_PI ? -1.0 : 1.0) * (1.0 - 2.0 * half_sine * half_sine);
#endif
}

VXS_FN void vxs_epipolar_cross(const vxs_real3 a, const vxs_real3 b, VXS_OUT vxs_real3 c)
{
    c[0] = a[1] * b[2] - a[2] * b[1];
    c[1] = a[2] * b[0] - a[0] * b[2];
    c[2] = a[0] * b[1] - a[1] * b[0];
}

/* Normalize v. It is first divided by its largest component, so that no square underflows or overflows.
 * Returns its length before; if that is 0 or NaN, v becomes 0 and 0 is returned. */
VXS_FN vxs_real vxs_epipolar_unit(VXS_INOUT vxs_real3 v)
{
    vxs_real most = VXS_REAL(0.0), length = VXS_REAL(0.0);
    for (vxs_i32 n = 0; n < 3; n++) most = vxs_abs(v[n]) > most ? vxs_abs(v[n]) : most;
    if (most > 0.0) {
        for (vxs_i32 n = 0; n < 3; n++) v[n] /= most;
        length = sqrt(vxs_air_dot(v, v));
        for (vxs_i32 n = 0; n < 3; n++) v[n] /= length;
    } else
        v[0] = v[1] = v[2] = VXS_REAL(0.0);
    return most * length;
}

/* places ----------------------------------------------------------------------------------------------------------------------- */

/* An eye ray.   direction  of length 1, or a point on it */
VXS_FN vxs_epipolar_ray vxs_epipolar_eye(VXS_EPIPOLAR space, const vxs_real3 direction)
{
    vxs_epipolar_ray ray;
    vxs_real         ahead = vxs_air_dot(VXS_FIELD(space, ahead), direction), side = vxs_air_dot(VXS_FIELD(space, side), direction);
    vxs_real         along = vxs_air_dot(VXS_FIELD(space, axis), direction), across = sqrt(ahead * ahead + side * side);
    vxs_real         length = sqrt(along * along + across * across);
    vxs_real         turn   = vxs_epipolar_angle(vxs_abs(side), ahead);
    ray.alpha               = vxs_epipolar_angle(across, along);
    ray.sine                = length > 0.0 ? across / length : VXS_REAL(0.0);
    ray.cosine              = length > 0.0 ? along / length : VXS_REAL(1.0);
    ray.theta               = side < 0.0 ? -turn : turn;
    return ray;
}

/* phi of the point at `metres` on the ray, >= 0. If light and eye are near each other, no nearly equal numbers are subtracted. */
VXS_FN vxs_real vxs_epipolar_phi_at(VXS_EPIPOLAR space, VXS_EPIPOLAR_RAY ray, vxs_real metres)
{
    vxs_real across = metres * VXS_FIELD(ray, sine);
    if (!(VXS_FIELD(space, away) > 0.0)) return across;
    return vxs_epipolar_angle(across, VXS_FIELD(space, away) - metres * VXS_FIELD(ray, cosine));
}

/* phi in the form that the functions below need.   turned  [out] sine and cosine; for suns, phi and 0 */
VXS_FN void vxs_epipolar_turn_of(VXS_EPIPOLAR space, vxs_real phi, VXS_OUT vxs_real2 turned)
{
    turned[0] = phi;
    turned[1] = VXS_REAL(0.0);
    if (VXS_FIELD(space, away) > 0.0) vxs_epipolar_turn(phi, turned);
}

/* Distance of phi on the ray, in metres; `most` if phi is not on the ray, or farther.   turned  vxs_epipolar_turn_of phi */
VXS_FN vxs_real vxs_epipolar_distance(VXS_EPIPOLAR space, VXS_EPIPOLAR_RAY ray, const vxs_real2 turned, vxs_real most)
{
    vxs_real across = turned[0], sine = VXS_FIELD(ray, sine);
    if (VXS_FIELD(space, away) > 0.0) { /* the law of sines */
        across *= VXS_FIELD(space, away);
        sine = VXS_FIELD(ray, sine) * turned[1] + VXS_FIELD(ray, cosine) * turned[0];
    }
    return across < most * sine ? across / sine : most;
}

/* place  from the eye, metres;   angles  [out] alpha, theta, phi */
VXS_FN void vxs_epipolar_from_place(VXS_EPIPOLAR space, const vxs_real3 place, VXS_OUT vxs_real3 angles)
{
    vxs_epipolar_ray ray    = vxs_epipolar_eye(space, place);
    vxs_real         metres = sqrt(vxs_air_dot(place, place));
    angles[0]               = ray.alpha;
    angles[1]               = ray.theta;
    angles[2]               = vxs_epipolar_phi_at(space, VXS_REF(ray), metres);
}

/* Unit vector across the axis at theta. */
VXS_FN void vxs_epipolar_across(VXS_EPIPOLAR space, vxs_real theta, VXS_OUT vxs_real3 across)
{
    vxs_real2 turned;
    vxs_epipolar_turn(vxs_abs(theta), turned);
    for (vxs_i32 n = 0; n < 3; n++)
        across[n] = turned[1] * VXS_FIELD(space, ahead)[n] + (theta < 0.0 ? -turned[0] : turned[0]) * VXS_FIELD(space, side)[n];
}

/* The inverse of vxs_epipolar_from_place.
 * angles  alpha, theta, phi; for punctual lights alpha + phi < pi
 * place   [out] at most VXS_EPIPOLAR_FARTHEST away */
#define VXS_EPIPOLAR_FARTHEST 1e15
VXS_FN void vxs_epipolar_place(VXS_EPIPOLAR space, const vxs_real3 angles, VXS_OUT vxs_real3 place)
{
    vxs_epipolar_ray ray;
    vxs_real2        turned, at;
    vxs_real3        across;
    vxs_epipolar_turn(angles[0], turned);
    ray.alpha  = angles[0];
    ray.theta  = angles[1];
    ray.sine   = turned[0];
    ray.cosine = turned[1];
    vxs_epipolar_turn_of(space, angles[2], at);
    vxs_real metres = vxs_epipolar_distance(space, VXS_REF(ray), at, VXS_REAL(VXS_EPIPOLAR_FARTHEST));
    vxs_epipolar_across(space, angles[1], across);
    for (vxs_i32 n = 0; n < 3; n++) place[n] = metres * (ray.cosine * VXS_FIELD(space, axis)[n] + ray.sine * across[n]);
}

/* A light ray: its origin (the light; for a sun, a point beside the eye, from which the ray extends both ways), and its
 * direction, of length 1.
 * across  vxs_epipolar_across theta;   turned  vxs_epipolar_turn_of phi */
VXS_FN void vxs_epipolar_light_ray(VXS_EPIPOLAR space, const vxs_real3 across, const vxs_real2 turned, VXS_OUT vxs_real3 begin,
                                   VXS_OUT vxs_real3 direction)
{
    vxs_i32 is_punctual = VXS_FIELD(space, away) > 0.0 ? 1 : 0;
    for (vxs_i32 n = 0; n < 3; n++) {
        vxs_real axis = VXS_FIELD(space, axis)[n];
        begin[n]      = is_punctual != 0 ? VXS_FIELD(space, away) * axis : turned[0] * across[n];
        direction[n]  = is_punctual != 0 ? turned[0] * across[n] - turned[1] * axis : -axis;
    }
}

/* alpha of the point at `metres` from the origin of a light ray; for suns `metres` may be negative.   turned  as above */
VXS_FN vxs_real vxs_epipolar_alpha_at(VXS_EPIPOLAR space, const vxs_real2 turned, vxs_real metres)
{
    if (!(VXS_FIELD(space, away) > 0.0)) return vxs_epipolar_angle(turned[0], -metres);
    return vxs_epipolar_angle(metres * turned[0], VXS_FIELD(space, away) - metres * turned[1]);
}

/* ranges ----------------------------------------------------------------------------------------------------------------------- */

/* The frame about an axis; theta is 0 in the middle of the view. Its range of theta is left 0, 0. If the axis is in the middle
 * of the view, `ahead` is any vector across it, and the range of theta is the full circle.
 * axis, middle  of length 1 */
VXS_FN vxs_epipolar vxs_epipolar_frame(const vxs_real3 axis, const vxs_real3 middle)
{
    vxs_epipolar space;
    vxs_i32      least = 0;
    space.away         = VXS_REAL(0.0);
    for (vxs_i32 n = 0; n < 3; n++) {
        if (vxs_abs(axis[n]) < vxs_abs(axis[least])) least = n;
        space.axis[n]  = axis[n];
        space.ahead[n] = middle[n];
    }
    space.theta[0] = space.theta[1] = VXS_REAL(0.0);
    for (vxs_i32 turn = 0; turn < 3;
         turn++) { /* repeat: a vector nearly along the axis leaves a short rest, with an error along the axis */
        vxs_real along = vxs_air_dot(axis, space.ahead);
        for (vxs_i32 n = 0; n < 3; n++) space.ahead[n] -= along * axis[n];
        if (turn == 0 && !(vxs_air_dot(space.ahead, space.ahead) > 1e-10)) {
            for (vxs_i32 n = 0; n < 3; n++) space.ahead[n] = n == least ? VXS_REAL(1.0) : VXS_REAL(0.0);
            space.theta[0] = VXS_REAL(-VXS_AIR_PI);
            space.theta[1] = VXS_REAL(VXS_AIR_PI);
        }
        vxs_epipolar_unit(space.ahead);
    }
    vxs_epipolar_cross(axis, space.ahead, space.side);
    vxs_epipolar_unit(space.side);
    return space;
}

/* Widen the range of alpha by an edge of the image from one corner to the next: by its ends, and by where its plane is nearest
 * to the axis.
 * a, b   of length 1
 * alpha  [in, out] smallest and greatest
 * Returns the side of the edge on which the axis is: the cosine to the normal of its plane; 0 if it has none. */
VXS_FN vxs_real vxs_epipolar_edge(const vxs_real3 axis, const vxs_real3 a, const vxs_real3 b, VXS_INOUT vxs_real2 alpha)
{
    vxs_real3 normal, across, in_plane, ahead_of_a, behind_b;
    vxs_epipolar_cross(a, axis, across);
    vxs_real at_a = vxs_epipolar_angle(sqrt(vxs_air_dot(across, across)), vxs_air_dot(a, axis));
    alpha[0]      = at_a < alpha[0] ? at_a : alpha[0];
    alpha[1]      = at_a > alpha[1] ? at_a : alpha[1];
    vxs_epipolar_cross(a, b, normal);
    if (!(vxs_epipolar_unit(normal) > 0.0)) return VXS_REAL(0.0);
    vxs_real above = vxs_air_dot(axis, normal);
    for (vxs_i32 n = 0; n < 3; n++) in_plane[n] = axis[n] - above * normal[n];
    vxs_real nearest = vxs_epipolar_angle(vxs_abs(above), sqrt(vxs_air_dot(in_plane, in_plane)));
    vxs_epipolar_cross(a, in_plane, ahead_of_a);
    vxs_epipolar_cross(in_plane, b, behind_b);
    vxs_real first = vxs_air_dot(ahead_of_a, normal), last = vxs_air_dot(behind_b, normal);
    if (first > 0.0 && last > 0.0 && nearest < alpha[0]) alpha[0] = nearest;
    if (first < 0.0 && last < 0.0 && VXS_AIR_PI - nearest > alpha[1]) alpha[1] = VXS_AIR_PI - nearest;
    return above;
}

/* The ranges of angles that the view can see. alpha: of the edge of the image, down to 0 or up to pi if the axis or its opposite
 * is in the view. theta: of the corners, less than half a circle; the full circle if the axis is or may be in the view. phi: of
 * the farthest points. */
VXS_FN void vxs_epipolar_widen(VXS_EPIPOLAR space, VXS_EPIPOLAR_VIEW view, const vxs_real3 middle, VXS_INOUT vxs_real2 alpha,
                               VXS_INOUT vxs_real2 theta, VXS_INOUT vxs_real2 phi)
{
    vxs_real3 a, b, normal;
    vxs_i32   inside = 1, opposite = 1;
    alpha[0] = VXS_REAL(VXS_AIR_PI);
    alpha[1] = VXS_REAL(0.0);
    for (vxs_i32 n = 0; n < 4; n++) {
        for (vxs_i32 i = 0; i < 3; i++) {
            a[i] = VXS_FIELD(view, corners)[n][i];
            b[i] = VXS_FIELD(view, corners)[(n + 1) & 3][i];
        }
        vxs_epipolar_unit(a);
        vxs_epipolar_unit(b);
        vxs_real above = vxs_epipolar_edge(VXS_FIELD(space, axis), a, b, alpha);
        vxs_epipolar_cross(a, b, normal);
        if (vxs_air_dot(normal, middle) < 0.0) above = -above;
        if (above < -1e-4) inside = 0; /* on the edge counts as in view */
        if (above > 1e-4) opposite = 0;
        vxs_epipolar_ray corner = vxs_epipolar_eye(space, a);
        theta[0]                = corner.theta < theta[0] ? corner.theta : theta[0];
        theta[1]                = corner.theta > theta[1] ? corner.theta : theta[1];
    }
    if (inside != 0) alpha[0] = VXS_REAL(0.0);
    if (opposite != 0) alpha[1] = VXS_REAL(VXS_AIR_PI);
    if (inside != 0 || opposite != 0) {
        theta[0] = VXS_REAL(-VXS_AIR_PI);
        theta[1] = VXS_REAL(VXS_AIR_PI);
    }
    vxs_real away = VXS_FIELD(space, away), far = VXS_FIELD(view, far_metres), widest = VXS_REAL(0.5 * VXS_AIR_PI);
    if (away > 0.0)
        widest = far < away ? vxs_epipolar_angle(sqrt((away - far) * (away + far)), far) : VXS_REAL(0.0); /* cosine far / away */
    widest = widest < alpha[0]   ? alpha[0]
             : widest > alpha[1] ? alpha[1]
                                 : widest; /* phi of the far end rises to there, then falls */
    vxs_real2        turned;
    vxs_epipolar_ray ray;
    vxs_epipolar_turn(widest, turned);
    ray.alpha  = widest;
    ray.theta  = VXS_REAL(0.0);
    ray.sine   = turned[0];
    ray.cosine = turned[1];
    phi[0]     = VXS_REAL(0.0);
    phi[1]     = vxs_epipolar_phi_at(space, VXS_REF(ray), far);
}

/* Widen a range that is empty or nearly empty, relative to its greatest number. */
VXS_FN void vxs_epipolar_open(VXS_INOUT vxs_real2 range)
{
    vxs_real most = vxs_abs(range[0]) > vxs_abs(range[1]) ? vxs_abs(range[0]) : vxs_abs(range[1]), least = 1e-5 * most + 1e-20;
    if (!(range[1] - range[0] > least)) range[1] = range[0] + least;
}

VXS_FN vxs_epipolar vxs_epipolar_of(const vxs_real3 axis, vxs_real away, VXS_EPIPOLAR_VIEW view)
{
    vxs_real3 middle, way, corner;
    for (vxs_i32 n = 0; n < 3; n++) middle[n] = VXS_REAL(0.0);
    for (vxs_i32 n = 0; n < 4; n++) {
        for (vxs_i32 i = 0; i < 3; i++) corner[i] = VXS_FIELD(view, corners)[n][i];
        vxs_epipolar_unit(corner);
        for (vxs_i32 i = 0; i < 3; i++) middle[i] += corner[i];
    }
    vxs_epipolar_unit(middle);
    for (vxs_i32 n = 0; n < 3; n++) way[n] = axis[n];
    if (!(vxs_epipolar_unit(way) > 0.0))
        for (vxs_i32 n = 0; n < 3; n++) way[n] = middle[n];
    vxs_epipolar space = vxs_epipolar_frame(way, middle);
    space.away         = away;
    vxs_epipolar_widen(VXS_REF(space), view, middle, space.alpha, space.theta, space.phi);
    vxs_epipolar_open(space.alpha);
    vxs_epipolar_open(space.theta);
    vxs_epipolar_open(space.phi);
    return space;
}

/* to_light  from the eye, metres; finite */
VXS_FN vxs_epipolar vxs_epipolar_of_punctual(const vxs_real3 to_light, VXS_EPIPOLAR_VIEW view)
{
    vxs_real3 axis;
    for (vxs_i32 n = 0; n < 3; n++) axis[n] = to_light[n];
    vxs_real away = vxs_epipolar_unit(axis);
    return vxs_epipolar_of(axis, away > VXS_EPIPOLAR_NEAREST ? away : VXS_REAL(VXS_EPIPOLAR_NEAREST), view);
}

/* For a spot light: clip the range of phi to its cone.
 * phi        [in, out] of a frame of vxs_epipolar_of_punctual
 * axis       direction of the light, of length 1
 * cos_outer  of the cone, >= 0 */
VXS_FN void vxs_epipolar_in_cone(VXS_EPIPOLAR space, const vxs_real3 axis, vxs_real cos_outer, VXS_INOUT vxs_real2 phi)
{
    vxs_real3 across;
    vxs_epipolar_cross(axis, VXS_FIELD(space, axis), across);
    vxs_real turned = vxs_epipolar_angle(sqrt(vxs_air_dot(across, across)), -vxs_air_dot(axis, VXS_FIELD(space, axis)));
    vxs_real wide   = vxs_epipolar_angle(sqrt((1.0 - cos_outer) * (1.0 + cos_outer)), cos_outer);
    if (turned - wide > phi[0]) phi[0] = turned - wide < phi[1] ? turned - wide : phi[1];
    if (turned + wide < phi[1]) phi[1] = turned + wide > phi[0] ? turned + wide : phi[0];
    vxs_epipolar_open(phi);
}

/* to_sun  direction to it, of any length */
VXS_FN vxs_epipolar vxs_epipolar_of_sun(const vxs_real3 to_sun, VXS_EPIPOLAR_VIEW view)
{
    return vxs_epipolar_of(to_sun, VXS_REAL(0.0), view);
}

#endif
