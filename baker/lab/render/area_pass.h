/* Light of a scene's area lights in the air and on surfaces, by libvxs_volumes; and they themselves, as they are seen.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef AREA_PASS_H
#define AREA_PASS_H

#include "baker/lab/render/area_plan.h"
#include "baker/lab/render/lamp_pass.h"

typedef struct area_pass_options {
    lamp_pass_options lit;   /* the receivers; its scene has area lights, and outlives the pass */
    double            scale; /* factor on radiance, before exposure */
} area_pass_options;

typedef struct area_pass area_pass;

/* pass  [out] NULL on failure.   Returns VXS_OK, VXS_E_GL, VXS_E_MEMORY. */
vxs_result area_pass_create(area_pass **pass, const area_pass_options *o, const gl_context *gl, vxs_volumes *volumes, message *m);

/* Accepts NULL. */
void area_pass_destroy(area_pass *pass);

/* Add airlight to the volumes' current frame, and compute the light on surfaces.
 * moved_ws  offset of moving casters, metres
 * normals   a texture of surfaces' normals;   exposure  factor on light
 * plan      [out] */
vxs_result area_pass_draw(area_pass *pass, const double eye_ws[3], const camera_view *seen, const double moved_ws[3],
                          double far_metres, unsigned normals, double exposure, area_plan *plan, message *m);

/* Add the light on surfaces to the current framebuffer, without exposure. */
void area_pass_add_light(const area_pass *pass);

/* Draw the area lights themselves into the current framebuffer, where no surface is in front of them.
 * clip_from_scene  for positions relative to the scene's middle;   depths  of the scene */
void area_pass_add_glow(const area_pass *pass, const float clip_from_scene[16], unsigned depths, const double eye_ws[3],
                        double exposure);

/* [scene->area_count] of the last frame. area_pass_lamps: its pass of virtual lights. */
const area_share *area_pass_shares(const area_pass *pass);
const lamp_pass  *area_pass_lamps(const area_pass *pass);

#endif
