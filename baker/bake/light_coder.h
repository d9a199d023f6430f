/* The seam between columns and words: a coding turns the maps of a light into words. The bake uses codings only through this
 * interface.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef LIGHT_CODER_H
#define LIGHT_CODER_H

#include "baker/columns/columns.h"
#include "formats/vxs_file.h"

/* A light in its coding. */
typedef struct coded_light {
    vxs_write_light written;      /* borrows from `owned` */
    uint64_t        memory_bytes; /* approximate memory that lookups read, enough to rank lights by size before they are encoded */
    void           *owned;
    void (*free)(void *owned);
} coded_light;

/* Accepts a zeroed object. */
static inline void coded_light_free(coded_light *c)
{
    if (c->free) c->free(c->owned);
    *c = (coded_light){0};
}

/* A coding that works on one light: begin, add_map once for each map, finish. All return VXS_OK, VXS_E_MEMORY, VXS_E_REFERENCES. */
typedef struct light_coder {
    void *data; /* of the coding; released by its creator */

    /* light  fitted; borrowed until the coder has finished */
    vxs_result (*begin)(void *data, const vxs_light *light);

    /* columns  of map `map`, open
     * ctx      threads; stages MASKS to MERGE are timed here, and a step of progress is done for each square of fetch_px
     * Returns also what the columns return. */
    vxs_result (*add_map)(void *data, uint32_t map, const column_map *columns, bake_context *ctx);

    /* out  [out] written only if VXS_OK is returned; released with coded_light_free */
    vxs_result (*finish)(void *data, coded_light *out);
} light_coder;

#endif
