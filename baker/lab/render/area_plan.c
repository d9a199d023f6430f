/* The plan of a frame's area lights, and its words; see area_plan.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/render/area_plan.h"

#include <math.h>
#include <string.h>

#include "baker/base/text.h"
#include "baker/base/vec3.h"
#include "baker/files/json_value.h"

static double luminance_of(const scene_area *a, const float *texel)
{
    return 0.2126 * (double)(a->radiance[0] * texel[0]) + 0.7152 * (double)(a->radiance[1] * texel[1]) +
           0.0722 * (double)(a->radiance[2] * texel[2]);
}

double area_power(const scene_area *a)
{
    static const float white[3] = {1, 1, 1};
    size_t             texels   = (size_t)a->wide_px * a->high_px;
    double             normal[3], sum = texels ? 0 : luminance_of(a, white);
    for (size_t n = 0; n < texels; n++) sum += luminance_of(a, a->texture + 3 * n);
    vec3_cross(a->across_ws, a->up_ws, normal);
    return sqrt(vec3_dot(normal, normal)) * sum / (double)(texels ? texels : 1);
}

int area_is_behind(const scene_area *a, const double eye_ws[3], const camera_view *seen, double far_metres)
{
    double normal[3], way[3];
    vec3_cross(a->across_ws, a->up_ws, normal);
    vec3_sub(eye_ws, a->corner_ws, way);
    double eye = vec3_dot(way, normal), across = fabs(vec3_dot(seen->right, normal)), up = fabs(vec3_dot(seen->up, normal));
    return eye <= 0 && eye + far_metres * (vec3_dot(seen->forward, normal) + across + up) <= 0;
}

/* The brightest parallelogram without a share; `count` if there is none. */
static uint32_t brightest(const double *powers, const area_share *shares, uint32_t count)
{
    uint32_t best = count;
    for (uint32_t n = 0; n < count; n++)
        if (shares[n].fate == AREA_FAINT && powers[n] > 0 && (best == count || powers[n] > powers[best])) best = n;
    return best;
}

void area_plan_share(const double *powers, area_share *shares, uint32_t count, uint32_t lamps, area_plan *plan)
{
    double   all  = 0;
    uint32_t rest = 0;
    *plan         = (area_plan){0};
    for (uint32_t n = 0; n < count; n++) {
        shares[n] = (area_share){shares[n].fate == AREA_BEHIND ? AREA_BEHIND : AREA_FAINT, 0};
        if (shares[n].fate == AREA_FAINT) all += powers[n];
        rest += shares[n].fate == AREA_FAINT && powers[n] > 0;
    }
    for (uint32_t n; plan->lamps < lamps && (n = brightest(powers, shares, count)) < count;) {
        uint32_t left = lamps - plan->lamps, most = left > rest-- ? left - rest : 1;
        double   part = all > powers[n] ? round(left * (powers[n] / all)) : left;
        shares[n]     = (area_share){AREA_DRAWN, (uint32_t)fmin(fmax(part, 1), most)};
        plan->lamps += shares[n].lamps;
        all -= powers[n];
    }
    for (uint32_t n = 0; n < count; n++) plan->areas[shares[n].fate]++;
}

/* text ------------------------------------------------------------------------------------------------------------------------- */

static const char *const fate_names[AREA_FATES] = {"drawn", "faint", "behind"};
static const char *const fate_texts[AREA_FATES] = {
    [AREA_FAINT] = "too faint (brighter ones have all lamps)", [AREA_BEHIND] = "behind all that is seen"};

static const char *name_of(const scene *s, const scene_area *a)
{
    return s->names + s->parts[a->part].node_name;
}

void area_plan_print(FILE *to, const area_plan *plan, const area_words *w, int verbose)
{
    size_t count = w->scene->area_count;
    fprintf(to, "area         %zu parallelogram%s of light", count, count == 1 ? "" : "s");
    if (count)
        fprintf(to, ": %u drawn by %u lamps", plan->areas[AREA_DRAWN], plan->lamps);
    else
        fputs(": nothing in the scene shines; --sky FILE lights it by a map of the sky", to);
    lamp_plan_print_smoke(to, &w->lit);
    for (int n = AREA_FAINT; n < AREA_FATES; n++)
        if (plan->areas[n]) fprintf(to, ", %u %s", plan->areas[n], fate_texts[n]);
    fputc('\n', to);
    if (!verbose) return;
    if (count) lamp_plan_print(to, &w->lit);
    for (size_t n = 0; n < count; n++) {
        char name[128];
        snprintf(name, sizeof name, "%s", name_of(w->scene, &w->scene->areas[n]));
        one_line(name);
        if (w->shares[n].fate == AREA_DRAWN)
            fprintf(to, "area light %s: %u lamps\n", name, w->shares[n].lamps);
        else
            fprintf(to, "area light %s is left out: %s\n", name, fate_texts[w->shares[n].fate]);
    }
    if (w->scene->dim_count) fprintf(to, "%zu triangles that shine are left out: no parallelogram of two\n", w->scene->dim_count);
}

json_t *area_plan_counts(const area_plan *plan)
{
    json_t *o = json_object();
    for (int n = 0; n < AREA_FATES; n++) json_set(&o, fate_names[n], json_integer(plan->areas[n]));
    return o;
}

json_t *area_plan_json(const area_plan *plan, const area_words *w)
{
    json_t *o = json_object(), *lights = json_array();
    for (size_t n = 0; n < w->scene->area_count; n++) {
        json_t *light = json_object();
        json_set(&light, "node", json_text(name_of(w->scene, &w->scene->areas[n])));
        json_set(&light, "fate", json_text(fate_names[w->shares[n].fate]));
        json_set(&light, "lamps", json_integer(w->shares[n].lamps));
        json_append(&lights, light);
    }
    json_set(&o, "lamps", json_integer(plan->lamps));
    lamp_plan_json(&o, &w->lit);
    json_set(&o, "lights", lights);
    json_set(&o, "dim_triangles", json_integer((json_int_t)w->scene->dim_count));
    return o;
}
