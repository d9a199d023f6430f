/* The camera of a command line; see camera_choice.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/command/camera_choice.h"

#include <string.h>

vxs_result camera_check(const camera_choice *c, message *m)
{
    if (c->eye_given != c->target_given)
        return fail(m, VXS_E_ARGUMENT, "--eye and --target go together: %s is missing", c->eye_given ? "--target" : "--eye");
    if (c->eye_given && !memcmp(c->camera.eye_ws, c->camera.target_ws, sizeof c->camera.eye_ws))
        return fail(m, VXS_E_ARGUMENT, "--eye and --target are the same point: expected two");
    return VXS_OK;
}

void camera_place(camera_choice *c, const box *around, const vxs_baked_light *const *lights, uint32_t light_count, double aspect)
{
    if (!c->eye_given) camera_frame_lit(&c->camera, around, lights, light_count, aspect);
}
