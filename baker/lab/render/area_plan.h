/* The plan of a frame's area lights: which emissive parallelograms of a scene get virtual lights, how many, and the reasons.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef AREA_PLAN_H
#define AREA_PLAN_H

#include <jansson.h>
#include <stdint.h>
#include <stdio.h>

#include "baker/lab/render/lamp_plan.h"
#include "baker/lab/truth/camera.h"
#include "baker/scene/scene.h"

/* The decision on a parallelogram in a frame. */
typedef enum area_fate {
    AREA_DRAWN,
    AREA_FAINT,  /* left out: black, or brighter ones have all virtual lights */
    AREA_BEHIND, /* left out: all visible space is behind it */
    AREA_FATES
} area_fate;

typedef struct area_share {
    area_fate fate;
    uint32_t  lamps; /* 0 unless it is drawn */
} area_share;

typedef struct area_plan {
    uint32_t areas[AREA_FATES], lamps;
} area_plan;

/* The power that a parallelogram emits on its front: its area times the mean luminance. */
double area_power(const scene_area *a);

/* 1: no point of a ray from the eye is in front of it. */
int area_is_behind(const scene_area *a, const double eye_ws[3], const camera_view *seen, double far_metres);

/* Distribute virtual lights by power to the parallelograms that are not behind the view, in descending order of power. Each gets
 * at least one, until none is left.
 * powers  [count]
 * shares  [count] in: fate AREA_BEHIND or any other; out: the decisions */
void area_plan_share(const double *powers, area_share *shares, uint32_t count, uint32_t lamps, area_plan *plan);

/* Data for the text and JSON of a plan. */
typedef struct area_words {
    const scene      *scene;
    const area_share *shares; /* [scene->area_count] of the last frame */
    lamp_words        lit;
} area_words;

/* Print a line; with `verbose` a line for each parallelogram, and for emissive surfaces that are not parallelograms. */
void area_plan_print(FILE *to, const area_plan *plan, const area_words *w, int verbose);

/* Counts of decisions in a frame; all data of the picture's plan. */
json_t *area_plan_counts(const area_plan *plan);
json_t *area_plan_json(const area_plan *plan, const area_words *w);

#endif
