/* Tables: the depths of lights of palette blocks, laid out for shaders. The words of a block are small; a shader needs some 30
 * fetches to find a tile in them. In the tables it needs 5, and 3 for each bit of the ranks of a tile. The tables of whole lights
 * are made when vxs_gl is created; those of a stream, when a page is uploaded (gl_stream_tables.c). They take the
 * place of words: the first word of a light is that of its top.
 *
 *     top      for each map T x T squares of 256 x 256 texels, by rows, T = max(1, 2^(levels-8))
 *     square   0x80000000 | depth, if all of its texels have this depth; the index of its node; or, where its page is missing,
 *              0x40000000 | min | max << 8: the bounds of its entry (vxs_lookup_blocks.h)
 *     node     slope, as in the words: it is added to k; least and greatest depth; the square as if its page were missing; then
 *              8 x 8 blocks, by rows
 *     block    0x80000000 | depth; or the index of its least and greatest depth, and its 4 x 4 tiles, by rows
 *     tile     two words: its least depth; bits << 28 | index of its record. bits 0: all texels have this depth
 *     record   2^bits - 1 deltas, then `bits` planes
 *
 * Least and greatest depths are those of texels, without the slope; all others include it.
 * A tile with n different depths has bits = ceil(log2(n)), at most 6. Its deltas are the depths without the least one, minus the
 * least one, as a binary search tree: the children of delta m, counted from 1, are 2m and 2m + 1; unused ones are 0x7fffffff.
 * Plane p has bit `bits - 1 - p` of the rank of each texel's depth: texel (x, y) is bit x + 8y of two words. So a shader compares
 * 64 ranks with that of k, bit by bit, while it searches for k. Equal records of a light, or of a page, are stored once. Indices
 * count from the first of all words.
 *
 * Not installed.
 * SPDX-License-Identifier: MIT */
#ifndef GL_TABLES_H
#define GL_TABLES_H

#include "vxs_file.h"
#include "vxs_result.h"

/* Where a record is, so that an equal one is not stored again. */
typedef struct gl_record_slot {
    uint32_t at, hash; /* at 0: empty */
} gl_record_slot;

typedef struct gl_tables {
    vxs_allocator   memory;
    uint32_t       *words; /* [capacity]; count of them are used */
    uint32_t        count, capacity;
    uint32_t        first; /* index of words[0] among all words */
    uint32_t        most;  /* greatest count */
    gl_record_slot *slots; /* [slot_count], a power of two: record_count records of the light, or of the page */
    uint32_t        slot_count, record_count;
} gl_tables;

typedef struct gl_square {
    uint32_t number; /* its index in the top of its light */
    uint32_t word;   /* [out] what the top has there */
} gl_square;

/* Append the tables of a light of palette blocks.
 * tables  memory, first and most are set; the rest is zero at first
 * start   [out] index of the top of the light
 * Returns VXS_OK; VXS_E_MEMORY; VXS_E_ARGUMENT when a page of the light is missing, or the tables would have more than `most`
 * words. */
vxs_result vxs_gl_tables_add(gl_tables *tables, const vxs_baked_light *baked, uint32_t *start);

/* Append the tables of a square of a light, without its word in the top. Returns as vxs_gl_tables_add.
 * square  [in, out] */
vxs_result vxs_gl_tables_add_square(gl_tables *tables, const vxs_baked_light *baked, gl_square *square);

/* Begin tables elsewhere: those so far are no longer there. */
void vxs_gl_tables_begin(gl_tables *tables, uint32_t first, uint32_t most);

uint32_t vxs_gl_tables_square_count(const vxs_light *light);

/* Returns the word in the top of a square while its page is missing.
 * page  [out] of the light; UINT32_MAX: the square has one depth */
uint32_t vxs_gl_tables_missing(const vxs_baked_light *baked, uint32_t square, uint32_t *page);

void vxs_gl_tables_free(gl_tables *tables);

#endif
