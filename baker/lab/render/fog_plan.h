/* The plan of a frame's fog: which lights are drawn, by which method, and what is left out, with reasons.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef FOG_PLAN_H
#define FOG_PLAN_H

#include <jansson.h>
#include <stdint.h>
#include <stdio.h>

#include "formats/vxs_file.h"

/* How lit intervals of the fog are found. */
typedef enum fog_by { FOG_BY_MARCH, FOG_BY_ANGLES, FOG_BY_INTERVALS, FOG_BY_MESH, FOG_BY_GRID } fog_by;
#define FOG_BY_CHOICES "march|angles|intervals|mesh|grid" /* their words, in that order */
extern const char *const fog_by_names[];

/* Airlight that is not worth a pass, where 1 is white: half of one of a screen's 255 steps near black, where they are finest:
 * 1 / (2 * 255 * 12.92). It bounds the sum of all airlight that is left out in a pixel: one half for whole lights, one half for
 * pixels of the other lights. */
#define FOG_FAINTEST (1.0 / 6600)

/* The decision on a light in a frame. */
typedef enum fog_fate {
    FOG_DRAWN,
    FOG_FAINT,       /* left out: the sum of all such lights is below half of FOG_FAINTEST, in any direction of view */
    FOG_OUT_OF_VIEW, /* left out: the same, but only in the pixels of this view */
    FOG_CLEAR,       /* left out: the light, or all visible space, is above the fog's top; or the sun is below the horizon */
    FOG_FATES
} fog_fate;

typedef struct fog_plan {
    uint32_t lights[FOG_FATES];
    uint32_t by_angles;   /* lights drawn by equiangular steps instead of the requested method */
    uint32_t light_maps;  /* lights drawn by maps that are joined with moving casters */
    uint32_t meshes_made; /* for FOG_BY_MESH: all meshes made so far, including this frame */
} fog_plan;

/* Of one light. */
typedef struct fog_light_plan {
    fog_fate    fate;
    double      share; /* share of the picture that is drawn for it: a rectangle around its cone, range and airlight above the
                          threshold */
    fog_by      by;    /* the method that is used */
    const char *why;   /* why it is not the requested method; NULL: it is */
} fog_light_plan;

/* A saving of a frame, and its reason; "" ends the list. */
typedef struct fog_saving {
    char left_out[64], reason[160];
} fog_saving;

enum { FOG_SAVINGS = 4 };

/* Print a line; with `verbose` also the savings, and a line for each light. */
void fog_plan_print(FILE *to, const fog_plan *plan, fog_by by, const fog_light_plan *lights, const vxs_baked_light *const *names,
                    uint32_t light_count, int verbose);

/* For a frame: the number of lights with each decision. */
json_t *fog_plan_counts(const fog_plan *plan);

/* For the picture: each light, and the savings. */
json_t *fog_plan_lights(const fog_light_plan *lights, const vxs_baked_light *const *names, uint32_t light_count);
json_t *fog_plan_left_out(const fog_plan *plan, fog_by by, uint32_t light_count);

#endif
