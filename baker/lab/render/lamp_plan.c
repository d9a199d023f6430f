/* Virtual lights as text and JSON; see lamp_plan.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/render/lamp_plan.h"

#include "baker/files/json_value.h"

void lamp_plan_print_smoke(FILE *to, const lamp_words *w)
{
    if (w->capsules) fprintf(to, " that %u capsules of smoke dim", w->capsules);
}

void lamp_plan_print(FILE *to, const lamp_words *w)
{
    fprintf(to, "shadows of %u points of the %s, pixels gather %s\n", w->points, w->baked ? "file" : "scene", w->gather);
    if (w->capsules) fprintf(to, "smoke by %u x %u curves for each lamp\n", w->smoke_side, w->smoke_side);
    if (w->baked_smoke) fprintf(to, "baked smoke is left out: the file has it for its own lights alone\n");
}

static json_t *smoke_json(const lamp_words *w)
{
    json_t *o = json_object();
    json_set(&o, "capsules", json_integer(w->capsules));
    json_set(&o, "side_px", json_integer(w->smoke_side));
    return o;
}

void lamp_plan_json(json_t **o, const lamp_words *w)
{
    json_set(o, "gather", json_text(w->gather));
    json_set(o, "points", json_integer(w->points));
    json_set(o, "points_of", json_text(w->baked ? "asset" : "scene"));
    if (w->capsules) json_set(o, "smoke", smoke_json(w));
    json_set(o, "baked_smoke_left_out", json_boolean(w->baked_smoke));
}
