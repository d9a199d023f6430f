/* Square cache: the results of fetched squares as bytes. A square then need not be fetched and built again, or another process
 * can make it.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SQUARE_RECORD_H
#define SQUARE_RECORD_H

#include "baker/columns/columns.h"
#include "formats/vxs_write_file.h"

/* The descent calls `find` before it fetches a square, and `store` with the result. The bytes belong to one version of vxs and one
 * coding; the cache does not interpret them. */

typedef enum square_action {
    SQUARE_MAKE,  /* fetch and build it, and store the result */
    SQUARE_KNOWN, /* its record is there */
    SQUARE_LEAVE, /* another process makes it; leave it out */
} square_action;

struct square_cache {
    void *data;
    int   store_only; /* 1: results are stored for another process to add; nothing is added here */

    /* Note the bounds that a map gave before a square is fetched, in order: they decide which squares are fetched. May be NULL. */
    vxs_result (*note)(void *data, const column_bounds *bounds);

    /* Decide about the square (i, j) of `level` of a map, which cannot be settled before it is fetched. Called in z order.
     * record  [out] if SQUARE_KNOWN: its record; released by the caller with free(record->data). If the record is not sound, the
     *         descent makes the square anyway */
    vxs_result (*find)(void *data, const column_map *columns, uint32_t level, uint32_t i, uint32_t j, square_action *action,
                       vxs_bytes *record, bake_context *ctx);

    /* Store the result of the square of the last `find`. May be NULL if fetching a square is an error. */
    vxs_result (*store)(void *data, const vxs_bytes *record, bake_context *ctx);
};

/* Result of a fetched square: the steps of the descent into it, in z order, and what was built.
 *
 *     steps      count, 4 bytes; then for each step: level, i and j in the map, and 1: built or 0: settled, 4 bytes each. A
 *                settled step has
 *                the bounds that settled it, four times 4 bytes. A built step has the sizes of what was built and of its frame,
 *                8 bytes each
 *     frames     zstd frames of what was built, one after the other
 *
 * The steps must tile the square: record_read checks this, because a file can come from any writer. */

typedef struct record_step {
    uint32_t       level, i, j; /* of the map */
    int            is_built;
    column_bounds  bounds;      /* settled steps */
    uint64_t       built_bytes; /* built steps */
    const uint8_t *frame;       /* after record_read: position in the bytes */
    size_t         frame_bytes;
} record_step;

/* Zero it. */
typedef struct square_record {
    record_step *steps;
    size_t       count, capacity;
    uint32_t     built_count;
} square_record;

/* Add a settled or a built step. Return VXS_OK or VXS_E_MEMORY. */
vxs_result record_add_settled(square_record *r, uint32_t level, uint32_t i, uint32_t j, const column_bounds *bounds);
vxs_result record_add_built(square_record *r, uint32_t level, uint32_t i, uint32_t j);

/* Compress what was built into a frame. Threads: any.   frame  [out] zero it first; released with free(frame->data) */
vxs_result record_pack(const vxs_bytes *built, vxs_bytes *frame);

/* The reverse.   built  [out] zero it first, released the same way. Returns VXS_E_CORRUPT also for bytes that are no frame. */
vxs_result record_unpack(const record_step *s, vxs_bytes *built);

/* The bytes of a record.   frames  [r->built_count] in the order of the steps; built_bytes has the sizes of their contents */
vxs_result record_write(const square_record *r, const vxs_bytes *frames, const uint64_t *built_bytes, vxs_bytes *out);

/* Read the record of the square (i, j) of `level` of a map with depth depth_vx.
 * r  [out] zero it first; borrows the bytes; released with record_free either way
 * Returns VXS_OK, VXS_E_MEMORY, VXS_E_CORRUPT. */
vxs_result record_read(square_record *r, const void *bytes, size_t size_bytes, uint32_t level, uint32_t i, uint32_t j,
                       uint32_t depth_vx);

/* Accepts a zeroed object. */
void record_free(square_record *r);

#endif
