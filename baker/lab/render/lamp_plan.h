/* Text and JSON on virtual lights, of area lights or of a sky.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef LAMP_PLAN_H
#define LAMP_PLAN_H

#include <jansson.h>
#include <stdint.h>
#include <stdio.h>

typedef struct lamp_words {
    const char *gather;               /* its word */
    uint32_t    points;               /* that cast shadows */
    int         baked;                /* they are those of the asset */
    uint32_t    capsules, smoke_side; /* capsules of smoke that dims the light, and the side of each virtual light's smoke map */
    int         baked_smoke;          /* 1: the asset has baked smoke for its own lights, which does not dim virtual lights */
} lamp_words;

/* The end of the line with their number: the smoke that dims them, if any. */
void lamp_plan_print_smoke(FILE *to, const lamp_words *w);

/* Further lines on them. */
void lamp_plan_print(FILE *to, const lamp_words *w);

/* Members of an object. */
void lamp_plan_json(json_t **o, const lamp_words *w);

#endif
