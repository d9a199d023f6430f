/* A picture of a scene in the shadows of baked lights: to look at what was baked.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef PICTURE_H
#define PICTURE_H

#include <stdint.h>

#include "baker/files/output_file.h"
#include "baker/truth/truth.h"
#include "formats/vxs_file.h"

typedef struct picture_camera {
    double eye_ws[3], target_ws[3];
    double fov_degrees; /* from top to bottom, above 0, below 180 */
} picture_camera;

typedef struct picture_options {
    uint32_t       width_px, height_px;
    uint32_t       filter_px; /* of lookups: odd, 1 to VXS_FILTER_MAX */
    uint32_t       threads;
    picture_camera camera; /* eye and target apart, and not in line with the vertical by less than a rounding */
} picture_options;

/* Stand where the casters fill the view, from above, the sun to the side.
 * camera     fov_degrees is read; eye and target are written
 * sun_ws     unit, the way the light travels
 * aspect     width / height */
void picture_frame(picture_camera *camera, const casters *c, const double sun_ws[3], double aspect);

/* What a camera sees: the unit vector forward, and the ways from the picture's middle to its edges, at distance 1. */
typedef struct picture_view {
    double forward[3], right[3], up[3];
} picture_view;

/* aspect  width / height;   the camera's eye and target are apart */
picture_view picture_view_of(const picture_camera *camera, double aspect);

/* The unit direction that is seen at a place of the picture: x from its left edge, 0, to its right one, 1; y from the top down. */
void picture_direction(const picture_view *v, double x, double y, double direction[3]);

/* Render: shadows from the lights' lookups, all else (what is seen, light from the sky) by rays. Where no light is directional it is
 * night, and the light of spot and point lights is seen in the air too.
 * rgb     [out] [3 * width * height] sRGB, top row first.   The same at any thread count.
 * lights  [light_count]
 * Returns VXS_OK or VXS_E_MEMORY. */
vxs_result picture_render(uint8_t *rgb, const picture_options *o, const truth *t, const casters *c,
                          const vxs_baked_light *const *lights, uint32_t light_count, message *m);

/* Encode as PNG. Returns VXS_OK, VXS_E_WRITE, VXS_E_MEMORY. */
vxs_result picture_write_png(output_file *out, const uint8_t *rgb, uint32_t width_px, uint32_t height_px, message *m);

#endif
