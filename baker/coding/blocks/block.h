/* A palette block of 32 x 32 texels and its tiles of 8 x 8, during the build.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef BLOCK_H
#define BLOCK_H

#include "baker/coding/blocks/patterns.h"
#include "baker/coding/blocks/plane.h"

enum { BLOCK_TILES = 16 };

typedef enum tile_kind { TILE_UNIFORM, TILE_PATTERN, TILE_OWN, TILE_PLANE } tile_kind;

/* Unused fields are 0, so that equal tiles have equal fields. */
typedef struct block_tile {
    uint16_t kind;
    uint16_t palette; /* uniform: the entry; pattern: bit n: entry n is used */
    uint32_t pattern; /* id of a pattern, or of a private-palette pattern */
    int32_t  base;    /* private palette: base of its depths, relative to the block's */
} block_tile;

static inline int tile_has_pattern(const block_tile *t)
{
    return t->kind == TILE_PATTERN || t->kind == TILE_OWN;
}

typedef struct block {
    uint32_t   depths;             /* [1, PALETTE_MAX] entries of the palette */
    int32_t    depth[PALETTE_MAX]; /* [depths] ascending from 0 */
    plane      plane;              /* for the tiles on it, relative to the block's base, without the node's slope */
    block_tile tile[BLOCK_TILES];  /* rows */
} block;

#endif
