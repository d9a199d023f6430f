/* The plan of a frame's smoke as text and JSON; see smoke_plan.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/render/smoke_plan.h"

#include <string.h>

#include "baker/base/text.h"
#include "baker/files/json_value.h"

static const char *const fate_names[SMOKE_FATES] = {"dims", "out_of_reach", "out_of_view", "no_room"};
static const char *const fate_texts[SMOKE_FATES] = {"dimmed", "out of its reach", "out of view",
                                                    "without a map, for all are taken"};

static void print_light(FILE *to, const smoke_light_plan *light, uint32_t side_px, const char *light_name)
{
    char name[VXS_LIGHT_NAME_BYTES];
    one_line(strcpy(name, light_name));
    if (light->fate == SMOKE_DIMS)
        fprintf(to, "light %s: smoke by %u x %u curves, of %u segments\n", name, side_px, side_px, light->segments);
    else
        fprintf(to, "light %s: no smoke: %s\n", name, fate_texts[light->fate]);
}

void smoke_plan_print(FILE *to, const smoke_plan *plan, uint32_t capsules, uint32_t side_px, const smoke_light_plan *lights,
                      const vxs_baked_light *const *names, uint32_t light_count, int verbose)
{
    fprintf(to, "smoke        %u capsules; %u light%s", capsules, light_count, light_count == 1 ? ": " : "s: ");
    for (int n = 0, listed = 0; n < SMOKE_FATES; n++)
        if (plan->lights[n]) fprintf(to, "%s%u %s", listed++ ? ", " : "", plan->lights[n], fate_texts[n]);
    fputc('\n', to);
    for (uint32_t n = 0; n < light_count && verbose; n++) print_light(to, &lights[n], side_px, names[n]->light.name);
}

json_t *smoke_plan_counts(const smoke_plan *plan)
{
    json_t *o = json_object();
    for (int n = 0; n < SMOKE_FATES; n++) json_set(&o, fate_names[n], json_integer(plan->lights[n]));
    json_set(&o, "built", json_integer(plan->built));
    return o;
}

json_t *smoke_plan_lights(const smoke_light_plan *lights, const vxs_baked_light *const *names, uint32_t light_count)
{
    json_t *list = json_array();
    for (uint32_t n = 0; n < light_count; n++) {
        json_t *o = json_object();
        json_set(&o, "light", json_text(names[n]->light.name));
        json_set(&o, "fate", json_text(fate_names[lights[n].fate]));
        if (lights[n].fate == SMOKE_DIMS) {
            json_set(&o, "segments", json_integer(lights[n].segments));
            json_set(&o, "merged", json_integer(lights[n].merged));
            json_set(&o, "cut_texels", json_integer(lights[n].cut_texels));
        }
        json_append(&list, o);
    }
    return list;
}
