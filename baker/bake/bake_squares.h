/* Squares of a bake in the square cache, in a part of the bake, or for another process: computes the keys of squares from options
 * and scene, and gives a light's columns the cache.
 *
 * If a column source has keys, the key of a square combines that key with the coding. Otherwise it combines all input of the bake
 * (provenance.h) with the renderer.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BAKE_SQUARES_H
#define BAKE_SQUARES_H

#include "baker/bake/bake_options.h"
#include "baker/bake/bake_report.h"
#include "baker/bake/cache/cache_folder.h"
#include "baker/bake/cache/part_file.h"
#include "baker/columns/columns.h"
#include "baker/columns/square_record.h"
#include "formats/vxs_write_file.h"

/* Data common to all parts of a bake: lights, options, metadata of the file, and the bounds that maps gave before fetches. Parts
 * can be merged with it without the scene. Parts with equal bytes belong to one bake. */

/* A map, as it is known before a square is fetched. */
typedef struct part_map {
    uint32_t       fetch_px;
    column_bounds *answers; /* [count] bounds in the order of the calls */
    size_t         count, capacity;
} part_map;

typedef struct part_light {
    vxs_light light;
    part_map  maps[VXS_CUBE_FACES];
} part_light;

/* Zero it. */
typedef struct part_common {
    bake_options o;        /* only coding, pack, rule, reuse and zstd_level */
    char        *made_by;  /* versions and renderer; owned */
    char        *metadata; /* of the file; owned */
    part_light  *lights;   /* [light_count] */
    size_t       light_count, light_capacity;
} part_common;

/* Read it from all of the bytes.
 * c  [out] zero it first; released with part_common_free, whatever is returned
 * Returns VXS_OK, VXS_E_MEMORY, VXS_E_CORRUPT. */
vxs_result part_common_read(part_common *c, const void *bytes, size_t size_bytes);

/* Accepts a zeroed object. */
void part_common_free(part_common *c);

/* Of a bake. Zero it. */
typedef struct bake_squares {
    int          has_store, has_part; /* both 0 and no `others`: nothing is stored */
    cache_folder store;
    part_writer  part;
    part_common  common;       /* of all parts */
    uint32_t     lights;       /* number of lights begun */
    uint64_t     next;         /* number of the next square, over all lights and maps */
    column_key   coding, bake; /* hashed into the keys of all squares; into those without a key of the source */

    const square_exchange *others; /* NULL: none */
} bake_squares;

/* Open the folder of --resume, and begin the part of --part.
 * report  inputs and renderer must be set
 * Returns what cache_folder_open and part_begin return; ends with bake_squares_close either way. */
vxs_result bake_squares_open(bake_squares *k, const bake_options *o, const bake_report *report, run_context *m);

/* Complete the part.   report  of all lights; its file_bytes is set */
vxs_result bake_squares_end_part(bake_squares *k, bake_report *report, run_context *m);

/* Accepts a zeroed object. */
void bake_squares_close(bake_squares *k);

/* The maps of a light during the bake. */
typedef struct light_squares {
    bake_squares *squares;
    column_source under;
    square_cache  cache;
    light_report *report;
    uint32_t      light, map;
    uint64_t      number; /* of the last square of `find`, with its keys in the cache and in the part */
    column_key    asked, part_key;
} light_squares;

/* Wrap the columns of the next light with the cache, if squares are stored.
 * l       [out] must not move while the source is used
 * report  of the light; its counts are added to
 * Returns VXS_OK or VXS_E_MEMORY. */
vxs_result light_squares_source(light_squares *l, bake_squares *k, column_source *source, const vxs_light *light,
                                light_report *report, run_context *m);

/* The key of a square in a part. */
column_key part_square_key(uint64_t number, uint32_t light, uint32_t map, uint32_t level, uint32_t i, uint32_t j);

#endif
