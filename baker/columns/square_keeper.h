/* What became of fetched squares, kept as bytes: so that a square need not be fetched and built again, or may be by somebody else.
 *
 * The descent asks before it fetches a square, and hands over what was made of it. Bytes are those of one version of vxs and of one
 * coding (square_record.h); a keeper knows nothing of what is in them.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SQUARE_KEEPER_H
#define SQUARE_KEEPER_H

#include "baker/columns/columns.h"
#include "formats/vxs_file.h"

typedef enum square_fate {
    SQUARE_MAKE,  /* it is fetched and built, and what becomes of it is kept */
    SQUARE_KNOWN, /* it was made before */
    SQUARE_LEAVE, /* it is somebody else's, and is left out */
} square_fate;

struct square_keeper {
    void *data;
    int   apart; /* 1: what is made is kept for others to add, and nothing is added here */

    /* What a map has answered before a square is fetched, in the order in which it was asked: what decides which squares are. May be NULL. */
    vxs_result (*note)(void *data, const column_bounds *bounds);

    /* What to do with the square (i, j) of `level` of a map that cannot be settled before it is fetched. Called in z order.
     * record  [out] of SQUARE_KNOWN: what became of it; released by the caller with free(record->data). Where it is not sound, the square is
     *         made after all */
    vxs_result (*ask)(void *data, const column_map *columns, uint32_t level, uint32_t i, uint32_t j, square_fate *fate,
                      vxs_bytes *record, bake_context *ctx);

    /* Keep what was made of the square that was asked about last. */
    vxs_result (*keep)(void *data, const vxs_bytes *record, bake_context *ctx);
};

#endif
