/* Which lights a command works on; see light_choice.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/scene/light_choice.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "baker/base/vec3.h"

static void add(light_choice *chosen, const char *name, const light_shape *shape)
{
    chosen->lights[chosen->count++] = (chosen_light){name, *shape};
}

static int has(const light_choice *chosen, const char *name)
{
    for (size_t i = 0; i < chosen->count; i++)
        if (!strcmp(chosen->lights[i].name, name)) return 1;
    return 0;
}

/* "lamp (spot), moon (directional)", cut short where it would fill the message. */
static void list_lights(const scene *s, char *text, size_t size)
{
    size_t used = 0;
    text[0]     = '\0';
    for (size_t i = 0; i < s->light_count && used < size; i++)
        used += (size_t)snprintf(text + used, size - used, "%s%s (%s)", i ? ", " : "", s->lights[i].name,
                                 light_kind_name(s->lights[i].shape.kind));
    if (used >= size) memcpy(text + size - sizeof "...", "...", sizeof "...");
}

static vxs_result add_named(const scene *s, const char *name, const light_shape *sun, light_choice *chosen, message *m)
{
    if (has(chosen, name)) return fail(m, VXS_E_ARGUMENT, "--light %s: given twice", name);
    if (sun && !strcmp(name, SUN_NAME)) {
        add(chosen, SUN_NAME, sun);
        return VXS_OK;
    }
    for (size_t i = 0; i < s->light_count; i++) {
        const scene_light *light = &s->lights[i];
        if (strcmp(light->name, name) != 0) continue;
        add(chosen, light->name, &light->shape);
        return VXS_OK;
    }
    if (!s->light_count) return fail(m, VXS_E_ARGUMENT, "--light %s: the scene has no lights; --sun X,Y,Z gives one", name);
    char known[512];
    list_lights(s, known, sizeof known);
    return fail(m, VXS_E_ARGUMENT, "--light %s: no such light; the scene has %s", name, known);
}

static vxs_result choose(const scene *s, const text_list *names, const light_shape *sun, light_choice *chosen, message *m)
{
    for (size_t i = 0; i < names->count; i++) {
        vxs_result r = add_named(s, names->items[i], sun, chosen, m);
        if (r != VXS_OK) return r;
    }
    if (sun && !has(chosen, SUN_NAME)) add(chosen, SUN_NAME, sun);
    if (chosen->count) return VXS_OK;

    for (size_t i = 0; i < s->light_count; i++) add(chosen, s->lights[i].name, &s->lights[i].shape);
    return chosen->count ? VXS_OK : fail(m, VXS_E_NO_LIGHT, "the scene has no light: --sun X,Y,Z gives one");
}

vxs_result lights_choose(const scene *s, const text_list *names, int sun_given, const double sun[3], light_choice *chosen,
                         message *m)
{
    *chosen               = (light_choice){0};
    light_shape sun_shape = {.kind = LIGHT_DIRECTIONAL};
    if (sun_given && !vec3_unit(sun, sun_shape.direction_ws))
        return fail(m, VXS_E_ARGUMENT, "--sun %g,%g,%g: expected a direction, not zero", sun[0], sun[1], sun[2]);

    chosen->lights = calloc(names->count + s->light_count + 1, sizeof *chosen->lights);
    if (!chosen->lights) return fail(m, VXS_E_MEMORY, "out of memory for the choice of lights");
    vxs_result r = choose(s, names, sun_given ? &sun_shape : NULL, chosen, m);
    if (r != VXS_OK) light_choice_free(chosen);
    return r;
}

void light_choice_free(light_choice *chosen)
{
    free(chosen->lights);
    *chosen = (light_choice){0};
}
