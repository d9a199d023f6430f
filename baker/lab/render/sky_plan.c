/* A sky as text and JSON; see sky_plan.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/lab/render/sky_plan.h"

#include "baker/base/text.h"
#include "baker/files/json_value.h"

void sky_plan_print(FILE *to, const sky_words *w, int verbose)
{
    char name[128];
    snprintf(name, sizeof name, "%s", w->path);
    fprintf(to, "sky          %s, %u x %u pixels: drawn by %u lamps", one_line(name), w->wide_px, w->high_px, w->lamps);
    lamp_plan_print_smoke(to, &w->lit);
    fputc('\n', to);
    if (!verbose) return;
    fprintf(to, "radiance times %g, turned by %g degrees\n", w->light, w->turn_degrees);
    lamp_plan_print(to, &w->lit);
}

json_t *sky_plan_json(const sky_words *w)
{
    json_t *o = json_object();
    json_set(&o, "path", json_text(w->path));
    json_set(&o, "width_px", json_integer(w->wide_px));
    json_set(&o, "height_px", json_integer(w->high_px));
    json_set(&o, "light", json_real(w->light));
    json_set(&o, "turn_degrees", json_real(w->turn_degrees));
    json_set(&o, "lamps", json_integer(w->lamps));
    lamp_plan_json(&o, &w->lit);
    return o;
}
