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

/* The way light travels that the camera stands beside: a sun's, or one as suns often have it. */
static const double *light_way(const vxs_baked_light *const *lights, uint32_t count)
{
    static const double usual[3] = {-0.43, -0.86, -0.26};
    for (uint32_t n = 0; n < count; n++)
        if (lights[n]->light.kind == VXS_LIGHT_KIND_DIRECTIONAL) return lights[n]->light.direction_ws;
    return usual;
}

void camera_stand(camera_choice *c, const casters *casting, const vxs_baked_light *const *lights, uint32_t light_count,
                  double aspect)
{
    if (!c->eye_given) picture_frame(&c->camera, casting, light_way(lights, light_count), aspect);
}
