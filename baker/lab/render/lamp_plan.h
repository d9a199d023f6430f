/* What is said of virtual lights, of what shines in a scene as of a sky, for people and JSON.
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
    uint32_t    capsules, smoke_side; /* of smoke that dims what is drawn, and curves a side of each virtual light */
    int         baked_smoke;          /* the asset has some for its lights, which nothing says of these */
} lamp_words;

/* The end of the line that says how many there are: what dims them, where something does. */
void lamp_plan_print_smoke(FILE *to, const lamp_words *w);

/* Lines of what else is known of them. */
void lamp_plan_print(FILE *to, const lamp_words *w);

/* Members of an object. */
void lamp_plan_json(json_t **o, const lamp_words *w);

#endif
