/* Warnings about a scene's scale, or about the requested region.
 *
 * The limits are wide: no scene in metres exceeds them, however large its terrain or small its only object.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SCENE_WARNINGS_H
#define SCENE_WARNINGS_H

#include "baker/casters/casters.h"
#include "baker/scene/light_choice.h"

/* Warn if a scene is too large or too small for metres, the unit of glTF. Its numbers are then probably in another unit. */
void warn_about_scale(const casters *c, run_context *m);

/* Warn if no punctual light reaches half the width of most components, in a scene of 100 m or more. Such a scene is probably in
 * centimetres, with light ranges in metres. */
void warn_about_ranges(const casters *c, const light_choice *chosen, run_context *m);

/* Warn if all casters lie in one plane: no object can shadow another. */
void warn_about_flat(const casters *c, run_context *m);

/* Warn of nodes with names of invisible things: collision shapes, by the naming rules of engines, and several levels of detail of
 * one object that overlap. */
void warn_about_names(const scene *s, run_context *m);

/* Warn if no caster touches the region: it is probably in other units, or elsewhere.   region_ws  [6] min xyz, max xyz */
void warn_about_region(const casters *c, const double region_ws[6], run_context *m);

#endif
