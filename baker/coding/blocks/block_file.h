/* Serialization of sets of palette blocks before they are merged. A loaded set merges like the saved one.
 * The bytes belong to one version of vxs, and are not a public format.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BLOCK_FILE_H
#define BLOCK_FILE_H

#include "baker/base/byte_stream.h"
#include "baker/coding/blocks/blocks.h"

/* Append a set of one map. Returns VXS_OK or VXS_E_MEMORY. */
vxs_result block_set_save(const block_set *s, vxs_bytes *out);

/* The square of a map that must contain a set. */
typedef struct block_area {
    uint32_t map, depth_vx;
    uint32_t x, y, side; /* in squares of NODE_PX */
} block_area;

/* Read a set from all of the bytes. Checks any input: all references are in range, and all squares are in the area.
 * s  [out] zero it first; released with block_set_free, whatever is returned
 * Returns VXS_OK, VXS_E_MEMORY, VXS_E_CORRUPT. */
vxs_result block_set_load(block_set *s, const void *bytes, size_t size_bytes, const block_area *area);

#endif
