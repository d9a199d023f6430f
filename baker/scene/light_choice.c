/* Selection of lights; see light_choice.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/scene/light_choice.h"

#include <fnmatch.h>
#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "baker/base/nearest.h"
#include "baker/base/vec3.h"
#include "formats/vxs_format.h"

static void add(light_choice *chosen, chosen_light light)
{
    chosen->lights[chosen->count++] = light;
}

int light_name_matches(const char *pattern, size_t number, const char *name)
{
    char by_number[24];
    snprintf(by_number, sizeof by_number, "#%zu", number);
    return !strcmp(pattern, by_number) || !fnmatch(pattern, name, 0);
}

static const chosen_light *find(const light_choice *lights, const char *name)
{
    for (size_t i = 0; i < lights->count; i++)
        if (!strcmp(lights->lights[i].name, name)) return &lights->lights[i];
    return NULL;
}

/* " (node 3 'Lamp')": the node of a light; "" for a light without a file. The node's name is left out if it equals the light's
 * name. */
static const char *node_text(char text[128], const char *light_name, uint32_t node, const char *node_name)
{
    char shown[65];
    int  named = node_name && node_name[0] && strcmp(node_name, light_name) != 0;
    text[0]    = '\0';
    if (named)
        snprintf(text, 128, "node %u '%s'", node, shorten(shown, sizeof shown - 1, node_name));
    else if (node_name)
        snprintf(text, 128, "node %u", node);
    return text;
}

/* "lamp (spot, node 3 'Kitchen'), noon (directional)" */
static const char *list_lights(const light_choice *lights, char text[LIST_BYTES])
{
    text[0] = '\0';
    for (size_t i = 0; i < lights->count; i++) {
        const chosen_light *l = &lights->lights[i];
        char                item[LIST_BYTES], node[128] = "";
        if (l->light) node_text(node, l->name, l->light->node, l->light->node_name);
        snprintf(item, sizeof item, "%s (%s%s%s)", l->name, light_kind_name(l->shape.kind), node[0] ? ", " : "", node);
        list_item(text, item);
    }
    return text;
}

static const char *meant_light(const light_choice *lights, const char *name, char text[64])
{
    nearest near = {.typed = name};
    for (size_t i = 0; i < lights->count; i++) nearest_try(&near, lights->lights[i].name, strlen(lights->lights[i].name));
    return nearest_text(text, &near);
}

/* JSON strings must be UTF-8. */
static int is_utf8(const char *text)
{
    json_t *string = json_string(text);
    json_decref(string);
    return string != NULL;
}

/* All candidates: the scene's lights, and the suns, which replace lights of the same name. */
static vxs_result add_all(const scene *s, const named_list *suns, light_choice *all, run_context *m)
{
    for (size_t i = 0; i < s->light_count; i++)
        if (!named_find(suns, s->lights[i].name)) add(all, (chosen_light){s->lights[i].name, s->lights[i].shape, 0, &s->lights[i]});
    for (const named_value *sun = suns->items; sun < suns->items + suns->count; sun++) {
        light_shape   shape  = {.kind = LIGHT_DIRECTIONAL};
        const double *v      = sun->numbers;
        size_t        length = strlen(sun->name);
        if (!vec3_unit(v, shape.direction_ws))
            return fail(m, VXS_E_ARGUMENT, "--sun %s=%g,%g,%g: expected a direction, not zero", sun->name, v[0], v[1], v[2]);
        if (length >= VXS_LIGHT_NAME_BYTES)
            return fail(m, VXS_E_ARGUMENT, "--sun %s: the name has %zu bytes, expected 1 to %d", sun->name, length,
                        VXS_LIGHT_NAME_BYTES - 1);
        if (!is_utf8(sun->name)) return fail(m, VXS_E_ARGUMENT, "--sun %s: expected a name in UTF-8", sun->name);
        add(all, (chosen_light){sun->name, shape, 1, NULL});
    }
    return VXS_OK;
}

