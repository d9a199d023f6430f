/* Warnings of probable mistakes in lights, before they are baked.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef LIGHT_WARNINGS_H
#define LIGHT_WARNINGS_H

#include "baker/scene/light_choice.h"

/* Warn when sunlight travels upward.
 * direction_ws  of any length */
void warn_about_sun(const char *name, const double direction_ws[3], message *m);

/* The same for all chosen directional lights. Also warns of scene lights that travel along -Z, the direction of a node that was
 * never rotated. */
void warn_about_suns(const light_choice *chosen, message *m);

/* The same. Also warns of duplicate lights, and of names that differ only in case. Each light is compared with those before it. */
void warn_about_lights(const light_choice *chosen, message *m);

#endif
