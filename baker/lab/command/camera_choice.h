/* The camera that --eye, --target and --fov ask for.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CAMERA_CHOICE_H
#define CAMERA_CHOICE_H

#include "baker/base/message.h"
#include "baker/lab/truth/camera.h"
#include "formats/vxs_file.h"

typedef struct camera_choice {
    camera_pose camera; /* fov_degrees holds its default; eye and target are written by camera_place when they are not given */
    int         eye_given, target_given;
} camera_choice;

/* Returns VXS_OK, or VXS_E_ARGUMENT when eye or target is missing or both are one point. */
vxs_result camera_check(const camera_choice *c, message *m);

/* Where no eye is given: place the camera so that all of a box is in view, beside the first sun of the lights (camera_frame_lit).
 * lights  [light_count];   aspect  width / height */
void camera_place(camera_choice *c, const box *around, const vxs_baked_light *const *lights, uint32_t light_count, double aspect);

#endif
