/* What became of a fetched square: the steps of the descent into it, in z order, and what was built.
 *
 *     steps      how many, of 4 bytes; then each: its level, i and j in the map, 1: built, 0: settled, all of 4 bytes. A settled one: the
 *                bounds that settled it, four of 4 bytes. A built one: bytes of what was built, and of its frame, 8 each
 *     frames     of what was built, zstd, one after the other
 *
 * The steps tile the square: what is read is as whole as what was written, whoever wrote it.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef SQUARE_RECORD_H
#define SQUARE_RECORD_H

#include "baker/columns/columns.h"
#include "formats/vxs_file.h"

typedef struct record_step {
    uint32_t       level, i, j; /* of the map */
    int            is_built;
    column_bounds  bounds;      /* settled */
    uint64_t       built_bytes; /* built */
    const uint8_t *frame;       /* read: where it lies in the bytes */
    size_t         frame_bytes;
} record_step;

/* Zero it. */
typedef struct square_record {
    record_step *steps;
    size_t       count, capacity;
    uint32_t     built_count;
} square_record;

/* Add a step that a square's bounds settled, or that is built. Return VXS_OK or VXS_E_MEMORY. */
vxs_result record_add_settled(square_record *r, uint32_t level, uint32_t i, uint32_t j, const column_bounds *bounds);
vxs_result record_add_built(square_record *r, uint32_t level, uint32_t i, uint32_t j);

/* What was built, as a frame. Its own threads may do it.   frame  [out] zero it first; released with free(frame->data) */
vxs_result record_pack(const vxs_bytes *built, vxs_bytes *frame);

/* And back.   built  [out] zero it first, released the same way. VXS_E_CORRUPT also where a frame is none. */
vxs_result record_unpack(const record_step *s, vxs_bytes *built);

/* The bytes of a record.   frames  [r->built_count] with the sizes of what is in them in built_bytes, in the order of the steps */
vxs_result record_write(const square_record *r, const vxs_bytes *frames, const uint64_t *built_bytes, vxs_bytes *out);

/* Read the record of the square (i, j) of `level`, whose depth is depth_vx.
 * r  [out] zero it first; borrows the bytes; released with record_free, whatever is returned
 * Returns VXS_OK, VXS_E_MEMORY, VXS_E_CORRUPT. */
vxs_result record_read(square_record *r, const void *bytes, size_t size_bytes, uint32_t level, uint32_t i, uint32_t j,
                       uint32_t depth_vx);

/* Accepts a zeroed object. */
void record_free(square_record *r);

#endif
