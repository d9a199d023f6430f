/* The camera of a command line; see camera_choice.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/options/camera_choice.h"

#include <string.h>

vxs_result camera_check(const camera_choice *c, message *m)
{
    if (c->eye_given != c->target_given)
        return fail(m, VXS_E_ARGUMENT, "--eye and --target go together: %s is missing", c->eye_given ? "--target" : "--eye");
    if (c->eye_given && !memcmp(c->camera.eye_ws, c->camera.target_ws, sizeof c->camera.eye_ws))
        return fail(m, VXS_E_ARGUMENT, "--eye and --target are the same point: expected two");
    return VXS_OK;
}

/* The direction of light that the camera is placed beside: that of the first sun, or a usual one. */
static const double *light_direction(const vxs_baked_light *const *lights, uint32_t count)
{
    static const double usual[3] = {-0.43, -0.86, -0.26};
    for (uint32_t n = 0; n < count; n++)
        if (lights[n]->light.kind == VXS_LIGHT_KIND_DIRECTIONAL) return lights[n]->light.direction_ws;
    return usual;
}

void camera_place(camera_choice *c, const casters *casting, const vxs_baked_light *const *lights, uint32_t light_count,
                  double aspect)
{
    if (!c->eye_given) camera_frame(&c->camera, casting, light_direction(lights, light_count), aspect);
}
