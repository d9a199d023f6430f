/* Tables: the depths of lights of palette blocks, laid out for shaders. The words of a block are small; a shader needs some 30
 * fetches to find a tile in them. In the tables it needs 6, and 3 for each bit of the ranks of a tile. vxs_gl makes the tables of
 * whole lights from their words and uploads them behind all words; word 0 of such a light, which no lookup reads, becomes the
 * index of its tables.
 *
 *     top      for each map T x T squares of 256 x 256 texels, by rows, T = max(1, 2^(levels-8))
 *     square   0x80000000 | depth, if all of its texels have this depth; or the index of its node
 *     node     slope, as in the words: it is added to k; least and greatest depth; then 8 x 8 blocks, by rows
 *     block    0x80000000 | depth; or the index of its least and greatest depth, and its 4 x 4 tiles, by rows
 *     tile     two words: its least depth; bits << 28 | index of its record. bits 0: all texels have this depth
 *     record   2^bits - 1 deltas, then `bits` planes
 *
 * Least and greatest depths are those of texels, without the slope; all others include it.
 * A tile with n different depths has bits = ceil(log2(n)), at most 6. Its deltas are the depths without the least one, minus the
 * least one, as a binary search tree: the children of delta m, counted from 1, are 2m and 2m + 1; unused ones are 0x7fffffff. A plane has bit `bits - 1 - p` of
 * the rank of each texel's depth: texel (x, y) is bit x + 8y of two words. So a shader compares 64 ranks with that of k, bit by
 * bit, while it searches for k. Equal records are stored once. Indices count from the first of all words.
 *
 * Not installed.
 * SPDX-License-Identifier: MIT */
#ifndef GL_TABLES_H
#define GL_TABLES_H

#include "vxs_file.h"
#include "vxs_result.h"

typedef struct gl_tables {
    vxs_allocator memory;
    uint32_t     *words; /* [capacity]; count of them are used */
    uint32_t      count, capacity;
    uint32_t      first; /* index of words[0] among all words */
    uint32_t      most;  /* greatest count */
} gl_tables;

/* Append the tables of a light of palette blocks.
 * tables  memory, first and most are set; the rest is zero at first
 * start   [out] index of the tables of the light
 * Returns VXS_OK; VXS_E_MEMORY; VXS_E_ARGUMENT when a page of the light is missing, or the tables would have more than `most`
 * words. */
vxs_result vxs_gl_tables_add(gl_tables *tables, const vxs_baked_light *baked, uint32_t *start);

void vxs_gl_tables_free(gl_tables *tables);

#endif
