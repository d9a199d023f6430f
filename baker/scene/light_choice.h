/* Which lights a command works on: --light NAME and --sun X,Y,Z against the lights of a scene.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef LIGHT_CHOICE_H
#define LIGHT_CHOICE_H

#include "baker/base/text.h"
#include "baker/scene/scene.h"

/* The name of the light that --sun adds. */
#define SUN_NAME "sun"

typedef struct chosen_light {
    const char *name; /* the scene's, the command line's, or SUN_NAME; borrowed */
    light_shape shape;
} chosen_light;

typedef struct light_choice {
    size_t        count;  /* at least 1 on success */
    chosen_light *lights; /* [count] owned; no two have the same name */
} light_choice;

/* Choose lights.
 *   neither option         all lights of the scene, in its order
 *   --light NAME ...       those, in the order given
 *   --sun X,Y,Z            a light named "sun", in place of the scene's own of that name; last, or where --light sun asks for it
 * names      the values of --light
 * sun_given  nonzero when --sun was given
 * sun        the way sunlight travels, of any length but zero; not looked at unless sun_given
 * chosen     [out] zeroed on failure; released with light_choice_free; borrows names from s and names
 * Returns VXS_OK, VXS_E_NO_LIGHT (neither option, and no light), VXS_E_ARGUMENT (unknown name, name given twice,
 * sun of length zero), VXS_E_MEMORY. */
vxs_result lights_choose(const scene *s, const text_list *names, int sun_given, const double sun[3], light_choice *chosen,
                         message *m);

/* Accepts a zeroed object. */
void light_choice_free(light_choice *chosen);

#endif
