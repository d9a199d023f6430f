/* Warnings of probable mistakes in lights; see light_warnings.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/scene/light_warnings.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "baker/base/vec3.h"

/* Tolerance for values that were rounded to float: unit vectors, radians, metres, shares. A sun at the horizon does not count as
 * below it. */
#define ALIKE 1e-4

void warn_about_sun(const char *name, const double direction_ws[3], message *m)
{
    double d[3];
    if (!vec3_unit(direction_ws, d) || d[1] <= ALIKE) return;
    for (int n = 0; n < 3; n++) d[n] = fabs(d[n]) < ALIKE ? 0 : d[n];
    warn(m,
         "light '%s' travels upward, (%.3g, %.3g, %.3g), as from a sun below the horizon: the direction is the way light travels; "
         "turn it round, or give --sun %.3g,%.3g,%.3g",
         name, d[0], d[1], d[2], 0 - d[0], 0 - d[1], 0 - d[2]); /* avoids -0 */
}

/* Warn of a node that was never rotated: its light travels horizontally and only grazes the ground. */
static void warn_about_unturned(const chosen_light *light, message *m)
{
    const double *d = light->shape.direction_ws;
    if (light->is_option || d[2] > -1 + 1e-9 || fabs(d[0]) > 1e-6 || fabs(d[1]) > 1e-6) return;
    warn(m,
         "light '%s' travels level, along -Z, as a node without a rotation has it: sunlight comes from above; turn its node, or "
         "give "
         "--sun X,Y,Z",
         light->name);
}

void warn_about_suns(const light_choice *chosen, message *m)
{
    for (const chosen_light *light = chosen->lights; light < chosen->lights + chosen->count; light++)
        if (light->shape.kind == LIGHT_DIRECTIONAL) {
            warn_about_sun(light->name, light->shape.direction_ws, m);
            warn_about_unturned(light, m);
        }
}

static int near_by(const double a[3], const double b[3])
{
    double between[3];
    vec3_sub(a, b, between);
    return vec3_dot(between, between) <= ALIKE * ALIKE;
}

static int shapes_alike(const light_shape *a, const light_shape *b)
{
    if (a->kind != b->kind) return 0;
    if (a->kind != LIGHT_POINT && !near_by(a->direction_ws, b->direction_ws)) return 0;
    if (a->kind == LIGHT_DIRECTIONAL) return 1;
    if (a->kind == LIGHT_SPOT && fabs(a->outer_rad - b->outer_rad) > ALIKE) return 0;
    int ranges_alike = a->range_m == b->range_m || fabs(a->range_m - b->range_m) <= ALIKE * a->range_m; /* both may be INFINITY */
    return ranges_alike && near_by(a->position_ws, b->position_ws);
}

static int same_but_for_case(const char *a, const char *b)
{
    return !strcasecmp(a, b) && strcmp(a, b) != 0;
}

/* Warn of two equal lights. The advice is to drop the one given on the command line, if any: that is easier. */
static void warn_about_twins(const chosen_light *first, const chosen_light *second, message *m)
{
    const chosen_light *option      = second->is_option ? second : first->is_option ? first : NULL;
    char                remedy[128] = "take one out of the scene, or choose with --light";
    if (option) snprintf(remedy, sizeof remedy, "leave out '%s', which --sun gives", option->name);
    warn(m, "lights '%s' and '%s' are one %s light, there twice: %s", first->name, second->name, light_kind_name(first->shape.kind),
         remedy);
}

/* Warn of the first earlier light with the same shape, and of the first one whose name differs only in case. */
static void warn_about_pairs(const light_choice *chosen, const chosen_light *light, message *m)
{
    const chosen_light *other = chosen->lights;
    while (other < light && !shapes_alike(&other->shape, &light->shape)) other++;
    if (other < light) warn_about_twins(other, light, m);

    other = chosen->lights;
    while (other < light && !same_but_for_case(other->name, light->name)) other++;
    if (other < light)
        warn(m,
             "lights '%s' and '%s' differ in case only, and are easily taken for each other where they are looked up: rename one",
             other->name, light->name);
}

void warn_about_lights(const light_choice *chosen, message *m)
{
    warn_about_suns(chosen, m);
    for (const chosen_light *light = chosen->lights; light < chosen->lights + chosen->count; light++)
        warn_about_pairs(chosen, light, m);
}
