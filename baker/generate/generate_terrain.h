/* The ground that a landscape made, for what stands on it.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef GENERATE_TERRAIN_H
#define GENERATE_TERRAIN_H

#include "baker/generate/generate.h"

/* Height of the surface of a scene that generate_landscape made with these options, and to which more may have been added since.
 * x, z  metres, inside the landscape */
double terrain_height(const glb_scene *s, const landscape_options *o, double x, double z);

#endif
