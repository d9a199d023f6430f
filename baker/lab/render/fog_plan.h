/* The plan of a frame's fog: which of its lights are drawn, and by what, what is left out, and why.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef FOG_PLAN_H
#define FOG_PLAN_H

#include <jansson.h>
#include <stdint.h>
#include <stdio.h>

#include "formats/vxs_file.h"

/* What tells where fog is lit. */
typedef enum fog_by { FOG_BY_MARCH, FOG_BY_ANGLES, FOG_BY_INTERVALS, FOG_BY_MESH, FOG_BY_GRID } fog_by;
#define FOG_BY_CHOICES "march|angles|intervals|mesh|grid" /* their words, in that order */
extern const char *const fog_by_names[];

/* Airlight that is not worth a pass, where 1 is white: half of one of a screen's 255 steps in black, where they are finest: 1 /
 * (2 * 255 * 12.92). It bounds the sum of all that is left out in a pixel: half of it lights as a whole, half pixels of others. */
#define FOG_FAINTEST (1.0 / 6600)

/* What becomes of a light in a frame. */
typedef enum fog_fate {
    FOG_DRAWN,
    FOG_FAINT,       /* left out: with all others that are, less than half of FOG_FAINTEST, wherever one looks */
    FOG_OUT_OF_VIEW, /* likewise in each pixel of the view */
    FOG_CLEAR,       /* the light, or all that is seen, is above the fog's top; or the sun is below the horizon */
    FOG_FATES
} fog_fate;

typedef struct fog_plan {
    uint32_t lights[FOG_FATES];
    uint32_t by_angles;   /* of lights that are drawn, those that are so though something else was asked */
    uint32_t light_maps;  /* of them all, which end where something moves */
    uint32_t meshes_made; /* up to and with this frame, of lights that are drawn; of FOG_BY_MESH */
} fog_plan;

/* Of one light. */
typedef struct fog_light_plan {
    fog_fate    fate;
    double      share; /* of the picture that it is drawn in: a rectangle about its cone, range and what is not too faint */
    fog_by      by;    /* what draws it */
    const char *why;   /* not what was asked; NULL: it is that */
} fog_light_plan;

/* What a frame goes without, and why; "" behind the last one. */
typedef struct fog_saving {
    char left_out[64], reason[160];
} fog_saving;

enum { FOG_SAVINGS = 4 };

/* by  what is asked;   light_count  of the file */
void fog_plan_savings(const fog_plan *plan, fog_by by, uint32_t light_count, fog_saving savings[FOG_SAVINGS]);

/* A line; with `verbose` what is left out, and a line for each light. */
void fog_plan_print(FILE *to, const fog_plan *plan, fog_by by, const fog_light_plan *lights, const vxs_baked_light *const *names,
                    uint32_t light_count, int verbose);

/* Of a frame: how many lights have which fate. */
json_t *fog_plan_counts(const fog_plan *plan);

/* Of the picture: each light, and what is left out. */
json_t *fog_plan_lights(const fog_light_plan *lights, const vxs_baked_light *const *names, uint32_t light_count);
json_t *fog_plan_left_out(const fog_plan *plan, fog_by by, uint32_t light_count);

#endif
