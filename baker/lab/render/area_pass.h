/* Light of a scene's area lights in the air and on surfaces, by libvxs_volumes; and they themselves, as they are seen.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef AREA_PASS_H
#define AREA_PASS_H

#include "baker/lab/render/area_plan.h"
#include "baker/lab/render/lamp_pass.h"

typedef struct area_pass_options {
    lamp_pass_options lit;   /* what they light; its scene has area lights, and outlives the pass */
    double            scale; /* what radiance is times, before exposure */
} area_pass_options;

typedef struct area_pass area_pass;

/* pass  [out] NULL on failure.   Returns VXS_OK, VXS_E_GL, VXS_E_MEMORY. */
vxs_result area_pass_create(area_pass **pass, const area_pass_options *o, const gl_context *gl, vxs_volumes *volumes, message *m);

/* Accepts NULL. */
void area_pass_destroy(area_pass *pass);

/* Add airlight to the frame of volumes that has begun, and find what surfaces get.
 * moved_ws  how far what moves has, in metres
 * normals   a texture of them;   exposure  what light is times
 * plan      [out] */
vxs_result area_pass_draw(area_pass *pass, const double eye_ws[3], const camera_view *seen, const double moved_ws[3],
                          double far_metres, unsigned normals, double exposure, area_plan *plan, message *m);

/* Add what surfaces got to the current framebuffer, without exposure. */
void area_pass_add_light(const area_pass *pass);

/* Add the lights themselves to the picture in the current framebuffer, where nothing is before them.
 * clip_from_scene  of places that count from the middle;   depths  of the scene */
void area_pass_add_glow(const area_pass *pass, const float clip_from_scene[16], unsigned depths, const double eye_ws[3],
                        double exposure);

/* [scene->area_count] of the last frame; what lights by them. */
const area_share *area_pass_shares(const area_pass *pass);
const lamp_pass  *area_pass_lamps(const area_pass *pass);

#endif
