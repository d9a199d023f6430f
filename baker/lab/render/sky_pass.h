/* Light of a sky map in the air and on surfaces, by distant virtual lights; and the map itself, where there is no surface.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SKY_PASS_H
#define SKY_PASS_H

#include "baker/lab/render/lamp_pass.h"
#include "baker/lab/render/sky_map.h"
#include "runtime/gl/vxs_gl.h"

typedef struct sky_pass_options {
    lamp_pass_options lit;           /* the receivers */
    double            radius_metres; /* of a sphere around the middle that contains all static casters */
    const sky_map    *map;           /* it outlives the pass */
    double            scale;         /* factor on the map's radiance, before exposure */
    double            turn_rad;      /* of the map about +Y, from +Z towards +X */
} sky_pass_options;

typedef struct sky_pass sky_pass;

/* pass  [out] NULL on failure.   Returns VXS_OK, VXS_E_GL, VXS_E_MEMORY. */
vxs_result sky_pass_create(sky_pass **pass, const sky_pass_options *o, const gl_context *gl, vxs_volumes *volumes, message *m);

/* Accepts NULL. */
void sky_pass_destroy(sky_pass *pass);

/* Add airlight to the volumes' current frame, and compute the light on surfaces.
 * moved_ws  offset of moving casters, metres
 * normals   a texture of surfaces' normals;   exposure  factor on light */
vxs_result sky_pass_draw(sky_pass *pass, const double eye_ws[3], const double moved_ws[3], unsigned normals, double exposure,
                         message *m);

/* Add the light on surfaces to the current framebuffer, without exposure. */
void sky_pass_add_light(const sky_pass *pass);

/* Draw the map into the current framebuffer, where there is no surface.   depths  of the scene */
void sky_pass_add_map(const sky_pass *pass, const vxs_view *view, unsigned depths, double exposure);

/* The mean of the map over all directions, exposed.   rgb  [out] */
void sky_pass_mean(const sky_pass *pass, double exposure, double rgb[3]);

/* Its pass of virtual lights. */
const lamp_pass *sky_pass_lamps(const sky_pass *pass);

#endif
