/* Text and JSON on a sky.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SKY_PLAN_H
#define SKY_PLAN_H

#include "baker/lab/render/lamp_plan.h"

typedef struct sky_words {
    const char *path;
    uint32_t    wide_px, high_px;
    double      light, turn_degrees; /* light: factor on radiance; turn_degrees: of the map */
    uint32_t    lamps;
    lamp_words  lit;
} sky_words;

/* Print a line; with `verbose` more lines. */
void sky_plan_print(FILE *to, const sky_words *w, int verbose);

json_t *sky_plan_json(const sky_words *w);

#endif
