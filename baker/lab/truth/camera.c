/* The camera of a picture; see camera.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/truth/camera.h"

#include <math.h>
#include <string.h>

#include "baker/base/box.h"
#include "baker/base/vec3.h"

static const double pi = 3.14159265358979323846;

static void corner_of(const box *b, int n, double corner[3])
{
    for (int i = 0; i < 3; i++) corner[i] = n >> i & 1 ? b->max[i] : b->min[i];
}

/* Unit axes of a camera with the direction `forward`: level with the horizon, unless that is vertical or up_ws is given. */
static void camera_axes(const double forward[3], const double up_ws[3], double right[3], double up[3])
{
    static const double vertical[3] = {0, 1, 0};
    double              across[3];
    vec3_cross(forward, vec3_dot(up_ws, up_ws) > 0 ? up_ws : vertical, across);
    if (!vec3_unit(across, right)) memcpy(right, (double[3]){1, 0, 0}, 3 * sizeof *right);
    vec3_cross(right, forward, up);
}

/* Extent of the box on both sides of the target along an axis, seen from `distance`, as slopes. */
static void slopes_of(const box *b, const double target[3], double distance, const double forward[3], const double axis[3],
                      double *low, double *high)
{
    *low  = INFINITY;
    *high = -INFINITY;
    for (int n = 0; n < 8; n++) {
        double corner[3], from[3];
        corner_of(b, n, corner);
        vec3_sub(corner, target, from);
        double slope = vec3_dot(from, axis) / (distance + vec3_dot(from, forward));
        *low         = fmin(*low, slope);
        *high        = fmax(*high, slope);
    }
}

void camera_frame_orbit(camera_pose *camera, const box *b, double aspect)
{
    enum { STEPS = 360 };
    const double margin = 1.03;
    double tan_y = tan(camera->fov_degrees * pi / 360) / margin, tan_x = tan_y * aspect, away[3], unit[3] = {0, 0, 1}, distance = 0;
    vec3_sub(camera->eye_ws, camera->target_ws, away);
    vec3_unit(away, unit);
    for (int axis = 0; axis < 3; axis++) camera->target_ws[axis] = 0.5 * (b->min[axis] + b->max[axis]);
    for (int step = 0; step < STEPS; step++) {
        double angle      = 2 * pi * step / STEPS, right[3], up[3];
        double forward[3] = {-(unit[0] * cos(angle) - unit[2] * sin(angle)), -unit[1],
                             -(unit[0] * sin(angle) + unit[2] * cos(angle))};
        camera_axes(forward, (const double[3]){0}, right, up);
        for (int n = 0; n < 8; n++) {
            double corner[3], from[3];
            corner_of(b, n, corner);
            vec3_sub(corner, camera->target_ws, from);
            double behind = vec3_dot(from, forward);
            distance      = fmax(distance, fmax(fabs(vec3_dot(from, right)) / tan_x, fabs(vec3_dot(from, up)) / tan_y) - behind);
        }
    }
    vec3_mad(camera->target_ws, fmax(distance, 1e-3 * fmax(box_diagonal(b), 1e-9)), unit, camera->eye_ws);
}

void camera_frame_lit(camera_pose *camera, const box *b, const vxs_baked_light *const *lights, uint32_t light_count, double aspect)
{
    static const double usual[3] = {-0.43, -0.86, -0.26};
    const double       *sun      = usual;
    for (uint32_t n = light_count; n-- > 0;)
        if (lights[n]->light.kind == VXS_LIGHT_KIND_DIRECTIONAL) sun = lights[n]->light.direction_ws;

    const double margin = 1.03, elevation = 24 * pi / 180, aside = -64 * pi / 180;
    double       size  = fmax(box_diagonal(b), 1e-9);
    double       tan_y = tan(camera->fov_degrees * pi / 360) / margin, tan_x = tan_y * aspect;
    double       azimuth    = atan2(-sun[2], -sun[0]) + aside;
    double       forward[3] = {-cos(azimuth) * cos(elevation), -sin(elevation), -sin(azimuth) * cos(elevation)};
    double       right[3], up[3], target[3], distance = 0;
    camera_axes(forward, (const double[3]){0}, right, up);
    for (int i = 0; i < 3; i++) target[i] = 0.5 * (b->min[i] + b->max[i]);

    /* centre the box in the view, move back until it fits, and repeat, since perspective moves the centre */
    for (int round = 0; round < 8; round++) {
        double low, high;
        distance = 0;
        for (int n = 0; n < 8; n++) {
            double corner[3], from[3];
            corner_of(b, n, corner);
            vec3_sub(corner, target, from);
            double behind = vec3_dot(from, forward);
            distance      = fmax(distance, fabs(vec3_dot(from, right)) / tan_x - behind);
            distance      = fmax(distance, fabs(vec3_dot(from, up)) / tan_y - behind);
        }
        distance = fmax(distance, size * 1e-3);
        slopes_of(b, target, distance, forward, right, &low, &high);
        vec3_mad(target, 0.5 * (low + high) * distance, right, target);
        slopes_of(b, target, distance, forward, up, &low, &high);
        vec3_mad(target, 0.5 * (low + high) * distance, up, target);
    }
    memcpy(camera->target_ws, target, sizeof target);
    vec3_mad(target, -distance, forward, camera->eye_ws);
}

camera_view camera_view_of(const camera_pose *camera, double aspect)
{
    camera_view v;
    double      tan_y = tan(camera->fov_degrees * pi / 360), along[3];
    vec3_sub(camera->target_ws, camera->eye_ws, along);
    vec3_unit(along, v.forward);
    camera_axes(v.forward, camera->up_ws, v.right, v.up);
    for (int i = 0; i < 3; i++) {
        v.right[i] *= tan_y * aspect;
        v.up[i] *= tan_y;
    }
    return v;
}

void camera_direction(const camera_view *v, double x, double y, double direction[3])
{
    double along[3];
    vec3_mad(v->forward, 2 * x - 1, v->right, along);
    vec3_mad(along, 1 - 2 * y, v->up, along);
    vec3_unit(along, direction);
}