static vxs_result fail_if_lost(const scene *s, const char *name, run_context *m)
{
    for (const lost_light *l = s->lost_lights; l < s->lost_lights + s->lost_light_count; l++) {
        char node[128];
        if (strcmp(l->name, name) != 0 && strcmp(l->node_name, name) != 0) continue;
        node_text(node, l->name, l->node, l->node_name);
        if (l->why) return fail(m, VXS_E_ARGUMENT, "--light %s: the light of %s cannot be baked: %s", name, node, l->why);
        return fail(m, VXS_E_ARGUMENT,
                    "--light %s: the light of %s is hidden (KHR_node_visibility); make its node visible in the scene", name, node);
    }
    return VXS_OK;
}

static vxs_result add_named(const scene *s, const light_choice *all, const char *name, light_choice *chosen, run_context *m)
{
    size_t              count = 0;
    const chosen_light *light = find(all, name);
    char                known[LIST_BYTES], meant[64];
    size_t              matched = 0;
    vxs_result          r;
    if (!light && (r = fail_if_lost(s, name, m)) != VXS_OK) return r;
    if (!light) {
        /* Find a light by the name of its node.
         * count  [out] number of matches */
        const chosen_light *found = NULL;
        count                     = 0;
        for (const chosen_light *l = all->lights; l < all->lights + all->count; l++) {
            if (!l->light || !l->light->node_name || strcmp(l->light->node_name, name) != 0) continue;
            found = l;
            ++count;
        }
        light = found;
    }
    if (count > 1)
        return fail(m, VXS_E_ARGUMENT, "--light %s: %zu nodes of that name have lights; there are %s", name, count,
                    list_lights(all, known));
    if (light && find(chosen, light->name)) return fail(m, VXS_E_ARGUMENT, "--light %s: given twice", name);
    if (light) {
        add(chosen, *light);
        return VXS_OK;
    }
    for (size_t i = 0; i < all->count; i++) {
        const chosen_light *l = &all->lights[i];
        if (!light_name_matches(name, i, l->name) &&
            !(l->light && l->light->node_name && light_name_matches(name, i, l->light->node_name)))
            continue;
        matched++;
        if (!find(chosen, all->lights[i].name)) add(chosen, all->lights[i]);
    }
    if (matched) return VXS_OK;
    if (!all->count) return fail(m, VXS_E_ARGUMENT, "--light %s: the scene has no lights; --sun X,Y,Z gives one", name);
    return fail(m, VXS_E_ARGUMENT, "--light %s: no such light; there are %s%s", name, list_lights(all, known),
                meant_light(all, name, meant));
}

/* ---- lights that are left out by default ---- */

enum { SHOWN = 3 };

static int is_dark(const scene_light *l)
{
    return l && l->dark;
}

void warn_about_lost_lights(const scene *s, run_context *m)
{
    size_t lost = 0;
    for (const lost_light *l = s->lost_lights; l < s->lost_lights + s->lost_light_count; l++) {
        char node[128];
        if (l->why && ++lost <= SHOWN)
            warn(m, "light '%s' (%s) is left out: %s", l->name, node_text(node, l->name, l->node, l->node_name), l->why);
    }
    if (lost > SHOWN) warn(m, "%zu more lights are left out for such faults; see to those above, and run again", lost - SHOWN);
}

static vxs_result fail_without_light(const scene *s, run_context *m)
{
    const lost_light *first = s->lost_lights;
    while (first < s->lost_lights + s->lost_light_count && !first->why) first++;
    if (first < s->lost_lights + s->lost_light_count)
        return fail(m, VXS_E_NO_LIGHT, "the scene has no light that can be baked; '%s': %s; --sun X,Y,Z gives one", first->name,
                    first->why);
    if (s->light_count)
        return fail(m, VXS_E_NO_LIGHT, "the scene has no light that shines; '%s': %s; --sun X,Y,Z gives one", s->lights[0].name,
                    s->lights[0].dark);
    if (s->lost_light_count)
        return fail(m, VXS_E_NO_LIGHT, "all lights of the scene are hidden (KHR_node_visibility): --sun X,Y,Z gives one");
    return fail(m, VXS_E_NO_LIGHT, "the scene has no light%s: --sun X,Y,Z gives one",
                s->emissive_count ? ", and materials that shine are none" : "");
}

