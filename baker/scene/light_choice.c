/* Which lights a command works on; see light_choice.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/scene/light_choice.h"

#include <fnmatch.h>
#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

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

/* "lamp (spot), moon (directional)" */
static const char *list_lights(const light_choice *lights, char text[LIST_BYTES])
{
    text[0] = '\0';
    for (size_t i = 0; i < lights->count; i++) {
        char item[LIST_BYTES];
        snprintf(item, sizeof item, "%s (%s)", lights->lights[i].name, light_kind_name(lights->lights[i].shape.kind));
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

/* As JSON has to be: what is no UTF-8 is no string there. */
static int is_utf8(const char *text)
{
    json_t *string = json_string(text);
    json_decref(string);
    return string != NULL;
}

/* What there is to choose from: the scene's lights, and the suns, in the place of those that have their names. */
static vxs_result add_all(const scene *s, const named_list *suns, light_choice *all, message *m)
{
    for (size_t i = 0; i < s->light_count; i++)
        if (!named_find(suns, s->lights[i].name)) add(all, (chosen_light){s->lights[i].name, s->lights[i].shape, 0});
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
        add(all, (chosen_light){sun->name, shape, 1});
    }
    return VXS_OK;
}

static vxs_result add_named(const light_choice *all, const char *name, light_choice *chosen, message *m)
{
    const chosen_light *light = find(all, name);
    char                known[LIST_BYTES], meant[64];
    size_t              matched = 0;
    if (find(chosen, name)) return fail(m, VXS_E_ARGUMENT, "--light %s: given twice", name);
    if (light) {
        add(chosen, *light);
        return VXS_OK;
    }
    for (size_t i = 0; i < all->count; i++) {
        if (!light_name_matches(name, i, all->lights[i].name)) continue;
        matched++;
        if (!find(chosen, all->lights[i].name)) add(chosen, all->lights[i]);
    }
    if (matched) return VXS_OK;
    if (!all->count) return fail(m, VXS_E_ARGUMENT, "--light %s: the scene has no lights; --sun X,Y,Z gives one", name);
    return fail(m, VXS_E_ARGUMENT, "--light %s: no such light; there are %s%s", name, list_lights(all, known),
                meant_light(all, name, meant));
}

static vxs_result choose(const light_choice *all, const text_list *names, const named_list *suns, light_choice *chosen, message *m)
{
    for (size_t i = 0; i < names->count; i++) {
        vxs_result r = add_named(all, names->items[i], chosen, m);
        if (r != VXS_OK) return r;
    }
    for (size_t i = all->count - suns->count; i < all->count; i++)
        if (!find(chosen, all->lights[i].name)) add(chosen, all->lights[i]);
    for (size_t i = 0; i < all->count && !names->count && !suns->count; i++) add(chosen, all->lights[i]);
    return chosen->count ? VXS_OK : fail(m, VXS_E_NO_LIGHT, "the scene has no light: --sun X,Y,Z gives one");
}

vxs_result lights_choose(const scene *s, const text_list *names, const named_list *suns, light_choice *chosen, message *m)
{
    size_t       most = names->count + s->light_count + suns->count + 1;
    light_choice all  = {0, calloc(most, sizeof *all.lights)};
    *chosen           = (light_choice){0, calloc(most, sizeof *chosen->lights)};
    vxs_result r      = VXS_OK;
    if (!all.lights || !chosen->lights) r = fail(m, VXS_E_MEMORY, "out of memory for the choice of lights");
    if (r == VXS_OK) r = add_all(s, suns, &all, m);
    if (r == VXS_OK) r = choose(&all, names, suns, chosen, m);
    if (r != VXS_OK) light_choice_free(chosen);
    light_choice_free(&all);
    return r;
}

static vxs_result ask(void *user, const scene *s, message *m)
{
    const light_question *q = user;
    vxs_result            r = lights_choose(s, q->names, q->suns, q->chosen, m);
    return r == VXS_OK ? q->judge(q->chosen, m) : r;
}

scene_check light_question_check(light_question *q)
{
    return (scene_check){ask, q};
}

vxs_result light_choice_require(const light_choice *chosen, const char *option, const named_list *values, message *m)
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
