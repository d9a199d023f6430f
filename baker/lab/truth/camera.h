/* The place of a camera, and the direction of each place of its picture.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CAMERA_H
#define CAMERA_H

#include "baker/base/box.h"
#include "formats/vxs_file.h"

typedef struct camera_pose {
    double eye_ws[3], target_ws[3];
    double fov_degrees; /* vertical field of view, above 0, below 180 */
    double up_ws[3];    /* up in the picture, of any length, not parallel to the direction to the target; 0,0,0: level with the
                           horizon */
    double near_metres; /* surfaces nearer than this, along the axis, are not seen; 0: all are */
} camera_pose;

/* Move the camera so that all of a box is in view from every point of a circle around its middle, at the eye's height.
 * camera  as from camera_frame_lit; target becomes the middle */
void camera_frame_orbit(camera_pose *camera, const box *b, double aspect);

/* Place a camera so that a box fills its view completely, from above, beside the first sun of the lights, or a default one if there
 * is none.
 * camera  fov_degrees is read; eye and target are written;   lights  [light_count];   aspect  width / height */
void camera_frame_lit(camera_pose *camera, const box *b, const vxs_baked_light *const *lights, uint32_t light_count, double aspect);

/* The view: the unit vector forward, and the vectors from the picture's centre to its edges, at distance 1. */
typedef struct camera_view {
    double forward[3], right[3], up[3];
} camera_view;

/* aspect  width / height;   the camera's eye and target are different */
camera_view camera_view_of(const camera_pose *camera, double aspect);

/* The unit direction through a place of the picture: x from its left edge, 0, to its right one, 1; y from the top down. */
void camera_direction(const camera_view *v, double x, double y, double direction[3]);

#endif
