/* Fog; see fog_pass.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/render/fog_pass.h"

#include <math.h>
#include <stdlib.h>

#include "runtime/volumes/vxs_volumes.h"

struct fog_pass {
    fog_pass_options options;
    vxs_gl          *shadows;
    vxs_volumes     *volumes;
};

static vxs_gl_function lookup(const char *name, void *user)
{
    return (vxs_gl_function)((const gl_context *)user)->lookup(name);
}

vxs_result fog_pass_create(fog_pass **out, const fog_pass_options *o, const gl_context *gl, vxs_gl *shadows, message *m)
{
    vxs_volumes_desc desc = {.struct_size      = sizeof desc,
                             .get_proc_address = lookup,
                             .user             = (void *)(uintptr_t)gl,
                             .shadows          = shadows,
                             .width_px         = o->width,
                             .height_px        = o->height};
    fog_pass        *p    = calloc(1, sizeof *p);
    *out                  = NULL;
    if (!p) return fail(m, VXS_E_MEMORY, "out of memory for fog");
    p->options        = *o;
    p->shadows        = shadows;
    vxs_result result = vxs_volumes_create(&p->volumes, &desc);
    if (result == VXS_OK) {
        *out = p;
        return VXS_OK;
    }
    free(p);
    return fail(m, result, "OpenGL cannot draw fog of %u x %u samples: %s", o->width, o->height, vxs_result_text(result));
}

void fog_pass_destroy(fog_pass *p)
{
    if (!p) return;
    vxs_volumes_destroy(p->volumes);
    free(p);
}

/* Rays that meet nothing end where nothing of the scene is any more. Fog lies below the eye's own height by so much. */
static vxs_volumes_frame frame_of(const fog_pass *p, const vxs_view *view, unsigned depths, const double eye_ws[3],
                                  const double ambient[3])
{
    const fog_medium *medium = p->options.medium;
    vxs_volumes_frame f      = {.anisotropy    = (float)medium->anisotropy,
                                .top_metres    = (float)fmin(medium->top_ws - eye_ws[1], 1e30),
                                .view          = *view,
                                .far_metres    = (float)(2 * p->options.size_metres),
                                .depth_texture = depths};
    for (int n = 0; n < 3; n++) {
        f.scattering[n] = (float)medium->scattering[n];
        f.extinction[n] = (float)medium->extinction[n];
        f.ambient[n]    = (float)ambient[n];
    }
    return f;
}

static vxs_result add_light(fog_pass *p, uint32_t n, const fog_shine *shine, double exposure)
{
    const double      radius = 5e-4 * p->options.size_metres; /* airlight has no bound where a ray meets a point */
    vxs_volumes_light light  = {.baked = n, .cos_inner = (float)shine->cos_inner, .radius_metres = (float)radius};
    for (int k = 0; k < 3; k++) light.colour[k] = (float)(exposure * shine->colour[k]);
    if (p->options.by == FOG_BY_INTERVALS) return vxs_volumes_intervals(p->volumes, &light);
    return vxs_volumes_march(p->volumes, &light, NULL, p->options.steps,
                             p->options.by == FOG_BY_MARCH ? VXS_STEPS_EVEN : VXS_STEPS_ANGLE);
}

vxs_result fog_pass_draw(fog_pass *p, const vxs_view *view, unsigned depths, const double eye_ws[3], const fog_shine *shines,
                         double exposure, const double ambient[3], message *m)
{
    vxs_volumes_frame frame  = frame_of(p, view, depths, eye_ws, ambient);
    vxs_result        result = vxs_volumes_begin(p->volumes, &frame);
    for (uint32_t n = 0; n < vxs_gl_light_count(p->shadows) && result == VXS_OK; n++)
        result = add_light(p, n, &shines[n], exposure);
    if (result != VXS_OK) return fail(m, result, "fog cannot be drawn: %s", vxs_result_text(result));
    vxs_volumes_composite(p->volumes);
    return VXS_OK;
}

unsigned fog_pass_airlight(const fog_pass *p)
{
    return vxs_volumes_airlight(p->volumes);
}
