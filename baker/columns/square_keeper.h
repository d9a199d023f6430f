/* Square cache: keeps the results of fetched squares as bytes. A square then need not be fetched and built again, or another
 * process can make it.
 *
 * The descent calls `ask` before it fetches a square, and `keep` with the result. The bytes belong to one version of vxs and one
 * coding (square_record.h); the cache does not interpret them.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SQUARE_KEEPER_H
#define SQUARE_KEEPER_H

#include "baker/columns/columns.h"
#include "formats/vxs_file.h"

typedef enum square_fate {
    SQUARE_MAKE,  /* fetch and build it, and keep the result */
    SQUARE_KNOWN, /* its record is there */
    SQUARE_LEAVE, /* another process makes it; leave it out */
} square_fate;

struct square_keeper {
    void *data;
    int   apart; /* 1: results are kept for another process to add; nothing is added here */

    /* Note the bounds that a map gave before a square is fetched, in order: they decide which squares are fetched. May be NULL. */
    vxs_result (*note)(void *data, const column_bounds *bounds);

    /* Decide about the square (i, j) of `level` of a map, which cannot be settled before it is fetched. Called in z order.
     * record  [out] if SQUARE_KNOWN: its record; released by the caller with free(record->data). If the record is not sound, the
     *         descent makes the square anyway */
    vxs_result (*ask)(void *data, const column_map *columns, uint32_t level, uint32_t i, uint32_t j, square_fate *fate,
                      vxs_bytes *record, bake_context *ctx);

    /* Keep the result of the square of the last `ask`. */
    vxs_result (*keep)(void *data, const vxs_bytes *record, bake_context *ctx);
};

#endif
