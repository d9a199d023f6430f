/* Blocks as a set keeps them, in a third of their size: fields that are 0 take no place. Equal blocks have equal bytes, and these are never in
 * a file.
 *
 *     head       which tiles have which fields
 *     patterns   of tiles that have one, 4 bytes each
 *     the rest   bases of own ones, entries of palettes, depths but the first, which is 0, the plane
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BLOCK_PACK_H
#define BLOCK_PACK_H

#include "baker/coding/blocks/block.h"

enum { BLOCK_PACKED_MAX = sizeof(block) };

/* Bit n of a mask is tile n. */
typedef struct block_head {
    uint16_t patterned, own, planar; /* tiles with a pattern, of them own ones; planes */
    uint16_t palette;                /* that is not 0 */
    uint8_t  depths, has_plane;
} block_head;

/* Returns how many bytes it takes, a multiple of 8: zeros are behind the last field. */
size_t block_pack(const block *b, uint8_t bytes[BLOCK_PACKED_MAX]);

void block_unpack(block *b, const uint8_t *bytes);

/* Give patterns other numbers: those of own patterns are own[was], of the others shared[was]; own_base[was] is added to bases of own ones. */
void block_renumber(uint8_t *bytes, const uint32_t *shared, const uint32_t *own, const int32_t *own_base);

/* The patterns of tiles alone, in the order of the tiles.   patterns  [out] [count] those of head->patterned; returns how many */
int block_patterns(const uint8_t *bytes, block_head *head, uint32_t patterns[BLOCK_TILES]);

#endif