static vxs_result choose(const scene *s, const light_choice *all, const text_list *names, const named_list *suns,
                         light_choice *chosen, run_context *m)
{
    int by_name = names->count || suns->count;
    for (size_t i = 0; i < names->count; i++) {
        vxs_result r = add_named(s, all, names->items[i], chosen, m);
        if (r != VXS_OK) return r;
    }
    for (size_t i = all->count - suns->count; i < all->count; i++)
        if (!find(chosen, all->lights[i].name)) add(chosen, all->lights[i]);
    for (size_t i = 0; i < all->count && !by_name; i++)
        if (!is_dark(all->lights[i].light)) add(chosen, all->lights[i]);
    if (!chosen->count) return fail_without_light(s, m);
    if (!by_name) warn_about_lost_lights(s, m);
    if (!by_name) {
        size_t dark = 0;
        for (const scene_light *l = s->lights; l < s->lights + s->light_count; l++) {
            char node[128];
            if (is_dark(l) && ++dark <= SHOWN)
                warn(m, "light '%s' (%s) is left out: %s; set it in the scene, or --light bakes it all the same", l->name,
                     node_text(node, l->name, l->node, l->node_name), l->dark);
        }
        if (dark > SHOWN)
            warn(m, "%zu more lights are left out because they are dark; set their intensities, or name them with --light",
                 dark - SHOWN);
    }

    /* Warn of chosen lights with properties that are not used as given. */
    size_t odd = 0;
    for (const chosen_light *l = chosen->lights; l < chosen->lights + chosen->count; l++) {
        char node[128];
        if (!l->light || (!l->light->odd && !l->light->dark) || ++odd > SHOWN) continue;
        node_text(node, l->name, l->light->node, l->light->node_name);
        if (l->light->odd) warn(m, "light '%s' (%s): %s", l->name, node, l->light->odd);
        if (l->light->dark)
            warn(m, "light '%s' (%s): %s, and pictures do not show it; set it in the scene", l->name, node, l->light->dark);
    }
    if (odd > SHOWN) warn(m, "%zu more lights like that; see to those above, and run again", odd - SHOWN);

    return VXS_OK;
}

vxs_result lights_choose(const scene *s, const text_list *names, const named_list *suns, light_choice *chosen, run_context *m)
{
    size_t       most = names->count + s->light_count + suns->count + 1;
    light_choice all  = {0, calloc(most, sizeof *all.lights)};
    *chosen           = (light_choice){0, calloc(most, sizeof *chosen->lights)};
    vxs_result r      = VXS_OK;
    if (!all.lights || !chosen->lights) r = fail(m, VXS_E_MEMORY, "out of memory for the choice of lights");
    if (r == VXS_OK) r = add_all(s, suns, &all, m);
    if (r == VXS_OK) r = choose(s, &all, names, suns, chosen, m);
    if (r != VXS_OK) light_choice_free(chosen);
    light_choice_free(&all);
    return r;
}

static vxs_result ask(void *user, const scene *s, run_context *m)
{
    const light_question *q = user;
    vxs_result            r = lights_choose(s, q->names, q->suns, q->chosen, m);
    return r == VXS_OK ? q->judge(q->chosen, m) : r;
}

scene_check light_question_check(light_question *q)
{
    return (scene_check){ask, q};
}

