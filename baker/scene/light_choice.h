/* Selection of lights for a command: --light NAME and --sun [NAME=]X,Y,Z, applied to the lights of a scene.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef LIGHT_CHOICE_H
#define LIGHT_CHOICE_H

#include "baker/base/text.h"
#include "baker/scene/scene.h"

/* Name of a light that --sun adds without a name. */
#define SUN_NAME "sun"

typedef struct chosen_light {
    const char        *name; /* from the scene or from --sun; borrowed */
    light_shape        shape;
    int                is_option; /* nonzero: given by --sun */
    const scene_light *light;     /* the scene's light; NULL: given by --sun */
} chosen_light;

typedef struct light_choice {
    size_t        count;  /* at least 1 on success */
    chosen_light *lights; /* [count] owned; names are unique */
} light_choice;

/* 1 when a pattern matches a light: a name with shell wildcards, "lamp*", or its number from 0, "#3". */
int light_name_matches(const char *pattern, size_t number, const char *name);

/* Choose lights.
 *   neither option         all lights of the scene that emit light, in its order; a warning lists the dark ones and those that
 *                          cannot be baked
 *   --light NAME ...       those, in the given order, by their name or their node's name; a light that cannot be baked is an error.
 *                          If no light or node has the name, it is a pattern for all matching lights that are not chosen yet, in
 *                          the scene's order
 *   --sun NAME=X,Y,Z ...   directional lights; each replaces the scene's light of that name. They come last, or at the place where
 *                          --light names them
 * names   values of --light
 * suns    values of --sun, all with names: the direction in which sunlight travels, of any nonzero length
 * chosen  [out] zeroed on failure; released with light_choice_free; borrows names from s and suns
 * Returns VXS_OK; VXS_E_NO_LIGHT (neither option, and no light that emits light); VXS_E_ARGUMENT (unknown name, name given twice, a
 * light that cannot be baked, a sun of length zero or with a name that the format cannot store); VXS_E_MEMORY. */
vxs_result lights_choose(const scene *s, const text_list *names, const named_list *suns, light_choice *chosen, run_context *m);

/* Warn of lights of the file that cannot be baked, as lights_choose does without options. */
void warn_about_lost_lights(const scene *s, run_context *m);

/* The same selection, made by a scene_check before triangles are placed. */
typedef struct light_question {
    const text_list  *names;
    const named_list *suns;
    light_choice     *chosen;                                        /* [out] */
    vxs_result (*judge)(const light_choice *chosen, run_context *m); /* the command's own check of the chosen lights */
} light_question;

/* A check for scene_load_gltf_checked. Valid while the question exists. */
scene_check light_question_check(light_question *q);

/* Check that each name in the values of an option is the name of a chosen light. Returns VXS_OK or VXS_E_ARGUMENT.
 * option  for messages: "--resolution" */
vxs_result light_choice_require(const light_choice *chosen, const char *option, const named_list *values, run_context *m);

/* 1 when a name is valid for a light: 1 to VXS_LIGHT_NAME_BYTES - 1 bytes of UTF-8. */
int light_name_is_sound(const char *name);

/* Accepts a zeroed object. */
void light_choice_free(light_choice *chosen);

/* Warnings of probable mistakes in lights, before they are baked. */

/* Warn when sunlight travels upward.
 * direction_ws  of any length */
void warn_about_sun(const char *name, const double direction_ws[3], run_context *m);

/* The same for all chosen directional lights. Also warns of scene lights that travel along -Z, the direction of a node that was
 * never rotated. */
void warn_about_suns(const light_choice *chosen, run_context *m);

/* The same. Also warns of duplicate lights, and of names that differ only in case. Each light is compared with those before it. */
void warn_about_lights(const light_choice *chosen, run_context *m);

#endif
