/* Packed blocks in a set, a third of their size: fields that are 0 are left out. Equal blocks have equal bytes. This form is never
 * written to the asset.
 *
 *     head       which tiles have which fields
 *     patterns   of tiles that have one, 4 bytes each
 *     the rest   bases of private palettes, palette entries, all depths except the first (which is 0), the plane
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BLOCK_PACK_H
#define BLOCK_PACK_H

#include "baker/coding/blocks/block.h"

enum { BLOCK_PACKED_MAX = sizeof(block) };

/* Bit n of a mask is tile n. */
typedef struct block_head {
    uint16_t patterned, own, planar; /* tiles with a pattern; those with a private palette; tiles on the plane */
    uint16_t palette;                /* tiles whose field `palette` is not 0 */
    uint8_t  depths, has_plane;
} block_head;

/* Returns the number of bytes, padded with zeros to a multiple of 8. */
size_t block_pack(const block *b, uint8_t bytes[BLOCK_PACKED_MAX]);

void block_unpack(block *b, const uint8_t *bytes);

/* Renumber patterns: private-palette ones become own[was], others shared[was]; own_base[was] is added to the bases of
 * private-palette ones. */
void block_renumber(uint8_t *bytes, const uint32_t *shared, const uint32_t *own, const int32_t *own_base);

/* Read only the patterns of tiles, in the order of the tiles.   patterns  [out] those of head->patterned. Returns their number */
int block_patterns(const uint8_t *bytes, block_head *head, uint32_t patterns[BLOCK_TILES]);

#endif
