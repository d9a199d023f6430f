/* A sun over smoke_scene.h, places in its smoke, and how much of the sun reaches them, in double: what a map of exact curves would
 * say, four of its texels' rays weighed. So what is off is the curves.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SMOKE_VIEW_H
#define SMOKE_VIEW_H

#include "tests/volumes/smoke_scene.h"

typedef struct smoke_sun {
    vxs_light_constants constants;
    double              axes[3][3], corner[3]; /* across, down, and the way light goes; where the map begins */
    double              nearest, farthest;     /* depths between which all capsules lie, metres */
} smoke_sun;

smoke_sun smoke_sun_over(const vxs_capsule *capsules, uint32_t count);

/* A frame that sees a place in the smoke in each pixel, at random.
 * depths  [out] [width_px * height_px] for the frame's depth texture
 * places  [out] [width_px * height_px][3] as a shader finds them, but for rounding */
vxs_volumes_frame smoke_frame(uint32_t width_px, uint32_t height_px, float *depths, double (*places)[3]);

/* left  [out] [count] of the sun's light, by a map of side_px texels a side.   Ends the program where memory ends. */
void smoke_truth(const smoke_sun *sun, uint32_t side_px, const vxs_capsule *capsules, uint32_t capsule_count,
                 const double (*places)[3], size_t count, double *left);

#endif
