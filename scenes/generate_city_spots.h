/* Spot lights of the city, a block at a time.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef GENERATE_CITY_SPOTS_H
#define GENERATE_CITY_SPOTS_H

#include "baker/base/random.h"
#include "scenes/generate_parts.h"

/* A position for a spot above the street, under a street lamp's arm. along, out: unit, horizontal: along the street, and towards
 * its middle. */
typedef struct city_lamp {
    double head[3], along[3], out[3];
} city_lamp;

typedef struct city_block {
    const city_lamp *lamps;
    uint32_t         lamp_count;
    size_t           box_first, box_count; /* the block's boxes, eight vertices of the scene each: corner c is at the high end of
                                              axis a if bit a of c is set */
    double           x, z;                 /* its centre, metres */
    double           half, street;         /* half its side, and the width of the streets around it, metres */
} city_block;

/* Add `count` spots, named spot%04u from *made + 1: first one under each lamp, the rest alternately on walls and over the
 * streets. None is inside one of the block's boxes, or closer to it than 10 cm. Each points down, and slightly along the street
 * or away from the wall. Cones of 20 to 60 degrees, from the axis to the edge; 15 to 40 m of range. */
void add_city_spots(parts *p, const city_block *k, rng r, uint32_t count, uint32_t *made);

#endif
