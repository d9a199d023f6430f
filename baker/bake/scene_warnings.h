/* What is probably wrong with a scene's size, or with the region of it that is asked for.
 *
 * The bounds are wide, so that no scene in metres is beyond them, however large its terrain or small its only object.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SCENE_WARNINGS_H
#define SCENE_WARNINGS_H

#include "baker/casters/casters.h"
#include "baker/scene/light_choice.h"

/* Warn when a scene is too large or too small for metres: the unit of glTF, which other units are taken for. */
void warn_about_scale(const casters *c, message *m);

/* Warn when no lamp reaches half as far as most components are wide, in a scene of 100 m or more, as of one in centimetres whose lights are
 * in metres. */
void warn_about_ranges(const casters *c, const light_choice *chosen, message *m);

/* Warn when all casters lie in one plane: nothing can be in the shadow of another. */
void warn_about_flat(const casters *c, message *m);

/* Warn of nodes that are named like what is never seen: shapes for collisions, by the rules of engines that read them by their names, and
 * several levels of detail of one thing, one in the other. */
void warn_about_names(const scene *s, message *m);

/* Warn when no caster touches the region: then it is probably in other units, or elsewhere.   region_ws  [6] min xyz, max xyz */
void warn_about_region(const casters *c, const double region_ws[6], message *m);

#endif
