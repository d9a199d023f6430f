/* Squares of a bake that are kept: what decides their bytes, from options and scene, as keys; and a light's columns with a keeper.
 *
 * Where a source has keys of its squares, those and the coding decide. Where it has none, all that goes into the bake does
 * (provenance.h), and who renders.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef KEPT_SQUARES_H
#define KEPT_SQUARES_H

#include "baker/bake/bake_report.h"
#include "baker/columns/square_keeper.h"
#include "baker/kept/square_store.h"

/* Of a bake. Zero it. */
typedef struct kept_squares {
    square_store store;
    int          is_open;      /* 0: nothing is kept */
    column_key   coding, bake; /* what all squares follow from; of squares without keys of their own */
} kept_squares;

/* Open the folder of --resume, if there is one.
 * report  with its inputs and renderer
 * Returns what square_store_open returns; ends with kept_squares_close either way. */
vxs_result kept_squares_open(kept_squares *k, const bake_options *o, const bake_report *report, message *m);
void       kept_squares_close(kept_squares *k);

/* The maps of a light while they are baked. */
typedef struct kept_light {
    kept_squares *squares;
    column_source under;
    square_keeper keeper;
    light_report *report;
    uint32_t      light, map;
    column_key    asked; /* of the square that was asked about last */
} kept_light;

/* The columns of light number `light` with a keeper; as they were where nothing is kept. Counts go to the report.
 * l  valid where it lies, as long as the source is used */
column_source kept_light_source(kept_light *l, kept_squares *k, column_source under, uint32_t light, light_report *report);

#endif
