/* The plan of a frame's area lights: which of a scene's parallelograms that shine have virtual lights, how many, what is left
 * out, and why.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef AREA_PLAN_H
#define AREA_PLAN_H

#include <jansson.h>
#include <stdint.h>
#include <stdio.h>

#include "baker/lab/render/lamp_plan.h"
#include "baker/lab/truth/camera.h"
#include "baker/scene/scene.h"

/* What becomes of a parallelogram in a frame. */
typedef enum area_fate {
    AREA_DRAWN,
    AREA_FAINT,  /* left out: black, or brighter ones have all lamps */
    AREA_BEHIND, /* all that is seen is behind it */
    AREA_FATES
} area_fate;

typedef struct area_share {
    area_fate fate;
    uint32_t  lamps; /* 0 unless it is drawn */
} area_share;

typedef struct area_plan {
    uint32_t areas[AREA_FATES], lamps;
} area_plan;

/* What a parallelogram sends out to its side, in all: its area times the mean luminance. */
double area_power(const scene_area *a);

/* 1: no place of a ray from the eye is before it. */
int area_is_behind(const scene_area *a, const double eye_ws[3], const camera_view *seen, double far_metres);

/* Share lamps out by power, those that are not behind first in order of it: each has one at least, until none is left.
 * powers  [count]
 * shares  [count] in: AREA_BEHIND or another; out: what becomes of each */
void area_plan_share(const double *powers, area_share *shares, uint32_t count, uint32_t lamps, area_plan *plan);

/* What it is about, for people and JSON. */
typedef struct area_words {
    const scene      *scene;
    const area_share *shares; /* [scene->area_count] of the last frame */
    lamp_words        lit;
} area_words;

/* A line; with `verbose` a line for each parallelogram, and for what shines and is none. */
void area_plan_print(FILE *to, const area_plan *plan, const area_words *w, int verbose);

/* Of a frame: how many have which fate. Of the picture: all that is said of it. */
json_t *area_plan_counts(const area_plan *plan);
json_t *area_plan_json(const area_plan *plan, const area_words *w);

#endif