vxs_result light_choice_require(const light_choice *chosen, const char *option, const named_list *values, run_context *m)
{
    char known[LIST_BYTES], meant[64];
    for (const named_value *v = values->items; v < values->items + values->count; v++)
        if (v->name && !find(chosen, v->name))
            return fail(m, VXS_E_ARGUMENT, "%s %s=%.10g: no light of that name is baked, but %s%s", option, v->name, v->numbers[0],
                        list_lights(chosen, known), meant_light(chosen, v->name, meant));
    return VXS_OK;
}

int light_name_is_sound(const char *name)
{
    return name[0] && strlen(name) < VXS_LIGHT_NAME_BYTES && is_utf8(name);
}

void light_choice_free(light_choice *chosen)
{
    free(chosen->lights);
    *chosen = (light_choice){0};
}

/* Tolerance for values that were rounded to float: unit vectors, radians, metres, shares. A sun at the horizon does not count as
 * below it. */
#define ALIKE 1e-4

void warn_about_sun(const char *name, const double direction_ws[3], run_context *m)
{
    double d[3];
    if (!vec3_unit(direction_ws, d) || d[1] <= ALIKE) return;
    for (int n = 0; n < 3; n++) d[n] = fabs(d[n]) < ALIKE ? 0 : d[n];
    warn(m,
         "light '%s' travels upward, (%.3g, %.3g, %.3g), as from a sun below the horizon: the direction is the way light travels; "
         "turn it round, or give --sun %.3g,%.3g,%.3g",
         name, d[0], d[1], d[2], 0 - d[0], 0 - d[1], 0 - d[2]); /* avoids -0 */
}

void warn_about_suns(const light_choice *chosen, run_context *m)
{
    for (const chosen_light *light = chosen->lights; light < chosen->lights + chosen->count; light++)
        if (light->shape.kind == LIGHT_DIRECTIONAL) {
            warn_about_sun(light->name, light->shape.direction_ws, m);
            /* a node that was never rotated: its light travels horizontally and only grazes the ground */
            const double *d = light->shape.direction_ws;
            if (light->is_option || d[2] > -1 + 1e-9 || fabs(d[0]) > 1e-6 || fabs(d[1]) > 1e-6) continue;
            warn(m,
                 "light '%s' travels level, along -Z, as a node without a rotation has it: sunlight comes from above; turn its "
                 "node, or give --sun X,Y,Z",
                 light->name);
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
    int ranges_alike = a->range_metres == b->range_metres ||
                       fabs(a->range_metres - b->range_metres) <= ALIKE * a->range_metres; /* both may be INFINITY */
    return ranges_alike && near_by(a->position_ws, b->position_ws);
}

static int same_but_for_case(const char *a, const char *b)
{
    return !strcasecmp(a, b) && strcmp(a, b) != 0;
}

void warn_about_lights(const light_choice *chosen, run_context *m)
{
    warn_about_suns(chosen, m);
    for (const chosen_light *light = chosen->lights; light < chosen->lights + chosen->count; light++) {
        /* Warn of the first earlier light with the same shape, and of the first one whose name differs only in case. */
        const chosen_light *other = chosen->lights;
        while (other < light && !shapes_alike(&other->shape, &light->shape)) other++;
        if (other < light) {
            /* Warn of two equal lights. The advice is to drop the one given on the command line, if any: that is easier. */
            const chosen_light *option      = light->is_option ? light : other->is_option ? other : NULL;
            char                remedy[128] = "take one out of the scene, or choose with --light";
            if (option) snprintf(remedy, sizeof remedy, "leave out '%s', which --sun gives", option->name);
            warn(m, "lights '%s' and '%s' are one %s light, there twice: %s", other->name, light->name,
                 light_kind_name(other->shape.kind), remedy);
        }

        other = chosen->lights;
        while (other < light && !same_but_for_case(other->name, light->name)) other++;
        if (other < light)
            warn(m,
                 "lights '%s' and '%s' differ in case only, and are easily taken for each other where they are looked up: rename "
                 "one",
                 other->name, light->name);
    }
}
