/* Squares of a bake that are kept, in a folder, as a part of the bake, or for another process: what decides their bytes, from options and
 * scene, as keys; and a light's columns with a keeper.
 *
 * Where a source has keys of its squares, those and the coding decide. Where it has none, all that goes into the bake does
 * (provenance.h), and who renders.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef KEPT_SQUARES_H
#define KEPT_SQUARES_H

#include "baker/bake/bake_report.h"
#include "baker/bake/cache/part_file.h"
#include "baker/bake/cache/square_store.h"
#include "baker/bake/part_common.h"
#include "baker/columns/square_keeper.h"

/* Of a bake. Zero it. */
typedef struct kept_squares {
    int          has_store, has_part; /* neither, and no others: nothing is kept */
    square_store store;
    part_writer  part;
    part_common  common;       /* of the parts */
    uint32_t     lights;       /* that were begun */
    uint64_t     next;         /* number of the square that is asked about next, over all lights and maps */
    column_key   coding, bake; /* what all squares follow from; of squares without keys of their own */

    const square_exchange *others; /* NULL: none */
} kept_squares;

/* Open the folder of --resume, and begin the part of --part.
 * report  with its inputs and renderer
 * Returns what square_store_open and part_begin return; ends with kept_squares_close either way. */
vxs_result kept_squares_open(kept_squares *k, const bake_options *o, const bake_report *report, message *m);

/* The part is complete.   report  of all lights; gets the size of the file */
vxs_result kept_squares_end_part(kept_squares *k, bake_report *report, message *m);

/* Accepts a zeroed object. */
void kept_squares_close(kept_squares *k);

/* The maps of a light while they are baked. */
typedef struct kept_light {
    kept_squares *squares;
    column_source under;
    square_keeper keeper;
    light_report *report;
    uint32_t      light, map;
    uint64_t      number; /* of the square that was asked about last, and its keys: in the folder, and in the part */
    column_key    asked, part_key;
} kept_light;

/* The columns of the next light get a keeper, where something is kept.
 * l       [out] where the source lies from then on, as long as it is used
 * report  of the light: counts go there
 * Returns VXS_OK or VXS_E_MEMORY. */
vxs_result kept_light_source(kept_light *l, kept_squares *k, column_source *source, const vxs_light *light, light_report *report,
                             message *m);

/* The key of a square in a part. */
column_key part_square_key(uint64_t number, uint32_t light, uint32_t map, uint32_t level, uint32_t i, uint32_t j);

#endif
