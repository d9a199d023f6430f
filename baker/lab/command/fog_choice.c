/* Fog from a command line; see fog_choice.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/command/fog_choice.h"

#include <math.h>

vxs_result fog_check(const fog_choice *c, run_context *m)
{
    const char *alone = c->albedo_given       ? "--fog-albedo"
                        : c->anisotropy_given ? "--fog-anisotropy"
                        : c->top_given        ? "--fog-top"
                        : c->by_given         ? "--fog-by"
                        : c->steps_given      ? "--fog-steps"
                        : c->grid_given       ? "--fog-grid"
                        : c->is_half          ? "--fog-half"
                                              : NULL;
    if (alone && !c->given) return fail(m, VXS_E_ARGUMENT, "%s needs --fog", alone);
    if (c->grid_given && c->by != FOG_BY_GRID) return fail(m, VXS_E_ARGUMENT, "--fog-grid %u needs --fog-by grid", c->grid);
    return VXS_OK;
}

vxs_result fog_check_steps(const fog_choice *c, const char *others, run_context *m)
{
    if (!c->steps_given || c->by == FOG_BY_MARCH || c->by == FOG_BY_ANGLES) return VXS_OK;
    return fail(m, VXS_E_ARGUMENT, "--fog-steps %u needs --fog-by march or angles%s", c->steps, others);
}

fog_medium fog_of(const fog_choice *c)
{
    fog_medium f = {.anisotropy = c->anisotropy, .top_ws = c->top_given ? c->top_metres : INFINITY};
    for (int i = 0; i < 3; i++) {
        f.extinction[i] = c->per_metre;
        f.scattering[i] = c->per_metre * c->albedo;
    }
    return f;
}
