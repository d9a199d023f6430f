/* Light of a map of the sky in the air and on surfaces, by virtual lights that are far away; and the map itself, where nothing
 * is before it.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SKY_PASS_H
#define SKY_PASS_H

#include "baker/lab/render/lamp_pass.h"
#include "baker/lab/render/sky_map.h"
#include "runtime/gl/vxs_gl.h"

typedef struct sky_pass_options {
    lamp_pass_options lit;           /* what it lights */
    double            radius_metres; /* of a sphere about the middle, that holds all that stands */
    const sky_map    *map;           /* it outlives the pass */
    double            scale;         /* what the map's radiance is times, before exposure */
    double            turn_rad;      /* of the map about +Y, from +Z towards +X */
} sky_pass_options;

typedef struct sky_pass sky_pass;

/* pass  [out] NULL on failure.   Returns VXS_OK, VXS_E_GL, VXS_E_MEMORY. */
vxs_result sky_pass_create(sky_pass **pass, const sky_pass_options *o, const gl_context *gl, vxs_volumes *volumes, message *m);

/* Accepts NULL. */
void sky_pass_destroy(sky_pass *pass);

/* Add airlight to the frame of volumes that has begun, and find what surfaces get.
 * moved_ws  how far what moves has, in metres
 * normals   a texture of them;   exposure  what light is times */
vxs_result sky_pass_draw(sky_pass *pass, const double eye_ws[3], const double moved_ws[3], unsigned normals, double exposure,
                         message *m);

/* Add what surfaces got to the current framebuffer, without exposure. */
void sky_pass_add_light(const sky_pass *pass);

/* Add the map to the picture in the current framebuffer, where there is nothing.   depths  of the scene */
void sky_pass_add_map(const sky_pass *pass, const vxs_view *view, unsigned depths, double exposure);

/* The mean of the map over all directions, as exposed.   rgb  [out] */
void sky_pass_mean(const sky_pass *pass, double exposure, double rgb[3]);

/* What lights by it. */
const lamp_pass *sky_pass_lamps(const sky_pass *pass);

#endif
