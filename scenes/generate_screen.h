/* An emissive screen.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef GENERATE_SCREEN_H
#define GENERATE_SCREEN_H

#include "scenes/generate_parts.h"

/* A flat box on a wall that faces -X, in front of `wall_x`; in front of it a picture of a low sun, two triangles of an emissive
 * material.
 * middle  of the screen, metres: y, z */
void generate_screen(parts *p, double wall_x, const double middle[2]);

#endif
