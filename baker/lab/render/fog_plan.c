/* The plan of a frame's fog as text and JSON; see fog_plan.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/render/fog_plan.h"

#include <string.h>

#include "baker/base/text.h"
#include "baker/files/json_value.h"

const char *const fog_by_names[] = {"march", "angles", "intervals", "mesh", "grid"};

static const char *const fate_names[FOG_FATES] = {"drawn", "faint", "out_of_view", "clear"};

static void fate_text(char text[64], fog_fate fate)
{
    static const char *const texts[FOG_FATES] = {[FOG_OUT_OF_VIEW] = "out of view", [FOG_CLEAR] = "not in the fog"};
    if (fate == FOG_FAINT)
        snprintf(text, 64, "too faint (together less than 1/%.0f of white)", 1 / FOG_FAINTEST);
    else
        snprintf(text, 64, "%s", texts[fate]);
}

/* savings ---------------------------------------------------------------------------------------------------------------------- */

static void leave_out(fog_saving **next, const char *what, const char *reason)
{
    snprintf((*next)->left_out, sizeof(*next)->left_out, "%s", what);
    snprintf((*next)->reason, sizeof(*next)->reason, "%s", reason);
    ++*next;
}

/* by  the requested method;   light_count  of the file */
static void fog_plan_savings(const fog_plan *plan, fog_by by, uint32_t light_count, fog_saving savings[FOG_SAVINGS])
{
    fog_saving *next = savings;
    char        what[64];
    memset(savings, 0, FOG_SAVINGS * sizeof *savings);
    if (!plan->lights[FOG_DRAWN]) leave_out(&next, "all passes of lights", "no light has airlight to speak of in view");
    if (by == FOG_BY_INTERVALS && !plan->by_angles)
        leave_out(&next, "march, grid and mesh", "the file says where each ray is lit, exactly");
    if (by == FOG_BY_MESH) {
        leave_out(&next, "adaptive pass", "what stands has a mesh that is made once, with triangles where its surface bends");
        snprintf(what, sizeof what, "%u of %u meshes", light_count - plan->meshes_made, light_count);
        if (plan->meshes_made < light_count) leave_out(&next, what, "their lights have not been drawn");
    } else if (!plan->light_maps)
        leave_out(&next, "light maps", "nothing moves: the file is asked where shadow begins");
}

/* text ------------------------------------------------------------------------------------------------------------------------- */

static void print_light(FILE *to, const fog_light_plan *light, const char *light_name)
{
    char name[VXS_LIGHT_NAME_BYTES], why[64];
    one_line(strcpy(name, light_name));
    if (light->fate == FOG_DRAWN) {
        fprintf(to, "light %s: by %s, in %.0f %% of the picture%s%s\n", name, fog_by_names[light->by], 100 * light->share,
                light->why ? ": " : "", light->why ? light->why : "");
        return;
    }
    fate_text(why, light->fate);
    fprintf(to, "light %s is left out: %s\n", name, why);
}

void fog_plan_print(FILE *to, const fog_plan *plan, fog_by by, const fog_light_plan *lights, const vxs_baked_light *const *names,
                    uint32_t light_count, int verbose)
{
    fog_saving savings[FOG_SAVINGS];
    char       why[64];
    fprintf(to, "fog          %u light%s: %u drawn by %s", light_count, light_count == 1 ? "" : "s", plan->lights[FOG_DRAWN],
            fog_by_names[by]);
    for (int n = FOG_FAINT; n < FOG_FATES; n++) {
        fate_text(why, (fog_fate)n);
        if (plan->lights[n]) fprintf(to, ", %u %s", plan->lights[n], why);
    }
    if (plan->by_angles) fprintf(to, "; %u of them by %s", plan->by_angles, fog_by_names[FOG_BY_ANGLES]);
    if (plan->light_maps) fprintf(to, "; %u of maps that end where something moves", plan->light_maps);
    fputc('\n', to);
    if (!verbose) return;
    fog_plan_savings(plan, by, light_count, savings);
    for (const fog_saving *s = savings; s < savings + FOG_SAVINGS && *s->left_out; s++)
        fprintf(to, "%-20s left out: %s\n", s->left_out, s->reason);
    for (uint32_t n = 0; n < light_count; n++) print_light(to, &lights[n], names[n]->light.name);
}

/* JSON ------------------------------------------------------------------------------------------------------------------------- */

json_t *fog_plan_counts(const fog_plan *plan)
{
    json_t *o = json_object();
    for (int n = 0; n < FOG_FATES; n++) json_set(&o, fate_names[n], json_integer(plan->lights[n]));
    return o;
}

json_t *fog_plan_lights(const fog_light_plan *lights, const vxs_baked_light *const *names, uint32_t light_count)
{
    json_t *list = json_array();
    for (uint32_t n = 0; n < light_count; n++) {
        json_t *o = json_object();
        json_set(&o, "light", json_text(names[n]->light.name));
        json_set(&o, "fate", json_text(fate_names[lights[n].fate]));
        if (lights[n].fate == FOG_DRAWN) {
            json_set(&o, "by", json_text(fog_by_names[lights[n].by]));
            if (lights[n].why) json_set(&o, "why", json_text(lights[n].why));
            json_set(&o, "share", json_real(rounded(lights[n].share, 4)));
        }
        json_append(&list, o);
    }
    return list;
}

json_t *fog_plan_left_out(const fog_plan *plan, fog_by by, uint32_t light_count)
{
    fog_saving savings[FOG_SAVINGS];
    json_t    *list = json_array();
    fog_plan_savings(plan, by, light_count, savings);
    for (const fog_saving *s = savings; s < savings + FOG_SAVINGS && *s->left_out; s++) {
        json_t *o = json_object();
        json_set(&o, "what", json_text(s->left_out));
        json_set(&o, "reason", json_text(s->reason));
        json_append(&list, o);
    }
    return list;
}
