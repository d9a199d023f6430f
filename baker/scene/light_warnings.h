/* What is probably wrong with lights, said before they are baked.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef LIGHT_WARNINGS_H
#define LIGHT_WARNINGS_H

#include "baker/scene/light_choice.h"

/* Warn when sunlight travels upward.   direction_ws  of any length */
void warn_about_sun(const char *name, const double direction_ws[3], message *m);

/* The same of all suns, and of those of the scene that travel along -Z, as a node does that was never turned. */
void warn_about_suns(const light_choice *chosen, message *m);

/* The same, and about a light that is there twice, and names that differ in case only: each light is held against those before it. */
void warn_about_lights(const light_choice *chosen, message *m);

#endif
