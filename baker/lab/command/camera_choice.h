/* The camera of the options --eye, --target and --fov.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef CAMERA_CHOICE_H
#define CAMERA_CHOICE_H

#include "baker/base/message.h"
#include "baker/lab/truth/camera.h"
#include "formats/vxs_file.h"

typedef struct camera_choice {
    camera_pose camera; /* fov_degrees has its default; camera_place sets eye and target if they are not given */
    int         eye_given, target_given;
} camera_choice;

/* Returns VXS_OK, or VXS_E_ARGUMENT when only one of eye and target is given, or both are the same point. */
vxs_result camera_check(const camera_choice *c, message *m);

/* If no eye is given: place the camera so that all of a box is in view, beside the first sun of the lights (camera_frame_lit).
 * lights  [light_count];   aspect  width / height */
void camera_place(camera_choice *c, const box *around, const vxs_baked_light *const *lights, uint32_t light_count, double aspect);

#endif
