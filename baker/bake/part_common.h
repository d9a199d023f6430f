/* Data common to all parts of a bake: lights, options, metadata of the file, and the bounds that maps gave before fetches. Parts
 * can be merged with it without the scene. Parts with equal bytes belong to one bake.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef PART_COMMON_H
#define PART_COMMON_H

#include "baker/bake/bake_options.h"
#include "baker/columns/columns.h"
#include "formats/vxs_file.h"

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

/* Append it to out. Returns VXS_OK or VXS_E_MEMORY. */
vxs_result part_common_write(const part_common *c, vxs_bytes *out);

/* Read it from all of the bytes.
 * c  [out] zero it first; released with part_common_free, whatever is returned
 * Returns VXS_OK, VXS_E_MEMORY, VXS_E_CORRUPT. */
vxs_result part_common_read(part_common *c, const void *bytes, size_t size_bytes);

/* Accepts a zeroed object. */
void part_common_free(part_common *c);

#endif
