/* Which lights a command works on: --light NAME and --sun [NAME=]X,Y,Z against the lights of a scene.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef LIGHT_CHOICE_H
#define LIGHT_CHOICE_H

#include "baker/base/text.h"
#include "baker/scene/scene.h"

/* The name of the light that --sun adds without a name. */
#define SUN_NAME "sun"

typedef struct chosen_light {
    const char        *name; /* the scene's, or that of --sun; borrowed */
    light_shape        shape;
    int                is_option; /* nonzero: --sun gives it, not the scene */
    const scene_light *light;     /* the scene's; NULL: --sun gives it */
} chosen_light;

typedef struct light_choice {
    size_t        count;  /* at least 1 on success */
    chosen_light *lights; /* [count] owned; no two have the same name */
} light_choice;

/* 1 when a pattern names a light: by a name with the wildcards of a shell, "lamp*", or by its number from 0, "#3". */
int light_name_matches(const char *pattern, size_t number, const char *name);

/* Choose lights.
 *   neither option         all lights of the scene that shine, in its order; those that do not, or cannot be baked, are warned of
 *   --light NAME ...       those, in the order given, by their names or by those of their nodes; what cannot be baked is an error. Where no light
 *                          and no node has that name, it is a pattern, and stands for all that it names, in the scene's order, but for those that
 *                          are there already
 *   --sun NAME=X,Y,Z ...   suns, each in place of the scene's own light of that name; last, or where --light NAME asks for one
 * names   the values of --light
 * suns    those of --sun, all with a name: the way sunlight travels, of any length but zero
 * chosen  [out] zeroed on failure; released with light_choice_free; borrows names from s and suns
 * Returns VXS_OK, VXS_E_NO_LIGHT (neither option, and no light that shines), VXS_E_ARGUMENT (unknown name, name given twice, a light that
 * cannot be baked, sun of length zero, or whose name is none that a file can hold), VXS_E_MEMORY. */
vxs_result lights_choose(const scene *s, const text_list *names, const named_list *suns, light_choice *chosen, message *m);

/* Warn of lights of the file that cannot be baked, as lights_choose does where all are meant. */
void warn_about_lost_lights(const scene *s, message *m);

/* The same as a question to a scene before a triangle is placed. */
typedef struct light_question {
    const text_list  *names;
    const named_list *suns;
    light_choice     *chosen;                                    /* [out] */
    vxs_result (*judge)(const light_choice *chosen, message *m); /* what a command has to say of them */
} light_question;

/* The check that asks it: for scene_load_gltf_checked, while the question lives. */
scene_check light_question_check(light_question *q);

/* Returns VXS_OK when every name that an option has a value for is that of a chosen light, or VXS_E_ARGUMENT.
 * option  "--resolution" */
vxs_result light_choice_require(const light_choice *chosen, const char *option, const named_list *values, message *m);

/* 1 when a light may have the name: 1 to VXS_LIGHT_NAME_BYTES - 1 bytes of UTF-8. */
int light_name_is_sound(const char *name);

/* Accepts a zeroed object. */
void light_choice_free(light_choice *chosen);

#endif
